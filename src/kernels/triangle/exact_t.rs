//! `triangle/exact_t`: the exact test with a precise distance.
//!
//! **Source:** as `triangle/exact`.
//!
//! **Idea:** `triangle/exact` bounds the error of `t`, and computes `t` again where its sign is not sure. Here the `t`
//! of every hit is computed again whose bound is above `t/4096`. So it is right to 4,096 ulp. The bound is pessimistic:
//! most are right to a few ulp. What is computed again is right to 32 ulp. Rays that hit at a grazing angle pay, and
//! rays that start very close to what they hit. A ray that leaves a triangle does not hit it, and does not pay.
//!
//! **Edges, range, degenerate input:** as `triangle/exact`.
//!
//! **Claims:** as `triangle/exact`. `t` is right to 4,096 ulp, which a test compares with the oracle.
//!
//! **Operations:** as `triangle/exact`, one multiplication and one comparison more.

use wide::f32x8;

use super::exact::{Closed, Exact, OPERATIONS, SETUP_OPERATIONS, Separate, setup, setup8, variant};
use crate::geom::lanes::Lanes;
use crate::geom::{Candidate, Ray, Triangle};
use crate::kernels::aabb::Slabs;
use crate::kernels::{Claim, Id, Info, Intersect, Kernel, Operations};

variant! {
    /// Triangles for the exact test with a precise distance.
    ExactT, Closed, Separate, true,
    Info {
        id: Id::of("triangle/exact_t"),
        idea: "the exact test; a t that may be off by more than 4,096 ulp is computed again",
        source: "Kensler, Shirley, 2006; Shewchuk, \"Adaptive Precision […] Robust Geometric Predicates\", 1997",
        operations: Operations { mul: OPERATIONS.mul + 1, compare: OPERATIONS.compare + 1, ..OPERATIONS },
        setup: SETUP_OPERATIONS,
        claims: &[Claim::EdgeWatertight, Claim::VertexWatertight, Claim::NoHitBehind, Claim::RightDecision],
    }
}
