//! Where a scene comes from: a built-in name or a file.

use std::path::{Path, PathBuf};

use super::builtin::BuiltIn;
use super::loaded::{LoadedScene, has_extension, remarks};
use super::scene_file::load_scene;
use crate::error::Error;
use crate::tracer::image::View;
use crate::tracer::meshes::load_obj;

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
