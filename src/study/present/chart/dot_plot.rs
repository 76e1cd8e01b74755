//! A dot plot: a row for each kernel, named on the left, and panels side by side that share the rows. A dot is a
//! measured value, the line through it its interval. Colours stand for kinds of figures, never for kernels.

use std::ops::Range;

use plotters::prelude::*;

use super::axis::LogAxis;
use super::canvas::{Area, Drawn, canvas, centered, header, header_height, heading, label, name, wrapped};
use super::hover::{Hover, Shape};
use super::layout::{LINE, MARGIN, TEXT, WIDTH, name_width, text_width};
use super::look::Look;
use super::palette::{BAD, BAND, FAINT, FALSE, INK, LOST, PAGE, RULE, SPEED};
use super::svg::SubjectGroup;

/// Space between names and panels, and between two panels.
const GAP: i32 = 14;
/// Minimum width of a panel of share 1.
const NARROWEST: i32 = 54;
const HEADING: i32 = 26;
/// Space between the edges of a panel and the ends of its axis.
const INSET: i32 = 9;
const MARK: i32 = 5;
const TICKS: i32 = 24;
/// Width of a mark and the space after it in the legend.
const SAMPLE: i32 = 26;
/// Space after an entry of the legend.
const AFTER: i32 = 14;

/// A dot plot.
pub(super) struct DotPlot {
    pub(super) title: String,
    /// Lines below the title: what the figures are.
    pub(super) remarks: Vec<String>,
    pub(super) panels: Vec<Panel>,
    pub(super) groups: Vec<Group>,
    /// When a dot is red, in a few words.
    pub(super) failure: String,
}

/// A column of the plot.
pub(super) struct Panel {
    /// Title with the unit, in a few words. It is broken into lines of the panel's width.
    pub(super) title: String,
    pub(super) kind: Kind,
    pub(super) scale: Scale,
    /// The panel's share of the width, relative to the others: 1 or more.
    pub(super) share: i32,
    /// A value that is marked by a line across the rows.
    pub(super) reference: Option<f64>,
    /// The meaning of each shape, at most four. Empty if there is one dot in a row. Panels with the same meaning share
    /// an entry of the legend.
    pub(super) marks: Vec<String>,
}

/// What the figures of a panel are: it decides their colour.
#[derive(Clone, Copy)]
pub(super) enum Kind {
    Speed,
    Lost,
    False,
}

#[derive(Clone, Copy)]
pub(super) enum Scale {
    /// From zero.
    Linear,
    Logarithmic,
}

/// Rows under a small heading.
pub(super) struct Group {
    pub(super) heading: Option<String>,
    pub(super) rows: Vec<Row>,
}

/// A kernel.
pub(super) struct Row {
    /// Unique ID within the chart, for tooltips.
    pub(super) id: String,
    pub(super) name: String,
    pub(super) bold: bool,
    /// Whether the row has a background of its own: the recommended kernel.
    pub(super) recommended: bool,
    /// The dots in each panel. Where a panel has none, a dash says that nothing was measured.
    pub(super) cells: Vec<Vec<Dot>>,
}

/// A measured value.
pub(super) struct Dot {
    /// Index of its shape: see [`Panel::marks`].
    pub(super) mark: usize,
    /// Not negative. Zero is drawn hollow at the left end of its panel, before every other value.
    pub(super) value: f64,
    /// The interval of the value. For zero, the upper end is its 95 % bound.
    pub(super) interval: Option<[f64; 2]>,
    /// Whether the value is a failure.
    pub(super) failed: bool,
    /// The figure with its unit, for the tooltip.
    pub(super) tooltip: String,
}

impl Kind {
    fn color(self) -> RGBColor {
        match self {
            Self::Speed => SPEED,
            Self::Lost => LOST,
            Self::False => FALSE,
        }
    }
}

/// An axis of a panel, in pixels.
struct Axis {
    scale: AxisScale,
    start: i32,
    length: i32,
    ticks: Vec<f64>,
}

enum AxisScale {
    /// From zero to this value.
    Linear(f64),
    Logarithmic(LogAxis),
}

