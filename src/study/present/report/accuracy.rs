//! Errors of every kernel on the workloads without severities: `generic` and `edge`.

use super::cells::code;
use crate::study::figures::{KernelFigures, MISSING, Rate, count, number, si};
use crate::study::present::grid::{Cell, Grid};
use crate::study::record::{AccuracyRow, Record};

/// The introduction to the section.
pub(super) const ACCURACY: &str = "\
## Accuracy

Hits are compared with an oracle in exact arithmetic. Twins give the same bits, so one row holds for every width of a \
kernel. A rate is the number of events per million; the number after the slash is its base. If no event was observed, \
the number in brackets is the 95 % bound: three events in the base.

- *false miss*: pairs of ray and primitive that exactly hit, strictly inside, and are reported as misses.
- *false hit*: pairs that exactly miss and are reported as hits.
- *leak*: rays that exactly hit a mesh, edges included, and are reported to miss it.
- *double hit*: rays that exactly hit one triangle, strictly inside, and no other, but are reported to hit several.
- *boundary*: rays that exactly hit a boundary, by the number of hits reported: none / one / more. A boundary is an \
edge or a vertex. For a quadric, it is a tangent point, a plane of its clip box or an end of the ray's interval.
- *ulp*: error of `t` where oracle and kernel both report a hit: its distance from the correctly rounded value, in \
representable numbers. Compare the 99th percentiles; the maximum is noise.
- *gross*: hits reported by both whose `t` is off by more than 1 %.
- *u, v*: absolute error of the surface parameters. For a box, of the exit distance.
- *point*: distance of the hit point, computed in `f32`, from the exact one, in sizes of the primitive: 99th \
percentile. Once from `origin + t·dir`, once from the barycentrics. The size is the longest edge or side.
- *height*: how far these points are off the exact surface, in the same unit.
- *normal*: angle between the tracer's normal for the hit and the exact normal: 99th percentile.
- *backward*: error of `t`, divided by the error that rounding the input to `f32` can cause: 99th percentile. A stable \
method stays below about 10, however hard the input.
- *hits itself*: rays that leave the hit and are reported to hit the same primitive again, in percent. They start \
where the tracer puts them (*offset*), or at `origin + t·dir` with a `t_min` of 1e-4 of the largest coordinate, of \
1e-4 of the length of the ray, or of 0.";

/// The names of the workloads without severities, in the order of the record.
pub(super) fn workloads(record: &Record) -> Vec<&str> {
    let mut workloads: Vec<&str> = Vec::new();
    for row in record.accuracy.iter().filter(|row| row.severity.is_none()) {
        if !workloads.contains(&row.workload.as_str()) {
            workloads.push(&row.workload);
        }
    }
    workloads
}

/// Rates of wrong answers on a workload.
pub(super) fn wrong_answers(rows: &[(&KernelFigures, &AccuracyRow)]) -> String {
    let header = ["kernel", "rays", "tests", "false miss", "false hit", "leak", "double hit", "boundary"];
    let mut grid = Grid::new(1, header);
    grid.rows.extend(rows.iter().map(|(kernel, row)| {
        let boundary = [row.boundary_none, row.boundary_one, row.boundary_many].map(count).join(" / ");
        vec![
            code(&kernel.method.id),
            Cell::from(count(row.rays)),
            Cell::from(count(row.tests)),
            rate(row.false_miss_per_million, row.exact_hits),
            rate(row.false_hit_per_million, row.exact_misses),
            rate(row.leak_per_million, row.mesh_hits),
            rate(row.double_hit_per_million, row.single_hits),
            Cell::from(boundary),
        ]
    }));
    grid.markdown()
}

/// Errors of `t`, `u` and `v` on a workload.
pub(super) fn errors(rows: &[(&KernelFigures, &AccuracyRow)]) -> String {
    let header = ["kernel", "ulp median", "ulp 99 %", "ulp max", "gross", "u, v 99 %", "u, v max"];
    let mut grid = Grid::new(1, header);
    grid.rows.extend(rows.iter().map(|(kernel, row)| {
        vec![
            code(&kernel.method.id),
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

/// Errors of points, normals and leaving rays.
pub(super) fn hits(rows: &[(&KernelFigures, &AccuracyRow)]) -> String {
    let header = [
        "kernel",
        "point, t",
        "point, u v",
        "height, t",
        "height, u v",
        "normal, rad",
        "backward",
        "hits itself: offset, %",
        "1e-4 scene, %",
        "1e-4 t, %",
        "no epsilon, %",
    ];
    let mut grid = Grid::new(1, header);
    grid.rows.extend(rows.iter().map(|(kernel, row)| {
        let errors = &row.hit_errors;
        let figure = |figure: Option<f64>| Cell::from(figure.map_or(MISSING.to_owned(), |figure| number(figure, 2)));
        let percent = |rate: f64| figure(Rate::new(rate, errors.leaving_rays).map(|rate| rate.per_million() / 1e4));
        vec![
            code(&kernel.method.id),
            figure(errors.ray_point_size_p99),
            figure(errors.uv_point_size_p99),
            figure(errors.ray_height_size_p99),
            figure(errors.uv_height_size_p99),
            figure(errors.normal_error_p99),
            figure(errors.t_backward_p99),
            percent(errors.own_hit_offset_per_million),
            percent(errors.own_hit_scene_epsilon_per_million),
            percent(errors.own_hit_t_epsilon_per_million),
            percent(errors.own_hit_no_epsilon_per_million),
        ]
    }));
    grid.markdown()
}

/// A rate and its base.
fn rate(per_million: f64, of: u64) -> Cell {
    Cell::from(Rate::new(per_million, of).map_or(MISSING.to_owned(), |rate| format!("{rate} / {}", si(of as f64, 3))))
}
