//! Eight rays of one octant, for as long as they stay together: each of them is tested against every box of a node. A
//! ray that reaches a subtree alone walks it as a single ray.
//!
//! In a single mesh, `stream` shares more node visits and is 1.2 to 1.8 times as fast. Packets serve scenes with
//! instances, where eight rays enter an instance together, and callers that bring eight rays. With single rays instead,
//! a forest of instances was traced at 0.59 to 0.83 times the speed, and instances of quadrics at 0.30 to 0.52 times.
//!
//! **Source:** packets: I. Wald, P. Slusallek, C. Benthin, M. Wagner, "Interactive Rendering with Coherent Ray
//! Tracing", 2001. Single-ray fallback: C. Benthin, I. Wald, S. Woop, M. Ernst, W. Mark, "Combining Single and
//! Packet-Ray Tracing for Arbitrary Ray Distributions on the Intel MIC Architecture", 2012.
//!
//! Tried and not kept (Zen 4, shared machine, differences below 10 % are noise): children in the order of the distances
//! at which one of the rays enters them, instead of by octant: 4 to 10 % fewer nodes, and 0.83 to 1.02 times the speed
//! on closest hits. Single rays from two active lanes on, instead of one: 0.84 to 1.1 times. Sorting 64 rays by octant
//! instead of 256: 0.75 to 1.1 times.

use glam::Vec3;
use wide::f32x8;

use super::fused_slabs::{ERROR, LARGEST, STEEPEST, sharp_reach};
use super::rays::{dir_is_neg, only_lane};
use super::stack::StackStorage;
use crate::geom::lanes::{Mask8, le8, lt8, max8, min8, sign_bit8};
use crate::geom::{Candidate, Hit, Ray};
use crate::kernels::aabb::InverseDirection;
use crate::tracer::bvh::{Boxes, Bvh, Child, Extent};

/// Per-ray data of eight rays for the fused slab test: [`super::fused_slabs::FusedSlabs`] in eight lanes.
#[derive(Clone, Copy)]
pub(crate) struct PacketRays {
    inv_dir: [f32x8; 3],
    near: [f32x8; 3],
    far: [f32x8; 3],
    t_min: f32x8,
    /// Lanes in which the error bounds hold and are small enough. Only these can walk together.
    pub(crate) fused: Mask8,
    /// For each axis, the lanes whose direction has its sign bit set.
    negative: [Mask8; 3],
}

impl PacketRays {
    /// Prepares eight rays for a tree of this extent.
    #[inline(always)]
    pub(crate) fn of(ray: &Ray<f32x8>, setup: &InverseDirection<f32x8>, extent: &Extent) -> Self {
        let bounds = &extent.bounds;
        let inverse = [setup.inv_dir.x, setup.inv_dir.y, setup.inv_dir.z];
        let origin = [ray.origin.x, ray.origin.y, ray.origin.z];
        let planes: Vec3 = bounds.lo.abs().max(bounds.hi.abs());
        let size = inverse.map(f32x8::abs);
        let most = min8(min8(size[0], size[1]), size[2]) * f32x8::splat(STEEPEST);
        let capped = size.map(|size| min8(size, most));
        let mut reach = [0, 1, 2].map(|axis| origin[axis].abs() + f32x8::splat(planes[axis]));
        let steep = lt8(most, size[0]) | lt8(most, size[1]) | lt8(most, size[2]);
        if steep.any() {
            let greatest = max8(max8(reach[0], reach[1]), reach[2]);
            reach = reach.map(|reach| steep.select(greatest, reach));
        }
        let negative = inverse.map(sign_bit8);
        let inv_dir = [0, 1, 2].map(|axis: usize| negative[axis].select(-capped[axis], capped[axis]));
        let size = [0, 1, 2].map(|axis: usize| reach[axis] * capped[axis]);
        let error = size.map(|size| size * f32x8::splat(ERROR) + f32x8::splat(f32::MIN_POSITIVE));
        let offset = [0, 1, 2].map(|axis: usize| origin[axis] * inv_dir[axis]);
        let largest = f32x8::splat(LARGEST);
        let sharp = le8(max8(max8(reach[0], reach[1]), reach[2]), f32x8::splat(sharp_reach(extent)));
        Self {
            inv_dir,
            near: [0, 1, 2].map(|axis| -offset[axis] - error[axis]),
            far: [0, 1, 2].map(|axis| error[axis] - offset[axis]),
            t_min: setup.t_min,
            fused: lt8(size[0], largest) & lt8(size[1], largest) & lt8(size[2], largest) & sharp,
            negative,
        }
    }

