//! Rays that pass the edges of random triangles ever closer, and what the oracle says about them.

use raylanes::conformance::{Counts, beside_edges, describe};
use raylanes::geom::{Ray, Triangle};
use raylanes::kernels::triangle::ExactT;
use raylanes::kernels::{Claim, Intersect, Kernel};
use raylanes::oracle::Exact;
use rayon::prelude::*;
use wide::f32x8;

/// Triangles, each with sixteen rays.
const TRIANGLES: u64 = 12_000;

/// Counts how often a kernel decides against the oracle.
pub(crate) fn all<K: Kernel<Shape = Triangle>>() -> Counts {
    let rounds =
        std::env::var("RAYLANES_ROUNDS").map_or(1, |rounds| rounds.parse().expect("RAYLANES_ROUNDS is a number"));
    (0..rounds * TRIANGLES).into_par_iter().fold(Counts::default, at_one::<K>).reduce(Counts::default, Counts::plus)
}

fn at_one<K: Kernel<Shape = Triangle>>(mut counts: Counts, seed: u64) -> Counts {
    let (triangle, rays) = beside_edges(seed);
    let prepared = K::prepare(&triangle);
    for rays in rays.as_chunks().0 {
        let mask = Intersect::<f32x8>::hit(&prepared, &Ray::from_lanes(rays)).mask.bits();
        for (lane, ray) in rays.iter().enumerate() {
            let (truth, hit) = (triangle.truth(ray), mask >> lane & 1 == 1);
            let broken = !truth.boundary & (hit != truth.hit);
            counts.add(Claim::RightDecision, 1, broken.into(), || describe(ray, &[(0, triangle, hit)]));
        }
    }
    counts
}

/// Compares every `t` of `triangle/exact_t` with the oracle. Where the exact `t` is subnormal, ulp have no meaning.
pub(crate) fn confirm_distances() {
    let check = |seed: u64| {
        let (triangle, rays) = beside_edges(seed);
        let prepared = ExactT::prepare(&triangle);
        let (mut hits, mut worst) = (0, 0);
        for ray in rays {
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
