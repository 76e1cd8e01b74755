//! A triangle mesh: shared vertices, one colour per range of triangles, and if wanted, normals and texture coordinates.

use glam::{Vec2, Vec3};

use super::corner_values::CornerValues;
use crate::geom::{Aabb, Triangle};

/// Colour of triangles whose file gives them none: light grey.
pub(super) const DEFAULT_COLOR: Vec3 = Vec3::splat(0.8);

/// Triangles that share vertices. Every mesh is valid: [`Mesh::new`] lists the conditions.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    pub(super) positions: Vec<Vec3>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) parts: Vec<Part>,
    /// In a box of its own, so that a mesh without them hardly grows.
    pub(super) normals: Option<Box<CornerValues<Vec3>>>,
    pub(super) texture_coordinates: Option<Box<CornerValues<Vec2>>>,
}

/// A range of triangles of one colour. It ends before the first triangle of the next part, or with the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Number of its first triangle.
    pub first_triangle: u32,
    /// Diffuse colour: linear red, green and blue from 0 to 1.
    pub color: Vec3,
}

/// Why [`Mesh::new`] refuses its arguments. Triangles, vertices and parts are counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// There are no triangles.
    #[error("no triangles")]
    NoTriangles,
    /// There are more than [`Mesh::MAX_TRIANGLES`] triangles.
    #[error("{0} triangles, but at most {max} are possible", max = Mesh::MAX_TRIANGLES)]
    TooManyTriangles(usize),
    /// A triangle refers to a vertex that does not exist.
    #[error("triangle {0} refers to a vertex that does not exist")]
    MissingVertex(usize),
    /// A coordinate is NaN or infinite.
    #[error("vertex {0} is not finite")]
    NotFinite(usize),
    /// The first part must begin at triangle 0. Each part must begin after the one before and hold at least one
    /// triangle. Colours must be from 0 to 1.
    #[error("part {0} is empty, out of order, or has a colour outside 0 to 1")]
    BadPart(usize),
    /// There must be three indices of values for each triangle.
    #[error("{what} of {count} triangles for a mesh of {triangles}")]
    WrongCorners {
        /// `normals` or `texture coordinates`.
        what: &'static str,
        /// Number of triangles that have indices.
        count: usize,
        /// Number of triangles in the mesh.
        triangles: usize,
    },
    /// A triangle refers to a normal or texture coordinate that does not exist.
    #[error("triangle {triangle} refers to {what} that do not exist")]
    MissingValue {
        /// `normals` or `texture coordinates`.
        what: &'static str,
        /// The triangle.
        triangle: usize,
    },
    /// A normal or texture coordinate is NaN or infinite.
    #[error("number {number} of the {what} is not finite")]
    ValueNotFinite {
        /// `normals` or `texture coordinates`.
        what: &'static str,
        /// Its number.
        number: usize,
    },
}

impl Mesh {
    /// The largest number of triangles in a mesh. The primitive number `u32::MAX` is reserved: it means a miss.
    pub const MAX_TRIANGLES: usize = u32::MAX as usize - 1;

    /// In place of an index: the triangle has no normals, or no texture coordinates. All three indices are then this.
    pub const NO_VALUE: u32 = u32::MAX;

    /// Makes a mesh. Conditions:
    ///
    /// - there is at least one triangle, and at most [`Mesh::MAX_TRIANGLES`];
    /// - every index refers to a vertex;
    /// - every coordinate is finite;
    /// - parts begin at triangle 0, ascend, hold at least one triangle each, and have colours from 0 to 1.
    ///
    /// Triangles of zero area are allowed, and no ray hits them; see [`Mesh::degenerate_triangles`].
    ///
    /// # Errors
    /// The first condition that does not hold, with the number of the triangle, vertex or part.
    pub fn new(
        mut positions: Vec<Vec3>,
        mut triangles: Vec<[u32; 3]>,
        mut parts: Vec<Part>,
    ) -> Result<Self, MeshError> {
        if triangles.is_empty() {
            return Err(MeshError::NoTriangles);
        }
        if triangles.len() > Self::MAX_TRIANGLES {
            return Err(MeshError::TooManyTriangles(triangles.len()));
        }
        let exists = |&index: &u32| (index as usize) < positions.len();
        if let Some(bad) = triangles.iter().position(|triangle| !triangle.iter().all(exists)) {
            return Err(MeshError::MissingVertex(bad));
        }
        if let Some(bad) = positions.iter().position(|position| !position.is_finite()) {
            return Err(MeshError::NotFinite(bad));
        }
        if let Some(bad) = first_bad_part(&parts, triangles.len()) {
            return Err(MeshError::BadPart(bad));
        }
        // A vector that grew may have twice the capacity that it needs, and a mesh lives long.
        positions.shrink_to_fit();
        triangles.shrink_to_fit();
        parts.shrink_to_fit();
        Ok(Self { positions, triangles, parts, normals: None, texture_coordinates: None })
    }

