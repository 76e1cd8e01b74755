//! A square of two triangles: the floor of a scene.

use glam::Vec3;

use crate::tracer::meshes::{Mesh, Part};

/// From (0, 0, 0) to (1, 0, 1), facing up. In one triangle u and v increase with z and x, in the other they decrease
/// with them. So a checker with a whole number of squares continues across the diagonal.
pub(super) fn mesh() -> Mesh {
    let positions = vec![Vec3::ZERO, Vec3::Z, Vec3::new(1.0, 0.0, 1.0), Vec3::X];
    let parts = vec![Part { first_triangle: 0, color: Vec3::splat(0.8) }];
    Mesh::new(positions, vec![[0, 1, 3], [2, 3, 1]], parts).expect("a square is a valid mesh")
}
