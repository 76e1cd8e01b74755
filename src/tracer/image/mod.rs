//! Pictures of a scene: camera, light, shading, comparison of two pictures.

mod camera;
mod picture;
mod view;

pub use camera::{Camera, block_order};
pub use picture::{Differences, OCCLUSION_RAYS, Picture, Shade, Shot, compare, picture_hits, shade};
#[cfg(feature = "study")]
pub(crate) use picture::{OCCLUSION_REACH, hemisphere_rays, shadow_rays};
pub use view::{Light, View, parse_point};
