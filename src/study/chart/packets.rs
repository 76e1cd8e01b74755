//! `packets.svg`: what packets of eight gain over scalar code, with the ideal marked, and how close they come to the machine's
//! limit.

use plotters::prelude::*;

use super::hover::{Hover, Shape};
use super::look::Look;
use super::{
    ADVANCE, Area, Drawn, FAINT, GRID, INK, LINE, MARGIN, TEXT, WIDTH, canvas, centered, header, header_height,
};
use super::{heading, label, machine, name};
use crate::study::figures::{Figures, Group, number, optional, percent, times};
use crate::study::record::Record;

const TITLE: &str = "Packets of eight: gain over scalar code, and share of the machine's limit";
const GROUP_TITLE: i32 = 26;
const AXIS: i32 = 36;
const GAP: i32 = 40;
/// Half the height of a bar.
const BAR: i32 = 5;
/// Beyond a bar, for its figure.
const FIGURE: i32 = 44;

/// A column of bars: what they show, the greatest value that has a place, and the value that is marked.
struct Column {
    title: &'static str,
    end: f64,
    ticks: &'static [f64],
    mark: f64,
    tick: fn(f64) -> String,
    value: fn(&Figures) -> Option<f64>,
    text: fn(Option<f64>) -> String,
}

const COLUMNS: [Column; 2] = [
    Column {
        title: "gain: time of 1x1 over 8x1 (line: the ideal, 8×)",
        end: 8.5,
        ticks: &[0.0, 2.0, 4.0, 6.0, 8.0],
        mark: 8.0,
        tick: |gain| format!("{gain:.0}"),
        value: |kernel| kernel.gain(),
        text: times,
    },
    Column {
        title: "share of the limit, % (line: all of it)",
        end: 1.06,
        ticks: &[0.0, 0.25, 0.5, 0.75, 1.0],
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
    let remarks = ["The limit: what the busiest class of operations takes at least, by their count and their rates in the same run."
        .to_owned(), machine(record) + ", one thread"];
    let top = header_height(WIDTH, TITLE, &remarks) + LINE;
    let rows: i32 = groups.iter().map(|group| GROUP_TITLE + LINE * group.kernels.len() as i32).sum();
    canvas((WIDTH, top + rows + AXIS + MARGIN), |root| {
        header(root, WIDTH, TITLE, &remarks)?;
        for (column, at) in COLUMNS.iter().zip([left, left + plot + GAP]) {
            column.axis(root, at, plot, top..top + rows)?;
        }
        let mut y = top;
        for group in groups {
            root.draw_text(&group.title, &heading(13.0), (MARGIN, y + GROUP_TITLE / 2))?;
            y += GROUP_TITLE;
            for (index, kernel) in group.kernels.iter().enumerate() {
                let middle = y + LINE / 2;
                root.draw_text(&kernel.name, &name(false), (MARGIN, middle))?;
                for (column, at) in COLUMNS.iter().zip([left, left + plot + GAP]) {
                    column.bar(root, at, plot, middle, kernel, Look::of(index).color)?;
                }
                y += LINE;
            }
        }
        Ok(())
    })
}

impl Column {
    /// Where a value is, in pixels from the beginning.
    fn place(&self, value: f64, plot: i32) -> i32 {
        (value / self.end * f64::from(plot - FIGURE)).round() as i32
    }

    fn axis(&self, root: &Area, left: i32, plot: i32, rows: std::ops::Range<i32>) -> Drawn {
        for &tick in self.ticks {
            let x = left + self.place(tick, plot);
            let marked = tick == self.mark;
            let style = if marked { INK.stroke_width(2) } else { GRID.stroke_width(1) };
            root.draw(&PathElement::new([(x, rows.start), (x, rows.end)], style))?;
            root.draw_text(&(self.tick)(tick), &centered(label(TEXT, INK)), (x, rows.end + 10))?;
        }
        let middle = left + self.place(self.mark, plot) / 2;
        root.draw_text(self.title, &centered(label(TEXT, INK)), (middle, rows.end + 28))
    }

    fn bar(&self, root: &Area, left: i32, plot: i32, y: i32, kernel: &Figures, color: RGBColor) -> Drawn {
        let value = (self.value)(kernel).filter(|value| value.is_finite());
        // Beyond the end there is only the figure.
        let end = left + self.place(value.unwrap_or(0.0).clamp(0.0, self.end), plot);
        root.draw(&Rectangle::new([(left, y - BAR), (end, y + BAR)], color.filled()))?;
        root.draw(&Hover {
            shape: Shape::Rectangle { corner: (left, y - LINE / 2), size: (plot, LINE) },
            of: vec![&kernel.kernel.id],
            title: title(kernel),
            data: Vec::new(),
        })?;
        // No figure lies on the line.
        let line = left + self.place(self.mark, plot);
        let figure = if (line - FIGURE..line).contains(&end) { line } else { end };
        root.draw_text(&(self.text)(value), &label(TEXT - 1.0, FAINT), (figure + 4, y))
    }
}

/// What a kernel's bars are about, in words.
fn title(kernel: &Figures) -> String {
    let ns = |face| format!("{face}: {} ns per test", optional(kernel.ns(face), 3));
    let limit = kernel.packet().and_then(|row| Some((row.limit_by.clone()?, number(row.limit_ns?, 3))));
    format!(
        "{}, {}, {}, gain {}, {} of the limit{}",
        kernel.kernel.id,
        ns("1x1"),
        ns("8x1"),
        times(kernel.gain()),
        percent(kernel.limit_share()),
        limit.map_or(String::new(), |(class, ns)| format!(": {ns} ns, by class {class}"))
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::figures::groups;
    use crate::study::fixture::{all_ids, record_of};

    #[test]
    fn every_kernel_has_its_gain_and_its_share() {
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
