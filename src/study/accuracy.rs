//! Errors of a kernel against the oracle. Twins are bit-identical, so the scalar one speaks for both.

use rayon::prelude::*;

use super::record::AccuracyRow;
use super::workload::{RAYS_PER_SAMPLE, Sample, Subject, Workload, rng};
use crate::geom::{Hit, Ray};
use crate::kernels::{Intersect, Kernel, Shape};
use crate::oracle::{Exact, Truth};

/// Samples that one task works through.
const SAMPLES_PER_TASK: u64 = 64;

/// Measures a kernel on a workload. The result depends on the arguments alone, not on threads or build.
pub fn measure<K: Kernel>(workload: Workload, rays: u64, seed: u64) -> AccuracyRow
where
    K::Shape: Subject,
{
    let samples = rays.div_ceil(RAYS_PER_SAMPLE as u64);
    let tasks: Vec<u64> = (0..samples).step_by(SAMPLES_PER_TASK as usize).collect();
    let tallies: Vec<Tally> = tasks
        .into_par_iter()
        .map(|first| {
            let mut tally = Tally::default();
            for index in first..samples.min(first + SAMPLES_PER_TASK) {
                let mut rng = rng(seed, K::Shape::FAMILY, workload, index);
                tally.sample::<K>(&K::Shape::sample(workload, &mut rng), workload);
            }
            tally
        })
        .collect();
    let mut total = Tally::default();
    for tally in tallies {
        total.merge(tally);
    }
    total.row(&K::INFO.id.to_string(), workload)
}

#[derive(Default)]
struct Tally {
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
    doubles: u64,
    gross: u64,
    /// Of every agreed hit.
    t_ulps: Vec<u32>,
    /// Of every agreed hit.
    uv_errors: Vec<f32>,
}

impl Tally {
    fn sample<K: Kernel>(&mut self, sample: &Sample<K::Shape>, workload: Workload)
    where
        K::Shape: Subject,
    {
        let prepared: Vec<K> = sample.shapes.iter().map(K::prepare).collect();
        for ray in &sample.rays {
            let setup = <K as Intersect<f32>>::setup(ray);
            let outcomes: Vec<(Truth, Hit<f32>)> = sample
                .shapes
                .iter()
                .zip(&prepared)
                .map(|(shape, primitive)| (shape.truth(ray), primitive.closest_hit(ray, &setup)))
                .collect();
            self.ray(ray, &outcomes, K::Shape::MESH && workload == Workload::Edge);
        }
    }

    fn ray(&mut self, ray: &Ray<f32>, outcomes: &[(Truth, Hit<f32>)], mesh: bool) {
        self.rays += 1;
        for (truth, hit) in outcomes {
            self.tests += 1;
            match (truth.hit, truth.boundary) {
                // Where t exceeds f32, no kernel can report the hit.
                (true, false) if truth.t.is_infinite() => {}
                (true, false) => {
                    self.strict_hits += 1;
                    self.false_misses += u64::from(!hit.mask);
                }
                (false, _) => {
                    self.misses += 1;
                    self.false_hits += u64::from(hit.mask);
                }
                // What happens exactly on a boundary is reported, never counted as an error.
                (true, true) => {}
            }
            if truth.hit && hit.mask {
                self.agreed(truth, hit, ray);
            }
        }
        let reported = outcomes.iter().filter(|(_, hit)| hit.mask).count();
        let exact = outcomes.iter().filter(|(truth, _)| truth.hit).count();
        if outcomes.iter().any(|(truth, _)| truth.hit && truth.boundary) {
            self.boundary[reported.min(2)] += 1;
        }
        if mesh && exact > 0 {
            self.mesh_hits += 1;
            self.leaks += u64::from(reported == 0);
        }
        if mesh && exact == 1 && outcomes.iter().all(|(truth, _)| !truth.boundary) {
            self.single_hits += 1;
            self.doubles += u64::from(reported > 1);
        }
    }

    fn agreed(&mut self, truth: &Truth, hit: &Hit<f32>, ray: &Ray<f32>) {
        // An entry clipped to the start of the interval is exact by construction and would only hide the others.
        if truth.t.to_bits() == ray.t_min.to_bits() {
            return;
        }
        self.t_ulps.push(ulps_between(truth.t, hit.t));
        let error = (f64::from(hit.t) - f64::from(truth.t)).abs();
        self.gross += u64::from(error > 0.01 * f64::from(truth.t).abs());
        self.uv_errors.push((hit.u - truth.u).abs().max((hit.v - truth.v).abs()));
    }

