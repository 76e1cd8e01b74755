//! The table of all kernels: times, bytes, operations and claims.

use super::cells::{code, with_interval};
use crate::study::figures::{Group, MISSING, number};
use crate::study::present::grid::{Cell, Grid};
use crate::study::record::{OperationCounts, Record, SpeedRow};

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

/// What the timed loop itself takes, and which data exceed the first-level cache.
pub(super) fn loop_and_cache(record: &Record) -> String {
    let rows = record.loops.iter().filter(|row| row.threads == 1);
    let times = rows.map(|row| {
        let time = with_interval(row.ns_per_test, row.ns_per_test_low, row.ns_per_test_high);
        format!("{} {time} ns", row.width)
    });
    let times: Vec<_> = times.collect();
    let none = if times.is_empty() { "not measured" } else { "" };
    let loops = format!(
        "Of these times, the loop itself takes: {}{none}. This is the same loop with a test that is one comparison and \
         never holds. It is not subtracted.",
        times.join(", ")
    );
    let bytes = || record.methods.iter().map(|method| method.set_bytes);
    let (Some(least), Some(most)) = (bytes().min(), bytes().max()) else { return loops };
    let cache = match record.machine.first_level_cache_bytes {
        None => "The size of the first-level cache is unknown.".to_owned(),
        Some(cache) => {
            let beyond: Vec<_> = record.methods.iter().filter(|method| method.set_bytes as u64 > cache).collect();
            let names: Vec<_> = beyond.iter().take(4).map(|method| format!("`{}`", method.id)).collect();
            let others = if beyond.len() > 4 { " and others" } else { "" };
            let which = if beyond.is_empty() {
                "none".to_owned()
            } else {
                format!("{} of {} ({}{others})", beyond.len(), record.methods.len(), names.join(", "))
            };
            format!("The first-level cache has {}. Larger than that: {which}.", kilobytes(cache))
        }
    };
    format!(
        "{loops}\n\nThe data of a set, which are 512 rays, 32 prepared primitives and the hits, take {} to {}. {cache}",
        kilobytes(least as u64),
        kilobytes(most as u64)
    )
}

fn kilobytes(bytes: u64) -> String {
    format!("{} KiB", number(bytes as f64 / 1024.0, 3))
}

/// Multiplications, additions, comparisons and divisions; in brackets, how many of them are in `f64`.
fn operations(counts: &OperationCounts) -> String {
    let OperationCounts { mul, add, compare, div, mul_f64, add_f64, compare_f64, div_f64, .. } = *counts;
    let pairs = [(mul, mul_f64), (add, add_f64), (compare, compare_f64), (div, div_f64)];
    let text = |(all, in_f64)| if in_f64 == 0 { format!("{all}") } else { format!("{all} ({in_f64})") };
    pairs.map(text).join(" / ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::tests::fixture::{degenerate_records, record_of};

    #[test]
    fn the_report_names_the_time_of_the_loop_and_the_data_that_exceed_the_cache() {
        let mut record = record_of(&["triangle/a".into(), "triangle/b".into()]);
        let text = |record: &Record| loop_and_cache(record);
        assert!(text(&record).contains("1x1 0.500 (0.494 to 0.506) ns, 8x1 0.125 ("));
        let expected = "take 39.1 KiB to 40.0 KiB. The first-level cache has 48.0 KiB. Larger than that: none";
        assert!(text(&record).contains(expected), "{}", text(&record));
        record.machine.first_level_cache_bytes = Some(40_500);
        assert!(text(&record).contains("has 39.6 KiB. Larger than that: 1 of 2 (`triangle/b`)."), "{}", text(&record));
        record.machine.first_level_cache_bytes = None;
        assert!(text(&record).ends_with("The size of the first-level cache is unknown."));
        for record in degenerate_records() {
            assert!(!text(&record).contains("NaN"));
        }
    }
}
