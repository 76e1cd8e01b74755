//! Meshes made of other meshes: some of the triangles, moved vertices, several meshes as one.

use glam::Vec3;

use super::corner_values::CornerValues;
use super::mesh::{Mesh, MeshError, Part};

impl Mesh {
    /// The triangles with these numbers, in this order. Colours, normals and texture coordinates follow them. Vertices
    /// that none of them uses are left out; the others stay in order.
    ///
    /// # Panics
    /// If there are no numbers, or there is no such triangle.
    pub(crate) fn subset(&self, numbers: &[u32]) -> Self {
        let (positions, triangles) = selected(self.positions(), self.triangles(), numbers);
        let mut parts: Vec<Part> = Vec::new();
        for (first_triangle, &number) in (0..).zip(numbers) {
            let color = self.color(number);
            if parts.last().is_none_or(|part| part.color != color) {
                parts.push(Part { first_triangle, color });
            }
        }
        let mesh = Self::new(positions, triangles, parts).expect("triangles of a valid mesh");
        Self {
            normals: self.normals.as_ref().map(|normals| Box::new(normals.subset(numbers))),
            texture_coordinates: self.texture_coordinates.as_ref().map(|uvs| Box::new(uvs.subset(numbers))),
            ..mesh
        }
    }

    /// The mesh with every vertex and every normal replaced.
    ///
    /// # Errors
    /// If a new vertex or normal is not finite.
    pub(crate) fn mapped(
        &self,
        position: impl Fn(Vec3) -> Vec3,
        normal: impl Fn(Vec3) -> Vec3,
    ) -> Result<Self, MeshError> {
        let positions = self.positions().iter().map(|&point| position(point)).collect();
        let mesh = Self::new(positions, self.triangles().to_vec(), self.parts().to_vec())?;
        let mesh = Self { texture_coordinates: self.texture_coordinates.clone(), ..mesh };
        match &self.normals {
            None => Ok(mesh),
            Some(normals) => {
                let values = normals.values.iter().map(|&value| normal(value)).collect();
                mesh.with_normals(values, normals.corners.clone())
            }
        }
    }

    /// The mesh in one colour, which must be from 0 to 1.
    pub(crate) fn in_color(self, color: Vec3) -> Self {
        Self { parts: vec![Part { first_triangle: 0, color }], ..self }
    }

    /// All triangles of the meshes, one mesh after the other.
    ///
    /// # Errors
    /// If there are no meshes, or more than [`Mesh::MAX_TRIANGLES`] triangles.
    ///
    /// # Panics
    /// If there are more than `u32::MAX` vertices.
    pub(crate) fn joined(meshes: &[Self]) -> Result<Self, MeshError> {
        let (mut positions, mut triangles, mut parts) = (Vec::new(), Vec::new(), Vec::new());
        for mesh in meshes {
            let first_triangle = triangles.len() as u32;
            let in_all = |part: &Part| Part { first_triangle: first_triangle + part.first_triangle, ..*part };
            parts.extend(mesh.parts().iter().map(in_all));
            append(&mut positions, &mut triangles, mesh.positions(), mesh.triangles());
        }
        let mesh = Self::new(positions, triangles, parts)?;
        let texture_coordinates = joined(meshes, |mesh| mesh.texture_coordinates.as_deref());
        Ok(Self { normals: joined(meshes, |mesh| mesh.normals.as_deref()), texture_coordinates, ..mesh })
    }
}

impl<T: Copy> CornerValues<T> {
    /// Those of the triangles with these numbers.
    fn subset(&self, numbers: &[u32]) -> Self {
        let (values, corners) = selected(&self.values, &self.corners, numbers);
        Self { values, corners }
    }
}

/// The triples with these numbers, and the values to which they refer, in order.
fn selected<T: Copy>(values: &[T], triples: &[[u32; 3]], numbers: &[u32]) -> (Vec<T>, Vec<[u32; 3]>) {
    let mut chosen: Vec<_> = numbers.iter().map(|&number| triples[number as usize]).collect();
    let mut is_used = vec![false; values.len()];
    for &index in chosen.as_flattened().iter().filter(|&&index| index != Mesh::NO_VALUE) {
        is_used[index as usize] = true;
    }
    let mut next = 0;
    let new_numbers: Vec<u32> = is_used.iter().map(|&used| (next, next += u32::from(used)).0).collect();
    for index in chosen.as_flattened_mut().iter_mut().filter(|index| **index != Mesh::NO_VALUE) {
        *index = new_numbers[*index as usize];
    }
    (values.iter().zip(is_used).filter(|(_, used)| *used).map(|(value, _)| *value).collect(), chosen)
}

/// Appends values, and triples that refer to them.
fn append<T: Copy>(values: &mut Vec<T>, triples: &mut Vec<[u32; 3]>, more: &[T], more_triples: &[[u32; 3]]) {
    let first = u32::try_from(values.len() + more.len()).expect("indices have 32 bits") - more.len() as u32;
    values.extend(more);
    triples.extend(
        more_triples
            .iter()
            .map(|triple| triple.map(|index| if index == Mesh::NO_VALUE { index } else { first + index })),
    );
}

/// The values of all meshes, or `None` if no mesh has any.
fn joined<T: Copy>(meshes: &[Mesh], of: impl Fn(&Mesh) -> Option<&CornerValues<T>>) -> Option<Box<CornerValues<T>>> {
    let (mut values, mut corners) = (Vec::new(), Vec::new());
    for mesh in meshes {
        match of(mesh) {
            Some(more) => append(&mut values, &mut corners, &more.values, &more.corners),
            None => corners.resize(corners.len() + mesh.len(), [Mesh::NO_VALUE; 3]),
        }
    }
    (!values.is_empty()).then(|| Box::new(CornerValues { values, corners }))
}
