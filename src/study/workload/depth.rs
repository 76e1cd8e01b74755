//! Two triangles that are folded together, one just behind the other.

use glam::{Mat3, Vec2, Vec3};
use rand::RngExt;
use rand_pcg::Pcg64;

use super::triangle::{steep_ray, turned};
use super::{RAYS_PER_SAMPLE, Sample, frame, in_cube, in_square, sign};
use crate::geom::Triangle;

/// Two triangles that share an edge, at a small `angle` to each other, and rays that hit both near that edge, from
/// either side.
pub(super) fn fold(angle: f32, rng: &mut Pcg64) -> Sample<Triangle> {
    let plane = frame(rng);
    let middle = in_cube(rng, 1.0);
    let at = |x: f32, y: f32, z: f32| middle + plane * Vec3::new(x, y, z);
    let mut apex = |slope: f32| {
        let Vec2 { x, y } = in_square(rng, 0.25);
        at(1.0 + x, y, (1.0 + x) * slope)
    };
    let (upper, lower) = (apex(angle), apex(0.0));
    let (a, b) = (at(0.0, -1.0, 0.0), at(0.0, 1.0, 0.0));
    let rays = (0..RAYS_PER_SAMPLE).map(|_| {
        let target = at(rng.random_range(0.01..0.3), rng.random_range(-0.5..0.5), 0.0);
        let towards = Mat3::from_cols(plane.x_axis, plane.y_axis, plane.z_axis * sign(rng));
        steep_ray(target, towards, rng)
    });
    let rays = rays.collect();
    let mut shapes = vec![Triangle { v0: a, v1: b, v2: upper }, Triangle { v0: b, v1: a, v2: lower }];
    // Between equal `t` the lower number wins, so either triangle may have it.
    if rng.random() {
        shapes.reverse();
    }
    Sample { rays, shapes: shapes.into_iter().map(|shape| turned(shape, rng)).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oracle::Exact;
    use crate::study::workload::rng;

    #[test]
    fn rays_hit_both_sides_of_the_fold_at_distances_of_its_angle() {
        for angle in [1e-2, 1e-4, 1e-6] {
            let mut first = [0; 2];
            for index in 0..100 {
                let Sample { shapes, rays } = fold(angle, &mut rng(1, "", "", &[], index));
                for ray in &rays {
                    let truths = [0, 1].map(|side: usize| shapes[side].truth(ray));
                    assert!(truths.iter().all(|truth| truth.hit && !truth.boundary), "{truths:?}");
                    let apart = (truths[0].t - truths[1].t) * ray.dir.length();
                    // A steep ray is up to 3.3 times as long as the distance. Rounding adds an ulp of it.
                    assert!(apart.abs() < 0.35 * 3.4 * angle + 2e-6, "{apart} apart at {angle}");
                    if apart != 0.0 {
                        first[usize::from(apart > 0.0)] += 1;
                    }
                }
            }
            let both = if angle < 1e-5 { 100 } else { 600 };
            assert!(first.iter().all(|&count| count > both), "{first:?} rays hit one or the other first");
        }
    }
}
