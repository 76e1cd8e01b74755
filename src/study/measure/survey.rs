//! Measures the errors of all kernels on all workloads, regimes and failure maps.

use rand_pcg::Pcg64;

use super::accuracy::Kernels;
use crate::study::progress::Progress;
use crate::study::record::{AccuracyRow, MapCells, MapRow, RegimeRow};
use crate::study::workload::{self, Counts, Regime, Sample, Subject, Workload};

/// Tests at each step of a regime. Rays at a mesh of many triangles are slow, so there are fewer of them.
const MAX_STEP_TESTS: u64 = 2_000_000;

/// The errors of all shapes that were measured so far.
pub(crate) struct Survey {
    quick: bool,
    seed: u64,
    pub(crate) rows: Vec<AccuracyRow>,
    pub(crate) regimes: Vec<RegimeRow>,
    pub(crate) maps: Vec<MapRow>,
    pub(crate) map_cells: Vec<MapCells>,
}

impl Survey {
    /// A survey without any rows.
    pub(crate) fn new(quick: bool, seed: u64) -> Self {
        Self { quick, seed, rows: Vec::new(), regimes: Vec::new(), maps: Vec::new(), map_cells: Vec::new() }
    }

    /// Measures the kernels of one shape on all workloads, regimes and failure maps of the shape.
    pub(crate) fn measure<S: Subject>(&mut self, kernels: &Kernels<S>, progress: &Progress) {
        let [workload_rays, step_rays, cell_rays] =
            if self.quick { [2_000, 1_024, 64] } else { [160_000, 64_000, 512] };
        // A sample has one shape, or more than a hundred.
        let shapes = |sample: &dyn Fn(&mut Pcg64) -> Sample<S>| {
            sample(&mut workload::rng(self.seed, S::FAMILY, "", &[], 0)).shapes.len() as u64
        };
        let rays_of = |regime: &Regime<S>, severity: f64| {
            step_rays.min(MAX_STEP_TESTS / shapes(&|rng| (regime.sample)(severity as f32, rng)))
        };
        // Tests take the time, so they determine the parts of the progress bar.
        let workload_tests =
            Workload::ALL.iter().map(|&workload| workload_rays * shapes(&|rng| S::sample(workload, rng)));
        let steps = S::REGIMES.iter().flat_map(|regime| regime.steps.iter().map(move |&severity| (regime, severity)));
        let step_tests =
            steps.map(|(regime, step)| rays_of(regime, step) * shapes(&|rng| (regime.sample)(step as f32, rng)));
        let map_tests = S::MAPS.iter().map(|map| (map.x.steps().len() * map.y.steps().len()) as u64 * cell_rays);
        let mut parts = progress
            .parts(&workload_tests.chain(step_tests).chain(map_tests).map(|tests| tests as f64).collect::<Vec<_>>())
            .into_iter();
        let mut begin = |name: &str| {
            let part = parts.next().expect("each workload, step and map has its own part");
            part.note(&format!("{}: accuracy, {name}", S::FAMILY));
            part.reach(0.0);
        };
        for workload in Workload::ALL {
            begin(workload.name());
            self.rows.extend(kernels.on_workload(workload, workload_rays, self.seed));
        }
        for regime in S::REGIMES {
            for &severity in regime.steps {
                begin(regime.name);
                self.rows.extend(kernels.on_regime(regime, severity, rays_of(regime, severity), self.seed));
            }
            self.regimes.push(RegimeRow {
                family: S::title(),
                name: regime.name.into(),
                about: regime.about.into(),
                axis: regime.axis.into(),
                steps: regime.steps.to_vec(),
                mesh: regime.counts == Counts::Mesh,
                counts: regime.counts.name().into(),
            });
        }
        for map in S::MAPS {
            begin(map.name);
            let (hits, cells) = kernels.on_map(map, cell_rays, self.seed);
            self.map_cells.extend(cells);
            self.maps.push(MapRow {
                family: S::title(),
                name: map.name.into(),
                x_axis: map.x.title.into(),
                x: map.x.steps(),
                y_axis: map.y.title.into(),
                y: map.y.steps(),
                hits,
            });
        }
    }
}
