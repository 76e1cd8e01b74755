//! The figures of one kernel.

use std::collections::BTreeSet;

use super::rate::{Rate, ulp_p99};
use super::scaling::Scaling;
use crate::study::measure::stats::ratio;
use crate::study::record::{AccuracyRow, KernelRow, MethodRow, Record, SpeedRow};

/// One kernel, and access to all of its rows.
#[derive(Debug)]
pub(crate) struct KernelFigures<'a> {
    /// The kernel's description of itself.
    pub(crate) method: &'a MethodRow,
    /// The part of its ID that distinguishes it within its group. For an instance, the family of the inner kernel is
    /// left out, because the group's title names it.
    pub(crate) name: String,
    /// Lost rays, as the group defines them.
    pub(crate) lost: Option<Failures<'a>>,
    /// Hits of what the ray exactly misses. In a mesh, double hits are among them.
    pub(crate) false_hits: Option<Failures<'a>>,
    /// Both together, for each ray once; for boxes, lost rays alone.
    pub(crate) wrong: Option<Rate>,
    pub(super) record: &'a Record,
}

impl<'a> KernelFigures<'a> {
    /// Throughput at a width, with this number of threads.
    pub(crate) fn speed(&self, width: &str, threads: usize) -> Option<&'a SpeedRow> {
        let mut rows = self.record.speed.iter();
        rows.find(|row| row.id == self.method.id && row.width == width && row.threads == threads)
    }

    /// Errors on a workload without severities.
    pub(crate) fn accuracy(&self, workload: &str) -> Option<&'a AccuracyRow> {
        self.rows(workload).find(|row| row.severity.is_none())
    }

    /// Errors at a step of a regime.
    pub(crate) fn at_step(&self, regime: &str, severity: f64) -> Option<&'a AccuracyRow> {
        self.rows(regime).find(|row| row.severity == Some(severity))
    }

    fn rows(&self, workload: &str) -> impl Iterator<Item = &'a AccuracyRow> {
        rows_of(self.record, &self.method.id).filter(move |row| row.workload == workload)
    }

    /// Nanoseconds per test in one thread.
    pub(crate) fn ns(&self, width: &str) -> Option<f64> {
        self.speed(width, 1).map(|row| row.ns_per_test)
    }

    /// Million tests per second.
    pub(crate) fn mtests(&self, width: &str, threads: usize) -> Option<f64> {
        self.speed(width, threads).map(|row| row.tests_per_second / 1e6)
    }

    /// Throughput with several threads over throughput with one.
    pub(crate) fn scaling(&self, width: &str, threads: usize) -> Option<Scaling> {
        let [one, several] = [self.speed(width, 1)?, self.speed(width, threads)?];
        Scaling::of_times(&one.ns_of_rounds, &several.ns_of_rounds, threads)
    }

    /// Time of a scalar test over the time of a test in a packet of eight rays.
    pub(crate) fn gain(&self) -> Option<f64> {
        Some(self.ns("1x1")? / self.ns("8x1")?)
    }

    /// The summary of eight rays against one primitive.
    pub(crate) fn packet(&self) -> Option<&'a KernelRow> {
        self.record.kernels.iter().find(|row| row.id == self.method.id && row.width == "8x1")
    }

    /// The packet's limit as a share of its time.
    pub(crate) fn limit_share(&self) -> Option<f64> {
        self.packet()?.limit_share
    }

    /// The limit of scalar code as a share of its time, as if a scalar operation took as long as one on eight lanes.
    pub(crate) fn scalar_limit_share(&self) -> Option<f64> {
        Some(8.0 * self.packet()?.limit_ns? / self.ns("1x1")?).filter(|share| share.is_finite())
    }

    /// 99th percentile of the error of `t` on generic rays, in ulp.
    pub(crate) fn ulp(&self) -> Option<u64> {
        self.accuracy("generic").and_then(ulp_p99)
    }

    /// The same, in the hardest step of all regimes.
    pub(crate) fn greatest_ulp(&self) -> Option<u64> {
        rows_of(self.record, &self.method.id).filter_map(ulp_p99).max()
    }

    /// Whether any answer was wrong.
    pub(crate) fn errs(&self) -> bool {
        self.wrong.is_some_and(|wrong| wrong.events > 0)
    }
}

/// Failures of one kind. All kernels of a group get the same rays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Failures<'a> {
    /// The workloads that decide, together.
    pub(crate) rate: Rate,
    /// The row with the highest rate in any workload, and that rate; `None` if nothing failed.
    pub(crate) worst: Option<(&'a AccuracyRow, Rate)>,
}

impl<'a> Failures<'a> {
    pub(super) fn over(
        rows: impl Iterator<Item = &'a AccuracyRow>,
        decides: impl Fn(&AccuracyRow) -> bool,
        rate: impl Fn(&AccuracyRow) -> Option<Rate>,
    ) -> Option<Self> {
        let rates: Vec<_> = rows.filter_map(|row| Some((row, rate(row)?))).collect();
        let failing = rates.iter().filter(|(_, rate)| rate.events > 0).copied();
        Some(Self {
            rate: Rate::sum(rates.iter().filter(|(row, _)| decides(row)).map(|&(_, rate)| rate))?,
            worst: failing.max_by(|(_, a), (_, b)| a.per_million().total_cmp(&b.per_million())),
        })
    }
}

pub(super) fn rows_of<'a>(record: &'a Record, id: &str) -> impl Iterator<Item = &'a AccuracyRow> {
    record.accuracy.iter().filter(move |row| row.id == id)
}

/// The fastest of these kernels at a width, in one thread, followed by all that tie with it, in order of their speed.
pub(crate) fn fastest_of<'k, 'a: 'k>(
    kernels: impl Iterator<Item = &'k KernelFigures<'a>>,
    width: &str,
) -> Vec<&'k KernelFigures<'a>> {
    let mut timed: Vec<_> = kernels.filter_map(|kernel| Some((kernel, kernel.speed(width, 1)?))).collect();
    timed.sort_by(|(_, a), (_, b)| a.ns_per_test.total_cmp(&b.ns_per_test));
    let Some(&(_, first)) = timed.first() else { return Vec::new() };
    timed.into_iter().filter(|(_, row)| tied(first, row)).map(|(kernel, _)| kernel).collect()
}

/// Whether two timings tie: the interval of their ratio contains 1, so neither counts as faster. A timing ties with
/// itself.
pub(crate) fn tied(a: &SpeedRow, b: &SpeedRow) -> bool {
    std::ptr::eq(a, b) || ratio(&a.ns_of_rounds, &b.ns_of_rounds).is_some_and(|ratio| ratio.may_be(1.0))
}

/// The distinct numbers of threads, ascending.
pub(crate) fn thread_counts(threads: impl Iterator<Item = usize>) -> BTreeSet<usize> {
    threads.collect()
}
