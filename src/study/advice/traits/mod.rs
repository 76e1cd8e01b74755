//! Traits of a scene and of its rays: the properties that make kernels fail, each measured and held to a limit.
//!
//! **Limits.** Each follows a regime of the study ([workload](crate::study::workload)). In the report of 2026-11-29, it
//! is the hardest step of that regime at which no kernel answers more than 100 of a million tests wrong. Steps are
//! mostly a decade apart, so a value just beyond its limit may still be harmless. A limit without a regime says so.
//!
//! **Rare values.** A trait that each triangle or each hit has for itself is given by its 99.9 % or 0.1 % quantile: at
//! most one in 1,000 is worse. If a kernel gets one of 1,000 of those wrong, a millionth of all answers is wrong. Of
//! fewer than 1,000 triangles or hits, the worst one counts.
//!
//! **Coordinates.** Triangles, quadrics and hits are measured in the coordinates of their geometry, where the kernel
//! sees them. Triangles count once, however many instances they have.

mod coherence;
mod hits;
mod transforms;
mod triangles;

use serde::Serialize;

use crate::study::figures::{count, number, severity};
use crate::study::measure::built_scene::TracerKernel;
use crate::study::measure::ray_sets::RaySet;
use crate::tracer::{Scene, World};

/// The quantile that stands for values of which large ones are bad.
const HIGH: f64 = 0.999;
/// The quantile that stands for values of which small ones are bad.
const LOW: f64 = 0.001;

/// The limit of the greatest coordinate, in extents of the scene. Regime: instance of triangle, translation. Rays that
/// are transformed before the translation is subtracted, and baked vertices, fail at the next step.
const MAX_OFFSET: f64 = 1e3;

/// Extents outside of this range decide: scenes of triangles, and scenes with quadrics. Regimes: triangle, scale, and
/// quadric, scale. Kernels with an absolute epsilon fail much earlier; see [`hits`].
const EXTENTS: [[f64; 2]; 2] = [[1e-12, 1e12], [1e-9, 1e6]];

/// One measured property of a scene or of its rays.
#[derive(Clone, Debug, Serialize)]
pub struct Trait {
    /// Its name, unique among the traits of a scene.
    pub name: &'static str,
    /// The figure that decides. It may be infinite.
    pub value: f64,
    /// The figure in words, in one line.
    pub text: String,
    /// Whether the figure is beyond the limit from which some kernel fails.
    pub decides: bool,
    /// What it does to kernels: one sentence.
    pub why: &'static str,
}

impl Trait {
    /// A trait that decides above a limit.
    fn above(limit: f64, name: &'static str, value: f64, text: String, why: &'static str) -> Self {
        Self { name, value, text: with_limit(&text, limit), decides: value > limit, why }
    }

    /// A trait that decides below a limit.
    fn below(limit: f64, name: &'static str, value: f64, text: String, why: &'static str) -> Self {
        Self { name, value, text: with_limit(&text, limit), decides: value < limit, why }
    }
}

fn with_limit(text: &str, limit: f64) -> String {
    format!("{text} (limit: {})", severity(limit))
}

/// The traits of a scene and of the rays that are to be traced in it, in a fixed order. One that needs triangles, hits
/// or rays is left out if there are none.
pub(crate) fn traits(scene: &Scene<TracerKernel>, sets: &[RaySet]) -> Vec<Trait> {
    let world = scene.world();
    let extent = scene.bounds().diagonal();
    let mut traits = vec![size(world), extent_trait(world, extent)];
    if extent > 0.0 {
        traits.push(offset(scene, extent));
    }
    traits.extend(triangles::traits(world));
    traits.push(transforms::condition(world));
    traits.extend(hits::traits(scene, sets));
    traits.extend(coherence::coherence(sets));
    traits
}

fn size(world: &World) -> Trait {
    let (triangles, quadrics, instances) = (world.triangles(), world.quadrics(), world.instances().len());
    Trait {
        name: "size",
        value: (triangles + quadrics) as f64,
        text: format!(
            "triangles: {}, quadrics: {}, instances: {}",
            count(triangles as u64),
            count(quadrics as u64),
            count(instances as u64)
        ),
        decides: false,
        why: "it decides how much a test may cost beside the visits of nodes, but not who is right",
    }
}

fn extent_trait(world: &World, extent: f64) -> Trait {
    let [least, greatest] = EXTENTS[usize::from(world.quadrics() > 0)];
    Trait {
        name: "extent",
        value: extent,
        text: format!(
            "the scene is {} units across (limits: {}, {})",
            number(extent, 2),
            severity(least),
            severity(greatest)
        ),
        decides: !(least..=greatest).contains(&extent),
        why: "products of three or four lengths leave the range of f32",
    }
}

fn offset(scene: &Scene<TracerKernel>, extent: f64) -> Trait {
    let bounds = scene.bounds();
    let greatest = f64::from(bounds.lo.abs().max(bounds.hi.abs()).max_element());
    let offset = greatest / extent;
    Trait::above(
        MAX_OFFSET,
        "offset from the origin",
        offset,
        format!("coordinates reach {} times the extent of the scene", number(offset, 2)),
        "vertices, planes and transforms that are prepared in the world lose digits",
    )
}

/// The nearest-rank quantile: the least value that at least this share of the values does not exceed. Changes the order
/// of the values.
///
/// # Panics
/// If there are no values.
fn quantile(values: &mut [f64], share: f64) -> f64 {
    let rank = (share * values.len() as f64).ceil() as usize;
    *values.select_nth_unstable_by(rank.max(1) - 1, f64::total_cmp).1
}

/// The share of values that satisfy a condition, in percent.
fn percent_of(values: &[f64], condition: impl Fn(f64) -> bool) -> String {
    let matching = values.iter().filter(|&&value| condition(value)).count();
    number(100.0 * matching as f64 / values.len() as f64, 2) + " %"
}

#[cfg(test)]
mod tests;
