//! `speed-accuracy.svg`: every kernel's speed against its lost rays and against the error of its `t`.
//!
//! plotters maps values to pixels and draws the axes. What must not overlap is placed here, in pixels, since a chart
//! without fonts cannot measure text: kernel names are set in a monospaced face, whose width is known, and stand in a
//! column beside the plot, each tied to its fastest mark.

use std::io;
use std::ops::{Range, RangeInclusive};

use plotters::coord::Shift;
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::figures::{Figures, Group, groups, si};
use super::record::Record;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = Result<(), DrawingAreaErrorKind<io::Error>>;
type Pixel = (i32, i32);

/// The faces of a kernel, in the order in which their marks are joined.
const FACES: [(&str, &str); 3] = [
    ("1x1", "one ray, one primitive (scalar)"),
    ("8x1", "eight rays, one primitive"),
    ("1x8", "one ray, eight primitives"),
];

/// Okabe and Ito's colours, which the colour-blind can tell apart, without the yellow, which white swallows.
const PALETTE: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];
const INK: RGBColor = RGBColor(40, 40, 40);
const FAINT: RGBColor = RGBColor(120, 120, 120);
const GRID: RGBColor = RGBColor(234, 234, 234);
const FRONTIER: RGBColor = RGBColor(196, 196, 196);

const WIDTH: i32 = 1000;
/// Plots get no narrower than this; long names widen the chart instead.
const MIN_PLOT: i32 = 480;
const LEFT: i32 = 64;
/// From the plot to the names; leaders cross it.
const GAP: i32 = 48;
const MARGIN: i32 = 16;
const HEADER: i32 = 132;
const GROUP_TITLE: i32 = 34;
const PANEL_TITLE: i32 = 22;
const PANEL_GAP: i32 = 14;
const X_LABELS: i32 = 22;
const X_TITLE: i32 = 30;
const MIN_PANEL: i32 = 140;
/// From one name to the next.
const LINE: i32 = 15;
const TEXT: f64 = 12.0;
/// Advance of a character of [`TEXT`] size in the widest of the common monospaced faces.
const ADVANCE: f64 = 0.605 * TEXT;
/// Half the size of a mark.
const MARK: i32 = 5;
/// Where a `t` error of zero is drawn: a decade below the least that there can be otherwise.
const ULP_FLOOR: f64 = 0.1;
/// From the middle of a name's coloured dot to the name.
const SWATCH: i32 = 9;
/// Appended to the names of kernels that a panel has no mark for.
const NOT_MEASURED: &str = " (not measured)";

/// Draws the chart of the one-thread figures. For each group of kernels there are two panels over the same speeds, one
/// for lost rays and one for the generic error of `t`.
pub(super) fn speed_accuracy_svg(record: &Record) -> String {
    let groups = groups(record);
    let panels: Vec<_> = groups.iter().map(panels).collect();
    let series = panels.iter().flat_map(|(lost, ulp)| lost.series.iter().chain(&ulp.series));
    let longest = series.map(|series| series.label().chars().count()).max().unwrap_or(0);
    let column = SWATCH + (longest as f64 * ADVANCE).ceil() as i32;
    let plot = (WIDTH - LEFT - GAP - column - MARGIN).max(MIN_PLOT);
    let width = LEFT + plot + GAP + column + MARGIN;
    let heights = |(lost, ulp): &(Panel, Panel)| GROUP_TITLE + lost.height() + ulp.height() + X_LABELS + X_TITLE;
    let height = HEADER + panels.iter().map(heights).sum::<i32>() + MARGIN;

    let mut svg = String::new();
    let root = SVGBackend::with_string(&mut svg, (width as u32, height as u32)).into_drawing_area();
    draw(&root, record, &groups, &panels, plot).expect("a string takes whatever is written to it");
    drop(root);
    svg
}

