//! Measured throughput of eight-lane operations: the time of one operation when it waits for no other. It gives a lower
//! limit for the time of a kernel whose operations are counted.
//!
//! Each operation runs in independent chains. There are more chains than an operation has cycles of latency. Loads come
//! from the first-level cache.

use std::array::from_fn;
use std::hint::black_box;
use std::time::Instant;

use wide::{f32x8, f64x8};

use super::rounds::{TimedJob, Times, of_job};
use super::stats::{mad, median};
use crate::geom::lanes::max8;
#[cfg(fused)]
use crate::geom::lanes::mul_add8;
use crate::study::record::RateRow;
use crate::tracer::Error;

/// Number of chains: as many as fit into the registers.
const CHAINS: usize = if cfg!(any(target_feature = "avx", target_arch = "aarch64")) { 12 } else { 6 };
/// Steps of each chain in a sample. A sample takes a quarter of a millisecond or more.
const STEPS: usize = 1 << 16;

/// Nanoseconds per step of one chain.
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

/// Nanoseconds per load. Loaded values are combined by maxima, which have the same throughput as loads. Logical
/// operations would not do: with wider registers, the compiler could do them on more than eight lanes at once.
fn time_load() -> f64 {
    const ROWS: usize = 4;
    let data = black_box([start_f32(); ROWS]);
    // These must stay in registers, or each step would store them.
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

/// Name of an operation, its precision, and a function that takes one sample: nanoseconds per operation.
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

/// What distinguishes an operation from all other jobs.
fn name(operation: &str, precision: &str) -> String {
    format!("operation {operation}, {precision}")
}

/// Every operation. A sample is the nanoseconds per operation.
pub(crate) fn timed_jobs<'a>() -> impl Iterator<Item = TimedJob<'a>> {
    OPERATIONS.iter().map(|(operation, precision, take)| TimedJob {
        name: name(operation, precision),
        // There is nothing to compare: what is computed depends on nothing.
        sample: Box::new(|| Ok((take(), 0))),
    })
}

/// The rows of all operations, from their times.
///
/// # Errors
/// If an operation was not timed.
pub(crate) fn rows(all: &[Times]) -> Result<Vec<RateRow>, Error> {
    let row = |(operation, precision, _): &Operation| {
        let samples = of_job(all, &name(operation, precision))?.ns.all();
        let ns_per_operation = median(&samples);
        Ok(RateRow {
            operation: (*operation).into(),
            precision: (*precision).into(),
            ns_per_operation,
            ns_per_operation_mad: mad(&samples),
            operations_per_second: 1e9 / ns_per_operation,
            samples: samples.len(),
        })
    };
    OPERATIONS.iter().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::measure::rounds::{merge, take};

    #[test]
    fn every_operation_takes_a_plausible_time() {
        let jobs: Vec<_> = timed_jobs().collect();
        let times = take(&jobs, 3, &mut |_| Ok(())).unwrap();
        let rows = rows(&merge(&[times]).unwrap()).unwrap();
        assert_eq!(rows.len(), OPERATIONS.len());
        for row in &rows {
            // Below a thousandth of a nanosecond, the compiler would have removed the loop.
            assert!((1e-3..1e3).contains(&row.ns_per_operation), "{row:?}");
            assert!(row.samples == 3 && (row.operations_per_second * row.ns_per_operation / 1e9 - 1.0).abs() < 1e-9);
        }
        assert!(super::rows(&[]).is_err());
    }
}
