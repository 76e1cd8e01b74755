//! Timing of the tracer. Jobs that are compared are interleaved: the first sample of every job, then the second sample
//! of every job, and so on. If the machine is slow for a while, all jobs suffer equally. Jobs with the same rays must
//! give the same hits.

use std::time::Instant;

use rayon::ThreadPool;

use super::built_scene::TracerKernel;
use super::ray_sets::RaySet;
use super::stats::{mad, median};
use crate::geom::Hit;
use crate::study::progress::Progress;
use crate::study::record::Samples;
use crate::tracer::{Error, Mode, Scene, checksum, trace_set_into};

/// A set of rays, and how to trace it.
#[derive(Debug)]
pub(crate) struct Job<'a> {
    pub(crate) scene: &'a Scene<TracerKernel>,
    pub(crate) set: &'a RaySet,
    pub(crate) mode: Mode,
    pub(crate) pool: &'a ThreadPool,
}

/// How long a job took, and what it hit.
#[derive(Clone, Debug)]
pub(crate) struct Timing {
    /// Number of rays.
    pub(crate) rays: usize,
    /// Number of rays that hit.
    pub(crate) hits: usize,
    /// Hash of the bits of all hits. It is the same in every run.
    pub(crate) checksum: u64,
    /// Wall time of each sample.
    seconds: Vec<f64>,
}

impl Timing {
    /// Median of the samples in million rays per second, and their median absolute deviation.
    pub(crate) fn mrays_per_second(&self) -> [f64; 2] {
        self.of_samples(|seconds| self.rays as f64 / seconds / 1e6)
    }

    /// Median of the samples in wall nanoseconds per ray, and their median absolute deviation.
    pub(crate) fn ns_per_ray(&self) -> [f64; 2] {
        self.of_samples(|seconds| seconds * 1e9 / self.rays as f64)
    }

    /// The samples in wall nanoseconds per ray.
    pub(crate) fn ns_of_rounds(&self) -> Samples {
        Samples::new(&[self.seconds.iter().map(|seconds| seconds * 1e9 / self.rays as f64).collect()])
    }

    fn of_samples(&self, figure: impl Fn(f64) -> f64) -> [f64; 2] {
        let samples: Vec<f64> = self.seconds.iter().map(|&seconds| figure(seconds)).collect();
        [median(&samples), mad(&samples)]
    }
}

/// Times the jobs in their order, `samples` times each after one warm-up run. Hits go into memory that is allocated
/// beforehand. Reports to `progress`.
///
/// # Errors
/// If any run of a job gives other hits than the first job with the same scene and rays: a timing of wrong results is
/// worthless.
pub(crate) fn time(jobs: &[Job], samples: usize, progress: &Progress) -> Result<Vec<Timing>, Error> {
    let most = jobs.iter().map(|job| job.set.rays.len()).max().unwrap_or(0);
    // A value that no ray can give. It overwrites the hits of earlier runs, so that they cannot pass for hits of a
    // later one.
    let unset = Hit::<f32>::new(true, f32::NEG_INFINITY, 0.0, 0.0);
    let mut buffer = vec![unset; most];
    let mut run = |job: &Job| {
        let hits = &mut buffer[..job.set.rays.len()];
        hits.fill(unset);
        let seconds = job.pool.install(|| {
            let start = Instant::now();
            trace_set_into(job.scene, &job.set.rays, job.set.any_hit, job.mode, hits);
            start.elapsed().as_secs_f64()
        });
        (seconds, checksum(hits), hits.iter().filter(|hit| hit.mask).count())
    };
    let same = |a: &Job, b: &Job| std::ptr::eq(a.scene, b.scene) && std::ptr::eq(a.set, b.set);
    let mut timings: Vec<Timing> = Vec::new();
    let runs = (samples + 1) * jobs.len();
    for round in 0..=samples {
        for (number, job) in jobs.iter().enumerate() {
            progress.reach((round * jobs.len() + number) as f64 / runs as f64);
            let (seconds, checksum, hits) = run(job);
            if round == 0 {
                timings.push(Timing { rays: job.set.rays.len(), hits, checksum, seconds: Vec::new() });
            } else {
                timings[number].seconds.push(seconds);
            }
            let first = jobs.iter().position(|other| same(other, job)).expect("the list contains the job itself");
            if checksum != timings[first].checksum {
                let [one, other] = [&jobs[first], job]
                    .map(|job| format!("mode {} on {} threads", job.mode.name(), job.pool.current_num_threads()));
                return Err(Error::Disagreement(format!("{} rays: {one}, and {other}", job.set.name)));
            }
        }
    }
    Ok(timings)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::measure::built_scene::BuiltScene;
    use crate::tracer::{SceneSource, thread_pool};

    #[test]
    fn every_mode_is_timed_and_gives_the_same_hits() {
        let (source, progress) = (SceneSource::parse("sphere:small").unwrap(), Progress::bar());
        let built = BuiltScene::new(&source, (32, 1)).unwrap();
        let pools = [1, 2].map(|threads| thread_pool(threads).unwrap());
        let of_set =
            |set| Mode::ALL.map(|mode| Job { scene: &built.scene, set, mode, pool: &pools[mode as usize % 2] });
        let jobs: Vec<Job> = built.sets.iter().flat_map(of_set).collect();
        let timings = time(&jobs, 3, &progress).unwrap();
        for (job, timing) in jobs.iter().zip(&timings) {
            assert_eq!((timing.rays, timing.seconds.len()), (job.set.rays.len(), 3));
            let ([rate, _], [ns, _]) = (timing.mrays_per_second(), timing.ns_per_ray());
            // With an odd number of samples, both medians come from the same sample.
            assert!(rate > 0.0 && (rate * ns / 1e3 - 1.0).abs() < 1e-9, "{rate} {ns}");
        }
        let primary = &timings[..Mode::ALL.len()];
        assert!((1..timings[0].rays).contains(&timings[0].hits), "some primary rays miss the sphere");
        assert!(primary.iter().all(|timing| (timing.hits, timing.checksum) == (timings[0].hits, timings[0].checksum)));
        assert_ne!(timings[0].checksum, timings[Mode::ALL.len()].checksum, "other rays must have other hits");
    }
}
