//! Walking a tree with a stream: many rays whose directions have the same signs, which need have nothing else in common.
//!
//! A node takes the list of rays that may hit it and leaves a list for each of its children. Rays that start near each other
//! share most of their nodes, whichever way they run, so that nearly all lists are long, and what happens to one ray waits for
//! nothing that happens to another: no test waits for the one before, as it does when one ray walks alone.
//!
//! **Source:** J. Tsakok, "Faster Incoherent Rays: Multi-BVH Ray Stream Tracing", 2009; order and lists: R. Barringer,
//! T. Akenine-Möller, "Dynamic Ray Stream Traversal", 2014. Here, long lists take eight rays against one box at a time, short
//! ones one ray against eight boxes, and the children are visited in the order of the octant.
//!
//! Tried and not kept (Zen 4, shared machine, differences below 10 % are noise): lists of rays with the distances at which they
//! enter, put down one by one: 0.6 to 0.9 times the speed on incoherent rays. Streams of rays that also have their longest axis
//! in common, which saves the watertight test its branches: 0.7 to 1.1 times. Streams of half as many rays, or twice as many: 0.93
//! to 1.0, and 0.97 to 1.04 times. Prefetching the next one to three of the nodes and
//! leaves to visit: 0.8 to 1.2 times. Huge pages, asked for by the allocator: 0.8 to 1.2 times.

use wide::{f32x8, u8x16};

use super::bvh::{Bvh, Child, Node};
use super::packet::sides;
use super::single::{ERROR, Fused};
use super::stack::Places;
use super::tally::Tally;
use crate::geom::lanes::{le8, max8, min8};
use crate::geom::{Aabb, Ray};

/// Rays of a stream, at most: a power of two.
pub(super) const RAYS: usize = 4096;
/// Shorter lists are tested ray by ray.
pub(super) const LONG: usize = 4;

/// What is computed once per ray, in the order of the lanes: the inverse direction; by how much of it near planes and far ones
/// are moved apart; `-origin·inv`, moved out by the error bound, for near planes; where the search ends, NaN if it has ended.
/// [`super::single::SingleRay`] has the details.
#[derive(Clone, Copy, Debug)]
pub(super) struct StreamRay(f32x8);

impl StreamRay {
    const NOTHING: Self = Self(f32x8::ZERO);

    /// For a tree within `bounds`; `None` if the ray cannot walk with others.
    #[inline(always)]
    pub(super) fn of(ray: &Ray<f32>, bounds: &Aabb) -> Option<Self> {
        let Fused { setup, inv_dir: inv, reach, near, valid, .. } = Fused::of(ray, bounds);
        // Twice the error bound, and an eighth more for what is lost when it is added.
        let apart = reach.max_element() * (2.25 * ERROR);
        // So that no error is so small that it underflows.
        (valid & (apart * inv.abs().min_element() > 1e-36))
            .then(|| Self(f32x8::new([inv.x, inv.y, inv.z, apart, near.x, near.y, near.z, setup.t_max])))
    }

    #[inline(always)]
    pub(super) fn limit(&self) -> f32 {
        self.0.as_array()[7]
    }

    #[inline(always)]
    pub(super) fn set_limit(&mut self, limit: f32) {
        self.0.as_mut_array()[7] = limit;
    }
}

/// What is to be visited, and where the list of its rays is.
#[derive(Clone, Copy, Debug)]
struct Task {
    child: Child,
    start: u32,
    len: u32,
}

/// Memory for walks, to be used again and again.
#[derive(Debug)]
pub(super) struct Streams {
    pub(super) rays: Box<[StreamRay; RAYS]>,
    lists: Vec<u16>,
    tasks: Places<Task>,
}

impl Streams {
    pub(super) fn new() -> Self {
        Self {
            rays: Box::new([StreamRay::NOTHING; RAYS]),
            lists: vec![0; 64 * RAYS],
            tasks: Places::new(Task { child: Child::NONE, start: 0, len: 0 }),
        }
    }
}

/// What is in the leaves.
pub(super) trait Leaves<T> {
    /// Tests the rays of these numbers, and sets where their search ends.
    fn test(&mut self, leaf: usize, numbers: &[u16], rays: &mut [StreamRay; RAYS], tally: &mut T);
}

impl Bvh {
    /// Visits the leaves that rays of one octant may hit. Their [`StreamRay`]s are in their places; none starts before `t_min`.
    #[inline(always)]
    pub(super) fn walk_stream<const ANY: bool, T: Tally>(
        &self,
        octant: usize,
        numbers: &[u16],
        t_min: f32,
        streams: &mut Streams,
        tally: &mut T,
        leaves: &mut impl Leaves<T>,
    ) {
        let (side, first) = (sides(octant), if ANY { octant } else { octant ^ 7 });
        let Streams { rays, lists, tasks } = streams;
        lists[..numbers.len()].copy_from_slice(numbers);
        let mut tasks = tasks.stack();
        let mut task = Task { child: self.root, start: 0, len: numbers.len() as u32 };
        loop {
            let (start, len) = (task.start as usize, task.len as usize);
            match task.child.leaf() {
                Err(number) => {
                    tally.node();
                    let node = &self.nodes[number];
                    // Eight numbers are written at a time, of which the last may be of no use. What lies above this list is of
                    // children that have been visited.
                    let (base, room) = (start + len + 8, len + 8);
                    if lists.len() < base + 8 * room {
                        lists.resize(2 * (base + 8 * room), 0);
                    }
                    let (list, above) = lists[start..base + 8 * room].split_at_mut(len + 8);
                    // The last list is visited first.
                    let mut ends: [usize; 8] = std::array::from_fn(|slot| (slot ^ first & 7) * room);
                    if len < LONG {
                        test_short(node, &list[..len], rays, side, t_min, &mut ends, above);
                    } else {
                        test_long(node, list, rays, side, t_min, &mut ends, above);
                    }
                    tasks.make_room();
                    for index in 0..8 {
                        let slot = index ^ first & 7;
                        let (start, len) = (base + index * room, ends[slot] - index * room);
                        let task = Task { child: node.children[slot], start: start as u32, len: len as u32 };
                        tasks.push_if(task, len != 0);
                    }
                }
                Ok(leaf) => {
                    tally.leaf();
                    leaves.test(leaf, &lists[start..start + len], rays, tally);
                }
            }
            let Some(next) = tasks.pop() else { return };
            task = next;
        }
    }
}

/// Appends each ray to the lists of the boxes that it may hit, one ray after the other.
#[inline(always)]
fn test_short(
    node: &Node,
    list: &[u16],
    rays: &[StreamRay; RAYS],
    side: [usize; 3],
    t_min: f32,
    ends: &mut [usize; 8],
    lists: &mut [u16],
) {
    let axes = [0, 1, 2];
    let (near_planes, far_planes) =
        (axes.map(|axis| node.boxes.near(axis, side)), axes.map(|axis| node.boxes.far(axis, side)));
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

/// [`test_short`] for eight rays at a time. The list has eight more numbers than rays.
#[inline(always)]
fn test_long(
    node: &Node,
    list: &[u16],
    rays: &[StreamRay; RAYS],
    side: [usize; 3],
    t_min: f32,
    ends: &mut [usize; 8],
    lists: &mut [u16],
) {
    let axes = [0, 1, 2];
    let (near_planes, far_planes) = (
        axes.map(|axis: usize| node.boxes.planes[axis][side[axis] & 1].as_array()),
        axes.map(|axis: usize| node.boxes.planes[axis][side[axis] & 1 ^ 1].as_array()),
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

/// For every set of eight numbers of two bytes, which bytes to take so that they come first.
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
