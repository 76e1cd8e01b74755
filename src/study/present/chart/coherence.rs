//! `coherence.svg`: the tracer's modes on the rays of a picture that are turned at random, further and further.

use super::axis::LogAxis;
use super::canvas::{canvas, header, header_height, heading, machine};
use super::layout::MARGIN;
use super::panel::{Mark, Panel, Series, XAxis, draw_stack, stack_height, widths};
use crate::study::figures::tracer::{Coherence, modes};
use crate::study::figures::{number, severity};
use crate::study::record::{CoherenceRow, Record};

const TITLE: &str = "Coherence: every mode as the rays become less coherent";
const SCENE_TITLE: i32 = 30;
const MARK: i32 = 5;

/// The figure of a row that a panel shows.
type Figure = fn(&CoherenceRow) -> Option<f64>;

/// Draws a stack of panels for each scene, against the jitter.
pub(super) fn svg(record: &Record) -> String {
    let all = Coherence::all(record);
    let panels: Vec<_> = all.iter().map(panels).collect();
    let (plot, width) = widths(panels.iter().flatten());
    let remarks = [machine(record) + ", one thread, closest hit"];
    let head = header_height(width, TITLE, &remarks);
    let height = head + panels.iter().map(|panels| SCENE_TITLE + stack_height(panels)).sum::<i32>() + MARGIN;
    canvas((width, height), |root| {
        let mut top = header(root, width, TITLE, &remarks)?;
        for (coherence, panels) in all.iter().zip(&panels) {
            root.draw_text(coherence.scene, &heading(15.0), (MARGIN, top + SCENE_TITLE / 2))?;
            top += SCENE_TITLE;
            let x = XAxis {
                axis: LogAxis::through(&coherence.jitters),
                title: "jitter: 0 for the rays of a picture, 1 for random rays".into(),
                tick: &severity,
            };
            draw_stack(root, panels, &x, top, plot)?;
            top += stack_height(panels);
        }
        Ok(())
    })
}

/// The panels of a scene: speed, and each count that has any values.
fn panels(coherence: &Coherence) -> Vec<Panel<'static>> {
    let panel = |(title, unit, figure): (&str, &str, Figure)| {
        let series = modes().map(|mode| Series { id: mode, name: mode, marks: marks(coherence, mode, figure, unit) });
        Panel {
            title: title.into(),
            possible: 0.0..=f64::INFINITY,
            threshold: None,
            frontier: false,
            series: series.into(),
        }
    };
    let figures: [(&str, &str, Figure); 4] = [
        ("million rays per second", "M rays/s", |row| Some(row.mrays_per_second)),
        ("lane utilisation: share of the lanes of triangle tests that are used (%)", "% of the lanes used", |row| {
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
        Some(Mark { step, x, spread: None, value, bound: false, size: MARK, tooltip })
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