impl Axis {
    fn new(panel: &Panel, dots: &[&Dot], columns: Range<i32>) -> Self {
        let (start, length) = (columns.start + INSET, columns.end - columns.start - 2 * INSET);
        let upper = |dot: &Dot| dot.interval.map_or(dot.value, |[_, upper]| upper.max(dot.value));
        match panel.scale {
            Scale::Linear => {
                let most = dots.iter().map(|dot| upper(dot)).chain(panel.reference).fold(0.0, f64::max);
                let most = if most > 0.0 { 1.04 * most } else { 1.0 };
                let step = [1.0, 2.0, 2.5, 5.0, 10.0].map(|step| step * 10f64.powf((most / 5.0).log10().floor()));
                let step = step.into_iter().find(|step| most / step <= 5.0).unwrap_or(most);
                let ticks = (0..=(most / step) as u32).map(|number| f64::from(number) * step).collect();
                Self { scale: AxisScale::Linear(most), start, length, ticks }
            }
            Scale::Logarithmic => {
                // Lower ends of intervals may be very small, so they are cut off after a decade.
                let lower = |dot: &Dot| dot.interval.map_or(dot.value, |[lower, _]| lower.max(dot.value / 10.0));
                let values = dots.iter().flat_map(|dot| [lower(dot), dot.value, upper(dot)]);
                let values = values.filter(|value| value.is_finite());
                let axis = LogAxis::around(values, 0.0..=f64::INFINITY, 5);
                let ticks = axis.ticks.clone();
                Self { scale: AxisScale::Logarithmic(axis), start, length, ticks }
            }
        }
    }

    /// The position of a value, from 0 to 1.
    fn share(&self, value: f64) -> f64 {
        match &self.scale {
            AxisScale::Linear(most) => value / most,
            AxisScale::Logarithmic(axis) => axis.position(value),
        }
    }

    fn position(&self, value: f64) -> i32 {
        self.start + (self.share(value).clamp(0.0, 1.0) * f64::from(self.length)).round() as i32
    }

    /// The ends of a dot's interval. The interval of a measured value does not reach zero's place.
    fn interval(&self, dot: &Dot) -> Option<[i32; 2]> {
        let [lower, upper] = dot.interval?;
        let least = match &self.scale {
            AxisScale::Logarithmic(axis) if dot.value > 0.0 => axis.gap().unwrap_or(0.0),
            _ => 0.0,
        };
        let ends = [lower.min(dot.value), upper.max(dot.value)].map(|value| self.share(value).clamp(least, 1.0));
        Some(ends.map(|share| self.start + (share * f64::from(self.length)).round() as i32))
    }

    /// The ticks that get a label, so that no two labels overlap.
    fn labelled(&self) -> Vec<f64> {
        let mut labelled: Vec<f64> = Vec::new();
        for &tick in &self.ticks {
            let half = |tick: f64| text_width(&tick_label(tick)) / 2;
            let is_free =
                |&other: &f64| (self.position(tick) - self.position(other)).abs() > half(tick) + half(other) + 6;
            if labelled.iter().all(is_free) {
                labelled.push(tick);
            }
        }
        labelled
    }
}

/// The label of a tick, short enough for narrow panels.
fn tick_label(value: f64) -> String {
    match value {
        1e9.. => format!("{}G", value / 1e9),
        1e6.. => format!("{}M", value / 1e6),
        1e3.. => format!("{}k", value / 1e3),
        0.0 | 1e-3.. => format!("{}", (value * 1e3).round() / 1e3),
        _ => format!("{value:e}"),
    }
}

impl DotPlot {
    /// Draws the plot.
    pub(super) fn svg(&self) -> String {
        let (left, shares, gaps) = (self.left(), self.shares(), self.gaps());
        let width = self.width();
        let space = width - left - gaps - MARGIN;
        let mut next = left;
        let columns: Vec<Range<i32>> = self
            .panels
            .iter()
            .map(|panel| {
                let start = next;
                next = start + space * panel.share / shares + GAP;
                start..next - GAP
            })
            .collect();
        let titles: Vec<Vec<String>> = self
            .panels
            .iter()
            .zip(&columns)
            .map(|(panel, columns)| wrapped(&panel.title, columns.end - columns.start, TEXT))
            .collect();
        let title_lines = titles.iter().map(Vec::len).max().unwrap_or(0) as i32;
        let legend = self.legend_lines(width);
        let above = header_height(width, &self.title, &self.remarks) + LINE * legend.len() as i32;
        let top = above + LINE * title_lines + 12;
        let height = self.groups.iter().map(Group::height).sum::<i32>();
        canvas((width, top + height + TICKS + MARGIN), |root| {
            let y = header(root, width, &self.title, &self.remarks)?;
            draw_legend(root, &legend, y)?;
            self.rows_of(root, width, top)?;
            for (number, ((panel, columns), title)) in self.panels.iter().zip(columns).zip(&titles).enumerate() {
                for (line, text) in (0..).zip(title) {
                    // Titles stand on the panels.
                    let y = above + 6 + LINE * (title_lines - title.len() as i32 + line) + LINE / 2;
                    root.draw_text(text, &label(TEXT, INK), (columns.start, y))?;
                }
                self.panel(root, number, panel, columns, top..top + height)?;
            }
            Ok(())
        })
    }

