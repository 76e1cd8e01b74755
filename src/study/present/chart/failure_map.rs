//! `failure-map-<family>.svg`: for each kernel, the error of `t` over two severities, as an image of coloured cells.
//! The images of a map are side by side and use the same colours.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::axis::LogAxis;
use super::canvas::{Area, Drawn, canvas, centered, header, header_height, heading, label, machine, name};
use super::hover::{Hover, Shape};
use super::layout::{LINE, MARGIN, Pixel, TEXT, name_width};
use super::palette::{BAD, FAINT, INK, PAGE, STEPS, UNKNOWN};
use crate::study::figures::{Group, count, severity};
use crate::study::record::{MapCells, MapRow, Record};

/// The largest error in ulp of each class of cells. The last of [`STEPS`] is the colour of larger errors.
const CLASSES: [u64; 6] = [1, 10, 100, 1_000, 10_000, 100_000];
/// Number of rays that a 99th percentile needs at least.
const LEAST: u64 = 100;

/// Minimum width of the chart.
const WIDTH: i32 = 620;
/// Minimum width of an image (approximately), and maximum width and height.
const MIN_IMAGE: i32 = 130;
const MAX_IMAGE: i32 = 200;
const LEFT: i32 = 54;
const GAP: i32 = 14;
/// Space between a name and the image below it: room for an underscore.
const BELOW_NAME: i32 = 5;
/// Width of the names that three images side by side have room for. A wider name is broken into two lines.
const NAME_WIDTH: i32 = (WIDTH - LEFT - MARGIN + GAP) / 3 - GAP;
const TICKS: i32 = 26;
const MAP_TITLE: i32 = 32;
const LEGEND_HEIGHT: i32 = 52;

/// Number of classes: [`CLASSES`], then larger errors, misses, and too few hits.
const KINDS: usize = CLASSES.len() + 3;

/// The class of a cell, from the number of rays that hit there and their error.
fn class(hits: u64, t_ulp_p99: Option<u64>) -> usize {
    match t_ulp_p99 {
        _ if hits < LEAST => CLASSES.len() + 2,
        None => CLASSES.len() + 1,
        Some(ulp) => CLASSES.iter().position(|&most| ulp <= most).unwrap_or(CLASSES.len()),
    }
}

/// The colour of a class. Cells where more than 1 % of the rays miss are a failure, and striped too.
fn color(class: usize) -> RGBColor {
    STEPS.get(class).copied().unwrap_or_else(|| [BAD, UNKNOWN][class - STEPS.len()])
}

/// The meaning of a class in words.
fn meaning(class: usize) -> String {
    match CLASSES.get(class) {
        Some(&most) if class == 0 => format!("0 to {most} ulp"),
        Some(&most) => format!("up to {}", count(most)),
        None => ["more", "> 1 % missed", "few hits"][class - CLASSES.len()].into(),
    }
}

/// Draws the maps of a group.
pub(super) fn svg(record: &Record, group: &Group, maps: &[&MapRow]) -> String {
    let names: Vec<Vec<&str>> = group.kernels.iter().map(|kernel| lines_of(&kernel.name)).collect();
    let layouts: Vec<Layout> = maps.iter().map(|map| Layout::new(map, &names)).collect();
    let width = layouts.iter().map(Layout::width).max().unwrap_or(0).max(WIDTH);
    let title = format!("{}: failure map", group.title);
    let subject = (group.subject != group.title).then(|| format!("All are {}.", group.subject));
    let about = "Error of t over two severities: 99th percentile, in units in the last place (ulp). All rays exactly \
                 hit, strictly inside.";
    let remarks: Vec<_> = [about.to_owned()].into_iter().chain(subject).chain([machine(record)]).collect();
    let height = header_height(width, &title, &remarks) + LEGEND_HEIGHT;
    let height = height + layouts.iter().map(Layout::height).sum::<i32>() + MARGIN;
    canvas((width, height), |root| {
        let mut top = header(root, width, &title, &remarks)?;
        legend(root, top)?;
        top += LEGEND_HEIGHT;
        for (map, layout) in maps.iter().zip(&layouts) {
            draw_map(root, record, (group, &names), map, layout, top)?;
            top += layout.height();
        }
        Ok(())
    })
}

