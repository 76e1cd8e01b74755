//! Walking a tree with one ray, which is tested against eight boxes at a time.

use glam::Vec3;
use wide::f32x8;

use super::bvh8::{Boxes, Bvh8, Child};
use crate::geom::lanes::{self, Vec3x8, le8, max8, min8};
use crate::geom::{Aabb, Hit, Ray};
use crate::kernels::aabb::{InverseDirection, pad8, slab_interval8};

/// What is computed once per ray.
pub(super) struct SingleRay {
    /// Splat, for the slab test of the box rule.
    pub(super) origin: Vec3x8,
    /// Splat, for the slab test of the box rule.
    pub(super) slabs: InverseDirection<f32x8>,
    inv_dir: [f32x8; 3],
    near: [f32x8; 3],
    far: [f32x8; 3],
    /// Which of the planes is the near one.
    side: [usize; 3],
    octant: usize,
    fused: bool,
    pub(super) t_max: f32,
}

impl SingleRay {
    #[inline(always)]
    pub(super) fn of(ray: &Ray<f32>, bounds: &Aabb) -> Self {
        let setup = InverseDirection::<f32>::of(ray);
        let inv = setup.inv_dir;
        let reach = ray.origin.abs() + bounds.lo.abs().max(bounds.hi.abs());
        let size = reach * inv.abs();
        let fused = size.max_element() < 1e30 && setup.t_min <= setup.t_max;
        let error = size * (1.0 / 1_048_576.0) + Vec3::splat(f32::MIN_POSITIVE);
        let offset = ray.origin * inv;
        let side = inv.to_array().map(|inv| usize::from(lanes::sign_bit(inv)));
        Self {
            origin: Vec3x8::splat(ray.origin),
            slabs: InverseDirection {
                inv_dir: Vec3x8::splat(inv),
                t_min: f32x8::splat(setup.t_min),
                t_max: f32x8::splat(setup.t_max),
            },
            inv_dir: inv.to_array().map(f32x8::splat),
            near: (-offset - error).to_array().map(f32x8::splat),
            far: (error - offset).to_array().map(f32x8::splat),
            side,
            octant: side[0] | side[1] << 1 | side[2] << 2,
            fused,
            t_max: setup.t_max,
        }
    }

    #[inline(always)]
    fn boxes(&self, boxes: &Boxes, limit: f32) -> (f32x8, u32) {
        if self.fused {
            let plane = |axis: usize, far: usize| boxes.planes[axis][(self.side[axis] ^ far) & 1];
            let near = |axis: usize| plane(axis, 0).mul_add(self.inv_dir[axis], self.near[axis]);
            let far = |axis: usize| plane(axis, 1).mul_add(self.inv_dir[axis], self.far[axis]);
            let entry = max8(max8(near(0), near(1)), max8(near(2), self.slabs.t_min));
            let exit = min8(min8(far(0), far(1)), min8(far(2), f32x8::splat(limit)));
            (entry, le8(entry, exit).bits())
        } else {
            let (entry, exit) = slab_interval8(&boxes.slabs(), self.origin, &self.slabs);
            (entry, le8(entry, pad8(exit, f32x8::splat(limit))).bits())
        }
    }
}

#[derive(Clone, Copy)]
pub(super) struct Visit {
    entry: f32,
    child: Child,
}

pub(super) const ROOM: usize = 512;
pub(super) type Room = [Visit; ROOM];
pub(super) const EMPTY: Room = [Visit { entry: 0.0, child: Child::NONE }; ROOM];

impl Bvh8 {
    #[inline(always)]
    pub(super) fn closest_hit1(
        &self,
        ray: &SingleRay,
        mut best: Hit<f32>,
        room: &mut Room,
        mut test: impl FnMut(usize, &mut Hit<f32>),
    ) -> Hit<f32> {
        let mut top = 0;
        let mut child = self.root;
        loop {
            match child.leaf() {
                Err(number) => {
                    let node = &self.nodes[number];
                    let (entry, hit) = ray.boxes(&node.boxes, lanes::min(best.t, ray.t_max));
                    let entry = entry.to_array();
                    if BRANCHY {
                        let mut hit = hit;
                        let base = top;
                        while hit != 0 {
                            let slot = hit.trailing_zeros() as usize & 7;
                            hit &= hit - 1;
                            // insertion: nearest on top
                            let visit = Visit { entry: entry[slot], child: node.children[slot] };
                            let mut at = top;
                            while at > base && room[(at - 1) & (ROOM - 1)].entry < visit.entry {
                                room[at & (ROOM - 1)] = room[(at - 1) & (ROOM - 1)];
                                at -= 1;
                            }
                            room[at & (ROOM - 1)] = visit;
                            top += 1;
                        }
                    } else {
                        for index in (0..8).rev() {
                            let slot = index ^ ray.octant & 7;
                            room[top & (ROOM - 1)] = Visit { entry: entry[slot], child: node.children[slot] };
                            top += (hit >> slot & 1) as usize;
                        }
                    }
                }
                Ok(leaf) => test(leaf, &mut best),
            }
            loop {
                if top == 0 {
                    return best;
                }
                top -= 1;
                let visit = room[top & (ROOM - 1)];
                if visit.entry <= best.t {
                    child = visit.child;
                    break;
                }
            }
        }
    }

    #[inline(always)]
    pub(super) fn any_hit1(&self, ray: &SingleRay, room: &mut Room, mut test: impl FnMut(usize) -> bool) -> bool {
        let mut top = 0;
        let mut child = self.root;
        loop {
            match child.leaf() {
                Err(number) => {
                    let node = &self.nodes[number];
                    let (_, hit) = ray.boxes(&node.boxes, ray.t_max);
                    let mut hit = hit;
                    while hit != 0 {
                        let slot = hit.trailing_zeros() as usize & 7;
                        hit &= hit - 1;
                        room[top & (ROOM - 1)].child = node.children[slot];
                        top += 1;
                    }
                }
                Ok(leaf) => {
                    if test(leaf) {
                        return true;
                    }
                }
            }
            if top == 0 {
                return false;
            }
            top -= 1;
            child = room[top & (ROOM - 1)].child;
        }
    }
}
const BRANCHY: bool = false;
