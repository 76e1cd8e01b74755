//! Walking a tree with a block: up to eight packets of eight rays that start and run alike.
//!
//! The eight boxes of a node are tested against one interval that contains all the rays. A box that survives is tested against
//! eight intervals at once, one for each packet, and a packet that survives against the boxes of single triangles. Rays
//! themselves meet nothing but triangles (and, if they do not start at one point, the triangle's box before).
//!
//! **Source:** interval arithmetic for packets: S. Boulos, I. Wald, P. Shirley, "Geometric and Arithmetic Culling Methods for
//! Entire Ray Packets", 2006; one interval against the children of a wide node: the coherent mode of Embree.
//!
//! **Why it culls nothing that counts:** with a direction of known sign, the distance to a near plane, `(plane - origin)·inv`, is
//! monotonic in origin and inverse direction under rounding as long as it is positive. It is least for the origin nearest to
//! the plane and the inverse direction nearest to zero. Where the plane is behind some origin the product may be
//! anything, but it is negative or zero, and all intervals of rays start at zero or later. Likewise for far planes. A NaN (`0·∞`)
//! drops out. So the interval enters no later and leaves no earlier than any of its rays, in the arithmetic of the box rule.
//!
//! **Where it fails:** packets whose rays run further apart than triangles are wide meet triangles that none of their rays does.
//! No measure of directions foretells that, as it hangs on distances and on triangles far smaller than others. So a block that
//! has met too many gives up, and its rays make a stream with others.
//!
//! **A block for which any hit will do** begins with the triangle that the last one has hit: E. Haines, D. Greenberg, "The Light
//! Buffer: A Shadow-Testing Accelerator", 1986. In a closed room that is all that three blocks in five need. It also spares
//! rays of blocks that prove not to be alike the stream: 1.3 times as fast in all. The last two or four triangles end another 4 or
//! 5 % of the blocks, and were no faster.
//!
//! Tried and not kept (Zen 4, shared machine, differences below 10 % are noise): bounds of the rays across their longest axis, which
//! are tight where parallel rays start from different points, instead of intervals along all axes: 0.5 to 0.8 times on primary
//! rays, since boxes of long triangles are entered early along one axis, and 0.8 to 0.9 on shadow rays; after intervals, and for
//! all shadow rays instead of streams, 0.75 to 0.95: as many nodes and triangles as by exact tests of boxes by rays, but
//! small triangles make packets wait where streams do not. In leaves, packets against one triangle after the other, instead of
//! triangles against one packet after the other: 0.85 to 1.0 times. Rays that start on a surface without the test of
//! each triangle's box by rays: seven times the triangle tests on shadow rays in a closed room, and 0.6 times the speed. Without
//! giving up, on primary rays turned at random by 0.01, 0.02, 0.05: 0.06 to 0.3, 0.01 to 0.1 and 0.004 to 0.02 times the speed on a
//! bunny and a terrain. Giving up after 100 triangles, or 200: 0.65 to 0.85, and 0.75 to 0.95 times on primary rays that are not
//! turned or by 0.003.

use glam::Vec3;
use wide::f32x8;

use super::bvh::{Boxes, Bvh, Child};
use super::packet::{of_rows, row};
use super::stack::Places;
use super::tally::Tally;
use crate::geom::Ray;
use crate::geom::lanes::{self, Mask8, eq8, le8, max8, min8};

/// Packets of a block.
pub(super) const PACKETS: usize = 8;
/// Rays of a block.
pub(super) const RAYS: usize = 8 * PACKETS;
/// Exits are moved out by 8ε, ε = 2⁻²³: no less than by the padding of the box rule, whichever is rounded first.
const PAD: f32 = 1.0 + 8.0 * f32::EPSILON;
/// Rays run alike if along no axis their directions differ by more than this share of the longest component.
const ALIKE: f32 = 0.15;
/// Rays that do not start at one point start alike if the box of their origins is no longer than so many mean items: then a
/// block meets few triangles that most of its packets miss. Half or twice as much was 0.8 to 1.0 times as fast on shadow rays.
const CLOSE: f32 = 3.0;
/// A block gives up when its packets have met more triangles, counted once for each packet.
const MOST: u32 = 400;

/// What became of rays that might make a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    /// Their hits are known.
    Traced,
    /// They are not alike.
    Unlike,
    /// They are, but met too many triangles.
    GivenUp,
}

/// What contains all rays of some packets: from where, and how fast, planes are met first and last.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interval {
    near_origin: [f32; 3],
    near_inv: [f32; 3],
    far_origin: [f32; 3],
    far_inv: [f32; 3],
    t_min: f32,
    limit: f32,
}

