//! The unit sphere: each face of an octahedron is divided into a triangular grid, and its points are normalised.

use glam::{DVec3, Vec3};

use crate::tracer::meshes::{Mesh, Part};

/// Each of the eight faces has `n` rows and thus `n²` triangles.
pub(super) fn triangles(n: u32) -> u32 {
    8 * n * n
}

/// The vertices lie on rings about the `y` axis: a pole, rings of 4, 8, … 4n (the equator) … 8, 4 vertices, a pole.
pub(super) fn mesh(n: u32) -> Mesh {
    let mut positions = Vec::new();
    let mut rings: Vec<Ring> = Vec::new();
    for row in 0..=2 * n {
        let quarter = row.min(2 * n - row);
        rings.push(Ring { first: positions.len() as u32, quarter });
        let y = f64::from(n) - f64::from(row);
        positions.extend((0..(4 * quarter).max(1)).map(|step| {
            let (z, x) = on_square(step, quarter);
            DVec3::new(x, y, z).normalize().as_vec3()
        }));
    }
    let mut triangles = Vec::new();
    for pair in rings.windows(2) {
        let upper_is_smaller = pair[0].quarter < pair[1].quarter;
        let (smaller, larger) = if upper_is_smaller { (&pair[0], &pair[1]) } else { (&pair[1], &pair[0]) };
        let mut add = |[a, b, c]: [u32; 3]| triangles.push(if upper_is_smaller { [a, b, c] } else { [a, c, b] });
        for side in 0..4 {
            for step in 0..=smaller.quarter {
                add([larger.vertex(side, step), larger.vertex(side, step + 1), smaller.vertex(side, step)]);
            }
            for step in 0..smaller.quarter {
                add([smaller.vertex(side, step), larger.vertex(side, step + 1), smaller.vertex(side, step + 1)]);
            }
        }
    }
    let parts = vec![Part { first_triangle: 0, color: Vec3::new(0.8, 0.55, 0.35) }];
    Mesh::new(positions, triangles, parts).expect("a sphere is a valid mesh")
}

/// The point after `step` steps around the square with corners `(±quarter, 0)` and `(0, ±quarter)`.
fn on_square(step: u32, quarter: u32) -> (f64, f64) {
    let side = step.checked_div(quarter).unwrap_or(0);
    let along = f64::from(step - side * quarter);
    let left = f64::from(quarter) - along;
    match side {
        0 => (left, along),
        1 => (-along, left),
        2 => (-left, -along),
        _ => (along, -left),
    }
}

/// The vertices at one height: four sides of `quarter` steps, or one vertex at a pole.
struct Ring {
    /// Number of its first vertex.
    first: u32,
    quarter: u32,
}

impl Ring {
    /// The vertex after `step` steps along this side.
    fn vertex(&self, side: u32, step: u32) -> u32 {
        self.first + (side * self.quarter + step) % (4 * self.quarter).max(1)
    }
}