    /// Gives the corners of triangles normals, for shading. They may have any length. `corners` holds, for each
    /// triangle, the indices into `values` of the normals at its three vertices, or three times [`Mesh::NO_VALUE`].
    ///
    /// # Errors
    /// If `corners` does not have one item per triangle, an index refers to no value, or a value is not finite.
    pub fn with_normals(self, values: Vec<Vec3>, corners: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        let values = CornerValues::new("normals", values, corners, self.len(), |value| value.is_finite())?;
        Ok(Self { normals: Some(Box::new(values)), ..self })
    }

    /// Gives the corners of triangles texture coordinates. `corners` is as for [`Mesh::with_normals`].
    ///
    /// # Errors
    /// As for [`Mesh::with_normals`].
    pub fn with_texture_coordinates(self, values: Vec<Vec2>, corners: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        let values = CornerValues::new("texture coordinates", values, corners, self.len(), |value| value.is_finite())?;
        Ok(Self { texture_coordinates: Some(Box::new(values)), ..self })
    }

    /// A white mesh of triangles that share no vertex.
    ///
    /// # Errors
    /// Like [`Mesh::new`].
    pub fn from_triangles(triangles: &[Triangle]) -> Result<Self, MeshError> {
        if triangles.len() > Self::MAX_TRIANGLES / 3 {
            return Err(MeshError::TooManyTriangles(triangles.len()));
        }
        let numbers = (0..triangles.len() as u32).map(|number| [3 * number, 3 * number + 1, 3 * number + 2]);
        let positions = triangles.iter().flat_map(Triangle::vertices).collect();
        Self::new(positions, numbers.collect(), vec![Part { first_triangle: 0, color: Vec3::ONE }])
    }

    /// The vertices.
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// The three vertex numbers of each triangle.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The colours, in order of first triangle.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// Number of triangles.
    #[inline]
    #[expect(clippy::len_without_is_empty, reason = "a mesh is never empty")]
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// The triangle with this number.
    ///
    /// # Panics
    /// If there is no such triangle.
    #[inline]
    pub fn triangle(&self, primitive: u32) -> Triangle {
        self.with_vertices(self.triangles[primitive as usize])
    }

    #[inline]
    fn with_vertices(&self, indices: [u32; 3]) -> Triangle {
        let [v0, v1, v2] = indices.map(|index| self.positions[index as usize]);
        Triangle { v0, v1, v2 }
    }

    /// All triangles, in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Triangle> + '_ {
        self.triangles.iter().map(|&indices| self.with_vertices(indices))
    }

    /// The colour of the triangle with this number; beyond the last triangle, that of the last part.
    pub fn color(&self, primitive: u32) -> Vec3 {
        // At least 1, because the first part begins at triangle 0.
        let after = self.parts.partition_point(|part| part.first_triangle <= primitive);
        self.parts[after - 1].color
    }

    /// The normals at the vertices of the triangle with this number, as they were given, or `None` if it has none.
    ///
    /// # Panics
    /// If the mesh has normals, but no such triangle.
    pub fn normals(&self, primitive: u32) -> Option<[Vec3; 3]> {
        self.normals.as_ref()?.of(primitive)
    }

    /// The texture coordinates at the vertices of the triangle with this number, or `None` if it has none.
    ///
    /// # Panics
    /// If the mesh has texture coordinates, but no such triangle.
    pub fn texture_coordinates(&self, primitive: u32) -> Option<[Vec2; 3]> {
        self.texture_coordinates.as_ref()?.of(primitive)
    }

    /// The normals with their indices.
    pub(super) fn normal_values(&self) -> Option<&CornerValues<Vec3>> {
        self.normals.as_deref()
    }

    /// The texture coordinates with their indices.
    pub(super) fn texture_values(&self) -> Option<&CornerValues<Vec2>> {
        self.texture_coordinates.as_deref()
    }

    /// The smallest box around all triangles. Vertices that no triangle uses do not count.
    pub fn bounds(&self) -> Aabb {
        self.iter().fold(Aabb::EMPTY, |bounds, triangle| bounds.union(&triangle.bounds()))
    }

    /// Number of triangles of exactly zero area: two equal vertices, or three on a line.
    pub fn degenerate_triangles(&self) -> usize {
        self.iter().filter(has_zero_area).count()
    }

    /// Bytes of vertices, indices, parts, normals and texture coordinates.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.positions)
            + size_of_val(&*self.triangles)
            + size_of_val(&*self.parts)
            + self.normals.as_ref().map_or(0, |normals| normals.bytes())
            + self.texture_coordinates.as_ref().map_or(0, |coordinates| coordinates.bytes())
    }
}

