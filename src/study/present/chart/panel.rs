//! A stack of plots over one horizontal axis: a line of marks for each series, and its name at the line's end. Series
//! whose lines coincide share a line and a label.

use std::ops::{Range, RangeInclusive};

use plotters::prelude::*;

use super::axis::LogAxis;
use super::canvas::{Area, Drawn, label, name, wrapped};
use super::hover::{Hover, Shape};
use super::layout::{LEFT, LINE, MARGIN, Pixel, TEXT, WIDTH, name_width};
use super::look::Look;
use super::palette::{FAINT, INK, PAGE, QUIET, RULE};
use super::svg::SubjectGroup;
use crate::study::figures::si;

/// Minimum width of a plot; long names widen the chart instead.
const MIN_PLOT: i32 = 270;
const MIN_HEIGHT: i32 = 150;
/// Marks at most this far apart count as overlapping.
const NEAR: i32 = 4;
/// Half the size of a mark.
const MARK: i32 = 4;
/// Space between the plot and the labels, for the leaders.
const GAP: i32 = 26;
/// Space between a leader and its label.
const BESIDE: i32 = 6;
const BELOW: i32 = 16;
const X_LABELS: i32 = 26;
/// A label of more names than this lists the first ones and counts the others.
const LISTED: usize = 3;

/// One plot.
pub(super) struct Panel<'a> {
    pub(super) title: String,
    /// The possible values; others get no tick.
    pub(super) possible: RangeInclusive<f64>,
    /// A value that is marked by a line across the plot.
    pub(super) threshold: Option<f64>,
    /// Later series are drawn above earlier ones where they coincide.
    pub(super) series: Vec<Series<'a>>,
}

/// The marks of a kernel, or of a category.
pub(super) struct Series<'a> {
    /// Unique ID within the chart.
    pub(super) id: &'a str,
    pub(super) name: &'a str,
    pub(super) look: Look,
    /// Whether the line is thick and all names are listed.
    pub(super) emphasised: bool,
    pub(super) marks: Vec<Mark>,
}

/// A measured value.
pub(super) struct Mark {
    /// Marks of consecutive steps are joined by a line.
    pub(super) step: usize,
    pub(super) x: f64,
    /// The observed value. Zero is drawn hollow, below every other value.
    pub(super) value: f64,
    /// The 95 % bound of a count of zero: a line reaches from zero to it.
    pub(super) bound: Option<f64>,
    /// The text of the tooltip after the ID: figures with their units.
    pub(super) tooltip: String,
}

/// The horizontal axis of a stack of panels.
pub(super) struct XAxis {
    pub(super) axis: LogAxis,
    pub(super) title: String,
    pub(super) tick: fn(f64) -> String,
}

/// Panels over one horizontal axis.
pub(super) struct Stack<'a> {
    pub(super) panels: Vec<Panel<'a>>,
    pub(super) x: XAxis,
}

impl Stack<'_> {
    /// The width that leaves room for plot and labels.
    pub(super) fn width(&self) -> i32 {
        WIDTH.max(LEFT + MIN_PLOT + self.labels_width())
    }

    fn labels_width(&self) -> i32 {
        let lines = self.panels.iter().flat_map(Panel::lines).flat_map(|line| line.label);
        GAP + BESIDE + lines.map(|text| name_width(&text)).max().unwrap_or(0) + MARGIN
    }

    /// The height at this width.
    pub(super) fn height(&self, width: i32) -> i32 {
        let title = self.x_title(width).len() as i32;
        self.panels.iter().map(|panel| panel.height(width)).sum::<i32>() + X_LABELS + LINE * title
    }

    fn x_title(&self, width: i32) -> Vec<String> {
        wrapped(&self.x.title, width - LEFT - MARGIN, TEXT)
    }

    /// Draws the panels, from `top` on.
    pub(super) fn draw(&self, root: &Area, mut top: i32, width: i32) -> Drawn {
        let plot = width - LEFT - self.labels_width();
        for (i, panel) in self.panels.iter().enumerate() {
            let title = panel.title_lines(width);
            for (line, text) in (0..).zip(&title) {
                root.draw_text(text, &label(TEXT, INK), (MARGIN, top + LINE * line + LINE / 2))?;
            }
            let corner = (LEFT, top + LINE * title.len() as i32 + 4);
            panel.draw(root, &self.x, corner, plot, i + 1 == self.panels.len())?;
            top += panel.height(width);
        }
        for (line, text) in (0..).zip(self.x_title(width)) {
            root.draw_text(&text, &label(TEXT, INK), (LEFT, top + X_LABELS - BELOW / 2 + LINE * line + LINE / 2))?;
        }
        Ok(())
    }
}