/// Draws the scale with the limits of its classes, and the two classes beside it.
fn legend(root: &Area, top: i32) -> Drawn {
    const BOX: i32 = 50;
    const HEIGHT: i32 = 18;
    for class in 0..STEPS.len() {
        let x = MARGIN + class as i32 * BOX;
        fill(root, [(x, top), (x + BOX, top + HEIGHT)], class)?;
        if let Some(&most) = CLASSES.get(class) {
            let at = (x + BOX, top + HEIGHT + LINE / 2);
            root.draw_text(&power(most as f64), &centered(label(TEXT, INK)), at)?;
        }
    }
    let x = MARGIN + STEPS.len() as i32 * BOX;
    root.draw_text("ulp", &label(TEXT, INK), (x - BOX / 2, top + HEIGHT + LINE / 2))?;
    for (row, class) in (0..).zip(STEPS.len()..KINDS) {
        let (x, y) = (x + 30, top + LINE * row);
        let corners = [(x, y), (x + BOX, y + HEIGHT)];
        fill(root, corners, class)?;
        stripe(root, corners, class)?;
        root.draw_text(&meaning(class), &label(TEXT, INK), (x + BOX + 8, y + HEIGHT / 2))?;
    }
    Ok(())
}

/// The lines of a kernel's name. A wide one is broken after the last underscore or slash that fits into the first line.
pub(super) fn lines_of(name: &str) -> Vec<&str> {
    let mut ends = name.match_indices(['_', '/']).map(|(at, separator)| at + separator.len());
    let fits = |&end: &usize| end < name.len() && name_width(&name[..end]) <= NAME_WIDTH;
    match ends.rfind(fits).filter(|_| name_width(name) > NAME_WIDTH) {
        Some(end) => <[&str; 2]>::from(name.split_at(end)).into(),
        None => vec![name],
    }
}

/// The layout of the images of a map.
struct Layout {
    /// Number of cells, horizontally and vertically.
    cells: Pixel,
    /// Side of a cell in pixels.
    cell: i32,
    columns: i32,
    rows: i32,
    /// Distance from one image to the next.
    pitch: i32,
    /// Height of the names above the images of a row.
    names: i32,
}

impl Layout {
    /// The layout of one image below each of these names, which are in lines.
    fn new(map: &MapRow, names: &[Vec<&str>]) -> Self {
        let cells = (map.x.len().max(1) as i32, map.y.len().max(1) as i32);
        let images = names.len() as i32;
        let widest = names.iter().flatten().map(|line| name_width(line)).max().unwrap_or(0);
        let lines = names.iter().map(Vec::len).max().unwrap_or(0) as i32;
        let pitch = widest.max(MIN_IMAGE) + GAP;
        let space = WIDTH - LEFT - MARGIN + GAP;
        let most = (space / pitch).max(1);
        // All rows have about the same number of images, and the images are as large as possible.
        let rows = ((images + most - 1) / most).max(1);
        let columns = ((images + rows - 1) / rows).max(1);
        let pitch = pitch.max((space / columns).min(MAX_IMAGE + GAP));
        let cell = ((pitch - GAP) / cells.0).min(MAX_IMAGE / cells.1).max(3);
        let pitch = pitch.max(cells.0 * cell + GAP);
        Self { cells, cell, columns, rows, pitch, names: LINE * lines + BELOW_NAME }
    }

    fn size(&self) -> Pixel {
        (self.cells.0 * self.cell, self.cells.1 * self.cell)
    }

    fn width(&self) -> i32 {
        LEFT + self.columns * self.pitch + MARGIN
    }

    fn row_height(&self) -> i32 {
        self.names + self.size().1 + TICKS
    }

    fn height(&self) -> i32 {
        MAP_TITLE + 2 * LINE + self.rows * self.row_height()
    }
}

