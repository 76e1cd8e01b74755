//! Errors of kernels against the oracle. Twins give the same bits, so only the scalar twin is run.
//!
//! All kernels of a shape get the same rays, and the exact answers are computed once for all of them. The results
//! depend only on the seed and the number of rays: samples are made independently of each other, and only counts and
//! sorted lists are merged. They are therefore equal from run to run, for any number of threads, and in every build.

use rayon::prelude::*;

use super::hit_errors::references;
use super::stats::ulps_between;
use super::tally::{Tally, is_strict, quantile};
use crate::geom::Hit;
use crate::kernels::{Claim, Intersect, Kernel, Shape};
use crate::oracle::{Exact, Truth};
use crate::registry::Visitor;
use crate::study::record::{AccuracyRow, MapCells};
use crate::study::workload::{Counts, FailureMap, RAYS_PER_SAMPLE, Regime, Sample, Subject, Workload, rng};

/// Samples per parallel task.
const SAMPLES_PER_TASK: u64 = 64;

/// A kernel for shapes of type `S`, with its type erased.
#[derive(Clone, Debug)]
pub struct Measured<S> {
    /// Kernel ID.
    pub id: String,
    /// What the kernel claims.
    pub claims: &'static [Claim],
    /// The hits of a sample, one for each pair of ray and shape: ray by ray, and for each ray shape by shape.
    hits: fn(&Sample<S>) -> Vec<Hit<f32>>,
}

/// All kernels of one shape.
#[derive(Clone, Debug)]
pub struct Kernels<S>(Vec<Measured<S>>);

impl<S: Subject> Kernels<S> {
    /// All registered kernels of the shape.
    pub fn registered() -> Self {
        let mut kernels = Self(Vec::new());
        S::visit_kernels(&mut kernels);
        kernels
    }
}

impl<S> Kernels<S> {
    /// The kernels, in the order of the registry.
    pub fn iter(&self) -> impl Iterator<Item = &Measured<S>> {
        self.0.iter()
    }
}

impl<S: Subject> Kernels<S> {
    /// Measures all kernels on a workload, with at least `rays` rays (whole samples). One row per kernel, in the order
    /// of [`Kernels::iter`].
    pub fn on_workload(&self, workload: Workload, rays: u64, seed: u64) -> Vec<AccuracyRow> {
        self.measure(
            rays,
            &Source {
                workload: workload.name(),
                severity: None,
                seed,
                counts: if S::MESH && workload == Workload::Edge { Counts::Mesh } else { Counts::Tests },
                sample: &|index| S::sample(workload, &mut rng(seed, S::FAMILY, workload.name(), &[], index)),
            },
        )
    }

    /// Measures all kernels on one step of a regime, with at least `rays` rays (whole samples). One row per kernel.
    pub fn on_regime(&self, regime: &Regime<S>, severity: f64, rays: u64, seed: u64) -> Vec<AccuracyRow> {
        let step = severity as f32;
        self.measure(
            rays,
            &Source {
                workload: regime.name,
                severity: Some(severity),
                seed,
                counts: regime.counts,
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
                    let mut rng = rng(source.seed, "leaving", source.workload, &[], index);
                    let references = references(&sample, &truths, index, &mut rng);
                    for (kernel, tally) in self.0.iter().zip(&mut tallies) {
                        let hits = (kernel.hits)(&sample);
                        tally.sample(&sample, &truths, &hits, source.counts);
                        tally.hit_errors.sample(&references, &hits, kernel.hits);
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

    /// Measures all kernels on a failure map. Each cell gets `rays` rays that exactly hit, or fewer where hits are
    /// rare. Returns the number of these rays for each cell, and the cells of each kernel.
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
        // Some of the hardest inputs cannot be hit at all (rounding may turn a sliver into a line), so attempts are
        // limited.
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

/// The exact answers for a sample, in the order of [`Measured::hits`].
fn truths<S: Exact>(sample: &Sample<S>) -> Vec<Truth> {
    sample.rays.iter().flat_map(|ray| sample.shapes.iter().map(|shape| shape.truth(ray))).collect()
}

/// Where samples come from, and what the rows say about their origin.
struct Source<'a, S> {
    workload: &'a str,
    severity: Option<f64>,
    seed: u64,
    counts: Counts,
    sample: &'a (dyn Fn(u64) -> Sample<S> + Sync),
}

impl<S> FailureMap<S> {
    /// The pairs of severities, in the order of [`MapCells::t_ulp_p99`].
    fn cells(&self) -> impl Iterator<Item = [f32; 2]> {
        let (x, y) = (self.x.steps(), self.y.steps());
        y.into_iter().flat_map(move |y| x.clone().into_iter().map(move |x| [x as f32, y as f32]))
    }
}
