//! `speed-accuracy.svg` and `speed-accuracy-instances.svg`: speed of every kernel at three widths, and how often it is
//! wrong on the workloads that are aimed at lost rays.

use super::canvas::machine;
use super::dot_plot::{Dot, DotPlot, Group as Rows, Kind, Panel, Row, Scale};
use crate::study::figures::failures::FAILING_RATE;
use crate::study::figures::{Failures, Group, KernelFigures, Loss, count, number, severity};
use crate::study::record::Record;

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
             if it exactly hits and is reported to miss. Rates: all rays aimed where kernels fail. Lines: 95 % \
             intervals. Bold: fewest wrong answers, or tied; shaded: recommended."
                .into(),
            machine(record),
        ],
        panels: vec![
            Panel { marks: WIDTHS.map(|(_, meaning)| meaning.into()).into(), ..speed },
            wrong("lost per million", Kind::Lost),
            wrong("false or double per million", Kind::False),
        ],
        groups: groups.iter().flat_map(|group| rows_of(group)).collect(),
        failure: "over 0.1 %".into(),
    }
}

/// The rows of a group. Instances are divided by their method.
fn rows_of(group: &Group) -> Vec<Rows> {
    let mut kernels: Vec<&KernelFigures> = group.kernels.iter().collect();
    let speed = |kernel: &KernelFigures| kernel.mtests(WIDTHS[0].0, 1).unwrap_or(0.0);
    kernels.sort_by(|a, b| speed(b).total_cmp(&speed(a)));
    let safest = group.safest();
    let mut parts: Vec<Rows> = Vec::new();
    for kernel in &kernels {
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
            bold: group.is_among_the_safest(kernel),
            recommended: safest.first().is_some_and(|first| first.method.id == *id),
            cells: cells(group, kernel).into(),
        };
        match parts.iter_mut().find(|part| part.heading.as_ref() == Some(&heading)) {
            Some(part) => part.rows.push(row),
            None => parts.push(Rows { heading: Some(heading), rows: vec![row] }),
        }
    }
    parts
}

/// The dots of a kernel: speeds, lost rays, false and double hits.
fn cells(group: &Group, kernel: &KernelFigures) -> [Vec<Dot>; 3] {
    let speeds = WIDTHS.iter().enumerate().filter_map(|(mark, (width, _))| {
        let row = kernel.speed(width, 1).filter(|row| row.ns_per_test > 0.0 && row.ns_per_test.is_finite())?;
        let [value, low, high] = [row.ns_per_test, row.ns_per_test_high, row.ns_per_test_low].map(|ns| 1e3 / ns);
        let tooltip = format!("{width}: {} ({} to {}) M tests/s", number(value, 3), number(low, 3), number(high, 3));
        Some(Dot { mark, value, interval: Some([low, high]), failed: false, tooltip })
    });
    let what = if group.loss == Loss::Leaks { "leaks" } else { "lost" };
    let lost = kernel.lost.map(|lost| dot(lost, what, true));
    // A false hit of a box costs a look inside, and nothing else.
    let what = if group.loss == Loss::Leaks { "false or double hits" } else { "false hits" };
    let false_hits = kernel.false_hits.map(|false_hits| dot(false_hits, what, group.shape != "aabb"));
    [speeds.collect(), lost.into_iter().collect(), false_hits.into_iter().collect()]
}

fn dot(failures: Failures, what: &str, can_fail: bool) -> Dot {
    let Failures { rate, worst } = failures;
    let worst = worst.map_or(String::new(), |(row, worst)| {
        let at = row.severity.map_or(String::new(), |step| format!(" at {}", severity(step)));
        format!("; worst: {worst} in {}{at}", row.workload.replace('_', " "))
    });
    Dot {
        mark: 0,
        value: rate.per_million(),
        interval: Some(rate.interval()),
        failed: can_fail && rate.per_million() > FAILING_RATE,
        tooltip: format!("{what} {rate} per million, n = {}{worst}", count(rate.of)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::figures::groups;
    use crate::study::tests::fixture::{all_ids, record_of, set_rounds};

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
    fn kernels_with_the_fewest_wrong_answers_are_bold() {
        let mut record = record_of(&["triangle/a".into(), "triangle/b".into()]);
        record.methods.iter_mut().for_each(|method| method.claims.clear());
        for row in &mut record.accuracy {
            (row.leak_per_million, row.double_hit_per_million, row.false_hit_per_million) = (0.0, 0.0, 0.0);
        }
        for row in &mut record.speed {
            set_rounds(row, &[if row.id == "triangle/a" { 1.0 } else { 1.5 }; 3]);
        }
        let bold = |record: &Record| {
            let groups = groups(record);
            let plot = plot(record, &groups.iter().collect::<Vec<_>>());
            let rows: Vec<_> = plot.groups.into_iter().flat_map(|group| group.rows).collect();
            let names = |is_meant: fn(&Row) -> bool| {
                rows.iter().filter(|row| is_meant(row)).map(|row| row.name.clone()).collect::<Vec<_>>()
            };
            [names(|row| row.bold), names(|row| row.recommended)]
        };
        assert_eq!(bold(&record), [&["a", "b"][..], &["a"]]);
        let rows = record.accuracy.iter_mut().filter(|row| row.id == "triangle/a" && row.workload == "shared_edge");
        rows.for_each(|row| row.double_hit_per_million = 2000.0);
        assert_eq!(bold(&record), [["b"]; 2]);
    }
}
