//! Counts the rays on which two tracers report different hits.

use serde::{Deserialize, Serialize};

use crate::geom::Hit;

/// Numbers of rays on which two tracers disagree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Disagreements {
    /// Only the first tracer reports a hit.
    pub only_first: usize,
    /// Only the second tracer reports a hit.
    pub only_second: usize,
    /// Both report a hit on different primitives at about the same `t`. Most of these rays hit an edge that two
    /// triangles share, or one of several copies of a triangle: both answers are right.
    pub ties: usize,
    /// Both report a hit on different primitives at different `t`.
    pub other_primitive: usize,
}

/// Two values of `t` are about the same if they differ by at most this share of the larger one.
const TIE: f32 = 1.0 / 4096.0;

impl Disagreements {
    /// Compares the hits of two tracers on the same rays. With `any_hit`, only hit or miss is compared.
    ///
    /// # Panics
    /// If the two slices differ in length.
    pub fn between(first: &[Hit<f32>], second: &[Hit<f32>], any_hit: bool) -> Self {
        assert_eq!(first.len(), second.len(), "both tracers must report one hit per ray");
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
    fn each_kind_of_disagreement_is_counted_separately() {
        let first = [hit(1, 2.0), hit(1, 2.0), Hit::MISS, hit(1, 2.0), hit(1, 2.0), Hit::MISS, hit(1, 0.0)];
        let second = [hit(1, 2.5), Hit::MISS, hit(1, 2.0), hit(2, 2.0001), hit(2, 2.001), Hit::MISS, hit(3, 0.0)];
        let expected = Disagreements { only_first: 1, only_second: 1, ties: 2, other_primitive: 1 };
        assert_eq!(Disagreements::between(&first, &second, false), expected);
        let expected = Disagreements { ties: 0, other_primitive: 0, ..expected };
        assert_eq!(Disagreements::between(&first, &second, true), expected);
    }
}
