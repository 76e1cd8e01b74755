//! Walking a tree with a block of rays: up to eight packets of eight.
//!
//! A block is tested against eight boxes at once, by an interval that contains all its rays. A box that survives is tested
//! against eight packets at once, each again an interval of rays. Only triangles are tested ray by ray.

use wide::f32x8;

use super::bvh8::{Boxes, Bvh8, Child};
use crate::geom::Ray;
use crate::geom::lanes::{Vec3x8, le8, max8, min8};

/// Packets of a block.
pub(super) const PACKETS: usize = 8;
/// Rays of a block.
pub(super) const RAYS: usize = 8 * PACKETS;

/// What contains all rays of some packets, whose directions have the same signs.
#[derive(Clone, Copy)]
struct Interval {
    near_origin: [f32; 3],
    near_inv: [f32; 3],
    far_origin: [f32; 3],
    far_inv: [f32; 3],
    t_min: f32,
}

/// The intervals of a block's packets, and of all together.
pub(super) struct Bundle {
    near_origin: [f32x8; 3],
    near_inv: [f32x8; 3],
    far_origin: [f32x8; 3],
    far_inv: [f32x8; 3],
    t_min: f32x8,
    /// For each packet, where the search ends for all its rays: −∞ if it has none.
    limit: [f32; PACKETS],
    whole: Interval,
    whole_limit: f32,
    side: [usize; 3],
}

/// Exits are moved out by so much.
const PAD: f32 = 1.0 + 8.0 * f32::EPSILON;

fn row(ray: &Ray<f32>) -> f32x8 {
    let Ray { origin: o, t_min, dir: d, t_max } = *ray;
    f32x8::new([o.x, o.y, o.z, t_min, d.x, d.y, d.z, t_max])
}

pub(super) fn packet_of(rows: [f32x8; 8]) -> Ray<f32x8> {
    let [ox, oy, oz, t_min, dx, dy, dz, t_max] = f32x8::transpose(rows);
    Ray { origin: Vec3x8 { x: ox, y: oy, z: oz }, dir: Vec3x8 { x: dx, y: dy, z: dz }, t_min, t_max }
}

impl Bundle {
    /// The rays, at least one and at most [`RAYS`], as packets and what bounds them. All have the same signs of directions.
    #[inline(always)]
    pub(super) fn of(rays: &[Ray<f32>], packets: &mut [Ray<f32x8>; PACKETS]) -> Self {
        let last = &rays[rays.len() - 1];
        let filler = row(&Ray { t_min: f32::INFINITY, t_max: f32::NEG_INFINITY, ..*last });
        let (mut least, mut greatest) = ([filler; PACKETS], [filler; PACKETS]);
        for (index, rays) in rays.chunks(8).enumerate() {
            let mut rows = [filler; 8];
            for (row_of, ray) in rows.iter_mut().zip(rays) {
                *row_of = row(ray);
            }
            let pairs = |of: fn(f32x8, f32x8) -> f32x8| {
                let [a, b, c, d, e, f, g, h] = rows;
                of(of(of(a, b), of(c, d)), of(of(e, f), of(g, h)))
            };
            least[index & 7] = pairs(min8);
            greatest[index & 7] = pairs(max8);
            packets[index & 7] = packet_of(rows);
        }
        let [lx, ly, lz, t_min, ldx, ldy, ldz, _] = f32x8::transpose(least);
        let [gx, gy, gz, _, gdx, gdy, gdz, t_max] = f32x8::transpose(greatest);
        let (lo, hi) = ([lx, ly, lz], [gx, gy, gz]);
        let (dir_lo, dir_hi) = ([ldx, ldy, ldz], [gdx, gdy, gdz]);
        let side = last.dir.to_array().map(|dir| usize::from(dir.is_sign_negative()));
        let one = f32x8::ONE;
        let at = |axis: usize, positive: f32x8, negative: f32x8| if side[axis] == 0 { positive } else { negative };
        let axes = [0, 1, 2];
        let near_origin = axes.map(|axis| at(axis, hi[axis], lo[axis]));
        let far_origin = axes.map(|axis| at(axis, lo[axis], hi[axis]));
        let near_inv = axes.map(|axis| one / at(axis, dir_hi[axis], dir_lo[axis]));
        let far_inv = axes.map(|axis| one / at(axis, dir_lo[axis], dir_hi[axis]) * f32x8::splat(PAD));
        let least_of = |v: f32x8| v.to_array().into_iter().fold(f32::INFINITY, |a, b| if b < a { b } else { a });
        let greatest_of = |v: f32x8| v.to_array().into_iter().fold(f32::NEG_INFINITY, |a, b| if b > a { b } else { a });
        let whole = Interval {
            near_origin: axes
                .map(|axis| if side[axis] == 0 { greatest_of(near_origin[axis]) } else { least_of(near_origin[axis]) }),
            far_origin: axes
                .map(|axis| if side[axis] == 0 { least_of(far_origin[axis]) } else { greatest_of(far_origin[axis]) }),
            near_inv: axes
                .map(|axis| if side[axis] == 0 { least_of(near_inv[axis]) } else { greatest_of(near_inv[axis]) }),
            far_inv: axes
                .map(|axis| if side[axis] == 0 { greatest_of(far_inv[axis]) } else { least_of(far_inv[axis]) }),
            t_min: least_of(t_min),
        };
        Self {
            near_origin,
            near_inv,
            far_origin,
            far_inv,
            t_min,
            limit: t_max.to_array(),
            whole,
            whole_limit: greatest_of(t_max),
            side,
        }
    }

