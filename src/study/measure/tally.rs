//! Counts the errors of one kernel ray by ray, and turns the counts into a row of the record.

use super::hit_errors::HitErrorTally;
use super::per_ray::PerRay;
use super::stats::ulps_between;
use crate::geom::{Hit, Ray};
use crate::oracle::Truth;
use crate::study::record::AccuracyRow;
use crate::study::workload::{Counts, Sample, Subject};

/// A strict hit: not on a boundary, and with a `t` that `f32` can hold. Every kernel should report it.
pub(super) fn is_strict(truth: &Truth) -> bool {
    truth.hit && !truth.boundary && truth.t.is_finite()
}

#[derive(Default)]
pub(super) struct Tally {
    rays: u64,
    tests: u64,
    strict_hits: u64,
    misses: u64,
    false_misses: u64,
    false_hits: u64,
    boundary: [u64; 3],
    mesh_hits: u64,
    leaks: u64,
    single_hits: u64,
    double_hits: u64,
    gross: u64,
    per_ray: PerRay,
    /// Error of `t` of every agreed hit.
    t_ulps: Vec<u32>,
    /// Error of `u` and `v` of every agreed hit.
    uv_errors: Vec<f32>,
    /// Errors of points and normals, and of rays that leave them.
    pub(super) hit_errors: HitErrorTally,
}

impl Tally {
    pub(super) fn sample<S: Subject>(
        &mut self,
        sample: &Sample<S>,
        truths: &[Truth],
        hits: &[Hit<f32>],
        counts: Counts,
    ) {
        let each = sample.shapes.len();
        for ((ray, truths), hits) in sample.rays.iter().zip(truths.chunks_exact(each)).zip(hits.chunks_exact(each)) {
            self.ray(ray, truths, hits, counts == Counts::Mesh);
            self.per_ray.add(counts, ray, &sample.shapes, truths, hits);
        }
    }

    fn ray(&mut self, ray: &Ray<f32>, truths: &[Truth], hits: &[Hit<f32>], mesh: bool) {
        self.rays += 1;
        for (truth, hit) in truths.iter().zip(hits) {
            self.tests += 1;
            // A pair exactly on a boundary is never counted as an error; `boundary` reports it below.
            if is_strict(truth) {
                self.strict_hits += 1;
                self.false_misses += u64::from(!hit.mask);
            } else if !truth.hit {
                self.misses += 1;
                self.false_hits += u64::from(hit.mask);
            }
            if truth.hit && hit.mask {
                self.agreed(truth, hit, ray);
            }
        }
        let reported = hits.iter().filter(|hit| hit.mask).count();
        let exact = truths.iter().filter(|truth| truth.hit).count();
        if truths.iter().any(|truth| truth.boundary) {
            self.boundary[reported.min(2)] += 1;
        }
        if mesh && exact > 0 {
            self.mesh_hits += 1;
            self.leaks += u64::from(reported == 0);
        }
        if mesh && exact == 1 && truths.iter().all(|truth| !truth.boundary) {
            self.single_hits += 1;
            self.double_hits += u64::from(reported > 1);
        }
    }

    fn agreed(&mut self, truth: &Truth, hit: &Hit<f32>, ray: &Ray<f32>) {
        // A `t` clipped to the start of the interval is exact by construction. Counting it would hide other errors.
        if truth.t.to_bits() == ray.t_min.to_bits() {
            return;
        }
        self.t_ulps.push(ulps_between(truth.t, hit.t));
        let error = (f64::from(hit.t) - f64::from(truth.t)).abs();
        self.gross += u64::from(error > 0.01 * f64::from(truth.t).abs());
        self.uv_errors.push((hit.u - truth.u).abs().max((hit.v - truth.v).abs()));
    }

    pub(super) fn merge(&mut self, other: Self) {
        self.rays += other.rays;
        self.tests += other.tests;
        self.strict_hits += other.strict_hits;
        self.misses += other.misses;
        self.false_misses += other.false_misses;
        self.false_hits += other.false_hits;
        for (sum, more) in self.boundary.iter_mut().zip(other.boundary) {
            *sum += more;
        }
        self.mesh_hits += other.mesh_hits;
        self.leaks += other.leaks;
        self.single_hits += other.single_hits;
        self.double_hits += other.double_hits;
        self.gross += other.gross;
        self.per_ray.merge(&other.per_ray);
        self.t_ulps.extend(other.t_ulps);
        self.uv_errors.extend(other.uv_errors);
        self.hit_errors.merge(other.hit_errors);
    }

