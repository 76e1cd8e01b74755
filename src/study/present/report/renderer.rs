//! The section of the first page on hits as a renderer meets them: where the points lie, and whether new rays leave.

use super::cells::code;
use crate::study::figures::{Group, KernelFigures, MISSING, Rate, number, optional};
use crate::study::present::grid::{Cell, Grid};
use crate::study::present::verdict::place;
use crate::study::record::{HitErrors, Record};

/// The section; `None` if no kernel has such figures.
pub(super) fn section(record: &Record, groups: &[&Group]) -> Option<String> {
    let mut grid = Grid::new(
        1,
        [
            "kernel",
            "point from t, sizes",
            "point from u and v, sizes",
            "hits itself: offset, %",
            "t_min 1e-4 of the scene, %",
            "t_min 1e-4 of t, %",
            "no offset, %",
        ],
    );
    // Boxes have no surface that is shaded.
    for kernel in groups.iter().filter(|group| group.shape != "aabb").flat_map(|group| &group.kernels) {
        grid.rows.extend(row(record, kernel));
    }
    (!grid.rows.is_empty()).then(|| {
        format!(
            "## Points, and rays that start there\n\nA *point* is where a kernel says that a ray hits. The table gives \
             its distance from the exact point in the hardest step of all regimes: 99 % of the points are nearer. The \
             unit is the size of the primitive, which is the longest edge of a triangle. `t` in units in the last \
             place does not tell this: at a grazing angle, thousands of them move a point by little.\n\n\
             *Hits itself*: rays that leave the surface from such a point, and are reported to hit it again. They \
             start off the surface by the tracer's error bound (*offset*), or at the point with a `t_min`, relative to \
             the largest coordinate or to the length of the ray before, or there with a `t_min` of 0. A `t_min` also \
             hides what is nearer. All workloads count together.\n\n{}",
            grid.markdown()
        )
    })
}

/// The figures of one kernel; `None` if none of its hits was measured.
fn row(record: &Record, kernel: &KernelFigures) -> Option<Vec<Cell>> {
    let rows: Vec<_> =
        record.accuracy.iter().filter(|row| row.id == kernel.method.id && row.hit_errors.measured_hits > 0).collect();
    let farthest = |error: fn(&HitErrors) -> Option<f64>| {
        let errors = rows.iter().filter_map(|row| Some((error(&row.hit_errors)?, row)));
        let worst = errors.max_by(|a, b| a.0.total_cmp(&b.0));
        Cell::from(worst.map_or(MISSING.to_owned(), |(error, row)| format!("{} ({})", number(error, 2), place(row))))
    };
    let again = |rate: fn(&HitErrors) -> f64| {
        let rates = rows.iter().filter_map(|row| Rate::new(rate(&row.hit_errors), row.hit_errors.leaving_rays));
        Cell::from(optional(Rate::sum(rates).map(|rate| rate.per_million() / 1e4), 2))
    };
    (!rows.is_empty()).then(|| {
        vec![
            code(&kernel.method.id),
            farthest(|errors| errors.ray_point_size_p99),
            farthest(|errors| errors.uv_point_size_p99),
            again(|errors| errors.own_hit_offset_per_million),
            again(|errors| errors.own_hit_scene_epsilon_per_million),
            again(|errors| errors.own_hit_t_epsilon_per_million),
            again(|errors| errors.own_hit_no_epsilon_per_million),
        ]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::figures::groups;
    use crate::study::tests::fixture::record_of;

    #[test]
    fn the_farthest_point_counts_and_rays_are_pooled() {
        let mut record = record_of(&["triangle/a".into(), "aabb/b".into()]);
        for row in record.accuracy.iter_mut().filter(|row| row.id == "triangle/a") {
            row.hit_errors = HitErrors::default();
        }
        let text = |record: &Record| {
            let groups = groups(record);
            section(record, &groups.iter().collect::<Vec<_>>())
        };
        assert_eq!(text(&record), None, "nothing was measured");
        let mut rows = record.accuracy.iter_mut().filter(|row| row.workload == "grazing");
        for (far, leaving, again) in [(0.5, 1_000, 30_000.0), (0.25, 3_000, 0.0)] {
            rows.next().unwrap().hit_errors = HitErrors {
                measured_hits: 1,
                ray_point_size_p99: Some(far),
                leaving_rays: leaving,
                own_hit_offset_per_million: again,
                ..HitErrors::default()
            };
        }
        let text = text(&record).unwrap();
        // 30 of 4,000 rays.
        assert!(text.contains("| `triangle/a` | 0.50 (grazing 0.1) | – | 0.75 | 0 | 0 | 0 |"), "{text}");
        assert!(!text.contains("aabb"), "{text}");
    }
}