    /// The octant of a lane's direction, and the mask of all lanes in that octant.
    #[inline(always)]
    pub(crate) fn octant(&self, lane: usize) -> (usize, Mask8) {
        let signs = self.negative.map(|negative| negative.bits() >> (lane & 7) & 1);
        let [x, y, z] = [0, 1, 2].map(|axis| if signs[axis] == 1 { self.negative[axis] } else { !self.negative[axis] });
        ((signs[0] | signs[1] << 1 | signs[2] << 2) as usize, x & y & z)
    }

    /// Tests one of eight boxes. Returns a lower bound of where each ray enters it, and the lanes that may hit it at or
    /// before `limit`. A lane whose limit is NaN hits nothing.
    #[inline(always)]
    pub(crate) fn enter(&self, boxes: &Boxes, slot: usize, dir_is_neg: [usize; 3], limit: f32x8) -> (f32x8, Mask8) {
        let plane = |planes: f32x8| f32x8::splat(planes.as_array()[slot & 7]);
        let near = |axis| plane(boxes.near(axis, dir_is_neg)).mul_add(self.inv_dir[axis], self.near[axis]);
        let far = |axis| plane(boxes.far(axis, dir_is_neg)).mul_add(self.inv_dir[axis], self.far[axis]);
        let entry = max8(max8(near(0), near(1)), max8(near(2), self.t_min));
        let exit = min8(min8(far(0), far(1)), min8(far(2), limit));
        (entry, le8(entry, exit))
    }
}

/// A child to visit, and where each ray enters its box at the earliest: NaN in lanes that miss the box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StackEntry {
    entry: f32x8,
    child: Child,
}

impl StackEntry {
    pub(crate) const EMPTY: Self = Self { entry: f32x8::ZERO, child: Child::NONE };
}

/// Rays of a packet that walk together.
enum RayGroup {
    /// At least one lane; the directions of all of them are in this octant.
    Lanes { octant: usize, lanes: Mask8 },
    /// One lane for which the fused test is not valid.
    Lane(usize),
}

/// Splits the active lanes of a packet into groups.
struct RayGroups<'a> {
    rays: &'a PacketRays,
    fused: Mask8,
    /// Lanes of `fused` that are still to come, as bits.
    remaining: u32,
    /// Other lanes that are still to come, as bits.
    remaining_single: u32,
}

impl<'a> RayGroups<'a> {
    #[inline(always)]
    fn new(rays: &'a PacketRays, active: Mask8) -> Self {
        let fused = active & rays.fused;
        let remaining = fused.bits();
        Self { rays, fused, remaining, remaining_single: active.bits() & !remaining }
    }
}

impl Iterator for RayGroups<'_> {
    type Item = RayGroup;

    #[inline(always)]
    fn next(&mut self) -> Option<RayGroup> {
        if self.remaining != 0 {
            let (octant, same) = self.rays.octant(self.remaining.trailing_zeros() as usize);
            let lanes = same & self.fused;
            self.remaining &= !lanes.bits();
            return Some(RayGroup::Lanes { octant, lanes });
        }
        (self.remaining_single != 0).then(|| {
            let lane = self.remaining_single.trailing_zeros() as usize;
            self.remaining_single &= self.remaining_single - 1;
            RayGroup::Lane(lane)
        })
    }
}

/// What the walk asks of the tree it walks: limits, leaf tests, single rays.
pub(crate) trait PacketSearch {
    /// The largest useful `t` of each lane; NaN in lanes whose search has ended.
    fn limit(&self) -> f32x8;
    /// Records the visit of a node.
    fn count_node(&mut self);
    /// Tests the content of a leaf, at least in the active lanes.
    fn test_leaf(&mut self, leaf: usize, active: Mask8);
    /// Traces one lane through the subtree of `child`.
    fn trace_single(&mut self, child: Child, lane: usize);
}

