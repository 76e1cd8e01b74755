//! One plot: a series of marks for each kernel, and a column of names beside it. A leader connects each name with the
//! last mark of its series.

use std::collections::BTreeMap;
use std::ops::{Range, RangeInclusive};

use plotters::prelude::*;

use super::axis::LogAxis;
use super::canvas::{Area, Drawing, Drawn, centered, label, name};
use super::hover::{Hover, Shape};
use super::layout::{ADVANCE, FAINT, GRID, INK, LEFT, LINE, MARGIN, Pixel, TEXT, WIDTH};
use super::look::{Look, line};
use super::svg::SubjectGroup;
use crate::study::figures::si;

/// Minimum width of a plot; long names widen the chart instead.
const MIN_PLOT: i32 = 480;
const MIN_HEIGHT: i32 = 150;
const TITLE_HEIGHT: i32 = 24;
/// Marks at most this far apart count as overlapping.
const NEAR: i32 = 4;
/// Space between the plot and the column of names, for the leaders.
const GAP: i32 = 48;
/// Width of the sample of line and mark before each name.
const SAMPLE: i32 = 34;
const BELOW: i32 = 16;
const X_LABELS: i32 = 22;
const X_TITLE: i32 = 30;
const FRONTIER: RGBColor = RGBColor(150, 150, 150);
const DOMINATED: RGBColor = RGBColor(244, 244, 244);
/// Follows the name of a kernel without marks in this panel.
const NOT_MEASURED: &str = " (not measured)";

/// One plot.
pub(super) struct Panel<'a> {
    pub(super) title: String,
    /// The possible values; others get no tick.
    pub(super) possible: RangeInclusive<f64>,
    /// A value that is marked by a line across the plot.
    pub(super) threshold: Option<f64>,
    /// Whether to draw the frontier: the marks that no other mark beats on both axes.
    pub(super) frontier: bool,
    pub(super) series: Vec<Series<'a>>,
}

/// The marks of a kernel.
pub(super) struct Series<'a> {
    /// Unique ID within the chart.
    pub(super) id: &'a str,
    pub(super) name: &'a str,
    pub(super) marks: Vec<Mark>,
}

/// A measured value.
pub(super) struct Mark {
    /// Marks of consecutive steps are joined by a line.
    pub(super) step: usize,
    pub(super) x: f64,
    /// The range of `x` within the noise. Marks whose ranges overlap tie.
    pub(super) spread: Option<[f64; 2]>,
    pub(super) value: f64,
    /// Whether the value is an upper bound, because no event was observed.
    pub(super) bound: bool,
    /// Half its size in pixels.
    pub(super) size: i32,
    /// The text of the tooltip after the ID: figures with their units.
    pub(super) tooltip: String,
}

impl Mark {
    /// The observed value: 0 for a bound.
    fn observed(&self) -> f64 {
        if self.bound { 0.0 } else { self.value }
    }
}

impl Series<'_> {
    /// The name beside the plot.
    fn label(&self) -> String {
        let remark = if self.marks.is_empty() { NOT_MEASURED } else { "" };
        format!("{}{remark}", self.name)
    }
}

/// Width of a plot that leaves room for the names of all panels, and width of the whole chart.
pub(super) fn widths<'a>(panels: impl Iterator<Item = &'a Panel<'a>>) -> (i32, i32) {
    let beside = LEFT + names_width(panels);
    let plot = (WIDTH - beside).max(MIN_PLOT);
    (plot, plot + beside)
}

/// Width to the right of a plot, for the leaders, samples and names of all these panels.
pub(super) fn names_width<'a>(panels: impl Iterator<Item = &'a Panel<'a>>) -> i32 {
    let series = panels.flat_map(|panel| &panel.series);
    let longest = series.map(|series| series.label().chars().count()).max().unwrap_or(0);
    GAP + SAMPLE + (longest as f64 * ADVANCE).ceil() as i32 + MARGIN
}

/// Height of a stack of panels with one horizontal axis.
pub(super) fn stack_height(panels: &[Panel]) -> i32 {
    panels.iter().map(Panel::height).sum::<i32>() + X_LABELS + X_TITLE
}

