//! `coherence.svg`: the tracer's modes on the rays of a picture that are turned at random, further and further.

use super::axis::LogAxis;
use super::canvas::{canvas, header, header_height, heading, machine};
use super::layout::{LINE, MARGIN, TEXT, WIDTH};
use super::look::Look;
use super::panel::{Mark, Panel, Series, Stack, XAxis};
use crate::study::figures::tracer::{Coherence, modes};
use crate::study::figures::{number, severity};
use crate::study::record::{CoherenceRow, Record};

const TITLE: &str = "Modes as rays become less coherent";
const MODES: &str = "A mode is how rays pass through the tree: scalar and single trace one ray, scalar with scalar \
                     code and single with eight lanes; packet traces eight rays together; auto chooses.";
const SCENE_TITLE: i32 = 26;

/// The figure of a row that a panel shows.
type Figure = fn(&CoherenceRow) -> Option<f64>;

/// Draws a stack of panels for each scene, against the jitter.
pub(super) fn svg(record: &Record) -> String {
    let all = Coherence::all(record);
    let stack = |coherence| Stack { panels: panels(coherence), x: axis(coherence) };
    let stacks: Vec<_> = all.iter().map(stack).collect();
    let width = stacks.iter().map(Stack::width).max().unwrap_or(WIDTH);
    let remarks = [MODES.into(), machine(record) + ", one thread, closest hit"];
    let head = header_height(width, TITLE, &remarks);
    let height = head + stacks.iter().map(|stack| SCENE_TITLE + stack.height(width)).sum::<i32>() + MARGIN;
    canvas((width, height), |root| {
        let mut top = header(root, width, TITLE, &remarks)?;
        for (coherence, stack) in all.iter().zip(&stacks) {
            root.draw_text(coherence.scene, &heading(TEXT), (MARGIN, top + LINE / 2))?;
            top += SCENE_TITLE;
            stack.draw(root, top, width)?;
            top += stack.height(width);
        }
        Ok(())
    })
}

fn axis(coherence: &Coherence) -> XAxis {
    XAxis {
        axis: LogAxis::through(&coherence.jitters),
        title: "jitter: each direction is turned at random; 0 for the rays of a picture, 1 for random rays".into(),
        tick: severity,
    }
}

/// The panels of a scene: speed, and each count that has any values.
fn panels(coherence: &Coherence) -> Vec<Panel<'static>> {
    let panel = |(title, unit, figure): (&str, &str, Figure)| {
        let mut number = 0..;
        let series = modes().map(|mode| Series {
            id: mode,
            name: mode,
            look: Look::of_category(number.next().unwrap_or(0)),
            emphasised: true,
            marks: marks(coherence, mode, figure, unit),
        });
        Panel { title: title.into(), possible: 0.0..=f64::INFINITY, threshold: None, series: series.into() }
    };
    let figures: [(&str, &str, Figure); 4] = [
        ("million rays per second", "M rays/s", |row| Some(row.mrays_per_second)),
        ("lane utilisation: lanes of triangle tests in use, %", "% of the lanes used", |row| {
            row.lane_utilisation().map(|share| 100.0 * share)
        }),
        ("nodes visited per ray", "nodes per ray", CoherenceRow::nodes_per_ray),
        ("eight-wide triangle tests per ray", "eight-wide triangle tests per ray", CoherenceRow::tests_per_ray),
    ];
    figures.into_iter().map(panel).filter(|panel| panel.series.iter().any(|series| !series.marks.is_empty())).collect()
}

fn marks(coherence: &Coherence, mode: &str, figure: Figure, unit: &str) -> Vec<Mark> {
    let mark = |(step, &x): (usize, &f64)| {
        let value = figure(coherence.row(x, mode)?).filter(|&value| value > 0.0 && value.is_finite())?;
        let tooltip = format!("jitter {}: {} {unit}", severity(x), number(value, 3));
        Some(Mark { step, x, value, bound: None, tooltip })
    };
    coherence.jitters.iter().enumerate().filter_map(mark).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::tests::fixture::record_of;

    #[test]
    fn a_count_without_values_has_no_panel() {
        let mut record = record_of(&[]);
        let titles = |record: &Record| {
            let panels: Vec<_> = Coherence::all(record).iter().flat_map(panels).collect();
            panels.into_iter().map(|panel| panel.title).collect::<Vec<_>>()
        };
        let all = titles(&record);
        assert!(
            all.len() == 8 && all.iter().all(|title| svg(&record).matches(&format!(">{title}<")).count() == 2),
            "{all:?}"
        );
        for row in record.coherence.iter_mut().filter(|row| row.scene == "room") {
            (row.nodes, row.leaves, row.tests, row.lanes) = (0, 0, 0, 0);
        }
        assert_eq!(titles(&record), all[..5]);
    }

    #[test]
    fn a_mode_has_the_same_look_in_every_panel() {
        let record = record_of(&[]);
        for panel in panels(&Coherence::all(&record)[0]) {
            assert!(panel.series.iter().map(|series| series.name).eq(modes()), "{}", panel.title);
            assert_eq!(panel.series[2].marks.len(), 9, "packets must have a mark at every jitter");
        }
    }
}
