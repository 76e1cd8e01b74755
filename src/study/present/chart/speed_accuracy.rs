//! `speed-accuracy.svg`: speed of every kernel against its error of `t` on generic rays, and against the rays that it
//! loses on the workloads aimed at losses.

use super::axis::LogAxis;
use super::canvas::{Area, Drawn, canvas, centered, header, header_height, heading, label, machine};
use super::layout::{INK, LEFT, LINE, MARGIN, TEXT, WIDTH};
use super::look::Look;
use super::panel::{
    Frame, Mark, Panel, Series, XAxis, draw_stack, frontier_sample, names_width, stack_height, whisker, widths,
};
use crate::study::figures::{Group, KernelFigures, Loss, count, number, si};
use crate::study::record::Record;

/// The widths that are shown, slower first, with half the size of their marks.
const WIDTHS: [(&str, i32); 2] = [(SCALAR, 4), (PACKET, 6)];
const SCALAR: &str = "1x1";
const PACKET: &str = "8x1";

const TITLE: &str = "Speed against accuracy: right is faster, down is more accurate";
const LEGEND_HEIGHT: i32 = 2 * LINE + 12;
const GROUP_TITLE: i32 = 30;
const SPEED: &str = "speed: million tests per second, one thread (right is faster)";

/// Space between two plots side by side, for the tick labels of the second one.
const BETWEEN: i32 = 56;
/// Minimum width of a plot.
const NARROWEST: i32 = 280;
const ROW_TITLE: i32 = 24;
const ROW_FIGURES: i32 = 26;

/// The order of the families: triangles first, because most pictures are made of them.
const ORDER: [&str; 3] = ["triangle", "aabb", "quadric"];

/// Draws an overview of these groups, one thread: a row for each group, with two plots side by side over the same
/// speeds, and the names once.
pub(super) fn overview(record: &Record, groups: &[&Group]) -> String {
    let mut groups = groups.to_vec();
    groups.sort_by_key(|group| ORDER.iter().position(|family| *family == group.title).unwrap_or(ORDER.len()));
    let rows: Vec<_> = groups.iter().map(|group| (group, panels(group, briefly(group)))).collect();
    let beside = names_width(rows.iter().flat_map(|(_, panels)| panels));
    let width = WIDTH.max(LEFT + BETWEEN + 2 * NARROWEST + beside);
    let plot = (width - LEFT - BETWEEN - beside) / 2;
    let remarks = [machine(record)];
    let head = header_height(width, TITLE, &remarks) + LEGEND_HEIGHT;
    let height = |panels: &[Panel; 2]| panels[0].least_height();
    let body: i32 = rows.iter().map(|(_, panels)| ROW_TITLE + height(panels) + ROW_FIGURES).sum();
    canvas((width, head + body + LINE + MARGIN / 2), |root| {
        let mut top = header(root, width, TITLE, &remarks)?;
        legend(root, top)?;
        top += LEGEND_HEIGHT;
        for (group, panels) in &rows {
            let size = (plot, height(panels));
            let corners = [0, plot + BETWEEN].map(|right| (LEFT + right, top + ROW_TITLE));
            root.draw_text(family(group), &heading(15.0), (MARGIN, top + ROW_TITLE / 2))?;
            for (panel, (left, _)) in panels.iter().zip(corners) {
                root.draw_text(&panel.title, &label(TEXT, INK), (left.max(MARGIN + 96), top + ROW_TITLE / 2))?;
            }
            let x = speeds(panels);
            let [error, lost] = corners.map(|corner| Frame { corner, size, x_labels: true });
            let best = panels[0].draw(root, &x, error, None)?;
            panels[1].draw(root, &x, lost, Some(&best))?;
            top += ROW_TITLE + size.1 + ROW_FIGURES;
        }
        root.draw_text(SPEED, &centered(label(TEXT, INK)), (LEFT + plot + BETWEEN / 2, top + LINE / 2))
    })
}

