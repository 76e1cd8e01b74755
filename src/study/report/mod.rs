//! `report.md`: the record in words and tables. Every figure in it comes from the record.

mod failures;
mod html;
mod packets;
mod tracer;
mod verdict;

pub(super) use html::report_html;
pub(super) use verdict::verdict;

use crate::study::chart::{PEERS, SPEED_ACCURACY};
use crate::study::date::date;
use crate::study::figures::{
    Cell, Figures, Grid, Group, Loss, MISSING, Rate, count, groups, groups_of_methods, number, severity, si, tied,
    times,
};
use crate::study::peers::tables;
use crate::study::record::{AccuracyRow, OperationCounts, Record, SpeedRow};

/// The report, in Markdown; it shows the charts, which belong beside it.
pub(super) fn report_markdown(record: &Record) -> String {
    let groups = groups(record);
    let methods = groups_of_methods(record);
    let mut parts = vec![title(record)];
    parts.extend(verdict_list(&groups));
    parts.push(format!("![Speed against accuracy of every kernel]({SPEED_ACCURACY})"));
    parts.extend(verdict::noise(record, &groups));
    parts.extend([advice(&groups), legend(&groups), KERNELS.to_owned(), kernel_table(&groups)]);
    parts.extend(packets::section(record, &groups));
    parts.extend(failures::absent(record));
    parts.extend(failures::stability(record, &methods));
    parts.extend(failures::transforms_and_quadrics(record, &methods));
    parts.extend(failures::failure_maps(record, &methods));
    parts.extend(failures::claims(record, &groups));
    parts.push(ACCURACY.to_owned());
    for workload in workloads(record) {
        let kernels = || groups.iter().flat_map(|group| &group.kernels);
        let rows: Vec<_> = kernels().filter_map(|kernel| Some((kernel, kernel.accuracy(workload)?))).collect();
        parts.push(format!("### Workload `{workload}`"));
        parts.extend([wrong_answers(&rows), errors(&rows)]);
    }
    parts.extend(tracer::throughput(record));
    parts.extend(tracer::coherence(record));
    parts.extend(tracer::several_threads(record, &groups));
    parts.extend(tracer::memory(record, &groups));
    if !record.peers.is_empty() {
        parts.push(format!("## Peers\n\n{}", tables::LEGEND));
        parts.push(format!("![Rays per second of raylanes and its peers]({PEERS})"));
        for (heading, grid) in tables::rates(&record.peers) {
            parts.push(format!("### {heading}\n\n{}", grid.markdown()));
        }
    }
    parts.extend([METHOD.to_owned(), machine(record), sources(record), checksums(record)]);
    parts.iter().map(|part| part.trim_end()).collect::<Vec<_>>().join("\n\n") + "\n"
}

/// The verdict as a list, if there is one.
fn verdict_list(groups: &[Group]) -> Option<String> {
    let lines: Vec<_> = verdict(groups).into_iter().map(|line| format!("- {line}")).collect();
    (!lines.is_empty()).then(|| lines.join("\n"))
}

const KERNELS: &str = "\
## Kernels

Nanoseconds per test of one ray against one primitive in one thread, median ± median absolute deviation; smaller is \
faster, and the fastest of each family is bold, with all that tie with it. `1x1` is one ray and one primitive (scalar), `8x1` eight rays against one \
primitive, `1x8` one ray against eight primitives. Bytes are prepared per primitive. The setup is computed once \
per ray: its bytes (scalar), and its nanoseconds per ray, scalar / in a packet. Operations are multiplications / additions / \
comparisons, minima and maxima / divisions and roots of one test that is computed to its end, in brackets those of them in \
`f64`. Claims are held by the tests without tolerance.";

const ACCURACY: &str = "\
## Accuracy

Against an oracle in exact arithmetic. Twins give the same bits, so that one row stands for every face of a kernel. Rates \
are per million of the number behind the slash; where nothing was observed, the bracket gives the 95 % bound, three in \
that number.

