//! The table of all kernels: times, bytes, operations and claims.

use super::cells::{code, with_interval};
use crate::study::figures::{Group, MISSING, number};
use crate::study::present::grid::{Cell, Grid};
use crate::study::record::{OperationCounts, SpeedRow};

/// The introduction to [`kernel_table`].
pub(super) const KERNELS: &str = "\
## Kernels

Times are nanoseconds per test of one ray against one primitive in one thread: the median, and in brackets its 95 % \
interval. In each group, the fastest kernel and all that tie with it are bold. `1x1` is one ray against one primitive \
(scalar), `8x1` is eight rays against one primitive, `1x8` is one ray against eight primitives.

*Bytes* are prepared per primitive. The *setup* is computed once per ray: its bytes (scalar), and its nanoseconds per \
ray, scalar / in a packet. *Operations* are those of one test without early exits: multiplications / additions / \
comparisons, minima and maxima / divisions and roots. The number in brackets is how many of them are in `f64`. Tests \
enforce the *claims* without tolerance.";

/// Kernel × width, with what each kernel prepares, computes and claims.
pub(super) fn kernel_table(groups: &[Group]) -> String {
    let header = ["kernel", "1x1 ns", "8x1 ns", "1x8 ns", "bytes", "setup bytes", "setup ns", "operations", "claims"];
    let mut grid = Grid::new(1, header);
    for group in groups {
        for kernel in &group.kernels {
            let mut row = vec![code(&kernel.method.id)];
            row.extend(["1x1", "8x1", "1x8"].map(|width| {
                let with_interval =
                    |row: &SpeedRow| with_interval(row.ns_per_test, row.ns_per_test_low, row.ns_per_test_high);
                let time = kernel.speed(width, 1).map_or(MISSING.to_owned(), with_interval);
                Cell::from(time).best_if(group.is_among_the_fastest(kernel, width))
            }));
            let info = kernel.method;
            let claims = if info.claims.is_empty() { MISSING.to_owned() } else { info.claims.join(", ") };
            row.extend([
                Cell::from(info.prepared_bytes.to_string()),
                Cell::from(info.setup_bytes.to_string()),
                Cell::from(format!("{} / {}", number(info.setup_ns, 2), number(info.setup_ns_packet, 2))),
                Cell::from(operations(&info.operations)),
                Cell::from(claims),
            ]);
            grid.rows.push(row);
        }
    }
    grid.markdown()
}

/// Multiplications, additions, comparisons and divisions; in brackets, how many of them are in `f64`.
fn operations(counts: &OperationCounts) -> String {
    let OperationCounts { mul, add, compare, div, mul_f64, add_f64, compare_f64, div_f64, .. } = *counts;
    let pairs = [(mul, mul_f64), (add, add_f64), (compare, compare_f64), (div, div_f64)];
    let text = |(all, in_f64)| if in_f64 == 0 { format!("{all}") } else { format!("{all} ({in_f64})") };
    pairs.map(text).join(" / ")
}
