//! The tables of a scene file, one struct each. `toml` refuses everything else and names the place.

use std::path::PathBuf;

use serde::Deserialize;
use toml::Spanned;

use super::number::{Array, Color, Count, FieldOfView, Finite, Fraction, Length, Point, Seed};
use super::quadric::QuadricTable;
use super::transform::{Step2, Step3, Steps};

/// A whole file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SceneFile {
    pub(super) camera: Option<Spanned<Camera>>,
    pub(super) light: Option<Spanned<Light>>,
    #[serde(default)]
    pub(super) mesh: Vec<Spanned<Mesh>>,
    #[serde(default)]
    pub(super) quadric: Vec<Spanned<QuadricTable>>,
    #[serde(default)]
    pub(super) instance: Vec<Spanned<Instance>>,
    #[serde(default)]
    pub(super) scatter: Vec<Spanned<Scatter>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Camera {
    pub(super) eye: Point,
    pub(super) look_at: Point,
    pub(super) field_of_view: Option<FieldOfView>,
    pub(super) transform: Option<Steps<Step3>>,
}

/// Either a point or a direction.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Light {
    pub(super) point: Option<Point>,
    pub(super) direction: Option<Spanned<Point>>,
}

/// A name, and either a file or a generator.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Mesh {
    pub(super) name: Spanned<String>,
    pub(super) file: Option<Spanned<PathBuf>>,
    pub(super) generator: Option<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Instance {
    pub(super) of: Spanned<String>,
    pub(super) transform: Option<Steps<Step3>>,
    pub(super) color: Option<Color>,
    pub(super) checker: Option<Checker>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Checker {
    pub(super) colors: Array<Color, 2>,
    pub(super) transform: Option<Steps<Step2>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Scatter {
    pub(super) of: Spanned<String>,
    /// Optional in built-in scenes only: there the default is the size of the scene.
    pub(super) count: Option<Spanned<Count>>,
    pub(super) seed: Option<Seed>,
    pub(super) on: Option<Spanned<String>>,
    pub(super) area: Option<Spanned<Area>>,
    pub(super) transform: Option<Steps<Step3>>,
    pub(super) scale: Option<Spanned<Array<Length, 2>>>,
    pub(super) lean: Option<Fraction>,
    pub(super) color: Option<Color>,
    pub(super) checker: Option<Checker>,
}

/// A rectangle in x and z.
#[derive(Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Area {
    pub(super) lo: Array<Finite, 2>,
    pub(super) hi: Array<Finite, 2>,
}
