//! Camera and light of a scene file.

use glam::Vec3;

use super::error::{SceneError, SpanError};
use super::format::SceneFile;
use super::transform::compose3;
use crate::tracer::image::{Light, View};
use crate::tracer::scene::World;

/// Vertical field of view in degrees, if the file gives none.
const DEFAULT_FIELD_OF_VIEW: f32 = 45.0;

/// The view of a scene file. What the file does not give is that of [`View::around`].
pub(super) fn view(file: &SceneFile, world: &World) -> Result<View, SceneError> {
    let mut view = View::around(&world.bounds());
    if let Some(camera) = &file.camera {
        let (span, camera) = (camera.span(), camera.get_ref());
        view.eye = camera.eye.0;
        view.look_at = camera.look_at.0;
        view.vertical_fov = camera.field_of_view.map_or(DEFAULT_FIELD_OF_VIEW, |degrees| degrees.0);
        view.transform = camera.transform.as_ref().map(compose3).transpose()?;
        if view.look_at == view.eye {
            let message = format!("eye and look_at give no direction: {} and {}", view.eye, view.look_at);
            return Err(SpanError::new(span, message).into());
        }
    }
    if let Some(light) = &file.light {
        view.light = match (&light.get_ref().point, &light.get_ref().direction) {
            (Some(point), None) => Light::Point(point.0),
            (None, Some(direction)) if direction.get_ref().0 != Vec3::ZERO => Light::Directional(direction.get_ref().0),
            (None, Some(direction)) => {
                let message = format!("no direction: {}", direction.get_ref().0);
                return Err(SpanError::new(direction.span(), message).into());
            }
            _ => return Err(SpanError::new(light.span(), "a light needs either point or direction").into()),
        };
    }
    Ok(view)
}
