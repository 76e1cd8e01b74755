//! `on-scenes.svg`: the tracer's speed with every kernel on whole scenes, and how many rays get a wrong answer there.

use super::canvas::machine;
use super::dot_plot::{Dot, DotPlot, Group as Rows, Kind, Panel, Row, Scale};
use crate::study::figures::failures::FAILING_RATE;
use crate::study::figures::on_scenes::{Answers, mrays};
use crate::study::figures::{Group, KernelFigures, Rate, count, number};
use crate::study::ray_sets;
use crate::study::record::Record;

/// The sets of rays whose answers are shown, as the legend names them.
const ANSWERS: [&str; 2] = ["pictures", "aimed at edges"];

/// Draws the kernels of the shapes that were traced in scenes, the fastest first. `None` if there are none.
pub(super) fn svg(record: &Record, groups: &[&Group]) -> Option<String> {
    let rows: Vec<Rows> = groups.iter().filter_map(|group| rows_of(record, group)).collect();
    let wrong = |title: &str, kind| Panel {
        title: title.into(),
        kind,
        scale: Scale::Logarithmic,
        share: 2,
        reference: Some(FAILING_RATE),
        marks: ANSWERS.map(Into::into).into(),
    };
    let plot = DotPlot {
        title: "The same scenes with every kernel".into(),
        remarks: vec![
            "Rays of whole pictures, traced by the same tracer through the same trees, and compared with the exact \
             answer of the scene. A ray is lost if it looks through the surface where it ends. Lines: 95 % intervals. \
             Bold: fewest wrong answers where rays are aimed, or tied; shaded: recommended."
                .into(),
            machine(record),
        ],
        panels: vec![
            Panel {
                title: "million rays per second, one thread".into(),
                kind: Kind::Speed,
                scale: Scale::Logarithmic,
                share: 3,
                reference: None,
                marks: ray_sets::NAMES.map(Into::into).into(),
            },
            wrong("lost per million", Kind::Lost),
            wrong("false per million", Kind::False),
        ],
        groups: rows,
        failure: "over 0.1 %".into(),
    };
    (!plot.groups.is_empty()).then(|| plot.svg())
}

fn rows_of(record: &Record, group: &Group) -> Option<Rows> {
    let traced = |kernel: &&KernelFigures| Answers::in_pictures(record, &kernel.method.id).is_some();
    let mut kernels: Vec<&KernelFigures> = group.kernels.iter().filter(traced).collect();
    let speed = |kernel: &KernelFigures| mrays(record, &kernel.method.id, |_| true).map_or(0.0, |speed| speed.value);
    kernels.sort_by(|a, b| speed(b).total_cmp(&speed(a)));
    let safest = group.safest();
    let row = |kernel: &&KernelFigures| {
        let is_first = safest.first().is_some_and(|first| first.method.id == kernel.method.id);
        Row {
            id: kernel.method.id.clone(),
            name: kernel.name.clone(),
            bold: group.is_among_the_safest(kernel),
            recommended: is_first,
            cells: cells(record, &kernel.method.id),
        }
    };
    let rows: Vec<_> = kernels.iter().map(row).collect();
    (!rows.is_empty()).then(|| Rows { heading: Some(group.title.clone()), rows })
}

/// The dots of a kernel: speeds, lost rays, false hits.
fn cells(record: &Record, id: &str) -> Vec<Vec<Dot>> {
    let speeds = ray_sets::NAMES.iter().enumerate().filter_map(|(mark, set)| {
        let speed = mrays(record, id, |row| row.rays == *set)?;
        Some(Dot {
            mark,
            value: speed.value,
            interval: Some([speed.low, speed.high]),
            failed: false,
            tooltip: format!(
                "{set}: {} ({} to {}) M rays/s, geometric mean of the scenes",
                number(speed.value, 3),
                number(speed.low, 3),
                number(speed.high, 3)
            ),
        })
    });
    let answers = [Answers::in_pictures(record, id), Answers::at_edges(record, id)];
    let dots = |what: &str, rate: fn(&Answers) -> Rate| {
        let of = answers.iter().enumerate().filter_map(|(mark, answers)| Some((mark, rate(answers.as_ref()?))));
        of.map(|(mark, rate)| Dot {
            mark,
            value: rate.per_million(),
            interval: Some(rate.interval()),
            failed: rate.per_million() > FAILING_RATE,
            tooltip: format!("{what}, {}: {rate} per million, n = {}", ANSWERS[mark], count(rate.of)),
        })
        .collect()
    };
    vec![speeds.collect(), dots("lost", |answers| answers.lost), dots("false", |answers| answers.false_hits)]
}