    fn merge(&mut self, other: Self) {
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
        self.doubles += other.doubles;
        self.gross += other.gross;
        self.t_ulps.extend(other.t_ulps);
        self.uv_errors.extend(other.uv_errors);
    }

    fn row(mut self, id: &str, workload: Workload) -> AccuracyRow {
        self.t_ulps.sort_unstable();
        self.uv_errors.sort_unstable_by(f32::total_cmp);
        let agreed = self.t_ulps.len() as u64;
        let at = |quantile: f64, count: usize| ((quantile * count as f64) as usize).min(count.saturating_sub(1));
        let ulps = |quantile| self.t_ulps.get(at(quantile, self.t_ulps.len())).map_or(0, |&ulps| u64::from(ulps));
        let uv = |quantile| self.uv_errors.get(at(quantile, self.uv_errors.len())).map_or(0.0, |&e| f64::from(e));
        AccuracyRow {
            id: id.into(),
            workload: workload.name().into(),
            severity: None,
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
            double_per_million: per_million(self.doubles, self.single_hits),
            agreed_hits: agreed,
            t_ulp_p50: ulps(0.5),
            t_ulp_p99: ulps(0.99),
            t_ulp_max: ulps(1.0),
            gross_per_million: per_million(self.gross, agreed),
            uv_error_p99: uv(0.99),
            uv_error_max: uv(1.0),
        }
    }
}

/// Zero where there is nothing to count among.
fn per_million(count: u64, of: u64) -> f64 {
    if of == 0 { 0.0 } else { 1e6 * count as f64 / of as f64 }
}

/// How many representable numbers lie between two, neither of which is NaN; +0 and −0 are the same.
fn ulps_between(a: f32, b: f32) -> u32 {
    // Bits as a number line: negative floats count downwards from zero.
    let place = |x: f32| {
        let magnitude = i64::from(x.to_bits() & 0x7fff_ffff);
        if x.is_sign_negative() { -magnitude } else { magnitude }
    };
    place(a).abs_diff(place(b)).try_into().expect("two floats are less than 2^32 apart")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ulps_count_representable_numbers() {
        assert_eq!(ulps_between(1.0, 1.0 + f32::EPSILON), 1);
        assert_eq!(ulps_between(1.0, 1.0 - f32::EPSILON), 2);
        assert_eq!(ulps_between(0.0, -0.0), 0);
        assert_eq!(ulps_between(-1e-45, 1e-45), 2);
        assert_eq!(ulps_between(f32::MAX, f32::INFINITY), 1);
        assert_eq!(ulps_between(f32::NEG_INFINITY, f32::INFINITY), 2 * 0x7f80_0000);
    }

    #[test]
    fn counts_follow_their_definitions() {
        let ray = Ray::new(glam::Vec3::ZERO, glam::Vec3::Z);
        let miss = Hit::MISS;
        let hit = Hit::<f32>::new(true, 2.0, 0.25, 0.5);
        let inside = Truth { hit: true, boundary: false, t: 2.0, u: 0.25, v: 0.25 };
        let edge = Truth { boundary: true, ..inside };
        let mut tally = Tally::default();
        tally.ray(&ray, &[(inside, miss), (Truth::MISS, miss)], true); // lost: a leak and a false miss
        tally.ray(&ray, &[(inside, hit), (Truth::MISS, hit)], true); // a double and a false hit
        tally.ray(&ray, &[(edge, miss), (edge, miss)], true); // a leak on the edge
        tally.ray(&ray, &[(edge, hit), (edge, hit)], true);
        tally.ray(&ray, &[(edge, hit), (edge, miss)], true);
        let row = tally.row("x", Workload::Edge);
        assert_eq!((row.rays, row.tests, row.exact_hits, row.exact_misses), (5, 10, 2, 2));
        assert_eq!((row.false_miss_per_million, row.false_hit_per_million), (5e5, 5e5));
        assert_eq!((row.boundary_none, row.boundary_one, row.boundary_many), (1, 1, 1));
        assert_eq!((row.mesh_hits, row.leak_per_million), (5, 4e5));
        assert_eq!((row.single_hits, row.double_per_million), (2, 5e5));
        assert_eq!((row.agreed_hits, row.t_ulp_max, row.uv_error_max), (4, 0, 0.25));
    }
}
