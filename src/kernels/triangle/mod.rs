//! Triangles. A hit satisfies `origin + t·dir = v0 + u·(v1 - v0) + v·(v2 - v0)`: three equations with three unknowns.
//! `u` and `v` are the textbook's barycentrics β and γ. Both sides hit. Edges and vertices belong to the triangle
//! (`u >= 0`, `v >= 0`, `u + v <= 1`). The header of each kernel says what becomes of that under rounding.
//!
//! A scalar twin returns as soon as it knows that the ray misses, and most rays do. A packet twin runs to the end: a
//! branch on eight different rays cannot be predicted. With such a branch, packets ran at 0.49 to 0.73 times the
//! speed, and whole scenes at 0.87 to 1.04 times. A branch in `triangle/woop` only for packets whose rays all have
//! one axis gave 1.05 times the speed for primary rays of a mesh, and 0.93 times for its shadow rays.

pub mod baldwin_weber;
pub mod cramer;
pub mod embree_moller;
pub mod embree_pluecker;
pub mod exact;
#[cfg(any(fused, doc))]
pub mod exact_fused;
pub mod exact_half_open;
pub mod exact_t;
pub mod kensler_shirley;
pub mod moller_trumbore;
pub mod moller_trumbore_epsilon;
pub mod moller_trumbore_f64;
#[cfg(any(fused, doc))]
pub mod pbrt_woop;
pub mod pluecker;
pub mod woop;
#[cfg(any(fused, doc))]
pub mod woop_dop;
pub mod woop_half_open;

#[doc(inline)]
pub use baldwin_weber::BaldwinWeber;
#[doc(inline)]
pub use cramer::Cramer;
#[doc(inline)]
pub use embree_moller::EmbreeMoller;
#[doc(inline)]
pub use embree_pluecker::EmbreePluecker;
#[doc(inline)]
pub use exact::Exact;
#[cfg(any(fused, doc))]
#[doc(inline)]
pub use exact_fused::ExactFused;
#[doc(inline)]
pub use exact_half_open::ExactHalfOpen;
#[doc(inline)]
pub use exact_t::ExactT;
#[doc(inline)]
pub use kensler_shirley::KenslerShirley;
#[doc(inline)]
pub use moller_trumbore::MollerTrumbore;
#[doc(inline)]
pub use moller_trumbore_epsilon::MollerTrumboreEpsilon;
#[doc(inline)]
pub use moller_trumbore_f64::MollerTrumboreF64;
#[cfg(any(fused, doc))]
#[doc(inline)]
pub use pbrt_woop::PbrtWoop;
#[doc(inline)]
pub use pluecker::Pluecker;
#[doc(inline)]
pub use woop::{Shear, Shear8, Woop};
#[cfg(any(fused, doc))]
#[doc(inline)]
pub use woop_dop::WoopDop;
#[doc(inline)]
pub use woop_half_open::WoopHalfOpen;

use glam::{DVec3, Vec3};
use wide::f32x8;

use crate::geom::Triangle;
use crate::geom::lanes::{Lanes, Mask8, ge8, le8, max, max8, min, min8};
use crate::kernels::aabb::Slabs;
use crate::kernels::power_of_two_below;

prepared! {
    /// The vertices of one triangle or of eight, 36 bytes a triangle. Kernels that prepare nothing store them.
    pub struct Vertices<P: Lanes> {
        /// Vertices with `u = v = 0`.
        pub v0: P::Vec3,
        /// Vertices with `u = 1`.
        pub v1: P::Vec3,
        /// Vertices with `v = 1`.
        pub v2: P::Vec3,
    }
}

impl From<&Triangle> for Vertices<f32> {
    fn from(&Triangle { v0, v1, v2 }: &Triangle) -> Self {
        Self { v0, v1, v2 }
    }
}

impl Vertices<f32x8> {
    /// The boxes of the triangles.
    #[inline(always)]
    fn bounds(&self) -> Slabs<f32x8> {
        let Self { v0, v1, v2 } = self;
        Slabs { lo: v0.min(v1).min(v2), hi: v0.max(v1).max(v2) }
    }
}

/// `(v1 - v0) × (v2 - v0)` in `f64`. Differences of `f32` numbers of similar size are exact in `f64`, and so are
/// products of two such differences. So the normal of a triangle of zero area is exactly zero, and the normal of any
/// sliver has the right direction.
fn normal(shape: &Triangle) -> DVec3 {
    let [v0, v1, v2] = shape.vertices().map(Vec3::as_dvec3);
    (v1 - v0).cross(v2 - v0)
}

