//! A loaded scene, and the remarks that loading left.

use std::path::Path;

use crate::tracer::image::View;
use crate::tracer::meshes::ObjReport;
use crate::tracer::scene::World;

/// All there is to know of a scene.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    /// What rays hit.
    pub world: World,
    /// The scene's own camera and light, or [`View::around`] it.
    pub view: View,
    /// One line each: whatever in the files did not become part of the world, or cannot be hit.
    pub remarks: Vec<String>,
}

/// Whether a file's name ends like this, in letters of any case.
pub(crate) fn has_extension(path: &Path, expected: &str) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(expected))
}

pub(crate) fn remarks(report: ObjReport) -> Vec<String> {
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
