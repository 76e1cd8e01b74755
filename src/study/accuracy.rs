//! Errors of kernels against the oracle. Twins are bit-identical, so the scalar one speaks for both.
//!
//! All kernels of a shape are measured on the same rays, whose exact answers are computed once for all of them. Results
//! depend on seed and number of rays alone: samples are made independently of each other, and what is merged are counts
//! and sorted lists. So they are equal from run to run, for any number of threads, and in every build.

use rayon::prelude::*;

use super::record::{AccuracyRow, MapCells};
use super::stats::ulps_between;
use super::workload::{FailureMap, RAYS_PER_SAMPLE, Regime, Sample, Subject, Workload, rng};
use crate::geom::{Hit, Ray};
use crate::kernels::{Claim, Intersect, Kernel, Shape};
use crate::oracle::{Exact, Truth};
use crate::registry::Visitor;

/// Samples that one task works through.
const SAMPLES_PER_TASK: u64 = 64;

/// A kernel for shapes of type `S`, by what it promises and what it answers.
#[derive(Clone, Debug)]
pub struct Measured<S> {
    /// Its ID.
    pub id: String,
    /// Its promises.
    pub claims: &'static [Claim],
    /// The hits of all rays of a sample: ray by ray, and in each shape by shape.
    hits: fn(&Sample<S>) -> Vec<Hit<f32>>,
}

/// The kernels of a shape.
#[derive(Clone, Debug)]
pub struct Kernels<S>(Vec<Measured<S>>);

impl<S: Subject> Kernels<S> {
    /// All that are registered.
    pub fn registered() -> Self {
        let mut kernels = Self(Vec::new());
        S::visit_kernels(&mut kernels);
        kernels
    }
}

impl<S> Kernels<S> {
    /// In the order of the registry.
    pub fn iter(&self) -> impl Iterator<Item = &Measured<S>> {
        self.0.iter()
    }
}

impl<S: Shape> Visitor<S> for Kernels<S> {
    fn visit<K: Kernel<Shape = S>>(&mut self) {
        self.0.push(Measured { id: K::INFO.id.to_string(), claims: K::INFO.claims, hits: hits::<K> });
    }
}

fn hits<K: Kernel>(sample: &Sample<K::Shape>) -> Vec<Hit<f32>> {
    let prepared: Vec<K> = sample.shapes.iter().map(K::prepare).collect();
    let mut hits = Vec::with_capacity(sample.rays.len() * prepared.len());
    for ray in &sample.rays {
        let setup = <K as Intersect<f32>>::setup(ray);
        hits.extend(prepared.iter().map(|primitive| primitive.closest_hit(ray, &setup)));
    }
    hits
}

/// The exact answers, in the order of [`Measured::hits`].
fn truths<S: Exact>(sample: &Sample<S>) -> Vec<Truth> {
    sample.rays.iter().flat_map(|ray| sample.shapes.iter().map(|shape| shape.truth(ray))).collect()
}

/// Whether every kernel should report the hit: it hangs on no equality, and its `t` does not exceed `f32`.
fn is_strict(truth: &Truth) -> bool {
    truth.hit && !truth.boundary && truth.t.is_finite()
}

/// Where samples come from.
struct Source<'a, S> {
    workload: &'a str,
    severity: Option<f64>,
    mesh: bool,
    sample: &'a (dyn Fn(u64) -> Sample<S> + Sync),
}

impl<S: Subject> Kernels<S> {
    /// Measures all of them on a workload: one row each.
    pub fn on_workload(&self, workload: Workload, rays: u64, seed: u64) -> Vec<AccuracyRow> {
        self.measure(
            rays,
            &Source {
                workload: workload.name(),
                severity: None,
                mesh: S::MESH && workload == Workload::Edge,
                sample: &|index| S::sample(workload, &mut rng(seed, S::FAMILY, workload.name(), &[], index)),
            },
        )
    }

    /// Measures all of them on one step of a regime: one row each.
    pub fn on_regime(&self, regime: &Regime<S>, severity: f64, rays: u64, seed: u64) -> Vec<AccuracyRow> {
        let step = severity as f32;
        self.measure(
            rays,
            &Source {
                workload: regime.name,
                severity: Some(severity),
                mesh: regime.mesh,
                sample: &|index| (regime.sample)(step, &mut rng(seed, S::FAMILY, regime.name, &[step], index)),
            },
        )
    }

    fn measure(&self, rays: u64, source: &Source<S>) -> Vec<AccuracyRow> {
        let samples = rays.div_ceil(RAYS_PER_SAMPLE as u64);
        let tasks: Vec<u64> = (0..samples).step_by(SAMPLES_PER_TASK as usize).collect();
        let tallies: Vec<Vec<Tally>> = tasks
            .into_par_iter()
            .map(|first| {
                let mut tallies: Vec<Tally> = self.0.iter().map(|_| Tally::default()).collect();
                for index in first..samples.min(first + SAMPLES_PER_TASK) {
                    let sample = (source.sample)(index);
                    let truths = truths(&sample);
                    for (kernel, tally) in self.0.iter().zip(&mut tallies) {
                        tally.sample(&sample, &truths, &(kernel.hits)(&sample), source.mesh);
                    }
                }
                tallies
            })
            .collect();
        let mut totals: Vec<Tally> = self.0.iter().map(|_| Tally::default()).collect();
        for tallies in tallies {
            for (total, tally) in totals.iter_mut().zip(tallies) {
                total.merge(tally);
            }
        }
        self.0
            .iter()
            .zip(totals)
            .map(|(kernel, total)| total.row(&kernel.id, source.workload, source.severity))
            .collect()
    }

