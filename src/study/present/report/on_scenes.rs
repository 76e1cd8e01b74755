//! The section on whole scenes: the same scenes and rays for every kernel.

use super::cells::code;
use crate::study::figures::on_scenes::{Answers, mrays};
use crate::study::figures::{MISSING, count, optional};
use crate::study::present::grid::{Cell, Grid};
use crate::study::ray_sets::{self, EDGES};
use crate::study::record::Record;

const ABOUT: &str = "\
## The same scenes, every kernel

Every kernel gets the trees and the rays of the same scenes. Each answer is compared with the exact one of the whole \
scene: the oracle decides all primitives whose boxes the ray may meet. Rays of pictures start where the exact kernel \
hits, moved off the surface by the tracer's error bound; other starts give other rates of hits on the surface left. \
Instances move rays by a transform in `f32`, so that no kernel is exact behind it. Wrong answers are per million rays; \
speeds are those of one thread. A ray is *lost* if it exactly ends at a surface and is reported to end behind it or \
nowhere. It is *false* if it is reported to hit what it exactly misses; if that touches \
the right triangle, it is a *neighbour*, and the place is right up to rounding. *Pictures* are primary, shadow, bounce \
and ambient-occlusion rays together. \
*Edges* are rays from the eye at random points on edges of the triangles in sight, as far as `f32` can aim.";

/// A table for each scene; `None` if no scene was judged.
pub(super) fn section(record: &Record) -> Option<String> {
    let mut scenes: Vec<&str> = record.on_scenes.iter().map(|row| row.scene.as_str()).collect();
    scenes.dedup();
    let tables: Vec<_> = scenes.iter().map(|scene| format!("### {scene}\n\n{}", table(record, scene))).collect();
    (!tables.is_empty()).then(|| format!("{ABOUT}\n\n{}", tables.join("\n")))
}

fn table(record: &Record, scene: &str) -> String {
    let mut grid = Grid::new(1, ["kernel"]);
    grid.header.extend(ray_sets::NAMES.map(|set| Cell::from(format!("{set}, M rays/s"))));
    for rays in ["pictures", "edges"] {
        grid.header.extend(["lost", "false", "neighbour"].map(|kind| Cell::from(format!("{rays}: {kind}"))));
    }
    let mut kernels: Vec<&str> = Vec::new();
    for row in record.on_scenes.iter().filter(|row| row.scene == scene) {
        if !kernels.contains(&row.kernel.as_str()) {
            kernels.push(&row.kernel);
        }
    }
    let answers = |kernel: &str, edges: bool| {
        Answers::of(record, kernel, |row| row.scene == scene && (row.rays == EDGES) == edges)
    };
    for kernel in &kernels {
        let speed = |set: &str| mrays(record, kernel, |row| row.scene == scene && row.rays == set);
        let mut cells = vec![code(kernel)];
        cells.extend(ray_sets::NAMES.map(|set| Cell::from(optional(speed(set).map(|speed| speed.value), 3))));
        cells.extend([false, true].into_iter().flat_map(|edges| wrong(answers(kernel, edges))));
        grid.rows.push(cells);
    }
    let rays = [false, true].map(|edges| kernels.first().and_then(|kernel| answers(kernel, edges)));
    let [pictures, edges] = rays.map(|answers| count(answers.map_or(0, |answers| answers.lost.of)));
    format!("{pictures} rays of pictures and {edges} rays at edges were judged.\n\n{}", grid.markdown())
}

/// The three kinds of wrong answers.
fn wrong(answers: Option<Answers>) -> [Cell; 3] {
    let Some(Answers { lost, false_hits, neighbours }) = answers else { return [MISSING; 3].map(Cell::from) };
    [lost, false_hits, neighbours].map(|rate| Cell::from(rate.to_string()))
}
