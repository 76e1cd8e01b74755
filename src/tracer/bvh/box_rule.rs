//! The box rule in both widths: where a ray enters and leaves a box, and the clamping of `t` into that interval.
//!
//! The rule is applied to triangles with their own boxes, and again to instances with their world boxes.
//! `ARCHITECTURE.md` proves why it makes the closest hit independent of the traversal.

use glam::Vec3;
use wide::f32x8;

use crate::geom::lanes::{self, Lanes, Mask8, Vec3x8, gt8, le8, lt8};
use crate::kernels::aabb::{InverseDirection, Slabs, pad, pad8, slab_interval, slab_interval8};

/// Where a ray enters a box and where it leaves the padded box, clipped to the ray's own interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TInterval<L: Lanes> {
    pub(crate) entry: L,
    pub(crate) exit: L,
}

impl TInterval<f32> {
    /// The interval of a ray in a box; `None` if the ray misses the box.
    #[inline(always)]
    pub(crate) fn of(bounds: &Slabs<f32>, origin: Vec3, setup: &InverseDirection<f32>) -> Option<Self> {
        let (entry, exit) = slab_interval(bounds, origin, setup);
        let exit = pad(exit, setup.t_max);
        // An infinity on the wrong side is a distance that overflowed.
        ((entry <= exit) & (entry < f32::INFINITY) & (exit > f32::NEG_INFINITY)).then_some(Self { entry, exit })
    }

    /// The number in the interval that is nearest to `t`. `t` must not be NaN.
    #[inline(always)]
    pub(crate) fn clamp(&self, t: f32) -> f32 {
        // If they differ only in the sign of zero, `t` is kept.
        lanes::min(self.exit, lanes::max(self.entry, t))
    }
}

impl TInterval<f32x8> {
    /// [`TInterval::<f32>::of`] in eight lanes: the lanes that hit the box, and the intervals there.
    #[inline(always)]
    pub(crate) fn of(bounds: &Slabs<f32>, origin: Vec3x8, setup: &InverseDirection<f32x8>) -> (Mask8, Self) {
        Self::of_each(&bounds.widen(), origin, setup)
    }

    /// [`TInterval::<f32>::of`] with a box for each lane.
    #[inline(always)]
    pub(crate) fn of_each(bounds: &Slabs<f32x8>, origin: Vec3x8, setup: &InverseDirection<f32x8>) -> (Mask8, Self) {
        let (entry, exit) = slab_interval8(bounds, origin, setup);
        let exit = pad8(exit, setup.t_max);
        let hit =
            le8(entry, exit) & lt8(entry, f32x8::splat(f32::INFINITY)) & gt8(exit, f32x8::splat(f32::NEG_INFINITY));
        (hit, Self { entry, exit })
    }

    /// [`TInterval::<f32>::clamp`] in eight lanes.
    #[inline(always)]
    pub(crate) fn clamp(&self, t: f32x8) -> f32x8 {
        lanes::min8(self.exit, lanes::max8(self.entry, t))
    }
}
