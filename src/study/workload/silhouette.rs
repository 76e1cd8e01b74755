//! Closed meshes seen from outside, and rays close to their silhouettes, where a front meets a back.
//!
//! A ray past a silhouette may miss both triangles, so a miss is no leak. And a ray that loses the front still hits the
//! back, which no count of leaks sees. But it then hits an odd number of triangles. No ray that starts outside does.

use glam::Vec3;
use rand::RngExt;
use rand_pcg::Pcg64;

use super::triangle::{Grid, shuffled, turned};
use super::{RAYS_PER_SAMPLE, Sample, direction, frame, in_cube, ray_from, sign, whole};
use crate::geom::{Ray, Triangle};

/// The corners of an octahedron, each opposite to the next one.
const CORNERS: [Vec3; 6] = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];

/// Its triangles, counter-clockwise as seen from outside.
const FACES: [[usize; 3]; 8] = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];

/// An edge of the mesh, and the third corners of its two triangles.
struct Edge {
    ends: [Vec3; 2],
    apexes: [Vec3; 2],
}

impl Edge {
    /// The edge between two corners that are not opposite to each other.
    fn random(corners: &[Vec3; 6], rng: &mut Pcg64) -> Self {
        let first = rng.random_range(0..3);
        let mut corner = |axis: usize| corners[axis % 3 * 2 + rng.random_range(0..2)];
        let ends = [corner(first), corner(first + 1)];
        let third = (first + 2) % 3 * 2;
        Self { ends, apexes: [corners[third], corners[third + 1]] }
    }

    /// Whether one of its triangles shows its front in this direction, and the other one its back.
    fn is_silhouette(&self, dir: Vec3) -> bool {
        let [a, b] = self.ends.map(Vec3::as_dvec3);
        let across = (b - a).cross(dir.as_dvec3());
        let [p, q] = self.apexes.map(|apex| across.dot(apex.as_dvec3() - a));
        p * q > 0.0
    }

    fn point(&self, along: f32) -> Vec3 {
        self.ends[0] + (self.ends[1] - self.ends[0]) * along
    }
}

fn mesh(corners: &[Vec3; 6], rng: &mut Pcg64) -> Vec<Triangle> {
    let face = |[a, b, c]: [usize; 3]| Triangle { v0: corners[a], v1: corners[b], v2: corners[c] };
    FACES.iter().map(|&corners| turned(face(corners), rng)).collect()
}

/// A closed mesh of eight triangles, and rays at the distance `gap` to its silhouette, on both sides of it. Half of
/// those with gap zero are on a grid, and meet the silhouette exactly.
pub(super) fn silhouette(gap: f32, rng: &mut Pcg64) -> Sample<Triangle> {
    if gap == 0.0 && rng.random() {
        return on_grid(rng);
    }
    let plane = frame(rng);
    let corners = CORNERS.map(|corner| plane * (corner + in_cube(rng, 0.25)));
    let ray = |rng: &mut Pcg64| {
        let (edge, away) = loop {
            let (edge, away) = (Edge::random(&corners, rng), direction(rng));
            if edge.is_silhouette(away) {
                break (edge, away);
            }
        };
        let along = if rng.random_bool(0.2) { 0.0 } else { rng.random_range(0.0..1.0) };
        let past = (edge.ends[1] - edge.ends[0]).cross(away).normalize() * (sign(rng) * gap);
        let target = edge.point(along) + past;
        ray_from(target + away * rng.random_range(4.0..8.0), target, rng)
    };
    let rays = (0..RAYS_PER_SAMPLE).map(|_| ray(rng)).collect();
    Sample { rays, shapes: mesh(&corners, rng) }
}

fn on_grid(rng: &mut Pcg64) -> Sample<Triangle> {
    // On the small grid, rays also run along edges and in the planes of triangles, at slopes that `f32` must round.
    let small = rng.random();
    let (grid, size, jitter) = if small { (Grid::COARSE, 4.0, 1) } else { (Grid::any(rng), 8.0, 2) };
    let from_above = |target: Vec3, rng: &mut Pcg64| {
        if small {
            let dir = Vec3::new(whole(rng, 2), whole(rng, 2), -3.0);
            Ray::new(target - dir * rng.random_range(8..=32) as f32, dir)
        } else {
            grid.ray_from(32, target, rng)
        }
    };
    let offset = Grid::COARSE.point(16, rng);
    let corners = CORNERS.map(|corner| offset + corner * size + grid.point(jitter, rng));
    let ray = |rng: &mut Pcg64| -> Ray<f32> {
        loop {
            let edge = Edge::random(&corners, rng);
            let along = if rng.random_bool(0.2) { 0.0 } else { rng.random_range(1..8) as f32 / 8.0 };
            let ray = from_above(edge.point(along), rng);
            if edge.is_silhouette(ray.dir) {
                return ray;
            }
        }
    };
    let rays = (0..RAYS_PER_SAMPLE).map(|_| ray(rng)).collect();
    shuffled(Sample { rays, shapes: mesh(&corners, rng) }, rng)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oracle::Exact;
    use crate::study::workload::rng;

    #[test]
    fn rays_exactly_cross_the_mesh_an_even_number_of_times_and_pass_it_on_both_sides() {
        for gap in [1e-3, 1e-6, 0.0] {
            // Rays beside every edge, by how many triangles they hit. Rays that meet an edge are the last kind.
            let mut kinds = [0; 5];
            for index in 0..400 {
                let sample = silhouette(gap, &mut rng(1, "", "", &[], index));
                for ray in &sample.rays {
                    let line = Ray { t_min: f32::NEG_INFINITY, ..*ray };
                    let truths: Vec<_> = sample.shapes.iter().map(|shape| shape.truth(ray)).collect();
                    let of_line: Vec<_> = sample.shapes.iter().map(|shape| shape.truth(&line)).collect();
                    assert_eq!(truths, of_line, "the ray must start outside");
                    let hits = truths.iter().filter(|truth| truth.hit).count();
                    let at_edge = truths.iter().any(|truth| truth.boundary);
                    assert!(at_edge || hits.is_multiple_of(2), "{hits} hits");
                    kinds[if at_edge { 4 } else { hits.min(3) }] += 1;
                }
            }
            let [past, _, through, _, at_edge] = kinds;
            // Half of the rays with gap zero are on a grid.
            let expected = if gap == 0.0 { 2_000..4_200 } else { 0..10 };
            assert!(expected.contains(&at_edge), "{at_edge} rays meet an edge, gap {gap}");
            assert!((1_000..4_000).contains(&past) && (1_000..4_000).contains(&through), "{kinds:?}, gap {gap}");
        }
    }
}
