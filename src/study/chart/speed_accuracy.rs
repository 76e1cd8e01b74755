//! `speed-accuracy.svg`: every kernel's speed against its error of `t` over ordinary rays, and against the rays it loses
//! where they are hardest to keep.

use super::axis::LogAxis;
use super::look::Look;
use super::panel::{Mark, Panel, Series, XAxis, draw_stack, frontier_sample, stack_height, widths};
use super::{Area, Drawn, INK, LINE, MARGIN, TEXT, canvas, header, header_height, heading, label, machine};
use crate::study::figures::{Figures, Group, si};
use crate::study::record::Record;

/// The faces of a kernel, slower first, with half the size of their marks.
const FACES: [(&str, i32); 2] = [("1x1", 4), ("8x1", 6)];

const TITLE: &str = "Speed against accuracy: right is faster, down is more accurate";
const LEGEND_HEIGHT: i32 = 2 * LINE + 12;
const GROUP_TITLE: i32 = 30;

/// Draws the one-thread figures of these groups, two panels over the same speeds for each.
pub(super) fn svg(record: &Record, groups: &[&Group]) -> String {
    let panels: Vec<_> = groups.iter().map(|group| panels(group)).collect();
    let (plot, width) = widths(panels.iter().flatten());
    let remarks = [machine(record) + ", one thread"];
    let head = header_height(width, TITLE, &remarks) + LEGEND_HEIGHT;
    let height = head + panels.iter().map(|panels| GROUP_TITLE + stack_height(panels)).sum::<i32>() + MARGIN;
    canvas((width, height), |root| {
        let mut top = header(root, width, TITLE, &remarks)?;
        legend(root, top)?;
        top += LEGEND_HEIGHT;
        for (group, panels) in groups.iter().zip(&panels) {
            root.draw_text(&group.heading(), &heading(15.0), (MARGIN, top + GROUP_TITLE / 2))?;
            top += GROUP_TITLE;
            let speeds = panels.iter().flat_map(|panel| &panel.series).flat_map(|series| &series.marks);
            let x = XAxis {
                axis: LogAxis::around(speeds.map(|mark| mark.x), 0.0..=f64::INFINITY),
                title: "speed: million tests per second, one thread (to the right: faster)".into(),
                tick: &|speed| si(speed, 1),
            };
            draw_stack(root, panels, &x, top, plot)?;
            top += stack_height(panels);
        }
        Ok(())
    })
}

/// What the marks mean.
fn legend(root: &Area, top: i32) -> Drawn {
    let look = Look::neutral();
    let rows = [top + LINE / 2, top + LINE / 2 + LINE + 4];
    let columns = [MARGIN + 8, MARGIN + 300];
    for (column, row, size, hollow, meaning) in [
        (0, 0, FACES[0].1, false, "small: scalar, one ray at a time"),
        (0, 1, FACES[1].1, false, "large: packet of eight rays"),
        (1, 0, 5, true, "hollow: none in n rays, drawn at 3/n, the 95 % bound (one or two lie below it)"),
    ] {
        look.mark(root, (columns[column], rows[row]), size, hollow)?;
        root.draw_text(meaning, &label(TEXT, INK), (columns[column] + 16, rows[row]))?;
    }
    frontier_sample(root, (columns[1] - 8, rows[1] + 2))?;
    let meaning = "frontier (bold names): nothing is both faster and as accurate; whatever lies in the shade is beaten";
    root.draw_text(meaning, &label(TEXT, INK), (columns[1] + 24, rows[1]))
}

/// The panels of a group: the error of `t`, and lost rays.
fn panels<'a>(group: &'a Group) -> [Panel<'a>; 2] {
    let lost = |kernel: &Figures| kernel.lost.map(|lost| (lost.or_bound(), lost.per_million == 0.0));
    let ulp = |kernel: &Figures| kernel.ulp().map(|ulp| (ulp as f64, false));
    let panel = |title: String, possible, series| Panel { title, possible, threshold: None, frontier: true, series };
    let ulp_title = "99th percentile of the error of t, in units in the last place (ulp), generic rays";
    [
        panel(ulp_title.into(), 1.0..=f64::INFINITY, series(group, ulp)),
        panel(group.lost_means(), 0.0..=1e6, series(group, lost)),
    ]
}

/// The series of a group; `value` gives what is plotted, and whether it is a bound.
fn series<'a>(group: &'a Group, value: impl Fn(&Figures) -> Option<(f64, bool)>) -> Vec<Series<'a>> {
    let series = group.kernels.iter().map(|kernel| {
        let mark = |(step, &(face, size)): (usize, &(&str, i32))| {
            let (value, bound) = value(kernel)?;
            let x = kernel.mtests(face, 1).filter(|&speed| speed > 0.0 && speed.is_finite())?;
            Some(Mark { step, x, value, bound, size })
        };
        Series { name: &kernel.name, marks: FACES.iter().enumerate().filter_map(mark).collect() }
    });
    series.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::figures::groups;
    use crate::study::fixture::{all_ids, record_of};

    fn chart(record: &Record) -> String {
        svg(record, &groups(record).iter().collect::<Vec<_>>())
    }

    fn occurrences(svg: &str, what: &str) -> usize {
        svg.matches(what).count()
    }

    #[test]
    fn every_kernel_is_named_in_both_panels() {
        let record = record_of(&all_ids());
        let svg = chart(&record);
        for group in groups(&record) {
            assert!(svg.contains(&format!(">\n{}\n<", group.heading())), "{}", group.title);
        }
        for name in ["cramer", "padded", "subtract_first/cramer", "inverse/moller_trumbore", "f64/padded"] {
            assert_eq!(occurrences(&svg, &format!(">\n{name}\n<")), 2, "{name}");
        }
    }

    #[test]
    fn a_zero_is_marked_as_a_bound() {
        let mut record = record_of(&["triangle/cramer".into()]);
        record.accuracy.iter_mut().for_each(|row| row.leak_per_million = 0.0);
        let with_zero = chart(&record);
        record.accuracy.iter_mut().for_each(|row| row.leak_per_million = 10.0);
        let without = chart(&record);
        // Two faces, and a stem and a tip for each arrow.
        let with_zero = occurrences(&with_zero, "polyline");
        assert_eq!(with_zero, occurrences(&without, "polyline") + 4);
    }

    #[test]
    fn only_a_zero_is_labelled_so() {
        let mut record = record_of(&["triangle/cramer".into()]);
        record.accuracy.iter_mut().for_each(|row| (row.mesh_hits, row.leak_per_million) = (30_000_000, 0.0));
        record.accuracy.iter_mut().for_each(|row| row.t_ulp_p99 = 1);
        assert_eq!(occurrences(&chart(&record), ">\n0\n<"), 0, "a bound of 0.1 is none");
        record.accuracy.iter_mut().for_each(|row| row.t_ulp_p99 = 0);
        assert_eq!(occurrences(&chart(&record), ">\n0\n<"), 1);
    }
}