/// A family's name in words that readers look for.
fn family<'a>(group: &'a Group) -> &'a str {
    if group.title == "aabb" { "box (aabb)" } else { &group.title }
}

/// Draws these groups at full length, one thread: for each group, two panels over the same speeds.
pub(super) fn stacked(record: &Record, groups: &[&Group]) -> String {
    let panels: Vec<_> = groups.iter().map(|group| panels(group, at_length(group))).collect();
    let (plot, width) = widths(panels.iter().flatten());
    let remarks = [machine(record)];
    let head = header_height(width, TITLE, &remarks) + LEGEND_HEIGHT;
    let height = head + panels.iter().map(|panels| GROUP_TITLE + stack_height(panels)).sum::<i32>() + MARGIN;
    canvas((width, height), |root| {
        let mut top = header(root, width, TITLE, &remarks)?;
        legend(root, top)?;
        top += LEGEND_HEIGHT;
        for (group, panels) in groups.iter().zip(&panels) {
            root.draw_text(&group.heading(), &heading(15.0), (MARGIN, top + GROUP_TITLE / 2))?;
            top += GROUP_TITLE;
            draw_stack(root, panels, &speeds(panels), top, plot)?;
            top += stack_height(panels);
        }
        Ok(())
    })
}

/// Short titles of the two panels, with the numbers of rays.
fn briefly(group: &Group) -> [String; 2] {
    let of = |what: &str, numbers: Vec<u64>| match (numbers.iter().min(), numbers.iter().max()) {
        (Some(least), Some(most)) if least < most => {
            format!("{what}, n = {} to {}", si(*least as f64, 2), si(*most as f64, 2))
        }
        (Some(n), _) => format!("{what}, n = {}", si(*n as f64, 2)),
        _ => what.into(),
    };
    let hits = group.kernels.iter().filter_map(|kernel| kernel.accuracy("generic")).map(|row| row.agreed_hits);
    let rays = group.kernels.iter().filter_map(|kernel| kernel.lost).map(|lost| lost.rate.of);
    let lost = match group.loss {
        Loss::Leaks => "leaks per million rays that hit a mesh",
        Loss::WithBoundary | Loss::Strict => "lost rays per million that hit",
    };
    [of("error of t (ulp), 99th percentile", hits.collect()), of(lost, rays.collect())]
}

/// Long titles of the two panels, as in the report.
fn at_length(group: &Group) -> [String; 2] {
    let error = "99th percentile of the error of t on generic rays, in units in the last place (ulp)";
    [error.into(), group.lost_means()]
}

/// The horizontal axis, over all speeds of a group.
fn speeds<'a>(panels: &[Panel]) -> XAxis<'a> {
    let marks = panels.iter().flat_map(|panel| &panel.series).flat_map(|series| &series.marks);
    XAxis {
        axis: LogAxis::around(marks.map(|mark| mark.x), 0.0..=f64::INFINITY),
        title: SPEED.into(),
        tick: &|speed| si(speed, 1),
    }
}

/// Draws the meaning of the marks.
fn legend(root: &Area, top: i32) -> Drawn {
    let look = Look::neutral();
    let rows = [top + LINE / 2, top + LINE / 2 + LINE + 4];
    let columns = [MARGIN + 8, MARGIN + 290];
    for (column, row, size, hollow, meaning) in [
        (0, 0, WIDTHS[0].1, false, "small: scalar, one ray at a time"),
        (0, 1, WIDTHS[1].1, false, "large: packet of eight, ± MAD"),
        (1, 0, 5, true, "hollow: no event in n rays, drawn at the 95 % bound, 3/n (one or two events lie below it)"),
    ] {
        look.mark(root, (columns[column], rows[row]), size, hollow)?;
        root.draw_text(meaning, &label(TEXT, INK), (columns[column] + 20, rows[row]))?;
    }
    whisker(root, [(columns[0] - 12, rows[1]), (columns[0] + 12, rows[1])], look)?;
    frontier_sample(root, (columns[1] - 8, rows[1] + 2))?;
    let meaning = "frontier (bold names: on it, or tied); shaded: some kernel is both faster and at least as accurate";
    root.draw_text(meaning, &label(TEXT, INK), (columns[1] + 24, rows[1]))
}

