//! Triangles. A hit satisfies `origin + t·dir = v0 + u·(v1 - v0) + v·(v2 - v0)`: three equations, three unknowns. The
//! textbook's barycentrics β and γ are `u` and `v`. Both sides hit; edges and vertices belong to the triangle
//! (`u >= 0`, `v >= 0`, `u + v <= 1`), and every kernel says what becomes of that under rounding.

mod cramer;
mod moller_trumbore;

pub use cramer::Cramer;
pub use moller_trumbore::MollerTrumbore;
