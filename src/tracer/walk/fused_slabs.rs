//! The fused slab test: `plane·inv - origin·inv` instead of the monotonic `(plane - origin)·inv`.
//!
//! It saves an operation per plane and may only cull, never judge a candidate. Its rounding errors are folded into the
//! addends once per ray, so it is never stricter than the slab test of the box rule. `culling_tests` checks that.

use glam::Vec3;

use crate::geom::Ray;
use crate::kernels::aabb::InverseDirection;
use crate::tracer::bvh::Extent;

/// Error bound of `plane·inv - origin·inv`, relative to `(|origin| + largest |plane|)·|inv|`.
///
/// With ε = 2⁻²⁴, the error against the monotonic `(plane - origin)·inv` is less than 6ε, and the padding of exits adds
/// 8ε. 16ε covers both, and the rounding of the bound itself. [`f32::MIN_POSITIVE`] covers underflow.
pub(crate) const ERROR: f32 = 1.0 / 1_048_576.0;
/// Above this `(|origin| + largest |plane|)·|inv|`, products may overflow, and the monotonic test is used instead.
pub(crate) const LARGEST: f32 = 1e30;
/// Cap on `|1 / dir|` per axis, relative to the smallest of the three axes.
///
/// The capped value serves where a direction is zero or nearly zero. Near planes are then reached too early. Far planes
/// are reached so late that the ray has left the tree before, along its longest axis. Both only make the test less
/// strict.
pub(crate) const STEEPEST: f32 = 1.152_921_5e18;

/// The largest `|origin| + largest |plane|` at which the fused test is sharp enough: its error bound, in coordinates,
/// is then at most a quarter of the smallest leaf. Beyond it, a ray would visit every leaf of a small object on a large
/// ground. In real meshes the error bound is a hundredth of the smallest leaf, or less.
#[inline(always)]
pub(crate) fn sharp_reach(extent: &Extent) -> f32 {
    extent.smallest_leaf * (0.25 / ERROR)
}

/// One ray, prepared for the fused slab test.
pub(crate) struct FusedSlabs {
    /// The ray's setup for the monotonic test.
    pub(crate) setup: InverseDirection<f32>,
    /// Inverse direction, capped by [`STEEPEST`].
    pub(crate) inv_dir: Vec3,
    /// `|origin| + largest |plane|` per axis.
    pub(crate) reach: Vec3,
    /// `-origin·inv` minus the error bound: the addend of near planes.
    pub(crate) near: Vec3,
    /// `-origin·inv` plus the error bound: the addend of far planes.
    pub(crate) far: Vec3,
    /// Whether the error bound holds and is small enough. False for NaN.
    pub(crate) valid: bool,
}

impl FusedSlabs {
    /// Prepares a ray for a tree of this extent.
    #[inline(always)]
    pub(crate) fn of(ray: &Ray<f32>, extent: &Extent) -> Self {
        let bounds = &extent.bounds;
        let setup = InverseDirection::<f32>::of(ray);
        let least = setup.inv_dir.abs().min_element();
        let inv_dir = setup.inv_dir.abs().min(Vec3::splat(least * STEEPEST)).copysign(setup.inv_dir);
        let mut reach = ray.origin.abs() + bounds.lo.abs().max(bounds.hi.abs());
        if inv_dir != setup.inv_dir {
            // A capped axis must be left after the ray's longest axis.
            reach = Vec3::splat(reach.max_element());
        }
        let size = reach * inv_dir.abs();
        let (error, offset) = (size * ERROR + Vec3::splat(f32::MIN_POSITIVE), ray.origin * inv_dir);
        let sharp = reach.max_element() <= sharp_reach(extent);
        let valid = (size.x < LARGEST) & (size.y < LARGEST) & (size.z < LARGEST) & sharp;
        Self { setup, inv_dir, reach, near: -offset - error, far: error - offset, valid }
    }
}