/// The place of a plot.
#[derive(Clone, Copy)]
pub(super) struct Frame {
    /// Upper left corner.
    pub(super) corner: Pixel,
    pub(super) size: Pixel,
    /// Whether the ticks of the horizontal axis are labelled.
    pub(super) x_labels: bool,
}

/// The horizontal axis of a stack of panels.
pub(super) struct XAxis<'a> {
    pub(super) axis: LogAxis,
    pub(super) title: String,
    pub(super) tick: &'a dyn Fn(f64) -> String,
}

/// Draws a stack of panels over one horizontal axis, starting at `top`.
pub(super) fn draw_stack(root: &Area, panels: &[Panel], x: &XAxis, mut top: i32, plot: i32) -> Drawn {
    for (i, panel) in panels.iter().enumerate() {
        root.draw_text(&panel.title, &label(TEXT, INK), (LEFT, top + TITLE_HEIGHT / 2))?;
        let corner = (LEFT, top + TITLE_HEIGHT);
        let frame = Frame { corner, size: (plot, panel.plot_height()), x_labels: i + 1 == panels.len() };
        panel.draw(root, x, frame, Some(&[]))?;
        top += panel.height();
    }
    root.draw_text(&x.title, &centered(label(TEXT, INK)), (LEFT + plot / 2, top + X_LABELS))
}

/// Draws a sample of the frontier, for a legend.
pub(super) fn frontier_sample(root: &Area, (x, y): Pixel) -> Drawn {
    root.draw(&Rectangle::new([(x, y - 9), (x + 24, y + 7)], DOMINATED.filled()))?;
    root.draw(&PathElement::new([(x + 24, y - 9), (x + 24, y - 1), (x + 12, y - 1)], FRONTIER.stroke_width(3)))?;
    root.draw(&PathElement::new([(x + 12, y - 1), (x + 12, y + 7), (x, y + 7)], FRONTIER.stroke_width(3)))
}

/// Draws a sample of the threshold, for a legend.
pub(super) fn threshold_sample(root: &Area, (x, y): Pixel) -> Drawn {
    root.draw(&PathElement::new([(x, y), (x + 24, y)], FRONTIER.stroke_width(1)))
}

/// A mark of a series, and its position in pixels.
#[derive(Clone, Copy)]
struct PlacedMark<'a> {
    series: usize,
    mark: &'a Mark,
    at: Pixel,
}

