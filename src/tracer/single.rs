//! Walking a tree with one ray, which is tested against eight boxes at a time.
//!
//! Tried and not kept (Zen 4, shared machine, differences below 10 % are noise): children put on the stack in the order of the
//! ray's octant, with neither branch nor comparison, instead of sorted: 0.98 to 1.08 times the speed on incoherent rays, 0.55 to
//! 0.76 times on primary rays. Prefetching leaves when they are put on the stack, which needs `unsafe`: 1.03 to 1.10 times.

use glam::Vec3;
use wide::f32x8;

use super::bvh::{Boxes, Bvh, Child};
use super::stack::Places;
use super::tally::Tally;
use crate::geom::lanes::{self, Vec3x8, le8, max8, min8};
use crate::geom::{Aabb, Hit, Ray};
use crate::kernels::aabb::{InverseDirection, pad8, slab_interval8};

/// How much the error of `plane·inv - origin·inv` can be, by `(|origin| + largest |plane|)·|inv|`: less than 6ε, ε = 2⁻²⁴,
/// against the monotonic `(plane - origin)·inv`, and another 8ε for the padding of exits. Times 16ε covers both, with what
/// the products of the bound itself lose. What underflows is covered by [`f32::MIN_POSITIVE`].
pub(super) const ERROR: f32 = 1.0 / 1_048_576.0;
/// Beyond this size of `(|origin| + largest |plane|)·|inv|` products may overflow.
pub(super) const LARGEST: f32 = 1e30;
/// How many times an inverse direction may be the least of the three. Where the direction is zero, or nearly so, a finite one
/// serves to cull as well: near planes are reached before they truly are, and far ones so late that the axis along which the
/// ray is longest has left the tree before.
pub(super) const STEEPEST: f32 = 1.152_921_5e18;

/// A ray's part in the fused slab test.
pub(super) struct Fused {
    pub(super) setup: InverseDirection<f32>,
    /// No component is more than [`STEEPEST`] times the least.
    pub(super) inv_dir: Vec3,
    /// `|origin| + largest |plane|`.
    pub(super) reach: Vec3,
    /// `-origin·inv`, moved out by the error bound: for near planes.
    pub(super) near: Vec3,
    /// The same, for far planes.
    pub(super) far: Vec3,
    /// Whether the bounds hold.
    pub(super) valid: bool,
}

impl Fused {
    /// For a tree within `bounds`.
    #[inline(always)]
    pub(super) fn of(ray: &Ray<f32>, bounds: &Aabb) -> Self {
        let setup = InverseDirection::<f32>::of(ray);
        let least = setup.inv_dir.abs().min_element();
        let inv_dir = setup.inv_dir.abs().min(Vec3::splat(least * STEEPEST)).copysign(setup.inv_dir);
        let mut reach = ray.origin.abs() + bounds.lo.abs().max(bounds.hi.abs());
        if inv_dir != setup.inv_dir {
            // So that the axis along which the ray is longest leaves the tree first indeed.
            reach = Vec3::splat(reach.max_element());
        }
        let size = reach * inv_dir.abs();
        let (error, offset) = (size * ERROR + Vec3::splat(f32::MIN_POSITIVE), ray.origin * inv_dir);
        // False for NaN.
        let valid = (size.x < LARGEST) & (size.y < LARGEST) & (size.z < LARGEST);
        Self { setup, inv_dir, reach, near: -offset - error, far: error - offset, valid }
    }
}

/// What is computed once per ray.
#[derive(Clone, Copy)]
pub(super) struct SingleRay {
    /// Eight times the same.
    pub(super) origin: Vec3x8,
    /// Eight times the same.
    pub(super) slabs: InverseDirection<f32x8>,
    inv_dir: [f32x8; 3],
    /// `-origin·inv`, moved out by the error bound: for near planes.
    near: [f32x8; 3],
    /// The same, for far planes.
    far: [f32x8; 3],
    /// Which plane is the near one.
    side: [usize; 3],
    /// Whether the bounds above hold.
    fused: bool,
    t_max: f32,
}

