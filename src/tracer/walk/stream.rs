//! A stream: many rays of one octant that need have nothing else in common.
//!
//! A node takes the list of rays that may hit it and makes a list for each of its children. Rays that start near each
//! other share most of their nodes, in whatever direction they run, so nearly all lists are long. The tests of
//! different rays are independent: none waits for the result of another, as consecutive tests of a single ray do.
//!
//! **Source:** J. Tsakok, "Faster Incoherent Rays: Multi-BVH Ray Stream Tracing", 2009. Order and lists: R. Barringer,
//! T. Akenine-Möller, "Dynamic Ray Stream Traversal", 2014. Here, long lists test eight rays against one box at a time,
//! short lists one ray against eight boxes, and children are visited in the order of the octant.
//!
//! Tried and not kept (Zen 4, shared machine, differences below 10 % are noise):
//!
//! - Lists that also hold the entry distances, filled one ray at a time: 0.6 to 0.9 times the speed on incoherent rays.
//! - Streams of rays that also share their longest axis, which saves the watertight test its branches: 0.7 to 1.1.
//! - Streams of half as many rays: 0.93 to 1.0. Twice as many: 0.97 to 1.04.
//! - Prefetching the next one to three nodes and leaves: 0.8 to 1.2. Huge pages from the allocator: 0.8 to 1.2.

use wide::{f32x8, u8x16};

use super::counter::Counter;
use super::fused_slabs::{ERROR, FusedSlabs};
use super::rays::dir_is_neg;
use super::stack::StackStorage;
use crate::geom::Ray;
use crate::geom::lanes::{le8, max8, min8};
use crate::tracer::bvh::{Bvh, Child, Extent, Node};

/// Largest number of rays in a stream. A power of two.
pub(crate) const RAYS: usize = 4096;
/// Lists of at least this length test eight rays at a time; shorter ones, one ray against eight boxes.
pub(crate) const MIN_WIDE_RAYS: usize = 4;

/// Per-ray data in the order of the lanes: inverse direction (3); distance of the near and far addends, relative to the
/// inverse direction (1); addends of near planes (3); largest useful `t`, NaN if the search has ended (1).
/// [`super::fused_slabs`] explains the addends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StreamRay(f32x8);

impl StreamRay {
    const EMPTY: Self = Self(f32x8::ZERO);

    /// Prepares a ray for a tree of this extent; `None` if it must walk alone, because its error bounds do not hold or
    /// are too large.
    #[inline(always)]
    pub(crate) fn of(ray: &Ray<f32>, extent: &Extent) -> Option<Self> {
        let FusedSlabs { setup, inv_dir: inv, reach, near, valid, .. } = FusedSlabs::of(ray, extent);
        // Twice the error bound, and an eighth more for the rounding of the sum.
        let apart = reach.max_element() * (2.25 * ERROR);
        // The error bound must not underflow.
        (valid & (apart * inv.abs().min_element() > 1e-36))
            .then(|| Self(f32x8::new([inv.x, inv.y, inv.z, apart, near.x, near.y, near.z, setup.t_max])))
    }

    /// The largest useful `t`; NaN if the search has ended.
    #[inline(always)]
    pub(crate) fn limit(&self) -> f32 {
        self.0.as_array()[7]
    }

    /// Sets the largest useful `t`; NaN ends the search.
    #[inline(always)]
    pub(crate) fn set_limit(&mut self, limit: f32) {
        self.0.as_mut_array()[7] = limit;
    }
}

/// A child to visit, and the range of its list of rays.
#[derive(Clone, Copy, Debug)]
struct StackEntry {
    child: Child,
    start: u32,
    len: u32,
}

/// Memory for a stream's rays, lists and stack, reused from walk to walk.
#[derive(Debug)]
pub(crate) struct StreamScratch {
    /// The rays by their numbers.
    pub(crate) rays: Box<[StreamRay; RAYS]>,
    lists: Vec<u16>,
    stack: StackStorage<StackEntry>,
}