/// Series with equal marks, by their number, and the lines of their label.
struct Line {
    series: Vec<usize>,
    label: Vec<String>,
}

impl Panel<'_> {
    fn title_lines(&self, width: i32) -> Vec<String> {
        wrapped(&self.title, width - 2 * MARGIN, TEXT)
    }

    fn height(&self, width: i32) -> i32 {
        LINE * self.title_lines(width).len() as i32 + 4 + self.plot_height() + BELOW
    }

    /// The height of the plot, with room for the labels.
    fn plot_height(&self) -> i32 {
        let labels = self.lines().iter().map(|line| line.label.len()).sum::<usize>();
        MIN_HEIGHT.max(LINE * labels as i32 + LINE / 2)
    }

    /// The lines of the plot: series with the same marks and the same colour share one. Series without marks share a
    /// label.
    fn lines(&self) -> Vec<Line> {
        let points = |series: &Series| series.marks.iter().map(|mark| (mark.step, mark.value)).collect::<Vec<_>>();
        let mut lines: Vec<Line> = Vec::new();
        for (number, series) in self.series.iter().enumerate() {
            let coincides = |line: &&mut Line| {
                let first = &self.series[line.series[0]];
                first.look.color == series.look.color && points(first) == points(series)
            };
            match lines.iter_mut().find(coincides) {
                Some(line) => line.series.push(number),
                None => lines.push(Line { series: vec![number], label: Vec::new() }),
            }
        }
        for line in &mut lines {
            let names: Vec<&str> = line.series.iter().map(|&number| self.series[number].name).collect();
            let first = &self.series[line.series[0]];
            let listed = if first.emphasised || names.len() <= LISTED { names.len() } else { LISTED - 1 };
            line.label.extend(first.marks.is_empty().then(|| "not measured:".into()));
            line.label.extend(names[..listed].iter().map(|&name| name.into()));
            line.label.extend((listed < names.len()).then(|| format!("and {} more", names.len() - listed)));
        }
        lines
    }

    /// Draws the plot. Only with `x_labels` are the ticks of the horizontal axis labelled.
    fn draw(&self, root: &Area, x: &XAxis, (left, top): Pixel, width: i32, x_labels: bool) -> Drawn {
        let height = self.plot_height();
        let (right, bottom) = (left + width, top + height);
        let label_height = if x_labels { X_LABELS } else { 0 };
        let marks = self.series.iter().flat_map(|series| &series.marks);
        let values =
            LogAxis::around(marks.flat_map(|mark| [Some(mark.value), mark.bound]).flatten(), self.possible.clone(), 5);
        let area = root.clone().shrink((left - LEFT, top), (LEFT + width, height + label_height));
        let labelled = x.axis.labelled(width, x.tick);
        let mut chart = ChartBuilder::on(&area)
            .set_label_area_size(LabelAreaPosition::Left, LEFT)
            .set_label_area_size(LabelAreaPosition::Bottom, label_height)
            .build_cartesian_2d(x.axis.clone(), values.clone())?;
        chart
            .configure_mesh()
            .bold_line_style(RULE)
            .axis_style(FAINT)
            .label_style(label(TEXT, FAINT))
            .x_labels(x.axis.ticks.len())
            .x_label_formatter(&|value| if labelled.contains(value) { (x.tick)(*value) } else { String::new() })
            .y_label_formatter(&|&value| si(value, 1))
            .draw()?;
        // Zero is not on a logarithmic axis, so a break is drawn beside it.
        if let Some(gap) = x.axis.gap().filter(|_| x_labels) {
            let x = left + (gap * f64::from(width)).round() as i32;
            axis_break(root, [(x - 3, bottom), (x + 3, bottom)], (3, -5))?;
        }
        if let Some(gap) = values.gap() {
            let y = bottom - (gap * f64::from(height)).round() as i32;
            axis_break(root, [(left, y - 3), (left, y + 3)], (5, -3))?;
        }
        let at = |x: f64, value: f64| chart.backend_coord(&(x, value));
        if let Some(value) = self.threshold.filter(|&value| (0.0..1.0).contains(&values.position(value))) {
            let (_, y) = at(x.axis.ticks.first().copied().unwrap_or(1.0), value);
            root.draw(&PathElement::new([(left, y), (right, y)], FAINT.stroke_width(2)))?;
        }
        let lines = self.lines();
        for line in &lines {
            self.line(root, line, &at)?;
        }
        root.draw(&SubjectGroup(&[]))?;
        self.hover(root, &at)?;
        self.labels(root, &lines, right, top..bottom, &at)
    }

    fn ids(&self, line: &Line) -> Vec<&str> {
        line.series.iter().map(|&number| self.series[number].id).collect()
    }

    /// Draws a line and its marks.
    fn line(&self, root: &Area, line: &Line, at: &impl Fn(f64, f64) -> Pixel) -> Drawn {
        let first = &self.series[line.series[0]];
        let style = first.look.color.stroke_width(if first.emphasised { 2 } else { 1 });
        root.draw(&SubjectGroup(&self.ids(line)))?;
        for marks in first.marks.chunk_by(|a, b| a.step + 1 == b.step) {
            root.draw(&PathElement::new(marks.iter().map(|mark| at(mark.x, mark.value)).collect::<Vec<_>>(), style))?;
        }
        for mark in &first.marks {
            let (x, y) = at(mark.x, mark.value);
            if let Some(bound) = mark.bound {
                let (_, end) = at(mark.x, bound);
                root.draw(&PathElement::new([(x, y), (x, end)], style))?;
                root.draw(&PathElement::new([(x - 3, end), (x + 3, end)], style))?;
            }
            let size = if first.emphasised { MARK + 1 } else { MARK - 1 };
            first.look.mark(root, (x, y), size, mark.value == 0.0)?;
        }
        Ok(())
    }

    /// Draws the label of each line right of the plot, with a leader from the line's last mark.
    fn labels(
        &self,
        root: &Area,
        lines: &[Line],
        right: i32,
        rows: Range<i32>,
        at: &impl Fn(f64, f64) -> Pixel,
    ) -> Drawn {
        let last = |line: &Line| {
            let mark = self.series[line.series[0]].marks.last();
            mark.map(|mark| at(mark.x, mark.value))
        };
        let mut labelled: Vec<(&Line, Option<Pixel>)> = lines.iter().map(|line| (line, last(line))).collect();
        labelled.sort_by_key(|(_, target)| target.map_or(i32::MAX, |(_, y)| y));
        let blocks: Vec<(i32, i32)> = labelled
            .iter()
            .map(|(line, target)| (target.map_or(rows.end, |(_, y)| y), LINE * line.label.len() as i32))
            .collect();
        for ((line, target), top) in labelled.iter().zip(tops(&blocks, rows)) {
            let first = &self.series[line.series[0]];
            let (x, height) = (right + GAP, LINE * line.label.len() as i32);
            root.draw(&SubjectGroup(&self.ids(line)))?;
            if let &Some((from, y)) = target {
                let middle = top + height / 2;
                let leader = [(from, y), (right + 2, y), (x - 4, middle), (x, middle)];
                root.draw(&PathElement::new(leader, first.look.color.mix(0.5)))?;
                if line.label.len() > 1 {
                    let bracket = [(x, top + 3), (x, top + height - 3)];
                    root.draw(&PathElement::new(bracket, first.look.color))?;
                }
            }
            let color = if first.look.color == QUIET { FAINT } else { first.look.color };
            for (i, text) in (0..).zip(&line.label) {
                root.draw_text(text, &name(false, color), (x + BESIDE, top + LINE * i + LINE / 2))?;
            }
        }
        root.draw(&SubjectGroup(&[]))
    }

    /// Draws the hover targets of the marks. The tooltip names all series with a mark near the pointer.
    fn hover(&self, root: &Area, at: &impl Fn(f64, f64) -> Pixel) -> Drawn {
        let marks = self.series.iter().flat_map(|series| series.marks.iter().map(move |mark| (series.id, mark)));
        let placed: Vec<_> = marks.map(|(id, mark)| (at(mark.x, mark.value), id, mark)).collect();
        let mut places: Vec<Pixel> = placed.iter().map(|&(place, ..)| place).collect();
        places.sort_unstable();
        places.dedup();
        for (x, y) in places {
            // Marks exactly here come first. IDs with the same text share a line.
            let near =
                |((other_x, other_y), ..): &&(Pixel, &str, &Mark)| (other_x - x).abs().max((other_y - y).abs()) <= NEAR;
            let mut named: Vec<_> = placed.iter().filter(near).collect();
            named.sort_by_key(|(place, _, mark)| (*place != (x, y), mark.tooltip.as_str()));
            let lines = named.chunk_by(|(.., a), (.., b)| a.tooltip == b.tooltip).map(|same| {
                let ids: Vec<_> = same.iter().map(|&&(_, id, _)| id).collect();
                format!("{}, {}", ids.join(", "), same[0].2.tooltip)
            });
            let title = lines.collect::<Vec<_>>().join("\n");
            let mut subjects: Vec<_> = named.iter().map(|&&(_, id, _)| id).collect();
            subjects.dedup();
            let shape = Shape::Disc { center: (x, y), radius: MARK + 4 };
            root.draw(&Hover { shape, subjects, title, data: Vec::new() })?;
        }
        Ok(())
    }
}

