//! What is traced: geometries and their instances, and the two-level scene that a kernel makes of them.

mod crossings;
mod faces;
mod filtered;
mod instance;
mod spawn;
mod surface;
mod traverse;
mod two_level;
mod world;
mod world_box;

pub use faces::{Disc, Face};
pub use filtered::Filtered;
#[cfg(feature = "study")]
pub(crate) use spawn::Leaving;
pub use surface::SurfacePoint;
pub(crate) use traverse::{Scratch, Visible};
pub use two_level::Scene;
pub(crate) use world::is_singular;
pub use world::{Checker, Geometry, Paint, Placement, World, WorldError};
