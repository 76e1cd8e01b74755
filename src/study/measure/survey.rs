//! Measures the errors of all kernels on all workloads, regimes and failure maps.

use rand_pcg::Pcg64;

use super::accuracy::Kernels;
use crate::study::progress::Progress;
use crate::study::record::{AccuracyRow, MapCells, MapRow, RegimeRow};
use crate::study::workload::{self, Sample, Subject, Workload};

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
            if self.quick { [2_000, 1_024, 64] } else { [200_000, 100_000, 512] };
        // Tests take the time, so they determine the parts of the progress bar. A sample has one shape, or hundreds.
        let tests = |rays: u64, sample: &dyn Fn(&mut Pcg64) -> Sample<S>| {
            rays as f64 * sample(&mut workload::rng(self.seed, S::FAMILY, "", &[], 0)).shapes.len() as f64
        };
        let workload_tests =
            Workload::ALL.iter().map(|&workload| tests(workload_rays, &|rng| S::sample(workload, rng)));
        let steps = S::REGIMES.iter().flat_map(|regime| regime.steps.iter().map(move |&severity| (regime, severity)));
        let step_tests = steps.map(|(regime, step)| tests(step_rays, &|rng| (regime.sample)(step as f32, rng)));
        let map_tests = S::MAPS.iter().map(|map| (map.x.steps().len() * map.y.steps().len()) as f64 * cell_rays as f64);
        let mut parts =
            progress.parts(&workload_tests.chain(step_tests).chain(map_tests).collect::<Vec<_>>()).into_iter();
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
                self.rows.extend(kernels.on_regime(regime, severity, step_rays, self.seed));
            }
            self.regimes.push(RegimeRow {
                family: S::title(),
                name: regime.name.into(),
                about: regime.about.into(),
                axis: regime.axis.into(),
                steps: regime.steps.to_vec(),
                mesh: regime.mesh,
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