/// [`normal`], times a power of two that brings it to about 1. It keeps its direction and does not become subnormal or
/// infinite, however small or large the triangle is. Returns the power too. A normal of zero stays zero.
fn scaled_normal(shape: &Triangle) -> (DVec3, f64) {
    let normal = normal(shape);
    let longest = normal.abs().max_element();
    let scale = if longest > 0.0 { 1.0 / power_of_two_below(longest) } else { 1.0 };
    (normal * scale, scale)
}

/// The vertices, or NaN if determinants of the triangle could not keep their digits: the product of its area and its
/// size is near the end of the range. Such a triangle misses.
fn representable(shape: &Triangle) -> [Vec3; 3] {
    // 2¹⁷ times the smallest `f32`.
    const LEAST: f64 = f32::MIN_POSITIVE as f64 / 64.0;
    let vertices = shape.vertices();
    let [v0, v1, v2] = vertices.map(Vec3::as_dvec3);
    let size = (v1 - v0).abs().max((v2 - v0).abs()).max_element();
    if normal(shape).abs().max_element() * size < LEAST { [Vec3::NAN; 3] } else { vertices }
}

/// Whether `u >= 0`, `v >= 0` and `u + v <= 1`. False for a NaN, because the last minimum passes it on.
///
/// One comparison makes one branch. rustc 1.95 makes three branches of three comparisons. Each of those is taken
/// about half the time, and kernels took 2.0 to 2.5 times as long.
#[inline(always)]
fn barycentrics_inside(u: f32, v: f32) -> bool {
    min(min(u, v), 1.0 - (u + v)) >= 0.0
}

/// [`barycentrics_inside`] in eight lanes. Nothing branches here, so the shorter form is faster.
#[inline(always)]
fn barycentrics_inside8(u: f32x8, v: f32x8) -> Mask8 {
    ge8(min8(u, v), f32x8::ZERO) & le8(u + v, f32x8::ONE)
}

/// Compares the signs of three weights. Positive if all three agree. Zero if at least one weight is zero and the
/// others agree. Negative if two signs differ. A NaN may go unnoticed: everything computed from it is NaN too.
#[inline(always)]
fn sign_agreement([u, v, w]: [f32; 3]) -> f32 {
    let (least, greatest) = (min(min(u, v), w), max(max(u, v), w));
    max(least, -greatest)
}

/// [`sign_agreement`] in eight lanes.
#[inline(always)]
fn sign_agreement8([u, v, w]: [f32x8; 3]) -> f32x8 {
    let (least, greatest) = (min8(min8(u, v), w), max8(max8(u, v), w));
    max8(least, -greatest)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers around the bounds of a triangle, infinities and a NaN.
    const SHARP: [f32; 16] = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        0.5,
        0.5 - f32::EPSILON / 4.0,
        0.5 + f32::EPSILON / 2.0,
        1.0 + f32::EPSILON,
        1.0 - f32::EPSILON / 2.0,
        f32::EPSILON / 4.0,
        1e-45,
        -1e-45,
        f32::MAX,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::NAN,
    ];

    #[test]
    fn barycentrics_inside_equals_its_three_comparisons() {
        for u in SHARP {
            for v in SHARP {
                let expected = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0);
                assert_eq!(barycentrics_inside(u, v), expected, "{u:?}, {v:?}");
                let eight = barycentrics_inside8(f32x8::splat(u), f32x8::splat(v)).bits();
                assert_eq!(eight, if expected { 0xff } else { 0 }, "eight lanes of {u:?}, {v:?}");
            }
        }
    }

    #[test]
    fn sign_agreement_is_negative_only_if_two_signs_differ() {
        let numbers: Vec<f32> = SHARP.into_iter().filter(|number| !number.is_nan()).collect();
        for &u in &numbers {
            for &v in &numbers {
                for &w in &numbers {
                    let weights = [u, v, w];
                    let agree =
                        weights.iter().all(|&weight| weight >= 0.0) | weights.iter().all(|&weight| weight <= 0.0);
                    let found = sign_agreement(weights);
                    assert_eq!(found >= 0.0, agree, "{weights:?}");
                    assert_eq!(found == 0.0, agree & weights.contains(&0.0), "{weights:?}");
                    for lane in sign_agreement8(weights.map(f32x8::splat)).to_array() {
                        assert_eq!(lane.to_bits(), found.to_bits(), "eight lanes of {weights:?}");
                    }
                }
            }
        }
    }
}
