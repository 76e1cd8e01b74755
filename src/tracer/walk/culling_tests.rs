//! What all walks rest on: no test that culls is stricter than the slab test of the box rule.

use glam::Vec3;
use wide::f32x8;

use super::block::{Block, RAYS};
use super::packet::PacketRays;
use super::rays::{dir_is_neg, octant, packet};
use super::single::SingleRay;
use super::stream::{self, StreamRay, StreamScratch};
use crate::geom::lanes::le8;
use crate::geom::{Aabb, Ray};
use crate::kernels::aabb::{InverseDirection, pad, slab_interval};
use crate::tracer::bvh::{Boxes, Bvh, Extent};
use crate::tracer::meshes::generator::hash;

/// A sequence of numbers that look random.
struct Random(u32);

impl Random {
    /// From 0 to 1.
    fn unit(&mut self) -> f32 {
        self.0 += 1;
        (hash(self.0, 0, 0) >> 8) as f32 * (1.0 / 16_777_216.0)
    }

    fn below(&mut self, count: usize) -> usize {
        ((self.unit() * count as f32) as usize).min(count - 1)
    }

    /// Each component from -1 to 1.
    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }

    /// Boxes, also flat ones, and some empty ones as in unused slots.
    fn boxes(&mut self, scale: f32) -> [Aabb; 8] {
        std::array::from_fn(|_| {
            let mut size = self.vector().abs() * self.unit() * scale;
            match self.below(6) {
                0 => return Aabb::EMPTY,
                1 => size[self.below(3)] = 0.0,
                _ => {}
            }
            let lo = self.vector() * scale;
            Aabb { lo, hi: lo + size }
        })
    }

    /// Towards a box, past its edges and corners, or along its planes.
    fn ray(&mut self, target: &Aabb, scale: f32) -> Ray<f32> {
        let mut at = target.lo + target.extent() * (self.vector() * 0.5 + 0.5);
        for axis in 0..3 {
            match self.below(4) {
                0 => at[axis] = target.lo[axis],
                1 => at[axis] = target.hi[axis],
                _ => {}
            }
        }
        let mut dir = self.vector() * [1e-20, 1e-6, 1.0, 1e3, 1e20][self.below(5)];
        match self.below(5) {
            0 => dir[self.below(3)] = [0.0, -0.0, 1e-40, -1e-30][self.below(4)],
            1 => dir = Vec3::AXES[self.below(3)],
            _ => {}
        }
        let origin = if self.below(4) == 0 { at } else { at - dir * (scale / dir.length() * self.unit() * 3.0) };
        let mut ray = Ray::new(origin, dir);
        match self.below(6) {
            0 => ray.t_min = f32::NEG_INFINITY,
            1 => ray.t_max = scale / dir.length(),
            2 => (ray.t_min, ray.t_max) = (1.0, 0.5),
            _ => {}
        }
        ray
    }
}

/// A box that is not empty; rays need a target.
fn some_box(boxes: &[Aabb; 8]) -> Aabb {
    boxes.iter().find(|one| one.lo.x <= one.hi.x).copied().unwrap_or(Aabb { lo: Vec3::ZERO, hi: Vec3::ZERO })
}

/// Where a ray enters a box by the rule, if it hits it.
fn by_the_rule(one: &Aabb, ray: &Ray<f32>) -> Option<f32> {
    let setup = InverseDirection::<f32>::of(ray);
    let (entry, exit) = slab_interval(&(*one).into(), ray.origin, &setup);
    (entry <= pad(exit, setup.t_max)).then_some(entry)
}

const SCALES: [f32; 6] = [1e-30, 1e-4, 1.0, 1e4, 1e15, 1e25];

