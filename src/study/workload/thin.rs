//! Triangles with hits that may lie outside the triangle's own box: slivers, and triangles with flat boxes.

use glam::{Mat3, Vec3};
use rand::RngExt;
use rand_pcg::Pcg64;

use super::triangle::{inside_or_past, regular, sliver};
use super::{Sample, frame, grazing_ray, in_cube};
use crate::geom::Triangle;

/// Slivers in any position, and rays at `angle` to them.
pub(super) fn grazed_sliver(angle: f32, rng: &mut Pcg64) -> Sample<Triangle> {
    let plane = frame(rng);
    Sample::of(sliver(plane, 100.0, rng), rng, |shape, rng| {
        let distance = rng.random_range(0.5..4.0);
        grazing_ray(inside_or_past(shape, rng), plane, angle, distance, rng)
    })
}

/// A triangle nearly across an axis, and rays at a small angle to it. Its box is about `thickness` thick.
pub(super) fn flat(thickness: f32, rng: &mut Pcg64) -> Sample<Triangle> {
    let units = [Vec3::X, Vec3::Y, Vec3::Z];
    let first = rng.random_range(0..3);
    let [x, y, z] = [0, 1, 2].map(|axis| units[(first + axis) % 3]);
    let plane = Mat3::from_cols(x, y, z);
    let middle = in_cube(rng, 1.0);
    let level = regular(plane, 1.0, rng);
    let raised = |vertex: Vec3| vertex + middle + z * (vertex.dot(x) * 0.5 * thickness);
    let [v0, v1, v2] = level.vertices().map(raised);
    Sample::of(Triangle { v0, v1, v2 }, rng, |shape, rng| {
        let (angle, distance) = (rng.random_range(0.2..1.0), rng.random_range(0.5..4.0));
        grazing_ray(inside_or_past(shape, rng), plane, angle, distance, rng)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oracle::Exact;
    use crate::study::workload::rng;

    #[test]
    fn boxes_are_as_thin_as_they_say_and_many_rays_hit() {
        for thickness in [1e-1, 1e-3, 1e-5, 0.0] {
            let mut hits = 0;
            for index in 0..200 {
                let Sample { shapes, rays } = flat(thickness, &mut rng(1, "", "", &[], index));
                let extent = shapes[0].bounds().extent();
                let share = extent.min_element() / extent.max_element();
                assert!(share <= thickness && share >= 0.2 * thickness, "{share} and not {thickness}");
                hits += rays.iter().filter(|ray| shapes[0].truth(ray).hit).count();
            }
            assert!((1_600..2_400).contains(&hits), "{hits} of 3,200 rays hit");
        }
    }

    #[test]
    fn slivers_are_grazed() {
        for angle in [1e-1, 1e-3] {
            for index in 0..100 {
                let Sample { shapes, rays } = grazed_sliver(angle, &mut rng(1, "", "", &[], index));
                let [v0, v1, v2] = shapes[0].vertices().map(Vec3::as_dvec3);
                let normal = (v1 - v0).cross(v2 - v0).normalize();
                for dir in rays.iter().map(|ray| ray.dir.as_dvec3().normalize()) {
                    let sine = normal.dot(dir).abs() / f64::from(angle);
                    assert!((0.9..1.1).contains(&sine), "{sine} times {angle}");
                }
            }
        }
    }
}
