//! `stability-<family>-<regime>.svg`: errors of each kernel as a regime gets harder, from left to right.

use plotters::style::RGBColor;

use super::axis::LogAxis;
use super::canvas::{Area, Drawn, canvas, header, header_height, label, machine};
use super::layout::{LINE, MARGIN, TEXT, text_width};
use super::look::{DISTINCT, Look};
use super::palette::{BAD, INK, QUIET, SPEED};
use super::panel::{Mark, Panel, Series, Stack, XAxis};
use crate::study::figures::failures::{Figure, Metric};
use crate::study::figures::{Group, KernelFigures, count, severity};
use crate::study::record::{Record, RegimeRow};

const ZERO: &str = "no event; line: to the 95 % bound";
const LEGEND_HEIGHT: i32 = 2 * LINE + 8;

/// Draws a regime: a panel for each of its metrics, against its severities.
pub(super) fn svg(record: &Record, group: &Group, regime: &RegimeRow) -> String {
    let x = XAxis {
        axis: LogAxis::through(&regime.steps),
        title: format!("{}: {}", regime.axis, direction(&regime.steps)),
        tick: severity,
    };
    let stack = Stack { panels: metrics(group, regime).map(|metric| panel(group, regime, metric)).collect(), x };
    let width = stack.width();
    let title = format!("{}: {}", group.title, regime.name.replace('_', " "));
    let subject = (group.subject != group.title).then(|| format!("All are {}.", group.subject));
    let remarks: Vec<_> = [regime.about.clone()].into_iter().chain(subject).chain([machine(record)]).collect();
    let top = header_height(width, &title, &remarks) + LEGEND_HEIGHT;
    canvas((width, top + stack.height(width) + MARGIN), |root| {
        let below = header(root, width, &title, &remarks)?;
        legend(root, below)?;
        stack.draw(root, top, width)
    })
}

/// The metrics that have data. Empty boxes, for example, cannot be lost.
fn metrics(group: &Group, regime: &RegimeRow) -> impl Iterator<Item = Metric> {
    let has_data = |metric: &Metric| group.kernels.iter().any(|kernel| !marks(kernel, regime, *metric).is_empty());
    Metric::of(regime).iter().copied().filter(has_data)
}

/// Which end of the axis is easy, in words.
fn direction(steps: &[f64]) -> &'static str {
    // A regime that goes far below and far above the unit is hard at both ends.
    match (steps.first(), steps.last()) {
        (Some(..0.1), Some(10.0..)) => "small on the left, large on the right, easy in the middle",
        _ => "easy on the left, hard on the right",
    }
}

/// Draws the meaning of the colours, in two lines.
fn legend(root: &Area, top: i32) -> Drawn {
    let rows = [
        vec![(BAD, false, "fails: above the line"), (SPEED, false, "some events"), (QUIET, false, "the others")],
        vec![(QUIET, true, ZERO)],
    ];
    for (row, entries) in (0..).zip(rows) {
        let (mut x, y) = (MARGIN + 6, top + LINE * row + LINE / 2);
        for (color, hollow, meaning) in entries {
            Look::new(color, 0).mark(root, (x, y), 4, hollow)?;
            root.draw_text(meaning, &label(TEXT, INK), (x + 14, y))?;
            x += text_width(meaning) + 40;
        }
    }
    Ok(())
}

fn panel<'a>(group: &'a Group, regime: &RegimeRow, metric: Metric) -> Panel<'a> {
    let possible = if metric == Metric::Ulp { 1.0..=f64::INFINITY } else { 0.0..=1e6 };
    let mut series: Vec<(RGBColor, Series)> = Vec::new();
    for kernel in &group.kernels {
        let marks = marks(kernel, regime, metric);
        let color = color(metric, &marks);
        // Those of one colour differ in their shapes.
        let shape = series.iter().filter(|(other, _)| *other == color).count() % DISTINCT;
        let look = Look::new(color, if color == QUIET { 0 } else { shape });
        let (id, name) = (&kernel.method.id, &kernel.name);
        series.push((color, Series { id, name, look, emphasised: color != QUIET, marks }));
    }
    // Failures lie on top.
    series.sort_by_key(|(color, _)| [QUIET, SPEED, BAD].iter().position(|other| other == color));
    let series = series.into_iter().map(|(_, series)| series).collect();
    Panel { title: metric.title().into(), possible, threshold: metric.limit(), series }
}

/// The colour of a line: red if it exceeds the metric's limit anywhere, blue if there were events, else grey.
fn color(metric: Metric, marks: &[Mark]) -> RGBColor {
    let most = marks.iter().map(|mark| mark.value).fold(0.0, f64::max);
    match metric {
        _ if metric.limit().is_some_and(|limit| most > limit) => BAD,
        Metric::Ulp => QUIET,
        _ if most > 0.0 => SPEED,
        _ => QUIET,
    }
}

