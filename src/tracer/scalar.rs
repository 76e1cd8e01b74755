//! Walking a tree with one ray and scalar arithmetic: the reference for all other walks.

use super::bvh::{Bvh, Child};
use super::stack::Places;
use super::tally::Tally;
use crate::geom::lanes;
use crate::geom::{Hit, Ray};
use crate::kernels::aabb::{InverseDirection, pad, slab_interval};

/// Where the ray enters a box, and what is in it.
pub(super) type Visit = (f32, Child);

pub(super) const ANYTHING: Visit = (0.0, Child::NONE);

impl Bvh {
    /// The first of `best` and all hits that `test` finds in the leaves, by [`Hit::is_closer_than`]. `test` gets a leaf and
    /// the best hit so far, which it replaces by one that comes before it. Leaves whose boxes the ray misses, or enters
    /// strictly beyond the best hit, may be left out.
    #[inline(always)]
    pub(super) fn closest_hit_scalar<T: Tally>(
        &self,
        ray: &Ray<f32>,
        setup: &InverseDirection<f32>,
        mut best: Hit<f32>,
        places: &mut Places<Visit>,
        tally: &mut T,
        mut test: impl FnMut(usize, &mut Hit<f32>, &mut T),
    ) -> Hit<f32> {
        let mut stack = places.stack();
        let mut next = Some((f32::NEG_INFINITY, self.root));
        while let Some((entry, child)) = next {
            // Beyond the best hit nothing can win; what is as near still can, by a lower number.
            if entry <= best.t {
                match child.leaf() {
                    Err(number) => {
                        tally.node();
                        let limit = lanes::min(best.t, setup.t_max);
                        let node = &self.nodes[number];
                        stack.make_room();
                        let base = stack.len();
                        for (slot, &child) in node.children.iter().enumerate() {
                            let (entry, exit) = slab_interval(&node.boxes.lane(slot), ray.origin, setup);
                            if entry <= pad(exit, limit) {
                                stack.insert_above(base, (entry, child), |below, visit| below.0 < visit.0);
                            }
                        }
                    }
                    Ok(leaf) => {
                        tally.leaf();
                        test(leaf, &mut best, tally);
                    }
                }
            }
            next = stack.pop();
        }
        best
    }

    /// Whether `test` is true of any leaf. Leaves whose boxes the ray misses may be left out.
    #[inline(always)]
    pub(super) fn any_hit_scalar<T: Tally>(
        &self,
        ray: &Ray<f32>,
        setup: &InverseDirection<f32>,
        places: &mut Places<Visit>,
        tally: &mut T,
        mut test: impl FnMut(usize, &mut T) -> bool,
    ) -> bool {
        let mut stack = places.stack();
        let mut next = Some((0.0, self.root));
        while let Some((_, child)) = next {
            match child.leaf() {
                Err(number) => {
                    tally.node();
                    let node = &self.nodes[number];
                    stack.make_room();
                    for (slot, &child) in node.children.iter().enumerate() {
                        let (entry, exit) = slab_interval(&node.boxes.lane(slot), ray.origin, setup);
                        stack.push_if((entry, child), entry <= pad(exit, setup.t_max));
                    }
                }
                Ok(leaf) => {
                    tally.leaf();
                    if test(leaf, tally) {
                        return true;
                    }
                }
            }
            next = stack.pop();
        }
        false
    }
}
