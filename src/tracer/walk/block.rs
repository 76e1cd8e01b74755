//! A block: up to eight packets of eight rays with similar origins and directions, for coherent rays.
//!
//! One interval bounds all rays of the block; it is tested against the eight boxes of a node. For a child that
//! survives, the eight intervals of the packets are tested against its box at once. In a leaf, the interval of each
//! remaining packet is tested against the boxes of the triangles. Only triangles are tested against rays. (If the rays
//! do not share an origin, each ray also tests the triangle's box first.)
//!
//! **Source:** interval arithmetic for packets: S. Boulos, I. Wald, P. Shirley, "Geometric and Arithmetic Culling
//! Methods for Entire Ray Packets", 2006. One interval against the children of a wide node: the coherent mode of
//! Embree. Occluders: E. Haines, D. Greenberg, "The Light Buffer: A Shadow-Testing Accelerator", 1986.
//!
//! **Why it culls no hit:** let the sign of a direction be known. The distance to a near plane, `(plane - origin)·inv`,
//! is monotonic in origin and inverse direction under rounding, as long as it is positive. It is least for the origin
//! nearest to the plane and the inverse direction nearest to zero. Where the plane lies behind some origin, the product
//! is negative or zero, and the intervals of all rays start at zero or later. The same holds for far planes. A NaN
//! (`0·∞`) drops out. So the interval enters no later and leaves no earlier than any of its rays, in the arithmetic of
//! the box rule.
//!
//! **Where it fails:** if the rays of a packet are farther apart than triangles are wide, the packet tests triangles
//! that none of its rays hits. Directions do not foretell that: it depends on distances and on the size of the
//! triangles. So a block that has tested too many triangles gives up, and its rays join a stream.
//!
//! **Occluders:** a block of any-hit rays first tests the triangle that the last block hit. In a closed room this ends
//! three blocks in five. It also keeps rays of incoherent blocks out of the stream. Together: 1.3 times as fast.
//! Testing the last two or four triangles ends another 4 or 5 % of the blocks, and was not faster.
//!
//! Tried and not kept (Zen 4, shared machine, differences below 10 % are noise):
//!
//! - Bounds across the longest axis of the rays instead of intervals along all axes. They are tight for parallel rays
//!   from different points. Primary rays 0.5 to 0.8 times the speed, since boxes of long triangles are entered early
//!   along one axis; shadow rays 0.8 to 0.9.
//! - The same bounds after the intervals, and for all shadow rays instead of streams: 0.75 to 0.95. They cull as well
//!   as exact tests of boxes by rays, but small triangles make packets wait where streams do not.
//! - In leaves, all packets against one triangle after the other, instead of all triangles against one packet after the
//!   other: 0.85 to 1.0.
//! - Rays that start on a surface without the test of each triangle's box by rays: seven times the triangle tests on
//!   shadow rays in a closed room, and 0.6 times the speed.
//! - Never giving up, on primary rays turned at random by 0.01, 0.02, 0.05: 0.06 to 0.3, 0.01 to 0.1 and 0.004 to 0.02
//!   times the speed on a bunny and a terrain.
//! - Giving up after 100 or 200 triangles: 0.65 to 0.85 and 0.75 to 0.95, on primary rays turned by 0 to 0.003.

use glam::Vec3;
use wide::f32x8;

use super::counter::Counter;
use super::rays::{dir_is_neg, packet_of_rows, row};
use super::stack::StackStorage;
use crate::geom::Ray;
use crate::geom::lanes::{self, Mask8, eq8, le8, max8, min8};
use crate::tracer::bvh::{Boxes, Bvh, Child};

/// Packets per block.
pub(crate) const PACKETS: usize = 8;
/// Rays per block.
pub(crate) const RAYS: usize = 8 * PACKETS;
/// Factor that moves exits out by 8ε, ε = 2⁻²³. That is at least the padding of the box rule, however the products
/// round.
const PAD: f32 = 1.0 + 8.0 * f32::EPSILON;
/// Largest spread of the directions of a block along any axis, relative to the longest component.
const MAX_DIR_SPREAD: f32 = 0.15;
/// Largest diagonal of the box of the origins, in mean triangle sizes. Beyond it, a block tests many triangles that
/// most of its packets miss. Half or twice as much was 0.8 to 1.0 times as fast on shadow rays.
const MAX_ORIGIN_EXTENT: f32 = 3.0;
/// A block gives up after so many triangle tests, counted once per packet.
const MAX_TRIANGLE_TESTS: u32 = 400;

