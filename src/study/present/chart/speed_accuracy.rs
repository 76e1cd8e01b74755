//! `speed-accuracy.svg` and `speed-accuracy-instances.svg`: speed of every kernel at three widths, and how often it is
//! wrong on the workloads that are aimed at lost rays.

use super::canvas::machine;
use super::dot_plot::{Dot, DotPlot, Group as Rows, Kind, Panel, Row, Scale};
use super::interval::interval;
use crate::study::figures::failures::FAILING_RATE;
use crate::study::figures::{Group, KernelFigures, Loss, Rate, count, fastest_of, number, severity};
use crate::study::record::{AccuracyRow, Record};

/// The widths, the most important first, as the legend names them.
const WIDTHS: [(&str, &str); 3] = [("8x1", "8x1"), ("1x8", "1x8"), ("1x1", "1x1 (scalar)")];

const TITLE: &str = "Speed, and how often kernels are wrong";

/// The order of the families: triangles first, because most pictures are made of them.
const ORDER: [&str; 3] = ["triangle", "aabb", "quadric"];

/// Draws the kernels of these groups in rows, the fastest first.
pub(super) fn svg(record: &Record, groups: &[&Group]) -> String {
    let mut groups = groups.to_vec();
    groups.sort_by_key(|group| ORDER.iter().position(|family| *family == group.shape).unwrap_or(ORDER.len()));
    plot(record, &groups).svg()
}

fn plot(record: &Record, groups: &[&Group]) -> DotPlot {
    let panel = |title: &str, kind, share| Panel {
        title: title.into(),
        kind,
        scale: Scale::Logarithmic,
        share,
        reference: None,
        marks: Vec::new(),
    };
    let wrong = |title, kind| Panel { reference: Some(FAILING_RATE), ..panel(title, kind, 2) };
    let speed = panel("million tests per second, one thread", Kind::Speed, 3);
    DotPlot {
        title: TITLE.into(),
        remarks: vec![
            "8x1 tests eight rays against one primitive, 1x8 one ray against eight, 1x1 one against one. A ray is lost \
             if it exactly hits and is reported to miss. Rates: worst of the workloads aimed at edges. Lines: \
             deviation of speeds, 95 % interval of rates."
                .into(),
            machine(record),
        ],
        panels: vec![
            Panel { marks: WIDTHS.map(|(_, meaning)| meaning.into()).into(), ..speed },
            wrong("lost per million", Kind::Lost),
            wrong("false or double per million", Kind::False),
        ],
        groups: groups.iter().flat_map(|group| rows_of(record, group)).collect(),
        failure: "over 0.1 %".into(),
        bold: "bold: fastest without red, or tied".into(),
    }
}

/// The rows of a group. Instances are divided by their method.
fn rows_of(record: &Record, group: &Group) -> Vec<Rows> {
    let mut kernels: Vec<&KernelFigures> = group.kernels.iter().collect();
    let speed = |kernel: &KernelFigures| kernel.mtests(WIDTHS[0].0, 1).unwrap_or(0.0);
    kernels.sort_by(|a, b| speed(b).total_cmp(&speed(a)));
    let figures: Vec<_> = kernels.iter().map(|kernel| cells(record, group, kernel)).collect();
    let holds = |cells: &[Vec<Dot>; 3]| cells.iter().flatten().all(|dot| !dot.failed) && !cells[1].is_empty();
    let holding = kernels.iter().zip(&figures).filter(|(_, cells)| holds(cells)).map(|(kernel, _)| *kernel);
    let best: Vec<&str> = fastest_of(holding, WIDTHS[0].0).iter().map(|kernel| kernel.method.id.as_str()).collect();
    let mut parts: Vec<Rows> = Vec::new();
    for (kernel, cells) in kernels.iter().zip(figures) {
        let (method, name) = kernel.name.split_once('/').filter(|_| !group.is_base()).unwrap_or(("", &kernel.name));
        let heading = match (method, group.title.as_str()) {
            ("", "aabb") => "box (aabb)".to_owned(),
            ("", title) => title.to_owned(),
            (method, title) => format!("{title}, method {method}"),
        };
        let id = &kernel.method.id;
        let row = Row {
            id: id.clone(),
            name: name.into(),
            bold: best.contains(&id.as_str()),
            recommended: false,
            cells: cells.into(),
        };
        match parts.iter_mut().find(|part| part.heading.as_ref() == Some(&heading)) {
            Some(part) => part.rows.push(row),
            None => parts.push(Rows { heading: Some(heading), rows: vec![row] }),
        }
    }
    parts
}