fn draw_map(
    root: &Area,
    record: &Record,
    (group, names): (&Group, &[Vec<&str>]),
    map: &MapRow,
    layout: &Layout,
    top: i32,
) -> Drawn {
    root.draw_text(&map.name, &heading(TEXT), (MARGIN, top + MAP_TITLE / 2))?;
    let rays = count(map.hits.iter().copied().max().unwrap_or(0));
    let axes = [format!("→ {}", map.x_axis), format!("↑ {}; {rays} rays per cell", map.y_axis)];
    for (line, text) in (0..).zip(axes) {
        root.draw_text(&text, &label(TEXT, INK), (MARGIN, top + MAP_TITLE + LINE * line + LINE / 2))?;
    }
    let top = top + MAP_TITLE + 2 * LINE;
    for ((i, kernel), lines) in (0..).zip(&group.kernels).zip(names) {
        let (column, row) = (i % layout.columns, i / layout.columns);
        let corner = (LEFT + column * layout.pitch, top + row * layout.row_height() + layout.names);
        for (above, line) in (0..).zip(lines.iter().rev()) {
            root.draw_text(line, &name(false, INK), (corner.0, corner.1 - BELOW_NAME - LINE / 2 - LINE * above))?;
        }
        axes_of(root, map, layout, corner, column == 0)?;
        let cells = record.map_cells.iter().find(|cells| cells.id == kernel.method.id && cells.map == map.name);
        let Some(cells) = cells.filter(|cells| fits(cells, map)) else {
            let (width, height) = layout.size();
            let center = (corner.0 + width / 2, corner.1 + height / 2);
            root.draw_text("not measured", &centered(label(TEXT, FAINT)), center)?;
            continue;
        };
        image(root, layout, corner, map, cells)?;
        root.draw(&hover(layout, corner, map, cells))?;
    }
    Ok(())
}

/// Whether the kernel has one figure for each cell of the map.
fn fits(cells: &MapCells, map: &MapRow) -> bool {
    let cells = cells.t_ulp_p99.len();
    cells > 0 && cells == map.x.len() * map.y.len() && cells == map.hits.len()
}

/// Draws the ticks at powers of ten. Only the first image of a row has labels on its vertical axis.
fn axes_of(root: &Area, map: &MapRow, layout: &Layout, (left, top): Pixel, y_labels: bool) -> Drawn {
    let (width, height) = layout.size();
    let (right, bottom) = (left + width, top + height);
    root.draw(&Rectangle::new([(left - 1, top - 1), (right + 1, bottom + 1)], FAINT.stroke_width(1)))?;
    let x_axis = LogAxis::of_cells(&map.x);
    for &tick in &x_axis.ticks {
        let x = left + (x_axis.position(tick) * f64::from(width)).round() as i32;
        root.draw(&PathElement::new([(x, bottom + 1), (x, bottom + 5)], FAINT))?;
        root.draw_text(&power(tick), &centered(label(0.9 * TEXT, INK)), (x, bottom + 15))?;
    }
    let y_axis = LogAxis::of_cells(&map.y);
    for &tick in &y_axis.ticks {
        let y = bottom - (y_axis.position(tick) * f64::from(height)).round() as i32;
        root.draw(&PathElement::new([(left - 5, y), (left - 1, y)], FAINT))?;
        if y_labels {
            let style = label(0.9 * TEXT, INK).pos(Pos::new(HPos::Right, VPos::Center));
            root.draw_text(&power(tick), &style, (left - 8, y))?;
        }
    }
    Ok(())
}

/// A power of ten: in plain digits if that is short, else as `1e5`.
fn power(tick: f64) -> String {
    let exponent = tick.log10().round();
    if (-2.0..=2.0).contains(&exponent) { severity(tick) } else { format!("1e{exponent}") }
}

fn image(root: &Area, layout: &Layout, (left, top): Pixel, map: &MapRow, cells: &MapCells) -> Drawn {
    let bottom = top + layout.size().1;
    let mut runs = runs(&map.hits, &cells.t_ulp_p99, layout.cells.0 as usize);
    // Runs of one class are drawn together, so that they become one path.
    runs.sort_by_key(|run| run.class);
    let corners = |run: &Run| {
        let bottom = bottom - run.row as i32 * layout.cell;
        let [from, to] = [run.columns.start, run.columns.end].map(|column| left + column as i32 * layout.cell);
        [(from, bottom - layout.cell), (to, bottom)]
    };
    runs.iter().try_for_each(|run| fill(root, corners(run), run.class))?;
    runs.iter().try_for_each(|run| stripe(root, corners(run), run.class))
}

