//! A loaded scene, and remarks about what was left out.

use std::fs;
use std::path::Path;

use crate::error::Error;
use crate::tracer::image::View;
use crate::tracer::memory::check_memory;
use crate::tracer::meshes::{Mesh, MeshReport, load_obj, load_ply, load_stl};
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
pub(super) fn has_extension(path: &Path, expected: &str) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(expected))
}

type MeshLoader = fn(&Path) -> Result<(Mesh, MeshReport), Error>;

/// The loader of each extension. [`MESH_FILES`] names them.
const LOADERS: [(&str, MeshLoader); 3] = [("obj", load_obj), ("ply", load_ply), ("stl", load_stl)];

/// The mesh files that are read, for messages.
pub(super) const MESH_FILES: &str = "an OBJ, PLY or STL file (*.obj, *.ply, *.stl)";

fn mesh_loader(path: &Path) -> Option<MeshLoader> {
    LOADERS.into_iter().find(|(extension, _)| has_extension(path, extension)).map(|(_, loader)| loader)
}

/// Whether the extension is that of a mesh file.
pub(super) fn is_mesh_file(path: &Path) -> bool {
    mesh_loader(path).is_some()
}

/// Loads a mesh from an OBJ, PLY or STL file, by its extension, if there is memory for it. See [`load_obj`],
/// [`load_ply`] and [`load_stl`].
///
/// # Errors
/// If the extension is another, or if the file cannot be read or is not valid.
pub fn load_mesh(path: &Path) -> Result<(Mesh, MeshReport), Error> {
    let load = mesh_loader(path).ok_or_else(|| Error::in_file(path, format!("expected {MESH_FILES}")))?;
    // Numbers take less memory than their text, but they are in memory twice while the mesh is made.
    let bytes = fs::metadata(path).map_or(0, |file| file.len());
    check_memory(bytes as usize).map_err(|message| Error::in_file(path, message))?;
    load(path)
}

/// The remarks about a mesh file.
pub(super) fn mesh_remarks(report: MeshReport) -> Vec<String> {
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
