//! What the processor can do at most: the time of an operation on eight lanes where it waits for no other, and so what a
//! test that needs so many of them takes at least.
//!
//! Each operation runs in chains that are independent of one another, more of them than an operation takes cycles. Loads
//! are taken from the first-level cache.

use std::array::from_fn;
use std::hint::black_box;
use std::time::Instant;

use wide::{f32x8, f64x8};

use super::record::{OperationCounts, RateRow};
use super::stats::{mad, median};
use crate::geom::lanes::max8;
#[cfg(fused)]
use crate::geom::lanes::mul_add8;

/// Chains that fit into the registers.
const CHAINS: usize = if cfg!(any(target_feature = "avx", target_arch = "aarch64")) { 12 } else { 6 };
/// Steps of each chain in a sample: a quarter of a millisecond or more.
const STEPS: usize = 1 << 16;

/// Nanoseconds of one step of one chain.
fn time<T: Copy>(start: [T; CHAINS], step: impl Fn(T) -> T) -> f64 {
    let mut values = black_box(start);
    let clock = Instant::now();
    for _ in 0..STEPS {
        for value in &mut values {
            *value = step(*value);
        }
    }
    let seconds = clock.elapsed().as_secs_f64();
    black_box(values);
    seconds * 1e9 / (STEPS * CHAINS) as f64
}

fn start_f32() -> [f32x8; CHAINS] {
    from_fn(|chain| f32x8::splat(1.25 + chain as f32 / 16.0))
}

fn start_f64() -> [f64x8; CHAINS] {
    from_fn(|chain| f64x8::splat(1.25 + chain as f64 / 16.0))
}

/// Nanoseconds of one load. What is loaded is combined by maxima, of which a processor does as many; logic would be done on
/// more than eight lanes at once where there are such registers.
fn time_load() -> f64 {
    const ROWS: usize = 4;
    let data = black_box([start_f32(); ROWS]);
    // Never in memory themselves, or each step would store them.
    let mut values = start_f32();
    let clock = Instant::now();
    for _ in 0..STEPS / ROWS {
        for row in black_box(&data) {
            values = from_fn(|chain| max8(values[chain], row[chain]));
        }
    }
    let seconds = clock.elapsed().as_secs_f64();
    black_box(values.into_iter().fold(f32x8::ZERO, max8));
    seconds * 1e9 / (STEPS * CHAINS) as f64
}

/// An operation, its precision, and a function that takes one sample: nanoseconds for one of them.
type Operation = (&'static str, &'static str, fn() -> f64);

const OPERATIONS: &[Operation] = &[
    ("multiply", "f32", || {
        let one = black_box(f32x8::ONE);
        time(start_f32(), |value| value * one)
    }),
    ("add", "f32", || {
        let zero = black_box(f32x8::ZERO);
        time(start_f32(), |value| max8(value + zero, zero)) / 2.0
    }),
    #[cfg(fused)]
    ("fused", "f32", || {
        let (one, zero) = black_box((f32x8::ONE, f32x8::ZERO));
        time(start_f32(), |value| mul_add8(value, one, zero))
    }),
    ("divide", "f32", || {
        let two = black_box(f32x8::splat(2.1));
        time(start_f32(), |value| two / value)
    }),
    ("multiply and add", "f32", || {
        let (one, zero) = black_box((f32x8::ONE, f32x8::ZERO));
        time(start_f32(), |value| value * one + zero) / 2.0
    }),
    ("load", "f32", time_load),
    ("multiply", "f64", || {
        let one = black_box(f64x8::ONE);
        time(start_f64(), |value| value * one)
    }),
    ("add", "f64", || {
        let zero = black_box(f64x8::ZERO);
        time(start_f64(), |value| value + zero)
    }),
    ("divide", "f64", || {
        let two = black_box(f64x8::splat(2.1));
        time(start_f64(), |value| two / value)
    }),
    ("multiply and add", "f64", || {
        let (one, zero) = black_box((f64x8::ONE, f64x8::ZERO));
        time(start_f64(), |value| value * one + zero) / 2.0
    }),
];

/// The samples so far, of each operation.
#[derive(Debug)]
pub(super) struct Rates(Vec<Vec<f64>>);

impl Rates {
    pub(super) fn new() -> Self {
        Self(vec![Vec::new(); OPERATIONS.len()])
    }

    /// Takes one more sample of each operation.
    pub(super) fn sample(&mut self) {
        for (samples, (_, _, take)) in self.0.iter_mut().zip(OPERATIONS) {
            samples.push(take());
        }
    }

    pub(super) fn rows(&self) -> Vec<RateRow> {
        let row = |(samples, (operation, precision, _)): (&Vec<f64>, &Operation)| {
            let ns_per_operation = median(samples);
            RateRow {
                operation: (*operation).into(),
                precision: (*precision).into(),
                ns_per_operation,
                ns_per_operation_mad: mad(samples),
                operations_per_second: 1e9 / ns_per_operation,
                samples: samples.len(),
            }
        };
        self.0.iter().zip(OPERATIONS).map(row).collect()
    }
}