/// The hover target of an image: the number of cells of each class as a tooltip, and the figure of each cell for the
/// script.
fn hover<'a>(layout: &Layout, corner: Pixel, map: &MapRow, cells: &'a MapCells) -> Hover<'a> {
    let classes: Vec<_> = map.hits.iter().zip(&cells.t_ulp_p99).map(|(&hits, &cell)| class(hits, cell)).collect();
    let counts = (0..KINDS).map(|class| (classes.iter().filter(|&&of| of == class).count(), meaning(class)));
    let counts: Vec<_> =
        counts.filter(|&(cells, _)| cells > 0).map(|(cells, meaning)| format!("{meaning}: {cells}")).collect();
    let figures = classes.iter().zip(&cells.t_ulp_p99).map(|(&class, cell)| match cell.filter(|_| class < KINDS - 1) {
        Some(ulp) => ulp.to_string(),
        None => meaning(class).replace(' ', "\u{a0}"),
    });
    let severities = |steps: &[f64]| steps.iter().map(|&step| severity(step)).collect::<Vec<_>>().join(" ");
    Hover {
        shape: Shape::Rectangle { corner, size: layout.size() },
        subjects: vec![&cells.id],
        title: format!("{}, scalar and packet, number of cells by error of t: {}", cells.id, counts.join("; ")),
        data: vec![
            ("axes", format!("{}|{}", map.x_axis, map.y_axis)),
            ("x", severities(&map.x)),
            ("y", severities(&map.y)),
            ("cells", figures.collect::<Vec<_>>().join(" ")),
        ],
    }
}

/// Neighbouring cells of one class in a row.
#[derive(Debug)]
struct Run {
    /// Number of the row, from the bottom.
    row: usize,
    columns: std::ops::Range<usize>,
    class: usize,
}

/// The runs of a map that is `width` cells wide.
fn runs(hits: &[u64], cells: &[Option<u64>], width: usize) -> Vec<Run> {
    let mut runs = Vec::new();
    for (row, (hits, cells)) in hits.chunks(width).zip(cells.chunks(width)).enumerate() {
        let classes: Vec<usize> = hits.iter().zip(cells).map(|(&hits, &cell)| class(hits, cell)).collect();
        let mut start = 0;
        for run in classes.chunk_by(|a, b| a == b) {
            let end = start + run.len();
            runs.push(Run { row, columns: start..end, class: run[0] });
            start = end;
        }
    }
    runs
}

/// Draws a rectangle in the colour of a class.
fn fill(root: &Area, corners: [Pixel; 2], class: usize) -> Drawn {
    root.draw(&Rectangle::new(corners, color(class).filled()))
}

