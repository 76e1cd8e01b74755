//! Rays that pass the edges of random triangles ever closer, and what the oracle says about them.
//!
//! Triangles of all sizes and shapes. The rays aim at points beside an edge or a vertex, from far away or from close
//! by, steeply or grazing. Rounding moves them by about 1e-7 of their coordinates. So they pass at all distances down
//! to zero.

use glam::{DVec3, Vec3};
use raylanes::geom::{Ray, Triangle};
use raylanes::kernels::triangle::ExactT;
use raylanes::kernels::{Claim, Intersect, Kernel};
use raylanes::oracle::Exact;
use rayon::prelude::*;
use wide::f32x8;

use crate::random::Random;
use crate::{Counts, describe};

/// Triangles, each with sixteen rays.
const TRIANGLES: u64 = 12_000;

/// Counts how often a kernel decides against the oracle.
pub(crate) fn all<K: Kernel<Shape = Triangle>>() -> Counts {
    let rounds =
        std::env::var("RAYLANES_ROUNDS").map_or(1, |rounds| rounds.parse().expect("RAYLANES_ROUNDS is a number"));
    (0..rounds * TRIANGLES).into_par_iter().fold(Counts::default, at_one::<K>).reduce(Counts::default, Counts::plus)
}

fn at_one<K: Kernel<Shape = Triangle>>(mut counts: Counts, seed: u64) -> Counts {
    let mut random = Random(seed << 20);
    let triangle = triangle(&mut random);
    let prepared = K::prepare(&triangle);
    for _ in 0..2 {
        let rays = [(); 8].map(|()| beside_an_edge(&triangle, &mut random));
        let mask = Intersect::<f32x8>::hit(&prepared, &Ray::from_lanes(&rays)).mask.bits();
        for (lane, ray) in rays.iter().enumerate() {
            let (truth, hit) = (triangle.truth(ray), mask >> lane & 1 == 1);
            let broken = !truth.boundary & (hit != truth.hit);
            counts.of(Claim::RightDecision).add(1, broken.into(), || describe(ray, &[(0, triangle, hit)]));
        }
    }
    counts
}

/// Compares every `t` of `triangle/exact_t` with the oracle. Where the exact `t` is subnormal, ulp have no meaning.
pub(crate) fn confirm_distances() {
    let check = |seed: u64| {
        let mut random = Random(seed << 20);
        let triangle = triangle(&mut random);
        let prepared = ExactT::prepare(&triangle);
        let (mut hits, mut worst) = (0, 0);
        for ray in [(); 16].map(|()| beside_an_edge(&triangle, &mut random)) {
            let (truth, hit) = (triangle.truth(&ray), Intersect::<f32>::hit(&prepared, &ray));
            if hit.mask & truth.hit & (truth.t >= f32::MIN_POSITIVE) {
                let ulp = hit.t.to_bits().abs_diff(truth.t.to_bits());
                assert!(
                    ulp <= 4096,
                    "{ulp} ulp: {} instead of {}\n{}",
                    hit.t,
                    truth.t,
                    describe(&ray, &[(0, triangle, true)])
                );
                (hits, worst) = (hits + 1, worst.max(ulp));
            }
        }
        (hits, worst)
    };
    let sum = |(a, b): (u64, u32), (c, d): (u64, u32)| (a + c, b.max(d));
    let (hits, worst) = (0..TRIANGLES).into_par_iter().map(check).reduce(|| (0, 0), sum);
    println!("{hits} hits, the worst t is {worst} ulp off");
    assert!(hits > 50_000, "{hits} hits");
}

/// In -1..1.
fn signed(random: &mut Random) -> f64 {
    random.below(1 << 30) as f64 / f64::from(1 << 29) - 1.0
}

fn vector(random: &mut Random) -> DVec3 {
    DVec3::new(signed(random), signed(random), signed(random))
}

/// `10^-x` with `x` in 0..greatest, of either sign.
fn small(greatest: f64, random: &mut Random) -> f64 {
    10f64.powf(-greatest * signed(random).abs()) * signed(random).signum()
}

/// Of a size from 1e-19 to 1e19, but mostly about 1; somewhere, but mostly near the origin; one in four a sliver. Half
/// of them have few digits, so rays meet edges exactly.
fn triangle(random: &mut Random) -> Triangle {
    let unit = if random.below(4) == 0 { 10f64.powf(19.0 * signed(random)) } else { 1.0 };
    let place = vector(random) / small(if random.below(4) == 0 { 6.0 } else { 0.5 }, random);
    let (v0, e1, mut e2) = (place, vector(random), vector(random));
    if random.below(4) == 0 {
        e2 = e1 * signed(random) + e2 * small(7.0, random);
    }
    let coarse = random.below(2) == 0;
    let point = |p: DVec3| {
        let p = if coarse { (p * 64.0).round() / 64.0 } else { p };
        (p * unit).as_vec3()
    };
    Triangle { v0: point(v0), v1: point(v0 + e1), v2: point(v0 + e2) }
}

/// A ray at a point on an edge, or beside it by 1e-12 to 1 of the triangle's size. One in sixteen starts there.
fn beside_an_edge(triangle: &Triangle, random: &mut Random) -> Ray<f32> {
    let [v0, v1, v2] = triangle.vertices().map(Vec3::as_dvec3);
    let along = if random.below(4) == 0 { random.below(2) as f64 } else { random.below(16) as f64 / 16.0 };
    let beside = if random.below(4) == 0 { 0.0 } else { small(12.0, random) };
    let (u, v) = match random.below(3) {
        0 => (along, beside),
        1 => (beside, along),
        _ => (along, 1.0 - along - beside),
    };
    let target = v0 + (v1 - v0) * u + (v2 - v0) * v;
    let size = (v1 - v0).length().max((v2 - v0).length());
    let distance = size / small(3.0, random).abs() * if random.below(16) == 0 { 1e-6 } else { 1.0 };
    let mut way = vector(random).normalize();
    if random.below(4) == 0 {
        let normal = (v1 - v0).cross(v2 - v0).normalize_or_zero();
        way -= normal * way.dot(normal) * (1.0 - small(7.0, random));
    }
    let origin = (target - way * distance).as_vec3();
    // The length of the direction does not matter. It is 1e-3 to 1e3, or the way to the target.
    let dir =
        (target - origin.as_dvec3()) / if random.below(2) == 0 { 1.0 } else { distance * small(3.0, random).abs() };
    Ray::new(origin, dir.as_vec3())
}
