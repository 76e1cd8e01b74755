//! A scene that is built and ready to be timed, together with the ray sets of a picture of it.

use std::time::Instant;

use super::ray_sets::{RaySet, ray_sets};
use crate::kernels::Kernel;
use crate::kernels::triangle::Exact;
use crate::tracer::{Error, LoadedScene, Scene, SceneSource};

/// The triangle kernel that the tracer is measured with, and its default. It is never wrong: a kernel that
/// leaks would be no fair base for comparing tracers.
pub type TracerKernel = Exact<f32>;

/// Width and height of every picture that is timed. All sections about the tracer have the same, so that the same rays
/// of the same scene appear in all of them.
pub(crate) const fn picture_size(quick: bool) -> u32 {
    if quick { 64 } else { 384 }
}

/// A scene that is ready to be timed, and the rays of a picture of it.
#[derive(Debug)]
pub(crate) struct BuiltScene {
    /// Scene name.
    pub(crate) name: String,
    pub(crate) scene: Scene<TracerKernel>,
    /// Seconds to build the scene, on all threads.
    pub(crate) build_seconds: f64,
    pub(crate) sets: [RaySet; 4],
}

impl BuiltScene {
    /// Builds the scene, and makes the ray sets of a picture of `size` × `size` pixels.
    ///
    /// # Errors
    /// If the scene cannot be loaded.
    pub(crate) fn new(source: &SceneSource, (size, seed): (u32, u64)) -> Result<Self, Error> {
        let LoadedScene { world, view, .. } = source.load()?;
        let start = Instant::now();
        let scene = Scene::new(world);
        let build_seconds = start.elapsed().as_secs_f64();
        let sets = ray_sets(&scene, &view, size, seed);
        Ok(Self { name: source.name(), scene, build_seconds, sets })
    }

    /// ID of the triangle kernel.
    pub(crate) fn kernel(&self) -> String {
        TracerKernel::INFO.id.to_string()
    }

    /// Bytes of geometry, instances, nodes and prepared primitives, divided by the number of primitives. A primitive
    /// counts once, however many instances it has.
    pub(crate) fn bytes_per_triangle(&self) -> f64 {
        self.scene.bytes() as f64 / self.scene.primitives() as f64
    }
}
