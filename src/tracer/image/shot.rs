//! How a picture is taken, and the hits of its rays.

use super::camera::Camera;
use super::view::Light;
use crate::geom::{Hit, Triangle};
use crate::kernels::Kernel;
use crate::tracer::scene::Scene;
use crate::tracer::trace::{Mode, trace};

/// How a picture is taken.
#[derive(Clone, Copy, Debug)]
pub struct Shot {
    /// The camera. Its aspect ratio should be that of the picture.
    pub camera: Camera,
    /// The light.
    pub light: Light,
    /// How rays are traced. The picture is the same in every mode.
    pub mode: Mode,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
}

/// The closest hits of a picture's rays, in the order of [`Camera::rays`].
pub fn picture_hits<K: Kernel<Shape = Triangle>>(scene: &Scene<K>, shot: &Shot) -> Vec<Hit<f32>> {
    trace(scene, &shot.camera.rays(shot.width, shot.height), shot.mode)
}
