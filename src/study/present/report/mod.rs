//! The report: `report.md`, the record in words and tables, and `report.html`, the same as one page. Every figure comes
//! from the record.

mod accuracy;
mod advice;
mod cells;
mod failures;
mod html;
mod kernels;
mod method;
mod packets;
mod tracer;

#[cfg(test)]
pub(crate) use advice::advice_table;
pub(crate) use html::report_html;

use crate::study::figures::{groups, groups_of_methods};
use crate::study::present::chart::{PEERS, SPEED_ACCURACY};
use crate::study::present::{peers, verdict};
use crate::study::record::{Record, date};

/// The report in Markdown. It refers to the chart files, which must be in the same folder.
pub(crate) fn report_markdown(record: &Record) -> String {
    let groups = groups(record);
    let methods = groups_of_methods(record);
    let mut parts = vec![title(record)];
    parts.extend(verdict::verdict_list(&groups));
    parts.push(format!("![Speed against accuracy of every kernel]({SPEED_ACCURACY})"));
    parts.extend(verdict::noise(record, &groups));
    parts.extend([
        advice::advice(&groups),
        advice::legend(&groups),
        kernels::KERNELS.to_owned(),
        kernels::kernel_table(&groups),
    ]);
    parts.extend(packets::section(record, &groups));
    parts.extend(failures::absent(record));
    parts.extend(failures::stability(record, &methods));
    parts.extend(failures::transforms_and_quadrics(record, &methods));
    parts.extend(failures::failure_maps(record, &methods));
    parts.extend(failures::claims(record, &groups));
    parts.push(accuracy::ACCURACY.to_owned());
    for workload in accuracy::workloads(record) {
        let kernels = || groups.iter().flat_map(|group| &group.kernels);
        let rows: Vec<_> = kernels().filter_map(|kernel| Some((kernel, kernel.accuracy(workload)?))).collect();
        parts.push(format!("### Workload `{workload}`"));
        parts.extend([accuracy::wrong_answers(&rows), accuracy::errors(&rows), accuracy::hits(&rows)]);
    }
    parts.extend(tracer::throughput(record));
    parts.extend(tracer::coherence(record));
    parts.extend(tracer::several_threads(record, &groups));
    parts.extend(tracer::memory(record, &groups));
    if !record.peers.is_empty() {
        parts.push(format!("## Peers\n\n{}", peers::LEGEND));
        parts.push(format!("![Rays per second of raylanes and its peers]({PEERS})"));
        for (heading, grid) in peers::rates(&record.peers) {
            parts.push(format!("### {heading}\n\n{}", grid.markdown()));
        }
    }
    parts.extend([
        method::METHOD.to_owned(),
        method::machine(record),
        method::sources(record),
        method::checksums(record),
    ]);
    parts.iter().map(|part| part.trim_end()).collect::<Vec<_>>().join("\n\n") + "\n"
}

fn title(record: &Record) -> String {
    let quick =
        if record.quick { " This was a quick run with fewer rays and samples: do not quote its figures." } else { "" };
    format!(
        "# Speed and accuracy of {} intersection kernels\n\n{}, {}, {} logical processors, {}.{quick}",
        record.methods.len(),
        date(record.started_unix),
        record.machine.cpu,
        record.machine.processors,
        record.machine.rustc
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::figures::failures::Metric;
    use crate::study::present::chart::charts;
    use crate::study::record::RegimeRow;
    use crate::study::tests::fixture::{all_ids, degenerate_records, record_of};

    #[test]
    fn every_kernel_is_in_every_table() {
        let record = record_of(&all_ids());
        let report = report_markdown(&record);
        let methods = groups_of_methods(&record);
        for kernel in &record.methods {
            // Tables of kernels, packets, claims and checksums, three tables for each of two workloads, and for each
            // regime one for each metric and one of hits.
            let mut groups = methods.iter();
            let group = groups.find(|group| group.kernels.iter().any(|shown| shown.method.id == kernel.id));
            let is_shown = |regime: &&RegimeRow| group.is_some_and(|group| group.title == regime.family);
            let regimes = record.regimes.iter().filter(is_shown);
            let tables = 10 + regimes.map(|regime| Metric::of(regime).len() + 1).sum::<usize>();
            assert_eq!(report.matches(&format!("\n| `{}` |", kernel.id)).count(), tables, "{}", kernel.id);
        }
        for chart in charts(&record) {
            assert!(report.contains(&format!("]({})", chart.file)), "{}", chart.file);
        }
        assert!(report.contains("- `triangle/elsewhere`: needs fused multiply-add"));
    }

    #[test]
    fn a_zero_rate_is_shown_with_its_bound() {
        let mut record = record_of(&["triangle/cramer".into()]);
        record.regimes.clear();
        let report = report_markdown(&record);
        assert!(report.contains("| 0 (< 15) / 200 k |"), "the bound of zero leaks in 200,000 rays");
        assert!(report.contains("loses 0 (< 15) |"), "{report}");
    }

    #[test]
    fn the_advice_names_kernels_that_tie() {
        let mut record = record_of(&["triangle/a".into(), "triangle/b".into()]);
        assert!(!report_markdown(&record).contains("tied with"));
        let times = |record: &mut Record, mad| {
            for row in &mut record.speed {
                row.ns_per_test = if row.id == "triangle/a" { 1.05 } else { 1.0 };
                row.ns_per_test_mad = mad;
            }
        };
        times(&mut record, 0.024);
        assert!(!report_markdown(&record).contains("tied with"));
        times(&mut record, 0.026);
        let report = report_markdown(&record);
        assert!(report.contains("| **`b`** ") && report.contains("; tied with `a`"));
    }

    #[test]
    fn rows_are_as_long_as_their_headers() {
        let report = report_markdown(&record_of(&all_ids()));
        let mut columns = None;
        for line in report.lines() {
            let here = line.starts_with('|').then(|| line.matches(" | ").count());
            assert!(here.is_none() || columns.is_none() || here == columns, "{line}");
            columns = here;
        }
    }

    #[test]
    fn degenerate_records_have_a_report() {
        for record in degenerate_records() {
            let report = report_markdown(&record);
            assert!(!report.contains("NaN") && !report.contains(" inf "), "{report}");
        }
    }
}
