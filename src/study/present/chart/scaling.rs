//! `scaling.svg`: cost of a ray in a landscape with more and more triangles, and the landscape's build time and memory.

use super::axis::LogAxis;
use super::canvas::{canvas, header, header_height, machine};
use super::layout::MARGIN;
use super::look::Look;
use super::palette::INK;
use super::panel::{Mark, Panel, Series, Stack, XAxis};
use crate::study::figures::tracer::Growth;
use crate::study::figures::{count, number, si};
use crate::study::record::{Record, ScalingRow};

const TITLE: &str = "Cost of a ray as a landscape grows";

/// Draws cost, build time and memory against the number of triangles.
pub(super) fn svg(record: &Record) -> String {
    let all = Growth::all(record);
    let sizes: Vec<f64> = all.first().map_or(Vec::new(), |growth| growth.rows.iter().map(|row| size(row)).collect());
    let x =
        XAxis { axis: LogAxis::through(&sizes), title: "triangles of the landscape".into(), tick: |size| si(size, 1) };
    let stack = Stack { panels: panels(&all).into(), x };
    let width = stack.width();
    let remarks = [machine(record) + ", mode auto, one thread; built on all threads"];
    let top = header_height(width, TITLE, &remarks);
    canvas((width, top + stack.height(width) + MARGIN), |root| {
        let top = header(root, width, TITLE, &remarks)?;
        stack.draw(root, top, width)
    })
}

fn size(row: &ScalingRow) -> f64 {
    row.triangles as f64
}

fn panels<'a>(all: &[Growth<'a>]) -> [Panel<'a>; 3] {
    let panel =
        |title: &str, series| Panel { title: title.into(), possible: 0.0..=f64::INFINITY, threshold: None, series };
    // Build time and memory are the same for all sets of rays, so the first set is enough.
    let of_scene = |name, unit, figure: fn(&ScalingRow) -> f64| {
        let rows = all.first().map(|growth| growth.rows.as_slice()).unwrap_or_default();
        vec![Series { id: name, name, look: Look::new(INK, 0), emphasised: true, marks: marks(rows, unit, figure) }]
    };
    [
        panel(
            "nanoseconds per ray",
            all.iter()
                .enumerate()
                .map(|(number, growth)| Series {
                    id: growth.rays,
                    name: growth.rays,
                    look: Look::of_category(number),
                    emphasised: true,
                    marks: marks(&growth.rows, "ns per ray", |row| row.ns_per_ray),
                })
                .collect(),
        ),
        panel(
            "build time in nanoseconds per triangle",
            of_scene("build", "ns per triangle", |row| row.build_seconds * 1e9 / size(row)),
        ),
        panel("bytes per triangle", of_scene("memory", "bytes per triangle", |row| row.bytes_per_triangle)),
    ]
}

fn marks(rows: &[&ScalingRow], unit: &str, figure: fn(&ScalingRow) -> f64) -> Vec<Mark> {
    let mark = |(step, row): (usize, &&ScalingRow)| {
        let value = Some(figure(row)).filter(|&value| value > 0.0 && value.is_finite())?;
        let tooltip = format!("{} triangles: {} {unit}", count(row.triangles as u64), number(value, 3));
        Some(Mark { step, x: size(row), value, bound: None, tooltip })
    };
    rows.iter().enumerate().filter_map(mark).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::tests::fixture::record_of;

    #[test]
    fn every_set_of_rays_has_a_line_through_all_sizes() {
        let record = record_of(&[]);
        let [cost, build, memory] = panels(&Growth::all(&record));
        assert_eq!(cost.series.len(), 4);
        for series in cost.series.iter().chain(&build.series).chain(&memory.series) {
            assert!(series.marks.iter().map(|mark| mark.step).eq(0..3), "{}", series.name);
        }
        assert!(build.series[0].marks.iter().all(|mark| (mark.value - 300.0).abs() < 1e-6));
        for tick in ["10 k", "100 k", "1 M"] {
            assert_eq!(svg(&record).matches(&format!(">{tick}<")).count(), 1, "{tick}");
        }
    }
}
