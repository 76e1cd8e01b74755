//! Throughput of the tracer with every kernel, on the pictures of whole scenes: mode auto, one thread. All kernels get
//! the same trees and rays.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Instant;

use super::built_scene::BuiltScene;
use super::on_scenes::{ForKernels, for_each_kernel};
use super::ray_sets::{EDGES, RaySet};
use super::rounds::{TimedJob, Times, of_job};
use super::stats::typical;
use crate::geom::{Hit, Triangle};
use crate::kernels::Kernel;
use crate::study::record::{OnSceneRow, Samples, SceneSpeedRow};
use crate::tracer::{Error, Mode, Scene, SceneSource, checksum, thread_pool, trace_set_into};

/// Scenes that are ready to be timed.
pub(crate) struct SceneSpeed(Vec<Timed>);

/// A scene, prepared for every kernel.
struct Timed {
    built: BuiltScene,
    kernels: Vec<(String, Trace)>,
}

/// Traces a set of rays.
type Trace = Box<dyn Fn(&RaySet, &mut [Hit<f32>]) + Sync>;

impl ForKernels for Vec<(String, Trace)> {
    fn scene<K: Kernel<Shape = Triangle>>(&mut self, id: &str, scene: Scene<K>) {
        let trace = move |set: &RaySet, hits: &mut [Hit<f32>]| {
            trace_set_into(&scene, &set.rays, set.any_hit, Mode::Auto, hits);
        };
        self.push((id.into(), Box::new(trace)));
    }
}

/// What distinguishes a timed set of rays.
fn name(scene: &str, rays: &str, kernel: &str) -> String {
    format!("{scene}, {rays} rays, {kernel}")
}

impl SceneSpeed {
    /// Builds the scenes, with pictures of `size` × `size` pixels, and prepares them for every kernel.
    ///
    /// # Errors
    /// If a scene cannot be loaded.
    pub(crate) fn new(scenes: &[SceneSource], (size, seed): (u32, u64)) -> Result<Self, Error> {
        let timed = |source: &SceneSource| {
            let built = BuiltScene::new(source, (size, seed))?;
            let mut kernels = Vec::new();
            for_each_kernel(&built.scene, &mut kernels);
            Ok(Timed { built, kernels })
        };
        Ok(Self(scenes.iter().map(timed).collect::<Result<_, Error>>()?))
    }

    /// Every kernel on every set of rays. A sample is the nanoseconds per ray, and the checksum of the hits.
    ///
    /// # Errors
    /// If the system does not grant the thread.
    pub(crate) fn timed_jobs(&self) -> Result<Vec<TimedJob<'_>>, Error> {
        let most = self.0.iter().flat_map(|timed| &timed.built.sets).map(|set| set.rays.len()).max().unwrap_or(0);
        // A value that no ray can give. It overwrites the hits of earlier runs, so that they cannot pass for hits of a
        // later one.
        let unset = Hit::<f32>::new(true, f32::NEG_INFINITY, 0.0, 0.0);
        let buffer = Rc::new(RefCell::new(vec![unset; most]));
        let pool = Rc::new(thread_pool(1)?);
        let mut jobs = Vec::new();
        for Timed { built, kernels } in &self.0 {
            for set in built.sets.iter().filter(|set| !set.rays.is_empty()) {
                for (kernel, trace) in kernels {
                    let (buffer, pool) = (buffer.clone(), pool.clone());
                    let sample = move || {
                        let mut buffer = buffer.borrow_mut();
                        let hits = &mut buffer[..set.rays.len()];
                        hits.fill(unset);
                        let start = Instant::now();
                        pool.install(|| trace(set, hits));
                        let seconds = start.elapsed().as_secs_f64();
                        Ok((seconds * 1e9 / set.rays.len() as f64, checksum(hits)))
                    };
                    jobs.push(TimedJob { name: name(&built.name, set.name, kernel), sample: Box::new(sample) });
                }
            }
        }
        Ok(jobs)
    }
}

/// The rows of all sets of rays that were judged, except those at edges, from their times.
///
/// # Errors
/// If one was not timed.
pub(crate) fn rows(judged: &[OnSceneRow], all: &[Times]) -> Result<Vec<SceneSpeedRow>, Error> {
    rows_of(judged.iter(), all)
}

/// The rows of another build, without the kernels that it lacks.
///
/// # Errors
/// If a time has no samples.
pub(crate) fn rows_of_other_build(judged: &[OnSceneRow], all: &[Times]) -> Result<Vec<SceneSpeedRow>, Error> {
    let is_there = |row: &&OnSceneRow| {
        let name = name(&row.scene, &row.rays, &row.kernel);
        all.iter().any(|times| times.name == name)
    };
    rows_of(judged.iter().filter(is_there), all)
}

fn rows_of<'a>(judged: impl Iterator<Item = &'a OnSceneRow>, all: &[Times]) -> Result<Vec<SceneSpeedRow>, Error> {
    let row = |OnSceneRow { scene, rays, kernel, .. }: &OnSceneRow| {
        let times = of_job(all, &name(scene, rays, kernel))?;
        let row = row_of([scene, rays, kernel], times.ns.clone(), times.checksum);
        row.ok_or_else(|| Error::Disagreement(format!("{}: it has no samples", times.name)))
    };
    judged.filter(|row| row.rays != EDGES).map(row).collect()
}

/// The row of one kernel on one set of rays; `None` without samples.
pub(crate) fn row_of([scene, rays, kernel]: [&str; 3], samples: Samples, checksum: u64) -> Option<SceneSpeedRow> {
    let ns = typical(&samples)?;
    Some(SceneSpeedRow {
        scene: scene.into(),
        rays: rays.into(),
        kernel: kernel.into(),
        ns_per_ray: ns.value,
        ns_per_ray_low: ns.low,
        ns_per_ray_high: ns.high,
        mrays_per_second: 1e3 / ns.value,
        ns_of_rounds: samples,
        checksum: format!("{checksum:016x}"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_judged_set_but_that_at_edges_gets_its_times() {
        let judged = |rays: &str| OnSceneRow {
            scene: "room".into(),
            rays: rays.into(),
            kernel: "triangle/woop".into(),
            ray_count: 100,
            solid: 100,
            open: 0,
            lost: 0,
            false_hits: 0,
            neighbours: 0,
            displaced: 0,
            displacement_p99: 0.0,
            checksum: String::new(),
        };
        let ns = Samples::new(&[vec![40.0, 45.0, 50.0, 55.0, 60.0]]);
        let times = [Times { name: name("room", "primary", "triangle/woop"), checksum: 0xabc, ns }];
        let rows = rows(&[judged("primary"), judged(EDGES)], &times).unwrap();
        let [row] = &rows[..] else { panic!("{rows:?}") };
        assert_eq!((row.ns_per_ray, row.mrays_per_second, row.checksum.as_str()), (50.0, 20.0, "0000000000000abc"));
        assert!(row.ns_per_ray_low < 50.0 && row.ns_per_ray_high > 50.0, "{row:?}");
        let missing = super::rows(&[judged("bounce")], &times).unwrap_err();
        assert!(missing.to_string().contains("room, bounce rays, triangle/woop: no process has timed it"), "{missing}");
    }
}
