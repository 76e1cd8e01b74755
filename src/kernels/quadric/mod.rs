//! Quadrics: the roots of the polynomial of second degree that the surface's equation becomes along a ray, of which those
//! within the surface's clip box are candidates.

mod naive;

pub use naive::Naive;
