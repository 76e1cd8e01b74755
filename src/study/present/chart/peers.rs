//! `peers.svg`: speed of each tracer on each set of rays, in its fastest configuration. raylanes runs in mode auto.

use super::axis::LogAxis;
use super::canvas::{canvas, header, header_height, machine};
use super::layout::MARGIN;
use super::look::Look;
use super::panel::{Mark, Panel, Series, Stack, XAxis};
use crate::study::figures::number;
use crate::study::figures::peers::fastest;
use crate::study::measure::ray_sets::NAMES;
use crate::study::record::{PeerRow, Record};

const TITLE: &str = "Rays per second: raylanes and its peers";

/// Draws a panel for each scene, with one-thread figures.
pub(super) fn svg(record: &Record) -> String {
    let scenes = record.peers.chunk_by(|a, b| a.scene == b.scene);
    // Sets of rays are no numbers. On the logarithmic axis, each gets a power of ten, so they are equally far apart.
    let x = XAxis {
        axis: LogAxis::through(&NAMES.map(position)),
        title: "sets of rays, from coherent to incoherent".into(),
        tick: |x| NAMES.into_iter().find(|name| position(name) == x).map(short).unwrap_or_default().into(),
    };
    let stack = Stack { panels: scenes.map(panel).collect(), x };
    let width = stack.width();
    let remarks = [machine(record) + ", one thread"];
    let top = header_height(width, TITLE, &remarks);
    canvas((width, top + stack.height(width) + MARGIN), |root| {
        header(root, width, TITLE, &remarks)?;
        stack.draw(root, top, width)
    })
}

/// The name of a set of rays, short enough for an axis.
fn short(set: &str) -> &str {
    set.strip_prefix("ambient ").unwrap_or(set)
}

/// The position of a set of rays on the axis.
fn position(set: &str) -> f64 {
    let number = NAMES.iter().position(|name| *name == set).unwrap_or(NAMES.len());
    10f64.powi(number as i32)
}

fn panel(rows: &[PeerRow]) -> Panel<'_> {
    let mut series: Vec<Series> = Vec::new();
    for row in rows.chunk_by(|a, b| a.rays == b.rays).flat_map(fastest) {
        let of_tracer = match series.iter().position(|series| series.name == row.tracer) {
            Some(number) => &mut series[number],
            None => {
                let look = Look::of_category(series.len());
                let (id, name) = (&row.tracer, &row.tracer);
                series.push_mut(Series { id, name, look, emphasised: true, marks: Vec::new() })
            }
        };
        if row.mrays_per_second > 0.0 && row.mrays_per_second.is_finite() {
            // Marks of non-consecutive steps are not joined by a line.
            let step = 2 * of_tracer.marks.len();
            let (x, value) = (position(&row.rays), row.mrays_per_second);
            let tooltip = format!(
                "{}, {} rays: {} ± {} M rays/s",
                row.configuration,
                row.rays,
                number(value, 3),
                number(row.mrays_per_second_mad, 1)
            );
            of_tracer.marks.push(Mark { step, x, value, bound: None, tooltip });
        }
    }
    Panel {
        title: format!("{}: million rays per second", rows[0].scene),
        possible: 0.0..=f64::INFINITY,
        threshold: None,
        series,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::record::{EMBREE, OURS};
    use crate::study::tests::fixture::{peer_row, record_of};

    #[test]
    fn every_tracer_is_named_once_in_each_scene() {
        let mut record = record_of(&["triangle/woop".into()]);
        let mut rows = vec![
            peer_row(OURS, "scalar", 1, &[2.0]),
            peer_row(OURS, "auto", 1, &[20.0]),
            peer_row(EMBREE, "fast", 1, &[10.0]),
            peer_row(EMBREE, "robust", 1, &[9.0]),
        ];
        for set in NAMES.into_iter().skip(1) {
            let of_set = |row: &PeerRow| PeerRow { rays: set.into(), ..row.clone() };
            rows.extend(rows[..4].iter().map(of_set).collect::<Vec<_>>());
        }
        let elsewhere = |row: &PeerRow| PeerRow { scene: "terrain".into(), ..row.clone() };
        rows.extend(rows.iter().map(elsewhere).collect::<Vec<_>>());
        record.peers = rows;
        let svg = svg(&record);
        for (text, times) in [(OURS, 2), (EMBREE, 2), ("bounce", 1), ("occlusion", 1)] {
            assert_eq!(svg.matches(&format!(">{text}<")).count(), times, "{text}");
        }
        let panel = panel(&record.peers[..16]);
        let marks: Vec<_> = panel.series.iter().map(|series| series.marks.iter().map(|mark| mark.value)).collect();
        assert!(marks.into_iter().flatten().eq([20.0; 4].into_iter().chain([10.0; 4])));
    }
}
