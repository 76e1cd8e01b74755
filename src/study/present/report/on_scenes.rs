//! The section on whole scenes: the same scenes and rays for every kernel.

use super::cells::code;
use crate::study::figures::on_scenes::{Answers, EDGES};
use crate::study::figures::{MISSING, Rate};
use crate::study::present::grid::{Cell, Grid};
use crate::study::record::Record;

const ABOUT: &str = "\
## The same scenes, every kernel

Every kernel gets the trees and the rays of the same scenes. Each answer is compared with the exact one of the whole \
scene: the oracle decides all primitives whose boxes the ray may meet. Rays start where the exact kernel hits. Figures \
are per million rays. A ray is *lost* if it exactly ends at a surface and is reported to end behind it or nowhere. It \
is *false* if it is reported to hit what it exactly misses; if that touches the right triangle, it is a *neighbour*, \
and the place is right up to rounding. *Pictures* are primary, shadow, bounce and ambient-occlusion rays together. \
*Edges* are rays from the eye at random points on edges of the triangles in sight, as far as `f32` can aim.";

/// A table for each scene; `None` if no scene was judged.
pub(super) fn section(record: &Record) -> Option<String> {
    let mut scenes: Vec<&str> = record.on_scenes.iter().map(|row| row.scene.as_str()).collect();
    scenes.dedup();
    let tables: Vec<_> = scenes.iter().map(|scene| format!("### {scene}\n\n{}", table(record, scene))).collect();
    (!tables.is_empty()).then(|| format!("{ABOUT}\n\n{}", tables.join("\n")))
}

fn table(record: &Record, scene: &str) -> String {
    let header =
        ["kernel", "rays of pictures", "lost", "false", "neighbour", "rays at edges", "lost", "false", "neighbour"];
    let mut grid = Grid::new(1, header);
    let mut kernels: Vec<&str> = Vec::new();
    for row in record.on_scenes.iter().filter(|row| row.scene == scene) {
        if !kernels.contains(&row.kernel.as_str()) {
            kernels.push(&row.kernel);
        }
    }
    for kernel in kernels {
        let of = |edges: bool| Answers::of(record, kernel, |row| row.scene == scene && (row.rays == EDGES) == edges);
        let mut cells = vec![code(kernel)];
        cells.extend([false, true].into_iter().flat_map(|edges| answers(of(edges))));
        grid.rows.push(cells);
    }
    grid.markdown()
}

/// The number of rays, and the three kinds of wrong answers.
fn answers(answers: Option<Answers>) -> [Cell; 4] {
    let Some(Answers { lost, false_hits, neighbours }) = answers else { return [MISSING; 4].map(Cell::from) };
    let [lost_cell, false_cell, neighbours] =
        [lost, false_hits, neighbours].map(|rate: Rate| Cell::from(rate.to_string()));
    [
        Cell::from(crate::study::figures::count(lost.of)),
        lost_cell.bad_if(lost.events > 0),
        false_cell.bad_if(false_hits.events > 0),
        neighbours,
    ]
}
