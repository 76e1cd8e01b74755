//! The claim of box kernels: rays that exactly meet corners, edges and faces of boxes, and rays one ulp beside them.
//!
//! Coordinates are whole numbers of at most 24 bits, so the exact answer has at most 128 bits.

use super::exact::hits_box;
use super::int3::{Int3, exactly, plus};
use super::random::Random;
use super::twins::hit8;
use super::{Counts, Options, threads};
use crate::geom::{Aabb, Ray};
use crate::kernels::{Claim, Kernel};
use glam::Vec3;

/// The greatest coordinate of a box.
const REACH: i64 = 1 << 22;

/// Counts how many rays that exactly hit a box are lost.
pub(super) fn count<K: Kernel<Shape = Aabb>>(options: &Options) -> Counts {
    let boxes = if options.exhaustive { 40_000 } else { 10_000 };
    let seeds: Vec<_> = (0..boxes).map(|index| options.seed_of(index)).collect();
    threads::sum(&seeds, |&seed| {
        let mut random = Random::from_seed(seed);
        let (lo, hi) = corners(&mut random);
        let shape = Aabb { lo: exactly(lo), hi: exactly(hi) };
        let prepared = K::prepare(&shape);
        let rays = [(); 8].map(|()| aimed(lo, hi, &mut random));
        let mask = hit8(&prepared, &Ray::from_lanes(&rays)).mask;
        let mut counts = Counts::default();
        for (lane, ray) in rays.iter().enumerate() {
            if hits_box(ray, &shape).expect("coordinates have few digits") {
                counts
                    .add(Claim::Conservative, 1, (!mask.lane(lane)).into(), || super::aimed::pair_to_rust(ray, &shape));
            }
        }
        counts
    })
}

/// The corners of a box. One side in eight is flat.
fn corners(random: &mut Random) -> (Int3, Int3) {
    let mut within = |range: i64| random.below(2 * range as usize + 1) as i64 - range;
    let (mut lo, mut hi) = ([0; 3], [0; 3]);
    for axis in 0..3 {
        let (a, b) = (within(REACH), within(REACH));
        let b = if within(4).abs() == 4 { a } else { b };
        (lo[axis], hi[axis]) = (a.min(b), a.max(b));
    }
    (lo, hi)
}

/// A ray through a corner, an edge or a face of the box, or through its inside. One in four is moved by one ulp.
fn aimed(lo: Int3, hi: Int3, random: &mut Random) -> Ray<f32> {
    let target = [0, 1, 2].map(|axis| match random.below(3) {
        0 => lo[axis],
        1 => hi[axis],
        _ => lo[axis] + random.below((hi[axis] - lo[axis]) as usize + 1) as i64,
    });
    // A step of any size, and the number of steps to the target.
    let size = 1i64 << (1 + random.below(22));
    let step = [(); 3].map(|()| random.below(2 * size as usize + 1) as i64 - size);
    let step = if step == [0; 3] { [1, 0, 0] } else { step };
    let steps = 1 + random.below((REACH / size) as usize) as i64;
    let mut origin = exactly(plus(target, step, -steps));
    if random.below(4) == 0 {
        let axis = random.below(3);
        // The neighbours of zero are subnormal.
        if origin[axis] != 0.0 {
            origin[axis] = if random.below(2) == 0 { origin[axis].next_up() } else { origin[axis].next_down() };
        }
    }
    let dir: Vec3 = exactly(step);
    Ray { t_min: if random.below(4) == 0 { f32::NEG_INFINITY } else { 0.0 }, ..Ray::new(origin, dir) }
}

#[cfg(all(test, feature = "study"))]
mod tests {
    use super::*;
    use crate::oracle::Exact;

    #[test]
    fn answers_in_128_bits_are_those_of_the_oracle() {
        let mut hits = [0; 2];
        for seed in 0..20_000 {
            let mut random = Random::from_seed(seed);
            let (lo, hi) = corners(&mut random);
            let shape = Aabb { lo: exactly(lo), hi: exactly(hi) };
            for ray in [(); 8].map(|()| aimed(lo, hi, &mut random)) {
                let truth = shape.truth(&ray);
                assert_eq!(hits_box(&ray, &shape), Some(truth.hit), "{ray:?} {shape:?}");
                hits[usize::from(truth.hit)] += 1;
            }
        }
        assert!(hits.iter().all(|count| *count > 5_000), "{hits:?} misses and hits");
    }
}