/// Draws the stripe of a class, if it has one.
fn stripe(root: &Area, [from, to]: [Pixel; 2], class: usize) -> Drawn {
    if class == STEPS.len() {
        let y = (from.1 + to.1) / 2;
        root.draw(&PathElement::new([(from.0, y), (to.0, y)], PAGE.mix(0.7)))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::figures::groups;
    use crate::study::tests::fixture::record_of;

    #[test]
    fn runs_cover_every_cell_exactly_once_with_its_class() {
        let record = record_of(&["triangle/cramer".into()]);
        let (hits, cells, width) = (&record.maps[0].hits, &record.map_cells[0].t_ulp_p99, record.maps[0].x.len());
        let mut covered = vec![None; cells.len()];
        let runs = runs(hits, cells, width);
        assert!(runs.len() < cells.len() / 2, "{} runs", runs.len());
        for run in &runs {
            for column in run.columns.clone() {
                assert_eq!(covered[run.row * width + column].replace(run.class), None, "{run:?}");
            }
        }
        let expected: Vec<_> = hits.iter().zip(cells).map(|(&hits, &cell)| Some(class(hits, cell))).collect();
        assert_eq!(covered, expected);
    }

    #[test]
    fn the_hover_target_of_a_map_has_the_figures_of_all_cells() {
        let mut record = record_of(&["triangle/cramer".into()]);
        record.map_cells[0].t_ulp_p99[..4].copy_from_slice(&[Some(7), Some(8), None, Some(123_456)]);
        let (map, cells) = (&record.maps[0], &record.map_cells[0]);
        let hover = hover(&Layout::new(map, &[vec!["cramer"]]), (0, 0), map, cells);
        let [(_, axes), (_, x), (_, y), (_, figures)] = &hover.data[..] else { panic!("four attributes") };
        assert_eq!(axes.split('|').collect::<Vec<_>>(), [&map.x_axis, &map.y_axis]);
        assert_eq!([x, y, figures].map(|list| list.split(' ').count()), [map.x.len(), map.y.len(), map.hits.len()]);
        assert!(figures.starts_with("7 8 >\u{a0}1\u{a0}%\u{a0}missed 123456 "), "{figures}");
        assert!(
            hover.title.starts_with("triangle/cramer, scalar and packet, number of cells by error of t: 0 to 1 ulp: ")
        );
        // Cells with few hits count as such, whatever their figures are.
        assert!(hover.title.ends_with("; few hits: 3"), "{}", hover.title);
    }

    #[test]
    fn wide_names_are_broken_so_that_three_images_fit_side_by_side() {
        assert_eq!(lines_of("moller_trumbore_f64"), ["moller_trumbore_f64"]);
        assert_eq!(lines_of("moller_trumbore_epsilon"), ["moller_trumbore_", "epsilon"]);
        assert_eq!(lines_of("subtract_first/exact_fused_t"), ["subtract_first/", "exact_fused_t"]);
        assert_eq!(lines_of("namewithoutanyseparator"), ["namewithoutanyseparator"]);
        let record = record_of(&["triangle/cramer".into()]);
        for (name, columns) in [("moller_trumbore_epsilon", 3), ("namewithoutanyseparator", 2)] {
            let names = ["moller_trumbore", "cramer", name].map(lines_of);
            let layout = Layout::new(&record.maps[0], &names);
            assert_eq!(layout.columns, columns, "{name}");
            for line in names.iter().flatten() {
                assert!(name_width(line) + GAP <= layout.pitch, "{line}");
            }
            assert_eq!(layout.names, BELOW_NAME + LINE * names[2].len() as i32, "{name}");
        }
    }

    #[test]
    fn every_class_has_its_own_colour_and_meaning() {
        let cells = [Some(0), Some(1), Some(2), Some(100), Some(101), Some(100_000), Some(100_001), None];
        assert_eq!(cells.map(|cell| class(LEAST, cell)), [0, 0, 1, 2, 3, 5, 6, 7]);
        assert_eq!(cells.map(|cell| class(LEAST - 1, cell)), [8; 8]);
        for a in 0..KINDS {
            assert!((0..a).all(|b| color(a) != color(b) && meaning(a) != meaning(b)), "{a}");
        }
    }

    #[test]
    fn misses_are_striped_and_have_their_own_colour() {
        let mut record = record_of(&["triangle/cramer".into()]);
        let chart = |record: &Record| {
            let groups = groups(record);
            svg(record, &groups[0], &record.maps.iter().filter(|map| map.family == "triangle").collect::<Vec<_>>())
        };
        for cells in &mut record.map_cells {
            cells.t_ulp_p99.iter_mut().for_each(|cell| *cell = Some(u64::MAX));
        }
        let missed = |svg: &str| ["fill=\"#C8321A\"", "stroke=\"#FFF\" opacity"].map(|look| svg.matches(look).count());
        assert_eq!(missed(&chart(&record)), [1, 1], "only the legend has them");
        record.map_cells[0].t_ulp_p99[5] = None;
        let svg = chart(&record);
        assert_eq!(missed(&svg), [2, 2]);
        record.map_cells[0].t_ulp_p99.pop();
        assert!(chart(&record).contains("not measured"), "cells that do not fit the map are not drawn");
    }
}