impl StreamScratch {
    pub(crate) fn new() -> Self {
        Self {
            rays: Box::new([StreamRay::EMPTY; RAYS]),
            lists: vec![0; 64 * RAYS],
            stack: StackStorage::new(StackEntry { child: Child::NONE, start: 0, len: 0 }),
        }
    }
}

/// What the walk does in a leaf.
pub(crate) trait Leaves<T> {
    /// Tests the rays with these numbers and updates their limits.
    fn test(&mut self, leaf: usize, numbers: &[u16], rays: &mut [StreamRay; RAYS], counter: &mut T);
}

impl Bvh {
    /// Visits the leaves that the rays with these numbers may hit. Their directions are in `octant`, their
    /// [`StreamRay`]s are in `scratch.rays`, and none has a `t_min` below `t_min`.
    #[inline(always)]
    pub(crate) fn walk_stream<const ANY: bool, T: Counter>(
        &self,
        octant: usize,
        numbers: &[u16],
        t_min: f32,
        scratch: &mut StreamScratch,
        counter: &mut T,
        leaves: &mut impl Leaves<T>,
    ) {
        let (dir_is_neg, first) = (dir_is_neg(octant), if ANY { octant } else { octant ^ 7 });
        let StreamScratch { rays, lists, stack } = scratch;
        lists[..numbers.len()].copy_from_slice(numbers);
        let mut stack = stack.stack();
        let mut next = StackEntry { child: self.root, start: 0, len: numbers.len() as u32 };
        loop {
            let (start, len) = (next.start as usize, next.len as usize);
            match next.child.leaf() {
                Err(number) => {
                    counter.node();
                    let node = &self.nodes[number];
                    // A list is written eight numbers at a time, so it needs room for eight more. Lists above this one
                    // belong to children that have been visited.
                    let (base, room) = (start + len + 8, len + 8);
                    if lists.len() < base + 8 * room {
                        lists.resize(2 * (base + 8 * room), 0);
                    }
                    let (list, above) = lists[start..base + 8 * room].split_at_mut(len + 8);
                    // The child that is pushed last is visited first.
                    let mut ends: [usize; 8] = std::array::from_fn(|slot| (slot ^ first & 7) * room);
                    if len < MIN_WIDE_RAYS {
                        test_short(node, &list[..len], rays, dir_is_neg, t_min, &mut ends, above);
                    } else {
                        test_long(node, list, rays, dir_is_neg, t_min, &mut ends, above);
                    }
                    stack.make_room();
                    for index in 0..8 {
                        let slot = index ^ first & 7;
                        let (start, len) = (base + index * room, ends[slot] - index * room);
                        let next = StackEntry { child: node.children[slot], start: start as u32, len: len as u32 };
                        stack.push_if(next, len != 0);
                    }
                }
                Ok(leaf) => {
                    counter.leaf();
                    leaves.test(leaf, &lists[start..start + len], rays, counter);
                }
            }
            let Some(top) = stack.pop() else { return };
            next = top;
        }
    }
}

/// Appends each ray to the lists of the boxes that it may hit, one ray at a time.
#[inline(always)]
fn test_short(
    node: &Node,
    list: &[u16],
    rays: &[StreamRay; RAYS],
    dir_is_neg: [usize; 3],
    t_min: f32,
    ends: &mut [usize; 8],
    lists: &mut [u16],
) {
    let axes = [0, 1, 2];
    let (near_planes, far_planes) =
        (axes.map(|axis| node.boxes.near(axis, dir_is_neg)), axes.map(|axis| node.boxes.far(axis, dir_is_neg)));
    for &number in list {
        let ray = rays[usize::from(number) % RAYS].0.as_array();
        let inv = axes.map(|axis| f32x8::splat(ray[axis]));
        let near = axes.map(|axis: usize| near_planes[axis].mul_add(inv[axis], f32x8::splat(ray[axis + 4])));
        let far = axes.map(|axis: usize| {
            let offset = inv[axis].abs().mul_add(f32x8::splat(ray[3]), f32x8::splat(ray[axis + 4]));
            far_planes[axis].mul_add(inv[axis], offset)
        });
        let entry = max8(max8(near[0], near[1]), max8(near[2], f32x8::splat(t_min)));
        let exit = min8(min8(far[0], far[1]), min8(far[2], f32x8::splat(ray[7])));
        let mut hit = le8(entry, exit).bits();
        while hit != 0 {
            let slot = hit.trailing_zeros() as usize & 7;
            hit &= hit - 1;
            lists[ends[slot]] = number;
            ends[slot] += 1;
        }
    }
}

