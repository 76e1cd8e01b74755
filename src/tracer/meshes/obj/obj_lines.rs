//! The lines of an OBJ file: which are passed on to `tobj`, which are refused, and what is kept of the others.

use std::collections::HashMap;
use std::path::Path;

use glam::Vec3;

use super::attribute::{Attribute, ForwardIndices, VERTEX};
use super::material::UsedLibraries;
use crate::error::quoted;
use crate::tracer::meshes::line::{Line, LineCount, LineError, decode};
use crate::tracer::meshes::mesh::{DEFAULT_COLOR, Part};
use crate::tracer::meshes::reader::LineChecker;

/// Keywords of lines that are ignored without a warning: points of parameter space, names, display settings, and the
/// bodies of free-form curves and surfaces. The first line of a curve or surface counts it; see
/// [`ObjLines::ignored_elements`].
const IGNORED_KEYWORDS: [&[u8]; 26] = [
    b"vp",
    b"o",
    b"g",
    b"s",
    b"mg",
    b"usemap",
    b"maplib",
    b"lod",
    b"bevel",
    b"c_interp",
    b"d_interp",
    b"shadow_obj",
    b"trace_obj",
    b"cstype",
    b"deg",
    b"bmat",
    b"step",
    b"parm",
    b"trim",
    b"hole",
    b"scrv",
    b"sp",
    b"end",
    b"con",
    b"ctech",
    b"stech",
];

/// Checks the lines of an OBJ file, passes vertices and faces on, and keeps what `tobj` would drop.
#[derive(Debug)]
pub(super) struct ObjLines {
    /// Number of vertices.
    pub(super) vertices: usize,
    /// Number of faces.
    faces: usize,
    /// The line of each face with more than three corners.
    pub(super) polygons: Vec<usize>,
    forward: ForwardIndices,
    /// The vertex of each corner of all faces, counted from 0.
    pub(super) corners: Vec<u32>,
    pub(super) normals: Attribute<3>,
    pub(super) texture_coordinates: Attribute<2>,
    pub(super) libraries: UsedLibraries,
    /// The materials that faces use.
    materials: Vec<UsedMaterial>,
    /// Number of points, lines, curves and free-form surfaces.
    pub(super) ignored_elements: usize,
    /// Vertices with a colour.
    pub(super) colored_vertices: LineCount,
    /// Lines that are not known.
    pub(super) unknown_keywords: LineCount,
}

/// A material that faces use.
#[derive(Debug)]
struct UsedMaterial {
    name: String,
    line: usize,
    first_face: usize,
}

impl Default for ObjLines {
    fn default() -> Self {
        Self {
            vertices: 0,
            faces: 0,
            polygons: Vec::new(),
            forward: ForwardIndices::default(),
            corners: Vec::new(),
            normals: Attribute::normals(),
            texture_coordinates: Attribute::texture_coordinates(),
            libraries: UsedLibraries::default(),
            materials: Vec::new(),
            ignored_elements: 0,
            colored_vertices: LineCount::default(),
            unknown_keywords: LineCount::default(),
        }
    }
}

impl LineChecker for ObjLines {
    fn check(&mut self, line: &Line<'_>, checked: &mut Vec<u8>) -> Result<(), LineError> {
        match line.keyword() {
            b"v" => self.vertex(line, checked),
            b"f" => self.face(line, checked),
            b"vn" => {
                self.normals.add_value(line);
                Ok(())
            }
            b"vt" => {
                self.texture_coordinates.add_value(line);
                Ok(())
            }
            b"usemtl" => {
                self.use_material(line);
                Ok(())
            }
            b"mtllib" => {
                self.libraries.add(line);
                Ok(())
            }
            b"p" | b"l" | b"curv" | b"curv2" | b"surf" => {
                self.ignored_elements += 1;
                Ok(())
            }
            b"" => Ok(()),
            keyword if IGNORED_KEYWORDS.contains(&keyword) => Ok(()),
            _ => {
                self.unknown_keywords.add(line);
                Ok(())
            }
        }
    }

