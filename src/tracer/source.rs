//! Where a scene comes from: a built-in name or a file.

use std::path::{Path, PathBuf};

use glam::Vec3;

use super::{BuiltIn, Camera, Error, Light, Mesh, ObjReport, load_obj};

/// A scene that has been named but not yet loaded.
#[derive(Clone, Debug)]
pub enum SceneSource {
    /// Made by code.
    BuiltIn {
        /// As it was named.
        name: String,
        /// What to make.
        scene: BuiltIn,
    },
    /// An OBJ file.
    Obj(PathBuf),
}

impl SceneSource {
    /// Understands a built-in name, with or without a size, and the path of an OBJ file. A file is not yet looked at.
    ///
    /// # Errors
    /// If the name is neither, or the size is not one that the built-in scene comes in.
    pub fn parse(argument: &str) -> Result<Self, Error> {
        if let Some(scene) = BuiltIn::parse(argument) {
            return Ok(Self::BuiltIn { name: argument.into(), scene: scene? });
        }
        let path = Path::new(argument);
        if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("obj")) {
            return Ok(Self::Obj(path.into()));
        }
        Err(Error::Argument {
            argument: argument.into(),
            message: format!("not a scene: expected an OBJ file (*.obj) or one of {}", BuiltIn::NAMES.join(", ")),
        })
    }

    /// The built-in name, or the file's name without its folder.
    pub fn name(&self) -> String {
        match self {
            Self::BuiltIn { name, .. } => name.clone(),
            Self::Obj(path) => path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned(),
        }
    }

    /// Makes or reads the mesh, with a remark for whatever in the file did not become part of it or cannot be hit.
    ///
    /// # Errors
    /// If the file cannot be read or makes no sense.
    pub fn load(&self) -> Result<(Mesh, Vec<String>), Error> {
        match self {
            Self::BuiltIn { scene, .. } => Ok((scene.mesh(), Vec::new())),
            Self::Obj(path) => load_obj(path).map(|(mesh, report)| (mesh, remarks(report))),
        }
    }

    /// The scene's own camera and light; for a file, a camera outside that has all of it in view, and a light from high
    /// above behind it.
    pub fn view(&self, mesh: &Mesh, width: u32, height: u32) -> (Camera, Light) {
        match self {
            Self::BuiltIn { scene, .. } => {
                let (eye, look_at, vertical_fov) = scene.camera();
                (Camera::new(eye, look_at, vertical_fov, width, height), scene.light())
            }
            Self::Obj(_) => {
                (Camera::around(&mesh.bounds(), 40.0, width, height), Light::Directional(Vec3::new(0.3, 1.0, 0.25)))
            }
        }
    }
}

fn remarks(report: ObjReport) -> Vec<String> {
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
