//! `triangle/pluecker`: edge functions on which both triangles at an edge agree.
//!
//! **Source:** the line coordinates of A. F. Möbius and J. Plücker, in the form of Embree's robust test (I. Wald, S.
//! Woop, C. Benthin, G. S. Johnson, M. Ernst, "Embree: A Kernel Framework for Efficient CPU Ray Tracing", 2014).
//!
//! **Idea:** take the vertices relative to the ray's origin. The sign of `((b - a) × (a + b)) · dir` says on which
//! side of the edge ab the ray passes. The ray hits if all three signs agree. If the edge is walked the other way,
//! the difference changes its sign and the sum stays the same. So every later product and sum changes its sign and
//! nothing else. The two triangles at an edge compute exactly opposite numbers: they cannot both reject the ray
//! because of that edge.
//!
//! **Differs from the sources:** the normal is prepared (in `f64`, rounded once, scaled to about 1), and `t` is a plain
//! quotient of two products with it. Embree computes a normal for every ray by a stabilised cross product. Edge
//! functions are compared with zero, not with an epsilon. Both sides hit.
//!
//! **Fails:** at a vertex three or more edge functions meet. Each has its own rounding, and their signs need not be
//! those of any point. Of 2,170,000 rays exactly through the hub of a fan, 5,800 leaked; of 1,890,000 exactly through
//! its edges, none. If a triangle is seen almost edge-on, another of its edges may be as close as a rounding error and
//! reject the ray (`edge-leak-pluecker` of the sharp cases). The rounding error of an edge function grows with distance
//! times size. So rays near an edge hit twice or hit the wrong neighbour, and more of them from farther away.
//!
//! Edge functions vanish where size, times size or distance, is below 1e-38.
//!
//! **Degenerate input:** the prepared normal of a triangle of zero area is exactly zero, so `t` divides by zero.
//!
//! **Operations:** 35 multiplications, 49 additions, 2 divisions, 9 minima, maxima and comparisons. 48 bytes
//! prepared.

use wide::f32x8;

use super::{Vertices, scaled_normal, sign_agreement, sign_agreement8};
use crate::geom::lanes::{Lanes, ge8, lt8, t_in_range, t_in_range8};
use crate::geom::{Candidate, Ray, Triangle};
use crate::kernels::aabb::Slabs;
use crate::kernels::{Claim, Id, Info, Intersect, Kernel, Operations};

prepared! {
    /// Triangles for the Plücker test: the vertices and the normal.
    pub struct Pluecker<P: Lanes> {
        vertices: Vertices<P>,
        n: P::Vec3,
    }
}

impl Kernel for Pluecker<f32> {
    type Shape = Triangle;
    type Packet = Pluecker<f32x8>;
    const INFO: Info = Info {
        id: Id::of("triangle/pluecker"),
        idea: "edge functions of vertices relative to the origin, exactly antisymmetric",
        source: "Wald, Woop, Benthin, Johnson, Ernst, \"Embree\", 2014 (its robust test)",
        operations: Operations { mul: 35, add: 49, compare: 9, div: 2, reads: 12, ..Operations::NONE },
        setup: Operations::NONE,
        claims: &[Claim::EdgeWatertight],
    };

    fn prepare(shape: &Triangle) -> Self {
        Self { vertices: shape.into(), n: scaled_normal(shape).0.as_vec3() }
    }

    prepared!(gather, lane);

    #[inline(always)]
    fn bounds(packet: &Self::Packet) -> Option<Slabs<f32x8>> {
        Some(packet.vertices.bounds())
    }
}

impl Intersect<f32> for Pluecker<f32> {
    type Setup = ();

    #[inline(always)]
    fn setup(_: &Ray<f32>) {}

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32>, (): &()) -> Candidate<f32> {
        let Self { vertices: Vertices { v0, v1, v2 }, n } = *self;

        // Move the origin to zero.
        let (a, b, c) = (v0 - ray.origin, v1 - ray.origin, v2 - ray.origin);

        // Evaluate the edge functions: the weights of v1, v2 and v0, up to a common factor.
        let u = (a - c).cross(a + c).dot(ray.dir);
        let v = (b - a).cross(b + a).dot(ray.dir);
        let w = (c - b).cross(c + b).dot(ray.dir);

        // Test whether the three signs agree.
        let inside = sign_agreement([u, v, w]) >= 0.0;
        if !inside {
            return Candidate::MISS;
        }

        // Intersect the plane and normalise the weights.
        let inv_sum = 1.0 / (u + v + w);
        let t = n.dot(a) / n.dot(ray.dir);
        let (u, v) = (u * inv_sum, v * inv_sum);

        // Reject weights that are all zero, or overflow, or are NaN. Test the range of t.
        let numbers = (u + v).abs() < f32::INFINITY;
        Candidate::<f32>::new(numbers & t_in_range(ray.t_min, t, ray.t_max), t, u, v)
    }
}

impl<P: Lanes> Intersect<f32x8> for Pluecker<P> {
    type Setup = ();

    #[inline(always)]
    fn setup(_: &Ray<f32x8>) {}

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32x8>, (): &()) -> Candidate<f32x8> {
        let Pluecker { vertices: Vertices { v0, v1, v2 }, n } = self.widen();

        // Move the origin to zero.
        let (a, b, c) = (v0 - ray.origin, v1 - ray.origin, v2 - ray.origin);

        // Evaluate the edge functions: the weights of v1, v2 and v0, up to a common factor.
        let u = (a - c).cross(a + c).dot(ray.dir);
        let v = (b - a).cross(b + a).dot(ray.dir);
        let w = (c - b).cross(c + b).dot(ray.dir);

        // Test whether the three signs agree.
        let inside = ge8(sign_agreement8([u, v, w]), f32x8::ZERO);

        // Intersect the plane and normalise the weights.
        let inv_sum = f32x8::ONE / (u + v + w);
        let t = n.dot(a) / n.dot(ray.dir);
        let (u, v) = (u * inv_sum, v * inv_sum);

        // Reject weights that are all zero, or overflow, or are NaN. Test the range of t.
        let numbers = lt8((u + v).abs(), f32x8::splat(f32::INFINITY));
        Candidate::<f32x8>::new(inside & numbers & t_in_range8(ray.t_min, t, ray.t_max), t, u, v)
    }
}
