//! Wavefront OBJ files, read by `tobj` behind a guard.
//!
//! `tobj` reports no line numbers, takes NaN for a coordinate and `l 1 2 3` for a triangle, fails a file for a broken
//! texture coordinate that nobody uses, and panics on a colour of two numbers. So it is fed line by line, with only
//! those lines that make geometry and only after a check: what is wrong is found here, where the line is known.
//!
//! | in the file | what becomes of it |
//! | --- | --- |
//! | `v x y z`, `v x y z w` | a vertex; `tobj` divides by the weight `w` |
//! | `v x y z r g b`, `… a` | a vertex; its colour is ignored with a warning |
//! | `f` with 3 or more vertices | a fan of triangles around the first. Negative indices count back from the line they stand on; positive ones may refer to vertices that come later in the file |
//! | `usemtl`, `mtllib` | the material's diffuse colour |
//! | `p`, `l`, `curv`, `curv2`, `surf` | nothing to hit; counted in [`ObjReport::ignored_elements`] |
//! | normals, texture coordinates, groups, display attributes | not used, whatever they hold |
//! | any other line | ignored with a warning |
//!
//! A backslash at the end of a line joins it with the next, except in comments. Text need not be UTF-8.

mod feed;
mod material;

use std::collections::HashMap;
use std::num::IntErrorKind;
use std::path::Path;

use glam::Vec3;

use self::feed::{Check, Fault, Feed, Line, LineCount};
use self::material::{DEFAULT_COLOR, Named};
use super::mesh::{Mesh, Part};
use crate::error::{Error, quoted};

/// Lines that shape no surface: attributes of vertices, names, display settings, and the bodies of free-form curves
/// and surfaces, which are counted by their first line.
const SILENT: [&[u8]; 28] = [
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

/// What loading a file left out or found remarkable.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ObjReport {
    /// Vertices in the file. The mesh holds only those that faces use.
    pub vertices: usize,
    /// Triangles of exactly zero area. They are part of the mesh, so that primitive numbers follow the file.
    pub degenerate: usize,
    /// Points, lines, curves and free-form surfaces.
    pub ignored_elements: usize,
    /// One line each: missing materials, unknown lines, and other things that were passed over.
    pub warnings: Vec<String>,
}

/// Loads an OBJ file and the material files it names. Triangles are in the order of the file's faces.
///
/// # Errors
/// If a file cannot be read, or has a line that makes no sense, or if there are no triangles. A material file that does
/// not exist is a warning.
pub fn load_obj(path: &Path) -> Result<(Mesh, ObjReport), Error> {
    let options = tobj::LoadOptions { single_index: true, triangulate: true, ..Default::default() };
    let mut feed = Feed::open(path, ObjLines::default())?;
    // Objects, groups and materials stay out of the feed, so tobj makes one model whose faces share their vertices.
    let parsed = tobj::load_obj_buf(&mut feed, &options, |_| Err(tobj::LoadError::OpenFileFailed));
    let ((models, _), lines) = feed.finish(parsed)?;
    let (positions, triangles) = geometry(&models);

    let mut warnings = Vec::new();
    let colors = material::load_libraries(path, &lines.libraries, &mut warnings)?;
    let parts = lines.parts(triangles.len(), &colors, path, &mut warnings);
    warnings.extend(lines.colored.warning(path, "vertex colour ignored"));
    warnings.extend(lines.unknown.warning(path, "unknown keyword, line ignored"));

    let mesh = Mesh::new(positions, triangles, parts).map_err(|error| Error::in_file(path, error.to_string()))?;
    let degenerate = mesh.degenerate_triangles();
    let report = ObjReport { vertices: lines.vertices, degenerate, ignored_elements: lines.elements, warnings };
    Ok((mesh, report))
}

fn geometry(models: &[tobj::Model]) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let [tobj::Model { mesh, .. }] = models else {
        unreachable!("tobj starts a new model only at a group or material")
    };
    let (positions, _) = mesh.positions.as_chunks();
    let (triangles, _) = mesh.indices.as_chunks();
    (positions.iter().map(|&position| Vec3::from_array(position)).collect(), triangles.to_vec())
}

/// Checks the lines of an OBJ file, lets geometry through, and keeps what `tobj` would drop.
#[derive(Debug, Default)]
struct ObjLines {
    vertices: usize,
    triangles: usize,
    /// The greatest index of a vertex that had not appeared when a face used it.
    forward: Option<ForwardIndex>,
    libraries: Vec<Named>,
    /// The materials that faces use, each with its first triangle.
    materials: Vec<(usize, Named)>,
    elements: usize,
    colored: LineCount,
    unknown: LineCount,
}

#[derive(Debug)]
struct ForwardIndex {
    index: usize,
    line: usize,
    text: String,
}

