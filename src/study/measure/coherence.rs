//! Speed of the tracer's modes against the coherence of rays: where does tracing many rays together stop to pay?
//!
//! The rays are those of a picture, which have one origin and run alike, turned at random. With `p` the unit direction
//! through a pixel and `r` one of the unit sphere, evenly distributed and fixed by the seed, the ray of that pixel with
//! jitter `j` runs along `(1 - j)·p + j·r`, made of unit length. Origin, order and number of rays are the same for all
//! `j`, and so is each ray's `r`. A small jitter turns rays by up to about `j` radians (neighbouring pixels of these
//! pictures are 0.003 to 0.004 apart); at 1 rays have nothing in common but the origin.

use super::built_scene::TracerKernel;
use super::ray_sets::RaySet;
use super::timing::{Job, time};
use crate::geom::Ray;
use crate::kernels::Kernel;
use crate::study::progress::Progress;
use crate::study::record::CoherenceRow;
use crate::study::workload::{direction, rng};
use crate::tracer::{Camera, Error, LoadedScene, Mode, Scene, SceneSource, count, thread_pool};

/// How far rays are turned: 0 for those of the picture, 1 for random ones.
pub const JITTERS: [f64; 9] = [0.0, 0.001, 0.003, 0.01, 0.03, 0.1, 0.2, 0.5, 1.0];

/// The scenes: an open one of small triangles, which random rays often leave, and a closed one of large triangles.
const SCENES: [&str; 2] = ["terrain:1e5", "room"];
/// The same for a quick run.
const QUICK_SCENES: [&str; 2] = ["terrain:1e3", "room:small"];

/// Times every mode on every jitter, all of a scene's interleaved, and counts what each takes.
///
/// # Errors
/// If two modes disagree about a hit.
pub(crate) fn measure(quick: bool, seed: u64, progress: &Progress) -> Result<Vec<CoherenceRow>, Error> {
    let (scenes, size, samples) = if quick { (QUICK_SCENES, 64, 3) } else { (SCENES, 256, 5) };
    let pool = thread_pool(1)?;
    let mut rows = Vec::new();
    for (name, progress) in progress.each(&scenes) {
        progress.note(&format!("{name}: coherence"));
        let LoadedScene { world, view, .. } = SceneSource::parse(name)?.load()?;
        let scene = Scene::<TracerKernel>::new(world);
        let camera = view.camera(size, size);
        let sets = JITTERS.map(|jitter| RaySet {
            name: "turned",
            any_hit: false,
            rays: turned(&camera, size, jitter as f32, seed),
        });
        let of_set = |set| Mode::ALL.map(|mode| Job { scene: &scene, set, mode, pool: &pool });
        let jobs: Vec<_> = sets.iter().flat_map(of_set).collect();
        let timings = time(&jobs, samples, &progress)?;
        let jitters = JITTERS.iter().flat_map(|jitter| [jitter; Mode::ALL.len()]);
        rows.extend(jobs.iter().zip(timings).zip(jitters).map(|((job, timing), &jitter)| {
            let counts = count(job.scene, &job.set.rays, job.set.any_hit, job.mode);
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

/// The rays of a picture of `size` × `size` pixels with this jitter, in the order of the picture's blocks.
fn turned(camera: &Camera, size: u32, jitter: f32, seed: u64) -> Vec<Ray<f32>> {
    let turn = |(number, ray): (usize, Ray<f32>)| {
        let straight = ray.dir.normalize();
        let random = direction(&mut rng(seed, "tracer", "coherence", &[], number as u64));
        let mixed = straight * (1.0 - jitter) + random * jitter;
        // Opposite directions may cancel each other.
        Ray::new(ray.origin, mixed.normalize_or(random))
    };
    camera.rays(size, size).into_iter().enumerate().map(turn).collect()
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn rays_are_turned_from_those_of_the_picture_to_random_ones() {
        let camera = Camera::new(Vec3::new(1.0, 2.0, 9.0), Vec3::ZERO, 45.0, 32, 32);
        let rays = |jitter| turned(&camera, 32, jitter, 5);
        let straight = rays(0.0);
        for (ray, pixel) in straight.iter().zip(camera.rays(32, 32)) {
            assert!(ray.dir.abs_diff_eq(pixel.dir.normalize(), 1e-6) && ray.origin == pixel.origin);
        }
        let angle = |a: &Ray<f32>, b: &Ray<f32>| a.dir.cross(b.dir).length();
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
        assert!(mean.length() < 0.06, "{mean}: evenly distributed");
        assert_eq!(rays(0.5), rays(0.5));
    }

    #[test]
    fn jitters_rise_from_the_picture_to_random() {
        assert!(JITTERS.is_sorted() && JITTERS[0] == 0.0 && JITTERS[JITTERS.len() - 1] == 1.0);
    }
}