    fn check_end(&mut self) -> Result<(), LineError> {
        self.forward.check_end(&VERTEX, self.vertices)?;
        self.texture_coordinates.check_end()?;
        self.normals.check_end()
    }
}

impl ObjLines {
    fn vertex(&mut self, line: &Line<'_>, checked: &mut Vec<u8>) -> Result<(), LineError> {
        let mut words = line.arguments();
        let mut position = [0.0; 3];
        checked.push(b'v');
        for coordinate in &mut position {
            let word = words.next().ok_or_else(|| line.error("a vertex needs 3 coordinates"))?;
            *coordinate = line.finite("vertex coordinate", word)?;
            checked.push(b' ');
            checked.extend(word);
        }
        match (words.next(), words.count()) {
            (None, _) => {}
            (Some(word), 0) => {
                let weight = line.finite("vertex weight", word)?;
                if !position.iter().all(|coordinate| (coordinate / weight).is_finite()) {
                    return Err(line.error("vertex weight is zero or too small"));
                }
                checked.push(b' ');
                checked.extend(word);
            }
            (Some(_), 2 | 3) => self.colored_vertices.add(line),
            _ => return Err(line.error("a vertex has 3, 4, 6 or 7 numbers")),
        }
        checked.push(b'\n');
        self.vertices += 1;
        Ok(())
    }

    fn face(&mut self, line: &Line<'_>, checked: &mut Vec<u8>) -> Result<(), LineError> {
        let mut corners = 0;
        checked.push(b'f');
        for word in line.arguments() {
            // tobj gets only the index of the position. Those of texture coordinate and normal follow after slashes.
            let mut indices = word.split(|&byte| byte == b'/');
            let index = indices.next().unwrap_or_default();
            let vertex = self.forward.resolve(&VERTEX, self.vertices, line, index)?;
            self.texture_coordinates.add_corner(line, indices.next().unwrap_or_default(), self.corners.len())?;
            self.normals.add_corner(line, indices.next().unwrap_or_default(), self.corners.len())?;
            // An index beyond u32 is beyond every file too. check_end refuses it.
            self.corners.push(u32::try_from(vertex).unwrap_or(u32::MAX));
            checked.push(b' ');
            checked.extend(index);
            corners += 1;
        }
        if corners < 3 {
            return Err(line.error("a face needs 3 vertices"));
        }
        checked.push(b'\n');
        self.faces += 1;
        if corners > 3 {
            self.polygons.push(line.number);
        }
        Ok(())
    }

    fn use_material(&mut self, line: &Line<'_>) {
        // Drop the material before, if no face used it.
        self.materials.pop_if(|material| material.first_face == self.faces);
        let name = decode(line.name()).trim().to_owned();
        self.materials.push(UsedMaterial { name, line: line.number, first_face: self.faces });
    }

    /// The parts of the mesh: one per range of triangles with the same material. Warns of materials without definition.
    /// `first_triangles` holds the first triangle of each face, and after the last face the number of triangles.
    pub(super) fn parts(
        &self,
        first_triangles: &[usize],
        colors: &HashMap<String, Vec3>,
        file: &Path,
        warnings: &mut Vec<String>,
    ) -> Vec<Part> {
        let mut undefined = LineCount::default();
        let mut parts = vec![Part { first_triangle: 0, color: DEFAULT_COLOR }];
        for UsedMaterial { name, line, first_face } in &self.materials {
            // Mesh::new refuses more triangles than u32 can count.
            let Ok(first_triangle) = u32::try_from(first_triangles[*first_face]) else { break };
            if *first_face == self.faces {
                // The last material has no faces.
                break;
            }
            let color = colors.get(name).copied().unwrap_or_else(|| {
                // An empty name means no material.
                if !name.is_empty() {
                    undefined.add_with(*line, || quoted(name.as_bytes()));
                }
                DEFAULT_COLOR
            });
            parts.pop_if(|part| part.first_triangle == first_triangle);
            parts.push(Part { first_triangle, color });
        }
        warnings.extend(undefined.warning(file, "unknown material, default colour used"));
        parts
    }
}
