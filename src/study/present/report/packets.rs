//! The section on packets: their gain over scalar code, and how close they come to the machine's limit.

use super::cells::code;
use crate::study::figures::{Group, KernelFigures, MISSING, count, number, percent, times};
use crate::study::present::chart::PACKETS;
use crate::study::present::grid::{Cell, Grid};
use crate::study::record::{RateRow, Record};

/// Lanes of a packet: the ideal gain.
const IDEAL: f64 = 8.0;

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
    use crate::study::tests::fixture::{all_ids, degenerate_records, record_of};

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
