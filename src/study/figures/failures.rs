//! Which metrics a regime is judged by, and at which of its steps a kernel fails.

use super::format::{count, number, severity};
use super::kernel::KernelFigures;
use super::rate::{
    Rate, clamped, double_hits, leaks, lost_by_boxes, odd_crossings, rejected, ulp_p99, wrong, wrong_closest,
};
use crate::study::record::{AccuracyRow, RegimeRow};
use crate::study::workload::Counts;

/// A kernel fails at a step if a rate exceeds this, in events per million: 0.1 %.
pub(crate) const FAILING_RATE: f64 = 1000.0;
/// A kernel fails at a step if the 99th percentile of the error of `t` exceeds this, in ulp.
pub(crate) const FAILING_ULP: u64 = 100;

/// A metric that kernels are judged by in a regime.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Metric {
    /// Wrong answers: false misses and false hits together.
    Wrong,
    /// Hits of a box reported as misses, boundary included.
    Lost,
    /// Misses reported as hits.
    FalseHit,
    /// Leaks: rays that hit a mesh and are reported to miss it.
    Leak,
    /// Double hits: rays that hit one triangle of a mesh and are reported to hit several.
    DoubleHit,
    /// Odd numbers of hits of a closed mesh, from outside.
    Odd,
    /// Closest hits on the wrong shape.
    WrongClosest,
    /// Hits that the box rule rejects.
    Rejected,
    /// Hits that the box rule clamps.
    Clamped,
    /// 99th percentile of the error of `t`.
    Ulp,
}

/// The value of a metric.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Figure {
    /// Events per million.
    Rate(Rate),
    /// Error of `t` in ulp.
    Ulp(u64),
}

impl Metric {
    /// The metrics of a regime. In a mesh, a neighbour may catch what one triangle loses, so leaks and double hits
    /// count. A false hit of a box costs time, a lost one costs a part of the picture, so these are separate metrics.
    pub(crate) fn of(regime: &RegimeRow) -> &'static [Self] {
        let counts = |counts: Counts| regime.counts == counts.name();
        if counts(Counts::Crossings) {
            &[Self::Odd, Self::Ulp]
        } else if counts(Counts::Closest) {
            &[Self::WrongClosest, Self::Ulp]
        } else if counts(Counts::Boxes) {
            &[Self::Rejected, Self::Clamped, Self::Ulp]
        } else if regime.mesh {
            &[Self::Leak, Self::DoubleHit, Self::Ulp]
        } else if regime.family == "aabb" {
            &[Self::Lost, Self::FalseHit, Self::Ulp]
        } else {
            &[Self::Wrong, Self::Ulp]
        }
    }

    /// What the metric counts, and the base of its rate.
    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::Wrong => "wrong answers: false misses and false hits per million tests (boundary hits excluded)",
            Self::Lost => "lost rays: false misses and missed boundary hits per million that exactly hit",
            Self::FalseHit => "false hits per million exact misses (harmless for bounding boxes)",
            Self::Leak => "leaks per million rays that exactly hit the mesh, edges included",
            Self::DoubleHit => "double hits per million rays that exactly hit one triangle, strictly inside",
            Self::Odd => "odd numbers of hits per million rays at a closed mesh, from outside",
            Self::WrongClosest => "wrong or no closest hits per million rays that exactly hit both at different t",
            Self::Rejected => "hits rejected by the box rule per million hits: the ray misses the triangle's box",
            Self::Clamped => "hits clamped by the box rule per million hits: t lies outside the triangle's box",
            Self::Ulp => "99th percentile of the error of t, in units in the last place (ulp)",
        }
    }

    /// The name of the metric in one or two words.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Wrong => "wrong",
            Self::Lost => "lost",
            Self::FalseHit => "false hits",
            Self::Leak => "leaks",
            Self::DoubleHit => "double hits",
            Self::Odd => "odd numbers of hits",
            Self::WrongClosest => "wrong closest hits",
            Self::Rejected => "rejected",
            Self::Clamped => "clamped",
            Self::Ulp => "p99",
        }
    }

    /// The value above which a kernel fails. `None` for false hits of boxes: these only cost a look inside. `None` for
    /// clamped hits: the box rule corrects them.
    pub(crate) fn limit(self) -> Option<f64> {
        match self {
            Self::FalseHit | Self::Clamped => None,
            Self::Ulp => Some(FAILING_ULP as f64),
            Self::Wrong
            | Self::Lost
            | Self::Leak
            | Self::DoubleHit
            | Self::Odd
            | Self::WrongClosest
            | Self::Rejected => Some(FAILING_RATE),
        }
    }

    fn fails(self, figure: Figure) -> bool {
        let value = match figure {
            Figure::Rate(rate) => rate.per_million(),
            Figure::Ulp(ulp) => ulp as f64,
        };
        self.limit().is_some_and(|limit| value > limit)
    }

    /// The value of the metric in a row; `None` if no ray or pair of the row was suited to measure it.
    pub(crate) fn figure(self, row: &AccuracyRow) -> Option<Figure> {
        match self {
            Self::Wrong => wrong(row).map(Figure::Rate),
            Self::Lost => lost_by_boxes(row).map(Figure::Rate),
            Self::FalseHit => Rate::new(row.false_hit_per_million, row.exact_misses).map(Figure::Rate),
            Self::Leak => leaks(row).map(Figure::Rate),
            Self::DoubleHit => double_hits(row).map(Figure::Rate),
            Self::Odd => odd_crossings(row).map(Figure::Rate),
            Self::WrongClosest => wrong_closest(row).map(Figure::Rate),
            Self::Rejected => rejected(row).map(Figure::Rate),
            Self::Clamped => clamped(row).map(Figure::Rate),
            Self::Ulp => ulp_p99(row).map(Figure::Ulp),
        }
    }
}

