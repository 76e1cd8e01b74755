//! `triangle/embree_moller`: Embree's fast test, as in its source.
//!
//! **Source:** Embree 4, `kernels/geometry/triangle_intersector_moeller.h`. Its form is one of A. Kensler, P. Shirley,
//! "Optimizing Ray-Triangle Intersection via Automated Search", 2006.
//!
//! **Idea:** the equations of `triangle/kensler_shirley`, without the division. All weights get the sign of the
//! determinant by xor. Then they are compared with the determinant's magnitude. Only what hits is divided.
//!
//! **Differs from the source:** the normal is prepared, as in Embree 2. Embree 4 computes the same bits for every ray.
//! Products are not fused, as in Embree's builds without AVX2. The reciprocal is correctly rounded. Embree also
//! compares `t` before it divides. Here the divided `t` is compared, which may lie an ulp outside of an interval that
//! the undivided one meets. The interval is closed. Determinants that overflow are a miss.
//!
//! **Differs from `triangle/kensler_shirley`:** the normal is a cross product in `f32`, and nothing is scaled.
//!
//! **Fails:** leaks at edges and vertices like `triangle/kensler_shirley`. The normal of a sliver loses its digits, and
//! then `t` does. Legs below about 5e-14 miss, as with `triangle/moller_trumbore`, and so do legs of 1e15.
//!
//! **Degenerate input:** rounding may give a normal to a triangle of zero area. It is stored as NaN and misses, like
//! one that is too small.
//!
//! **Operations:** 21 multiplications, 15 additions, 1 division, 6 minima and comparisons. 48 bytes prepared.

use wide::f32x8;

use super::representable;
use crate::geom::lanes::{Lanes, Mask8, ge8, le8, lt8, min, min8, t_in_range, t_in_range8};
use crate::geom::{Candidate, Ray, Triangle};
use crate::kernels::{Id, Info, Intersect, Kernel, Operations};

prepared! {
    /// Triangles for Embree's fast test: a vertex, the edges into and out of it, and the normal.
    pub struct EmbreeMoller<P: Lanes> {
        v0: P::Vec3,
        /// `v0 - v1`.
        e1: P::Vec3,
        /// `v2 - v0`.
        e2: P::Vec3,
        /// `e2 × e1`.
        n: P::Vec3,
    }
}

impl Kernel for EmbreeMoller<f32> {
    type Shape = Triangle;
    type Packet = EmbreeMoller<f32x8>;
    const INFO: Info = Info {
        id: Id::of("triangle/embree_moller"),
        idea: "Embree's fast test: normal in f32, weights compared before the division",
        source: "Embree 4, triangle_intersector_moeller.h; Kensler, Shirley, 2006",
        operations: Operations { mul: 21, add: 15, compare: 6, div: 1, reads: 12, ..Operations::NONE },
        setup: Operations::NONE,
        claims: &[],
    };

    fn prepare(shape: &Triangle) -> Self {
        let [v0, v1, v2] = representable(shape);
        let (e1, e2) = (v0 - v1, v2 - v0);
        Self { v0, e1, e2, n: e2.cross(e1) }
    }

    prepared!(gather, lane);
}

/// `a`, with the other sign if that of `b` is negative.
#[inline(always)]
fn times_sign(a: f32, b: f32) -> f32 {
    f32::from_bits(a.to_bits() ^ (b.to_bits() & (-0f32).to_bits()))
}

/// [`times_sign`] in eight lanes.
#[inline(always)]
fn times_sign8(a: f32x8, b: f32x8) -> f32x8 {
    a ^ (b & f32x8::splat(-0.0))
}

/// Whether `u >= 0`, `v >= 0` and `u + v <= sum`. False for a NaN. One branch, as in
/// [`barycentrics_inside`](super::barycentrics_inside).
#[inline(always)]
fn weights_inside(u: f32, v: f32, sum: f32) -> bool {
    min(min(u, v), sum - (u + v)) >= 0.0
}

/// [`weights_inside`] in eight lanes.
#[inline(always)]
fn weights_inside8(u: f32x8, v: f32x8, sum: f32x8) -> Mask8 {
    ge8(min8(u, v), f32x8::ZERO) & le8(u + v, sum)
}

impl Intersect<f32> for EmbreeMoller<f32> {
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
        let size = det.abs();

        // Compute the weights and compare them with the determinant. The test is true for a hit, so a NaN is a miss.
        let u = times_sign(r.dot(e2), det);
        let v = times_sign(r.dot(e1), det);
        if !weights_inside(u, v, size) {
            return Candidate::MISS;
        }

        // Divide. A determinant of zero makes t infinite or NaN, a larger one may overflow.
        let inv_size = 1.0 / size;
        let t = times_sign(n.dot(c), det) * inv_size;
        let hits = (size < f32::INFINITY) & t_in_range(ray.t_min, t, ray.t_max);
        Candidate::<f32>::new(hits, t, u * inv_size, v * inv_size)
    }
}

impl<P: Lanes> Intersect<f32x8> for EmbreeMoller<P> {
    type Setup = ();

    #[inline(always)]
    fn setup(_: &Ray<f32x8>) {}

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32x8>, (): &()) -> Candidate<f32x8> {
        let EmbreeMoller { v0, e1, e2, n } = self.widen();

        // Compute the shared cross product and the determinant.
        let c = v0 - ray.origin;
        let r = c.cross(ray.dir);
        let det = n.dot(ray.dir);
        let size = det.abs();

        // Compute the weights and compare them with the determinant. The test is true for a hit, so a NaN is a miss.
        let u = times_sign8(r.dot(e2), det);
        let v = times_sign8(r.dot(e1), det);
        let inside = weights_inside8(u, v, size);

        // Divide. A determinant of zero makes t infinite or NaN, a larger one may overflow.
        let inv_size = f32x8::ONE / size;
        let t = times_sign8(n.dot(c), det) * inv_size;
        let hits = inside & lt8(size, f32x8::splat(f32::INFINITY)) & t_in_range8(ray.t_min, t, ray.t_max);
        Candidate::<f32x8>::new(hits, t, u * inv_size, v * inv_size)
    }
}
