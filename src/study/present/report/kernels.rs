//! Every kernel: its times, its bytes, its operations and its claims.

use super::cells::{code, with_mad};
use crate::study::figures::{Group, MISSING, number};
use crate::study::present::grid::{Cell, Grid};
use crate::study::record::OperationCounts;

pub(super) const KERNELS: &str = "\
## Kernels

Nanoseconds per test of one ray against one primitive in one thread, median ± median absolute deviation; smaller is \
faster, and the fastest of each family is bold, with all that tie with it. `1x1` is one ray and one primitive (scalar), `8x1` eight rays against one \
primitive, `1x8` one ray against eight primitives. Bytes are prepared per primitive. The setup is computed once \
per ray: its bytes (scalar), and its nanoseconds per ray, scalar / in a packet. Operations are multiplications / additions / \
comparisons, minima and maxima / divisions and roots of one test that is computed to its end, in brackets those of them in \
`f64`. Claims are held by the tests without tolerance.";

pub(super) fn kernel_table(groups: &[Group]) -> String {
    let header = ["kernel", "1x1 ns", "8x1 ns", "1x8 ns", "bytes", "setup bytes", "setup ns", "operations", "claims"];
    let mut grid = Grid::new(1, header);
    for group in groups {
        for kernel in &group.kernels {
            let mut row = vec![code(&kernel.kernel.id)];
            row.extend(["1x1", "8x1", "1x8"].map(|face| {
                let time = kernel
                    .speed(face, 1)
                    .map_or(MISSING.to_owned(), |row| with_mad(row.ns_per_test, row.ns_per_test_mad));
                Cell::from(time).best_if(group.is_among_the_fastest(kernel, face))
            }));
            let info = kernel.kernel;
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

/// Multiplications, additions, comparisons and divisions, with what is in `f64` in brackets.
fn operations(counts: &OperationCounts) -> String {
    let OperationCounts { mul, add, compare, div, mul_f64, add_f64, compare_f64, div_f64, .. } = *counts;
    let pairs = [(mul, mul_f64), (add, add_f64), (compare, compare_f64), (div, div_f64)];
    let text = |(all, double)| if double == 0 { format!("{all}") } else { format!("{all} ({double})") };
    pairs.map(text).join(" / ")
}