/// Draws two strokes across an axis, from end to end of the part that they take out.
fn axis_break(root: &Area, ends: [Pixel; 2], (dx, dy): Pixel) -> Drawn {
    let [(x0, y0), (x1, y1)] = ends;
    root.draw(&PathElement::new([(x0, y0), (x1, y1)], PAGE.stroke_width(3)))?;
    ends.iter().try_for_each(|&(x, y)| root.draw(&PathElement::new([(x - dx, y - dy), (x + dx, y + dy)], FAINT)))
}

/// The tops of blocks in a column, each given by the place of its middle that it wants, in ascending order, and its
/// height. Blocks do not overlap, keep their order, and stay within the rows if they fit.
fn tops(blocks: &[(i32, i32)], rows: Range<i32>) -> Vec<i32> {
    let mut least = rows.start;
    let mut tops: Vec<i32> = blocks
        .iter()
        .map(|&(middle, height)| {
            let top = least.max(middle - height / 2);
            least = top + height;
            top
        })
        .collect();
    let mut most = rows.end;
    for (top, (_, height)) in tops.iter_mut().zip(blocks).rev() {
        *top = (most - height).min(*top);
        most = *top;
    }
    tops
}

#[cfg(test)]
mod tests {
    use super::super::palette::{BAD, QUIET};
    use super::*;

