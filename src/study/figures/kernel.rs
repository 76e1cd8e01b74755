//! What the record says about one kernel.

use std::collections::BTreeSet;

use super::rate::{Rate, ulp_p99};
use crate::study::record::{AccuracyRow, KernelRow, MethodRow, Record, SpeedRow};

/// What the record says about one kernel.
#[derive(Debug)]
pub(crate) struct Figures<'a> {
    /// The kernel.
    pub(crate) kernel: &'a MethodRow,
    /// What distinguishes its ID within its group, the family of an instance's inner kernel left out: that is in the group's
    /// title.
    pub(crate) name: String,
    /// Rays that exactly hit and are reported to hit nothing, by [`Group::loss`]: the worst of [`Group::losing`] and their severities, or, where
    /// there are none, all of them together.
    pub(crate) lost: Option<Rate>,
    /// The row that `lost` is from, if any were.
    pub(crate) lost_in: Option<&'a AccuracyRow>,
    pub(super) record: &'a Record,
}

impl<'a> Figures<'a> {
    /// Throughput of a face.
    pub(crate) fn speed(&self, face: &str, threads: usize) -> Option<&'a SpeedRow> {
        let mut rows = self.record.speed.iter();
        rows.find(|row| row.id == self.kernel.id && row.face == face && row.threads == threads)
    }

    /// Errors on a workload that has no severities.
    pub(crate) fn accuracy(&self, workload: &str) -> Option<&'a AccuracyRow> {
        self.rows(workload).find(|row| row.severity.is_none())
    }

    /// Errors at a step of a regime.
    pub(crate) fn at_step(&self, regime: &str, severity: f64) -> Option<&'a AccuracyRow> {
        self.rows(regime).find(|row| row.severity == Some(severity))
    }

    fn rows(&self, workload: &str) -> impl Iterator<Item = &'a AccuracyRow> {
        rows_of(self.record, &self.kernel.id).filter(move |row| row.workload == workload)
    }

    /// Nanoseconds per test in one thread.
    pub(crate) fn ns(&self, face: &str) -> Option<f64> {
        self.speed(face, 1).map(|row| row.ns_per_test)
    }

    /// Million tests per second.
    pub(crate) fn mtests(&self, face: &str, threads: usize) -> Option<f64> {
        self.speed(face, threads).map(|row| row.tests_per_second / 1e6)
    }

    /// How much less time a test takes in a packet of eight rays.
    pub(crate) fn gain(&self) -> Option<f64> {
        Some(self.ns("1x1")? / self.ns("8x1")?)
    }

    /// The figures of eight rays against one primitive at a glance.
    pub(crate) fn packet(&self) -> Option<&'a KernelRow> {
        self.record.kernels.iter().find(|row| row.id == self.kernel.id && row.face == "8x1")
    }

    /// What share of the time of a packet its busiest class of operations takes at least.
    pub(crate) fn limit_share(&self) -> Option<f64> {
        self.packet()?.limit_share
    }

    /// The same of scalar code, were a scalar operation to take as long as one on eight lanes.
    pub(crate) fn scalar_limit_share(&self) -> Option<f64> {
        Some(8.0 * self.packet()?.limit_ns? / self.ns("1x1")?).filter(|share| share.is_finite())
    }

    /// 99th percentile of the error of `t` over generic rays.
    pub(crate) fn ulp(&self) -> Option<u64> {
        self.accuracy("generic").and_then(ulp_p99)
    }

    /// Whether any ray was lost.
    pub(crate) fn loses(&self) -> bool {
        self.lost.is_some_and(|lost| lost.per_million > 0.0)
    }
}

pub(super) fn rows_of<'a>(record: &'a Record, id: &str) -> impl Iterator<Item = &'a AccuracyRow> {
    record.accuracy.iter().filter(move |row| row.id == id)
}

/// The fastest of some kernels, in a face and one thread, before all that tie with it, in order of their speed.
pub(crate) fn fastest_of<'k, 'a: 'k>(
    kernels: impl Iterator<Item = &'k Figures<'a>>,
    face: &str,
) -> Vec<&'k Figures<'a>> {
    let mut timed: Vec<_> = kernels.filter_map(|kernel| Some((kernel, kernel.speed(face, 1)?))).collect();
    timed.sort_by(|(_, a), (_, b)| a.ns_per_test.total_cmp(&b.ns_per_test));
    let Some(&(_, first)) = timed.first() else { return Vec::new() };
    timed.into_iter().filter(|(_, row)| tied(first, row)).map(|(kernel, _)| kernel).collect()
}

/// Whether two timings differ by no more than the sum of their median absolute deviations: they are then not ranked.
pub(crate) fn tied(a: &SpeedRow, b: &SpeedRow) -> bool {
    (a.ns_per_test - b.ns_per_test).abs() <= a.ns_per_test_mad + b.ns_per_test_mad
}

/// The numbers of threads that occur, ascending.
pub(crate) fn thread_counts(threads: impl Iterator<Item = usize>) -> BTreeSet<usize> {
    threads.collect()
}
