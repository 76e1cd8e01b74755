//! The section on packets: their gain over scalar code, and how close they come to the machine's limit.

use super::cells::code;
use crate::study::figures::{Group, KernelFigures, MISSING, count, number, percent, times};
use crate::study::present::chart::PACKETS;
use crate::study::present::grid::{Cell, Grid};
use crate::study::record::{OperationCounts, RateRow, Record};

/// Lanes of a packet: the ideal gain.
const IDEAL: f64 = 8.0;
/// The report explains a gain below this.
const GOOD: f64 = 7.0;

/// The section; empty if no kernel was timed at both widths.
pub(super) fn section(record: &Record, groups: &[Group]) -> Vec<String> {
    let kernels: Vec<&KernelFigures> =
        groups.iter().flat_map(|group| &group.kernels).filter(|one| one.gain().is_some()).collect();
    if kernels.is_empty() {
        return Vec::new();
    }
    let mut parts = vec![format!(
        "## Packets against scalar code, and the machine's limit\n\n*Gain* is the time of `1x1` over the time of \
         `8x1`, per test; {IDEAL}× would be ideal. The *limit* is the least time for the busiest class of a kernel's \
         operations. It is the number of these operations, as in the table above, times the measured time of one \
         operation that waits for no other. *Multiply and add* is all arithmetic together. Selections, logic and \
         conversions are not counted. The timed pass also keeps the closest hit, which is not counted either. *Share* \
         is the limit over the time of `8x1`. *Scalar share* is the same for `1x1`, as if a scalar operation took as \
         long as an eight-lane one.\n\n\
         Gain = {IDEAL} × share / scalar share. A scalar share above 100 % means that scalar code skips work by early \
         exits and branches. Packets do all the work, and branch only where a result is in doubt. A gain above \
         {IDEAL}× comes from mispredicted branches of scalar code. *Hit* is the share of calls (eight tests or one) in \
         which anything is hit."
    )];
    parts.push(format!("![Gain of packets over scalar code, and share of the limit]({PACKETS})"));
    let header = ["kernel", "gain", "limit ns", "busiest class", "share", "scalar share", "hit 8x1", "hit 1x1"];
    let mut grid = Grid::new(1, header);
    grid.rows.extend(kernels.iter().map(|kernel| row(kernel)));
    parts.push(grid.markdown());
    let explained =
        |kernel: &&KernelFigures| Some(format!("- `{}`: {}", kernel.method.id, explanation(record, kernel)?));
    let explanations: Vec<_> = kernels.iter().filter_map(explained).collect();
    if !explanations.is_empty() {
        parts.push(format!("### Why some kernels gain less than {GOOD}×\n\n{}", explanations.join("\n")));
    }
    if !record.rates.is_empty() {
        parts.push(
            "### Measured throughput of eight-lane operations\n\nOne thread. Data is in registers; loads come from the \
             first-level cache."
                .to_owned(),
        );
        parts.push(rates(&record.rates));
    }
    parts
}

fn row(kernel: &KernelFigures) -> Vec<Cell> {
    let packet = kernel.packet();
    let hits = ["8x1", "1x1"].map(|width| percent(kernel.speed(width, 1).map(|row| row.hit_share)));
    let limit = packet.and_then(|row| Some(format!("{} of {}", number(row.limit_ns?, 3), number(row.ns_per_test, 3))));
    let class = packet.and_then(|row| row.limit_by.clone());
    let [hit_packets, hit_rays] = hits;
    vec![
        code(&kernel.method.id),
        Cell::from(times(kernel.gain())),
        Cell::from(limit.unwrap_or(MISSING.to_owned())),
        Cell::from(class.unwrap_or(MISSING.to_owned())),
        Cell::from(percent(kernel.limit_share())),
        Cell::from(percent(kernel.scalar_limit_share())),
        Cell::from(hit_packets),
        Cell::from(hit_rays),
    ]
}

