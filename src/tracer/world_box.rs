//! The box of an instance in the world: it contains the exactly transformed object, whatever the rounding.

use glam::{Affine3, Vec3};

use super::mesh::two_sum;
use crate::geom::Aabb;

/// A box around everything within `object`, a box that is not empty, after the exact affine transform. Each side is the
/// outermost of the transformed corners, or at most a few `f32` further out; for the identity it is the side of `object`
/// itself. A side beyond the range of `f32` is infinite.
pub(super) fn world_box(object: &Aabb, object_to_world: &Affine3) -> Aabb {
    let (rows, translation) = (object_to_world.matrix3.transpose(), object_to_world.translation);
    let sides = [0, 1, 2].map(|axis| {
        let factors = rows.col(axis).to_array().map(f64::from);
        let (lo, hi) = (object.lo.to_array().map(f64::from), object.hi.to_array().map(f64::from));
        // Products of two f32 are exact in f64.
        let products = [0, 1, 2].map(|j| (factors[j] * lo[j], factors[j] * hi[j]));
        let least = products.map(|(a, b)| a.min(b));
        let greatest = products.map(|(a, b)| a.max(b));
        let translation = f64::from(translation[axis]);
        // The negative of a lower bound is an upper bound of the negative.
        (-upper_bound(-translation, least.map(|product| -product)), upper_bound(translation, greatest))
    });
    Aabb { lo: Vec3::from_array(sides.map(|side| side.0)), hi: Vec3::from_array(sides.map(|side| side.1)) }
}

/// The least `f32` that is at least the exact sum, or at most a few further up.
fn upper_bound(first: f64, others: [f64; 3]) -> f32 {
    // The rounded sum and the exact errors of its additions together are the exact sum.
    let (mut sum, mut error) = (first, 0.0);
    for term in others {
        let (rounded, lost) = two_sum(sum, term);
        (sum, error) = (rounded, error + lost.abs());
    }
    // Nothing was lost in most of practice. Else twice the error also covers the roundings of adding up its parts, and
    // the next number that of adding it.
    let bound = if error > 0.0 { (sum + 2.0 * error).next_up() } else { sum };
    let nearest = bound as f32;
    if f64::from(nearest) < bound { nearest.next_up() } else { nearest }
}