    /// The width of the plot.
    fn width(&self) -> i32 {
        WIDTH.max(self.left() + NARROWEST * self.shares() + self.gaps() + MARGIN)
    }

    /// The start of the first panel, behind the names.
    fn left(&self) -> i32 {
        MARGIN + self.rows().map(|row| name_width(&row.name)).max().unwrap_or(0) + GAP
    }

    /// The sum of all shares.
    fn shares(&self) -> i32 {
        self.panels.iter().map(|panel| panel.share).sum::<i32>().max(1)
    }

    /// The sum of the spaces between panels.
    fn gaps(&self) -> i32 {
        GAP * (self.panels.len() as i32 - 1).max(0)
    }

    fn rows(&self) -> impl Iterator<Item = &Row> {
        self.groups.iter().flat_map(|group| &group.rows)
    }

    /// The rows and the middle of each, in pixels below the first.
    fn places(&self) -> impl Iterator<Item = (&Row, i32)> {
        let tops = self.groups.iter().scan(0, |next, group| {
            let top = *next;
            *next += group.height();
            Some((group, top + if group.heading.is_some() { HEADING } else { 0 }))
        });
        tops.flat_map(|(group, top)| (0..).zip(&group.rows).map(move |(i, row)| (row, top + LINE * i + LINE / 2)))
    }

    /// Draws headings, names, and the background of the recommended rows.
    fn rows_of(&self, root: &Area, width: i32, top: i32) -> Drawn {
        let mut y = top;
        for group in &self.groups {
            if let Some(text) = &group.heading {
                root.draw_text(text, &heading(TEXT), (MARGIN, y + HEADING / 2 + 2))?;
            }
            y += group.height();
        }
        for (row, y) in self.places().map(|(row, y)| (row, top + y)) {
            if row.recommended {
                let corners = [(4, y - LINE / 2), (width - 4, y + LINE / 2)];
                root.draw(&Rectangle::new(corners, BAND.filled()))?;
            }
            root.draw(&SubjectGroup(&[&row.id]))?;
            root.draw_text(&row.name, &name(row.bold, INK), (MARGIN, y))?;
        }
        root.draw(&SubjectGroup(&[]))
    }

