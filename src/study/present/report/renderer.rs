//! Hits as a renderer meets them: where the points lie, and whether new rays leave. A section of the appendix, and a
//! line on the first page.

use super::cells::code;
use crate::study::figures::{Group, KernelFigures, MISSING, Rate, number, optional};
use crate::study::present::grid::{Cell, Grid};
use crate::study::present::verdict::place;
use crate::study::record::{AccuracyRow, HitErrors, Record};

/// The section of the appendix; `None` if no kernel has such figures.
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
    let farthest = |error| Cell::from(farthest(record, kernel, error).unwrap_or(MISSING.to_owned()));
    let again = |rate| Cell::from(again(record, kernel, rate));
    measured(record, kernel).next().map(|_| {
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

/// The same for the kernel of a group that is recommended, and for the fastest one, in a line of Markdown. `None` for
/// boxes, and if both are one kernel.
pub(super) fn line(record: &Record, group: &Group) -> Option<String> {
    let (best, fastest) = (*group.safest().first()?, *group.fastest("8x1").first()?);
    if group.shape == "aabb" || best.name == fastest.name {
        return None;
    }
    let both = [best, fastest];
    let points = both.map(|kernel| farthest(record, kernel, |errors| errors.ray_point_size_p99));
    let [Some(right), Some(other)] = points else { return None };
    let again = |rate: fn(&HitErrors) -> f64| both.map(|kernel| again(record, kernel, rate));
    let [offset, none] = [
        |errors: &HitErrors| errors.own_hit_offset_per_million,
        |errors: &HitErrors| errors.own_hit_no_epsilon_per_million,
    ]
    .map(again);
    Some(format!(
        "- {}, points: 99 % of the points of `{}` are nearer to the exact one than {right} times the size of the \
         primitive, in the hardest step of all regimes, and those of `{}` than {other}. Of the rays that leave these \
         points, {} % and {} % hit the same primitive again if they start off the surface by the tracer's error bound, \
         and {} % and {} % if they start at the point.",
        group.title, best.name, fastest.name, offset[0], offset[1], none[0], none[1]
    ))
}

/// The rows in which hits were measured.
fn measured<'a>(record: &'a Record, kernel: &KernelFigures) -> impl Iterator<Item = &'a AccuracyRow> {
    let id = kernel.method.id.clone();
    record.accuracy.iter().filter(move |row| row.id == id && row.hit_errors.measured_hits > 0)
}

/// The largest error of all rows, and in which of them.
fn farthest(record: &Record, kernel: &KernelFigures, error: fn(&HitErrors) -> Option<f64>) -> Option<String> {
    let errors = measured(record, kernel).filter_map(|row| Some((error(&row.hit_errors)?, row)));
    let (error, row) = errors.max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(format!("{} ({})", number(error, 2), place(row)))
}

/// The percentage of rays that hit again, over all rows.
fn again(record: &Record, kernel: &KernelFigures, rate: fn(&HitErrors) -> f64) -> String {
    let rates =
        measured(record, kernel).filter_map(|row| Rate::new(rate(&row.hit_errors), row.hit_errors.leaving_rays));
    optional(Rate::sum(rates).map(|rate| rate.per_million() / 1e4), 2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::figures::groups;
    use crate::study::tests::fixture::record_of;

    #[test]
    fn the_farthest_point_counts_and_rays_are_pooled() {
        let mut record = record_of(&["triangle/a".into(), "aabb/b".into(), "triangle/c".into()]);
        for row in record.accuracy.iter_mut().filter(|row| row.id != "aabb/b") {
            row.hit_errors = HitErrors::default();
        }
        let text = |record: &Record| {
            let groups = groups(record);
            section(record, &groups.iter().collect::<Vec<_>>())
        };
        assert_eq!(text(&record), None, "nothing was measured");
        for (id, times) in [("triangle/a", 1.0), ("triangle/c", 8.0)] {
            let mut rows = record.accuracy.iter_mut().filter(|row| row.id == id && row.workload == "grazing");
            for (far, leaving, again) in [(0.5, 1_000, 30_000.0), (0.25, 3_000, 0.0)] {
                rows.next().unwrap().hit_errors = HitErrors {
                    measured_hits: 1,
                    ray_point_size_p99: Some(times * far),
                    leaving_rays: leaving,
                    own_hit_offset_per_million: times * again,
                    ..HitErrors::default()
                };
            }
        }
        let text = text(&record).unwrap();
        // 30 of 4,000 rays.
        assert!(text.contains("| `triangle/a` | 0.50 (grazing 0.1) | – | 0.75 | 0 | 0 | 0 |"), "{text}");
        assert!(!text.contains("aabb"), "{text}");
        // `a` is faster, and `c` is right more often.
        let line = line(&record, &groups(&record)[0]).unwrap();
        let points = "of `c` are nearer to the exact one than 4.0 (grazing 0.1) times the size of the primitive";
        assert!(line.contains(points) && line.contains("and those of `a` than 0.50 (grazing 0.1)."), "{line}");
        assert!(line.contains("points, 6.0 % and 0.75 % hit"), "{line}");
    }
}
