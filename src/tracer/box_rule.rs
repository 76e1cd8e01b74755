//! The box rule, which [`crate::tracer`] states and proves, in both widths. It is applied twice: to triangles and their own
//! boxes, and to instances and theirs.

use glam::Vec3;
use wide::f32x8;

use crate::geom::lanes::{self, Lanes, Mask8, Vec3x8, gt8, le8, lt8};
use crate::kernels::aabb::{InverseDirection, Slabs, pad, pad8, slab_interval, slab_interval8};

/// Where a ray enters a box and leaves the padded one, clipped to the ray's interval.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span<L: Lanes> {
    pub(super) entry: L,
    pub(super) exit: L,
}

impl Span<f32> {
    /// `None` if the ray misses the box.
    #[inline(always)]
    pub(super) fn of(bounds: &Slabs<f32>, origin: Vec3, setup: &InverseDirection<f32>) -> Option<Self> {
        let (entry, exit) = slab_interval(bounds, origin, setup);
        let exit = pad(exit, setup.t_max);
        // An end at infinity on the wrong side is a distance that overflowed.
        ((entry <= exit) & (entry < f32::INFINITY) & (exit > f32::NEG_INFINITY)).then_some(Self { entry, exit })
    }

    /// The number in the span that is nearest to `t`, which is not NaN.
    #[inline(always)]
    pub(super) fn clamp(&self, t: f32) -> f32 {
        // Where they are equal but for the sign of zero, `t` stays as it is.
        lanes::min(self.exit, lanes::max(self.entry, t))
    }
}

impl Span<f32x8> {
    /// [`Span::<f32>::of`] in eight lanes: in which the ray hits the box, and the span there.
    #[inline(always)]
    pub(super) fn of(bounds: &Slabs<f32>, origin: Vec3x8, setup: &InverseDirection<f32x8>) -> (Mask8, Self) {
        Self::of_each(&bounds.widen(), origin, setup)
    }

    /// [`Span::<f32>::of`] with a box for each lane.
    #[inline(always)]
    pub(super) fn of_each(bounds: &Slabs<f32x8>, origin: Vec3x8, setup: &InverseDirection<f32x8>) -> (Mask8, Self) {
        let (entry, exit) = slab_interval8(bounds, origin, setup);
        let exit = pad8(exit, setup.t_max);
        let hit =
            le8(entry, exit) & lt8(entry, f32x8::splat(f32::INFINITY)) & gt8(exit, f32x8::splat(f32::NEG_INFINITY));
        (hit, Self { entry, exit })
    }

    /// [`Span::<f32>::clamp`] in eight lanes.
    #[inline(always)]
    pub(super) fn clamp(&self, t: f32x8) -> f32x8 {
        lanes::min8(self.exit, lanes::max8(self.entry, t))
    }
}