fn draw(root: &Area, record: &Record, groups: &[Group], panels: &[(Panel, Panel)], plot: i32) -> Drawn {
    // Pages are white or dark; the chart brings its own background.
    root.fill(&WHITE)?;
    header(root, record)?;
    let mut top = HEADER;
    for (group, (lost, ulp)) in groups.iter().zip(panels) {
        root.draw_text(&group.heading(), &heading(15.0), (LEFT, top + GROUP_TITLE / 2))?;
        top += GROUP_TITLE;
        let speeds = LogAxis::new(lost.marks().chain(ulp.marks()).map(|mark| mark.speed));
        for (panel, labels) in [(lost, 0), (ulp, X_LABELS)] {
            panel.draw(root, &speeds, top, plot, labels)?;
            top += panel.height();
        }
        top += X_LABELS;
        let speed = "speed: million tests per second, one thread (to the right: faster)";
        root.draw_text(speed, &label(TEXT, INK).pos(Pos::new(HPos::Center, VPos::Center)), (LEFT + plot / 2, top))?;
        top += X_TITLE;
    }
    root.present()
}

/// The message, and what the marks mean.
fn header(root: &Area, record: &Record) -> Drawn {
    let quick = if record.quick { " (quick run: fewer rays and samples)" } else { "" };
    let title = "Speed against accuracy: right is faster, down is more accurate";
    root.draw_text(&format!("{title}{quick}"), &heading(19.0), (LEFT, 26))?;
    let machine = format!("{}, {}, one thread", record.machine.cpu, record.machine.rustc);
    root.draw_text(&machine, &label(TEXT, FAINT), (LEFT, 50))?;
    for ((face, &(name, meaning)), x) in FACES.iter().enumerate().zip([LEFT, LEFT + 310, LEFT + 590]) {
        stamp(root, face, (x + MARK, 78), MARK, INK)?;
        root.draw_text(&format!("{name}: {meaning}"), &label(TEXT, INK), (x + 18, 78))?;
    }
    hollow(root, 1, (LEFT + MARK, 102), INK)?;
    root.draw_text("hollow: none in n rays, drawn at 3/n (95 % bound)", &label(TEXT, INK), (LEFT + 18, 102))?;
    let x = LEFT + 440;
    root.draw(&PathElement::new([(x, 94), (x, 102), (x - 24, 102), (x - 24, 110)], FRONTIER.stroke_width(3)))?;
    root.draw_text("frontier: nothing is both faster and as accurate", &label(TEXT, INK), (x + 12, 102))
}

/// The panels of a group: lost rays, and the error of `t`.
fn panels<'a>(group: &Group<'a>) -> (Panel<'a>, Panel<'a>) {
    let lost = |kernel: &Figures| kernel.lost.map(|lost| (lost.or_bound(), lost.per_million == 0.0));
    let ulp = |kernel: &Figures| kernel.ulp().map(|ulp| (if ulp == 0 { ULP_FLOOR } else { ulp as f64 }, false));
    let ulp_title = "99th percentile of the error of t, in units in the last place (ulp), generic rays";
    (
        Panel { title: group.lost_means(), possible: 0.0..=1e6, zero: None, series: series(group, lost) },
        Panel { title: ulp_title, possible: 1.0..=f64::INFINITY, zero: Some(ULP_FLOOR), series: series(group, ulp) },
    )
}

/// One plot: its marks, one series for each kernel, and the names beside it.
struct Panel<'a> {
    title: &'static str,
    /// Values that there can be; others get no tick.
    possible: RangeInclusive<f64>,
    /// Value that stands for zero, which a logarithmic axis has no place for.
    zero: Option<f64>,
    series: Vec<Series<'a>>,
}

struct Series<'a> {
    name: &'a str,
    color: RGBColor,
    marks: Vec<Mark>,
}

impl Series<'_> {
    /// What stands beside the plot.
    fn label(&self) -> String {
        let remark = if self.marks.is_empty() { NOT_MEASURED } else { "" };
        format!("{}{remark}", self.name)
    }
}

struct Mark {
    /// Index into [`FACES`].
    face: usize,
    /// Million tests per second.
    speed: f64,
    value: f64,
    /// The value is an upper bound: nothing was observed.
    bound: bool,
}

