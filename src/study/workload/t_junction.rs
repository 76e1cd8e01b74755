//! T-junctions: a vertex of two triangles in the middle of the edge of a third one.

use glam::Vec3;
use rand::RngExt;
use rand_pcg::Pcg64;

use super::triangle::{Grid, shuffled, turned, upright_ray};
use super::{RAYS_PER_SAMPLE, Sample, frame, in_cube};
use crate::geom::Triangle;

/// A triangle to the left of the edge from `a` to `b`, and two to its right, which meet at `middle`.
fn junction([a, b, middle, left, right]: [Vec3; 5], rng: &mut Pcg64) -> Vec<Triangle> {
    [[a, b, left], [b, middle, right], [middle, a, right]]
        .map(|[v0, v1, v2]| turned(Triangle { v0, v1, v2 }, rng))
        .to_vec()
}

/// A T-junction, and rays at the relative distance `gap` to its edge. Half of those with gap zero are on a grid: the
/// vertex is exactly on the edge, and so are the rays. Elsewhere the vertex is rounded to one side of the edge.
pub(super) fn t_junction(gap: f32, rng: &mut Pcg64) -> Sample<Triangle> {
    if gap == 0.0 && rng.random() {
        return on_grid(rng);
    }
    let plane = frame(rng);
    let corner = |x: f32, y: f32, rng: &mut Pcg64| plane * (Vec3::new(x, y, 0.0) + in_cube(rng, 0.2));
    let (a, b) = (corner(0.0, -1.0, rng), corner(0.0, 1.0, rng));
    let (left, right) = (corner(-1.0, 0.0, rng), corner(1.0, 0.0, rng));
    let middle = a + (b - a) * rng.random_range(0.25..0.75);
    let rays = (0..RAYS_PER_SAMPLE).map(|_| {
        let (at_middle, to_left) = (rng.random_bool(0.2), rng.random_bool(0.5));
        let on_edge = if at_middle { middle } else { a + (b - a) * rng.random_range(0.1..0.9) };
        // From the middle to the right runs the edge that the other two triangles share. It is not to be met.
        let apex = if at_middle | to_left { left } else { right };
        upright_ray(on_edge + (apex - on_edge) * gap, plane, rng)
    });
    let rays = rays.collect();
    Sample { rays, shapes: junction([a, b, middle, left, right], rng) }
}

fn on_grid(rng: &mut Pcg64) -> Sample<Triangle> {
    let grid = Grid::any(rng);
    let offset = Grid::COARSE.point(16, rng);
    let corner = |x: f32, y: f32, rng: &mut Pcg64| offset + Vec3::new(x, y, 0.0) + grid.point(2, rng);
    let (a, b) = (corner(0.0, -16.0, rng), corner(0.0, 16.0, rng));
    let (left, right) = (corner(-16.0, 0.0, rng), corner(16.0, 0.0, rng));
    // Eighths need three more digits, which f32 holds, also for the ray.
    let on_edge = |eighths: i32| a + (b - a) * (eighths as f32 / 8.0);
    let middle = rng.random_range(2..=6);
    let rays = (0..RAYS_PER_SAMPLE).map(|_| {
        let eighths = if rng.random_bool(0.2) { middle } else { rng.random_range(1..8) };
        grid.ray(on_edge(eighths), rng)
    });
    let rays = rays.collect();
    let shapes = junction([a, b, on_edge(middle), left, right], rng);
    shuffled(Sample { rays, shapes }, rng)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oracle::Exact;
    use crate::study::workload::rng;

    /// For each ray, how many triangles it exactly hits, and whether it hits one at an edge or a vertex.
    fn exact_hits(gap: f32, on_grid: bool) -> Vec<(usize, bool)> {
        let mut hits = Vec::new();
        for index in 0..400 {
            let sample = t_junction(gap, &mut rng(1, "", "", &[], index));
            // The rays of a grid have a component of size 1.
            if sample.rays[0].dir.abs().to_array().contains(&1.0) != on_grid {
                continue;
            }
            hits.extend(sample.rays.iter().map(|ray| {
                let truths: Vec<_> = sample.shapes.iter().map(|shape| shape.truth(ray)).collect();
                let boundary = truths.iter().any(|truth| truth.boundary);
                (truths.iter().filter(|truth| truth.hit).count(), boundary)
            }));
        }
        assert!(hits.len() > 2_000, "{} rays", hits.len());
        hits
    }

    #[test]
    fn a_vertex_on_an_edge_leaves_a_gap_only_where_it_is_rounded() {
        // On the grid, the large triangle and one or two of the small ones meet each ray at their edges.
        assert!(exact_hits(0.0, true).iter().all(|&(hits, boundary)| hits >= 2 && boundary));
        let rounded = exact_hits(0.0, false);
        let share =
            |hits: usize| rounded.iter().filter(|(count, _)| *count == hits).count() as f64 / rounded.len() as f64;
        assert!((0.01..0.2).contains(&share(0)), "{} of the rays pass through the gap", share(0));
        assert!((0.01..0.2).contains(&share(2)), "{} of the rays hit both sides", share(2));
        assert!(exact_hits(1e-3, false).iter().all(|&hits| hits == (1, false)));
    }
}
