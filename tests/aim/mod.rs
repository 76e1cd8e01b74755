//! The cases of `raylanes::conformance` as a proptest strategy, which can shrink a failing case.

use proptest::prelude::*;
use raylanes::conformance::{Aimed, Case};

/// Packets of rays aimed at packets of shapes. Shrinking makes the numbers that decide a case smaller.
pub(crate) fn cases<S: Aimed>() -> impl Strategy<Value = Case<S>> {
    prop::collection::vec(any::<u32>(), Case::<S>::NUMBERS).prop_map(|numbers| Case::from_numbers(&numbers))
}