/// The series of a group; `value` gives what is plotted, and whether it is a bound.
fn series<'a>(group: &Group<'a>, value: impl Fn(&Figures) -> Option<(f64, bool)>) -> Vec<Series<'a>> {
    let series = group.kernels.iter().zip(PALETTE.into_iter().cycle()).map(|(kernel, color)| {
        let mark = |(face, (name, _)): (usize, &(&str, &str))| {
            let (value, bound) = value(kernel)?;
            let speed = kernel.mtests(name, 1).filter(|&speed| speed > 0.0 && speed.is_finite())?;
            Some(Mark { face, speed, value, bound })
        };
        Series { name: kernel.name, color, marks: FACES.iter().enumerate().filter_map(mark).collect() }
    });
    series.collect()
}

impl Panel<'_> {
    fn marks(&self) -> impl Iterator<Item = &Mark> {
        self.series.iter().flat_map(|series| &series.marks)
    }

    fn plot_height(&self) -> i32 {
        MIN_PANEL.max(LINE * (self.series.len() as i32 + 1))
    }

    fn height(&self) -> i32 {
        PANEL_TITLE + self.plot_height() + PANEL_GAP
    }

    /// Draws the panel with its upper edge at `top`; `x_labels` is the space for the figures below it.
    fn draw(&self, root: &Area, speeds: &LogAxis, top: i32, width: i32, x_labels: i32) -> Drawn {
        root.draw_text(self.title, &label(TEXT, INK), (LEFT, top + PANEL_TITLE / 2))?;
        let top = top + PANEL_TITLE;
        let bottom = top + self.plot_height();
        let mut values = LogAxis::new(self.marks().map(|mark| mark.value));
        values.ticks.retain(|tick| self.possible.contains(tick));
        values.ticks.extend(self.zero.filter(|&zero| self.marks().any(|mark| mark.value == zero)));

        let area = root.clone().shrink((0, top), (LEFT + width, bottom - top + x_labels));
        let mut chart = ChartBuilder::on(&area)
            .set_label_area_size(LabelAreaPosition::Left, LEFT)
            .set_label_area_size(LabelAreaPosition::Bottom, x_labels)
            .build_cartesian_2d(speeds.clone(), values)?;
        chart
            .configure_mesh()
            .bold_line_style(GRID)
            .axis_style(FAINT)
            .label_style(label(TEXT, INK))
            .x_label_formatter(&|&speed| si(speed, 1))
            .y_label_formatter(&|&value| if Some(value) == self.zero { "0".to_owned() } else { si(value, 1) })
            .draw()?;

        let pixel = |mark: &Mark| chart.backend_coord(&(mark.speed, mark.value));
        self.frontier(root, (LEFT, top), pixel)?;
        for series in &self.series {
            let line = series.marks.iter().map(pixel).collect::<Vec<_>>();
            root.draw(&PathElement::new(line, series.color.mix(0.6)))?;
        }
        self.names(root, LEFT + width, top..bottom, pixel)?;
        for series in &self.series {
            series.marks.iter().try_for_each(|mark| mark.draw(root, pixel(mark), series.color))?;
        }
        Ok(())
    }

    /// A step line through the marks that no other mark beats in both, from the upper edge to the left one.
    fn frontier(&self, root: &Area, (left, top): Pixel, pixel: impl Fn(&Mark) -> Pixel) -> Drawn {
        let mut marks: Vec<&Mark> = self.marks().collect();
        marks.sort_by(|a, b| b.speed.total_cmp(&a.speed).then(a.value.total_cmp(&b.value)));
        let mut best = f64::INFINITY;
        let mut steps: Vec<Pixel> = Vec::new();
        for mark in marks {
            if mark.value < best {
                best = mark.value;
                let (x, y) = pixel(mark);
                steps.extend([(x, steps.last().map_or(top, |&(_, above)| above)), (x, y)]);
            }
        }
        if let Some(&(_, last)) = steps.last() {
            steps.push((left, last));
            root.draw(&PathElement::new(steps, FRONTIER.stroke_width(3)))?;
        }
        Ok(())
    }

    /// The names of all series in a column right of the plot, each tied to its fastest mark.
    fn names(&self, root: &Area, right: i32, rows: Range<i32>, pixel: impl Fn(&Mark) -> Pixel) -> Drawn {
        let column = right + GAP;
        let fastest = |series: &Series| {
            series.marks.iter().max_by(|a, b| a.speed.total_cmp(&b.speed)).map_or((right, rows.end), &pixel)
        };
        let targets: Vec<Pixel> = self.series.iter().map(fastest).collect();
        for ((series, &target), y) in self.series.iter().zip(&targets).zip(name_rows(&targets, column, rows)) {
            if !series.marks.is_empty() {
                root.draw(&PathElement::new([target, (column - 4, y)], series.color.mix(0.6)))?;
            }
            root.draw(&Circle::new((column, y), 4, series.color.filled()))?;
            root.draw_text(
                &series.label(),
                &styled(FontFamily::Monospace, FontStyle::Normal, TEXT, INK),
                (column + SWATCH, y),
            )?;
        }
        Ok(())
    }
}

