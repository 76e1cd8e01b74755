//! Samples of a timing, as they were taken.

use serde::{Deserialize, Serialize};

/// Samples in groups: one group for each process that took them. Within a group they are in the order of the rounds. A
/// round takes one sample of everything that is timed. So sample `k` of group `p` of two timings was taken in the same
/// round of the same process, and their ratio does not depend on how busy the machine was then.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[cfg_attr(test, schemars(inline))]
pub struct Samples(Vec<Vec<f64>>);

impl Samples {
    /// Keeps four significant digits of each sample. Figures that are computed from the result can then be computed
    /// again from a written record.
    pub(crate) fn new(groups: &[Vec<f64>]) -> Self {
        let four_digits = |sample: &f64| format!("{sample:.3e}").parse().expect("this is how numbers are written");
        Self(groups.iter().map(|group| group.iter().map(four_digits).collect()).collect())
    }

    /// The groups.
    pub fn groups(&self) -> &[Vec<f64>] {
        &self.0
    }

    /// All samples, one group after the other.
    pub fn all(&self) -> Vec<f64> {
        self.0.concat()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_keep_four_digits_and_survive_json() {
        let samples = Samples::new(&[vec![1.234_56, 0.001_234_44], vec![98_764.0]]);
        assert_eq!(samples.groups(), [vec![1.235, 0.001_234], vec![98_760.0]]);
        assert_eq!(samples.all(), [1.235, 0.001_234, 98_760.0]);
        let text = serde_json::to_string(&samples).unwrap();
        assert_eq!(text, "[[1.235,0.001234],[98760.0]]");
        assert_eq!(serde_json::from_str::<Samples>(&text).unwrap(), samples);
    }
}
