//! Wavefront OBJ files. `tobj` parses them, but every line is checked first.
//!
//! `tobj` alone is not enough. It reports no line numbers, accepts NaN as a coordinate, and takes `l 1 2 3` for a
//! triangle. It refuses a whole file for a broken texture coordinate that nobody uses. It panics on a colour of two
//! numbers. So [`CheckedReader`] gives it one checked line at a time, and only lines that make geometry. Errors are
//! found here, where the line number is known.
//!
//! | in the file | what becomes of it |
//! | --- | --- |
//! | `v x y z`, `v x y z w` | a vertex; `tobj` divides by the weight `w` |
//! | `v x y z r g b`, `… a` | a vertex; its colour is ignored with a warning |
//! | `f` with 3 or more vertices | triangles; a convex polygon becomes a fan around its first vertex; see `polygon` |
//! | `usemtl`, `mtllib` | the diffuse colour of the material; `mtllib` takes one name with spaces, or several |
//! | `p`, `l`, `curv`, `curv2`, `surf` | no surface; counted in [`MeshReport::ignored_elements`] |
//! | `vn x y z`, and `f` with `v//vn` or `v/vt/vn` | normals at the corners of triangles; see [`Mesh::normals`] |
//! | `vt u`, `vt u v`, `vt u v w`, and `f` with `v/vt` | texture coordinates at the corners, without `w` |
//! | groups, display attributes | ignored, with any content |
//! | any other line | ignored with a warning |
//!
//! Negative indices count back from the line that they are in. Positive indices may refer to vertices that come later
//! in the file. A backslash at the end of a line joins it with the next line, except in comments.
//!
//! Polygons are split by their positions alone, and each corner keeps its own normal and texture coordinate. `tobj`
//! never sees these: it would make a vertex for each combination. One that cannot be read is an error only if a face
//! uses it.
//!
//! Lines end with a line feed, a carriage return, or both. Text extends ASCII. It need not be UTF-8: other names are
//! taken as Latin-1. UTF-16 is refused.

mod attribute;
mod geometry;
mod material;
mod obj_lines;
mod write;

use std::path::Path;

use self::geometry::Geometry;
use self::obj_lines::ObjLines;
pub(crate) use self::write::{Materials, write_obj};
use super::mesh::Mesh;
use super::reader::CheckedReader;
use super::report::MeshReport;
use crate::error::Error;

/// Loads an OBJ file and the material files that it names. Triangles are in the order of the file's faces. Vertices are
/// in its order too, without those that no face uses.
///
/// A material file that does not exist is a warning.
///
/// # Errors
/// If a file cannot be read, if a line is not valid, or if there are no triangles.
pub fn load_obj(path: &Path) -> Result<(Mesh, MeshReport), Error> {
    let options = tobj::LoadOptions { single_index: true, ..Default::default() };
    let mut reader = CheckedReader::open(path, ObjLines::default())?;
    // The reader passes no objects, groups or materials on. So tobj makes one model, and its faces share vertices.
    let parsed = tobj::load_obj_buf(&mut reader, &options, |_| Err(tobj::LoadError::OpenFileFailed));
    let ((models, _), lines) = reader.finish(parsed)?;
    let has_attributes = lines.normals.is_used() || lines.texture_coordinates.is_used();
    let geometry = Geometry::new(&models, &lines, has_attributes);

    let mut warnings = Vec::new();
    let colors = lines.libraries.load(path, &mut warnings)?;
    let parts = lines.parts(&geometry.first_triangles, &colors, path, &mut warnings);
    warnings.extend(geometry.warnings(path));
    warnings.extend(lines.colored_vertices.warning(path, "vertex colour ignored"));
    warnings.extend(lines.unknown_keywords.warning(path, "unknown keyword, line ignored"));

    let ObjLines { vertices, ignored_elements, normals, texture_coordinates, .. } = lines;
    let mesh = Mesh::new(geometry.positions, geometry.triangles, parts).and_then(|mut mesh| {
        if normals.is_used() {
            let (values, corners) = normals.of_triangles(&geometry.corners);
            mesh = mesh.with_normals(values, corners)?;
        }
        if texture_coordinates.is_used() {
            let (values, corners) = texture_coordinates.of_triangles(&geometry.corners);
            mesh = mesh.with_texture_coordinates(values, corners)?;
        }
        Ok(mesh)
    });
    let mesh = mesh.map_err(|error| Error::in_file(path, error.to_string()))?;
    let report = MeshReport { vertices, degenerate: mesh.degenerate_triangles(), ignored_elements, warnings };
    Ok((mesh, report))
}