/// The row of each name in a column at `x`, such that names are a line apart, near their targets, and no two leaders
/// cross.
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

    // Two leaders that cross get shorter by exchanging their names, so that this ends, and ends without crossings.
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

impl Mark {
    fn draw(&self, root: &Area, at: Pixel, color: RGBColor) -> Drawn {
        // A white rim keeps neighbours apart.
        stamp(root, self.face, at, MARK + 1, WHITE)?;
        if self.bound { hollow(root, self.face, at, color) } else { stamp(root, self.face, at, MARK, color) }
    }
}

/// The mark of an upper bound: hollow, with an arrow downward.
fn hollow(root: &Area, face: usize, (x, y): Pixel, color: RGBColor) -> Drawn {
    stamp(root, face, (x, y), MARK, color)?;
    stamp(root, face, (x, y), MARK - 2, WHITE)?;
    let (from, tip) = (y + MARK, y + MARK + 7);
    root.draw(&PathElement::new([(x, from), (x, tip)], color.stroke_width(2)))?;
    root.draw(&PathElement::new([(x - 3, tip - 3), (x, tip), (x + 3, tip - 3)], color.stroke_width(2)))
}

/// A filled circle, square or diamond for the face.
fn stamp(root: &Area, face: usize, (x, y): Pixel, size: i32, color: RGBColor) -> Drawn {
    match face {
        0 => root.draw(&Circle::new((x, y), size, color.filled())),
        1 => {
            let half = size - 1;
            root.draw(&Rectangle::new([(x - half, y - half), (x + half, y + half)], color.filled()))
        }
        _ => {
            let half = size + 1;
            root.draw(&Polygon::new([(x - half, y), (x, y - half), (x + half, y), (x, y + half)], color.filled()))
        }
    }
}

/// A logarithmic axis around what is shown, with ticks that suit its length.
#[derive(Clone)]
struct LogAxis {
    /// Decimal logarithms of the ends.
    ends: Range<f64>,
    ticks: Vec<f64>,
}

impl LogAxis {
    fn new(values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = values
            .map(f64::log10)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (value.min(low), value.max(high)));
        // Without values, any axis will do.
        let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
        // Some space around the outermost marks, and enough for two ticks where all are equal.
        let padding = (0.08 * (high - low) + 0.12).max(0.5 - (high - low) / 2.0);
        let ends = low - padding..high + padding;
        let decades = ends.end - ends.start;
        let steps: &[f64] = if decades < 2.5 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let every = (decades / 6.0).ceil() as i32;
        let exponents = (ends.start.floor() as i32..=ends.end.ceil() as i32).filter(|exponent| exponent % every == 0);
        let ticks = exponents.flat_map(|exponent| steps.iter().map(move |step| step * 10f64.powi(exponent)));
        Self { ticks: ticks.filter(|tick| ends.contains(&tick.log10())).collect(), ends }
    }
}

