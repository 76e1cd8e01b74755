//! Eight boxes as structure of arrays: one ray, or the bounds of many rays, is tested against all of them at once.

use glam::Vec3;
use wide::f32x8;

use super::leaf::Leaf;
use crate::geom::Aabb;
use crate::geom::lanes::Vec3x8;
use crate::kernels::aabb::Slabs;

/// Eight boxes. Unused ones are empty, and no ray hits them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Boxes {
    /// For each axis, the lower planes and the upper planes.
    pub(crate) planes: [[f32x8; 2]; 3],
}

impl Boxes {
    pub(crate) fn new(boxes: [Aabb; 8]) -> Self {
        let planes = [0, 1, 2]
            .map(|axis| [f32x8::new(boxes.map(|one| one.lo[axis])), f32x8::new(boxes.map(|one| one.hi[axis]))]);
        Self { planes }
    }

    /// The boxes of a leaf's items, empty in unused slots.
    pub(crate) fn of_items(leaf: &Leaf, bounds_of: impl Fn(u32) -> Aabb) -> Self {
        Self::new(leaf.0.map(|item| if item == Leaf::NONE { Aabb::EMPTY } else { bounds_of(item) }))
    }

    /// The boxes in eight lanes, for the slab test.
    #[inline(always)]
    pub(crate) fn slabs(&self) -> Slabs<f32x8> {
        let [x, y, z] = self.planes;
        Slabs { lo: Vec3x8 { x: x[0], y: y[0], z: z[0] }, hi: Vec3x8 { x: x[1], y: y[1], z: z[1] } }
    }

    /// The planes of an axis that rays reach first: the upper ones where `dir_is_neg[axis]` is 1, else the lower ones.
    #[inline(always)]
    pub(crate) fn near(&self, axis: usize, dir_is_neg: [usize; 3]) -> f32x8 {
        self.planes[axis][dir_is_neg[axis] & 1]
    }

    /// The planes of an axis that rays reach last.
    #[inline(always)]
    pub(crate) fn far(&self, axis: usize, dir_is_neg: [usize; 3]) -> f32x8 {
        self.planes[axis][dir_is_neg[axis] & 1 ^ 1]
    }

    /// The box in one lane.
    #[inline(always)]
    pub(crate) fn lane(&self, lane: usize) -> Slabs<f32> {
        let side = |side: usize| Vec3::from_array([0, 1, 2].map(|axis| self.planes[axis][side].as_array()[lane]));
        Slabs { lo: side(0), hi: side(1) }
    }

    /// A box around all eight.
    pub(crate) fn union(&self) -> Aabb {
        let side = |side: usize, start: f32, of: fn(f32, f32) -> f32| {
            Vec3::from_array([0, 1, 2].map(|axis| self.planes[axis][side].to_array().into_iter().fold(start, of)))
        };
        Aabb { lo: side(0, f32::INFINITY, f32::min), hi: side(1, f32::NEG_INFINITY, f32::max) }
    }
}

impl From<Slabs<f32x8>> for Boxes {
    #[inline(always)]
    fn from(Slabs { lo, hi }: Slabs<f32x8>) -> Self {
        Self { planes: [[lo.x, hi.x], [lo.y, hi.y], [lo.z, hi.z]] }
    }
}