/// What became of the rays of a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// All hits are known.
    Traced,
    /// Origins or directions differ too much for a block.
    Incoherent,
    /// The block tested too many triangles.
    GivenUp,
}

/// Bounds of some rays: the origins and inverse directions that reach near planes first and far planes last.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Interval {
    near_origin: [f32; 3],
    near_inv: [f32; 3],
    far_origin: [f32; 3],
    far_inv: [f32; 3],
    t_min: f32,
    limit: f32,
}

impl Interval {
    const EMPTY: Self = Self {
        near_origin: [0.0; 3],
        near_inv: [0.0; 3],
        far_origin: [0.0; 3],
        far_inv: [0.0; 3],
        t_min: 0.0,
        limit: 0.0,
    };
}

/// The packets of a block, the interval of each packet, and the interval of all rays. It is large: use it in place.
#[derive(Debug)]
pub(crate) struct Block {
    pub(crate) packets: [Ray<f32x8>; PACKETS],
    // Intervals of the packets, one lane each.
    near_origin: [f32x8; 3],
    near_inv: [f32x8; 3],
    far_origin: [f32x8; 3],
    far_inv: [f32x8; 3],
    t_min: f32x8,
    /// The largest useful `t` of each packet; -∞ if none.
    limit: [f32; PACKETS],
    /// The interval of all rays.
    pub(crate) whole: Interval,
    /// The octant of all directions.
    pub(crate) octant: usize,
    /// Whether all rays share one origin. If not, the intervals of packets are wide.
    pub(crate) one_origin: bool,
    /// Triangle tests of packets so far.
    pub(crate) tests: u32,
}

/// The componentwise minimum and maximum of each packet's rays.
pub(crate) struct Extremes {
    low: [f32x8; PACKETS],
    high: [f32x8; PACKETS],
    /// Whether no component is NaN. If one is, minimum and maximum are undefined.
    no_nan: bool,
}

/// Folds eight values pairwise. Generic rather than `fn`, so that it is inlined.
#[inline(always)]
fn reduce<T>(of: impl Fn(T, T) -> T, [a, b, c, d, e, f, g, h]: [T; 8]) -> T {
    of(of(of(a, b), of(c, d)), of(of(e, f), of(g, h)))
}

#[inline(always)]
fn least(v: f32x8) -> f32 {
    reduce(lanes::min, v.to_array())
}

#[inline(always)]
fn greatest(v: f32x8) -> f32 {
    reduce(lanes::max, v.to_array())
}

/// Calls `of` for each axis. `array::map` is not always inlined.
#[inline(always)]
fn axes<T>(of: impl Fn(usize) -> T) -> [T; 3] {
    [of(0), of(1), of(2)]
}

impl Block {
    /// A block without rays.
    pub(crate) fn new() -> Self {
        let nothing = f32x8::ZERO;
        Self {
            packets: [packet_of_rows([nothing; 8]); PACKETS],
            near_origin: [nothing; 3],
            near_inv: [nothing; 3],
            far_origin: [nothing; 3],
            far_inv: [nothing; 3],
            t_min: nothing,
            limit: [0.0; PACKETS],
            whole: Interval::EMPTY,
            octant: 0,
            one_origin: true,
            tests: 0,
        }
    }

    /// Loads at most [`RAYS`] rays. Unused lanes are inactive.
    #[inline(always)]
    pub(crate) fn take(&mut self, rays: &[Ray<f32>]) -> Extremes {
        let last = rays.last().unwrap_or(&Ray::INACTIVE);
        let filler = row(&Ray { origin: last.origin, dir: last.dir, t_min: f32::INFINITY, t_max: f32::NEG_INFINITY });
        let (mut low, mut high) = ([filler; PACKETS], [filler; PACKETS]);
        let mut valid = Mask8::all_lanes();
        for (index, packet) in self.packets.iter_mut().enumerate() {
            let mut rows = [filler; 8];
            if let Some(rays) = rays.get(8 * index..) {
                for (row_of, ray) in rows.iter_mut().zip(rays) {
                    *row_of = row(ray);
                }
            }
            for row in rows {
                valid = valid & eq8(row, row);
            }
            low[index & 7] = reduce(min8, rows);
            high[index & 7] = reduce(max8, rows);
            *packet = packet_of_rows(rows);
        }
        Extremes { low, high, no_nan: valid.all() }
    }

