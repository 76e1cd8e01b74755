//! Pictures of a scene: camera, light, shading, comparison of two kernels.

mod camera;
mod check;
mod compare;
mod picture;
mod secondary;
mod shade;
mod shot;
mod view;

pub use camera::{Camera, block_order};
pub use check::ViewError;
pub use compare::{Differences, compare, mark_colors};
pub use picture::Picture;
#[cfg(feature = "study")]
pub(crate) use secondary::{hemisphere_rays, shadow_rays, surfaces};
#[cfg(feature = "study")]
pub(crate) use shade::OCCLUSION_REACH;
pub use shade::{OCCLUSION_RAYS, Shade, shade};
pub use shot::{Shot, picture_hits};
pub use view::{Light, View, parse_point};