/// Why a kernel's packets gain less than [`GOOD`], from counts and measurements; `None` if they gain enough.
fn explanation(record: &Record, kernel: &KernelFigures) -> Option<String> {
    let gain = kernel.gain().filter(|&gain| gain < GOOD)?;
    let mut reasons = vec![times(Some(gain))];
    if let (Some(packet), Some(scalar)) = (kernel.limit_share(), kernel.scalar_limit_share()) {
        let [packets, rays] = [packet, scalar].map(|share| percent(Some(share)));
        reasons.push(if scalar > 1.0 {
            format!("scalar code skips work (its share of the limit is {rays})")
        } else {
            format!("scalar code is closer to its limit than packets are: {IDEAL} × {packets} / {rays}")
        });
    }
    // Only for triangles: the test of a box has little to skip, and that of a quadric ends with its roots.
    if let Some(hits) = kernel.speed("1x1", 1).filter(|row| row.id.contains("triangle/")).map(|row| row.hit_share) {
        let none = percent(Some(1.0 - hits));
        reasons.push(format!("scalar code exits early on a miss, in {none} of the tests; packets do not"));
    }
    let OperationCounts { mul, add, mul_f64, add_f64, .. } = kernel.method.operations;
    let takes = |precision| record.rates.iter().find(|row| row.operation == "multiply" && row.precision == precision);
    if let (Some(in_f32), Some(in_f64)) = (takes("f32"), takes("f64"))
        && 2 * (mul_f64 + add_f64) > mul + add
    {
        let ratio = in_f64.ns_per_operation / in_f32.ns_per_operation;
        reasons.push(format!("eight lanes of `f64` take {} as long as eight lanes of `f32`", times(Some(ratio))));
    }
    Some(reasons.join("; "))
}

fn rates(rows: &[RateRow]) -> String {
    let mut grid = Grid::new(2, ["operation", "precision", "ns", "billions per second", "samples"]);
    grid.rows.extend(rows.iter().map(|row| {
        vec![
            Cell::from(row.operation.as_str()),
            Cell::from(row.precision.as_str()),
            Cell::from(format!("{} ± {}", number(row.ns_per_operation, 3), number(row.ns_per_operation_mad, 1))),
            Cell::from(number(row.operations_per_second / 1e9, 3)),
            Cell::from(count(row.samples as u64)),
        ]
    }));
    grid.markdown()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::figures::groups;
    use crate::study::figures::summary;
    use crate::study::tests::fixture::{all_ids, degenerate_records, record_of};

    fn explained(record: &Record, id: &str) -> Option<String> {
        let groups = groups(record);
        let kernel = groups.iter().flat_map(|group| &group.kernels).find(|kernel| kernel.method.id == id).unwrap();
        explanation(record, kernel)
    }

    #[test]
    fn a_small_gain_is_explained_by_counts_and_measurements() {
        let mut record = record_of(&["triangle/cramer".into(), "triangle/moller_trumbore_f64".into()]);
        let set = |record: &mut Record, scalar: f64, packet: f64| {
            for row in &mut record.speed {
                row.ns_per_test = if row.width == "1x1" { scalar } else { packet };
            }
            record.kernels = summary::kernels(record);
        };
        // The limit is 52 operations of 0.08 ns for eight tests.
        set(&mut record, 5.2, 1.04);
        let text = explained(&record, "triangle/cramer").unwrap();
        assert!(
            text.starts_with("5.00×; scalar")
                && text.contains("8 × 50 % / 80 %")
                && text.contains("exits early on a miss, in 89 % of the tests"),
            "{text}"
        );
        assert!(!text.contains("f64"), "{text}");
        assert!(explained(&record, "triangle/moller_trumbore_f64").unwrap().contains("`f64` take 2.00× as long"));
        set(&mut record, 3.0, 1.0);
        assert!(
            explained(&record, "triangle/cramer").unwrap().contains("skips work (its share of the limit is 139 %)")
        );
        set(&mut record, 7.1, 1.0);
        assert_eq!(explained(&record, "triangle/cramer"), None);
    }

    #[test]
    fn every_kernel_that_was_timed_is_in_the_table() {
        let record = record_of(&all_ids());
        let text = section(&record, &groups(&record)).join("\n\n");
        for method in &record.methods {
            assert_eq!(text.matches(&format!("\n| `{}` |", method.id)).count(), 1, "{}", method.id);
        }
        for record in degenerate_records() {
            let text = section(&record, &groups(&record)).join("\n\n");
            assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
        }
    }
}
