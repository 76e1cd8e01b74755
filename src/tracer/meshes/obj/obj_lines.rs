//! The lines of an OBJ file: which are passed on to `tobj`, which are refused, and what is kept of the others.

use std::collections::HashMap;
use std::num::IntErrorKind;
use std::path::Path;

use glam::Vec3;

use super::line::{Line, LineCount, LineError, decode};
use super::material::{DEFAULT_COLOR, UsedLibraries};
use super::reader::LineChecker;
use crate::error::quoted;
use crate::tracer::meshes::mesh::Part;

/// Keywords of lines that are ignored without a warning: attributes of vertices, names, display settings, and the
/// bodies of free-form curves and surfaces. The first line of a curve or surface counts it; see
/// [`ObjLines::ignored_elements`].
const IGNORED_KEYWORDS: [&[u8]; 28] = [
    b"vn",
    b"vt",
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
#[derive(Debug, Default)]
pub(super) struct ObjLines {
    /// Number of vertices.
    pub(super) vertices: usize,
    /// Number of faces.
    faces: usize,
    /// The line of each face with more than three corners.
    pub(super) polygons: Vec<usize>,
    /// The largest index that a face used before its vertex was defined.
    forward: Option<ForwardIndex>,
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

/// A vertex index, counted from 1, and the face that uses it.
#[derive(Debug)]
struct ForwardIndex {
    index: usize,
    line: usize,
    text: String,
}

impl LineChecker for ObjLines {
    fn check(&mut self, line: &Line<'_>, checked: &mut Vec<u8>) -> Result<(), LineError> {
        match line.keyword() {
            b"v" => self.vertex(line, checked),
            b"f" => self.face(line, checked),
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
        match &self.forward {
            Some(ForwardIndex { index, line, text }) if *index > self.vertices => Err(LineError {
                line: *line,
                message: format!("there is no vertex {index}, the file has {}: {text}", self.vertices),
            }),
            _ => Ok(()),
        }
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
            // Keep only the index of the position. Indices of texture coordinate and normal follow after slashes.
            let index = word.split(|&byte| byte == b'/').next().unwrap_or_default();
            self.check_index(line, index)?;
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

    /// Checks one vertex index of a face.
    fn check_index(&mut self, line: &Line<'_>, word: &[u8]) -> Result<(), LineError> {
        let text = str::from_utf8(word).map_err(|_| line.error("face index is not a whole number"))?;
        // tobj parses indices as isize too.
        let index = text.parse::<isize>().map_err(|error| match error.kind() {
            IntErrorKind::Empty => line.error("face index is missing"),
            IntErrorKind::PosOverflow | IntErrorKind::NegOverflow => line.error("face index is out of range"),
            _ => line.error("face index is not a whole number"),
        })?;
        match index {
            0 => Err(line.error("face index is 0, but the first vertex is 1")),
            ..0 if index.unsigned_abs() > self.vertices => {
                Err(line.error(&format!("face index {index} counts back beyond the {} vertices so far", self.vertices)))
            }
            ..0 => Ok(()),
            1.. => {
                let index = index.unsigned_abs();
                let known = self.forward.as_ref().map_or(0, |forward| forward.index).max(self.vertices);
                if index > known {
                    self.forward = Some(ForwardIndex { index, line: line.number, text: quoted(line.text) });
                }
                Ok(())
            }
        }
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