fn first_bad_part(parts: &[Part], triangles: usize) -> Option<usize> {
    if parts.is_empty() {
        return Some(0);
    }
    (0..parts.len()).find(|&number| {
        let Part { first_triangle, color } = parts[number];
        let in_order = match number.checked_sub(1) {
            None => first_triangle == 0,
            Some(previous) => parts[previous].first_triangle < first_triangle,
        };
        let is_color = color.to_array().iter().all(|component| (0.0..=1.0).contains(component));
        !in_order || first_triangle as usize >= triangles || !is_color
    })
}

/// Decides exactly whether `(v1 - v0) × (v2 - v0)` is zero. Expanded, each component of the cross product is a sum of
/// six products of two coordinates. `f64` holds such a product without rounding.
pub(crate) fn has_zero_area(triangle: &Triangle) -> bool {
    let [a, b, c] = triangle.vertices().map(|vertex| vertex.to_array().map(f64::from));
    [(1, 2), (2, 0), (0, 1)].into_iter().all(|(y, z)| {
        let cross = |p: [f64; 3], q: [f64; 3]| [p[y] * q[z], -(p[z] * q[y])];
        let [[ab, ba], [bc, cb], [ca, ac]] = [cross(a, b), cross(b, c), cross(c, a)];
        sums_to_zero([ab, ba, bc, cb, ca, ac])
    })
}

/// Whether the exact sum of the terms is zero. The terms are products of two `f32`, so nothing overflows or underflows.
///
/// The method is Shewchuk's growing expansion (Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
/// Predicates, 1997, theorem 10). The parts always add up to the exact sum and never overlap. So the sum is zero only
/// if all parts are zero.
fn sums_to_zero(terms: [f64; 6]) -> bool {
    let mut parts = [0.0; 6];
    for (count, term) in terms.into_iter().enumerate() {
        let mut sum = term;
        for part in &mut parts[..count] {
            (sum, *part) = two_sum(sum, *part);
        }
        parts[count] = sum;
    }
    parts == [0.0; 6]
}

/// Returns the rounded sum and its rounding error, which is exact (Knuth's two-sum).
pub(crate) fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_part = sum - a;
    let a_part = sum - b_part;
    (sum, (a - a_part) + (b - b_part))
}

#[cfg(test)]
mod tests {
    use super::*;

    const GREY: Part = Part { first_triangle: 0, color: Vec3::splat(0.5) };