impl SingleRay {
    /// For a tree within `bounds`.
    #[inline(always)]
    pub(super) fn of(ray: &Ray<f32>, bounds: &Aabb) -> Self {
        let Fused { setup, inv_dir, near, far, valid, .. } = Fused::of(ray, bounds);
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
            side: setup.inv_dir.to_array().map(|inv| usize::from(lanes::sign_bit(inv))),
            fused: valid,
            t_max: setup.t_max,
        }
    }

    /// Where the ray enters eight boxes, at most, and which it may hit at or before `limit`: never fewer than by the slab test
    /// of the box rule, which is monotonic, but takes longer.
    #[inline(always)]
    pub(super) fn boxes(&self, boxes: &Boxes, limit: f32) -> (f32x8, u32) {
        let limit = f32x8::splat(limit);
        if self.fused {
            let near = |axis| boxes.near(axis, self.side).mul_add(self.inv_dir[axis], self.near[axis]);
            let far = |axis| boxes.far(axis, self.side).mul_add(self.inv_dir[axis], self.far[axis]);
            let entry = max8(max8(near(0), near(1)), max8(near(2), self.slabs.t_min));
            let exit = min8(min8(far(0), far(1)), min8(far(2), limit));
            (entry, le8(entry, exit).bits())
        } else {
            let (entry, exit) = slab_interval8(&boxes.slabs(), self.origin, &self.slabs);
            (entry, le8(entry, pad8(exit, limit)).bits())
        }
    }
}

/// Where the ray enters a box at the earliest, and what is in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Visit {
    entry: f32,
    child: Child,
}

pub(super) const ANYTHING: Visit = Visit { entry: 0.0, child: Child::NONE };

/// What is in the leaves. Not two closures: those that are called from two places are not inlined, and a call in the middle of
/// the walk costs as much as a node, since no register survives it.
pub(super) trait Leaves<T> {
    /// Puts the closest hit in a leaf in the place of a best one that it comes before.
    fn closest_hit(&mut self, leaf: usize, best: &mut Hit<f32>, tally: &mut T);
    /// Whether anything in a leaf is hit.
    fn any_hit(&mut self, leaf: usize, tally: &mut T) -> bool;
}

impl Bvh {
    /// [`Bvh::closest_hit_scalar`] below `root`.
    #[inline(always)]
    pub(super) fn closest_hit_single<T: Tally>(
        &self,
        root: Child,
        ray: &SingleRay,
        mut best: Hit<f32>,
        places: &mut Places<Visit>,
        tally: &mut T,
        leaves: &mut impl Leaves<T>,
    ) -> Hit<f32> {
        let mut stack = places.stack();
        let mut child = root;
        loop {
            match child.leaf() {
                Err(number) => {
                    tally.node();
                    let node = &self.nodes[number];
                    let (entry, mut hit) = ray.boxes(&node.boxes, lanes::min(best.t, ray.t_max));
                    let entry = entry.to_array();
                    stack.make_room();
                    let base = stack.len();
                    while hit != 0 {
                        let slot = hit.trailing_zeros() as usize & 7;
                        hit &= hit - 1;
                        let visit = Visit { entry: entry[slot], child: node.children[slot] };
                        stack.insert_above(base, visit, |below, visit| below.entry < visit.entry);
                    }
                }
                Ok(leaf) => {
                    tally.leaf();
                    leaves.closest_hit(leaf, &mut best, tally);
                }
            }
            // Beyond the best hit nothing can win; what is as near still can, by a lower number.
            child = loop {
                match stack.pop() {
                    Some(visit) if visit.entry <= best.t => break visit.child,
                    Some(_) => {}
                    None => return best,
                }
            };
        }
    }

    /// [`Bvh::any_hit_scalar`] below `root`.
    #[inline(always)]
    pub(super) fn any_hit_single<T: Tally>(
        &self,
        root: Child,
        ray: &SingleRay,
        places: &mut Places<Visit>,
        tally: &mut T,
        leaves: &mut impl Leaves<T>,
    ) -> bool {
        let mut stack = places.stack();
        let mut child = root;
        loop {
            match child.leaf() {
                Err(number) => {
                    tally.node();
                    let node = &self.nodes[number];
                    let (_, mut hit) = ray.boxes(&node.boxes, ray.t_max);
                    stack.make_room();
                    while hit != 0 {
                        let slot = hit.trailing_zeros() as usize & 7;
                        hit &= hit - 1;
                        stack.push_if(Visit { entry: 0.0, child: node.children[slot] }, true);
                    }
                }
                Ok(leaf) => {
                    tally.leaf();
                    if leaves.any_hit(leaf, tally) {
                        return true;
                    }
                }
            }
            match stack.pop() {
                Some(visit) => child = visit.child,
                None => return false,
            }
        }
    }
}