    fn panel(&self, root: &Area, number: usize, panel: &Panel, columns: Range<i32>, rows: Range<i32>) -> Drawn {
        let dots: Vec<&Dot> = self.rows().flat_map(|row| &row.cells[number]).collect();
        let axis = Axis::new(panel, &dots, columns.clone());
        for &tick in &axis.ticks {
            let x = axis.position(tick);
            root.draw(&PathElement::new([(x, rows.start), (x, rows.end)], RULE))?;
        }
        for tick in axis.labelled() {
            let at = (axis.position(tick), rows.end + TICKS / 2 + 2);
            root.draw_text(&tick_label(tick), &centered(label(TEXT, FAINT)), at)?;
        }
        root.draw(&PathElement::new([(columns.start, rows.end), (columns.end, rows.end)], FAINT))?;
        if let AxisScale::Logarithmic(log) = &axis.scale
            && let Some(gap) = log.gap()
        {
            // Zero is not on a logarithmic axis, so a break is drawn after it.
            let x = axis.start + (gap * f64::from(axis.length)).round() as i32;
            let y = rows.end;
            root.draw(&Rectangle::new([(x - 3, y - 2), (x + 3, y + 2)], PAGE.filled()))?;
            for x in [x - 3, x + 3] {
                root.draw(&PathElement::new([(x - 3, y + 5), (x + 3, y - 5)], FAINT))?;
            }
        }
        if let Some(reference) = panel.reference.filter(|&value| (0.0..=1.0).contains(&axis.share(value))) {
            let x = axis.position(reference);
            root.draw(&PathElement::new([(x, rows.start), (x, rows.end)], FAINT.stroke_width(2)))?;
        }
        for (row, y) in self.places().map(|(row, y)| (row, rows.start + y)) {
            root.draw(&SubjectGroup(&[&row.id]))?;
            let dots = &row.cells[number];
            if dots.is_empty() {
                root.draw_text("–", &centered(label(TEXT, FAINT)), ((columns.start + columns.end) / 2, y))?;
            }
            for dot in dots {
                dot.draw(root, panel.kind, &axis, y)?;
            }
            let figures = dots.iter().map(|dot| format!("{}, {}", row.id, dot.tooltip)).collect::<Vec<_>>();
            if !figures.is_empty() {
                let (corner, size) = ((columns.start, y - LINE / 2), (columns.end - columns.start, LINE));
                let shape = Shape::Rectangle { corner, size };
                root.draw(&Hover { shape, subjects: vec![&row.id], title: figures.join("\n"), data: Vec::new() })?;
            }
        }
        root.draw(&SubjectGroup(&[]))
    }

    /// The entries of the legend, in lines.
    fn legend_lines(&self, width: i32) -> Vec<Vec<Entry<'_>>> {
        let mut entries: Vec<Entry> = Vec::new();
        for panel in &self.panels {
            for (mark, text) in (0..).zip(&panel.marks) {
                let look = Look::new(panel.kind.color(), mark);
                match entries.iter_mut().find(|entry| entry.text == text) {
                    Some(entry) => entry.samples.push(look),
                    None => entries.push(Entry { samples: vec![look], hollow: false, text }),
                }
            }
        }
        let dots = || {
            self.rows()
                .flat_map(|row| row.cells.iter().zip(&self.panels))
                .flat_map(|(dots, panel)| dots.iter().map(move |dot| (dot, panel)))
        };
        if let Some((_, panel)) = dots().find(|(dot, _)| dot.value == 0.0) {
            let samples = vec![Look::new(panel.kind.color(), 0)];
            entries.push(Entry { samples, hollow: true, text: "none (line: 95 % bound)" });
        }
        if dots().any(|(dot, _)| dot.failed) {
            entries.push(Entry { samples: vec![Look::new(BAD, 0)], hollow: false, text: &self.failure });
        }
        let mut lines: Vec<Vec<Entry>> = Vec::new();
        let mut end = width;
        for entry in entries {
            let of_entry = entry.width();
            if end + of_entry - AFTER > width - MARGIN {
                lines.push(Vec::new());
                end = MARGIN;
            }
            end += of_entry;
            lines.last_mut().expect("the first entry starts a line").push(entry);
        }
        lines
    }
}

impl Group {
    fn height(&self) -> i32 {
        LINE * self.rows.len() as i32 + if self.heading.is_some() { HEADING } else { 0 }
    }
}

impl Dot {
    fn draw(&self, root: &Area, kind: Kind, axis: &Axis, y: i32) -> Drawn {
        let color = if self.failed { BAD } else { kind.color() };
        let x = axis.position(self.value);
        if let Some([low, high]) = axis.interval(self) {
            root.draw(&PathElement::new([(low, y), (high, y)], color.stroke_width(2)))?;
            if self.value == 0.0 {
                root.draw(&PathElement::new([(high, y - 4), (high, y + 4)], color.stroke_width(2)))?;
            }
        }
        Look::new(color, self.mark).mark(root, (x, y), MARK, self.value == 0.0)
    }
}

/// An entry of the legend. The samples are hollow for a count of zero.
struct Entry<'a> {
    samples: Vec<Look>,
    hollow: bool,
    text: &'a str,
}

impl Entry<'_> {
    fn width(&self) -> i32 {
        SAMPLE * self.samples.len() as i32 + text_width(self.text) + AFTER
    }
}

