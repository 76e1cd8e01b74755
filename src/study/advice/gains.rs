//! What the simpler models of a scene gain: each is built, and the same rays are traced in it and in the given scene,
//! in turns. A model that gains nothing is none that a scene needs.

use std::time::Instant;

use glam::{Affine3, Vec3};
use serde::Serialize;

use super::models::{SimplerModel, combined, simpler_models};
use super::race::{Clock, Pair, Prepared, Rounds, Runner, prepare};
use super::rays::{Rays, moved};
use crate::geom::{Hit, Ray};
use crate::study::figures::choice::{Need, Standing, TIE, WrongAnswers};
use crate::study::measure::built_scene::TracerKernel;
use crate::study::measure::on_scenes::Answered;
use crate::study::measure::ray_sets::EDGES;
use crate::study::measure::scene_truth::SceneTruth;
use crate::study::measure::stats::{Estimate, ratio};
use crate::study::progress::Progress;
use crate::study::record::Samples;
use crate::tracer::{Error, Light, Mode, Scene, View, World};

/// A model must take at most this share of the memory to be worth it without being faster.
const SMALLER: f64 = 0.9;

/// A simpler model of the scene, with the chosen kernels and mode.
#[derive(Clone, Debug, Serialize)]
pub struct ModelRow {
    /// What is simpler.
    pub name: &'static str,
    /// What was found and what was done.
    pub about: String,
    /// Whether it is faster, or as fast and smaller, or lets a cheaper kernel do.
    pub is_worth_it: bool,
    /// A cheaper kernel that meets the need in this model and not in the given scene. The gain is then that of both.
    pub kernel: Option<String>,
    /// How many times as fast as the given scene it is traced.
    pub gain: f64,
    /// Lower end of its interval.
    pub gain_low: f64,
    /// Upper end of its interval.
    pub gain_high: f64,
    /// Bytes of the given scene and of the model, with trees and prepared primitives.
    pub bytes: [usize; 2],
    /// Greatest distance between the two surfaces, in units of the scene.
    pub deviation: f64,
    /// Rays that were traced in both. Where the surface is another one, only the first set: others start on it.
    pub rays: u64,
    /// Those of them that hit something in one only, or at different distances: beyond the deviation, and beyond a
    /// hundred-thousandth of the distance.
    pub changed: u64,
}

/// The scene that is asked about, and what was chosen for it.
pub(super) struct Asked<'a> {
    pub(super) name: &'a str,
    pub(super) scene: &'a Scene<TracerKernel>,
    pub(super) view: &'a View,
    pub(super) rays: &'a Rays,
    pub(super) clock: &'a Clock,
    pub(super) prepared: &'a dyn Prepared,
    pub(super) pair: &'a Pair,
    pub(super) mode: Mode,
    pub(super) need: Need,
    pub(super) most_displaced: f64,
    /// Family and ID of the kernel that is faster than the chosen one and does not meet the need.
    pub(super) cheaper: Option<(&'static str, String)>,
}

impl Asked<'_> {
    /// Measures all simpler models of the scene.
    ///
    /// # Errors
    /// Like [`Clock::time`].
    pub(super) fn models(&self, deadline: Instant, progress: &Progress) -> Result<Vec<ModelRow>, Error> {
        let models = simpler_models(self.scene.world());
        let start = Instant::now();
        let count = models.len() as f64;
        let mut rows = Vec::new();
        for (number, model) in models.into_iter().enumerate() {
            progress.note(&format!("{}: {}", self.name, model.name));
            let share = deadline.saturating_duration_since(start).mul_f64((number + 1) as f64 / count);
            rows.push(self.row(model, start + share)?);
            progress.reach((number + 1) as f64 / count);
        }
        Ok(rows)
    }

    /// The models that are worth it, one after the other, measured as one. `None` if there are none.
    ///
    /// # Errors
    /// Like [`Clock::time`].
    pub(super) fn simpler(
        &self,
        rows: &[ModelRow],
        deadline: Instant,
    ) -> Result<Option<(SimplerScene, ModelRow)>, Error> {
        let is_wanted = |model: &SimplerModel| rows.iter().any(|row| row.name == model.name && row.is_worth_it);
        let Some(model) = combined(self.scene.world(), is_wanted) else { return Ok(None) };
        let scene = SimplerScene { world: model.world.clone(), view: moved_view(self.view, model.moved_by) };
        Ok(Some((scene, self.row(model, deadline)?)))
    }

    fn row(&self, model: SimplerModel, deadline: Instant) -> Result<ModelRow, Error> {
        let SimplerModel { name, about, world, moved_by, deviation } = model;
        let scene = Scene::<TracerKernel>::new(world);
        let sets = self.rays.timed_in(&scene, &moved_view(self.view, moved_by), moved_by, !deviation.keeps_surface());
        let is_moved = moved_by != Vec3::ZERO;
        let cheaper = self.cheaper.as_ref().filter(|_| is_moved).map(|(family, id)| (self.pair.with(family, id), id));
        let cheaper = cheaper.filter(|(pair, _)| self.is_enough(&scene, pair, moved_by));
        let pair = cheaper.as_ref().map_or(self.pair, |(pair, _)| pair);
        let simpler = prepare(&scene, pair);
        let runners = [(self.prepared, &self.rays.timed[..]), (&*simpler, &sets[..])].map(|(prepared, sets)| Runner {
            prepared,
            mode: self.mode,
            sets,
        });
        let turns = self.clock.time(&runners, &Rounds { least: 6, most: 24, deadline }, &|_| {})?;
        let [given, own] =
            [(0, &self.rays.timed), (1, &sets)].map(|(number, sets)| Samples::new(&[turns[number].total(sets)]));
        let gain = ratio(&given, &own);
        let gain = |end: fn(&Estimate) -> f64| gain.as_ref().map_or(f64::NAN, end);
        let [gain, gain_low, gain_high] = [gain(|gain| gain.value), gain(|gain| gain.low), gain(|gain| gain.high)];
        let bytes = [self.scene.bytes(), scene.bytes()];
        let is_smaller = (bytes[1] as f64) < SMALLER * bytes[0] as f64;
        // Rays that leave the surface would start inside another one, or above it.
        let compared = if deviation.keeps_surface() { self.rays.timed.len() } else { 1 };
        let deviation = deviation.distance();
        let compared = &self.rays.timed[..compared];
        let changed = compared.iter().map(|given| {
            let own = moved(given, moved_by);
            let [first, second] = [(self.prepared, given), (&*simpler, &own)].map(|(prepared, set)| {
                let mut hits = vec![Hit::MISS; set.rays.len()];
                prepared.trace(set, Mode::Auto, &mut hits);
                hits
            });
            let pairs = given.rays.iter().zip(first.iter().zip(&second));
            pairs.filter(|(ray, (a, b))| is_changed(given.any_hit, deviation, ray, a, b)).count() as u64
        });
        Ok(ModelRow {
            name,
            about,
            is_worth_it: gain_low > 1.0 + TIE || is_smaller && gain_high > 1.0 - TIE,
            kernel: cheaper.map(|(_, id)| id.clone()),
            gain,
            gain_low,
            gain_high,
            bytes,
            deviation,
            rays: compared.iter().map(|set| set.rays.len() as u64).sum(),
            changed: changed.sum(),
        })
    }

    /// Whether other kernels meet the need in another scene.
    fn is_enough(&self, scene: &Scene<TracerKernel>, pair: &Pair, moved_by: Vec3) -> bool {
        let truth = SceneTruth::new(scene.world());
        let prepared = prepare(scene, pair);
        let sets = self.rays.search.iter().filter(|answered| answered.set.name != EDGES);
        let rows = sets.map(|answered| {
            let answered = Answered::new(&truth, moved(&answered.set, moved_by));
            prepared.judge(&truth, &answered, [self.name, ""], self.most_displaced)
        });
        let rows: Vec<_> = rows.collect();
        WrongAnswers::of(rows.iter()).is_some_and(|answers| self.need.standing(answers.wrong) == Standing::Meets)
    }
}

