//! Where two tracers report something else for the same ray.

use serde::{Deserialize, Serialize};

use crate::geom::Hit;

/// Rays about which two tracers disagree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Disagreements {
    /// Only the first one reports a hit.
    pub only_first: usize,
    /// Only the second one reports a hit.
    pub only_second: usize,
    /// Both report a hit, of different primitives, at about the same `t`: most hit an edge that the two share, or one of
    /// several copies of a triangle, and either answer is right.
    pub ties: usize,
    /// Both report a hit, of different primitives, at different `t`.
    pub other_primitive: usize,
}

/// Two `t` that differ by no more than this share of the greater one count as about the same.
const TIE: f32 = 1.0 / 4096.0;

impl Disagreements {
    /// Compares the hits of the same rays. Of any-hit rays only whether there is one is compared.
    ///
    /// # Panics
    /// If there are not as many of the one as of the other.
    pub fn between(first: &[Hit<f32>], second: &[Hit<f32>], any_hit: bool) -> Self {
        assert_eq!(first.len(), second.len(), "hits of the same rays");
        let mut found = Self::default();
        for (a, b) in first.iter().zip(second) {
            match (a.mask, b.mask) {
                (true, false) => found.only_first += 1,
                (false, true) => found.only_second += 1,
                (true, true) if !any_hit && a.primitive != b.primitive => {
                    if (a.t - b.t).abs() <= TIE * a.t.abs().max(b.t.abs()) {
                        found.ties += 1;
                    } else {
                        found.other_primitive += 1;
                    }
                }
                _ => {}
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hit(primitive: u32, t: f32) -> Hit<f32> {
        Hit { primitive, ..Hit::<f32>::new(true, t, 0.25, 0.25) }
    }

    #[test]
    fn each_kind_is_counted_by_itself() {
        let first = [hit(1, 2.0), hit(1, 2.0), Hit::MISS, hit(1, 2.0), hit(1, 2.0), Hit::MISS, hit(1, 0.0)];
        let second = [hit(1, 2.5), Hit::MISS, hit(1, 2.0), hit(2, 2.0001), hit(2, 2.001), Hit::MISS, hit(3, 0.0)];
        let expected = Disagreements { only_first: 1, only_second: 1, ties: 2, other_primitive: 1 };
        assert_eq!(Disagreements::between(&first, &second, false), expected);
        let expected = Disagreements { ties: 0, other_primitive: 0, ..expected };
        assert_eq!(Disagreements::between(&first, &second, true), expected);
    }
}