    /// Computes the intervals, if the rays are coherent. Returns whether they are: all are valid, no `t_min` is
    /// negative, all directions are in one octant and nearly equal, and the origins are close to each other relative to
    /// `item_size`.
    #[inline(always)]
    pub(crate) fn bound(&mut self, Extremes { low, high, no_nan }: Extremes, item_size: f32) -> bool {
        let [lx, ly, lz, t_least, ldx, ldy, ldz, _] = reduce(min8, low).to_array();
        let [gx, gy, gz, _, gdx, gdy, gdz, _] = reduce(max8, high).to_array();
        let (lo, hi) = (Vec3::new(lx, ly, lz), Vec3::new(gx, gy, gz));
        let (dir_lo, dir_hi) = (Vec3::new(ldx, ldy, ldz), Vec3::new(gdx, gdy, gdz));
        let finite = lo.is_finite() && hi.is_finite() && dir_lo.is_finite() && dir_hi.is_finite();
        let longest = dir_lo.abs().max(dir_hi.abs()).max_element();
        let similar = (dir_hi - dir_lo).max_element() <= MAX_DIR_SPREAD * longest;
        self.one_origin = lo == hi;
        let close = self.one_origin || (hi - lo).length() <= MAX_ORIGIN_EXTENT * item_size;
        // A minimum may lose the sign of zero, so a zero counts as no sign.
        let one_octant = [0, 1, 2].into_iter().all(|axis| dir_lo[axis] > 0.0 || dir_hi[axis] < 0.0);
        if !(similar && close && one_octant && finite && t_least >= 0.0 && no_nan) {
            return false;
        }
        self.set_intervals(low, high);
        true
    }

    /// Computes the intervals from the extremes of each packet.
    #[inline(always)]
    fn set_intervals(&mut self, low: [f32x8; 8], high: [f32x8; 8]) {
        let [lx, ly, lz, t_min, ldx, ldy, ldz, _] = f32x8::transpose(low);
        let [gx, gy, gz, _, gdx, gdy, gdz, t_max] = f32x8::transpose(high);
        let (lo, hi, dir_lo, dir_hi) = ([lx, ly, lz], [gx, gy, gz], [ldx, ldy, ldz], [gdx, gdy, gdz]);
        let negative = axes(|axis| dir_lo[axis].as_array()[0] < 0.0);
        let one = f32x8::ONE;
        // Near planes: the origin nearest to them, and the inverse direction nearest to zero. Far planes: the opposite.
        self.near_origin = axes(|axis| if negative[axis] { lo[axis] } else { hi[axis] });
        self.far_origin = axes(|axis| if negative[axis] { hi[axis] } else { lo[axis] });
        self.near_inv = axes(|axis| one / if negative[axis] { dir_lo[axis] } else { dir_hi[axis] });
        self.far_inv = axes(|axis| one / if negative[axis] { dir_hi[axis] } else { dir_lo[axis] } * f32x8::splat(PAD));
        let outermost = |vectors: &[f32x8; 3], upper: bool| {
            axes(|axis| if upper != negative[axis] { greatest(vectors[axis]) } else { least(vectors[axis]) })
        };
        self.whole = Interval {
            near_origin: outermost(&self.near_origin, true),
            near_inv: outermost(&self.near_inv, false),
            far_origin: outermost(&self.far_origin, false),
            far_inv: outermost(&self.far_inv, true),
            t_min: least(t_min),
            limit: greatest(t_max),
        };
        self.tests = 0;
        self.t_min = t_min;
        self.limit = t_max.to_array();
        self.octant = usize::from(negative[0]) | usize::from(negative[1]) << 1 | usize::from(negative[2]) << 2;
    }

    /// Sets the largest useful `t` of a packet.
    #[inline(always)]
    pub(crate) fn set_limit(&mut self, packet: usize, limit: f32x8) {
        self.limit[packet & 7] = greatest(limit);
    }

    #[inline(always)]
    fn interval(&self, packet: usize) -> Interval {
        let at = |vectors: &[f32x8; 3]| axes(|axis| vectors[axis].as_array()[packet & 7]);
        Interval {
            near_origin: at(&self.near_origin),
            near_inv: at(&self.near_inv),
            far_origin: at(&self.far_origin),
            far_inv: at(&self.far_inv),
            t_min: self.t_min.as_array()[packet & 7],
            limit: self.limit[packet & 7],
        }
    }

    /// A bit for each of eight boxes that a packet may hit.
    #[inline(always)]
    pub(crate) fn boxes_hit_by(&self, packet: usize, boxes: &Boxes, dir_is_neg: [usize; 3]) -> u32 {
        self.interval(packet).boxes(boxes, dir_is_neg).1
    }

