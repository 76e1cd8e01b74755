//! Values at the corners of triangles: normals, or texture coordinates.

use super::mesh::{Mesh, MeshError};

/// Values, and which of them each triangle has at its corners. Corners may share a value.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CornerValues<T> {
    pub(super) values: Vec<T>,
    /// For each triangle: three indices of values, or three times [`Mesh::NO_VALUE`].
    pub(super) corners: Vec<[u32; 3]>,
}

impl<T: Copy> CornerValues<T> {
    /// `what` names the values in errors, `triangles` is the number of triangles.
    pub(super) fn new(
        what: &'static str,
        mut values: Vec<T>,
        mut corners: Vec<[u32; 3]>,
        triangles: usize,
        is_finite: impl Fn(&T) -> bool,
    ) -> Result<Self, MeshError> {
        if corners.len() != triangles {
            return Err(MeshError::WrongCorners { what, count: corners.len(), triangles });
        }
        let exist = |indices: &[u32; 3]| {
            *indices == [Mesh::NO_VALUE; 3] || indices.iter().all(|&index| (index as usize) < values.len())
        };
        if let Some(triangle) = corners.iter().position(|indices| !exist(indices)) {
            return Err(MeshError::MissingValue { what, triangle });
        }
        if let Some(number) = values.iter().position(|value| !is_finite(value)) {
            return Err(MeshError::ValueNotFinite { what, number });
        }
        values.shrink_to_fit();
        corners.shrink_to_fit();
        Ok(Self { values, corners })
    }

    /// The values at the corners of a triangle, or `None` if it has none.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub(super) fn of(&self, primitive: u32) -> Option<[T; 3]> {
        Some(self.indices(primitive as usize)?.map(|index| self.values[index as usize]))
    }

    /// The indices of the values at the corners of a triangle, or `None` if it has none.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub(super) fn indices(&self, triangle: usize) -> Option<[u32; 3]> {
        let indices = self.corners[triangle];
        (indices[0] != Mesh::NO_VALUE).then_some(indices)
    }

    /// All values.
    pub(super) fn values(&self) -> &[T] {
        &self.values
    }

    pub(super) fn bytes(&self) -> usize {
        size_of::<Self>() + size_of_val(&*self.values) + size_of_val(&*self.corners)
    }
}
