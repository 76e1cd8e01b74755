//! Errors of every kernel on the workloads that have no severities.

use super::cells::code;
use crate::study::figures::{Figures, MISSING, Rate, count, number, si};
use crate::study::present::grid::{Cell, Grid};
use crate::study::record::{AccuracyRow, Record};

pub(super) const ACCURACY: &str = "\
## Accuracy

Against an oracle in exact arithmetic. Twins give the same bits, so that one row stands for every face of a kernel. Rates \
are per million of the number behind the slash; where nothing was observed, the bracket gives the 95 % bound, three in \
that number.

- *false miss*: pairs of ray and primitive that exactly hit strictly inside, reported as misses.
- *false hit*: pairs that exactly miss, reported as hits.
- *leak*: rays that exactly hit a mesh, edges included, reported to hit nothing of it.
- *double*: rays that exactly hit one triangle strictly inside and no other, reported to hit several.
- *boundary*: rays that exactly hit an edge or a vertex, or a quadric where that hangs on an equality (tangent, at a plane \
of its box, at an end of the interval), by how many hits were reported: none / one / more.
- *ulp*: distance of `t` from the correctly rounded one, in representable numbers, over hits both agree on. The 99th \
percentile is the one to compare; the greatest is noise.
- *gross*: hits that both agree on whose `t` is off by more than 1 %.
- *u, v*: absolute error of the surface parameters; for a box, of the exit distance.";

/// The workloads without severities that occur, in the order of the record.
pub(super) fn workloads(record: &Record) -> Vec<&str> {
    let mut workloads: Vec<&str> = Vec::new();
    for row in record.accuracy.iter().filter(|row| row.severity.is_none()) {
        if !workloads.contains(&row.workload.as_str()) {
            workloads.push(&row.workload);
        }
    }
    workloads
}

pub(super) fn wrong_answers(rows: &[(&Figures, &AccuracyRow)]) -> String {
    let header = ["kernel", "rays", "tests", "false miss", "false hit", "leak", "double", "boundary"];
    let mut grid = Grid::new(1, header);
    grid.rows.extend(rows.iter().map(|(kernel, row)| {
        let boundary = [row.boundary_none, row.boundary_one, row.boundary_many].map(count).join(" / ");
        vec![
            code(&kernel.kernel.id),
            Cell::from(count(row.rays)),
            Cell::from(count(row.tests)),
            rate(row.false_miss_per_million, row.exact_hits),
            rate(row.false_hit_per_million, row.exact_misses),
            rate(row.leak_per_million, row.mesh_hits),
            rate(row.double_per_million, row.single_hits),
            Cell::from(boundary),
        ]
    }));
    grid.markdown()
}

pub(super) fn errors(rows: &[(&Figures, &AccuracyRow)]) -> String {
    let header = ["kernel", "ulp median", "ulp 99 %", "ulp greatest", "gross", "u, v 99 %", "u, v greatest"];
    let mut grid = Grid::new(1, header);
    grid.rows.extend(rows.iter().map(|(kernel, row)| {
        vec![
            code(&kernel.kernel.id),
            Cell::from(count(row.t_ulp_p50)),
            Cell::from(count(row.t_ulp_p99)),
            Cell::from(count(row.t_ulp_max)),
            rate(row.gross_per_million, row.agreed_hits),
            Cell::from(number(row.uv_error_p99, 2)),
            Cell::from(number(row.uv_error_max, 2)),
        ]
    }));
    grid.markdown()
}

fn rate(per_million: f64, of: u64) -> Cell {
    Cell::from(Rate::new(per_million, of).map_or(MISSING.to_owned(), |rate| format!("{rate} / {}", si(of as f64, 3))))
}