    #[test]
    fn labels_do_not_overlap_and_keep_their_order() {
        let blocks: Vec<(i32, i32)> = (0..12).map(|i| (100 + i / 4 * 60, LINE * (1 + i % 3))).collect();
        let rows = 0..LINE * 24 + 10;
        let tops = tops(&blocks, rows.clone());
        for (i, pair) in tops.windows(2).enumerate() {
            assert!(pair[0] + blocks[i].1 <= pair[1], "{tops:?}");
        }
        assert!(tops[0] >= rows.start && tops[11] + blocks[11].1 <= rows.end, "{tops:?}");
        assert_eq!(super::tops(&[(50, 20), (90, 20)], 0..200), [40, 80]);
    }

    fn panel<'a>(series: &'a [(&'a str, RGBColor, &'a [f64])]) -> Panel<'a> {
        let series = series.iter().map(|&(name, color, values)| Series {
            id: name,
            name,
            look: Look::new(color, 0),
            emphasised: color == BAD,
            marks: values
                .iter()
                .enumerate()
                .map(|(step, &value)| Mark {
                    step,
                    x: 10f64.powi(step as i32),
                    value,
                    bound: (value == 0.0).then_some(3.0),
                    tooltip: String::new(),
                })
                .collect(),
        });
        Panel { title: String::new(), possible: 0.0..=1e6, threshold: None, series: series.collect() }
    }

    #[test]
    fn series_with_the_same_line_share_a_label() {
        let zeros: &[f64] = &[0.0, 0.0];
        let all = [
            ("a", QUIET, zeros),
            ("b", BAD, &[1.0, 2.0]),
            ("c", QUIET, zeros),
            ("d", QUIET, zeros),
            ("e", BAD, &[1.0, 2.0]),
            ("f", QUIET, &[0.0, 1.0]),
            ("g", QUIET, zeros),
            ("h", QUIET, &[]),
        ];
        let labels: Vec<_> = panel(&all).lines().into_iter().map(|line| line.label.join(" ")).collect();
        assert_eq!(labels, ["a c and 2 more", "b e", "f", "not measured: h"]);
    }

    #[test]
    fn a_zero_is_drawn_hollow_below_every_measured_value() {
        // One event in a base where zero has the bound 3 is less than the bound, and still above the zero.
        let all: [(&str, RGBColor, &[f64]); 2] = [("zero", QUIET, &[0.0, 0.0]), ("one", BAD, &[1.0, 0.4])];
        let x = XAxis { axis: LogAxis::through(&[1.0, 10.0]), title: String::new(), tick: |x| x.to_string() };
        let stack = Stack { panels: vec![panel(&all)], x };
        let width = stack.width();
        let svg = super::super::canvas::canvas((width, stack.height(width)), |root| stack.draw(root, 0, width));
        let centers = |look: &str| -> Vec<i32> {
            let circles = svg.lines().filter(|line| line.starts_with("<circle") && line.contains(look));
            circles.filter_map(|line| line.split(" cy=\"").nth(1)?.split('"').next()?.parse().ok()).collect()
        };
        let (zeros, measured) = (centers("stroke=\"#949DA6\""), centers("fill=\"#C8321A\""));
        assert!(zeros.len() == 2 && measured.len() == 2, "{svg}");
        assert!(zeros.iter().all(|zero| measured.iter().all(|value| value + 8 < *zero)), "{zeros:?} {measured:?}");
    }
}