#[test]
fn single_rays_and_packets_are_never_stricter() {
    let mut random = Random(1);
    let (mut hits, mut together) = (0, 0);
    for round in 0..60_000 {
        let scale = SCALES[round % SCALES.len()];
        let all = random.boxes(scale);
        let (boxes, target) = (Boxes::new(all), some_box(&all));
        let bounds = all.iter().fold(Aabb::EMPTY, |bounds, one| bounds.union(one));
        let extent = Extent { bounds, smallest_leaf: f32::INFINITY };
        let rays: [Ray<f32>; 8] = std::array::from_fn(|_| random.ray(&target, scale));
        let eight = packet(&rays);
        let setup = InverseDirection::<f32x8>::of(&eight);
        let walk = PacketRays::of(&eight, &setup, &extent);
        for (lane, ray) in rays.iter().enumerate() {
            let (entry, hit) = SingleRay::of(ray, &extent).boxes(&boxes, InverseDirection::<f32>::of(ray).t_max);
            let (octant, _) = walk.octant(lane);
            for (slot, one) in all.iter().enumerate() {
                let Some(at) = by_the_rule(one, ray) else { continue };
                hits += 1;
                let culled = hit >> slot & 1 == 0 || entry.to_array()[slot] > at;
                assert!(!culled, "{one:?}, {ray:?}: entered at {at:e}, not at {:e}", entry.to_array()[slot]);
                if walk.fused.lane(lane) {
                    together += 1;
                    let (entry, hit) = walk.enter(&boxes, slot, dir_is_neg(octant), setup.t_max);
                    let culled = !hit.lane(lane) || entry.to_array()[lane] > at;
                    assert!(
                        !culled,
                        "{one:?}, {ray:?} in a packet: entered at {at:e}, not at {:e}",
                        entry.to_array()[lane]
                    );
                }
            }
        }
    }
    assert!(hits > 200_000 && together * 4 > hits * 3, "{hits} hits, {together} of them in packets");
}

fn block_of(rays: &[Ray<f32>], item_size: f32) -> Option<Block> {
    let mut block = Block::new();
    let extremes = block.take(rays);
    block.bound(extremes, item_size).then_some(block)
}

/// Which rays a stream brings to which boxes.
struct Met(Vec<(usize, usize)>);

impl stream::Leaves<()> for Met {
    fn test(&mut self, leaf: usize, numbers: &[u16], _: &mut [StreamRay; stream::RAYS], (): &mut ()) {
        self.0.extend(numbers.iter().map(|&number| (usize::from(number), leaf)));
    }
}

#[test]
fn streams_are_never_stricter() {
    let mut random = Random(3);
    let (mut hits, mut together, mut streams) = (0, 0, StreamScratch::new());
    for round in 0..20_000 {
        let scale = SCALES[round % SCALES.len()];
        let all = random.boxes(scale);
        let used: Vec<Aabb> = all.iter().copied().filter(|one| one.lo.x <= one.hi.x).collect();
        let Some(target) = used.first() else { continue };
        // A leaf for each box.
        let tree = Bvh::with_leaves(&used);
        let first = random.ray(target, scale);
        let same_octant =
            |ray: &Ray<f32>| (0..3).all(|axis| ray.dir[axis].is_sign_negative() == first.dir[axis].is_sign_negative());
        let count = [1, 3, 4, 7, 8, 9, 30][random.below(7)];
        let rays: Vec<_> =
            std::iter::repeat_with(|| random.ray(target, scale)).filter(same_octant).take(count).collect();
        let mut numbers = Vec::new();
        for (number, ray) in rays.iter().enumerate() {
            if let Some(ready) = StreamRay::of(ray, &tree.extent) {
                streams.rays[number] = ready;
                numbers.push(number as u16);
            }
        }
        let t_min = rays.iter().fold(f32::INFINITY, |least, ray| least.min(ray.t_min));
        let mut met = Met(Vec::new());
        tree.walk_stream::<false, _>(octant(&first), &numbers, t_min, &mut streams, &mut (), &mut met);
        for (number, ray) in rays.iter().enumerate() {
            for (leaf, one) in tree.leaves.iter().map(|leaf| &used[leaf.0[0] as usize]).enumerate() {
                if by_the_rule(one, ray).is_some() {
                    hits += 1;
                    if numbers.contains(&(number as u16)) {
                        together += 1;
                        assert!(met.0.contains(&(number, leaf)), "{one:?}, {ray:?}, one of {count}");
                    }
                }
            }
        }
    }
    assert!(hits > 100_000 && together * 2 > hits, "{hits} hits, {together} of them in streams");
}

