//! Timing of the tracer. What is compared is interleaved: the first sample of every job, then the second of every job, so
//! that a slow spell of the machine falls on all alike. Jobs with the same rays must end with the same hits.

use std::time::Instant;

use rayon::ThreadPool;

use super::ray_sets::RaySet;
use super::stats::{mad, median};
use crate::geom::{Hit, Triangle};
use crate::kernels::Kernel;
use crate::tracer::{Error, Mode, Scene, checksum, trace_into};

/// A set of rays, and how it is traced.
#[derive(Debug)]
pub(super) struct Job<'a, K> {
    pub(super) scene: &'a Scene<K>,
    pub(super) set: &'a RaySet,
    pub(super) mode: Mode,
    pub(super) pool: &'a ThreadPool,
}

/// How long a job took, and what it found.
#[derive(Clone, Debug)]
pub(super) struct Timing {
    /// Number of rays.
    pub(super) rays: usize,
    /// Rays that hit.
    pub(super) hits: usize,
    /// Over the bits of all hits, of every run.
    pub(super) checksum: u64,
    /// Wall time of each sample.
    seconds: Vec<f64>,
}

impl Timing {
    /// Median of the samples in million rays per second, and their median absolute deviation.
    pub(super) fn mrays_per_second(&self) -> [f64; 2] {
        self.of_samples(|seconds| self.rays as f64 / seconds / 1e6)
    }

    /// The same in wall nanoseconds per ray.
    pub(super) fn ns_per_ray(&self) -> [f64; 2] {
        self.of_samples(|seconds| seconds * 1e9 / self.rays as f64)
    }

    fn of_samples(&self, figure: impl Fn(f64) -> f64) -> [f64; 2] {
        let samples: Vec<f64> = self.seconds.iter().map(|&seconds| figure(seconds)).collect();
        [median(&samples), mad(&samples)]
    }
}

/// Times the jobs, in their order, into room that is there already. Each runs once before, to warm up.
///
/// # Errors
/// If a job gives other hits than the first one with the same rays, even in a single run: a timing of wrong results is worth
/// nothing.
pub(super) fn time<K: Kernel<Shape = Triangle>>(jobs: &[Job<K>], samples: usize) -> Result<Vec<Timing>, Error> {
    let most = jobs.iter().map(|job| job.set.rays.len()).max().unwrap_or(0);
    // What no ray can end with, so that nothing that an earlier run has left passes for a hit of a later one.
    let unset = Hit::<f32>::new(true, f32::NEG_INFINITY, 0.0, 0.0);
    let mut room = vec![unset; most];
    let mut run = |job: &Job<K>| {
        let hits = &mut room[..job.set.rays.len()];
        hits.fill(unset);
        let seconds = job.pool.install(|| {
            let start = Instant::now();
            trace_into(job.scene, &job.set.rays, job.set.any_hit, job.mode, hits);
            start.elapsed().as_secs_f64()
        });
        (seconds, checksum(hits), hits.iter().filter(|hit| hit.mask).count())
    };
    let same = |a: &Job<K>, b: &Job<K>| std::ptr::eq(a.scene, b.scene) && std::ptr::eq(a.set, b.set);
    let mut timings: Vec<Timing> = Vec::new();
    for round in 0..=samples {
        for (number, job) in jobs.iter().enumerate() {
            let (seconds, checksum, hits) = run(job);
            if round == 0 {
                timings.push(Timing { rays: job.set.rays.len(), hits, checksum, seconds: Vec::new() });
            } else {
                timings[number].seconds.push(seconds);
            }
            let first = jobs.iter().position(|other| same(other, job)).expect("the job itself is there");
            if checksum != timings[first].checksum {
                let [one, other] = [&jobs[first], job].map(|job| {
                    format!("mode {} on {} threads", job.mode.name(), job.pool.current_num_threads())
                });
                return Err(Error::Disagreement(format!("{} rays: {one}, and {other}", job.set.name)));
            }
        }
    }
    Ok(timings)
}