impl Panel<'_> {
    fn marks(&self) -> impl Iterator<Item = &Mark> {
        self.series.iter().flat_map(|series| &series.marks)
    }

    /// Minimum height of a plot, with room for the names.
    pub(super) fn least_height(&self) -> i32 {
        LINE * (self.series.len() as i32 + 1)
    }

    fn plot_height(&self) -> i32 {
        MIN_HEIGHT.max(self.least_height())
    }

    fn height(&self) -> i32 {
        TITLE_HEIGHT + self.plot_height() + BELOW
    }

    /// Draws the plot. With `names`, also draws the names of all series beside it; those on the frontier and those
    /// listed in `names` are bold. Returns the series on the frontier.
    pub(super) fn draw(&self, root: &Area, x: &XAxis, frame: Frame, names: Option<&[usize]>) -> Drawing<Vec<usize>> {
        let Frame { corner: (left, top), size: (width, height), x_labels } = frame;
        let (right, bottom) = (left + width, top + height);
        let label_height = if x_labels { X_LABELS } else { 0 };
        let values = LogAxis::around(self.marks().map(|mark| mark.value), self.possible.clone());
        let area = root.clone().shrink((left - LEFT, top), (LEFT + width, height + label_height));
        let mut chart = ChartBuilder::on(&area)
            .set_label_area_size(LabelAreaPosition::Left, LEFT)
            .set_label_area_size(LabelAreaPosition::Bottom, label_height)
            .build_cartesian_2d(x.axis.clone(), values.clone())?;

        let mut placed: Vec<PlacedMark> = Vec::new();
        for (series, marks) in self.series.iter().enumerate() {
            let place = |mark| PlacedMark { series, mark, at: chart.backend_coord(&(mark.x, mark.value)) };
            placed.extend(marks.marks.iter().map(place));
        }
        let frontier = if self.frontier { frontier(&placed) } else { Vec::new() };
        let steps = frontier_steps(&frontier, (left, top));
        if !steps.is_empty() {
            let dominated = steps.iter().copied().chain([(left, top)]).collect::<Vec<_>>();
            root.draw(&Polygon::new(dominated, DOMINATED.filled()))?;
        }
        chart
            .configure_mesh()
            .bold_line_style(GRID)
            .axis_style(FAINT)
            .label_style(label(TEXT, INK))
            .x_labels(x.axis.ticks.len())
            .x_label_formatter(&|&value| (x.tick)(value))
            .y_label_formatter(&|&value| si(value, 1))
            .draw()?;
        if let Some(gap) = x.axis.gap().filter(|_| x_labels) {
            // Zero is not on a logarithmic axis, so a break is drawn before it.
            let x = left + (gap * f64::from(width)).round() as i32;
            root.draw(&Rectangle::new([(x - 3, bottom - 2), (x + 3, bottom + 2)], WHITE.filled()))?;
            for x in [x - 3, x + 3] {
                root.draw(&PathElement::new([(x - 3, bottom + 5), (x + 3, bottom - 5)], FAINT))?;
            }
        }
        if let Some(value) = self.threshold.filter(|&value| (0.0..1.0).contains(&values.position(value))) {
            let (_, y) = chart.backend_coord(&(x.axis.ticks.first().copied().unwrap_or(1.0), value));
            root.draw(&PathElement::new([(left, y), (right, y)], FRONTIER.stroke_width(1)))?;
        }
        if !steps.is_empty() {
            root.draw(&PathElement::new(steps, FRONTIER.stroke_width(3)))?;
        }
        self.lines(root, &placed)?;
        let best = with_ties(&placed, &frontier);
        if let Some(more) = names {
            self.names(root, right, top..bottom, &placed, &[&best, more].concat())?;
        }
        for PlacedMark { series, mark, at: (_, y) } in &placed {
            if let Some(spread) = mark.spread {
                let ends = spread.map(|x| (chart.backend_coord(&(x, mark.value)).0.clamp(left, right), *y));
                root.draw(&SubjectGroup(Some(self.series[*series].id)))?;
                whisker(root, ends, Look::of(*series))?;
            }
        }
        self.draw_marks(root, &placed)?;
        Ok(best)
    }

    /// Draws the names of all series in a column right of the plot, with leaders to their last marks. Those in `best`
    /// are bold.
    fn names(&self, root: &Area, right: i32, rows: Range<i32>, placed: &[PlacedMark], best: &[usize]) -> Drawn {
        let column = right + GAP;
        let last = |series: usize| {
            let marks = placed.iter().filter(|placed| placed.series == series).map(|placed| placed.at);
            marks.max_by_key(|&(x, _)| x).unwrap_or((right, rows.end))
        };
        let targets: Vec<Pixel> = (0..self.series.len()).map(last).collect();
        let names = name_rows(&targets, column, rows);
        for (i, ((series, &target), y)) in self.series.iter().zip(&targets).zip(names).enumerate() {
            let look = Look::of(i);
            root.draw(&SubjectGroup(Some(series.id)))?;
            if !series.marks.is_empty() {
                root.draw(&PathElement::new([target, (column - 4, y)], look.color.mix(0.6)))?;
            }
            line(root, &[(column, y), (column + SAMPLE - 6, y)], &[(Some(series.id), look)])?;
            look.mark(root, (column + SAMPLE / 2 - 3, y), 4, false)?;
            root.draw_text(&series.label(), &name(best.contains(&i)), (column + SAMPLE, y))?;
        }
        root.draw(&SubjectGroup(None))
    }

    /// Joins the marks of consecutive steps. Where several series coincide, the line is striped in their colours.
    fn lines(&self, root: &Area, placed: &[PlacedMark]) -> Drawn {
        let mut segments: BTreeMap<[Pixel; 2], Vec<usize>> = BTreeMap::new();
        for pair in placed.windows(2) {
            if pair[0].series == pair[1].series && pair[0].mark.step + 1 == pair[1].mark.step {
                segments.entry([pair[0].at, pair[1].at]).or_default().push(pair[0].series);
            }
        }
        // Consecutive segments of the same series become one line, so that the dash pattern continues.
        let mut chains: Vec<(Vec<usize>, Vec<Pixel>)> = Vec::new();
        for ([from, to], series) in segments {
            match chains.iter_mut().find(|(of, points)| *of == series && points.last() == Some(&from)) {
                Some((_, points)) => points.push(to),
                None => chains.push((series, vec![from, to])),
            }
        }
        for (series, points) in &chains {
            let looks: Vec<_> = series.iter().map(|&series| (Some(self.series[series].id), Look::of(series))).collect();
            line(root, points, &looks)?;
        }
        root.draw(&SubjectGroup(None))
    }

    /// Draws the marks. Of several marks in one place, one is drawn, a different one at each step; the tooltip names
    /// all.
    fn draw_marks(&self, root: &Area, placed: &[PlacedMark]) -> Drawn {
        let mut places: BTreeMap<Pixel, Vec<&PlacedMark>> = BTreeMap::new();
        for mark in placed {
            places.entry(mark.at).or_default().push(mark);
        }
        for (&at, here) in &places {
            let shown = here[here[0].mark.step % here.len()];
            root.draw(&SubjectGroup(Some(self.series[shown.series].id)))?;
            Look::of(shown.series).mark(root, at, shown.mark.size, shown.mark.bound)?;
        }
        root.draw(&SubjectGroup(None))?;
        for (&(x, y), here) in &places {
            let near = |other: &&PlacedMark| (other.at.0 - x).abs().max((other.at.1 - y).abs()) <= NEAR;
            // Marks exactly here come first. IDs with the same text share a line.
            let mut named: Vec<_> = placed.iter().filter(near).collect();
            named.sort_by_key(|other| (other.at != (x, y), other.mark.tooltip.as_str()));
            let lines = named.chunk_by(|a, b| a.mark.tooltip == b.mark.tooltip).map(|same| {
                let ids: Vec<_> = same.iter().map(|placed| self.series[placed.series].id).collect();
                format!("{}, {}", ids.join(", "), same[0].mark.tooltip)
            });
            let title = lines.collect::<Vec<_>>().join("\n");
            let mut subjects: Vec<_> = named.iter().map(|placed| self.series[placed.series].id).collect();
            subjects.dedup();
            let shape = Shape::Disc { center: (x, y), radius: here[0].mark.size + 3 };
            root.draw(&Hover { shape, subjects, title, data: Vec::new() })?;
        }
        Ok(())
    }
}

