//! Throughput of the tracer on the rays of pictures.

use std::time::Instant;

use super::Progress;
use super::ray_sets::{RaySet, ray_sets};
use super::record::TracerRow;
use super::stats::{mad, median};
use crate::geom::{Hit, Triangle};
use crate::kernels::Kernel;
use crate::kernels::triangle::MollerTrumbore;
use crate::tracer::{Error, LoadedScene, Mode, Scene, SceneSource, checksum, thread_pool, trace};

/// Times one scene, with every mode and number of threads, interleaved.
///
/// # Errors
/// If the scene cannot be loaded, or if two modes or thread counts disagree about a hit.
pub(crate) fn measure(
    source: &SceneSource,
    (size, seed): (u32, u64),
    samples: usize,
    thread_counts: &[usize],
    progress: &Progress,
) -> Result<Vec<TracerRow>, Error> {
    progress.note(&format!("{}: building", source.name()));
    let LoadedScene { world, view, .. } = source.load()?;
    let start = Instant::now();
    let scene = Scene::<MollerTrumbore<f32>>::new(world);
    let build_seconds = start.elapsed().as_secs_f64();
    let mut rows = Vec::new();
    for set in ray_sets(&scene, &view, size, seed) {
        progress.note(&format!("{}: {} rays", source.name(), set.name));
        rows.extend(time(&scene, &set, samples, thread_counts)?.into_iter().map(|job| TracerRow {
            scene: source.name(),
            triangles: scene.primitives(),
            instances: scene.world().instances().len(),
            rays: set.name.into(),
            ray_count: set.rays.len(),
            hits: job.hits.iter().filter(|hit| hit.mask).count(),
            mode: job.mode.name().into(),
            kernel: <MollerTrumbore<f32> as Kernel>::INFO.id.to_string(),
            threads: job.pool.current_num_threads(),
            mrays_per_second: median(&job.mrays),
            mrays_per_second_mad: mad(&job.mrays),
            build_seconds,
            bytes_per_triangle: scene.bytes() as f64 / scene.primitives() as f64,
            checksum: format!("{:016x}", checksum(&job.hits)),
        }));
    }
    Ok(rows)
}

/// A mode on a number of threads, with its rates and the hits of its last run.
struct Job {
    mode: Mode,
    pool: rayon::ThreadPool,
    mrays: Vec<f64>,
    hits: Vec<Hit<f32>>,
}

fn time<K: Kernel<Shape = Triangle>>(
    scene: &Scene<K>,
    set: &RaySet,
    samples: usize,
    thread_counts: &[usize],
) -> Result<Vec<Job>, Error> {
    let mut jobs = Vec::new();
    for mode in Mode::ALL {
        for &threads in thread_counts {
            let pool = thread_pool(threads)?;
            let hits = pool.install(|| trace(scene, &set.rays, set.any_hit, mode));
            jobs.push(Job { mode, pool, mrays: Vec::new(), hits });
        }
    }
    for _ in 0..samples {
        for job in &mut jobs {
            let start = Instant::now();
            job.hits = job.pool.install(|| trace(scene, &set.rays, set.any_hit, job.mode));
            job.mrays.push(set.rays.len() as f64 / start.elapsed().as_secs_f64() / 1e6);
        }
        if let Some(odd) = jobs.iter().find(|job| checksum(&job.hits) != checksum(&jobs[0].hits)) {
            return Err(Error::Disagreement(format!("{} rays, mode {}", set.name, odd.mode.name())));
        }
    }
    Ok(jobs)
}
