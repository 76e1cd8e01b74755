//! The rays that advice is found with, those that it is scored on, and those that kernels are timed with.
//!
//! They are the rays of pictures of the scene, or those of a file. Rays that score a kernel had no part in choosing it:
//! they belong to a picture of another size with other random directions, or to other stretches of the file.

use std::time::{Duration, Instant};

use glam::Vec3;

use crate::geom::Ray;
use crate::study::measure::built_scene::TracerKernel;
use crate::study::measure::on_scenes::{Answered, edge_rays};
use crate::study::measure::ray_sets::{RaySet, ray_sets};
use crate::study::measure::scene_truth::SceneTruth;
use crate::tracer::{Scene, View};

/// Name of the rays of a file.
const OF_FILE: &str = "file";

/// Where rays come from.
pub(super) enum Source<'a> {
    /// Pictures.
    Picture(&'a View),
    /// A file: its rays, and whether any hit will do.
    File(&'a [Ray<f32>], bool),
}

/// The rays of one scene.
pub(super) struct Rays {
    /// Kernels are chosen by these: the rays of a picture or of a file, and those aimed at edges.
    pub(super) search: Vec<Answered>,
    /// The chosen kernel is scored on these.
    pub(super) scored: Vec<Answered>,
    /// Kernels are timed with these.
    pub(super) timed: Vec<RaySet>,
    /// Width and height of the picture that they belong to, and its seed.
    picture: Option<(u32, u64)>,
}

/// Width and height of the picture that shows how many rays a picture has, and how long their exact answers take.
const PILOT: u32 = 64;
/// Greatest width and height of a picture.
const LARGEST: u32 = 1024;
/// Width and height of the picture whose rays are timed.
const TIMED: u32 = 192;
/// The file is divided into stretches of this many rays: they may be coherent, and blocks of them are traced together.
const STRETCH: usize = 4096;
/// The most rays of a file that are timed.
const MOST_TIMED: usize = 1 << 18;

impl Rays {
    /// Makes about `wanted` rays for the search, as many for the score, and finds their exact answers. Takes fewer if
    /// the answers would take longer than `time`: half as many, a quarter, and so on, so that small disturbances do not
    /// change the rays.
    pub(super) fn new(
        scene: &Scene<TracerKernel>,
        truth: &SceneTruth,
        source: &Source,
        (wanted, time, seed): (usize, Duration, u64),
        reach: &dyn Fn(f64),
    ) -> Self {
        match source {
            Source::Picture(view) => {
                let picture = |size, seed| Vec::from(ray_sets(scene, view, size, seed));
                let pilot = Instant::now();
                let sets = with_edges(scene, truth, picture(PILOT, seed), seed);
                let rays: usize = sets.iter().map(|set| set.rays.len()).sum();
                answered(truth, sets);
                let wanted = affordable(wanted, 2.0 * pilot.elapsed().as_secs_f64() / rays as f64, time);
                let size = (f64::from(PILOT) * (wanted as f64 / rays as f64).sqrt()).round() as u32;
                let size = size.clamp(PILOT, LARGEST);
                let half = |number: u32| {
                    reach(0.5 * f64::from(number));
                    // Another size moves all pixels, and another seed turns all other rays.
                    let (size, seed) = (size + number, seed.wrapping_add(number.into()));
                    answered(truth, with_edges(scene, truth, picture(size, seed), seed))
                };
                let timed = size.min(TIMED);
                Self {
                    search: half(0),
                    scored: half(1),
                    timed: without_empty(picture(timed, seed)),
                    picture: Some((timed, seed)),
                }
            }
            Source::File(rays, any_hit) => {
                let set = |rays: Vec<Ray<f32>>| RaySet { name: OF_FILE, any_hit: *any_hit, rays };
                let pilot = Instant::now();
                let first = set(rays[..rays.len().min(STRETCH)].into());
                let count = first.rays.len();
                answered(truth, vec![first]);
                let wanted = affordable(wanted, 2.0 * pilot.elapsed().as_secs_f64() / count as f64, time);
                let half = |number: usize| {
                    reach(0.5 * number as f64);
                    let set = set(every_other(rays, number, wanted));
                    answered(truth, with_edges(scene, truth, vec![set], seed.wrapping_add(number as u64)))
                };
                let timed = without_empty(vec![set(spread(rays, MOST_TIMED))]);
                Self { search: half(0), scored: half(1), timed, picture: None }
            }
        }
    }

    /// The rays that a simpler scene is timed with. Where its surface is another one, the rays of a picture start on
    /// that; all others are moved.
    pub(super) fn timed_in(&self, scene: &Scene<TracerKernel>, view: &View, moved_by: Vec3, anew: bool) -> Vec<RaySet> {
        if let Some((size, seed)) = self.picture.filter(|_| anew) {
            return without_empty(ray_sets(scene, view, size, seed).into());
        }
        self.timed.iter().map(|set| moved(set, moved_by)).collect()
    }
}

/// The same rays from origins that are moved.
pub(super) fn moved(set: &RaySet, by: Vec3) -> RaySet {
    let ray = |ray: &Ray<f32>| Ray { origin: ray.origin + by, ..*ray };
    RaySet { rays: set.rays.iter().map(ray).collect(), ..*set }
}

/// Halves a number of rays until they take no longer than `time`.
fn affordable(mut wanted: usize, seconds_per_ray: f64, time: Duration) -> usize {
    while wanted > 1000 && wanted as f64 * seconds_per_ray > time.as_secs_f64() {
        wanted /= 2;
    }
    wanted
}

fn answered(truth: &SceneTruth, sets: Vec<RaySet>) -> Vec<Answered> {
    without_empty(sets).into_iter().map(|set| Answered::new(truth, set)).collect()
}

fn without_empty(sets: Vec<RaySet>) -> Vec<RaySet> {
    sets.into_iter().filter(|set| !set.rays.is_empty()).collect()
}

/// With rays from the origins of the first set at edges of what they hit.
fn with_edges(scene: &Scene<TracerKernel>, truth: &SceneTruth, mut sets: Vec<RaySet>, seed: u64) -> Vec<RaySet> {
    sets.push(edge_rays(scene, &sets[0].rays, truth, seed));
    sets
}

/// About `most` rays of every other stretch, spread over the file. Two halves have no ray in common.
fn every_other(rays: &[Ray<f32>], half: usize, most: usize) -> Vec<Ray<f32>> {
    // A short file has shorter stretches, so that both halves get some.
    let stretch = STRETCH.min(rays.len().div_ceil(8)).max(1);
    let own: Vec<_> = rays.chunks(stretch).skip(half).step_by(2).flatten().copied().collect();
    spread(&own, most)
}

/// At most about `most` rays: stretches, evenly spread.
fn spread(rays: &[Ray<f32>], most: usize) -> Vec<Ray<f32>> {
    rays.chunks(STRETCH).step_by(rays.len().div_ceil(most).max(1)).flatten().copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracer::{LoadedScene, SceneSource};

    fn numbered(count: usize) -> Vec<Ray<f32>> {
        (0..count).map(|number| Ray::new(Vec3::new(number as f32, 0.0, 0.0), Vec3::Y)).collect()
    }

    fn numbers(rays: &[Ray<f32>]) -> Vec<usize> {
        rays.iter().map(|ray| ray.origin.x as usize).collect()
    }

    #[test]
    fn the_halves_of_a_file_have_no_ray_in_common_and_cover_all_of_it() {
        for count in [1, 2, 9, 1000, 100_000] {
            let rays = numbered(count);
            let halves = [0, 1].map(|half| numbers(&every_other(&rays, half, count)));
            let mut all = halves.concat();
            all.sort_unstable();
            assert_eq!(all, (0..count).collect::<Vec<_>>());
            let [larger, smaller] = halves.map(|half| half.len());
            assert!(count == 1 || larger <= 2 * smaller + STRETCH, "{count}: {larger} and {smaller}");
        }
        // Of many rays, some, from the whole file, in stretches that stay together.
        let some = numbers(&every_other(&numbered(1 << 20), 1, 1 << 16));
        assert!((1 << 15..=1 << 17).contains(&some.len()), "{}", some.len());
        assert!(some[0] < 1 << 14 && some[some.len() - 1] > (1 << 20) - (1 << 17));
        assert!(some.windows(2).filter(|pair| pair[1] != pair[0] + 1).count() < some.len() / STRETCH + 1);
    }

    #[test]
    fn fewer_rays_are_taken_if_their_answers_take_long() {
        let time = Duration::from_secs(1);
        assert_eq!(affordable(1_000_000, 1e-7, time), 1_000_000);
        assert_eq!(affordable(1_000_000, 1.1e-6, time), 500_000);
        assert_eq!(affordable(1_000_000, 1e9, time), 976, "some rays remain");
    }

    #[test]
    fn rays_that_score_are_others_than_those_of_the_search() {
        let LoadedScene { world, view, .. } = SceneSource::parse("room:1000").unwrap().load().unwrap();
        let scene = Scene::new(world);
        let truth = SceneTruth::new(scene.world());
        let amount = (30_000, Duration::from_secs(1000), 1);
        let rays = Rays::new(&scene, &truth, &Source::Picture(&view), amount, &|_| {});
        let directions = |sets: &[Answered]| -> std::collections::HashSet<[u32; 3]> {
            let rays = sets.iter().flat_map(|answered| &answered.set.rays);
            rays.map(|ray| ray.dir.to_array().map(f32::to_bits)).collect()
        };
        let [search, scored] = [&rays.search, &rays.scored].map(|sets| directions(sets));
        assert!(search.len() > 20_000 && scored.len() > 20_000, "{} and {}", search.len(), scored.len());
        assert!(search.intersection(&scored).count() < 20, "shadow rays may agree by chance");
        let names: Vec<_> = rays.search.iter().map(|answered| answered.set.name).collect();
        assert_eq!(names, ["primary", "shadow", "bounce", "ambient occlusion", "edges"]);
        assert_eq!(rays.timed.len(), 4, "rays at edges are not timed");
    }
}