    /// A bit for each packet that may hit box `slot` of eight.
    #[inline(always)]
    pub(crate) fn packets_that_hit(&self, boxes: &Boxes, slot: usize, dir_is_neg: [usize; 3]) -> u32 {
        let (mut entry, mut exit) = (self.t_min, f32x8::new(self.limit));
        for axis in 0..3 {
            let plane = |planes: f32x8| f32x8::splat(planes.as_array()[slot & 7]);
            let near = (plane(boxes.near(axis, dir_is_neg)) - self.near_origin[axis]) * self.near_inv[axis];
            let far = (plane(boxes.far(axis, dir_is_neg)) - self.far_origin[axis]) * self.far_inv[axis];
            entry = max8(near, entry);
            exit = min8(far, exit);
        }
        le8(entry, exit).bits()
    }
}

impl Interval {
    /// A lower bound of where the rays enter each of eight boxes, and a bit for each box that they may hit.
    #[inline(always)]
    pub(crate) fn boxes(&self, boxes: &Boxes, dir_is_neg: [usize; 3]) -> (f32x8, u32) {
        let (mut entry, mut exit) = (f32x8::splat(self.t_min), f32x8::splat(self.limit));
        for axis in 0..3 {
            let (near, far) = (boxes.near(axis, dir_is_neg), boxes.far(axis, dir_is_neg));
            let near = (near - f32x8::splat(self.near_origin[axis])) * f32x8::splat(self.near_inv[axis]);
            let far = (far - f32x8::splat(self.far_origin[axis])) * f32x8::splat(self.far_inv[axis]);
            entry = max8(near, entry);
            exit = min8(far, exit);
        }
        (entry, le8(entry, exit).bits())
    }
}

/// A child to visit, a lower bound of where the block enters its box, and the node and slot that hold the box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StackEntry {
    entry: f32,
    child: Child,
    node: u32,
    slot: u32,
}

impl StackEntry {
    pub(crate) const EMPTY: Self = Self { entry: 0.0, child: Child::NONE, node: 0, slot: 0 };
}

impl Bvh {
    /// Calls `test` with every leaf that a packet may hit, and a bit for each such packet. `test` updates the packets'
    /// limits and [`Block::tests`]. Returns whether the walk came to its end; false if the block gave up.
    #[inline(always)]
    pub(crate) fn walk_block<const ANY: bool, T: Counter>(
        &self,
        block: &mut Block,
        storage: &mut StackStorage<StackEntry>,
        counter: &mut T,
        mut test: impl FnMut(usize, u32, &mut Block, &mut T),
    ) -> bool {
        let mut stack = storage.stack();
        let dir_is_neg = dir_is_neg(block.octant);
        let (mut child, mut packets) = (self.root, 0xff_u32);
        loop {
            match child.leaf() {
                Err(number) => {
                    counter.node();
                    let node = &self.nodes[number];
                    let interval = if packets.count_ones() == 1 {
                        block.interval(packets.trailing_zeros() as usize)
                    } else {
                        block.whole
                    };
                    let (entry, mut hit) = interval.boxes(&node.boxes, dir_is_neg);
                    let entry = entry.to_array();
                    stack.make_room();
                    let base = stack.len();
                    while hit != 0 {
                        let slot = hit.trailing_zeros() as usize & 7;
                        hit &= hit - 1;
                        let next = StackEntry {
                            entry: entry[slot],
                            child: node.children[slot],
                            node: number as u32,
                            slot: slot as u32,
                        };
                        if ANY {
                            stack.push_if(next, true);
                        } else {
                            stack.insert_above(base, next, |below, new| below.entry < new.entry);
                        }
                    }
                }
                Ok(leaf) => {
                    counter.leaf();
                    test(leaf, packets, block, counter);
                    if block.tests > MAX_TRIANGLE_TESTS {
                        return false;
                    }
                    block.whole.limit = greatest(f32x8::new(block.limit));
                }
            }
            child = loop {
                let Some(next) = stack.pop() else { return true };
                // A box beyond all best hits holds no winner. At equal distance a lower number may still win.
                if next.entry <= block.whole.limit {
                    let boxes = &self.nodes[next.node as usize].boxes;
                    packets = block.packets_that_hit(boxes, next.slot as usize, dir_is_neg);
                    if packets != 0 {
                        break next.child;
                    }
                }
            };
        }
    }
}
