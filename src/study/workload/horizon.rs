//! A ground of many triangles, seen from far away and from just above it.

use glam::Vec2;
use rand::RngExt;
use rand_pcg::Pcg64;

use super::triangle::turned;
use super::{RAYS_PER_SAMPLE, Sample, frame, in_cube, in_disc, ray_from, sign};
use crate::geom::Triangle;

/// A flat ground of cells of unit size, and rays from about one cell above it, `distance` cells away. The ground is
/// parallel to no axis. On one that is, kernels err no more often from farther away.
pub(super) fn horizon(distance: f32, rng: &mut Pcg64) -> Sample<Triangle> {
    let plane = frame(rng);
    let middle = in_cube(rng, 1.0);
    let at = |Vec2 { x, y }: Vec2| middle + plane.x_axis * x + plane.y_axis * y;
    let view = in_disc(rng).normalize();
    // A rounding error of the distance shifts a hit along the ground by the error over the angle. The triangle there
    // may catch a ray that its own triangle loses, so it must be part of the mesh.
    // With twice this reach, the rates are the same.
    let reach = 1.0 + 10.0 * (distance / 1e4) * (distance / 1e4);
    let shapes = strip(view, reach).into_iter().map(|corners| {
        let [v0, v1, v2] = corners.map(at);
        turned(Triangle { v0, v1, v2 }, rng)
    });
    let shapes = shapes.collect();
    let above = plane.z_axis * sign(rng);
    let rays = (0..RAYS_PER_SAMPLE).map(|_| {
        let target = at(target(rng));
        let along = view + view.perp() * rng.random_range(-0.02..0.02);
        let back = plane.x_axis * along.x + plane.y_axis * along.y;
        ray_from(target - back * distance + above * rng.random_range(0.75..1.5), target, rng)
    });
    Sample { rays: rays.collect(), shapes }
}

/// The triangles of a grid along the line through the origin in the direction `view`, up to the distance `reach`.
fn strip(view: Vec2, reach: f32) -> Vec<[Vec2; 3]> {
    let end = reach as i32 + 1;
    let cells = (-end..end).flat_map(|x| (-end..end).map(move |y| Vec2::new(x as f32, y as f32)));
    let near = cells.filter(|cell| {
        let middle = *cell + Vec2::splat(0.5);
        middle.dot(view).abs() <= reach && middle.perp_dot(view).abs() <= 1.25
    });
    let halves = near.flat_map(|corner| {
        let [right, up, far] = [Vec2::X, Vec2::Y, Vec2::ONE].map(|step| corner + step);
        [[corner, right, far], [corner, far, up]]
    });
    halves.collect()
}

/// The vertex at the origin of the grid, a point on one of its edges, or a point in one of its triangles.
fn target(rng: &mut Pcg64) -> Vec2 {
    let [x, y]: [f32; 2] = [0; 2].map(|_| rng.random_range(-0.5..0.5));
    match rng.random_range(0..6) {
        0 | 1 => Vec2::ZERO,
        2 => Vec2::new(x, 0.0),
        3 => Vec2::new(x, x),
        _ => Vec2::new(x, y),
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::oracle::Exact;
    use crate::study::workload::rng;

    #[test]
    fn rays_hit_the_ground_once_at_the_angle_of_their_distance() {
        for distance in [1e1, 1e2, 1e3, 1e4] {
            let mut missed = 0;
            for index in 0..100 {
                let Sample { shapes, rays } = horizon(distance, &mut rng(1, "", "", &[], index));
                for ray in &rays {
                    let truths: Vec<_> = shapes.iter().map(|shape| (shape, shape.truth(ray))).collect();
                    let strict = truths.iter().all(|(_, truth)| !truth.boundary);
                    let mut hit = truths.iter().filter(|(_, truth)| truth.hit);
                    let Some((shape, truth)) = hit.next() else {
                        missed += 1;
                        continue;
                    };
                    assert!(!strict || hit.next().is_none(), "a flat ground is hit twice");
                    let [v0, v1, v2] = shape.vertices().map(Vec3::as_dvec3);
                    let (normal, dir) = ((v1 - v0).cross(v2 - v0).normalize(), ray.dir.as_dvec3());
                    let angle = normal.dot(dir).abs() / dir.length();
                    assert!((0.7..1.6).contains(&(angle * f64::from(distance))), "{angle} at {distance}");
                    let length = f64::from(truth.t) * dir.length() / f64::from(distance);
                    assert!((0.85..1.15).contains(&length), "{length} times {distance}");
                }
            }
            // Rounding its origin moves a ray along the ground, at last by some cells.
            assert!(missed <= 2, "{missed} of 1,600 rays leave the strip at {distance}");
        }
    }
}
