//! `triangle/moller_trumbore`: the most widely used triangle test.
//!
//! **Source:** T. Möller, B. Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997.
//!
//! **Idea:** Cramer's rule, with the four determinants factored through two cross products, `dir × e2` and
//! `(origin - v0) × e1`, and with a single division.
//!
//! **Differs from the paper:** both edges are prepared. Both sides hit. One ray exits early, in one place; a packet
//! never does. There is no epsilon on the determinant: it would lose small triangles. The reciprocal of the
//! determinant is rounded before it is multiplied, as in the paper.
//!
//! **Fails:** leaks at edges and vertices like Cramer's rule. On slivers `t` is the first to lose digits: the normal is
//! never computed on its own, and `e2 · ((origin - v0) × e1)` cancels. Legs below about 5e-14 miss, because this
//! product would be subnormal or zero, and `t` could be anything. From 1e13 it overflows: a miss too.
//!
//! **Degenerate input:** a zero determinant is a miss, because ±∞ and NaN fail the test of the barycentrics. A
//! triangle of zero area is stored as NaN, like one that is too small.
//!
//! **Operations:** 27 multiplications, 18 additions, 1 division, 5 minima and comparisons. The paper's form has 24
//! additions, because it computes the edges for every ray. 36 bytes prepared.

use wide::f32x8;

use super::{barycentrics_inside, barycentrics_inside8, representable};
use crate::geom::lanes::{Lanes, t_in_range, t_in_range8};
use crate::geom::{Candidate, Ray, Triangle};
use crate::kernels::{Id, Info, Intersect, Kernel, Operations};

prepared! {
    /// Triangles for the Möller–Trumbore test: a vertex and the two edges that leave it.
    pub struct MollerTrumbore<P: Lanes> {
        v0: P::Vec3,
        pub(super) e1: P::Vec3,
        pub(super) e2: P::Vec3,
    }
}

impl Kernel for MollerTrumbore<f32> {
    type Shape = Triangle;
    type Packet = MollerTrumbore<f32x8>;
    const INFO: Info = Info {
        id: Id::of("triangle/moller_trumbore"),
        idea: "Cramer's rule factored through two cross products, one division",
        source: "Möller, Trumbore, \"Fast, Minimum Storage Ray/Triangle Intersection\", 1997",
        operations: Operations { mul: 27, add: 18, compare: 5, div: 1, reads: 9, ..Operations::NONE },
        setup: Operations::NONE,
        claims: &[],
    };

    fn prepare(shape: &Triangle) -> Self {
        let [v0, v1, v2] = representable(shape);
        Self { v0, e1: v1 - v0, e2: v2 - v0 }
    }

    prepared!(gather, lane);
}

impl Intersect<f32> for MollerTrumbore<f32> {
    type Setup = ();

    #[inline(always)]
    fn setup(_: &Ray<f32>) {}

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32>, (): &()) -> Candidate<f32> {
        let Self { v0, e1, e2 } = *self;

        // Compute the determinant.
        let p = ray.dir.cross(e2);
        let det = e1.dot(p);
        let inv_det = 1.0 / det;

        // Compute the barycentrics.
        let s = ray.origin - v0;
        let u = s.dot(p) * inv_det;
        let q = s.cross(e1);
        let v = ray.dir.dot(q) * inv_det;

        // Test the barycentrics. The test is true for a hit, so a NaN is a miss.
        if !barycentrics_inside(u, v) {
            return Candidate::MISS;
        }

        // Compute t and test its range.
        let t = e2.dot(q) * inv_det;
        Candidate::<f32>::new(t_in_range(ray.t_min, t, ray.t_max), t, u, v)
    }
}

impl<P: Lanes> Intersect<f32x8> for MollerTrumbore<P> {
    type Setup = ();

    #[inline(always)]
    fn setup(_: &Ray<f32x8>) {}

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32x8>, (): &()) -> Candidate<f32x8> {
        let MollerTrumbore { v0, e1, e2 } = self.widen();

        // Compute the determinant.
        let p = ray.dir.cross(e2);
        let det = e1.dot(p);
        let inv_det = f32x8::ONE / det;

        // Compute the barycentrics.
        let s = ray.origin - v0;
        let u = s.dot(p) * inv_det;
        let q = s.cross(e1);
        let v = ray.dir.dot(q) * inv_det;

        // Test the barycentrics. The test is true for a hit, so a NaN is a miss.
        let inside = barycentrics_inside8(u, v);

        // Compute t and test its range.
        let t = e2.dot(q) * inv_det;
        Candidate::<f32x8>::new(inside & t_in_range8(ray.t_min, t, ray.t_max), t, u, v)
    }
}