- *false miss*: pairs of ray and primitive that exactly hit strictly inside, reported as misses.
- *false hit*: pairs that exactly miss, reported as hits.
- *leak*: rays that exactly hit a mesh, edges included, reported to hit nothing of it.
- *double*: rays that exactly hit one triangle strictly inside and no other, reported to hit several.
- *boundary*: rays that exactly hit an edge or a vertex, or a quadric where that hangs on an equality (tangent, at a plane \
of its box, at an end of the interval), by how many hits were reported: none / one / more.
- *ulp*: distance of `t` from the correctly rounded one, in representable numbers, over hits both agree on. The 99th \
percentile is the one to compare; the greatest is noise.
- *gross*: hits that both agree on whose `t` is off by more than 1 %.
- *u, v*: absolute error of the surface parameters; for a box, of the exit distance.";

const METHOD: &str = "\
## Method and bias

**What a test is.** Rays find their closest hit among a small set of primitives, as in the leaf of a tracer, with everything \
in the first-level cache. The time per test is that of the whole, divided by rays times primitives: loading, the test, \
keeping the closer hit by blends, and each ray's setup, spread over the primitives. No rays are timed twice in a row: what \
a processor remembers of branches is no help, here as in a tracer. Missing are the cache misses of a real traversal: expect \
kernels to differ less in a tracer than here, and one with many prepared bytes to do worse.

**What is compared.** Times are medians of repeated samples, those of all kernels interleaved, with their median absolute \
deviation (MAD). Two kernels tie where their medians differ by no more than the sum of both. Other programs may share the \
machine, and clock rates drift: trust ratios between rows of one record, rather than absolute figures or ratios between \
records.

**What the errors are errors of.** Rays are seeded and aimed. `generic` rays go into and past a primitive of about unit size \
from a few units away; `edge` rays go to edges, vertices, corners and planes, and to the silhouettes, rims and apices of quadrics. The rates describe these workloads: a picture \
meets an edge far more rarely, and harder geometry (slivers, great distances) may err far more.

**What ties the two together.** The scalar and the packet form of a kernel are written apart and give identical bits; the \
checksums below, equal for all faces and thread counts, say so for the very rays that were timed.";

fn title(record: &Record) -> String {
    let quick = if record.quick { " This was a quick run, with fewer rays and samples: do not quote it." } else { "" };
    format!(
        "# Speed and accuracy of {} intersection kernels\n\n{}, {}, {} logical processors, {}.{quick}",
        record.methods.len(),
        date(record.started_unix),
        record.machine.cpu,
        record.machine.processors,
        record.machine.rustc
    )
}

fn advice(groups: &[Group]) -> String {
    format!("## Which kernel\n\n{}", advice_table(groups))
}

/// What to use of each group: by speed, by lost rays and by the error of `t`.
fn advice_table(groups: &[Group]) -> String {
    let header = ["kernels", "fastest in packets (8x1)", "fewest lost rays", "most accurate `t`"];
    let mut grid = Grid::new(header.len(), header);
    for group in groups {
        let mut timed: Vec<(&Figures, &SpeedRow)> =
            group.kernels.iter().filter_map(|kernel| Some((kernel, kernel.speed("8x1", 1)?))).collect();
        timed.sort_by(|(_, a), (_, b)| a.ns_per_test.total_cmp(&b.ns_per_test));
        let cells = [fastest(&timed), fewest_lost(&timed), most_accurate(&timed)];
        let mut row = vec![Cell::from(group.heading())];
        row.extend(cells.map(|cell| Cell::from(cell.unwrap_or(MISSING.to_owned()))));
        grid.rows.push(row);
    }
    grid.markdown()
}

/// The kernels of a group, fastest first.
type Timed<'a> = [(&'a Figures<'a>, &'a SpeedRow)];

fn fastest(timed: &Timed) -> Option<String> {
    let &(kernel, row) = timed.first()?;
    let ties = timed[1..].iter().filter(|(_, other)| tied(row, other)).map(|(kernel, _)| kernel.name.as_str());
    let lost = kernel.lost.map_or(String::new(), |lost| format!(", loses {lost}"));
    Some(format!(
        "**`{}`** {} M/s{lost}{}",
        kernel.name,
        number(row.tests_per_second / 1e6, 3),
        list("a tie with", ties)
    ))
}

