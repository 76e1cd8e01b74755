//! Where a scene comes from: a built-in name or a file.

use std::path::{Path, PathBuf};

use super::{BuiltIn, Error, ObjReport, View, World, load_obj, load_scene};

/// A scene that has been named but not yet loaded.
#[derive(Clone, Debug)]
pub enum SceneSource {
    /// In this crate.
    BuiltIn {
        /// As it was named.
        name: String,
        /// What to make.
        scene: BuiltIn,
    },
    /// An OBJ file.
    Obj(PathBuf),
    /// A scene file.
    Toml(PathBuf),
}

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

impl SceneSource {
    /// Understands a built-in name, with or without a size, and the path of an OBJ file or a scene file. A file is not yet
    /// looked at.
    ///
    /// # Errors
    /// If the name is none of these, or the size is not one that the built-in scene comes in.
    pub fn parse(argument: &str) -> Result<Self, Error> {
        if let Some(scene) = BuiltIn::parse(argument) {
            return Ok(Self::BuiltIn { name: argument.into(), scene: scene? });
        }
        let path = Path::new(argument);
        if has_extension(path, "obj") {
            return Ok(Self::Obj(path.into()));
        }
        if has_extension(path, "toml") {
            return Ok(Self::Toml(path.into()));
        }
        Err(Error::Argument {
            argument: argument.into(),
            message: format!(
                "not a scene: expected an OBJ file (*.obj), a scene file (*.toml) or one of {}",
                BuiltIn::NAMES.join(", ")
            ),
        })
    }

    /// The built-in name, or the file's name without its folder.
    pub fn name(&self) -> String {
        match self {
            Self::BuiltIn { name, .. } => name.clone(),
            Self::Obj(path) | Self::Toml(path) => {
                path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
            }
        }
    }

    /// Makes the scene, or reads its files.
    ///
    /// # Errors
    /// If a file cannot be read or makes no sense.
    pub fn load(&self) -> Result<LoadedScene, Error> {
        match self {
            Self::BuiltIn { scene, .. } => scene.load(),
            Self::Obj(path) => {
                let (mesh, report) = load_obj(path)?;
                let view = View::around(&mesh.bounds());
                Ok(LoadedScene { world: mesh.into(), view, remarks: remarks(report) })
            }
            Self::Toml(path) => load_scene(path),
        }
    }
}

/// Whether a file's name ends like this, in letters of any case.
pub(super) fn has_extension(path: &Path, expected: &str) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(expected))
}

pub(super) fn remarks(report: ObjReport) -> Vec<String> {
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
