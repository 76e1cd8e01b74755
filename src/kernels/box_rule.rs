//! The box rule, which makes the closest hit of a tracer the same for every tree and every traversal.
//!
//! **Why:** a tree visits primitives in some order, and `t` is rounded. So an early hit can cull a box whose primitive
//! would have given a smaller `t`. Another tree, another order or a packet then gives another hit.
//!
//! **The rule:** a candidate counts if the kernel's own `t` lies in the ray's original interval, and if the ray hits
//! the primitive's own padded box ([`TInterval::of`](TInterval::<f32>::of)). Its `t` is then clamped into the interval
//! between entry and padded exit of that box ([`TInterval::clamp`](TInterval::<f32>::clamp)). Only the clamped `t` is
//! compared with the best so far. Between equal `t`, the lower number wins ([`Hit::is_closer_than`]).
//!
//! **What the tree must do:** the box of a node must be the exact union of the boxes below it. A node is culled only if
//! the slab test of this module misses its box, or if its entry is greater than the best `t`. A cheaper test may cull
//! too, if it is never stricter. `ARCHITECTURE.md` has the proof. For instances, the rule is applied in the object's
//! coordinates and once more with the instance's box in the world.
//!
//! **What it costs:** it is evaluated only for candidates that passed the primitive's test. It never removes a true
//! hit, unless a product overflows or underflows.
//!
//! ```
//! use glam::Vec3;
//! use raylanes::geom::{Hit, Ray, Triangle};
//! use raylanes::kernels::aabb::InverseDirection;
//! use raylanes::kernels::box_rule::TInterval;
//! use raylanes::kernels::{Intersect, Kernel, triangle::ExactHalfOpen};
//!
//! let triangle = Triangle { v0: Vec3::ZERO, v1: Vec3::X, v2: Vec3::Y };
//! let (prepared, bounds) = (ExactHalfOpen::prepare(&triangle), triangle.bounds());
//! let ray = Ray::new(Vec3::new(0.25, 0.25, 1.0), Vec3::NEG_Z);
//! let slabs = InverseDirection::<f32>::of(&ray); // once per ray
//!
//! let mut best = Hit::MISS;
//! let hit: Hit<f32> = prepared.hit(&ray); // for each primitive of a leaf
//! if hit.mask
//!     && let Some(interval) = TInterval::<f32>::of(&bounds.into(), ray.origin, &slabs)
//! {
//!     let candidate = Hit { t: interval.clamp(hit.t), primitive: 7, ..hit };
//!     if candidate.is_closer_than(&best) {
//!         best = candidate;
//!     }
//! }
//! assert_eq!((best.t, best.primitive), (1.0, 7));
//! ```
//!
//! [`Hit::is_closer_than`]: crate::geom::Hit::is_closer_than

use glam::Vec3;
use wide::f32x8;

use crate::geom::Candidate;
use crate::geom::lanes::{self, Lanes, Mask8, Vec3x8, gt8, le8, lt8};
use crate::kernels::aabb::{InverseDirection, Slabs, pad, pad8, slab_interval, slab_interval8};

/// Where a ray enters a box and where it leaves the padded box, clipped to the ray's own interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TInterval<L: Lanes> {
    /// The entry. A node whose entry is greater than the best `t` may be culled.
    pub entry: L,
    /// The padded exit.
    pub exit: L,
}

impl TInterval<f32> {
    /// The interval of a ray in a box; `None` if the ray misses the box.
    #[inline(always)]
    pub fn of(bounds: &Slabs<f32>, origin: Vec3, setup: &InverseDirection<f32>) -> Option<Self> {
        let (entry, exit) = slab_interval(bounds, origin, setup);
        let exit = pad(exit, setup.t_max);
        // An infinity on the wrong side is a distance that overflowed.
        ((entry <= exit) & (entry < f32::INFINITY) & (exit > f32::NEG_INFINITY)).then_some(Self { entry, exit })
    }

    /// The number in the interval that is nearest to `t`. `t` must not be NaN.
    #[inline(always)]
    pub fn clamp(&self, t: f32) -> f32 {
        // If they differ only in the sign of zero, `t` is kept.
        lanes::min(self.exit, lanes::max(self.entry, t))
    }
}

impl TInterval<f32x8> {
    /// [`TInterval::<f32>::of`] in eight lanes: the lanes that hit the box, and the intervals there.
    #[inline(always)]
    pub fn of(bounds: &Slabs<f32>, origin: Vec3x8, setup: &InverseDirection<f32x8>) -> (Mask8, Self) {
        Self::of_each(&bounds.widen(), origin, setup)
    }

    /// [`TInterval::<f32>::of`] with a box for each lane.
    #[inline(always)]
    pub fn of_each(bounds: &Slabs<f32x8>, origin: Vec3x8, setup: &InverseDirection<f32x8>) -> (Mask8, Self) {
        let (entry, exit) = slab_interval8(bounds, origin, setup);
        let exit = pad8(exit, setup.t_max);
        let hit =
            le8(entry, exit) & lt8(entry, f32x8::splat(f32::INFINITY)) & gt8(exit, f32x8::splat(f32::NEG_INFINITY));
        (hit, Self { entry, exit })
    }

    /// [`TInterval::<f32>::clamp`] in eight lanes.
    #[inline(always)]
    pub fn clamp(&self, t: f32x8) -> f32x8 {
        lanes::min8(self.exit, lanes::max8(self.entry, t))
    }
}

/// Applies the rule to the candidates of one ray and eight primitives, or of eight rays and one primitive. `bounds` are
/// the primitives' own boxes.
#[inline(always)]
pub fn apply8(
    candidate: Candidate<f32x8>,
    bounds: &Slabs<f32x8>,
    origin: Vec3x8,
    setup: &InverseDirection<f32x8>,
) -> Candidate<f32x8> {
    let (inside, interval) = TInterval::<f32x8>::of_each(bounds, origin, setup);
    candidate.narrowed(inside, interval.clamp(candidate.t()))
}