impl Figure {
    /// The figure with its unit.
    fn in_words(self) -> String {
        match self {
            Self::Rate(rate) => format!("{} %", number(rate.per_million() / 1e4, 2)),
            Self::Ulp(ulp) => format!("{} ulp", number(ulp as f64, 3)),
        }
    }
}

impl std::fmt::Display for Figure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Rate(rate) => rate.fmt(f),
            Self::Ulp(ulp) => f.write_str(&count(*ulp)),
        }
    }
}

/// Whether and where a kernel fails in a regime.
#[derive(Debug, PartialEq)]
pub(crate) enum Verdict {
    /// It fails at no step.
    Holds {
        /// Errors that were too rare to count as failure, such as `leaks up to 0.05 %`. Empty if there were none.
        minor: String,
    },
    /// It fails at some steps.
    Fails {
        /// Index of the first failing step.
        first: usize,
        /// The failing steps in words, such as `from 1e-4`.
        at: String,
        /// The figures at the first failing step, such as `lost 2.3 %, p99 1,234 ulp`.
        how: String,
    },
}

/// Judges a kernel in a regime; `None` if it was not measured there.
pub(crate) fn verdict(kernel: &KernelFigures, regime: &RegimeRow) -> Option<Verdict> {
    verdict_by(kernel, regime, |_| true)
}

/// [`verdict`] by some of the regime's metrics.
pub(crate) fn verdict_by(
    kernel: &KernelFigures,
    regime: &RegimeRow,
    counts: impl Fn(Metric) -> bool,
) -> Option<Verdict> {
    let rows: Vec<_> = regime.steps.iter().map(|&step| kernel.at_step(&regime.name, step)).collect();
    if rows.iter().all(Option::is_none) {
        return None;
    }
    let failing = |row: &AccuracyRow| -> Vec<String> {
        let metrics = Metric::of(regime).iter().filter(|measure| counts(**measure));
        let figures = metrics.filter_map(|measure| Some((measure, measure.figure(row)?)));
        let failing = figures.filter(|(measure, figure)| measure.fails(*figure));
        failing.map(|(measure, figure)| format!("{} {}", measure.name(), figure.in_words())).collect()
    };
    let failures: Vec<_> = rows.into_iter().map(|row| row.map_or(Vec::new(), failing)).collect();
    let Some(first) = failures.iter().position(|failures| !failures.is_empty()) else {
        return Some(Verdict::Holds { minor: minor_errors(kernel, regime) });
    };
    let fails: Vec<bool> = failures.iter().map(|failures| !failures.is_empty()).collect();
    Some(Verdict::Fails { first, at: spans(&fails, &regime.steps), how: failures[first].join(", ") })
}