fn marks(kernel: &KernelFigures, regime: &RegimeRow, metric: Metric) -> Vec<Mark> {
    let mark = |(step, &x): (usize, &f64)| {
        let figure = metric.figure(kernel.at_step(&regime.name, x)?)?;
        let (value, bound, unit) = match figure {
            Figure::Rate(rate) => {
                let bound = (rate.events == 0).then(|| rate.or_bound());
                (rate.per_million(), bound, format!(" per million, n = {}", count(rate.of)))
            }
            Figure::Ulp(ulp) => (ulp as f64, None, " ulp".into()),
        };
        let tooltip = format!("scalar and packet, at {}: {} {figure}{unit}", severity(x), metric.name());
        Some(Mark { step, x, value, bound, tooltip })
    };
    regime.steps.iter().enumerate().filter_map(mark).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::figures::groups;
    use crate::study::tests::fixture::{all_ids, record_of};

    fn chart(record: &Record, regime: &str) -> String {
        let regime = record.regimes.iter().find(|row| row.name == regime).unwrap();
        let groups = groups(record);
        svg(record, groups.iter().find(|group| group.title == regime.family).unwrap(), regime)
    }

    fn x_of(svg: &str, text: &str) -> Option<i32> {
        let before = &svg[..svg.rfind(&format!(">{text}<"))?];
        let x = &before[before.rfind(" x=\"")? + 4..];
        let x = x.split('"').next()?;
        x.parse().ok()
    }

    #[test]
    fn a_severity_of_zero_is_on_the_right() {
        let mut record = record_of(&all_ids());
        record.accuracy.iter_mut().for_each(|row| row.t_ulp_p99 += 1);
        let svg = chart(&record, "grazing");
        let ticks = ["0.1", "0.01", "1e-3", "1e-4", "1e-5", "1e-6", "0"].map(|text| x_of(&svg, text));
        let shown: Vec<_> = ticks.iter().flatten().collect();
        assert!(shown.len() >= 4 && ticks[6].is_some() && shown.is_sorted(), "{ticks:?}");
    }

    #[test]
    fn a_zero_rate_is_hollow_and_a_missing_figure_is_a_gap() {
        let mut record = record_of(&["triangle/cramer".to_owned()]);
        for row in record.accuracy.iter_mut().filter(|row| row.workload == "sliver") {
            (row.false_miss_per_million, row.false_hit_per_million, row.t_ulp_p99) = (500.0, 500.0, 2);
        }
        let regime = record.regimes.iter().find(|row| row.name == "sliver").unwrap().clone();
        let marks_of = |record: &Record, metric| marks(&groups(record)[0].kernels[0], &regime, metric);
        let count = regime.steps.len();
        assert!(marks_of(&record, Metric::Wrong).iter().all(|mark| mark.value > 0.0 && mark.bound.is_none()));
        let severity = Some(regime.steps[2]);
        let step = record.accuracy.iter().position(|row| row.workload == "sliver" && row.severity == severity).unwrap();
        (record.accuracy[step].false_miss_per_million, record.accuracy[step].false_hit_per_million) = (0.0, 0.0);
        let marks = marks_of(&record, Metric::Wrong);
        assert!(marks[2].value == 0.0 && marks[2].bound.is_some_and(|bound| bound > 0.0) && marks.len() == count);
        record.accuracy.remove(step);
        for metric in [Metric::Wrong, Metric::Ulp] {
            let steps: Vec<_> = marks_of(&record, metric).iter().map(|mark| mark.step).collect();
            assert!(steps.len() == count - 1 && !steps.contains(&2), "{steps:?}");
        }
    }

    #[test]
    fn red_is_for_failures_only() {
        let mark = |value| vec![Mark { step: 0, x: 1.0, value, bound: None, tooltip: String::new() }];
        for (metric, value, expected) in [
            (Metric::Leak, 1000.1, BAD),
            (Metric::Leak, 1000.0, SPEED),
            (Metric::Leak, 0.0, QUIET),
            (Metric::FalseHit, 1e6, SPEED),
            (Metric::Ulp, 101.0, BAD),
            (Metric::Ulp, 100.0, QUIET),
        ] {
            assert_eq!(color(metric, &mark(value)), expected, "{metric:?} {value}");
        }
    }

    #[test]
    fn every_metric_of_a_regime_has_a_panel() {
        let record = record_of(&all_ids());
        for (regime, metrics) in [
            ("vertex_fan", vec![Metric::Leak, Metric::DoubleHit, Metric::Ulp]),
            ("silhouette", vec![Metric::Odd, Metric::Ulp]),
            ("depth_order", vec![Metric::WrongClosest, Metric::Ulp]),
            ("inside_box", vec![Metric::Rejected, Metric::Clamped, Metric::Ulp]),
            ("flat", vec![Metric::Lost, Metric::FalseHit, Metric::Ulp]),
            ("sliver", vec![Metric::Wrong, Metric::Ulp]),
        ] {
            let svg = chart(&record, regime);
            // A title may be broken into lines.
            let shown = |metric: &Metric| metric.title().split(' ').take(3).all(|word| svg.contains(word));
            assert!(metrics.iter().all(shown), "{regime}");
        }
    }
}
