//! Speed of the tracer's modes against the coherence of the rays: when does it stop paying to trace many rays together?
//!
//! The primary rays of a picture have one origin and similar directions. Here each ray is turned at random. Let `p` be
//! the unit direction through a pixel, and `r` a random unit vector, uniform over the sphere and fixed by the seed.
//! With jitter `j`, the ray of that pixel has the direction `(1 - j)·p + j·r`, normalised. Origin, order and number of
//! rays are the same for all `j`, and so is each ray's `r`. A small jitter turns rays by up to about `j` radians;
//! neighbouring pixels of these pictures are 0.002 to 0.003 radians apart. At jitter 1, rays share nothing but the
//! origin.

use super::built_scene::{TracerKernel, picture_size};
use super::ray_sets::RaySet;
use super::timing::{Job, time};
use crate::geom::Ray;
use crate::kernels::Kernel;
use crate::study::progress::Progress;
use crate::study::record::CoherenceRow;
use crate::study::workload::{direction, rng};
use crate::tracer::{Camera, Error, LoadedScene, Mode, Scene, SceneSource, thread_pool, traversal_stats};

/// The jitters that are measured: 0 gives the rays of the picture, 1 gives random rays.
pub const JITTERS: [f64; 9] = [0.0, 0.001, 0.003, 0.01, 0.03, 0.1, 0.2, 0.5, 1.0];

/// An open scene of small triangles, which random rays often leave, and a closed scene of large triangles.
const SCENES: [&str; 2] = ["terrain:1e5", "room"];
/// Smaller scenes of the same kinds, for a quick run.
const QUICK_SCENES: [&str; 2] = ["terrain:1e3", "room:small"];

/// Times every mode at every jitter, interleaved within a scene. Counts visits and tests in a run that is not timed.
///
/// # Errors
/// If two modes disagree about a hit.
pub(crate) fn measure(quick: bool, seed: u64, progress: &Progress) -> Result<Vec<CoherenceRow>, Error> {
    let scenes = if quick { QUICK_SCENES } else { SCENES };
    // Nine jitters confirm each other, and more samples would take the study beyond three minutes.
    let samples = 3;
    let size = picture_size(quick);
    let pool = thread_pool(1)?;
    let mut rows = Vec::new();
    for (name, progress) in progress.each(&scenes) {
        progress.note(&format!("{name}: coherence"));
        let LoadedScene { world, view, .. } = SceneSource::parse(name)?.load()?;
        let scene = Scene::<TracerKernel>::new(world);
        let camera = view.camera(size, size);
        let sets = JITTERS.map(|jitter| RaySet {
            name: "jittered",
            any_hit: false,
            rays: jittered(&camera, size, jitter as f32, seed),
        });
        let of_set = |set| Mode::ALL.map(|mode| Job { scene: &scene, set, mode, pool: &pool });
        let jobs: Vec<_> = sets.iter().flat_map(of_set).collect();
        let timings = time(&jobs, samples, &progress)?;
        let jitters = JITTERS.iter().flat_map(|jitter| [jitter; Mode::ALL.len()]);
        rows.extend(jobs.iter().zip(timings).zip(jitters).map(|((job, timing), &jitter)| {
            let counts = traversal_stats(job.scene, &job.set.rays, job.set.any_hit, job.mode);
            let [mrays_per_second, mrays_per_second_mad] = timing.mrays_per_second();
            CoherenceRow {
                scene: (*name).into(),
                jitter,
                mode: job.mode.name().into(),
                kernel: TracerKernel::INFO.id.to_string(),
                ray_count: counts.rays,
                mrays_per_second,
                mrays_per_second_mad,
                nodes: counts.nodes,
                leaves: counts.leaves,
                tests: counts.tests,
                lanes: counts.lanes,
                checksum: format!("{:016x}", timing.checksum),
            }
        }));
    }
    Ok(rows)
}

/// The primary rays of a picture of `size` × `size` pixels, turned by this jitter, in the order of the picture's
/// blocks. Jitter 0 leaves them as they are, with directions that are not normalised.
fn jittered(camera: &Camera, size: u32, jitter: f32, seed: u64) -> Vec<Ray<f32>> {
    let turn = |(number, ray): (usize, Ray<f32>)| {
        let straight = ray.dir.normalize();
        let random = direction(&mut rng(seed, "tracer", "coherence", &[], number as u64));
        let mixed = straight * (1.0 - jitter) + random * jitter;
        // Opposite directions can cancel to zero.
        Ray::new(ray.origin, mixed.normalize_or(random))
    };
    let rays = camera.rays(size, size);
    if jitter == 0.0 { rays } else { rays.into_iter().enumerate().map(turn).collect() }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn jitter_turns_the_rays_of_the_picture_into_random_rays() {
        let camera = Camera::new(Vec3::new(1.0, 2.0, 9.0), Vec3::ZERO, 45.0, 32, 32);
        let rays = |jitter| jittered(&camera, 32, jitter, 5);
        let straight = rays(0.0);
        assert_eq!(straight, camera.rays(32, 32));
        let angle = |a: &Ray<f32>, b: &Ray<f32>| a.dir.cross(b.dir.normalize()).length();
        let mut last = 0.0;
        for jitter in [0.001, 0.01, 0.1] {
            let turned = rays(jitter);
            let greatest = turned.iter().zip(&straight).map(|(a, b)| angle(a, b)).fold(0.0, f32::max);
            assert!((0.9 * jitter..1.2 * jitter).contains(&greatest), "{jitter}: {greatest}");
            assert!(turned.iter().all(|ray| (ray.dir.length() - 1.0).abs() < 1e-6));
            assert!(greatest > last);
            last = greatest;
        }
        let mean: Vec3 = rays(1.0).iter().map(|ray| ray.dir).sum::<Vec3>() / 1024.0;
        assert!(mean.length() < 0.06, "{mean}: directions must be uniform");
        assert_eq!(rays(0.5), rays(0.5));
    }

    #[test]
    fn jitters_rise_from_0_to_1() {
        assert!(JITTERS.is_sorted() && JITTERS[0] == 0.0 && JITTERS[JITTERS.len() - 1] == 1.0);
    }
}
