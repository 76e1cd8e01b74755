//! The report: the answer (`report.md`), and the appendix (`appendix.md`) with everything that was measured. Both are
//! written as pages too. Every figure comes from the record.

mod accuracy;
mod advice;
mod answer;
mod cells;
mod failures;
mod html;
mod kernels;
mod method;
mod on_scenes;
mod other_build;
mod packets;
mod renderer;
mod tracer;

pub(crate) use html::report_html;

use crate::study::figures::groups;
use crate::study::present::chart::{ON_SCENES, PEERS, SPEED_ACCURACY};
use crate::study::present::{peers, verdict};
use crate::study::record::{Record, date};

/// The answer in Markdown: the first page. It refers to two charts and to every section of the appendix, in the same
/// folder.
pub(crate) fn answer_markdown(record: &Record, appendix: &str) -> String {
    let groups = groups(record);
    let mut base: Vec<_> = groups.iter().filter(|group| group.is_base()).collect();
    // Triangles first, because most pictures are made of them.
    base.sort_by_key(|group| group.shape != "triangle");
    let mut parts = vec![title(record, "Which ray-intersection kernel to use")];
    parts.extend(verdict::verdict_list(record, &groups));
    if !record.on_scenes.is_empty() {
        parts.push(format!("![The same scenes with every kernel: speed, lost rays, false hits]({ON_SCENES})"));
    }
    parts.push(format!("![Single tests: speed, lost rays, false or double hits]({SPEED_ACCURACY})"));
    parts.extend(advice::section(record));
    parts.extend([answer::what_fails(record, &base)]);
    parts.extend(answer::how_to_choose(record, &base));
    parts.extend(verdict::noise(record, &groups).map(|noise| format!("## How sure this is\n\n{noise}")));
    let sections = appendix.lines().filter_map(|line| line.strip_prefix("## "));
    let links = sections.map(|heading| format!("- [{heading}](appendix.md#{})", html::anchor(heading)));
    parts.push(format!("## The appendix\n\n{}", links.collect::<Vec<_>>().join("\n")));
    joined(&parts)
}

/// The appendix in Markdown: everything that was measured. It refers to the chart files, which must be in the same
/// folder.
pub(crate) fn appendix_markdown(record: &Record) -> String {
    let groups = groups(record);
    let mut parts =
        vec![title(record, &format!("Speed and accuracy of {} intersection kernels", record.methods.len()))];
    let base: Vec<_> = groups.iter().filter(|group| group.is_base()).collect();
    parts.push(format!("## The figures of the first page\n\n{}", answer::figures(record, &base)));
    parts.extend(on_scenes::section(record));
    parts.extend(renderer::section(record, &base));
    parts.extend([kernels::KERNELS.to_owned(), kernels::kernel_table(&groups), kernels::loop_and_cache(record)]);
    parts.extend(other_build::section(record, &groups));
    parts.extend(packets::section(record, &groups));
    parts.extend(failures::absent(record));
    parts.extend(failures::stability(record, &groups));
    parts.extend(failures::transforms_and_quadrics(record, &groups));
    parts.extend(failures::failure_maps(record, &groups));
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
    joined(&parts)
}

/// Parts with an empty line between them.
fn joined(parts: &[String]) -> String {
    parts.iter().map(|part| part.trim_end()).collect::<Vec<_>>().join("\n\n") + "\n"
}

fn title(record: &Record, title: &str) -> String {
    let quick =
        if record.quick { " This was a quick run with fewer rays and samples: do not quote its figures." } else { "" };
    format!(
        "# {title}\n\n{}, {}, {} logical processors, {}.{quick}",
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
    use crate::study::tests::fixture::{all_ids, degenerate_records, record_of};

    fn both(record: &Record) -> [String; 2] {
        let appendix = appendix_markdown(record);
        [answer_markdown(record, &appendix), appendix]
    }

    #[test]
    fn every_kernel_is_in_every_table() {
        let record = record_of(&all_ids());
        let [answer, appendix] = both(&record);
        let groups = groups(&record);
        for kernel in &record.methods {
            let mut with_kernel =
                groups.iter().filter(|group| group.kernels.iter().any(|shown| shown.method.id == kernel.id));
            let group = with_kernel.next().expect("every kernel has a group");
            // Tables of kernels, packets, claims and checksums, three tables for each of two workloads, for each regime
            // one for each metric and one of hits.
            let regimes = record.regimes.iter().filter(|regime| regime.family == group.title);
            let tables = 10 + regimes.map(|regime| Metric::of(regime).len() + 1).sum::<usize>();
            let scenes = record.on_scenes.iter().filter(|row| row.kernel == kernel.id && row.rays == "primary").count();
            let rows = |text: &str| {
                let row = |line: &&str| line.starts_with(&format!("| `{}` |", kernel.id));
                text.lines().filter(row).count() + text.matches(&format!("\n| **`{}`** |", kernel.id)).count()
            };
            // The figures of the first page; and, except for boxes, the points of a renderer.
            let of_base = usize::from(group.is_base()) * if group.shape == "aabb" { 1 } else { 2 };
            assert_eq!(rows(&appendix), tables + scenes + of_base, "{}", kernel.id);
            assert_eq!(rows(&answer), usize::from(group.is_base()), "{}", kernel.id);
        }
        for chart in charts(&record) {
            assert!((answer.clone() + &appendix).contains(&format!("]({})", chart.file)), "{}", chart.file);
        }
        assert!(appendix.contains("- `triangle/elsewhere`: needs fused multiply-add"));
    }

    #[test]
    fn the_answer_is_short_and_links_to_every_section_of_the_appendix() {
        let record = record_of(&all_ids());
        let [answer, appendix] = both(&record);
        assert!(answer.lines().count() < 120, "{answer}");
        let page = report_html(&appendix, &charts(&record));
        let links: Vec<_> = answer.split("(appendix.md#").skip(1).filter_map(|rest| rest.split(')').next()).collect();
        assert_eq!(links.len(), appendix.matches("\n## ").count());
        for link in links {
            assert!(page.contains(&format!("<h2 id=\"{link}\">")), "{link}");
        }
        assert!(report_html(&answer, &[]).contains("<a href=\"appendix.html#kernels\">"));
    }

    #[test]
    fn a_zero_rate_is_shown_with_its_bound() {
        let mut record = record_of(&["triangle/cramer".into()]);
        record.regimes.clear();
        let report = appendix_markdown(&record);
        assert!(report.contains("| 0 (< 18) / 200 k |"), "the bound of zero leaks in 200,000 rays");
    }

    #[test]
    fn rows_are_as_long_as_their_headers() {
        let record = record_of(&all_ids());
        for report in both(&record) {
            let mut columns = None;
            for line in report.lines() {
                let here = line.starts_with('|').then(|| line.matches(" | ").count());
                assert!(here.is_none() || columns.is_none() || here == columns, "{line}");
                columns = here;
            }
        }
    }

    #[test]
    fn degenerate_records_have_a_report() {
        for record in degenerate_records() {
            for report in both(&record) {
                assert!(!report.contains("NaN") && !report.contains(" inf "), "{report}");
            }
        }
    }
}
