//! The source of a scene: a built-in name or a file.

use std::path::{Path, PathBuf};

use super::builtin::BuiltIn;
use super::loaded::{LoadedScene, MESH_FILES, has_extension, is_mesh_file, load_mesh, mesh_remarks};
use super::scene_file::load_scene;
use crate::error::{Error, printable};
use crate::tracer::image::View;

/// A scene to load.
#[derive(Clone, Debug)]
pub enum SceneSource {
    /// A built-in scene.
    BuiltIn {
        /// The name as it was given, with its size.
        name: String,
        /// The scene and its size.
        scene: BuiltIn,
    },
    /// An OBJ, PLY or STL file.
    Mesh(PathBuf),
    /// A scene file.
    Toml(PathBuf),
}

impl SceneSource {
    /// Parses a built-in name, with or without a size, or the path of a mesh file or scene file. Does not open
    /// the file.
    ///
    /// # Errors
    /// If the argument is none of these, or if a size is not valid for the built-in scene.
    pub fn parse(argument: &str) -> Result<Self, Error> {
        if let Some(scene) = BuiltIn::parse(argument) {
            return Ok(Self::BuiltIn { name: argument.into(), scene: scene? });
        }
        let path = Path::new(argument);
        if is_mesh_file(path) {
            return Ok(Self::Mesh(path.into()));
        }
        if has_extension(path, "toml") {
            return Ok(Self::Toml(path.into()));
        }
        Err(Error::Argument {
            argument: argument.into(),
            message: format!(
                "not a scene: expected {MESH_FILES}, a scene file (*.toml) or one of {}",
                BuiltIn::NAMES.join(", ")
            ),
        })
    }

    /// The built-in name with its size, or the file's name without its folder. As tables and messages show it; see
    /// [`printable`].
    pub fn name(&self) -> String {
        match self {
            Self::BuiltIn { name, .. } => name.clone(),
            Self::Mesh(path) | Self::Toml(path) => {
                printable(&path.file_name().unwrap_or(path.as_os_str()).to_string_lossy())
            }
        }
    }

    /// What [`SceneSource::parse`] makes this of.
    #[cfg(feature = "study")]
    pub(crate) fn argument(&self) -> &std::ffi::OsStr {
        match self {
            Self::BuiltIn { name, .. } => name.as_ref(),
            Self::Mesh(path) | Self::Toml(path) => path.as_os_str(),
        }
    }

    /// Reads the files of the scene once, to find an error in them before long work. Does nothing for a pipe, which can
    /// be read only once, and for a built-in scene.
    ///
    /// # Errors
    /// If a file cannot be read or is not valid.
    pub fn check(&self) -> Result<(), Error> {
        match self {
            Self::Mesh(path) | Self::Toml(path) if path.metadata().is_ok_and(|file| !file.is_file()) => Ok(()),
            Self::BuiltIn { .. } => Ok(()),
            Self::Mesh(_) | Self::Toml(_) => self.load().map(drop),
        }
    }

    /// Makes the built-in scene or reads the files.
    ///
    /// # Errors
    /// If a file cannot be read or is not valid.
    pub fn load(&self) -> Result<LoadedScene, Error> {
        match self {
            Self::BuiltIn { scene, .. } => scene.load(),
            Self::Mesh(path) => {
                let (mesh, report) = load_mesh(path)?;
                let view = View::around(&mesh.bounds());
                Ok(LoadedScene { world: mesh.into(), view, remarks: mesh_remarks(report) })
            }
            Self::Toml(path) => load_scene(path),
        }
    }
}
