//! Scenes that come with the crate: scene files like any other, so that they need no more code than a user's, and show how
//! it is done.

use std::path::Path;

use super::loaded::LoadedScene;
use super::scene_file;
use crate::error::Error;
use crate::tracer::meshes::generator::{DEFAULT_SIZE, parse_size};

/// A built-in scene of a chosen size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuiltIn {
    /// Which of [`SCENES`].
    number: usize,
    size: u32,
}

struct Scene {
    name: &'static str,
    text: &'static str,
    /// What its size counts.
    unit: Option<&'static str>,
}

const SCENES: [Scene; 5] = [
    Scene { name: "room", text: include_str!("builtin/room.toml"), unit: Some("triangles") },
    Scene { name: "terrain", text: include_str!("builtin/terrain.toml"), unit: Some("triangles") },
    Scene { name: "sphere", text: include_str!("builtin/sphere.toml"), unit: Some("triangles") },
    Scene { name: "forest", text: include_str!("builtin/forest.toml"), unit: Some("trees") },
    Scene { name: "gallery", text: include_str!("builtin/gallery.toml"), unit: None },
];

impl BuiltIn {
    /// The names, for help texts. A size may follow all but the last; see [`BuiltIn::parse`].
    pub const NAMES: [&str; SCENES.len()] = {
        let mut names = [""; SCENES.len()];
        let mut number = 0;
        while number < SCENES.len() {
            names[number] = SCENES[number].name;
            number += 1;
        }
        names
    };

    /// Understands `NAME` and `NAME:SIZE`, or returns `None` if this is no name of a built-in scene. The size is
    /// `small` (10,000), `medium` (100,000; this is the default), `large` (1,000,000) or a number from 1,000 to
    /// 10,000,000, also written `1e6` or `1_000_000`. It counts the trees of the forest, and the triangles of `room`,
    /// `terrain` and `sphere`, which have as many as asked for, or the next number they can be made of. The gallery, of
    /// quadrics, has no size.
    ///
    /// # Errors
    /// If the size is none of these.
    pub fn parse(argument: &str) -> Option<Result<Self, Error>> {
        let (name, size) = match argument.split_once(':') {
            Some((name, size)) => (name, Some(size)),
            None => (argument, None),
        };
        let number = SCENES.iter().position(|scene| scene.name == name)?;
        let size = match (size, SCENES[number].unit) {
            (None, _) => Ok(DEFAULT_SIZE),
            (Some(size), Some(unit)) => parse_size(size, unit),
            (Some(_), None) => Err(format!("the {name} has no size")),
        };
        Some(
            size.map(|size| Self { number, size })
                .map_err(|message| Error::Argument { argument: argument.into(), message }),
        )
    }

    /// The scene file, in which generators and scatters without a size of their own take the size that was asked for.
    pub fn text(&self) -> &'static str {
        SCENES[self.number].text
    }

    pub(crate) fn load(&self) -> Result<LoadedScene, Error> {
        let Scene { name, text, .. } = SCENES[self.number];
        scene_file::from_text(Path::new(&format!("{name}.toml")), text, Some(self.size))
    }
}
