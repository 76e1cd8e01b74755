//! `packets.svg`: the gain of packets of eight over scalar code, and how close packets come to the machine's limit.

use plotters::prelude::*;

use super::canvas::{Area, Drawn, canvas, centered, header, header_height, heading, label, machine, name};
use super::hover::{Hover, Shape};
use super::layout::{ADVANCE, FAINT, GRID, INK, LINE, MARGIN, TEXT, WIDTH};
use super::look::Look;
use crate::study::figures::{Group, KernelFigures, number, optional, percent, times};
use crate::study::record::Record;

const TITLE: &str = "Packets of eight: gain over scalar code, and share of the limit";
const GROUP_TITLE: i32 = 26;
const AXIS: i32 = 36;
const GAP: i32 = 40;
/// Half the height of a bar.
const BAR: i32 = 5;
/// Space beyond a bar, for its figure.
const FIGURE: i32 = 44;

/// A column of bars: its title, the distance of its ticks, the marked value, and the value of each bar.
struct Column {
    title: &'static str,
    step: f64,
    mark: f64,
    tick: fn(f64) -> String,
    value: fn(&KernelFigures) -> Option<f64>,
    text: fn(Option<f64>) -> String,
}

const COLUMNS: [Column; 2] = [
    Column {
        title: "gain: time of 1x1 over time of 8x1 (line: the ideal, 8×)",
        step: 2.0,
        mark: 8.0,
        tick: |gain| format!("{gain:.0}"),
        value: |kernel| kernel.gain(),
        text: times,
    },
    Column {
        title: "limit as a share of the time, % (line: 100 %)",
        step: 0.25,
        mark: 1.0,
        tick: |share| format!("{:.0}", 100.0 * share),
        value: |kernel| kernel.limit_share(),
        text: percent,
    },
];

/// Draws the kernels of these groups.
pub(super) fn svg(record: &Record, groups: &[&Group]) -> String {
    let names =
        groups.iter().flat_map(|group| &group.kernels).map(|kernel| kernel.name.chars().count()).max().unwrap_or(0);
    let left = MARGIN + (names as f64 * ADVANCE).ceil() as i32 + 12;
    let plot = (WIDTH - left - MARGIN - GAP) / 2;
    let remarks = [
        "Limit: the machine's least time for the busiest class of operations (their number times their measured rate)."
            .to_owned(),
        machine(record) + ", one thread",
    ];
    let top = header_height(WIDTH, TITLE, &remarks) + LINE;
    let rows: i32 = groups.iter().map(|group| GROUP_TITLE + LINE * group.kernels.len() as i32).sum();
    let kernels = || groups.iter().flat_map(|group| &group.kernels);
    let columns = COLUMNS.iter().zip([left, left + plot + GAP]);
    let columns = columns.map(|(column, left)| Bars { column, left, plot, end: column.end(kernels()) });
    let columns: Vec<_> = columns.collect();
    canvas((WIDTH, top + rows + AXIS + MARGIN), |root| {
        header(root, WIDTH, TITLE, &remarks)?;
        for column in &columns {
            column.axis(root, top..top + rows)?;
        }
        let mut y = top;
        for group in groups {
            root.draw_text(&group.title, &heading(13.0), (MARGIN, y + GROUP_TITLE / 2))?;
            y += GROUP_TITLE;
            for (index, kernel) in group.kernels.iter().enumerate() {
                let middle = y + LINE / 2;
                root.draw_text(&kernel.name, &name(false), (MARGIN, middle))?;
                for column in &columns {
                    column.bar(root, middle, kernel, Look::of(index).color)?;
                }
                y += LINE;
            }
        }
        Ok(())
    })
}

impl Column {
    /// The end of the axis: a little beyond the longest bar and the marked value.
    fn end<'a>(&self, kernels: impl Iterator<Item = &'a KernelFigures<'a>>) -> f64 {
        1.06 * kernels.filter_map(self.value).filter(|value| value.is_finite()).fold(self.mark, f64::max)
    }
}

/// A column and its position.
struct Bars<'a> {
    column: &'a Column,
    left: i32,
    plot: i32,
    end: f64,
}

