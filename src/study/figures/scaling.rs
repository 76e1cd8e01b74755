//! Throughput with several threads over throughput with one.

use std::fmt;

use super::format::number;
use crate::study::measure::stats::{Estimate, ratio};
use crate::study::record::Samples;

/// A ratio of throughputs, formed within rounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scaling {
    ratio: Estimate,
    threads: usize,
}

impl Scaling {
    /// From the times with one thread and with several; `None` if they have no rounds in common.
    pub(super) fn of_times(one: &Samples, several: &Samples, threads: usize) -> Option<Self> {
        ratio(one, several).map(|ratio| Self { ratio, threads })
    }

    /// The ratio.
    pub(crate) fn value(&self) -> f64 {
        self.ratio.value
    }

    /// Whether it is greater than the number of threads, which only noise or a shared clock can explain.
    pub(crate) fn is_doubtful(&self) -> bool {
        self.ratio.value > self.threads as f64
    }
}

impl fmt::Display for Scaling {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Estimate { value, low, high } = self.ratio;
        write!(f, "{value:.2}× ({} to {})", number(low, 3), number(high, 3))?;
        if self.is_doubtful() {
            write!(f, ", > {}×: noise or shared clock", self.threads)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_than_one_per_thread_is_marked() {
        let scaling = |ns: [f64; 3]| {
            let [one, two] = [[1.0; 3], ns].map(|ns| Samples::new(&[ns.into()]));
            Scaling::of_times(&one, &two, 2).unwrap()
        };
        let plausible = scaling([0.5, 0.52, 0.55]);
        assert_eq!((plausible.to_string().as_str(), plausible.is_doubtful()), ("1.92× (1.82 to 2.00)", false));
        let doubtful = scaling([0.4, 0.4, 0.55]);
        assert_eq!(doubtful.to_string(), "2.50× (1.82 to 2.50), > 2×: noise or shared clock");
        assert!(doubtful.is_doubtful() && (doubtful.value() - 2.5).abs() < 1e-12);
        assert_eq!(Scaling::of_times(&Samples::default(), &Samples::default(), 2), None);
    }
}
