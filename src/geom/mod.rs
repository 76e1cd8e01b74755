//! Rays, hits and shapes: plain data, generic over the lane type. [`lanes`] is the arithmetic that keeps twins
//! identical, and [`transform`] the affine transforms.

mod candidate;
mod hit;
pub mod lanes;
mod ray;
#[cfg(feature = "serde")]
mod serialize;
mod shapes;
pub mod transform;

pub use candidate::Candidate;
pub use hit::Hit;
pub use lanes::{Lanes, Mask8, Vec3x8};
pub use ray::Ray;
pub use shapes::{Aabb, Placed, Quadric, Shape, Triangle};
pub(crate) use transform::is_singular;
pub use transform::{Axis, InvalidTransform, Transform2, Transform3};
