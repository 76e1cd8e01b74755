//! Rays, hits and shapes: plain data, generic over the lane type, and the arithmetic that keeps twins identical.

mod hit;
pub mod lanes;
mod ray;
mod shapes;

pub use hit::Hit;
pub use lanes::{Lanes, Mask8, Vec3x8};
pub use ray::Ray;
pub use shapes::{Aabb, Placed, Quadric, Shape, Triangle};
