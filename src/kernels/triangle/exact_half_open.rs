//! `triangle/exact_half_open`: the exact test with an exact tie rule. A line crosses a closed mesh an even number of
//! times.
//!
//! **Source:** as `triangle/exact`. The tie rule is a symbolic perturbation: H. Edelsbrunner, E. P. Mücke, "Simulation
//! of Simplicity", 1990.
//!
//! **Idea:** imagine the ray's origin moved by (ε, ε², ε³), for an ε smaller than any distance. Then the ray meets no
//! edge. The weight of the edge from `p` to `q` is the volume `((p - o) × (q - o))·d`. Its gradient in `o` is
//! `(p - q) × d`. Where the weight is zero, the first component of the gradient that is not zero decides. Its sign is
//! exact too. For the edge walked the other way, the decision is the opposite.
//!
//! **Edges:** half-open, as in `triangle/woop_half_open`. At the rim of a mesh, a ray exactly on an edge hits on one
//! side and misses on the other.
//!
//! **Claims:** every ray that is not exactly on an edge is decided as without rounding. A ray through a mesh hits
//! exactly one triangle, also through an edge or a vertex. Seen along the ray, the triangles of a closed mesh lie in an
//! even number of layers above every point that is on no edge. So the line of a ray hits an even number of triangles,
//! at silhouettes too. `triangle/woop_half_open` breaks that on a small grid of points already.
//!
//! **Degenerate input:** as `triangle/exact`. An edge that is parallel to the ray has no gradient. Its triangle is
//! parallel to the ray too, and misses.
//!
//! **Bound, range, operations:** as `triangle/exact`. Ties are examined only after the exact stage.

use glam::DVec3;
use wide::f32x8;

use super::exact::{Exact, OPERATIONS, Rule, SETUP_OPERATIONS, Separate, setup, setup8, variant};
use crate::geom::lanes::Lanes;
use crate::geom::{Candidate, Ray, Triangle};
use crate::kernels::aabb::Slabs;
use crate::kernels::volume::ExactSum;
use crate::kernels::{Claim, Id, Info, Intersect, Kernel};

variant! {
    /// Triangles for the exact half-open test.
    ExactHalfOpen, HalfOpen, Separate, false,
    Info {
        id: Id::of("triangle/exact_half_open"),
        idea: "the exact test; the ray is moved by an infinitesimal and then meets no edge",
        source: "Kensler, Shirley, 2006; Edelsbrunner, Mücke, \"Simulation of Simplicity\", 1990",
        operations: OPERATIONS,
        setup: SETUP_OPERATIONS,
        claims: CLAIMS,
    }
}

/// What follows from the tie rule.
pub(super) const CLAIMS: &[Claim] = &[
    Claim::EdgeWatertight,
    Claim::VertexWatertight,
    Claim::SingleHit,
    Claim::EvenCrossings,
    Claim::NoHitBehind,
    Claim::RightDecision,
];

/// A ray on an edge belongs to the triangle into which it would be moved.
pub(super) struct HalfOpen;

impl Rule for HalfOpen {
    #[inline(always)]
    fn is_inside([u, v, w]: [f64; 3], [a, b, c]: [DVec3; 3], dir: DVec3) -> bool {
        let sides = [(u, [c, a]), (v, [a, b]), (w, [b, c])]
            .map(|(weight, edge)| if weight == 0.0 { side_after_move(edge, dir) } else { weight });
        sides.iter().all(|side| *side > 0.0) | sides.iter().all(|side| *side < 0.0)
    }
}

/// The sign of the weight after the move, for a ray that is exactly on the edge from `p` to `q`. Zero if they are
/// parallel.
#[cold]
fn side_after_move([p, q]: [DVec3; 2], d: DVec3) -> f64 {
    // A component of (p - q) × d. f64 holds each product of two f32 numbers exactly.
    let component = |[p_i, p_j]: [f64; 2], [q_i, q_j]: [f64; 2], [d_i, d_j]: [f64; 2]| {
        let mut sum = ExactSum::<4>::ZERO;
        for product in [p_i * d_j, -q_i * d_j, -p_j * d_i, q_j * d_i] {
            sum.add(product);
        }
        sum.rounded()
    };
    let gradient = [
        component([p.y, p.z], [q.y, q.z], [d.y, d.z]),
        component([p.z, p.x], [q.z, q.x], [d.z, d.x]),
        component([p.x, p.y], [q.x, q.y], [d.x, d.y]),
    ];
    gradient.into_iter().find(|component| *component != 0.0).unwrap_or(0.0)
}
