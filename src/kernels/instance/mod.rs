//! Instances: a primitive, or a whole scene, put into the world by an affine transform.
//!
//! Instead of the shape, the ray is transformed, by the inverse: `origin' = L⁻¹(origin - T)`, `dir' = L⁻¹ dir`, where
//! `x ↦ L x + T` takes the object to the world. The direction is never renormalised, so `t` means the same in both
//! spaces, and the interval is taken over as it is.

mod subtract_first;

pub use subtract_first::{Instance, SingularTransform};