/// What the busiest class of operations of a test takes at least.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Limit {
    /// Nanoseconds for eight tests at once.
    pub(super) ns: f64,
    /// As in [`RateRow::operation`].
    pub(super) class: &'static str,
}

impl Limit {
    /// `None` where a rate is missing. What is counted in `f64` takes its own time in the same units.
    pub(super) fn of(operations: &OperationCounts, rates: &[RateRow]) -> Option<Self> {
        let ns = |operation: &str, precision: &str, count: u32| {
            let rate = || rates.iter().find(|row| row.operation == operation && row.precision == precision);
            if count == 0 { Some(0.0) } else { rate().map(|row| f64::from(count) * row.ns_per_operation) }
        };
        let OperationCounts { mul, add, compare, div, fused, reads, mul_f64, add_f64, compare_f64, div_f64 } =
            *operations;
        let (multiplied, added_f64) = (mul - mul_f64 - fused, add_f64 + compare_f64);
        let added = add - add_f64 - fused + (compare - compare_f64);
        let fused_ns = ns("fused", "f32", fused)?;
        let classes = [
            ("multiply", ns("multiply", "f32", multiplied)? + ns("multiply", "f64", mul_f64)? + fused_ns),
            ("add", ns("add", "f32", added)? + ns("add", "f64", added_f64)?),
            ("divide", ns("divide", "f32", div - div_f64)? + ns("divide", "f64", div_f64)?),
            ("load", ns("load", "f32", reads)?),
            (
                "multiply and add",
                ns("multiply and add", "f32", multiplied + fused + added)?
                    + ns("multiply and add", "f64", mul_f64 + added_f64)?,
            ),
        ];
        let (class, ns) = classes.into_iter().max_by(|(_, a), (_, b)| a.total_cmp(b))?;
        Some(Self { ns, class })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eight_lanes_take_a_time() {
        let mut rates = Rates::new();
        (0..3).for_each(|_| rates.sample());
        let rows = rates.rows();
        assert_eq!(rows.len(), OPERATIONS.len());
        for row in &rows {
            // From a thousandth of a nanosecond, which would be a loop that the compiler has removed, to a microsecond.
            assert!((1e-3..1e3).contains(&row.ns_per_operation), "{row:?}");
            assert!(row.samples == 3 && (row.operations_per_second * row.ns_per_operation / 1e9 - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn the_busiest_class_sets_the_limit() {
        let row = |operation: &str, precision: &str, ns| RateRow {
            operation: operation.into(),
            precision: precision.into(),
            ns_per_operation: ns,
            ns_per_operation_mad: 0.0,
            operations_per_second: 1e9 / ns,
            samples: 1,
        };
        let mut rates = vec![
            row("multiply", "f32", 1.0),
            row("add", "f32", 1.0),
            row("fused", "f32", 1.0),
            row("divide", "f32", 7.0),
            row("multiply and add", "f32", 0.5),
            row("load", "f32", 0.5),
            row("multiply", "f64", 2.0),
            row("add", "f64", 2.0),
            row("divide", "f64", 14.0),
            row("multiply and add", "f64", 1.0),
        ];
        let none = OperationCounts {
            mul: 0,
            add: 0,
            compare: 0,
            div: 0,
            fused: 0,
            reads: 0,
            mul_f64: 0,
            add_f64: 0,
            compare_f64: 0,
            div_f64: 0,
        };
        let limit = |operations: OperationCounts| Limit::of(&operations, &rates).map(|limit| (limit.class, limit.ns));
        assert_eq!(limit(OperationCounts { mul: 9, add: 4, compare: 4, ..none }), Some(("multiply", 9.0)));
        assert_eq!(limit(OperationCounts { mul: 4, add: 4, compare: 5, ..none }), Some(("add", 9.0)));
        assert_eq!(limit(OperationCounts { mul: 9, div: 2, ..none }), Some(("divide", 14.0)));
        assert_eq!(limit(OperationCounts { mul: 9, reads: 20, ..none }), Some(("load", 10.0)));
        // A fused pair is one operation, of the multiplier.
        assert_eq!(limit(OperationCounts { mul: 9, add: 9, fused: 9, compare: 8, ..none }), Some(("multiply", 9.0)));
        assert_eq!(limit(OperationCounts { mul: 9, mul_f64: 9, add: 1, ..none }), Some(("multiply", 18.0)));
        assert_eq!(limit(OperationCounts { mul: 3, div: 2, div_f64: 1, ..none }), Some(("divide", 21.0)));
        rates.retain(|row| row.operation != "divide");
        let limit = |operations: OperationCounts| Limit::of(&operations, &rates);
        assert_eq!(limit(OperationCounts { div: 1, ..none }), None);
        assert!(limit(OperationCounts { mul: 1, ..none }).is_some(), "what is not needed need not be known");
    }
}