fn fewest_lost(timed: &Timed) -> Option<String> {
    // A zero over more rays says more, but not that another zero is worse.
    best(timed, |kernel| kernel.lost.map(|lost| lost.per_million), |kernel| kernel.lost.map(|lost| lost.to_string()))
}

fn most_accurate(timed: &Timed) -> Option<String> {
    best(timed, |kernel| kernel.ulp().map(|ulp| ulp as f64), |kernel| Some(format!("{} ulp", count(kernel.ulp()?))))
}

/// The fastest of the kernels with the least `figure`, and its price.
fn best(
    timed: &Timed,
    figure: impl Fn(&Figures) -> Option<f64>,
    text: impl Fn(&Figures) -> Option<String>,
) -> Option<String> {
    let least = timed.iter().filter_map(|(kernel, _)| figure(kernel)).reduce(f64::min)?;
    let equals: Vec<_> = timed.iter().filter(|(kernel, _)| figure(kernel) == Some(least)).collect();
    let (kernel, row) = equals.first()?;
    let price = times(Some(row.ns_per_test / timed[0].1.ns_per_test));
    let (ties, slower): (Vec<_>, Vec<_>) = equals[1..].iter().partition(|(_, other)| tied(row, other));
    let names =
        |of: Vec<&&(&Figures, &SpeedRow)>, remark| list(remark, of.iter().map(|(kernel, _)| kernel.name.as_str()));
    let others = names(ties, "as good, and a tie:") + &names(slower, "as good, but slower:");
    Some(format!("**`{}`** {}, {price} the time{others}", kernel.name, text(kernel)?))
}

/// A remark on other kernels, by name while they are few.
fn list<'a>(remark: &str, names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<_> = names.map(|name| format!("`{name}`")).collect();
    match names.len() {
        0 => String::new(),
        1..=4 => format!("; {remark} {}", names.join(", ")),
        more => format!("; {remark} {more} others"),
    }
}

/// Explains the figures of [`advice`].
fn legend(groups: &[Group]) -> String {
    let mut text =
        "M/s: million tests of one ray against one primitive per second, in one thread. A tie: the medians differ \
         by no more than the sum of their median absolute deviations. The time is relative to the fastest. \
         ulp: 99th percentile of the error of `t` over generic rays, in units in the last place. `0 (< b)`: none was \
         observed, and b is the 95 % bound. Lost:\n"
            .to_owned();
    for loss in Loss::ALL {
        let mut same = groups.iter().filter(|group| group.loss == loss);
        if let Some(first) = same.next() {
            let titles: Vec<_> = [first].into_iter().chain(same).map(|group| group.title.as_str()).collect();
            text += &format!("\n- {}: {}", titles.join(", "), first.lost_means());
        }
    }
    text
}

