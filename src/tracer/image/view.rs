//! How a scene is seen: the camera's position and direction, and the light.

use glam::{Affine3, Vec3};

use super::camera::Camera;
use crate::geom::Aabb;

/// A camera for pictures of any size and aspect ratio, and a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Position of the camera.
    pub eye: Vec3,
    /// The point that appears in the middle of the picture.
    pub look_at: Vec3,
    /// Vertical field of view in degrees.
    pub vertical_fov: f32,
    /// A transform that is applied to the camera, if any; see [`Camera::transformed`].
    pub transform: Option<Affine3>,
    /// The light.
    pub light: Light,
}

/// A light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// A point light at this position.
    Point(Vec3),
    /// A light at infinity. The vector points towards it and may have any length.
    Directional(Vec3),
}

impl View {
    /// A view of a whole box from outside: from the front, the right and above. The light is directional and comes from
    /// high above, behind the camera.
    pub fn around(bounds: &Aabb) -> Self {
        const VERTICAL_FOV: f32 = 40.0;
        let radius = (bounds.extent().as_dvec3().length() * 0.5) as f32;
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

/// Parses a point or vector as written on a command line: `1,2.5,-3`.
///
/// # Errors
/// If the text is not three finite numbers, separated by commas.
pub fn parse_point(text: &str) -> Result<Vec3, String> {
    let numbers: Vec<f32> =
        text.split(',').filter_map(|number| number.trim().parse().ok()).filter(|x: &f32| x.is_finite()).collect();
    match numbers[..] {
        [x, y, z] if text.split(',').count() == 3 => Ok(Vec3::new(x, y, z)),
        _ => Err("expected three numbers, such as 1,2.5,-3".into()),
    }
}
