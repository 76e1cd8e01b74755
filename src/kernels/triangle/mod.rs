//! Triangles. A hit satisfies `origin + t·dir = v0 + u·(v1 - v0) + v·(v2 - v0)`: three equations, three unknowns. The
//! textbook's barycentrics β and γ are `u` and `v`. Both sides hit; edges and vertices belong to the triangle
//! (`u >= 0`, `v >= 0`, `u + v <= 1`), and every kernel says what becomes of that under rounding.

mod baldwin_weber;
mod cramer;
mod kensler_shirley;
mod moller_trumbore;
mod moller_trumbore_f64;
mod pluecker;
mod woop;
#[cfg(fused)]
mod woop_dop;
mod woop_half_open;

pub use baldwin_weber::BaldwinWeber;
pub use cramer::Cramer;
pub use kensler_shirley::KenslerShirley;
pub use moller_trumbore::MollerTrumbore;
pub use moller_trumbore_f64::MollerTrumboreF64;
pub use pluecker::Pluecker;
pub use woop::{Shear, Shear8, Vertices, Woop};
#[cfg(fused)]
pub use woop_dop::WoopDop;
pub use woop_half_open::WoopHalfOpen;

use glam::{DVec3, Vec3};

use crate::geom::Triangle;

/// `(v1 - v0) × (v2 - v0)` in `f64`. Differences of `f32` of like size are exact in `f64`, and so is a product of two
/// of them, so that this is zero for a triangle of zero area, and its direction is good for any sliver.
fn normal(shape: &Triangle) -> DVec3 {
    let [v0, v1, v2] = shape.vertices().map(Vec3::as_dvec3);
    (v1 - v0).cross(v2 - v0)
}
