//! One ray, scalar arithmetic, one box at a time: the reference for all other walks.

use super::counter::Counter;
use super::stack::StackStorage;
use crate::geom::lanes;
use crate::geom::{Hit, Ray};
use crate::kernels::aabb::{InverseDirection, pad, slab_interval};
use crate::tracer::bvh::{Bvh, Child};

/// A child to visit, and where the ray enters its box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StackEntry {
    entry: f32,
    child: Child,
}

impl StackEntry {
    pub(crate) const EMPTY: Self = Self { entry: 0.0, child: Child::NONE };
}

impl Bvh {
    /// Returns the closest of `best` and all hits in the leaves, by [`Hit::is_closer_than`]. With `ANY`, returns as
    /// soon as `best` is a hit.
    ///
    /// `test` gets a leaf and the best hit so far, and replaces it by a closer one. The walk may skip a leaf whose box
    /// the ray misses, or enters strictly beyond the best hit.
    #[inline(always)]
    pub(crate) fn walk_scalar<const ANY: bool, T: Counter>(
        &self,
        ray: &Ray<f32>,
        setup: &InverseDirection<f32>,
        mut best: Hit<f32>,
        storage: &mut StackStorage<StackEntry>,
        counter: &mut T,
        mut test: impl FnMut(usize, &mut Hit<f32>, &mut T),
    ) -> Hit<f32> {
        let mut stack = storage.stack();
        let mut next = Some(StackEntry { entry: f32::NEG_INFINITY, child: self.root });
        while let Some(StackEntry { entry, child }) = next {
            // A box beyond the best hit holds no winner. At equal distance a lower number may still win.
            if ANY || entry <= best.t {
                match child.leaf() {
                    Err(number) => {
                        counter.node();
                        let limit = lanes::min(best.t, setup.t_max);
                        let node = &self.nodes[number];
                        stack.make_room();
                        let base = stack.len();
                        for (slot, &child) in node.children.iter().enumerate() {
                            let (entry, exit) = slab_interval(&node.boxes.lane(slot), ray.origin, setup);
                            let (entry, hit) = (StackEntry { entry, child }, entry <= pad(exit, limit));
                            if ANY {
                                stack.push_if(entry, hit);
                            } else if hit {
                                stack.insert_above(base, entry, |below, new| below.entry < new.entry);
                            }
                        }
                    }
                    Ok(leaf) => {
                        counter.leaf();
                        test(leaf, &mut best, counter);
                        if ANY && best.mask {
                            return best;
                        }
                    }
                }
            }
            next = stack.pop();
        }
        best
    }
}
