//! Traits of the instances' transforms.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::Trait;
use crate::study::figures::number;
use crate::tracer::World;

/// The limit of the condition number of a transform. Regime: instance of triangle, shear, where baked triangles fail
/// first. Rays transformed in `f32` fail from 10,000 on.
const MAX_CONDITION: f64 = 1e2;

/// The greatest condition number among the instances.
pub(super) fn condition(world: &World) -> Trait {
    let instances = world.instances();
    let conditions =
        instances.par_iter().map(|placement| condition_number(placement.object_to_world.matrix3.as_dmat3()));
    let greatest = conditions.reduce(|| 1.0, f64::max);
    Trait::above(
        MAX_CONDITION,
        "condition of transforms",
        greatest,
        format!("the greatest condition number of a transform is {}", number(greatest, 2)),
        "transformed rays are turned by rounding, and baked triangles become slivers",
    )
}

/// The ratio of the greatest and the least singular value. A world has only matrices with an inverse.
fn condition_number(matrix: DMat3) -> f64 {
    // As the root of the least eigenvalue, the least singular value would have only half of the digits.
    greatest_singular_value(matrix) * greatest_singular_value(matrix.inverse())
}

/// The root of the greatest eigenvalue of the matrix times its transpose, in closed form: O. K. Smith, "Eigenvalues of
/// a symmetric 3 × 3 matrix", 1961.
fn greatest_singular_value(matrix: DMat3) -> f64 {
    let square = matrix.transpose() * matrix;
    let mean = (square.x_axis.x + square.y_axis.y + square.z_axis.z) / 3.0;
    let rest = square - DMat3::from_diagonal(DVec3::splat(mean));
    let spread =
        ((rest.x_axis.length_squared() + rest.y_axis.length_squared() + rest.z_axis.length_squared()) / 6.0).sqrt();
    if spread == 0.0 {
        return mean.sqrt();
    }
    let angle = ((rest * (1.0 / spread)).determinant() / 2.0).clamp(-1.0, 1.0).acos() / 3.0;
    (mean + 2.0 * spread * angle.cos()).sqrt()
}

#[cfg(test)]
mod tests {
    use glam::{Affine3, Mat3, Vec3};

    use super::*;
    use crate::geom::Quadric;
    use crate::tracer::{Geometry, Placement};

    #[test]
    fn condition_numbers_do_not_depend_on_rotation_or_scale() {
        let turn =
            |x: f64, y: f64, z: f64| DMat3::from_rotation_x(x) * DMat3::from_rotation_y(y) * DMat3::from_rotation_z(z);
        let (before, after) = (turn(0.3, -1.1, 2.0), turn(-0.7, 0.4, 1.3));
        for scales in
            [[1.0, 1.0, 1.0], [2.0, 2.0, 1.0], [3.0, 2.0, 2.0], [3.0, -2.0, 1.0], [1e3, 1.0, 1e-4], [1.0, 1e-7, 1.0]]
        {
            let expected = scales.map(f64::abs).into_iter().fold(0.0, f64::max)
                / scales.map(f64::abs).into_iter().fold(f64::MAX, f64::min);
            for size in [1.0, 1000.0, 1e-20] {
                let matrix = before * DMat3::from_diagonal(DVec3::from(scales) * size) * after;
                let condition = condition_number(matrix);
                assert!((condition / expected - 1.0).abs() < 1e-7, "{scales:?} · {size}: {condition}");
            }
        }
        // The singular values of this shear are the golden ratio and its inverse.
        let shear = DMat3::from_cols(DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Z);
        assert!((condition_number(before * shear) - (3.0 + 5f64.sqrt()) / 2.0).abs() < 1e-12);
    }

    #[test]
    fn the_worst_instance_decides() {
        let sphere = Geometry::from(Quadric::sphere(1.0));
        let decides = |matrix3: Mat3| {
            let placements =
                [matrix3, Mat3::IDENTITY].map(|matrix3| Placement::new(0, Affine3 { matrix3, translation: Vec3::ONE }));
            condition(&World::new(vec![sphere.clone()], placements.into()).unwrap()).decides
        };
        let turn = Mat3::from_rotation_x(0.5) * Mat3::from_rotation_y(0.6);
        let sheared = |factor: f32| Mat3::from_cols(Vec3::X, Vec3::new(factor, 1.0, 0.0), Vec3::Z);
        for size in [1.0, 1000.0] {
            assert!(!decides(turn * size) && !decides(turn * sheared(2.0) * turn * size));
            // The condition number is about the square of the factor.
            assert!(decides(turn * sheared(32.0) * turn * size));
        }
    }
}