impl Bars<'_> {
    /// The horizontal position of a value.
    fn position(&self, value: f64) -> i32 {
        self.left + (value / self.end * f64::from(self.plot - FIGURE)).round() as i32
    }

    fn axis(&self, root: &Area, rows: std::ops::Range<i32>) -> Drawn {
        let Column { title, step, mark, tick, .. } = *self.column;
        for value in (0..=(self.end / step) as u32).map(|number| f64::from(number) * step) {
            let x = self.position(value);
            let style = if value == mark { INK.stroke_width(2) } else { GRID.stroke_width(1) };
            root.draw(&PathElement::new([(x, rows.start), (x, rows.end)], style))?;
            root.draw_text(&tick(value), &centered(label(TEXT, INK)), (x, rows.end + 10))?;
        }
        let middle = self.position(self.end / 2.0);
        root.draw_text(title, &centered(label(TEXT, INK)), (middle, rows.end + 28))
    }

    fn bar(&self, root: &Area, y: i32, kernel: &KernelFigures, color: RGBColor) -> Drawn {
        let value = (self.column.value)(kernel).filter(|value| value.is_finite());
        let end = self.position(value.unwrap_or(0.0).max(0.0));
        root.draw(&Rectangle::new([(self.left, y - BAR), (end, y + BAR)], color.filled()))?;
        root.draw(&Hover {
            shape: Shape::Rectangle { corner: (self.left, y - LINE / 2), size: (self.plot, LINE) },
            subjects: vec![&kernel.method.id],
            title: title(kernel),
            data: Vec::new(),
        })?;
        // The figure must not lie on the line.
        let line = self.position(self.column.mark);
        let figure = if (line - FIGURE..line).contains(&end) { line } else { end };
        root.draw_text(&(self.column.text)(value), &label(TEXT - 1.0, FAINT), (figure + 4, y))
    }
}

/// The tooltip of a kernel's bars.
fn title(kernel: &KernelFigures) -> String {
    let ns = |width| format!("{width}: {} ns per test", optional(kernel.ns(width), 3));
    let limit = kernel.packet().and_then(|row| Some((row.limit_by.clone()?, number(row.limit_ns?, 3))));
    format!(
        "{}, {}, {}, gain {}, limit {} of the time{}",
        kernel.method.id,
        ns("1x1"),
        ns("8x1"),
        times(kernel.gain()),
        percent(kernel.limit_share()),
        limit.map_or(String::new(), |(class, ns)| format!(" ({ns} ns, busiest class: {class})"))
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::figures::groups;
    use crate::study::tests::fixture::{all_ids, record_of};

    #[test]
    fn the_axis_covers_the_mark_and_the_longest_bar() {
        let mut record = record_of(&["triangle/cramer".into(), "triangle/woop".into()]);
        let mut end = |ns: f64| {
            let scalar = record.speed.iter_mut().find(|row| row.width == "1x1" && row.threads == 1).unwrap();
            scalar.ns_per_test = ns;
            let groups = groups(&record);
            let kernels = || groups.iter().flat_map(|group| &group.kernels);
            (COLUMNS[0].end(kernels()), kernels().filter_map(KernelFigures::gain).fold(0.0, f64::max))
        };
        let (end_of_short, short) = end(1e-3);
        assert!(short < 8.0 && end_of_short == 1.06 * 8.0, "{short}");
        let (end_of_long, long) = end(1e3);
        assert!(long > 8.0 && end_of_long == 1.06 * long, "{long}");
    }

    #[test]
    fn every_kernel_shows_its_gain_and_its_share_of_the_limit() {
        let record = record_of(&all_ids());
        let groups = groups(&record);
        let svg = svg(&record, &groups.iter().filter(|group| group.is_base()).collect::<Vec<_>>());
        for kernel in groups.iter().filter(|group| group.is_base()).flat_map(|group| &group.kernels) {
            for figure in [kernel.name.clone(), times(kernel.gain()), percent(kernel.limit_share()), title(kernel)] {
                assert!(svg.contains(&figure), "{}: {figure}", kernel.name);
            }
        }
    }
}
