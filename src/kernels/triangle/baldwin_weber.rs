//! `triangle/baldwin_weber`: transforms the ray into the triangle's own coordinates.
//!
//! **Source:** D. Baldwin, M. Weber, "Fast Ray-Triangle Intersections by Coordinate Transformation", JCGT 5(3), 2016.
//!
//! **Idea:** an affine map takes the triangle to (0,0,0), (1,0,0), (0,1,0). Its third row gives `t` as a quotient.
//! The other two rows give `u` and `v` of the point at `t`.
//!
//! **Differs from the paper:** the paper takes a coordinate axis as the third direction. That saves one column and
//! needs a branch on the axis. Here the third direction is the normal: all 12 numbers are stored, and nothing
//! branches. With the normal, an error of the point off the plane changes `u` and `v` as little as possible. The map
//! is computed in `f64` and rounded once. The third row is scaled to a largest component of 1, so it does
//! not overflow or underflow.
//!
//! **Fails:** the constants of the three rows grow with the triangle's distance from the origin of coordinates, and
//! the sums with them cancel. Far from the origin `u`, `v` and `t` lose digits. Methods that subtract first lose none
//! there. Near the origin, on a huge triangle, it is the other way round. Leaks at edges and vertices.
//!
//! **Not here:** the test of J. Havel, A. Herout, "Yet Faster Ray-Triangle Intersection (Using SSE4)", 2010, prepares
//! planes too and fails in the same regimes. It leaked 1.4 to 5 times as often at edges, with 23 multiplications for
//! 15.
//!
//! **Degenerate input:** no map exists for a triangle of zero area. It is stored as NaN and misses. The same holds
//! for a triangle that is not finite.
//!
//! **Operations:** 15 multiplications, 15 additions, 1 division, 5 minima and comparisons. 48 bytes prepared.

use glam::{DVec3, Vec3};
use wide::f32x8;

use super::{barycentrics_inside, barycentrics_inside8, normal};
use crate::geom::lanes::{Lanes, t_in_range, t_in_range8};
use crate::geom::{Candidate, Ray, Triangle};
use crate::kernels::{Id, Info, Intersect, Kernel, Operations};

prepared! {
    /// Triangles for the Baldwin–Weber test: the map from the world to the triangle, row by row. `u(p) = u_row·p + u0`,
    /// `v` likewise; `n_row` and `n0` give the distance from the plane, up to a factor.
    pub struct BaldwinWeber<P: Lanes> {
        u_row: P::Vec3,
        u0: P,
        v_row: P::Vec3,
        v0: P,
        n_row: P::Vec3,
        n0: P,
    }
}

impl Kernel for BaldwinWeber<f32> {
    type Shape = Triangle;
    type Packet = BaldwinWeber<f32x8>;
    const INFO: Info = Info {
        id: Id::of("triangle/baldwin_weber"),
        idea: "an affine map, prepared in f64, takes the triangle to the unit triangle",
        source: "Baldwin, Weber, \"Fast Ray-Triangle Intersections by Coordinate Transformation\", 2016",
        operations: Operations { mul: 15, add: 15, compare: 5, div: 1, reads: 12, ..Operations::NONE },
        setup: Operations::NONE,
        claims: &[],
    };

    fn prepare(shape: &Triangle) -> Self {
        let [v0, v1, v2] = shape.vertices().map(Vec3::as_dvec3);
        let (e1, e2, n) = (v1 - v0, v2 - v0, normal(shape));
        let squared = n.length_squared();
        // Solve p - v0 = u·e1 + v·e2 + w·n. Each gradient is perpendicular to two of the three vectors. Zero area
        // divides by zero.
        let (u, v) = (e2.cross(n) / squared, n.cross(e1) / squared);
        let n = n / n.abs().max_element();
        let row = |gradient: DVec3| (gradient.as_vec3(), -gradient.dot(v0) as f32);
        let ((u_row, u0), (v_row, v0), (n_row, n0)) = (row(u), row(v), row(n));
        Self { u_row, u0, v_row, v0, n_row, n0 }
    }

    prepared!(gather, lane);
}

impl Intersect<f32> for BaldwinWeber<f32> {
    type Setup = ();

    #[inline(always)]
    fn setup(_: &Ray<f32>) {}

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32>, (): &()) -> Candidate<f32> {
        let Self { u_row, u0, v_row, v0, n_row, n0 } = *self;

        // Intersect the plane. A ray parallel to it divides by zero: t is infinite or NaN.
        let t = -(n_row.dot(ray.origin) + n0) / n_row.dot(ray.dir);

        // Map the point to the barycentrics.
        let p = ray.origin + ray.dir * t;
        let u = u_row.dot(p) + u0;
        let v = v_row.dot(p) + v0;

        // Test the barycentrics. The test is true for a hit, so a NaN is a miss.
        if !barycentrics_inside(u, v) {
            return Candidate::MISS;
        }

        // Test the range of t.
        Candidate::<f32>::new(t_in_range(ray.t_min, t, ray.t_max), t, u, v)
    }
}

impl<P: Lanes> Intersect<f32x8> for BaldwinWeber<P> {
    type Setup = ();

    #[inline(always)]
    fn setup(_: &Ray<f32x8>) {}

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32x8>, (): &()) -> Candidate<f32x8> {
        let BaldwinWeber { u_row, u0, v_row, v0, n_row, n0 } = self.widen();

        // Intersect the plane. A ray parallel to it divides by zero: t is infinite or NaN.
        let t = -(n_row.dot(ray.origin) + n0) / n_row.dot(ray.dir);

        // Map the point to the barycentrics.
        let p = ray.origin + ray.dir * t;
        let u = u_row.dot(p) + u0;
        let v = v_row.dot(p) + v0;

        // Test the barycentrics. The test is true for a hit, so a NaN is a miss.
        let inside = barycentrics_inside8(u, v);

        // Test the range of t.
        Candidate::<f32x8>::new(inside & t_in_range8(ray.t_min, t, ray.t_max), t, u, v)
    }
}
