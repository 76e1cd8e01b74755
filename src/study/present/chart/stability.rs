//! `stability-<family>-<regime>.svg`: errors of each kernel as a regime gets harder, from left to right.

use super::axis::LogAxis;
use super::canvas::{Area, Drawn, canvas, header, header_height, label, machine};
use super::layout::{INK, LINE, MARGIN, Pixel, TEXT};
use super::look::{Look, line};
use super::panel::{Mark, Panel, Series, XAxis, draw_stack, stack_height, threshold_sample, widths};
use crate::study::figures::failures::{Figure, Metric};
use crate::study::figures::{Group, KernelFigures, count, severity};
use crate::study::record::{Record, RegimeRow};

const BOUND: &str = "A hollow mark means no event in n rays. It is drawn at the 95 % bound, 3/n. One or two events lie \
                     below it.";
const MARK: i32 = 5;
const LEGEND_HEIGHT: i32 = LINE + 12;

/// Draws a regime: a panel for each of its metrics, against its severities.
pub(super) fn svg(record: &Record, group: &Group, regime: &RegimeRow) -> String {
    let panels: Vec<_> = metrics(group, regime).map(|metric| panel(group, regime, metric)).collect();
    let (plot, width) = widths(panels.iter());
    let title = format!("{}: {}", group.subject, regime.name.replace('_', " "));
    let remarks = [regime.about.clone(), BOUND.to_owned(), machine(record)];
    let top = header_height(width, &title, &remarks) + LEGEND_HEIGHT;
    canvas((width, top + stack_height(&panels) + MARGIN), |root| {
        let below = header(root, width, &title, &remarks)?;
        legend(root, below)?;
        let x = XAxis {
            axis: LogAxis::through(&regime.steps),
            title: format!("{}: {}", regime.axis, direction(&regime.steps)),
            tick: &severity,
        };
        draw_stack(root, &panels, &x, top, plot)
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

fn legend(root: &Area, top: i32) -> Drawn {
    let y = top + LINE / 2;
    let entry = |x: i32, meaning: &str| root.draw_text(meaning, &label(TEXT, INK), (x, y));
    Look::neutral().mark(root, (MARGIN + 8, y), MARK, true)?;
    entry(MARGIN + 24, "hollow: no event in n rays, drawn at 3/n")?;
    let x = MARGIN + 300;
    let ends: [Pixel; 2] = [(x, y), (x + 36, y)];
    line(root, &ends, &[0, 1, 2].map(|i| (None, Look::of(i))))?;
    entry(x + 44, "striped: kernels with equal figures, marks alternate")?;
    let x = x + 420;
    threshold_sample(root, (x, y))?;
    entry(x + 32, "above this line, a kernel fails")
}

fn panel<'a>(group: &'a Group, regime: &RegimeRow, metric: Metric) -> Panel<'a> {
    let possible = if metric == Metric::Ulp { 1.0..=f64::INFINITY } else { 0.0..=1e6 };
    let series = group.kernels.iter().map(|kernel| Series {
        id: &kernel.method.id,
        name: &kernel.name,
        marks: marks(kernel, regime, metric),
    });
    Panel {
        title: metric.title().into(),
        possible,
        threshold: metric.limit(),
        frontier: false,
        series: series.collect(),
    }
}

fn marks(kernel: &KernelFigures, regime: &RegimeRow, metric: Metric) -> Vec<Mark> {
    let mark = |(step, &x): (usize, &f64)| {
        let figure = metric.figure(kernel.at_step(&regime.name, x)?)?;
        let (value, bound, unit) = match figure {
            Figure::Rate(rate) => (rate.or_bound(), rate.events == 0, format!(" per million, n = {}", count(rate.of))),
            Figure::Ulp(ulp) => (ulp as f64, false, " ulp".into()),
        };
        let tooltip = format!("scalar and packet, at {}: {} {figure}{unit}", severity(x), metric.name());
        Some(Mark { step, x, spread: None, value, bound, size: MARK, tooltip })
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
        let before = &svg[..svg.find(&format!(">{text}<"))?];
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
        assert!(ticks.iter().all(Option::is_some) && ticks.is_sorted(), "{ticks:?}");
        assert_eq!(svg.matches(">0<").count(), 1);
    }

    #[test]
    fn a_zero_rate_is_drawn_as_a_bound_and_a_missing_figure_as_a_gap() {
        let ids = ["triangle/cramer".to_owned()];
        let arrows = |svg: &str| svg.matches("l3 3 3-3").count();
        let lines = |svg: &str| {
            let paths = svg.lines().filter(|line| line.starts_with("<path stroke=\"#0072B2\" stroke-width=\"2\""));
            paths.map(|path| path.matches('M').count()).sum::<usize>()
        };
        let mut record = record_of(&ids);
        for row in record.accuracy.iter_mut().filter(|row| row.workload == "sliver") {
            (row.false_miss_per_million, row.false_hit_per_million, row.t_ulp_p99) = (5.0, 5.0, 2);
        }
        let without = chart(&record, "sliver");
        let severity = Some(record.regimes.iter().find(|row| row.name == "sliver").unwrap().steps[2]);
        let step = record.accuracy.iter().position(|row| row.workload == "sliver" && row.severity == severity).unwrap();
        (record.accuracy[step].false_miss_per_million, record.accuracy[step].false_hit_per_million) = (0.0, 0.0);
        assert_eq!(arrows(&chart(&record, "sliver")), arrows(&without) + 1);
        record.accuracy.remove(step);
        // In each of the two panels, the line is split at the gap.
        assert_eq!(lines(&chart(&record, "sliver")), lines(&without) + 2);
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
            let shown = |metric: &Metric| svg.contains(metric.title());
            assert!(metrics.iter().all(shown), "{regime}");
        }
    }
}