    /// Measures all of them on a failure map, with so many rays per cell that exactly hit, or fewer where hardly any does:
    /// the numbers of these rays, and the cells of each kernel.
    pub fn on_map(&self, map: &FailureMap<S>, rays: u64, seed: u64) -> (Vec<u64>, Vec<MapCells>) {
        let cells: Vec<[f32; 2]> = map.cells().collect();
        let (hits, columns): (Vec<u64>, Vec<Vec<Option<u64>>>) =
            cells.par_iter().map(|&severities| self.on_cell(map, severities, rays, seed)).unzip();
        let of_kernel = |(index, kernel): (usize, &Measured<S>)| MapCells {
            id: kernel.id.clone(),
            map: map.name.into(),
            t_ulp_p99: columns.iter().map(|column| column[index]).collect(),
        };
        (hits, self.0.iter().enumerate().map(of_kernel).collect())
    }

    fn on_cell(&self, map: &FailureMap<S>, severities: [f32; 2], rays: u64, seed: u64) -> (u64, Vec<Option<u64>>) {
        let mut errors: Vec<Vec<u32>> = vec![Vec::new(); self.0.len()];
        let mut hits = 0;
        // Where the worst inputs have no answer at all (a sliver that rounding makes a line), more attempts do not help.
        for index in 0..16 * rays / RAYS_PER_SAMPLE as u64 {
            let sample = (map.sample)(severities, &mut rng(seed, S::FAMILY, map.name, &severities, index));
            let truths = truths(&sample);
            hits += truths.iter().filter(|truth| is_strict(truth)).count() as u64;
            for (kernel, errors) in self.0.iter().zip(&mut errors) {
                let strict = truths.iter().zip((kernel.hits)(&sample)).filter(|(truth, _)| is_strict(truth));
                errors
                    .extend(strict.map(|(truth, hit)| if hit.mask { ulps_between(truth.t, hit.t) } else { u32::MAX }));
            }
            if hits >= rays {
                break;
            }
        }
        let p99 = errors
            .into_iter()
            .map(|mut errors| {
                errors.truncate(rays as usize);
                errors.sort_unstable();
                let p99 = errors.get(quantile(0.99, errors.len())).copied().unwrap_or(u32::MAX);
                (p99 != u32::MAX).then_some(u64::from(p99))
            })
            .collect();
        (hits.min(rays), p99)
    }
}

impl<S> FailureMap<S> {
    /// Pairs of severities, in the order of [`MapCells::t_ulp_p99`].
    fn cells(&self) -> impl Iterator<Item = [f32; 2]> {
        let (x, y) = (self.x.steps(), self.y.steps());
        y.into_iter().flat_map(move |y| x.clone().into_iter().map(move |x| [x as f32, y as f32]))
    }
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
    fn sample<S>(&mut self, sample: &Sample<S>, truths: &[Truth], hits: &[Hit<f32>], mesh: bool) {
        let each = sample.shapes.len();
        for ((ray, truths), hits) in sample.rays.iter().zip(truths.chunks_exact(each)).zip(hits.chunks_exact(each)) {
            self.ray(ray, truths, hits, mesh);
        }
    }

    fn ray(&mut self, ray: &Ray<f32>, truths: &[Truth], hits: &[Hit<f32>], mesh: bool) {
        self.rays += 1;
        for (truth, hit) in truths.iter().zip(hits) {
            self.tests += 1;
            // What happens exactly on a boundary is reported, never counted as an error.
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

    fn row(mut self, id: &str, workload: &str, severity: Option<f64>) -> AccuracyRow {
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

/// The index, in a sorted list, of the value that this share of them does not exceed.
fn quantile(share: f64, count: usize) -> usize {
    ((share * count as f64) as usize).min(count.saturating_sub(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_follow_their_definitions() {
        let ray = Ray::new(glam::Vec3::ZERO, glam::Vec3::Z);
        let miss = Hit::MISS;
        let hit = Hit::<f32>::new(true, 2.0, 0.25, 0.5);
        let inside = Truth { hit: true, boundary: false, t: 2.0, u: 0.25, v: 0.25 };
        let edge = Truth { boundary: true, ..inside };
        let mut tally = Tally::default();
        tally.ray(&ray, &[inside, Truth::MISS], &[miss, miss], true); // lost: a leak and a false miss
        tally.ray(&ray, &[inside, Truth::MISS], &[hit, hit], true); // a double and a false hit
        tally.ray(&ray, &[edge, edge], &[miss, miss], true); // a leak on the edge
        tally.ray(&ray, &[edge, edge], &[hit, hit], true);
        tally.ray(&ray, &[edge, edge], &[hit, miss], true);
        let row = tally.row("x", "edge", None);
        assert_eq!((row.rays, row.tests, row.exact_hits, row.exact_misses), (5, 10, 2, 2));
        assert_eq!((row.false_miss_per_million, row.false_hit_per_million), (5e5, 5e5));
        assert_eq!((row.boundary_none, row.boundary_one, row.boundary_many), (1, 1, 1));
        assert_eq!((row.mesh_hits, row.leak_per_million), (5, 4e5));
        assert_eq!((row.single_hits, row.double_per_million), (2, 5e5));
        assert_eq!((row.agreed_hits, row.t_ulp_max, row.uv_error_max), (4, 0, 0.25));
    }
}