/// The two panels of a group: the error of `t`, and lost rays.
fn panels<'a>(group: &'a Group, [error, lost]: [String; 2]) -> [Panel<'a>; 2] {
    let rate = |kernel: &KernelFigures| kernel.lost.map(|lost| (lost.rate.or_bound(), lost.rate.events == 0));
    let ulp = |kernel: &KernelFigures| kernel.ulp().map(|ulp| (ulp as f64, false));
    let panel = |title: String, possible, series| Panel { title, possible, threshold: None, frontier: true, series };
    [panel(error, 1.0..=f64::INFINITY, series(group, ulp)), panel(lost, 0.0..=1e6, series(group, rate))]
}

/// The series of a group. `value` gives the plotted value of a kernel, and whether it is a bound.
fn series<'a>(group: &'a Group, value: impl Fn(&KernelFigures) -> Option<(f64, bool)>) -> Vec<Series<'a>> {
    let series = group.kernels.iter().map(|kernel| {
        let mark = |(step, &(width, size)): (usize, &(&str, i32))| {
            let (value, bound) = value(kernel)?;
            let x = kernel.mtests(width, 1).filter(|&speed| speed > 0.0 && speed.is_finite())?;
            Some(Mark {
                step,
                x,
                spread: spread(kernel, width),
                value,
                bound,
                size,
                tooltip: tooltip(group, kernel, width),
            })
        };
        Series {
            id: &kernel.method.id,
            name: &kernel.name,
            marks: WIDTHS.iter().enumerate().filter_map(mark).collect(),
        }
    });
    series.collect()
}

/// The interval of a packet's speed; `None` for scalar code.
fn spread(kernel: &KernelFigures, width: &str) -> Option<[f64; 2]> {
    let row = kernel.speed(width, 1).filter(|_| width == PACKET)?;
    Some([row.ns_per_test_high, row.ns_per_test_low].map(|ns| 1e3 / ns))
}