/// The dots of a kernel: speeds, lost rays, false and double hits.
fn cells(record: &Record, group: &Group, kernel: &KernelFigures) -> [Vec<Dot>; 3] {
    let speeds = WIDTHS.iter().enumerate().filter_map(|(mark, (width, _))| {
        let row = kernel.speed(width, 1).filter(|row| row.ns_per_test > 0.0 && row.ns_per_test.is_finite())?;
        let (value, deviation) = (1e3 / row.ns_per_test, row.ns_per_test_mad);
        // The noise may be as large as the time.
        let ends = [row.ns_per_test + deviation, (row.ns_per_test - deviation).max(row.ns_per_test / 10.0)];
        let mad = value * deviation / row.ns_per_test;
        let tooltip = format!("{width}: {} ± {} M tests/s", number(value, 3), number(mad, 1));
        Some(Dot { mark, value, interval: Some(ends.map(|ns| 1e3 / ns)), failed: false, tooltip })
    });
    let lost = kernel.lost.map(|rate| {
        let what = if group.loss == Loss::Leaks { "leaks" } else { "lost" };
        dot(rate, kernel.lost_in, what, true)
    });
    let false_hits = false_hits(record, group, kernel);
    // A false hit of a box costs a look inside, and nothing else.
    let false_hits = false_hits.map(|(rate, row, what)| dot(rate, row, what, group.shape != "aabb"));
    [speeds.collect(), lost.into_iter().collect(), false_hits.into_iter().collect()]
}

fn dot(rate: Rate, place: Option<&AccuracyRow>, what: &str, can_fail: bool) -> Dot {
    let place = place.map_or(String::new(), |row| {
        let at = row.severity.map_or(String::new(), |step| format!(" at {}", severity(step)));
        format!(", in {}{at}", row.workload.replace('_', " "))
    });
    Dot {
        mark: 0,
        value: rate.per_million,
        interval: Some(interval(rate)),
        failed: can_fail && rate.per_million > FAILING_RATE,
        tooltip: format!("{what} {rate} per million, n = {}{place}", count(rate.of)),
    }
}

/// The worst rate of false hits or of double hits on the workloads of [`Group::loss_workloads`], the row and what it
/// counts. If there were none in any of them, all of their rays together.
fn false_hits<'a>(
    record: &'a Record,
    group: &Group,
    kernel: &KernelFigures,
) -> Option<(Rate, Option<&'a AccuracyRow>, &'static str)> {
    let is_aimed =
        |row: &&AccuracyRow| row.id == kernel.method.id && group.loss_workloads.contains(&row.workload.as_str());
    let rows = || record.accuracy.iter().filter(is_aimed);
    let single = rows().filter_map(|row| Some((Rate::new(row.false_hit_per_million, row.exact_misses)?, row)));
    let double = rows().filter_map(|row| Some((Rate::new(row.double_hit_per_million, row.single_hits)?, row)));
    let kinds: [(&str, Vec<(Rate, &AccuracyRow)>); 2] =
        [("false hits", single.collect()), ("double hits", double.collect())];
    let all = kinds.iter().flat_map(|(what, rates)| rates.iter().map(move |&(rate, row)| (rate, row, *what)));
    let (rate, row, what) = all.max_by(|(a, ..), (b, ..)| a.per_million.total_cmp(&b.per_million))?;
    if rate.per_million > 0.0 {
        return Some((rate, Some(row), what));
    }
    // Each kind has its own rays: the zero is about the smaller number.
    let rays = kinds.iter().map(|(_, rates)| rates.iter().map(|(rate, _)| rate.of).sum());
    let of = rays.filter(|&of: &u64| of > 0).min()?;
    Some((Rate { of, ..rate }, None, "false and double hits"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::figures::groups;
    use crate::study::tests::fixture::{all_ids, record_of};

    #[test]
    fn every_kernel_has_a_row_with_three_speeds_and_two_rates() {
        let record = record_of(&all_ids());
        let groups = groups(&record);
        let plot = plot(&record, &groups.iter().collect::<Vec<_>>());
        let rows: Vec<&Row> = plot.groups.iter().flat_map(|group| &group.rows).collect();
        assert_eq!(rows.len(), record.methods.len());
        for row in &rows {
            assert_eq!(row.cells.iter().map(Vec::len).collect::<Vec<_>>(), [3, 1, 1], "{}", row.id);
        }
        let speeds = |rows: &Rows| rows.rows.iter().map(|row| row.cells[0][0].value).collect::<Vec<_>>();
        assert!(plot.groups.iter().all(|group| speeds(group).is_sorted_by(|a, b| a >= b)));
        assert_eq!(plot.groups[0].heading.as_deref(), Some("triangle"));
    }

    #[test]
    fn only_kernels_without_failures_are_bold() {
        let mut record = record_of(&["triangle/a".into(), "triangle/b".into()]);
        for row in &mut record.accuracy {
            (row.leak_per_million, row.double_hit_per_million, row.false_hit_per_million) = (0.0, 0.0, 0.0);
        }
        for row in &mut record.speed {
            (row.ns_per_test, row.ns_per_test_mad) = (if row.id == "triangle/a" { 1.0 } else { 1.5 }, 0.01);
        }
        let bold = |record: &Record| {
            let groups = groups(record);
            let plot = plot(record, &groups.iter().collect::<Vec<_>>());
            let rows = plot.groups.into_iter().flat_map(|group| group.rows);
            rows.filter(|row| row.bold).map(|row| row.name).collect::<Vec<_>>()
        };
        assert_eq!(bold(&record), ["a"]);
        let rows = record.accuracy.iter_mut().filter(|row| row.id == "triangle/a" && row.workload == "shared_edge");
        rows.for_each(|row| row.double_hit_per_million = 2000.0);
        assert_eq!(bold(&record), ["b"]);
    }
}
