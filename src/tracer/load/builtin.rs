//! Built-in scenes. They are ordinary scene files, so they need no code of their own, and they serve as examples.

use std::path::Path;

use super::loaded::LoadedScene;
use super::scene_file;
use crate::error::Error;
use crate::tracer::meshes::generator::{DEFAULT_SIZE, parse_size};

/// A built-in scene and its size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuiltIn {
    /// Index into [`SCENES`].
    number: usize,
    size: u32,
}

struct Entry {
    name: &'static str,
    /// The scene file.
    text: &'static str,
    /// The things that the size counts. `None`: the scene has no size.
    unit: Option<&'static str>,
}

const SCENES: [Entry; 5] = [
    Entry { name: "room", text: include_str!("builtin/room.toml"), unit: Some("triangles") },
    Entry { name: "terrain", text: include_str!("builtin/terrain.toml"), unit: Some("triangles") },
    Entry { name: "sphere", text: include_str!("builtin/sphere.toml"), unit: Some("triangles") },
    Entry { name: "forest", text: include_str!("builtin/forest.toml"), unit: Some("trees") },
    Entry { name: "gallery", text: include_str!("builtin/gallery.toml"), unit: None },
];

impl BuiltIn {
    /// The names. All but the last may be followed by a size; see [`BuiltIn::parse`].
    pub const NAMES: [&str; SCENES.len()] = {
        let mut names = [""; SCENES.len()];
        let mut number = 0;
        while number < SCENES.len() {
            names[number] = SCENES[number].name;
            number += 1;
        }
        names
    };

    /// Parses `NAME` or `NAME:SIZE`. Returns `None` if the name is not that of a built-in scene.
    ///
    /// The size is `small` (10,000), `medium` (100,000, the default), `large` (1,000,000), or a whole number from 1,000
    /// to 10,000,000. Forms like `1e6` and `1_000_000` are numbers too. The size of `room`, `terrain` and `sphere` is
    /// the number of triangles; the scene has that many or the next larger number that its shape allows. The size of
    /// `forest` is the number of trees. `gallery` consists of quadrics and has no size.
    ///
    /// # Errors
    /// If the size is not valid, or if the scene has no size.
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

    /// The scene file. In it, generators and scatters without a size of their own get the size of this value.
    pub fn text(&self) -> &'static str {
        SCENES[self.number].text
    }

    pub(crate) fn load(&self) -> Result<LoadedScene, Error> {
        let Entry { name, text, .. } = SCENES[self.number];
        scene_file::from_text(Path::new(&format!("{name}.toml")), text, Some(self.size))
    }
}