/// The tooltip of a mark: speed, error and lost rays of a kernel at a width.
fn tooltip(group: &Group, kernel: &KernelFigures, width: &str) -> String {
    let mut text = if width == PACKET { "packet of 8 rays" } else { "1 ray" }.to_owned();
    if let Some(row) = kernel.speed(width, 1) {
        let mtests = row.tests_per_second / 1e6;
        let [low, high] = [row.ns_per_test_high, row.ns_per_test_low].map(|ns| number(1e3 / ns, 3));
        text += &format!(": {} ({low} to {high}) M tests/s", number(mtests, 3));
    }
    if let Some(ulp) = kernel.ulp() {
        text += &format!(", error of t {} ulp", count(ulp));
    }
    if let Some(lost) = kernel.lost {
        text += &format!(", {} {} per million", if group.loss == Loss::Leaks { "leaks" } else { "lost" }, lost.rate);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::figures::groups;
    use crate::study::tests::fixture::{all_ids, record_of, set_rounds};

    /// The overview, and the stack of panels.
    fn charts(record: &Record) -> [String; 2] {
        let groups = groups(record);
        let groups: Vec<_> = groups.iter().collect();
        [overview(record, &groups), stacked(record, &groups)]
    }

    fn occurrences(svg: &str, what: &str) -> usize {
        svg.matches(what).count()
    }

    #[test]
    fn every_kernel_is_named_once_in_a_row_and_in_every_panel_of_a_stack() {
        let record = record_of(&all_ids());
        let [overview, stacked] = charts(&record);
        for group in groups(&record) {
            assert!(stacked.contains(&format!(">{}<", group.heading())), "{}", group.title);
            assert!(overview.contains(&format!(">{}<", family(&group))), "{}", group.title);
        }
        for name in ["cramer", "padded", "baked", "subtract_first/exact"] {
            let text = format!(">{name}</text>");
            assert_eq!([&overview, &stacked].map(|svg| occurrences(svg, &text)), [1, 2], "{name}");
        }
    }

    #[test]
    fn the_overview_fits_a_screen_and_starts_with_triangles() {
        let record = record_of(&all_ids());
        let groups = groups(&record);
        let bases: Vec<_> = groups.iter().filter(|group| group.is_base()).rev().collect();
        let svg = overview(&record, &bases);
        let rows = ["triangle", "box (aabb)", "quadric"].map(|family| svg.find(&format!(">{family}<")));
        assert!(rows.is_sorted() && rows[0].is_some());
        let [width, height] = ["width", "height"].map(|side| {
            let (_, rest) = svg.split_once(&format!(" {side}=\"")).unwrap();
            rest.split('"').next().unwrap().parse::<u32>().unwrap()
        });
        assert!(width <= 1100 && height <= 650, "{width} × {height}");
    }

    #[test]
    fn tooltips_name_kernel_width_and_figures() {
        let mut record = record_of(&["triangle/cramer".into(), "triangle/woop".into()]);
        for row in &mut record.speed {
            let packet = row.width == "8x1";
            set_rounds(row, if packet { &[1.24, 1.25, 1.26] } else { &[4.95, 5.0, 5.05] });
        }
        for row in &mut record.accuracy {
            (row.t_ulp_p99, row.leak_per_million) = (7, if row.id == "triangle/woop" { 0.0 } else { 12.0 });
        }
        let [overview, stacked] = charts(&record);
        let cramer = "triangle/cramer, packet of 8 rays: 800 (794 to 806) M tests/s, error of t 7 ulp, leaks 12.0 per \
                      million</title>";
        for svg in [&overview, &stacked] {
            assert_eq!(
                occurrences(
                    svg,
                    "triangle/cramer, 1 ray: 200 (198 to 202) M tests/s, error of t 7 ulp, leaks 12.0 per"
                ),
                2
            );
            // In one panel both kernels share the place of a mark; in the other each has its own.
            assert_eq!(occurrences(svg, &format!(" leaks 0 (&lt; 4.8) per million\n{cramer}")), 1);
            assert_eq!(occurrences(svg, &format!("<title>{cramer}")), 1);
        }
    }

    #[test]
    fn a_zero_is_marked_as_a_bound() {
        let mut record = record_of(&["triangle/cramer".into()]);
        record.accuracy.iter_mut().for_each(|row| row.leak_per_million = 0.0);
        let with_zero = charts(&record);
        record.accuracy.iter_mut().for_each(|row| row.leak_per_million = 10.0);
        // One arrow for each of the two widths.
        for (with_zero, without) in with_zero.iter().zip(&charts(&record)) {
            let [with_zero, without] = [with_zero, without].map(|svg| occurrences(svg, "l3 3 3-3"));
            assert_eq!(with_zero, without + 2);
        }
    }

    #[test]
    fn a_bound_below_one_is_not_labelled_as_zero() {
        let mut record = record_of(&["triangle/cramer".into()]);
        record.accuracy.iter_mut().for_each(|row| (row.mesh_hits, row.leak_per_million) = (30_000_000, 0.0));
        record.accuracy.iter_mut().for_each(|row| row.t_ulp_p99 = 1);
        assert!(charts(&record).iter().all(|svg| occurrences(svg, ">0<") == 0), "a bound of 0.1 is not 0");
        record.accuracy.iter_mut().for_each(|row| row.t_ulp_p99 = 0);
        assert!(charts(&record).iter().all(|svg| occurrences(svg, ">0<") == 1));
    }
}
