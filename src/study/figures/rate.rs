//! Rates of errors, in events per million, and how to read them from a row of errors.

use std::fmt;

use super::format::number;
use crate::study::record::AccuracyRow;

/// Events per million rays or ray-primitive pairs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rate {
    /// Events per million.
    pub(crate) per_million: f64,
    /// Number of rays or pairs: the base of the rate.
    pub(crate) of: u64,
}

impl Rate {
    /// `None` if the base is empty or the rate is not a number.
    pub(crate) fn new(per_million: f64, of: u64) -> Option<Self> {
        (of > 0 && per_million >= 0.0 && per_million.is_finite()).then_some(Self { per_million, of })
    }

    /// Number of events.
    pub(crate) fn events(self) -> f64 {
        self.per_million * self.of as f64 / 1e6
    }

    /// The rate. For a rate of zero, its 95 % upper bound: three events in the whole base.
    pub(crate) fn or_bound(self) -> f64 {
        if self.per_million > 0.0 { self.per_million } else { 3e6 / self.of as f64 }
    }
}

impl fmt::Display for Rate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.per_million > 0.0 {
            f.write_str(&number(self.per_million, 3))
        } else {
            write!(f, "0 (< {})", number(self.or_bound(), 2))
        }
    }
}

/// Leaks: rays that exactly hit a mesh and are reported to miss it.
pub(crate) fn leaks(row: &AccuracyRow) -> Option<Rate> {
    Rate::new(row.leak_per_million, row.mesh_hits)
}

/// Whether the triangles of a row's mesh share whole edges. Where a vertex lies on the edge of a neighbour, the mesh
/// itself is at fault, and leaks are shown in that regime only.
pub(crate) fn shares_whole_edges(workload: &str) -> bool {
    workload != "t_junction"
}

/// Double hits: rays that exactly hit one triangle of a mesh, strictly inside, and are reported to hit several.
pub(crate) fn double_hits(row: &AccuracyRow) -> Option<Rate> {
    Rate::new(row.double_hit_per_million, row.single_hits)
}

/// Odd crossings: rays that start outside a closed mesh and are reported to hit an odd number of its triangles.
pub(crate) fn odd_crossings(row: &AccuracyRow) -> Option<Rate> {
    Rate::new(row.odd_per_million, row.crossing_rays)
}

/// Rays whose closest hit is reported on the wrong shape, or on none.
pub(crate) fn wrong_closest(row: &AccuracyRow) -> Option<Rate> {
    Rate::new(row.wrong_closest_per_million, row.closest_rays)
}

/// Hits that the box rule rejects.
pub(crate) fn rejected(row: &AccuracyRow) -> Option<Rate> {
    Rate::new(row.box_rejected_per_million, row.box_hits)
}

/// Hits that the box rule clamps.
pub(crate) fn clamped(row: &AccuracyRow) -> Option<Rate> {
    Rate::new(row.box_clamped_per_million, row.box_hits)
}

/// Rays that a box loses. A box has no neighbour that could catch a lost ray, so its boundary counts like its interior.
pub(crate) fn lost_by_boxes(row: &AccuracyRow) -> Option<Rate> {
    let of = row.exact_hits + row.boundary_none + row.boundary_one + row.boundary_many;
    // The rate is meaningless, and may even be NaN, if its base is empty.
    let strict = Rate::new(row.false_miss_per_million, row.exact_hits).map_or(0.0, Rate::events);
    Rate::new((strict + row.boundary_none as f64) / of as f64 * 1e6, of)
}

/// Wrong answers: false misses and false hits together.
pub(crate) fn wrong(row: &AccuracyRow) -> Option<Rate> {
    let sides = [(row.false_miss_per_million, row.exact_hits), (row.false_hit_per_million, row.exact_misses)];
    // A rate is meaningless, and may even be NaN, if its base is empty.
    let events: f64 = sides.iter().filter_map(|&(rate, of)| Rate::new(rate, of)).map(Rate::events).sum();
    let of = row.exact_hits + row.exact_misses;
    Rate::new(events / of as f64 * 1e6, of)
}

/// Gross errors: agreed hits whose `t` is off by more than 1 %.
pub(crate) fn gross(row: &AccuracyRow) -> Option<Rate> {
    Rate::new(row.gross_per_million, row.agreed_hits)
}

/// 99th percentile of the error of `t` in ulp; `None` if there are no agreed hits.
pub(crate) fn ulp_p99(row: &AccuracyRow) -> Option<u64> {
    (row.agreed_hits > 0).then_some(row.t_ulp_p99)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_zero_rate_is_shown_with_its_bound() {
        assert_eq!(Rate::new(0.0, 100_000).unwrap().to_string(), "0 (< 30)");
        assert_eq!(Rate::new(10.0, 100_000).unwrap().to_string(), "10.0");
        assert_eq!(Rate::new(0.0, 0), None);
        assert_eq!(Rate::new(f64::NAN, 1), None);
    }
}