    pub(super) fn row(mut self, id: &str, workload: &str, severity: Option<f64>) -> AccuracyRow {
        self.t_ulps.sort_unstable();
        self.uv_errors.sort_unstable_by(f32::total_cmp);
        let agreed = self.t_ulps.len() as u64;
        let ulps = |share| self.t_ulps.get(quantile(share, self.t_ulps.len())).map_or(0, |&ulps| u64::from(ulps));
        let uv = |share| self.uv_errors.get(quantile(share, self.uv_errors.len())).map_or(0.0, |&e| f64::from(e));
        AccuracyRow {
            id: id.into(),
            workload: workload.into(),
            severity,
            rays: self.rays,
            tests: self.tests,
            exact_hits: self.strict_hits,
            exact_misses: self.misses,
            false_miss_per_million: per_million(self.false_misses, self.strict_hits),
            false_hit_per_million: per_million(self.false_hits, self.misses),
            boundary_none: self.boundary[0],
            boundary_one: self.boundary[1],
            boundary_many: self.boundary[2],
            mesh_hits: self.mesh_hits,
            leak_per_million: per_million(self.leaks, self.mesh_hits),
            single_hits: self.single_hits,
            double_hit_per_million: per_million(self.double_hits, self.single_hits),
            crossing_rays: self.per_ray.odd.of,
            odd_per_million: self.per_ray.odd.per_million(),
            closest_rays: self.per_ray.wrong_closest.of,
            wrong_closest_per_million: self.per_ray.wrong_closest.per_million(),
            box_hits: self.per_ray.rejected.of,
            box_rejected_per_million: self.per_ray.rejected.per_million(),
            box_clamped_per_million: self.per_ray.clamped.per_million(),
            agreed_hits: agreed,
            t_ulp_p50: ulps(0.5),
            t_ulp_p99: ulps(0.99),
            t_ulp_max: ulps(1.0),
            gross_per_million: per_million(self.gross, agreed),
            uv_error_p99: uv(0.99),
            uv_error_max: uv(1.0),
            hit_errors: self.hit_errors.row(),
        }
    }
}

/// `count` per million of `of`; 0 if `of` is 0.
pub(super) fn per_million(count: u64, of: u64) -> f64 {
    if of == 0 { 0.0 } else { 1e6 * count as f64 / of as f64 }
}

/// Index, in a sorted list of `count` values, of the value that the given share of them does not exceed.
pub(super) fn quantile(share: f64, count: usize) -> usize {
    ((share * count as f64) as usize).min(count.saturating_sub(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_error_is_counted_by_its_definition() {
        let ray = Ray::new(glam::Vec3::ZERO, glam::Vec3::Z);
        let miss = Hit::MISS;
        let hit = Hit::<f32>::new(true, 2.0, 0.25, 0.5);
        let inside = Truth { hit: true, boundary: false, t: 2.0, u: 0.25, v: 0.25 };
        let edge = Truth { boundary: true, ..inside };
        let mut tally = Tally::default();
        tally.ray(&ray, &[inside, Truth::MISS], &[miss, miss], true); // a leak and a false miss
        tally.ray(&ray, &[inside, Truth::MISS], &[hit, hit], true); // a double hit and a false hit
        tally.ray(&ray, &[edge, edge], &[miss, miss], true); // a leak on the edge
        tally.ray(&ray, &[edge, edge], &[hit, hit], true);
        tally.ray(&ray, &[edge, edge], &[hit, miss], true);
        let row = tally.row("x", "edge", None);
        assert_eq!((row.rays, row.tests, row.exact_hits, row.exact_misses), (5, 10, 2, 2));
        assert_eq!((row.false_miss_per_million, row.false_hit_per_million), (5e5, 5e5));
        assert_eq!((row.boundary_none, row.boundary_one, row.boundary_many), (1, 1, 1));
        assert_eq!((row.mesh_hits, row.leak_per_million), (5, 4e5));
        assert_eq!((row.single_hits, row.double_hit_per_million), (2, 5e5));
        assert_eq!((row.agreed_hits, row.t_ulp_max, row.uv_error_max), (4, 0, 0.25));
    }
}