fn is_changed(any_hit: bool, deviation: f64, ray: &Ray<f32>, a: &Hit<f32>, b: &Hit<f32>) -> bool {
    if any_hit || a.mask != b.mask {
        return a.mask != b.mask;
    }
    let [a, b] = [a, b].map(|hit| f64::from(hit.t));
    let length = ray.dir.as_dvec3().length();
    // A surface that is seen at an angle moves farther along the ray.
    a.is_finite() && (a - b).abs() * length > 4.0 * deviation + 1e-5 * a.abs() * length
}

/// A simpler scene.
#[derive(Clone, Debug)]
pub struct SimplerScene {
    /// The world.
    pub world: World,
    /// Camera and light.
    pub view: View,
}

/// A view, moved like the world.
fn moved_view(view: &View, by: Vec3) -> View {
    let light = match view.light {
        Light::Point(point) => Light::Point(point + by),
        light @ Light::Directional(_) => light,
    };
    match view.transform {
        None => View { eye: view.eye + by, look_at: view.look_at + by, light, ..*view },
        Some(transform) => {
            let transform = Affine3 { translation: transform.translation + by, ..transform };
            View { transform: Some(transform), light, ..*view }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hits_are_changed_beyond_the_deviation() {
        let ray = Ray::new(Vec3::ZERO, Vec3::Z * 2.0);
        let hit = |t| Hit::<f32>::new(true, t, 0.0, 0.0);
        let changed = |deviation, a: Hit<f32>, b: Hit<f32>| is_changed(false, deviation, &ray, &a, &b);
        assert!(!changed(0.0, Hit::MISS, Hit::MISS));
        assert!(changed(1.0, hit(1.0), Hit::MISS) && changed(1.0, Hit::MISS, hit(1.0)));
        assert!(!changed(0.0, hit(1.0), hit(1.0 + 5e-6)) && changed(0.0, hit(1.0), hit(1.0 + 5e-5)));
        // Twice the difference of t is the distance.
        assert!(!changed(0.01, hit(1.0), hit(1.019)) && changed(0.01, hit(1.0), hit(1.021)));
        assert!(!is_changed(true, 0.0, &ray, &hit(1.0), &hit(9.0)), "any hit");
        assert!(is_changed(true, 0.0, &ray, &hit(1.0), &Hit::MISS));
    }

    #[test]
    fn a_view_moves_with_its_world() {
        let view = View {
            eye: Vec3::X,
            look_at: Vec3::ZERO,
            vertical_fov: 40.0,
            transform: None,
            light: Light::Point(Vec3::Y),
        };
        let by = Vec3::new(-5.0, 2.0, 1.0);
        let moved = moved_view(&view, by);
        let expected = Light::Point(Vec3::Y + by);
        assert_eq!((moved.eye, moved.look_at, moved.light), (Vec3::X + by, by, expected));
        let turned =
            View { transform: Some(Affine3::from_rotation_y(1.0)), light: Light::Directional(Vec3::Z), ..view };
        let rays = |view: &View| view.camera(3, 3).rays(3, 3);
        for (ray, moved) in rays(&turned).iter().zip(rays(&moved_view(&turned, by))) {
            assert!((moved.origin - ray.origin - by).length() < 1e-6 && moved.dir == ray.dir);
        }
        assert_eq!(moved_view(&turned, by).light, Light::Directional(Vec3::Z));
    }
}
