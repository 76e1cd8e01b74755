//! Views that give no picture: without a direction, or beyond the range of numbers that kernels compute with.

use glam::Vec3;
use thiserror::Error;

use super::view::{Light, View};
use crate::tracer::scene::{Geometry, World};

/// The smallest and the largest sizes and distances. With these, products of three of them and of a triangle's edges
/// neither vanish nor overflow in `f32`, in any kernel.
const RANGE: std::ops::RangeInclusive<f64> = 1e-10..=1e12;
/// The farthest that the eye may be, in sizes of the scene. From there the scene covers ten steps of a direction in
/// `f32`.
const FARTHEST: f64 = 1e6;

/// Why a view gives no picture.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ViewError {
    /// The eye and the point that it looks at are equal.
    #[error("the camera has no direction: eye and look-at are both {0}")]
    NoDirection(Vec3),
    /// A directional light has a direction of length zero.
    #[error("the light has no direction: {0}")]
    NoLight(Vec3),
    /// A size or distance is out of range: what it is, and its value.
    #[error(
        "{0} is {value}, but pictures need values from {least:e} to {most:e}: move or scale the scene",
        value = short(*.1),
        least = RANGE.start(),
        most = RANGE.end()
    )]
    OutOfRange(&'static str, f64),
    /// The scene is smaller than a step between two directions.
    #[error("the eye is {} times the scene's size away, at most {FARTHEST:e} can be seen", short(*.0))]
    TooFar(f64),
}

/// With as few digits as an `f32` needs.
fn short(value: f64) -> String {
    let rounded = value as f32;
    if rounded.is_finite() { format!("{rounded:e}") } else { format!("{value:e}") }
}

fn check_range(what: &'static str, value: f64) -> Result<(), ViewError> {
    if RANGE.contains(&value) { Ok(()) } else { Err(ViewError::OutOfRange(what, value)) }
}

/// A place may be at the origin.
fn check_place(what: &'static str, place: Vec3) -> Result<(), ViewError> {
    // The maximum of a vector may skip a NaN.
    let farthest = if place.is_nan() { f64::NAN } else { f64::from(place.abs().max_element()) };
    if farthest <= *RANGE.end() { Ok(()) } else { Err(ViewError::OutOfRange(what, farthest)) }
}

impl View {
    /// Finds out whether this view of the world can give a picture.
    ///
    /// # Errors
    /// The first thing in its way. A view whose camera looks past the scene is no error.
    pub fn check(&self, world: &World) -> Result<(), ViewError> {
        let bounds = world.bounds();
        let size = bounds.diagonal();
        check_range("the size of the scene", size)?;
        for place in [bounds.lo, bounds.hi] {
            check_place("the largest coordinate of the scene", place)?;
        }
        for geometry in world.geometries() {
            let bounds = geometry.bounds();
            let (size, place) = match geometry {
                Geometry::Mesh(_) => ("the size of a mesh", "the largest coordinate of a mesh"),
                Geometry::Quadric(_) | Geometry::Faces(_) => {
                    ("the size of a quadric", "the largest coordinate of a quadric")
                }
            };
            check_range(size, bounds.diagonal())?;
            check_place(place, bounds.lo.abs().max(bounds.hi.abs()))?;
        }
        if self.eye == self.look_at {
            return Err(ViewError::NoDirection(self.eye));
        }
        let eye = self.transform.map_or(self.eye, |transform| transform.transform_point3(self.eye));
        check_place("the largest coordinate of the eye", eye)?;
        check_place("the largest coordinate of look-at", self.look_at)?;
        match self.light {
            Light::Point(position) => check_place("the largest coordinate of the light", position)?,
            Light::Directional(Vec3::ZERO) => return Err(ViewError::NoLight(Vec3::ZERO)),
            Light::Directional(_) => {}
        }
        let distance = (eye.as_dvec3() - eye.clamp(bounds.lo, bounds.hi).as_dvec3()).length() / size;
        if distance <= FARTHEST { Ok(()) } else { Err(ViewError::TooFar(distance)) }
    }
}