/// The highest value of each rate over all steps, in words. Rates of zero are left out.
fn minor_errors(kernel: &KernelFigures, regime: &RegimeRow) -> String {
    let worst = |measure: &Metric| {
        let figures =
            regime.steps.iter().filter_map(|&step| match measure.figure(kernel.at_step(&regime.name, step)?)? {
                Figure::Rate(rate) if rate.events > 0 => Some(rate),
                _ => None,
            });
        let worst = figures.max_by(|a, b| a.per_million().total_cmp(&b.per_million()))?;
        Some(format!("{} up to {}", measure.name(), Figure::Rate(worst).in_words()))
    };
    Metric::of(regime).iter().filter_map(worst).collect::<Vec<_>>().join(", ")
}

/// The failing steps in words, consecutive ones joined.
fn spans(fails: &[bool], steps: &[f64]) -> String {
    let mut spans = Vec::new();
    let mut step = 0;
    for run in fails.chunk_by(|a, b| a == b) {
        let (first, last) = (step, step + run.len() - 1);
        step += run.len();
        if run[0] {
            let [from, to] = [first, last].map(|step| severity(steps[step]));
            spans.push(match (first == last, last + 1 == steps.len()) {
                (true, _) => format!("at {from}"),
                (false, true) => format!("from {from}"),
                (false, false) => format!("at {from} to {to}"),
            });
        }
    }
    spans.join(" and ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::figures::groups;
    use crate::study::record::Record;
    use crate::study::tests::fixture::record_of;

    fn grazing(record: &Record) -> &RegimeRow {
        record.regimes.iter().find(|regime| regime.name == "grazing").unwrap()
    }

    fn verdict_of(record: &Record) -> Option<Verdict> {
        verdict(&groups(record)[0].kernels[0], grazing(record))
    }

    /// A record of one kernel that fails nowhere.
    fn flawless() -> Record {
        let mut record = record_of(&["triangle/cramer".into()]);
        for row in &mut record.accuracy {
            (row.false_miss_per_million, row.false_hit_per_million, row.t_ulp_p99) = (0.0, 0.0, FAILING_ULP);
        }
        record
    }

    fn at_step(record: &mut Record, step: usize) -> &mut AccuracyRow {
        let severity = Some(grazing(record).steps[step]);
        record.accuracy.iter_mut().find(|row| row.workload == "grazing" && row.severity == severity).unwrap()
    }

    #[test]
    fn wrong_answers_are_false_misses_and_false_hits_together() {
        let mut record = flawless();
        let row = at_step(&mut record, 0);
        (row.exact_hits, row.false_miss_per_million) = (1000, 5000.0);
        (row.exact_misses, row.false_hit_per_million) = (3000, 1000.0);
        assert_eq!(wrong(row), Rate::new(2000.0, 4000));
        (row.exact_misses, row.false_hit_per_million) = (0, f64::NAN);
        assert_eq!(wrong(row), Rate::new(5000.0, 1000));
        row.exact_hits = 0;
        assert_eq!(wrong(row), None);
    }

    #[test]
    fn a_verdict_names_the_failing_steps_and_the_figures() {
        let mut record = flawless();
        assert_eq!(verdict_of(&record), Some(Verdict::Holds { minor: String::new() }));
        at_step(&mut record, 1).false_hit_per_million = 1000.0;
        at_step(&mut record, 3).false_hit_per_million = 500.0;
        assert_eq!(verdict_of(&record), Some(Verdict::Holds { minor: "wrong up to 0.047 %".into() }));
        at_step(&mut record, 2).false_miss_per_million = 1e6;
        at_step(&mut record, 2).t_ulp_p99 = FAILING_ULP + 1;
        for step in [4, 5, 6] {
            at_step(&mut record, step).t_ulp_p99 = 12_345;
        }
        let Some(Verdict::Fails { first, at, how }) = verdict_of(&record) else { panic!("the kernel must fail") };
        assert_eq!((first, at.as_str()), (2, "at 1e-3 and from 1e-5"));
        assert_eq!(how, "wrong 53 %, p99 101 ulp");
        record.accuracy.retain(|row| row.severity.is_none());
        assert_eq!(verdict_of(&record), None);
    }

    #[test]
    fn every_metric_has_its_own_events_and_base() {
        let mut record = flawless();
        let row = at_step(&mut record, 0);
        (row.mesh_hits, row.leak_per_million) = (1_000, 1e3);
        (row.single_hits, row.double_hit_per_million) = (2_000, 1e3);
        (row.crossing_rays, row.odd_per_million) = (3_000, 1e3);
        (row.closest_rays, row.wrong_closest_per_million) = (4_000, 1e3);
        (row.box_hits, row.box_rejected_per_million, row.box_clamped_per_million) = (5_000, 1e3, 2e3);
        (row.exact_misses, row.false_hit_per_million) = (6_000, 1e3);
        for (metric, events, of) in [
            (Metric::Leak, 1, 1_000),
            (Metric::DoubleHit, 2, 2_000),
            (Metric::Odd, 3, 3_000),
            (Metric::WrongClosest, 4, 4_000),
            (Metric::Rejected, 5, 5_000),
            (Metric::Clamped, 10, 5_000),
            (Metric::FalseHit, 6, 6_000),
        ] {
            assert_eq!(metric.figure(row), Some(Figure::Rate(Rate { events, of })), "{metric:?}");
        }
    }

    #[test]
    fn a_kernel_fails_by_what_nothing_else_corrects() {
        let always = Figure::Rate(Rate { events: 1, of: 1 });
        let fails = [Metric::Rejected, Metric::Lost, Metric::Clamped, Metric::FalseHit].map(|it| it.fails(always));
        assert_eq!(fails, [true, true, false, false]);
    }

    #[test]
    fn a_box_fails_by_lost_rays_and_not_by_false_hits() {
        let mut record = record_of(&["aabb/padded".into()]);
        let regime = record.regimes.iter().find(|regime| regime.name == "box_edge").unwrap().clone();
        for row in record.accuracy.iter_mut().filter(|row| row.workload == regime.name) {
            (row.false_miss_per_million, row.boundary_none, row.false_hit_per_million) = (0.0, 0, 1e6);
            row.t_ulp_p99 = 1;
        }
        let verdict_of = |record: &Record| verdict(&groups(record)[0].kernels[0], &regime);
        assert_eq!(verdict_of(&record), Some(Verdict::Holds { minor: "false hits up to 100 %".into() }));
        record.accuracy.iter_mut().for_each(|row| row.false_miss_per_million = 1e6);
        assert!(matches!(verdict_of(&record), Some(Verdict::Fails { first: 0, .. })));
    }

    #[test]
    fn consecutive_failing_steps_are_joined_in_words() {
        let steps = [1.0, 2.0, 3.0, 4.0, 5.0];
        let words = |fails: [u8; 5]| spans(&fails.map(|fails| fails == 1), &steps);
        assert_eq!(words([1, 1, 0, 0, 1]), "at 1 to 2 and at 5");
        assert_eq!(words([1, 1, 1, 1, 1]), "from 1");
        assert_eq!(words([0, 1, 0, 1, 1]), "at 2 and from 4");
    }
}