impl Ranged for LogAxis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (start, end): (i32, i32)) -> i32 {
        let position = (value.log10() - self.ends.start) / (self.ends.end - self.ends.start);
        start + (position * f64::from(end - start)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        // One grid line per tick, no finer ones.
        if hint.weight().allow_light_points() { Vec::new() } else { self.ticks.clone() }
    }

    fn range(&self) -> Range<f64> {
        10f64.powf(self.ends.start)..10f64.powf(self.ends.end)
    }
}

impl ValueFormatter<f64> for LogAxis {}

/// plotters-svg writes font sizes divided by this.
const FONT_SCALE: f64 = 1.24;

/// Text that begins at a point, vertically centred on it.
fn label(size: f64, color: RGBColor) -> TextStyle<'static> {
    styled(FontFamily::SansSerif, FontStyle::Normal, size, color)
}

fn heading(size: f64) -> TextStyle<'static> {
    styled(FontFamily::SansSerif, FontStyle::Bold, size, INK)
}

fn styled(family: FontFamily<'static>, style: FontStyle, size: f64, color: RGBColor) -> TextStyle<'static> {
    FontDesc::new(family, size * FONT_SCALE, style).color(&color).pos(Pos::new(HPos::Left, VPos::Center))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::figures::tests::{degenerate_records, record_of, some_ids};

    fn occurrences(svg: &str, what: &str) -> usize {
        svg.matches(what).count()
    }

    #[test]
    fn every_kernel_is_named_in_both_panels() {
        let record = record_of(&some_ids());
        let svg = speed_accuracy_svg(&record);
        for group in groups(&record) {
            assert!(svg.contains(&format!(">\n{}\n<", group.heading())), "{}", group.title);
        }
        // Each name occurs in two groups, and in both panels of each.
        for name in ["cramer", "moller_trumbore", "division", "padded"] {
            assert_eq!(occurrences(&svg, &format!(">\n{name}\n<")), 4, "{name}");
        }
    }

    #[test]
    fn a_zero_is_marked_as_a_bound() {
        let mut record = record_of(&["triangle/cramer".into()]);
        let with_zero = speed_accuracy_svg(&record);
        record.accuracy.iter_mut().for_each(|row| row.leak_per_million = 10.0);
        let without = speed_accuracy_svg(&record);
        // Three faces, and a stem and a tip for each tick.
        assert_eq!(occurrences(&with_zero, "polyline"), occurrences(&without, "polyline") + 6);
    }

    #[test]
    fn only_a_zero_is_labelled_so() {
        let mut record = record_of(&["triangle/cramer".into()]);
        record.accuracy.iter_mut().for_each(|row| (row.mesh_hits, row.leak_per_million) = (30_000_000, 0.0));
        record.accuracy.iter_mut().for_each(|row| row.t_ulp_p99 = 1);
        assert_eq!(occurrences(&speed_accuracy_svg(&record), ">\n0\n<"), 0, "a bound of 0.1 is none");
        record.accuracy.iter_mut().for_each(|row| row.t_ulp_p99 = 0);
        assert_eq!(occurrences(&speed_accuracy_svg(&record), ">\n0\n<"), 1);
    }

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
    fn axes_have_at_least_two_ticks() {
        for values in [vec![], vec![1e6], vec![20.0, 21.0], vec![0.1, 44_000.0], vec![1e-3, 4e9], vec![1e-300, 1e300]] {
            let ticks = LogAxis::new(values.iter().copied()).ticks.len();
            assert!((2..=10).contains(&ticks), "{values:?}: {ticks}");
        }
    }

    #[test]
    fn degenerate_records_have_a_chart() {
        for record in degenerate_records() {
            let svg = speed_accuracy_svg(&record);
            assert!(!svg.contains("NaN") && !svg.contains("inf") && svg.contains("</svg>"));
            assert!(!svg.contains(&i32::MAX.to_string()) && !svg.contains(&i32::MIN.to_string()));
        }
    }
}