/// Draws the range of a mark within the noise.
pub(super) fn whisker(root: &Area, ends: [Pixel; 2], look: Look) -> Drawn {
    root.draw(&PathElement::new(ends, look.color))?;
    ends.iter().try_for_each(|&(x, y)| root.draw(&PathElement::new([(x, y - 3), (x, y + 4)], look.color)))
}

/// The marks that no other mark beats on both axes, largest `x` first. Bounds count as zero, so all zeros are equal.
fn frontier<'a>(placed: &[PlacedMark<'a>]) -> Vec<PlacedMark<'a>> {
    let mut marks = placed.to_vec();
    marks.sort_by(|a, b| b.mark.x.total_cmp(&a.mark.x).then(a.mark.observed().total_cmp(&b.mark.observed())));
    let mut best = f64::INFINITY;
    marks.retain(|PlacedMark { mark, .. }| {
        let better = mark.observed() < best;
        best = best.min(mark.observed());
        better
    });
    marks
}

/// The series on the frontier, and those that tie with one of them: with an equal value, and an `x` that ties.
fn with_ties(placed: &[PlacedMark], frontier: &[PlacedMark]) -> Vec<usize> {
    let ties = |a: &Mark, b: &Mark| match (a.spread, b.spread) {
        (Some([a_least, a_most]), Some([b_least, b_most])) => a_least <= b_most && b_least <= a_most,
        _ => a.x == b.x,
    };
    let is_on = |placed: &&PlacedMark| {
        frontier.iter().any(|best| best.mark.observed() == placed.mark.observed() && ties(best.mark, placed.mark))
    };
    placed.iter().filter(is_on).map(|placed| placed.series).collect()
}

