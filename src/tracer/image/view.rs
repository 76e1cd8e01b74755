//! From where a scene is seen, and what shines on it.

use glam::{Affine3, Vec3};

use super::camera::Camera;
use crate::geom::Aabb;

/// A camera for pictures of any size, and a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Where the camera is.
    pub eye: Vec3,
    /// The point in the middle of the picture.
    pub look_at: Vec3,
    /// Vertical field of view in degrees.
    pub vertical_fov: f32,
    /// What is applied to the camera that these describe, if anything.
    pub transform: Option<Affine3>,
    /// The light.
    pub light: Light,
}

/// What shines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// From a point, in all directions.
    Point(Vec3),
    /// From infinitely far; the vector points towards the light and may have any length.
    Directional(Vec3),
}

impl View {
    /// From outside a box, with all of it in view, from the front, the right and above; the light is high above behind the
    /// camera.
    pub fn around(bounds: &Aabb) -> Self {
        const VERTICAL_FOV: f32 = 40.0;
        let radius = bounds.extent().length() * 0.5;
        let distance = radius / (VERTICAL_FOV.to_radians() * 0.5).sin();
        let eye = bounds.center() + Vec3::new(0.5, 0.4, 1.0).normalize() * distance;
        let light = Light::Directional(Vec3::new(0.3, 1.0, 0.25));
        Self { eye, look_at: bounds.center(), vertical_fov: VERTICAL_FOV, transform: None, light }
    }

    /// The camera for a `width` × `height` picture.
    pub fn camera(&self, width: u32, height: u32) -> Camera {
        let camera = Camera::new(self.eye, self.look_at, self.vertical_fov, width, height);
        self.transform.map_or(camera, |transform| camera.transformed(&transform))
    }
}

/// Understands a point or vector as it is given on a command line: `1,2.5,-3`.
///
/// # Errors
/// Says what was expected instead.
pub fn parse_point(text: &str) -> Result<Vec3, String> {
    let numbers: Vec<f32> =
        text.split(',').filter_map(|number| number.trim().parse().ok()).filter(|x: &f32| x.is_finite()).collect();
    match numbers[..] {
        [x, y, z] if text.split(',').count() == 3 => Ok(Vec3::new(x, y, z)),
        _ => Err("expected three numbers, such as 1,2.5,-3".into()),
    }
}
