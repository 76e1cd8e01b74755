//! A loaded scene, and remarks about what was left out.

use std::fs;
use std::path::Path;

use crate::error::Error;
use crate::tracer::image::View;
use crate::tracer::memory::check_memory;
use crate::tracer::meshes::{Mesh, ObjReport, load_obj};
use crate::tracer::scene::World;

/// What loading a scene gives.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    /// The geometries and their instances.
    pub world: World,
    /// Camera and light of the scene file. What the file does not give comes from [`View::around`].
    pub view: View,
    /// One line each: parts of the files that are not in the world, or that no ray can hit.
    pub remarks: Vec<String>,
}

/// Whether a file has this extension, in upper or lower case.
pub(crate) fn has_extension(path: &Path, expected: &str) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(expected))
}

/// Loads an OBJ file if there is memory for it.
pub(super) fn load_mesh(path: &Path) -> Result<(Mesh, ObjReport), Error> {
    // Numbers take less memory than their text, but they are in memory twice while the mesh is made.
    let bytes = fs::metadata(path).map_or(0, |file| file.len());
    check_memory(bytes as usize).map_err(|message| Error::in_file(path, message))?;
    load_obj(path)
}

/// The remarks about an OBJ file.
pub(crate) fn obj_remarks(report: ObjReport) -> Vec<String> {
    let mut remarks = Vec::new();
    if report.degenerate > 0 {
        remarks.push(format!("triangles of zero area, which no ray hits: {}", report.degenerate));
    }
    if report.ignored_elements > 0 {
        remarks.push(format!("points, lines and curves, ignored: {}", report.ignored_elements));
    }
    remarks.extend(report.warnings);
    remarks
}