impl Bvh {
    /// Visits the leaves that the rays may hit, one group of rays after the other.
    #[inline(always)]
    pub(crate) fn walk_packet<const ANY: bool>(
        &self,
        ray: &Ray<f32x8>,
        setup: &InverseDirection<f32x8>,
        storage: &mut StackStorage<StackEntry>,
        search: &mut impl PacketSearch,
    ) {
        let rays = PacketRays::of(ray, setup, &self.extent);
        for group in RayGroups::new(&rays, le8(setup.t_min, search.limit())) {
            match group {
                RayGroup::Lanes { octant, lanes } => self.walk_group::<ANY>(&rays, octant, lanes, storage, search),
                RayGroup::Lane(lane) => search.trace_single(self.root, lane),
            }
        }
    }

    /// Visits the leaves that the rays of one group may hit, the nearest children first.
    ///
    /// With `ANY` the farthest children come first: such rays mostly start on surfaces that they do not hit (0.64 times
    /// the nodes on shadow rays in a closed room).
    #[inline(always)]
    fn walk_group<const ANY: bool>(
        &self,
        rays: &PacketRays,
        octant: usize,
        lanes: Mask8,
        storage: &mut StackStorage<StackEntry>,
        search: &mut impl PacketSearch,
    ) {
        let mut stack = storage.stack();
        let miss = f32x8::splat(f32::NAN);
        let (dir_is_neg, first) = (dir_is_neg(octant), if ANY { octant } else { octant ^ 7 });
        let (mut child, mut active) = (self.root, lanes);
        loop {
            let bits = active.bits();
            if bits.count_ones() > 1 {
                match child.leaf() {
                    Err(number) => {
                        search.count_node();
                        let node = &self.nodes[number];
                        // NaN, not -∞: a ray whose `t_min` is -∞ would still pass.
                        let limit = active.select(search.limit(), miss);
                        stack.make_room();
                        // The child that is pushed last is visited first.
                        for index in 0..8 {
                            let slot = index ^ first & 7;
                            let (entry, hit) = rays.enter(&node.boxes, slot, dir_is_neg, limit);
                            let next = StackEntry { entry: hit.select(entry, miss), child: node.children[slot] };
                            stack.push_if(next, hit.any());
                        }
                    }
                    Ok(leaf) => search.test_leaf(leaf, active),
                }
            } else if bits != 0 {
                search.trace_single(child, bits.trailing_zeros() as usize);
            }
            let Some(next) = stack.pop() else { return };
            // A box beyond the best hit holds no winner. At equal distance a lower number may still win.
            (child, active) = (next.child, le8(next.entry, search.limit()));
        }
    }
}

/// What the rays of a packet have hit so far.
pub(crate) struct PacketHits<const ANY: bool> {
    /// The largest useful `t` of each lane; NaN in lanes whose search has ended.
    pub(crate) limit: f32x8,
    /// The closest hits. Unused with `ANY`.
    pub(crate) best: Hit<f32x8>,
    /// Lanes that have hit anything. Used only with `ANY`.
    any: Mask8,
}

impl<const ANY: bool> PacketHits<ANY> {
    /// Starts with these best hits; a hit beyond `best` or `t_max` is of no use.
    #[inline(always)]
    pub(crate) fn new(best: Hit<f32x8>, t_max: f32x8) -> Self {
        Self { limit: min8(best.t, t_max), best, any: Mask8::none() }
    }

    /// Keeps a candidate where it is closer; with `ANY`, ends the search where it hits.
    #[inline(always)]
    pub(crate) fn keep(&mut self, candidate: &Candidate<f32x8>) {
        if ANY {
            self.end_in(candidate.mask());
        } else {
            self.best.keep_closer(candidate);
            self.limit = min8(self.best.t, self.limit);
        }
    }

    /// Ends the search in these lanes: each has hit something.
    #[inline(always)]
    pub(crate) fn end_in(&mut self, lanes: Mask8) {
        self.any = self.any | lanes;
        self.limit = lanes.select(f32x8::splat(f32::NAN), self.limit);
    }

    /// Ends the search in one lane.
    #[inline(always)]
    pub(crate) fn end_in_lane(&mut self, lane: usize) {
        self.end_in(only_lane(lane));
    }

    /// The closest hits; with `ANY`, hits whose fields are zero.
    #[inline(always)]
    pub(crate) fn into_hits(self) -> Hit<f32x8> {
        let nothing = f32x8::ZERO;
        if ANY { Candidate::<f32x8>::new(self.any, nothing, nothing, nothing).or_miss() } else { self.best }
    }
}