impl Interval {
    const NOTHING: Self = Self {
        near_origin: [0.0; 3],
        near_inv: [0.0; 3],
        far_origin: [0.0; 3],
        far_inv: [0.0; 3],
        t_min: 0.0,
        limit: 0.0,
    };
}

/// The packets of a block, and the intervals of each and of all together. As big as it is, it stays where it is.
#[derive(Debug)]
pub(super) struct Block {
    pub(super) packets: [Ray<f32x8>; PACKETS],
    // One lane for each packet.
    near_origin: [f32x8; 3],
    near_inv: [f32x8; 3],
    far_origin: [f32x8; 3],
    far_inv: [f32x8; 3],
    t_min: f32x8,
    /// Where the search ends for all rays of a packet: −∞ if it has none.
    limit: [f32; PACKETS],
    pub(super) whole: Interval,
    /// The octant of all directions.
    pub(super) octant: usize,
    /// Whether all rays start at one point. If not, the intervals of packets are wide.
    pub(super) one_origin: bool,
    /// Triangles met by packets so far.
    pub(super) met: u32,
}

/// The least and the greatest rows of each packet.
pub(super) struct Extremes {
    low: [f32x8; PACKETS],
    high: [f32x8; PACKETS],
    /// Whether nothing in the rays is NaN; else a minimum or maximum may be anything.
    numbers: bool,
}

/// Any function, not a pointer to one: that would be called.
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

/// For each axis. `array::map` is not always inlined.
#[inline(always)]
fn axes<T>(of: impl Fn(usize) -> T) -> [T; 3] {
    [of(0), of(1), of(2)]
}

impl Block {
    /// Without rays.
    pub(super) fn new() -> Self {
        let nothing = f32x8::ZERO;
        Self {
            packets: [of_rows([nothing; 8]); PACKETS],
            near_origin: [nothing; 3],
            near_inv: [nothing; 3],
            far_origin: [nothing; 3],
            far_inv: [nothing; 3],
            t_min: nothing,
            limit: [0.0; PACKETS],
            whole: Interval::NOTHING,
            octant: 0,
            one_origin: true,
            met: 0,
        }
    }

    /// Takes over the rays, at most [`RAYS`].
    #[inline(always)]
    pub(super) fn take(&mut self, rays: &[Ray<f32>]) -> Extremes {
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
            *packet = of_rows(rows);
        }
        Extremes { low, high, numbers: valid.all() }
    }

    /// Finds what contains the rays, if they are alike: all valid, none from behind its origin, all directions in one octant and
    /// nearly the same, and origins close to each other for items of the given size. Says whether.
    #[inline(always)]
    pub(super) fn bound(&mut self, Extremes { low, high, numbers }: Extremes, item_size: f32) -> bool {
        let [lx, ly, lz, t_least, ldx, ldy, ldz, _] = reduce(min8, low).to_array();
        let [gx, gy, gz, _, gdx, gdy, gdz, _] = reduce(max8, high).to_array();
        let (lo, hi) = (Vec3::new(lx, ly, lz), Vec3::new(gx, gy, gz));
        let (dir_lo, dir_hi) = (Vec3::new(ldx, ldy, ldz), Vec3::new(gdx, gdy, gdz));
        let finite = lo.is_finite() && hi.is_finite() && dir_lo.is_finite() && dir_hi.is_finite();
        let longest = dir_lo.abs().max(dir_hi.abs()).max_element();
        let alike = (dir_hi - dir_lo).max_element() <= ALIKE * longest;
        self.one_origin = lo == hi;
        let close = self.one_origin || (hi - lo).length() <= CLOSE * item_size;
        // As a sign of zero may have been lost in a minimum, a zero is no sign at all.
        let one_octant = [0, 1, 2].into_iter().all(|axis| dir_lo[axis] > 0.0 || dir_hi[axis] < 0.0);
        if !(alike && close && one_octant && finite && t_least >= 0.0 && numbers) {
            return false;
        }
        self.set_intervals(low, high);
        true
    }

    /// Sets the intervals, from the least and the greatest rows of each packet.
    #[inline(always)]
    fn set_intervals(&mut self, low: [f32x8; 8], high: [f32x8; 8]) {
        let [lx, ly, lz, t_min, ldx, ldy, ldz, _] = f32x8::transpose(low);
        let [gx, gy, gz, _, gdx, gdy, gdz, t_max] = f32x8::transpose(high);
        let (lo, hi, dir_lo, dir_hi) = ([lx, ly, lz], [gx, gy, gz], [ldx, ldy, ldz], [gdx, gdy, gdz]);
        let negative = axes(|axis| dir_lo[axis].as_array()[0] < 0.0);
        let one = f32x8::ONE;
        // What is nearest to the near planes, and slowest in `t`; and the other way round.
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
        self.met = 0;
        self.t_min = t_min;
        self.limit = t_max.to_array();
        self.octant = usize::from(negative[0]) | usize::from(negative[1]) << 1 | usize::from(negative[2]) << 2;
    }

    /// Sets where the search of a packet ends.
    #[inline(always)]
    pub(super) fn set_limit(&mut self, packet: usize, limit: f32x8) {
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

    /// Which of eight boxes a packet may hit.
    #[inline(always)]
    pub(super) fn boxes_hit_by(&self, packet: usize, boxes: &Boxes, side: [usize; 3]) -> u32 {
        self.interval(packet).boxes(boxes, side).1
    }

    /// Which packets may hit one of eight boxes.
    #[inline(always)]
    pub(super) fn packets_that_hit(&self, boxes: &Boxes, slot: usize, side: [usize; 3]) -> u32 {
        let (mut entry, mut exit) = (self.t_min, f32x8::new(self.limit));
        for axis in 0..3 {
            let plane = |planes: f32x8| f32x8::splat(planes.as_array()[slot & 7]);
            let near = (plane(boxes.near(axis, side)) - self.near_origin[axis]) * self.near_inv[axis];
            let far = (plane(boxes.far(axis, side)) - self.far_origin[axis]) * self.far_inv[axis];
            entry = max8(near, entry);
            exit = min8(far, exit);
        }
        le8(entry, exit).bits()
    }
}

