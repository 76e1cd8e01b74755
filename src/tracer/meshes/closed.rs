//! Whether a mesh is closed, so that points are inside or outside.

use std::collections::HashMap;

use super::mesh::Mesh;

impl Mesh {
    /// Whether the mesh is closed: each edge belongs to an even number of triangles. Vertices are the same if their
    /// coordinates are, whatever their numbers. The orientation of triangles does not matter.
    ///
    /// A line then crosses the surface an even number of times, and points are inside or outside. A mesh that passes
    /// through itself may be closed too. A point that is inside twice counts as outside.
    ///
    /// ```
    /// use raylanes::geom::Triangle;
    /// use raylanes::tracer::Mesh;
    /// use glam::Vec3;
    ///
    /// let [o, x, y, z] = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    /// let faces = [[o, y, x], [o, z, y], [o, x, z], [x, y, z]].map(|[v0, v1, v2]| Triangle { v0, v1, v2 });
    /// assert!(Mesh::from_triangles(&faces)?.is_closed());
    /// assert!(!Mesh::from_triangles(&faces[..3])?.is_closed());
    /// # Ok::<(), raylanes::tracer::MeshError>(())
    /// ```
    pub fn is_closed(&self) -> bool {
        let mut edges = HashMap::<[[u32; 3]; 2], bool>::new();
        for triangle in self.iter() {
            // A negative zero is the same coordinate.
            let [a, b, c] = triangle.vertices().map(|vertex| (vertex + 0.0).to_array().map(f32::to_bits));
            for [from, to] in [[a, b], [b, c], [c, a]] {
                let is_odd = edges.entry(if from < to { [from, to] } else { [to, from] }).or_default();
                // An edge between equal vertices is no edge.
                *is_odd ^= from != to;
            }
        }
        !edges.values().any(|&is_odd| is_odd)
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::geom::Triangle;
    use crate::tracer::meshes::{Part, generator};

    #[test]
    fn built_in_meshes_are_closed_or_open_as_they_look() {
        for (name, expected) in [("sphere:1e3", true), ("terrain:1e3", false), ("square", false)] {
            let mesh = generator::Generator::parse(name, 1_000).unwrap().mesh();
            assert_eq!(mesh.is_closed(), expected, "{name}");
        }
    }

    #[test]
    fn vertices_are_the_same_if_their_coordinates_are() {
        let [o, x, y, z] = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let flipped = [[o, y, x], [-o, y, z], [o, x, z], [x, y, z]].map(|[v0, v1, v2]| Triangle { v0, v1, v2 });
        assert!(Mesh::from_triangles(&flipped).unwrap().is_closed());
        // A triangle of two vertices adds an edge twice.
        let part = vec![Part { first_triangle: 0, color: Vec3::ONE }];
        let folded = vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3], [1, 2, 2]];
        assert!(Mesh::new(vec![o, x, y, z], folded, part).unwrap().is_closed());
    }
}