fn kernel_table(groups: &[Group]) -> String {
    let header = ["kernel", "1x1 ns", "8x1 ns", "1x8 ns", "bytes", "setup bytes", "setup ns", "operations", "claims"];
    let mut grid = Grid::new(1, header);
    for group in groups {
        for kernel in &group.kernels {
            let mut row = vec![code(&kernel.kernel.id)];
            row.extend(["1x1", "8x1", "1x8"].map(|face| {
                let time = kernel.speed(face, 1).map_or(MISSING.to_owned(), with_mad);
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

fn code(id: &str) -> Cell {
    Cell::from(format!("`{id}`"))
}

fn with_mad(row: &SpeedRow) -> String {
    format!("{} ± {}", number(row.ns_per_test, 3), number(row.ns_per_test_mad, 1))
}

/// The workloads without severities that occur, in the order of the record.
fn workloads(record: &Record) -> Vec<&str> {
    let mut workloads: Vec<&str> = Vec::new();
    for row in record.accuracy.iter().filter(|row| row.severity.is_none()) {
        if !workloads.contains(&row.workload.as_str()) {
            workloads.push(&row.workload);
        }
    }
    workloads
}

fn rate(per_million: f64, of: u64) -> Cell {
    Cell::from(Rate::new(per_million, of).map_or(MISSING.to_owned(), |rate| format!("{rate} / {}", si(of as f64, 3))))
}

fn wrong_answers(rows: &[(&Figures, &AccuracyRow)]) -> String {
    let header = ["kernel", "rays", "tests", "false miss", "false hit", "leak", "double", "boundary"];
    let mut grid = Grid::new(1, header);
    grid.rows.extend(rows.iter().map(|(kernel, row)| {
        let boundary = [row.boundary_none, row.boundary_one, row.boundary_many].map(count).join(" / ");
        vec![
            code(&kernel.kernel.id),
            Cell::from(count(row.rays)),
            Cell::from(count(row.tests)),
            rate(row.false_miss_per_million, row.exact_hits),
            rate(row.false_hit_per_million, row.exact_misses),
            rate(row.leak_per_million, row.mesh_hits),
            rate(row.double_per_million, row.single_hits),
            Cell::from(boundary),
        ]
    }));
    grid.markdown()
}

fn errors(rows: &[(&Figures, &AccuracyRow)]) -> String {
    let header = ["kernel", "ulp median", "ulp 99 %", "ulp greatest", "gross", "u, v 99 %", "u, v greatest"];
    let mut grid = Grid::new(1, header);
    grid.rows.extend(rows.iter().map(|(kernel, row)| {
        vec![
            code(&kernel.kernel.id),
            Cell::from(count(row.t_ulp_p50)),
            Cell::from(count(row.t_ulp_p99)),
            Cell::from(count(row.t_ulp_max)),
            rate(row.gross_per_million, row.agreed_hits),
            Cell::from(number(row.uv_error_p99, 2)),
            Cell::from(number(row.uv_error_max, 2)),
        ]
    }));
    grid.markdown()
}

fn machine(record: &Record) -> String {
    let machine = &record.machine;
    format!(
        "## Machine and build\n\n- Processor: {}, {} logical processors\n- System: {}, target `{}`\n- Target features: {}\n\
         - Compiler: {}\n- Measured code: {}\n- Seed {}; {}; took {} s; record layout {}",
        machine.cpu,
        machine.processors,
        machine.os,
        machine.target,
        machine.target_features.join(", "),
        machine.rustc,
        machine.versions.join(", "),
        record.seed,
        if record.quick { "quick run" } else { "full run" },
        number(record.seconds, 3),
        record.schema
    )
}

/// Ideas and sources, kernels that share both together.
fn sources(record: &Record) -> String {
    let mut sources: Vec<(&str, &str, Vec<String>)> = Vec::new();
    for kernel in &record.methods {
        let id = format!("`{}`", kernel.id);
        match sources.iter_mut().find(|(idea, source, _)| *idea == kernel.idea && *source == kernel.source) {
            Some((_, _, ids)) => ids.push(id),
            None => sources.push((&kernel.idea, &kernel.source, vec![id])),
        }
    }
    let lines = sources.into_iter().map(|(idea, source, ids)| format!("- {}: {idea}. {source}.\n", ids.join(", ")));
    format!("## Sources\n\n{}", lines.collect::<String>())
}

fn checksums(record: &Record) -> String {
    let kernels = record.speed.iter().map(|row| (format!("`{}`", row.id), row.checksum.as_str()));
    let traced = |scene: &str, rays: &str, kernel: &str| format!("{scene}, {rays} rays, `{kernel}`");
    let tracer = record.tracer.iter().map(|row| (traced(&row.scene, &row.rays, &row.kernel), row.checksum.as_str()));
    let coherence = record.coherence.iter().map(|row| {
        (traced(&row.scene, &format!("jitter {}", severity(row.jitter)), &row.kernel), row.checksum.as_str())
    });
    // Equal for all faces, modes and thread counts: one line each.
    let mut lines: Vec<(String, &str)> = Vec::new();
    for line in kernels.chain(tracer).chain(coherence) {
        if !lines.contains(&line) {
            lines.push(line);
        }
    }
    let mut grid = Grid::new(2, ["hits of", "checksum of their bits"]);
    grid.rows.extend(lines.into_iter().map(|(what, checksum)| vec![Cell::from(what), code(checksum)]));
    format!("## Checksums\n\n{}", grid.markdown())
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::*;
    use crate::study::chart::charts;
    use crate::study::failures::Measure;
    use crate::study::fixture::{all_ids, degenerate_records, record_of};
    use crate::study::record::RegimeRow;

    #[test]
    fn every_kernel_is_in_every_table() {
        let record = record_of(&all_ids());
        let report = report_markdown(&record);
        let methods = groups_of_methods(&record);
        for kernel in &record.methods {
            // Kernels, packets, claims, two tables for each of two workloads, and checksums; and one for each measure of a
            // regime.
            let mut groups = methods.iter();
            let group = groups.find(|group| group.kernels.iter().any(|shown| shown.kernel.id == kernel.id));
            let is_shown = |regime: &&RegimeRow| group.is_some_and(|group| group.title == regime.family);
            let regimes = record.regimes.iter().filter(is_shown);
            let tables = 8 + regimes.map(|regime| Measure::of(regime).len()).sum::<usize>();
            assert_eq!(report.matches(&format!("\n| `{}` |", kernel.id)).count(), tables, "{}", kernel.id);
        }
        for chart in charts(&record) {
            assert!(report.contains(&format!("]({})", chart.file)), "{}", chart.file);
        }
        assert!(report.contains("- `triangle/elsewhere`: needs fused multiply-add"));
    }

    #[test]
    fn a_zero_is_shown_as_a_bound() {
        let mut record = record_of(&["triangle/cramer".into()]);
        record.regimes.clear();
        let report = report_markdown(&record);
        assert!(report.contains("| 0 (< 15) / 200 k |"), "leaks over 200,000 rays");
        assert!(report.contains("loses 0 (< 15) |"), "{report}");
    }

    #[test]
    fn the_advice_names_ties() {
        let mut record = record_of(&["triangle/a".into(), "triangle/b".into()]);
        assert!(!report_markdown(&record).contains("a tie with"));
        let times = |record: &mut Record, mad| {
            for row in &mut record.speed {
                row.ns_per_test = if row.id == "triangle/a" { 1.05 } else { 1.0 };
                row.ns_per_test_mad = mad;
            }
        };
        times(&mut record, 0.024);
        assert!(!report_markdown(&record).contains("a tie with"));
        times(&mut record, 0.026);
        let report = report_markdown(&record);
        assert!(report.contains("| **`b`** ") && report.contains("; a tie with `a`"));
    }

    /// What the project's README says of a record: its verdict, and what to use of each family.
    fn of_readme(record: &Record, folder: &str) -> String {
        let mut groups = groups(record);
        groups.retain(Group::is_base);
        let verdict = verdict_list(&groups).unwrap_or_default();
        format!(
            "{verdict}\n\n{}\nTests of one ray against one primitive, in packets of eight (8x1), one thread; lost rays per million that \
             exactly hit, where that is\nworst (`< b`: the 95 % bound where none was); ulp: 99th percentile of the error of `t`. Kernels \
             tie where they differ by no more than\nthe noise. Measured on {}, {}: [the whole record]({folder}/report.md), \
             and as a page `report.html` beside it.\n",
            advice_table(&groups),
            date(record.started_unix),
            record.machine.cpu
        )
    }

    /// To bring the README up to date: `RAYLANES_BLESS=1 cargo test --lib readme`.
    #[test]
    fn the_readme_says_what_its_record_says() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let readme = fs::read_to_string(root.join("README.md")).unwrap();
        let (before, rest) = readme.split_once("<!-- verdict of ").expect("the README has a verdict");
        let (folder, rest) = rest.split_once(" -->\n").unwrap();
        let (said, after) = rest.split_once("<!-- end of verdict -->").unwrap();
        assert!(before.contains(&format!("]({folder}/{SPEED_ACCURACY})")), "the chart is that of the same record");
        let json = fs::read_to_string(root.join(folder).join("results.json")).unwrap();
        let record: Record = serde_json::from_str(&json).expect("the README's record has the present layout");
        let expected = format!("\n{}\n", of_readme(&record, folder));
        if std::env::var_os("RAYLANES_BLESS").is_some() {
            let blessed = format!("{before}<!-- verdict of {folder} -->\n{expected}<!-- end of verdict -->{after}");
            fs::write(root.join("README.md"), blessed).unwrap();
        } else {
            assert_eq!(said, expected, "if this is meant: RAYLANES_BLESS=1 cargo test --lib readme");
        }
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
