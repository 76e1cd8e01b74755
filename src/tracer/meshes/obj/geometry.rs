//! The surface of an OBJ file: the faces that `tobj` has read, split into triangles.

use std::path::Path;

use glam::Vec3;

use super::obj_lines::ObjLines;
use crate::tracer::meshes::polygon::OddPolygons;

/// Vertices, in the order of the file, and triangles, in the order of the faces.
#[derive(Debug, Default)]
pub(super) struct Geometry {
    pub(super) positions: Vec<Vec3>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// The corners of each triangle, counted over all faces. Empty if nobody asks for them.
    pub(super) corners: Vec<[u32; 3]>,
    /// The first triangle of each face, and after the last face the number of triangles.
    pub(super) first_triangles: Vec<usize>,
    odd_polygons: OddPolygons,
}

impl Geometry {
    /// Splits the faces of the only model. `lines` says what `tobj` does not: the line of each polygon, and the vertex
    /// of each corner. `keep_corners` asks for [`Geometry::corners`].
    pub(super) fn new(models: &[tobj::Model], lines: &ObjLines, keep_corners: bool) -> Self {
        let [tobj::Model { mesh, .. }] = models else {
            unreachable!("tobj starts a new model only at a group or material")
        };
        let (positions, _) = mesh.positions.as_chunks();
        let mut geometry = Self {
            positions: positions.iter().map(|&position| Vec3::from_array(position)).collect(),
            ..Self::default()
        };
        let mut polygons = lines.polygons.iter();
        // Without arities, every face is a triangle.
        let mut arities = mesh.face_arities.iter();
        let mut indices = &mesh.indices[..];
        // A corner takes at least two bytes of a file, so a u32 counts those of the largest file.
        let mut first_corner = 0;
        while !indices.is_empty() {
            let face;
            (face, indices) = indices.split_at(arities.next().map_or(3, |&arity| arity as usize));
            geometry.first_triangles.push(geometry.triangles.len());
            let fan = [[0, 1, 2]];
            let split;
            let triangles = match face.len() {
                3 => &fan[..],
                _ => {
                    split = geometry.split(face, *polygons.next().expect("the line of every polygon is known"));
                    &split[..]
                }
            };
            geometry.triangles.extend(triangles.iter().map(|triangle| triangle.map(|corner| face[corner])));
            if keep_corners {
                let corners = triangles.iter().map(|triangle| triangle.map(|corner| first_corner + corner as u32));
                geometry.corners.extend(corners);
                first_corner += face.len() as u32;
            }
        }
        geometry.first_triangles.push(geometry.triangles.len());
        geometry.restore_order(lines);
        geometry
    }

    /// Numbers the vertices in the order of the file. `tobj` numbers them in the order in which faces first use them.
    fn restore_order(&mut self, lines: &ObjLines) {
        const UNUSED: u32 = u32::MAX;
        let mut tobj_numbers = vec![UNUSED; lines.vertices];
        let mut next = 0;
        for &vertex in &lines.corners {
            let number = &mut tobj_numbers[vertex as usize];
            if *number == UNUSED {
                *number = next;
                next += 1;
            }
        }
        tobj_numbers.retain(|&number| number != UNUSED);
        self.positions = tobj_numbers.iter().map(|&number| self.positions[number as usize]).collect();
        let mut numbers = vec![0; tobj_numbers.len()];
        (0..).zip(tobj_numbers).for_each(|(number, tobj_number)| numbers[tobj_number as usize] = number);
        self.triangles.iter_mut().flatten().for_each(|vertex| *vertex = numbers[*vertex as usize]);
    }

    /// The triangles of a face with more than three corners, by its corners.
    fn split(&mut self, face: &[u32], line: usize) -> Vec<[usize; 3]> {
        let corners: Vec<_> = face.iter().map(|&index| self.positions[index as usize]).collect();
        self.odd_polygons.split(&corners, line, || format!("{} corners", face.len()))
    }

    /// Warnings about polygons that have no obvious surface.
    pub(super) fn warnings(&self, file: &Path) -> impl Iterator<Item = String> {
        self.odd_polygons.warnings(file)
    }
}
