//! Camera and light of a scene file.

use glam::Vec3;

use super::error::{SceneError, SpanError};
use super::format::SceneFile;
use super::transform::compose3;
use crate::geom::Aabb;
use crate::tracer::image::{Light, View};
use crate::tracer::scene::{Geometry, World};

/// Vertical field of view in degrees, if the file gives none.
const DEFAULT_FIELD_OF_VIEW: f32 = 45.0;

/// The view of a scene file. What the file does not give is that of [`View::around`].
pub(super) fn view(file: &SceneFile, world: &World) -> Result<View, SceneError> {
    let mut view = View::around(&world_bounds(world));
    if let Some(camera) = &file.camera {
        let (span, camera) = (camera.span(), camera.get_ref());
        view.eye = camera.eye.0;
        view.look_at = camera.look_at.0;
        view.vertical_fov = camera.field_of_view.map_or(DEFAULT_FIELD_OF_VIEW, |degrees| degrees.0);
        view.transform = camera.transform.as_ref().map(compose3).transpose()?;
        if (view.look_at - view.eye).try_normalize().is_none() {
            let message = format!("eye and look_at give no direction: {} and {}", view.eye, view.look_at);
            return Err(SpanError::new(span, message).into());
        }
    }
    if let Some(light) = &file.light {
        view.light = match (&light.get_ref().point, &light.get_ref().direction) {
            (Some(point), None) => Light::Point(point.0),
            (None, Some(direction)) if direction.get_ref().0.try_normalize().is_some() => {
                Light::Directional(direction.get_ref().0)
            }
            (None, Some(direction)) => {
                let message = format!("no direction: {}", direction.get_ref().0);
                return Err(SpanError::new(direction.span(), message).into());
            }
            _ => return Err(SpanError::new(light.span(), "a light needs either point or direction").into()),
        };
    }
    Ok(view)
}

/// A box around all instances. It may be off by rounding, so it serves only to place a camera.
fn world_bounds(world: &World) -> Aabb {
    let object_bounds: Vec<_> = world.geometries().iter().map(Geometry::bounds).collect();
    world.instances().iter().fold(Aabb::EMPTY, |bounds, placement| {
        let Aabb { lo, hi } = object_bounds[placement.geometry as usize];
        (0..8).fold(bounds, |bounds, corner| {
            let corner = Vec3::select(glam::BVec3::new(corner & 1 != 0, corner & 2 != 0, corner & 4 != 0), hi, lo);
            bounds.including(placement.object_to_world.transform_point3(corner))
        })
    })
}