impl Check for ObjLines {
    fn line(&mut self, line: &Line<'_>, checked: &mut Vec<u8>) -> Result<(), Fault> {
        match line.keyword() {
            b"v" => self.vertex(line, checked),
            b"f" => self.face(line, checked),
            b"usemtl" => {
                self.use_material(Named { name: line.name(), line: line.number });
                Ok(())
            }
            b"mtllib" => {
                self.use_library(Named { name: line.name(), line: line.number });
                Ok(())
            }
            b"p" | b"l" | b"curv" | b"curv2" | b"surf" => {
                self.elements += 1;
                Ok(())
            }
            b"" => Ok(()),
            keyword if SILENT.contains(&keyword) => Ok(()),
            _ => {
                self.unknown.note(line);
                Ok(())
            }
        }
    }

    fn end(&mut self) -> Result<(), Fault> {
        match &self.forward {
            Some(ForwardIndex { index, line, text }) if *index > self.vertices => Err(Fault {
                line: *line,
                message: format!("there is no vertex {index}, the file has {}: {text}", self.vertices),
            }),
            _ => Ok(()),
        }
    }
}

impl ObjLines {
    fn vertex(&mut self, line: &Line<'_>, checked: &mut Vec<u8>) -> Result<(), Fault> {
        let mut words = line.arguments();
        let mut position = [0.0; 3];
        checked.push(b'v');
        for coordinate in &mut position {
            let word = words.next().ok_or_else(|| line.fault("a vertex needs 3 coordinates"))?;
            *coordinate = line.finite("vertex coordinate", word)?;
            checked.push(b' ');
            checked.extend(word);
        }
        match (words.next(), words.count()) {
            (None, _) => {}
            (Some(word), 0) => {
                let weight = line.finite("vertex weight", word)?;
                if !position.iter().all(|coordinate| (coordinate / weight).is_finite()) {
                    return Err(line.fault("vertex weight is zero or too small"));
                }
                checked.push(b' ');
                checked.extend(word);
            }
            (Some(_), 2 | 3) => self.colored.note(line),
            _ => return Err(line.fault("a vertex has 3, 4, 6 or 7 numbers")),
        }
        checked.push(b'\n');
        self.vertices += 1;
        Ok(())
    }

    fn face(&mut self, line: &Line<'_>, checked: &mut Vec<u8>) -> Result<(), Fault> {
        let mut corners = 0;
        checked.push(b'f');
        for word in line.arguments() {
            // Only the position's index; those of texture coordinate and normal follow after slashes.
            let index = word.split(|&byte| byte == b'/').next().unwrap_or_default();
            self.index(line, index)?;
            checked.push(b' ');
            checked.extend(index);
            corners += 1;
        }
        if corners < 3 {
            return Err(line.fault("a face needs 3 vertices"));
        }
        checked.push(b'\n');
        self.triangles += corners - 2;
        Ok(())
    }

    /// Checks one vertex index of a face.
    fn index(&mut self, line: &Line<'_>, word: &[u8]) -> Result<(), Fault> {
        let text = str::from_utf8(word).map_err(|_| line.fault("face index is not a whole number"))?;
        // tobj counts in isize too.
        let index = text.parse::<isize>().map_err(|error| match error.kind() {
            IntErrorKind::Empty => line.fault("face index is missing"),
            IntErrorKind::PosOverflow | IntErrorKind::NegOverflow => line.fault("face index is out of range"),
            _ => line.fault("face index is not a whole number"),
        })?;
        match index {
            0 => Err(line.fault("face index is 0, but the first vertex is 1")),
            ..0 if index.unsigned_abs() > self.vertices => {
                Err(line.fault(&format!("face index {index} counts back beyond the {} vertices so far", self.vertices)))
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

    fn use_material(&mut self, material: Named) {
        // A material without faces is none to speak of.
        self.materials.pop_if(|(first_triangle, _)| *first_triangle == self.triangles);
        self.materials.push((self.triangles, material));
    }

    fn use_library(&mut self, library: Named) {
        // Exporters like to name the one library again before every object.
        if self.libraries.last().is_none_or(|last| last.name != library.name) {
            self.libraries.push(library);
        }
    }

    /// The colour of each run of triangles.
    fn parts(
        &self,
        triangles: usize,
        colors: &HashMap<String, Vec3>,
        file: &Path,
        warnings: &mut Vec<String>,
    ) -> Vec<Part> {
        let mut undefined = LineCount::default();
        let mut parts = vec![Part { first_triangle: 0, color: DEFAULT_COLOR }];
        for (first_triangle, Named { name, line }) in &self.materials {
            // The last one may have no faces. More triangles than u32 can count are refused by Mesh::new.
            let (true, Ok(first_triangle)) = (*first_triangle < triangles, u32::try_from(*first_triangle)) else {
                break;
            };
            let color = colors.get(name).copied().unwrap_or_else(|| {
                // An empty name asks for no material.
                if !name.is_empty() {
                    undefined.note_text(*line, name.as_bytes());
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