    fn square() -> (Vec<Vec3>, Vec<[u32; 3]>) {
        (vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(1.0, 1.0, 0.0)], vec![[0, 1, 2], [1, 3, 2]])
    }

    #[test]
    fn a_mesh_gives_triangle_and_colour_by_number() {
        let (mut positions, triangles) = square();
        positions.push(Vec3::splat(9.0)); // no triangle uses it
        let red = Part { first_triangle: 1, color: Vec3::X };
        let mesh = Mesh::new(positions, triangles, vec![GREY, red]).unwrap();
        assert_eq!(mesh.len(), 2);
        assert_eq!(mesh.triangle(1).vertices(), [Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y]);
        assert_eq!(mesh.iter().nth(1), Some(mesh.triangle(1)));
        assert_eq!([mesh.color(0), mesh.color(1)], [GREY.color, red.color]);
        assert_eq!(mesh.bounds(), Aabb { lo: Vec3::ZERO, hi: Vec3::new(1.0, 1.0, 0.0) });
        assert_eq!(mesh.bytes(), 5 * 12 + 2 * 12 + 2 * 16);
    }

    #[test]
    fn corners_have_normals_and_texture_coordinates_of_their_own() {
        let (positions, triangles) = square();
        let mesh = Mesh::new(positions, triangles, vec![GREY]).unwrap();
        let bytes = mesh.bytes();
        assert_eq!((mesh.normals(1), mesh.texture_coordinates(9)), (None, None));
        let none = [Mesh::NO_VALUE; 3];
        let (normals, corners) = (vec![Vec3::X, Vec3::Y * 3.0, Vec3::ZERO], vec![none, [1, 2, 1]]);
        let shaded = mesh.clone().with_normals(normals.clone(), corners.clone()).unwrap();
        assert_eq!((shaded.normals(0), shaded.normals(1)), (None, Some([Vec3::Y * 3.0, Vec3::ZERO, Vec3::Y * 3.0])));
        assert_eq!(shaded.bytes(), bytes + 48 + 3 * 12 + 2 * 12);
        let textured = mesh.clone().with_texture_coordinates(vec![Vec2::X, Vec2::Y], vec![[0, 1, 0], none]).unwrap();
        assert_eq!(textured.texture_coordinates(0), Some([Vec2::X, Vec2::Y, Vec2::X]));
        assert_eq!(textured.texture_coordinates(1), None);
        assert_eq!(textured.bytes(), bytes + 48 + 2 * 8 + 2 * 12);

        let what = "normals";
        let error = |values: &[Vec3], corners: &[[u32; 3]]| {
            mesh.clone().with_normals(values.to_vec(), corners.to_vec()).unwrap_err()
        };
        assert_eq!(error(&normals, &corners[..1]), MeshError::WrongCorners { what, count: 1, triangles: 2 });
        for bad in [[0, 1, 3], [0, 1, Mesh::NO_VALUE], [Mesh::NO_VALUE, 1, 2]] {
            assert_eq!(error(&normals, &[none, bad]), MeshError::MissingValue { what, triangle: 1 });
        }
        let nan = [Vec3::X, Vec3::Y, Vec3::new(0.0, f32::NAN, 0.0)];
        assert_eq!(error(&nan, &[none, none]), MeshError::ValueNotFinite { what, number: 2 });
        let infinite = mesh.with_texture_coordinates(vec![Vec2::INFINITY], vec![[0; 3]; 2]).unwrap_err();
        assert_eq!(infinite.to_string(), "number 0 of the texture coordinates is not finite");
    }

    #[test]
    fn invalid_meshes_are_refused() {
        let (positions, triangles) = square();
        let error = |positions: &[Vec3], triangles: &[[u32; 3]], parts: &[Part]| {
            Mesh::new(positions.to_vec(), triangles.to_vec(), parts.to_vec()).err()
        };
        assert_eq!(error(&positions, &triangles, &[GREY]), None);
        assert_eq!(error(&positions, &[], &[GREY]), Some(MeshError::NoTriangles));
        assert_eq!(error(&positions[..3], &triangles, &[GREY]), Some(MeshError::MissingVertex(1)));
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let positions = [positions[0], positions[1], positions[2], Vec3::new(0.0, bad, 0.0)];
            assert_eq!(error(&positions, &triangles, &[GREY]), Some(MeshError::NotFinite(3)));
        }
        let from = |first_triangle| Part { first_triangle, ..GREY };
        let green = |component| Part { color: Vec3::new(0.0, component, 0.0), ..GREY };
        for (parts, bad) in [
            (vec![], 0),
            (vec![from(1)], 0),
            (vec![GREY, GREY], 1),
            (vec![GREY, from(2)], 1),
            (vec![green(f32::NAN)], 0),
            (vec![green(-0.1)], 0),
            (vec![green(1.5)], 0),
        ] {
            assert_eq!(error(&positions, &triangles, &parts), Some(MeshError::BadPart(bad)), "{parts:?}");
        }
    }

    #[test]
    fn zero_area_is_decided_exactly() {
        let thin = |x: f32| Triangle { v0: Vec3::ZERO, v1: Vec3::ONE, v2: Vec3::new(x, 3.0, 3.0) };
        assert!(has_zero_area(&thin(3.0)));
        assert!(!has_zero_area(&thin(3.0f32.next_up())));
        // One vertex is so small that any fixed precision loses it beside the others.
        let far = Triangle { v0: Vec3::splat(1e-40), v1: Vec3::new(1e30, 0.0, 0.0), v2: Vec3::new(-1e30, 0.0, 0.0) };
        assert!(!has_zero_area(&far));
        assert!(has_zero_area(&Triangle { v0: Vec3::new(1e-40, 0.0, 0.0), ..far }));
        assert!(has_zero_area(&Triangle { v2: far.v1, ..far }));
        // After one rounding, the large terms of the two far vertices cancel and hide the term of the small one.
        let [near, twice] = [1e20, 2e20].map(|x| Vec3::new(x, x, 0.0));
        assert!(!has_zero_area(&Triangle { v0: near, v1: Vec3::X * 1e-20, v2: twice }));
        // Three points on a line whose coordinates need every digit.
        let (start, step) =
            (Vec3::new(1_048_577.0, 1.0, 1.0 / 1_048_576.0), Vec3::new(1_048_576.0, 1.0 / 1_048_576.0, 1.0));
        assert!(has_zero_area(&Triangle { v0: start, v1: start + step, v2: start + step * 2.0 }));
        // The products of these coordinates are below the range of f32.
        let tiny = Triangle { v0: Vec3::ZERO, v1: Vec3::X * 1e-45, v2: Vec3::Y * 1e-45 };
        assert!(!has_zero_area(&tiny));
        let (positions, mut triangles) = square();
        triangles.push([0, 0, 1]);
        assert_eq!(Mesh::new(positions, triangles, vec![GREY]).unwrap().degenerate_triangles(), 1);
    }
}