    /// Sets where the search of a packet ends.
    #[inline(always)]
    pub(super) fn set_limit(&mut self, packet: usize, limit: f32) {
        self.limit[packet & 7] = limit;
    }

    #[inline(always)]
    pub(super) fn update_whole(&mut self) {
        let [a, b, c, d, e, f, g, h] = self.limit;
        let max = |a: f32, b: f32| if a > b { a } else { b };
        self.whole_limit = max(max(max(a, b), max(c, d)), max(max(e, f), max(g, h)));
    }

    #[inline(always)]
    fn interval(&self, packet: usize) -> Interval {
        let at = |vectors: &[f32x8; 3]| [0, 1, 2].map(|axis: usize| vectors[axis].as_array()[packet & 7]);
        Interval {
            near_origin: at(&self.near_origin),
            near_inv: at(&self.near_inv),
            far_origin: at(&self.far_origin),
            far_inv: at(&self.far_inv),
            t_min: self.t_min.as_array()[packet & 7],
        }
    }

    /// Where an interval enters eight boxes, and which it hits.
    #[inline(always)]
    fn boxes(&self, interval: &Interval, limit: f32, boxes: &Boxes) -> (f32x8, u32) {
        let (mut entry, mut exit) = (f32x8::splat(interval.t_min), f32x8::splat(limit));
        for axis in 0..3 {
            let side = self.side[axis] & 1;
            let (near, far) = (boxes.planes[axis][side], boxes.planes[axis][side ^ 1]);
            let near = (near - f32x8::splat(interval.near_origin[axis])) * f32x8::splat(interval.near_inv[axis]);
            let far = (far - f32x8::splat(interval.far_origin[axis])) * f32x8::splat(interval.far_inv[axis]);
            entry = max8(near, entry);
            exit = min8(far, exit);
        }
        (entry, le8(entry, exit).bits())
    }

    /// Which of eight boxes a packet may hit.
    #[inline(always)]
    pub(super) fn boxes_hit_by(&self, packet: usize, boxes: &Boxes) -> u32 {
        self.boxes(&self.interval(packet), self.limit[packet & 7], boxes).1
    }

    /// Which packets may hit one of eight boxes.
    #[inline(always)]
    pub(super) fn packets_that_hit(&self, boxes: &Boxes, lane: usize) -> u32 {
        let (mut entry, mut exit) = (self.t_min, f32x8::new(self.limit));
        for axis in 0..3 {
            let side = self.side[axis] & 1;
            let plane = |side: usize| f32x8::splat(boxes.planes[axis][side].as_array()[lane & 7]);
            let near = (plane(side) - self.near_origin[axis]) * self.near_inv[axis];
            let far = (plane(side ^ 1) - self.far_origin[axis]) * self.far_inv[axis];
            entry = max8(near, entry);
            exit = min8(far, exit);
        }
        le8(entry, exit).bits()
    }
}

#[derive(Clone, Copy)]
pub(super) struct Visit {
    entry: f32,
    child: Child,
    /// Node and slot.
    place: u32,
}

const ROOM: usize = 512;
pub(super) type Room = [Visit; ROOM];
pub(super) const EMPTY: Room = [Visit { entry: 0.0, child: Child::NONE, place: 0 }; ROOM];

impl Bvh8 {
    /// Calls `test` with every leaf that a packet may hit, and those packets.
    #[inline(always)]
    pub(super) fn walk_block<const ORDERED: bool>(
        &self,
        bundle: &mut Bundle,
        room: &mut Room,
        mut test: impl FnMut(usize, u32, &mut Bundle),
    ) {
        let mut top = 0;
        let mut child = self.root;
        let mut packets = 0xffu32;
        loop {
            match child.leaf() {
                Err(number) => {
                    let node = &self.nodes[number];
                    let (entry, mut hit) = if packets.count_ones() == 1 {
                        let packet = packets.trailing_zeros() as usize;
                        bundle.boxes(&bundle.interval(packet), bundle.limit[packet & 7], &node.boxes)
                    } else {
                        bundle.boxes(&bundle.whole, bundle.whole_limit, &node.boxes)
                    };
                    let entry = entry.to_array();
                    let base = top;
                    while hit != 0 {
                        let slot = hit.trailing_zeros() as usize & 7;
                        hit &= hit - 1;
                        let visit =
                            Visit { entry: entry[slot], child: node.children[slot], place: (number * 8 + slot) as u32 };
                        let mut at = top;
                        if ORDERED {
                            while at > base && room[(at - 1) & (ROOM - 1)].entry < visit.entry {
                                room[at & (ROOM - 1)] = room[(at - 1) & (ROOM - 1)];
                                at -= 1;
                            }
                        }
                        room[at & (ROOM - 1)] = visit;
                        top += 1;
                    }
                }
                Ok(leaf) => test(leaf, packets, bundle),
            }
            loop {
                if top == 0 {
                    return;
                }
                top -= 1;
                let visit = room[top & (ROOM - 1)];
                if visit.entry > bundle.whole_limit {
                    continue;
                }
                packets = bundle.packets_that_hit(&self.nodes[(visit.place >> 3) as usize].boxes, visit.place as usize & 7);
                if packets != 0 {
                    child = visit.child;
                    break;
                }
            }
        }
    }
}
