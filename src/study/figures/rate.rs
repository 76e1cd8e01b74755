//! Rates of errors: how many events in how many rays, with exact confidence intervals, and how to read them from a row
//! of errors.

use std::fmt;

use super::binomial::{at_least, at_most, rising_to};
use super::format::number;
use crate::study::record::AccuracyRow;

/// The chance that an interval or a comparison is wrong.
const SIGNIFICANCE: f64 = 0.05;

/// Events among rays or ray-primitive pairs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Rate {
    /// Number of events.
    pub(crate) events: u64,
    /// Number of rays or pairs: the base of the rate.
    pub(crate) of: u64,
}

impl Rate {
    /// `None` if the base is empty.
    pub(crate) fn of_events(events: u64, of: u64) -> Option<Self> {
        (of > 0).then_some(Self { events, of })
    }

    /// From events per million, as rows hold them. `None` if the base is empty or the rate is not a number.
    pub(crate) fn new(per_million: f64, of: u64) -> Option<Self> {
        let events = (per_million * of as f64 / 1e6).round();
        (events >= 0.0 && events.is_finite()).then(|| Self::of_events(events as u64, of)).flatten()
    }

    /// Events per million.
    pub(crate) fn per_million(self) -> f64 {
        self.events as f64 / self.of as f64 * 1e6
    }

    /// The 95 % confidence interval of the rate, in events per million. Source: C. Clopper, E. Pearson, "The Use of
    /// Confidence or Fiducial Limits Illustrated in the Case of the Binomial", 1934. It is exact: at least 95 % of such
    /// intervals contain the true rate, also for rare events.
    pub(crate) fn interval(self) -> [f64; 2] {
        let Self { events, of } = self;
        let tail = SIGNIFICANCE / 2.0;
        let least = if events == 0 { 0.0 } else { rising_to(tail, |p| at_least(events, of, p)) };
        let most = match events {
            0 => -(tail.ln() / of as f64).exp_m1(),
            _ if events == of => 1.0,
            _ => rising_to(1.0 - tail, |p| 1.0 - at_most(events, of, p)),
        };
        [least * 1e6, most * 1e6]
    }

    /// The rate in events per million. For zero, the upper end of its interval.
    pub(crate) fn or_bound(self) -> f64 {
        if self.events > 0 { self.per_million() } else { self.interval()[1] }
    }

    /// Whether the counts leave open which rate is smaller. Given the sum of both counts, the first is binomial if the
    /// rates are equal; they tie if it is not in the outer 5 % of that distribution. Source: J. Przyborowski, H.
    /// Wilenski, "Homogeneity of Results in Testing Samples from Poisson Series", 1940.
    pub(crate) fn ties_with(self, other: Self) -> bool {
        let all = self.events + other.events;
        let share = self.of as f64 / (self.of + other.of) as f64;
        2.0 * at_most(self.events, all, share).min(at_least(self.events, all, share)) > SIGNIFICANCE
    }

    /// The sum of several counts; `None` if there are none.
    pub(crate) fn sum(rates: impl Iterator<Item = Self>) -> Option<Self> {
        rates.reduce(|a, b| Self { events: a.events + b.events, of: a.of + b.of })
    }
}

impl fmt::Display for Rate {
    /// Events per million. For zero, the upper end of the confidence interval too.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.events > 0 {
            f.write_str(&number(self.per_million(), 3))
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
    let strict = Rate::new(row.false_miss_per_million, row.exact_hits).map_or(0, |rate| rate.events);
    Rate::of_events(strict + row.boundary_none, of)
}

/// Wrong answers: false misses and false hits together.
pub(crate) fn wrong(row: &AccuracyRow) -> Option<Rate> {
    let sides = [(row.false_miss_per_million, row.exact_hits), (row.false_hit_per_million, row.exact_misses)];
    // A rate is meaningless, and may even be NaN, if its base is empty.
    Rate::sum(sides.iter().filter_map(|&(rate, of)| Rate::new(rate, of)))
}

/// Gross errors: agreed hits whose `t` is off by more than 1 %.
pub(crate) fn gross(row: &AccuracyRow) -> Option<Rate> {
    Rate::new(row.gross_per_million, row.agreed_hits)
}

/// 99th percentile of the error of `t` in ulp; `None` if there are no agreed hits.
pub(crate) fn ulp_p99(row: &AccuracyRow) -> Option<u64> {
    (row.agreed_hits > 0).then_some(row.t_ulp_p99)
}

/// Hits of what a ray exactly misses. In a mesh, rays that hit more than one triangle count, each once.
pub(crate) fn false_or_double(row: &AccuracyRow) -> Option<Rate> {
    if row.mesh_hits > 0 { double_hits(row) } else { Rate::new(row.false_hit_per_million, row.exact_misses) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rate(events: u64, of: u64) -> Rate {
        Rate::of_events(events, of).unwrap()
    }

    #[test]
    fn a_zero_rate_is_shown_with_its_bound() {
        // 1 - 0.025^(1/n)
        assert_eq!(rate(0, 100_000).to_string(), "0 (< 37)");
        assert_eq!(rate(1, 100_000).to_string(), "10.0");
        assert_eq!(Rate::new(0.0, 0), None);
        assert_eq!(Rate::new(f64::NAN, 1), None);
        for events in 0..=97 {
            assert_eq!(Rate::new(rate(events, 97).per_million(), 97), Rate::of_events(events, 97));
        }
    }

    #[test]
    fn intervals_are_those_of_a_statistics_program() {
        // From `binom.test` of R.
        let near = |rate: Rate, [least, most]: [f64; 2]| {
            let interval = rate.interval().map(|end| end / 1e6);
            let is_near = |value: f64, expected: f64| (value - expected).abs() <= 1e-4 * expected.max(1e-9);
            assert!(is_near(interval[0], least) && is_near(interval[1], most), "{rate:?}: {interval:?}");
        };
        near(rate(10, 100), [0.049_004_69, 0.176_222_6]);
        near(rate(3, 20), [0.032_070_94, 0.378_926_8]);
        near(rate(0, 10), [0.0, 0.308_497_1]);
        near(rate(10, 10), [0.691_502_9, 1.0]);
        near(rate(0, 1_000_000), [0.0, 3.688_873e-6]);
        near(rate(1, 1_000_000), [2.531_781e-8, 5.571_632e-6]);
    }

    #[test]
    fn rates_tie_until_chance_is_unlikely() {
        let n = 200_000;
        for (a, b, tie) in [(0, 0, true), (0, 1, true), (0, 5, true), (0, 6, false), (10, 22, true), (10, 25, false)] {
            assert_eq!(rate(a, n).ties_with(rate(b, n)), tie, "{a} and {b}");
            assert_eq!(rate(b, n).ties_with(rate(a, n)), tie, "{b} and {a}");
        }
        // The same rate over other numbers of rays.
        assert!(rate(100, 10_000).ties_with(rate(1000, 100_000)) && !rate(100, 10_000).ties_with(rate(100, 100_000)));
        assert!(!rate(90_000, n).ties_with(rate(100_000, n)));
    }
}
