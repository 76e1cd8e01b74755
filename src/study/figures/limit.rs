//! The limit of a kernel: the least time it could take on this machine. It is the number of its operations, counted by
//! hand, times their measured rates.

use crate::study::record::{OperationCounts, RateRow};

/// The least time of the busiest class of a kernel's operations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Limit {
    /// Nanoseconds for eight tests at once.
    pub(crate) ns: f64,
    /// The busiest class, as in [`RateRow::operation`].
    pub(crate) class: &'static str,
}

impl Limit {
    /// The limit of these operations; `None` if a rate that it needs is missing. Operations in `f64` use the same units
    /// of the processor, but have rates of their own.
    pub(crate) fn of(operations: &OperationCounts, rates: &[RateRow]) -> Option<Self> {
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
        // A fused multiply-add is one operation of the multiplier.
        assert_eq!(limit(OperationCounts { mul: 9, add: 9, fused: 9, compare: 8, ..none }), Some(("multiply", 9.0)));
        assert_eq!(limit(OperationCounts { mul: 9, mul_f64: 9, add: 1, ..none }), Some(("multiply", 18.0)));
        assert_eq!(limit(OperationCounts { mul: 3, div: 2, div_f64: 1, ..none }), Some(("divide", 21.0)));
        rates.retain(|row| row.operation != "divide");
        let limit = |operations: OperationCounts| Limit::of(&operations, &rates);
        assert_eq!(limit(OperationCounts { div: 1, ..none }), None);
        assert!(
            limit(OperationCounts { mul: 1, ..none }).is_some(),
            "a missing rate does not matter if it is not needed"
        );
    }
}
