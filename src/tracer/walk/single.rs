//! One ray against the eight boxes of a node at a time: for rays that have little in common.
//!
//! Tried and not kept (Zen 4, shared machine, differences below 10 % are noise): children put on the stack in the order
//! of the ray's octant, with neither branch nor comparison, instead of sorted: 0.98 to 1.08 times the speed on
//! incoherent rays, 0.55 to 0.76 times on primary rays. Prefetching leaves when they are put on the stack, which needs
//! `unsafe`: 1.03 to 1.10 times.

use wide::f32x8;

use super::counter::Counter;
use super::fused_slabs::FusedSlabs;
use super::stack::StackStorage;
use crate::geom::lanes::{self, Vec3x8, le8, max8, min8};
use crate::geom::{Hit, Ray};
use crate::kernels::aabb::{InverseDirection, pad8, slab_interval8};
use crate::tracer::bvh::{Boxes, Bvh, Child, Extent};

/// Per-ray data of the walk, splatted to eight lanes.
#[derive(Clone, Copy)]
pub(crate) struct SingleRay {
    origin: Vec3x8,
    /// For the monotonic test, and for the box rule in leaves.
    pub(crate) slabs: InverseDirection<f32x8>,
    inv_dir: [f32x8; 3],
    /// Addends of near planes, from [`FusedSlabs::near`].
    near: [f32x8; 3],
    /// Addends of far planes, from [`FusedSlabs::far`].
    far: [f32x8; 3],
    /// For each axis, 1 if the upper plane is the near one.
    dir_is_neg: [usize; 3],
    /// Whether the fused test may be used.
    fused: bool,
    t_max: f32,
}

impl SingleRay {
    /// Prepares a ray for a tree of this extent.
    #[inline(always)]
    pub(crate) fn of(ray: &Ray<f32>, extent: &Extent) -> Self {
        let FusedSlabs { setup, inv_dir, near, far, valid, .. } = FusedSlabs::of(ray, extent);
        Self {
            origin: Vec3x8::splat(ray.origin),
            slabs: InverseDirection {
                inv_dir: Vec3x8::splat(setup.inv_dir),
                t_min: f32x8::splat(setup.t_min),
                t_max: f32x8::splat(setup.t_max),
            },
            inv_dir: inv_dir.to_array().map(f32x8::splat),
            near: near.to_array().map(f32x8::splat),
            far: far.to_array().map(f32x8::splat),
            dir_is_neg: setup.inv_dir.to_array().map(|inv| usize::from(lanes::sign_bit(inv))),
            fused: valid,
            t_max: setup.t_max,
        }
    }

    /// Tests eight boxes. Returns a lower bound of where the ray enters each, and a bit for each that it may hit at or
    /// before `limit`. Never stricter than the slab test of the box rule.
    #[inline(always)]
    pub(crate) fn boxes(&self, boxes: &Boxes, limit: f32) -> (f32x8, u32) {
        let limit = f32x8::splat(limit);
        if self.fused {
            let near = |axis| boxes.near(axis, self.dir_is_neg).mul_add(self.inv_dir[axis], self.near[axis]);
            let far = |axis| boxes.far(axis, self.dir_is_neg).mul_add(self.inv_dir[axis], self.far[axis]);
            let entry = max8(max8(near(0), near(1)), max8(near(2), self.slabs.t_min));
            let exit = min8(min8(far(0), far(1)), min8(far(2), limit));
            (entry, le8(entry, exit).bits())
        } else {
            let (entry, exit) = slab_interval8(&boxes.slabs(), self.origin, &self.slabs);
            (entry, le8(entry, pad8(exit, limit)).bits())
        }
    }
}

/// A child to visit, and a lower bound of where the ray enters its box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StackEntry {
    entry: f32,
    child: Child,
}

impl StackEntry {
    pub(crate) const EMPTY: Self = Self { entry: 0.0, child: Child::NONE };
}

/// What the walk does in a leaf. A trait and not a closure: a closure that is called from two places is not inlined. A
/// call inside the walk costs as much as a node, since no register survives it.
pub(crate) trait Leaves<T> {
    /// Replaces `best` by a closer hit of this leaf, if there is one; for rays that ask for any hit, by any hit.
    fn test(&mut self, leaf: usize, best: &mut Hit<f32>, counter: &mut T);
}

impl Bvh {
    /// [`Bvh::walk_scalar`] below `root`, with eight boxes at a time.
    #[inline(always)]
    pub(crate) fn walk_single<const ANY: bool, T: Counter>(
        &self,
        root: Child,
        ray: &SingleRay,
        mut best: Hit<f32>,
        storage: &mut StackStorage<StackEntry>,
        counter: &mut T,
        leaves: &mut impl Leaves<T>,
    ) -> Hit<f32> {
        let mut stack = storage.stack();
        let mut child = root;
        loop {
            match child.leaf() {
                Err(number) => {
                    counter.node();
                    let node = &self.nodes[number];
                    let limit = if ANY { ray.t_max } else { lanes::min(best.t, ray.t_max) };
                    let (entry, mut hit) = ray.boxes(&node.boxes, limit);
                    let entry = entry.to_array();
                    stack.make_room();
                    let base = stack.len();
                    while hit != 0 {
                        let slot = hit.trailing_zeros() as usize & 7;
                        hit &= hit - 1;
                        if ANY {
                            stack.push_if(StackEntry { entry: 0.0, child: node.children[slot] }, true);
                        } else {
                            let entry = StackEntry { entry: entry[slot], child: node.children[slot] };
                            stack.insert_above(base, entry, |below, new| below.entry < new.entry);
                        }
                    }
                }
                Ok(leaf) => {
                    counter.leaf();
                    leaves.test(leaf, &mut best, counter);
                    if ANY && best.mask {
                        return best;
                    }
                }
            }
            // A box beyond the best hit holds no winner. At equal distance a lower number may still win.
            child = loop {
                match stack.pop() {
                    Some(next) if ANY || next.entry <= best.t => break next.child,
                    Some(_) => {}
                    None => return best,
                }
            };
        }
    }
}