/// The line through the frontier, from the top edge to the left edge.
fn frontier_steps(frontier: &[PlacedMark], (left, top): Pixel) -> Vec<Pixel> {
    let mut steps: Vec<Pixel> = Vec::new();
    for &PlacedMark { at: (x, y), .. } in frontier {
        steps.extend([(x, steps.last().map_or(top, |&(_, above)| above)), (x, y)]);
    }
    steps.extend(steps.last().map(|&(_, last)| (left, last)));
    steps
}

/// The vertical position of each name in a column at `x`. Names are at least a line apart and near their targets, and
/// no two leaders cross.
fn name_rows(targets: &[Pixel], x: i32, rows: Range<i32>) -> Vec<i32> {
    let mut slots: Vec<i32> = targets.iter().map(|&(_, y)| y).collect();
    slots.sort_unstable();
    let mut least = rows.start + LINE / 2;
    for slot in &mut slots {
        *slot = least.max(*slot);
        least = *slot + LINE;
    }
    let mut most = rows.end - LINE / 2;
    for slot in slots.iter_mut().rev() {
        *slot = most.min(*slot);
        most = *slot - LINE;
    }

    // Two leaders that cross get shorter if their names are swapped. So the loop ends, and no leaders cross then.
    let length = |(tx, ty): Pixel, y: i32| f64::from(x - tx).hypot(f64::from(y - ty));
    let mut swapped = true;
    while swapped {
        swapped = false;
        for a in 0..slots.len() {
            for b in a + 1..slots.len() {
                let (ta, tb, sa, sb) = (targets[a], targets[b], slots[a], slots[b]);
                if length(ta, sb) + length(tb, sa) < length(ta, sa) + length(tb, sb) - 1e-6 {
                    slots.swap(a, b);
                    swapped = true;
                }
            }
        }
    }
    slots
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_a_line_apart_and_leaders_do_not_cross() {
        let targets: Vec<Pixel> = (0..35).map(|i| (i * 37 % 300, 100 + i % 3 * 200)).collect();
        let rows = name_rows(&targets, 400, 0..36 * LINE);
        let mut sorted = rows.clone();
        sorted.sort_unstable();
        assert!(sorted.windows(2).all(|pair| pair[1] - pair[0] >= LINE));
        assert!(sorted[0] >= LINE / 2 && sorted[34] <= 36 * LINE - LINE / 2);
        let side = |(px, py): Pixel, (qx, qy): Pixel, (rx, ry): Pixel| (qx - px) * (ry - py) - (qy - py) * (rx - px);
        for a in 0..35 {
            for b in 0..a {
                let ([p, q], [r, s]) = ([targets[a], (400, rows[a])], [targets[b], (400, rows[b])]);
                let cross = side(p, q, r).signum() * side(p, q, s).signum() < 0
                    && side(r, s, p).signum() * side(r, s, q).signum() < 0;
                assert!(!cross, "{a} and {b}");
            }
        }
    }

    #[test]
    fn the_frontier_holds_the_marks_that_no_other_beats() {
        let mark = |x: f64, value, bound| Mark {
            step: 0,
            x,
            spread: Some([x - 0.4, x + 0.4]),
            value,
            bound,
            size: 5,
            tooltip: String::new(),
        };
        // The second is beaten by the first. The fourth is beaten by the third: both are zeros, and the third is
        // faster; its weaker bound does not matter.
        let all = [
            mark(9.0, 50.0, false),
            mark(8.0, 60.0, false),
            mark(5.0, 7.0, true),
            mark(4.0, 3.0, true),
            mark(7.0, 9.0, false),
            // Equal to the fifth and tied in speed; equal to the fifth and slower beyond the noise; worse, though tied
            // in speed.
            mark(6.3, 9.0, false),
            mark(6.1, 9.0, false),
            mark(6.9, 10.0, false),
        ];
        let placed: Vec<PlacedMark> =
            all.iter().enumerate().map(|(series, mark)| PlacedMark { series, mark, at: (0, 0) }).collect();
        let frontier = frontier(&placed);
        assert_eq!(frontier.iter().map(|placed| placed.series).collect::<Vec<_>>(), [0, 4, 2]);
        assert_eq!(with_ties(&placed, &frontier), [0, 2, 4, 5]);
    }
}