#[test]
fn blocks_are_never_stricter() {
    let mut random = Random(2);
    let (mut blocks, mut hits) = (0, 0);
    for round in 0..30_000 {
        let scale = SCALES[round % SCALES.len()];
        let all = random.boxes(scale);
        let (boxes, target) = (Boxes::new(all), some_box(&all));
        let first = random.ray(&target, scale);
        let spread = [0.0, 1e-7, 1e-3, 0.05][random.below(4)];
        let apart = [0.0, 0.0, 0.01, 0.5][random.below(4)] * scale;
        let rays: Vec<_> = (0..1 + random.below(RAYS))
            .map(|_| Ray {
                origin: first.origin + random.vector() * apart,
                dir: first.dir + random.vector() * (first.dir.length() * spread),
                t_min: [0.0, 0.1][random.below(2)],
                t_max: if random.below(3) == 0 { scale / first.dir.length() } else { f32::INFINITY },
            })
            .collect();
        let Some(block) = block_of(&rays, scale) else { continue };
        blocks += 1;
        let dir_is_neg = dir_is_neg(block.octant);
        let (entry, whole) = block.whole.boxes(&boxes, dir_is_neg);
        for (slot, one) in all.iter().enumerate() {
            for (index, ray) in rays.iter().enumerate() {
                let Some(at) = by_the_rule(one, ray) else { continue };
                hits += 1;
                assert!(whole >> slot & 1 == 1 && entry.to_array()[slot] <= at, "the block, {one:?}, {ray:?}");
                let packet = index / 8;
                assert!(
                    block.packets_that_hit(&boxes, slot, dir_is_neg) >> packet & 1 == 1,
                    "packets, {one:?}, {ray:?}"
                );
                assert!(block.boxes_hit_by(packet, &boxes, dir_is_neg) >> slot & 1 == 1, "a packet, {one:?}, {ray:?}");
            }
        }
    }
    assert!(blocks > 5_000 && hits > 200_000, "{blocks} blocks, {hits} hits");
}

#[test]
fn blocks_are_of_rays_that_are_alike() {
    let alike: Vec<_> =
        (0..20).map(|index| Ray::new(Vec3::ZERO, Vec3::new(1.0, 0.5 + 0.001 * index as f32, -2.0))).collect();
    let with = |index: usize, change: fn(&mut Ray<f32>)| {
        let mut rays = alike.clone();
        change(&mut rays[index]);
        block_of(&rays, 1.0)
    };
    let block = with(3, |_| {}).unwrap();
    assert!(block.one_origin && block.octant == 4);
    for (index, ray) in alike.iter().enumerate() {
        assert_eq!(block.packets[index / 8].lane(index % 8), *ray);
    }
    // Places without a ray hold one that is inactive.
    let active = le8(block.packets[2].t_min, block.packets[2].t_max);
    assert_eq!((active.bits(), block.packets[7].t_max.to_array()), (0b1111, [f32::NEG_INFINITY; 8]));
    assert!(!with(19, |ray| ray.origin.x = 0.5).unwrap().one_origin);
    assert!(with(19, |ray| ray.t_max = f32::INFINITY).is_some());
    let unfit: [fn(&mut Ray<f32>); 9] = [
        |ray| ray.dir.y = -0.5,
        |ray| ray.dir.y = 0.0,
        |ray| ray.dir.x = 2.0,
        |ray| ray.dir.z = f32::NAN,
        |ray| ray.dir.z = f32::NEG_INFINITY,
        |ray| ray.origin.x = f32::NAN,
        |ray| ray.origin.y = 100.0,
        |ray| ray.t_min = -0.5,
        |ray| ray.t_max = f32::NAN,
    ];
    for (number, change) in unfit.into_iter().enumerate() {
        for index in [0, 9, 19] {
            assert!(with(index, change).is_none(), "change {number} of ray {index}");
        }
    }
    let endless: Vec<_> = alike.iter().map(|ray| Ray { origin: Vec3::INFINITY, ..*ray }).collect();
    assert!(block_of(&endless, 1.0).is_none() && block_of(&[], 1.0).is_none());
}
