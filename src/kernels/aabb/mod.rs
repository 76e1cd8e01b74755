//! Axis-aligned boxes by slabs. A slab is the space between two parallel planes, and a box is the intersection of
//! three slabs. A ray is inside the box where its three intervals between the planes overlap.
//!
//! Source of the method: T. L. Kay and J. T. Kajiya, "Ray Tracing Complex Scenes", 1986. A hit's `t` is the entry
//! distance and its `u` the exit distance, both clipped to the ray's interval. `hit.mask` is the textbook's yes or
//! no. Boxes are closed: a ray on the surface hits, and a flat box can be hit.
//!
//! The kernels differ for two kinds of rays. One runs parallel to a slab, with `0/0` or `0·∞` on its planes. The
//! other grazes an edge or a corner, where entry and exit differ only by rounding.

pub mod center_radius;
pub mod division;
#[cfg(any(fused, doc))]
pub mod fused;
pub mod padded;
pub mod reciprocal;
pub mod sign_selected;
pub mod two_ulp;

#[doc(inline)]
pub use center_radius::CenterRadius;
#[doc(inline)]
pub use division::Division;
#[cfg(any(fused, doc))]
#[doc(inline)]
pub use fused::Fused;
#[doc(inline)]
pub use padded::Padded;
pub(crate) use padded::{pad, pad8};
#[doc(inline)]
pub use reciprocal::Reciprocal;
#[doc(inline)]
pub use sign_selected::SignSelected;
#[doc(inline)]
pub use two_ulp::TwoUlp;

use glam::Vec3;
use wide::f32x8;

use crate::geom::lanes::{Lanes, Vec3x8, max, max8, min, min8, sign_bit, sign_bit8};
use crate::geom::{Aabb, Ray};
use crate::kernels::Operations;

prepared! {
    /// The corners of one box or of eight, 24 bytes a box. All slab kernels store them.
    pub struct Slabs<P: Lanes> {
        /// Least corners.
        pub lo: P::Vec3,
        /// Greatest corners.
        pub hi: P::Vec3,
    }
}

impl From<Aabb> for Slabs<f32> {
    fn from(Aabb { lo, hi }: Aabb) -> Self {
        Self { lo, hi }
    }
}

impl Slabs<f32> {
    fn prepare(shape: &Aabb) -> Self {
        shape.or_empty().into()
    }
}

/// The per-ray data of the kernels that multiply by the inverse direction.
///
/// A ray that misses everything (see [`Ray`]) gets an empty interval here. A slab test has no other way to notice a
/// NaN in the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InverseDirection<L: Lanes> {
    /// `1 / dir`, with `±∞` for `±0`.
    pub(crate) inv_dir: L::Vec3,
    /// Least `t` of the ray's interval, or of an empty one.
    pub(crate) t_min: L,
    /// Greatest `t` of the ray's interval, or of an empty one.
    pub(crate) t_max: L,
}

/// Operations of [`Ray::is_valid`].
pub(crate) const VALIDITY: Operations = Operations { mul: 6, add: 5, compare: 4, ..Operations::NONE };

impl InverseDirection<f32> {
    /// Operations of [`InverseDirection::of`].
    pub(crate) const OPERATIONS: Operations = VALIDITY.and(Operations { div: 3, ..Operations::NONE });

    /// The data of `ray`. Costs three divisions and the validity check.
    #[inline(always)]
    pub fn of(ray: &Ray<f32>) -> Self {
        let Interval { t_min, t_max } = Interval::<f32>::of(ray);
        Self { inv_dir: Vec3::new(1.0 / ray.dir.x, 1.0 / ray.dir.y, 1.0 / ray.dir.z), t_min, t_max }
    }
}

impl InverseDirection<f32x8> {
    /// [`InverseDirection::<f32>::of`] in eight lanes.
    #[inline(always)]
    pub fn of(ray: &Ray<f32x8>) -> Self {
        let Interval { t_min, t_max } = Interval::<f32x8>::of(ray);
        let one = f32x8::ONE;
        Self { inv_dir: Vec3x8 { x: one / ray.dir.x, y: one / ray.dir.y, z: one / ray.dir.z }, t_min, t_max }
    }
}

/// The ray's interval. It is empty for a ray that misses everything.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval<L: Lanes> {
    /// Least `t`.
    pub(super) t_min: L,
    /// Greatest `t`.
    pub(super) t_max: L,
}

impl Interval<f32> {
    #[inline(always)]
    fn of(ray: &Ray<f32>) -> Self {
        if ray.is_valid() {
            Self { t_min: ray.t_min, t_max: ray.t_max }
        } else {
            Self { t_min: f32::INFINITY, t_max: f32::NEG_INFINITY }
        }
    }
}

impl Interval<f32x8> {
    #[inline(always)]
    fn of(ray: &Ray<f32x8>) -> Self {
        let valid = ray.is_valid();
        Self {
            t_min: valid.select(ray.t_min, f32x8::splat(f32::INFINITY)),
            t_max: valid.select(ray.t_max, f32x8::splat(f32::NEG_INFINITY)),
        }
    }
}

/// Entry and exit distance, clipped to the ray's interval. The sign bit of the inverse direction chooses the near and
/// the far plane of each slab.
///
/// A NaN (`0·∞`: the ray runs in a plane of the slab) fails its comparison and drops out. Such a slab does not limit
/// the ray. `(plane - origin) * inv_dir` is monotonic in `plane` under rounding. So a box that contains another box
/// is never entered later or left earlier than it. The tracer's guarantee rests on that.
#[inline(always)]
pub(crate) fn slab_interval(slabs: &Slabs<f32>, origin: Vec3, setup: &InverseDirection<f32>) -> (f32, f32) {
    // Start with the ray's interval.
    let (mut entry, mut exit) = (setup.t_min, setup.t_max);
    for axis in 0..3 {
        let (lo, hi, inv) = (slabs.lo[axis], slabs.hi[axis], setup.inv_dir[axis]);
        // Choose the near and the far plane by the sign bit.
        let (near, far) = if sign_bit(inv) { (hi, lo) } else { (lo, hi) };

        // Compute the distances to both planes.
        let (t_near, t_far) = ((near - origin[axis]) * inv, (far - origin[axis]) * inv);

        // Cut the interval. A NaN drops out.
        entry = max(t_near, entry);
        exit = min(t_far, exit);
    }
    (entry, exit)
}

/// [`slab_interval`] in eight lanes.
#[inline(always)]
pub(crate) fn slab_interval8(slabs: &Slabs<f32x8>, origin: Vec3x8, setup: &InverseDirection<f32x8>) -> (f32x8, f32x8) {
    // Start with the ray's interval.
    let (mut entry, mut exit) = (setup.t_min, setup.t_max);
    for (lo, hi, origin, inv) in [
        (slabs.lo.x, slabs.hi.x, origin.x, setup.inv_dir.x),
        (slabs.lo.y, slabs.hi.y, origin.y, setup.inv_dir.y),
        (slabs.lo.z, slabs.hi.z, origin.z, setup.inv_dir.z),
    ] {
        // Choose the near and the far plane by the sign bit.
        let negative = sign_bit8(inv);
        let (near, far) = (negative.select(hi, lo), negative.select(lo, hi));

        // Compute the distances to both planes.
        let (t_near, t_far) = ((near - origin) * inv, (far - origin) * inv);

        // Cut the interval. A NaN drops out.
        entry = max8(t_near, entry);
        exit = min8(t_far, exit);
    }
    (entry, exit)
}
