//! `triangle/kensler_shirley`: prepared normal, one cross product per test.
//!
//! **Source:** A. Kensler, P. Shirley, "Optimizing Ray-Triangle Intersection via Automated Search", 2006. The form is
//! that of Embree's fast test, with its `e1 = v0 - v1`, which saves a negation.
//!
//! **Idea:** the four determinants of Möller and Trumbore can share terms in many ways. Here they share the normal
//! `n`. The test computes `(v0 - origin) × dir` once, and then four dot products with the prepared normal and edges.
//!
//! **Differs from the sources:** the normal is computed in `f64` and rounded once, so it is as good for a sliver as for
//! any triangle. Normal and edges are multiplied by one power of two, which cancels: the determinant is about as long
//! as the direction, for triangles of every size. Both sides hit. There is no epsilon. Embree compares before it
//! divides. Here the reciprocal of the determinant is multiplied in first, as everywhere in this crate; in a packet
//! that costs no more.
//!
//! **Fails:** leaks at edges and vertices like Möller–Trumbore. Slivers do not harm `t`, a quotient of two products
//! with the prepared normal. The range ends where the direction or the triangle's inverse size overflows.
//!
//! **Degenerate input:** the normal of a triangle of zero area is exactly zero. So is the determinant, and the
//! triangle misses.
//!
//! **Operations:** 21 multiplications, 15 additions, 1 division, 5 minima and comparisons. 48 bytes prepared.

use glam::Vec3;
use wide::f32x8;

use super::{barycentrics_inside, barycentrics_inside8, scaled_normal};
use crate::geom::lanes::{Lanes, t_in_range, t_in_range8};
use crate::geom::{Candidate, Ray, Triangle};
use crate::kernels::{Id, Info, Intersect, Kernel, Operations};

prepared! {
    /// Triangles for the Kensler–Shirley test: a vertex, the edges into and out of it, and the normal.
    pub struct KenslerShirley<P: Lanes> {
        v0: P::Vec3,
        /// `v0 - v1`, times a power of two.
        e1: P::Vec3,
        /// `v2 - v0`, times the same power.
        e2: P::Vec3,
        /// The normal, times the same power. Its largest component is about 1.
        n: P::Vec3,
    }
}

impl Kernel for KenslerShirley<f32> {
    type Shape = Triangle;
    type Packet = KenslerShirley<f32x8>;
    const INFO: Info = Info {
        id: Id::of("triangle/kensler_shirley"),
        idea: "Möller–Trumbore with the normal prepared and one cross product",
        source: "Kensler, Shirley, \"Optimizing Ray-Triangle Intersection via Automated Search\", 2006",
        operations: Operations { mul: 21, add: 15, compare: 5, div: 1, reads: 12, ..Operations::NONE },
        setup: Operations::NONE,
        claims: &[],
    };

    fn prepare(shape: &Triangle) -> Self {
        let (n, scale) = scaled_normal(shape);
        let scaled = |edge: Vec3| (edge.as_dvec3() * scale).as_vec3();
        let Triangle { v0, v1, v2 } = *shape;
        Self { v0, e1: scaled(v0 - v1), e2: scaled(v2 - v0), n: n.as_vec3() }
    }

    prepared!(gather, lane);
}

impl Intersect<f32> for KenslerShirley<f32> {
    type Setup = ();

    #[inline(always)]
    fn setup(_: &Ray<f32>) {}

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32>, (): &()) -> Candidate<f32> {
        let Self { v0, e1, e2, n } = *self;

        // Compute the shared cross product and the determinant.
        let c = v0 - ray.origin;
        let r = c.cross(ray.dir);
        let det = n.dot(ray.dir);
        let inv_det = 1.0 / det;

        // Compute the barycentrics.
        let u = r.dot(e2) * inv_det;
        let v = r.dot(e1) * inv_det;

        // Test the barycentrics. The test is true for a hit, so a NaN is a miss.
        if !barycentrics_inside(u, v) {
            return Candidate::MISS;
        }

        // Compute t and test its range.
        let t = n.dot(c) * inv_det;
        Candidate::<f32>::new(t_in_range(ray.t_min, t, ray.t_max), t, u, v)
    }
}

impl<P: Lanes> Intersect<f32x8> for KenslerShirley<P> {
    type Setup = ();

    #[inline(always)]
    fn setup(_: &Ray<f32x8>) {}

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32x8>, (): &()) -> Candidate<f32x8> {
        let KenslerShirley { v0, e1, e2, n } = self.widen();

        // Compute the shared cross product and the determinant.
        let c = v0 - ray.origin;
        let r = c.cross(ray.dir);
        let det = n.dot(ray.dir);
        let inv_det = f32x8::ONE / det;

        // Compute the barycentrics.
        let u = r.dot(e2) * inv_det;
        let v = r.dot(e1) * inv_det;

        // Test the barycentrics. The test is true for a hit, so a NaN is a miss.
        let inside = barycentrics_inside8(u, v);

        // Compute t and test its range.
        let t = n.dot(c) * inv_det;
        Candidate::<f32x8>::new(inside & t_in_range8(ray.t_min, t, ray.t_max), t, u, v)
    }
}