/// [`test_short`] for eight rays at a time. The list has eight unused numbers at its end.
#[inline(always)]
fn test_long(
    node: &Node,
    list: &[u16],
    rays: &[StreamRay; RAYS],
    dir_is_neg: [usize; 3],
    t_min: f32,
    ends: &mut [usize; 8],
    lists: &mut [u16],
) {
    let axes = [0, 1, 2];
    let (near_planes, far_planes) = (
        axes.map(|axis: usize| node.boxes.planes[axis][dir_is_neg[axis] & 1].as_array()),
        axes.map(|axis: usize| node.boxes.planes[axis][dir_is_neg[axis] & 1 ^ 1].as_array()),
    );
    let t_min = f32x8::splat(t_min);
    let mut left = list.len() - 8;
    for numbers in list.as_chunks::<8>().0 {
        let rows = numbers.map(|number| rays[usize::from(number) % RAYS].0);
        let [ix, iy, iz, apart, nx, ny, nz, limit] = f32x8::transpose(rows);
        let (inv, near) = ([ix, iy, iz], [nx, ny, nz]);
        let far = axes.map(|axis: usize| inv[axis].abs().mul_add(apart, near[axis]));
        let present = (1 << left.min(8)) - 1;
        let numbers = to_bytes(numbers);
        for slot in 0..8 {
            let near = axes.map(|axis: usize| f32x8::splat(near_planes[axis][slot]).mul_add(inv[axis], near[axis]));
            let far = axes.map(|axis: usize| f32x8::splat(far_planes[axis][slot]).mul_add(inv[axis], far[axis]));
            let entry = max8(max8(near[0], near[1]), max8(near[2], t_min));
            let exit = min8(min8(far[0], far[1]), min8(far[2], limit));
            let hit = le8(entry, exit).bits() & present;
            let end = ends[slot];
            let kept = numbers.shuffle(u8x16::new(KEEP[hit as usize % 256]));
            lists[end..end + 8].copy_from_slice(&of_bytes(kept));
            ends[slot] = end + hit.count_ones() as usize;
        }
        left = left.saturating_sub(8);
        if left == 0 {
            break;
        }
    }
}

/// For every subset of eight 16-bit numbers, the byte shuffle that moves the subset to the front.
static KEEP: [[u8; 16]; 256] = {
    let mut table = [[0; 16]; 256];
    let mut set = 0;
    while set < 256 {
        let (mut number, mut at) = (0, 0);
        while number < 8 {
            if set >> number & 1 == 1 {
                table[set][at] = 2 * number;
                table[set][at + 1] = 2 * number + 1;
                at += 2;
            }
            number += 1;
        }
        set += 1;
    }
    table
};

#[inline(always)]
fn to_bytes(numbers: &[u16; 8]) -> u8x16 {
    let bytes = numbers.map(u16::to_le_bytes);
    u8x16::new(std::array::from_fn(|index| bytes[index / 2][index % 2]))
}

#[inline(always)]
fn of_bytes(bytes: u8x16) -> [u16; 8] {
    let bytes = bytes.to_array();
    std::array::from_fn(|index| u16::from_le_bytes([bytes[2 * index], bytes[2 * index + 1]]))
}
