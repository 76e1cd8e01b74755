//! Loading scenes: mesh files, scene files in TOML, and built-in scenes. Writing scene files.

mod builtin;
mod loaded;
mod scene_file;
mod source;

pub use builtin::BuiltIn;
pub use loaded::{LoadedScene, load_mesh};
pub use scene_file::{load_scene, write_scene};
pub use source::SceneSource;