impl Interval {
    /// Where it enters eight boxes, and which it hits.
    #[inline(always)]
    pub(super) fn boxes(&self, boxes: &Boxes, side: [usize; 3]) -> (f32x8, u32) {
        let (mut entry, mut exit) = (f32x8::splat(self.t_min), f32x8::splat(self.limit));
        for axis in 0..3 {
            let (near, far) = (boxes.near(axis, side), boxes.far(axis, side));
            let near = (near - f32x8::splat(self.near_origin[axis])) * f32x8::splat(self.near_inv[axis]);
            let far = (far - f32x8::splat(self.far_origin[axis])) * f32x8::splat(self.far_inv[axis]);
            entry = max8(near, entry);
            exit = min8(far, exit);
        }
        (entry, le8(entry, exit).bits())
    }
}

/// Where the block enters a box at the earliest, what is in it, and which node's box it is, in which slot.
#[derive(Clone, Copy, Debug)]
pub(super) struct Visit {
    entry: f32,
    child: Child,
    node: u32,
    slot: u32,
}

pub(super) const ANYTHING: Visit = Visit { entry: 0.0, child: Child::NONE, node: 0, slot: 0 };

impl Bvh {
    /// Calls `test` with every leaf that a packet may hit, and a bit for each such packet. It sets the packets' limits, and counts
    /// triangles. Says whether the walk came to its end: false if the block met too many, and its rays are better off alone.
    #[inline(always)]
    pub(super) fn walk_block<const ANY: bool, T: Tally>(
        &self,
        block: &mut Block,
        places: &mut Places<Visit>,
        tally: &mut T,
        mut test: impl FnMut(usize, u32, &mut Block, &mut T),
    ) -> bool {
        let mut stack = places.stack();
        let side = super::packet::sides(block.octant);
        let (mut child, mut packets) = (self.root, 0xff_u32);
        loop {
            match child.leaf() {
                Err(number) => {
                    tally.node();
                    let node = &self.nodes[number];
                    let interval = if packets.count_ones() == 1 {
                        block.interval(packets.trailing_zeros() as usize)
                    } else {
                        block.whole
                    };
                    let (entry, mut hit) = interval.boxes(&node.boxes, side);
                    let entry = entry.to_array();
                    stack.make_room();
                    let base = stack.len();
                    while hit != 0 {
                        let slot = hit.trailing_zeros() as usize & 7;
                        hit &= hit - 1;
                        let visit = Visit {
                            entry: entry[slot],
                            child: node.children[slot],
                            node: number as u32,
                            slot: slot as u32,
                        };
                        if ANY {
                            stack.push_if(visit, true);
                        } else {
                            stack.insert_above(base, visit, |below, visit| below.entry < visit.entry);
                        }
                    }
                }
                Ok(leaf) => {
                    tally.leaf();
                    test(leaf, packets, block, tally);
                    if block.met > MOST {
                        return false;
                    }
                    block.whole.limit = greatest(f32x8::new(block.limit));
                }
            }
            child = loop {
                let Some(visit) = stack.pop() else { return true };
                // Beyond the farthest of the best hits nothing can win; what is as near still can, by a lower number.
                if visit.entry <= block.whole.limit {
                    packets = block.packets_that_hit(&self.nodes[visit.node as usize].boxes, visit.slot as usize, side);
                    if packets != 0 {
                        break visit.child;
                    }
                }
            };
        }
    }
}