fn draw_legend(root: &Area, lines: &[Vec<Entry>], top: i32) -> Drawn {
    for (line, entries) in (0..).zip(lines) {
        let y = top + LINE * line + LINE / 2;
        let mut x = MARGIN;
        for entry in entries {
            let mut start = x;
            for look in &entry.samples {
                let color = look.color.stroke_width(2);
                root.draw(&PathElement::new([(start, y), (start + SAMPLE - 6, y)], color))?;
                let middle = start + if entry.hollow { MARK + 2 } else { SAMPLE / 2 - 3 };
                look.mark(root, (middle, y), MARK, entry.hollow)?;
                start += SAMPLE;
            }
            root.draw_text(entry.text, &label(TEXT, INK), (start, y))?;
            x += entry.width();
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot(values: &[f64], scale: Scale) -> DotPlot {
        let dot = |value: f64| Dot {
            mark: 0,
            value,
            interval: Some(if value == 0.0 { [0.0, 15.0] } else { [value / 40.0, value * 5.6] }),
            failed: value > 1000.0,
            tooltip: value.to_string(),
        };
        let row = |(i, &value): (usize, &f64)| Row {
            id: format!("id/{i}"),
            name: format!("kernel_{i}"),
            bold: i == 0,
            recommended: i == 1,
            cells: vec![vec![dot(value)]],
        };
        DotPlot {
            title: "Title".into(),
            remarks: Vec::new(),
            panels: vec![Panel {
                title: "per million".into(),
                kind: Kind::Lost,
                scale,
                share: 1,
                reference: None,
                marks: Vec::new(),
            }],
            groups: vec![Group { heading: Some("group".into()), rows: values.iter().enumerate().map(row).collect() }],
            failure: "red".into(),
        }
    }

    #[test]
    fn a_zero_lies_left_of_every_measured_value_and_of_its_interval() {
        // One event in 200,000, and zero events in 200,000.
        let plot = plot(&[0.0, 5.0, 0.4, 2000.0], Scale::Logarithmic);
        let dots: Vec<&Dot> = plot.rows().flat_map(|row| &row.cells[0]).collect();
        let axis = Axis::new(&plot.panels[0], &dots, 0..100);
        let zero = axis.position(0.0);
        for dot in &dots[1..] {
            assert!(zero + MARK < axis.position(dot.value), "{}", dot.value);
            let [low, high] = axis.interval(dot).unwrap();
            assert!(zero < low && low <= axis.position(dot.value) && axis.position(dot.value) < high, "{}", dot.value);
        }
        assert_eq!(axis.interval(dots[0]), Some([zero, axis.position(15.0)]));
        assert!(axis.position(15.0) > axis.position(5.0), "the bound of zero lies above one event");
    }

    #[test]
    fn zeros_are_hollow_failures_red_and_every_row_is_named() {
        let svg = plot(&[0.0, 5.0, 2000.0], Scale::Logarithmic).svg();
        assert_eq!(svg.matches(&format!("r=\"{MARK}\" stroke=")).count(), 2, "the zero, and the legend: {svg}");
        assert_eq!(svg.matches(&format!("r=\"{MARK}\" fill=\"#C8321A\"")).count(), 2, "the failure, and the legend");
        for i in 0..3 {
            assert!(svg.contains(&format!(">kernel_{i}</text>")) && svg.contains(&format!("<title>id/{i}, ")), "{i}");
        }
        assert_eq!(svg.matches("font-weight=\"bold\"").count(), 3, "title, heading and one row");
        assert_eq!(svg.matches(" class=\"f-band\"").count(), 1);
    }

    #[test]
    fn axes_have_labels_that_do_not_overlap() {
        for scale in [Scale::Linear, Scale::Logarithmic] {
            for values in [&[0.0][..], &[3.0], &[0.0, 0.01, 1e6], &[61.0, 670.0], &[5.0, 6.0]] {
                let plot = plot(values, scale);
                let dots: Vec<&Dot> = plot.rows().flat_map(|row| &row.cells[0]).collect();
                let axis = Axis::new(&plot.panels[0], &dots, 0..NARROWEST);
                let labelled = axis.labelled();
                assert!(!labelled.is_empty() && labelled.len() <= 6, "{values:?}: {labelled:?}");
                for pair in labelled.windows(2) {
                    assert!(axis.position(pair[1]) - axis.position(pair[0]) > text_width(&tick_label(pair[1])) / 2);
                }
            }
        }
    }
}
