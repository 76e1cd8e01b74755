//! A loaded scene, and remarks about what was left out.

use std::path::Path;

use crate::tracer::image::View;
use crate::tracer::meshes::ObjReport;
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
