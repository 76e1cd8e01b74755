//! `triangle/moller_trumbore_f64`: Möller–Trumbore in double precision.
//!
//! **Source:** T. Möller, B. Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997.
//!
//! **Idea:** `f32` in and out, `f64` in between: what `triangle/moller_trumbore` would give if it hardly rounded.
//!
//! **Differs from `triangle/moller_trumbore`:** the vertices are stored unchanged, in `f32`. Edges in `f64` would
//! double the memory to save 6 subtractions. The differences of the vertices are exact except for extreme ratios.
//! `t`, `u` and `v` are rounded to `f32` once, at the end. The interval is tested with the rounded `t`, which is the
//! one returned. No determinant of finite `f32` numbers overflows or underflows in `f64`.
//!
//! **Fails:** eight lanes of `f64` are two registers, at half the speed. It still leaks at edges and vertices: rounding
//! moves a ray that is exactly on an edge off it, independently for each of the two triangles. That happens where a
//! product needs more than 53 bits, or where exporters write 5·cos(90°) as 3e-16: beside 1.9, its digits are lost
//! (`exporter-vertex-3e-16` of the sharp cases). From a start that is 2⁻⁵⁰ of its coordinates off a plane, the sign of
//! `t` is lost (`leaves-lattice-plane`).
//!
//! **Degenerate input:** a zero determinant is a miss without a test of its own, because `u` is then NaN or infinite.
//! Rounding may make the determinant of a triangle of zero area non-zero, so such a triangle is stored as NaN.
//!
//! **Operations:** 27 multiplications, 24 additions, 1 division, all in `f64`, and 5 comparisons, 3 of them in `f64`.
//! 36 bytes prepared.

use glam::{DVec3, Vec3};
use wide::{f32x8, f64x8};

use super::{Vertices, normal};
use crate::geom::lanes::{DVec3x8, Lanes, dot_f64x8, double8, ge64, le64, t_in_range, t_in_range8, to_f32x8};
use crate::geom::{Candidate, Ray, Triangle};
use crate::kernels::aabb::Slabs;
use crate::kernels::{DoubleOperations, Id, Info, Intersect, Kernel, Operations};

prepared! {
    /// Triangles for the Möller–Trumbore test in `f64`: the unchanged vertices.
    pub struct MollerTrumboreF64<P: Lanes> {
        vertices: Vertices<P>,
    }
}

impl Kernel for MollerTrumboreF64<f32> {
    type Shape = Triangle;
    type Packet = MollerTrumboreF64<f32x8>;
    const INFO: Info = Info {
        id: Id::of("triangle/moller_trumbore_f64"),
        idea: "Möller–Trumbore computed in f64, f32 in and out",
        source: "Möller, Trumbore, \"Fast, Minimum Storage Ray/Triangle Intersection\", 1997",
        operations: Operations {
            mul: 27,
            add: 24,
            compare: 5,
            div: 1,
            reads: 9,
            double: DoubleOperations { mul: 27, add: 24, compare: 3, div: 1 },
            ..Operations::NONE
        },
        setup: Operations::NONE,
        claims: &[],
    };

    fn prepare(shape: &Triangle) -> Self {
        let vertices = Vertices::from(shape);
        let has_area = normal(shape) != DVec3::ZERO;
        Self { vertices: Vertices { v0: if has_area { vertices.v0 } else { Vec3::NAN }, ..vertices } }
    }

    prepared!(gather, lane);

    #[inline(always)]
    fn bounds(packet: &Self::Packet) -> Option<Slabs<f32x8>> {
        Some(packet.vertices.bounds())
    }
}

/// The smaller of two numbers. `b` where one is NaN.
#[inline(always)]
fn min(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// [`barycentrics_inside`](super::barycentrics_inside) in `f64`. The packet twin makes the three comparisons, because
/// nothing branches there.
#[inline(always)]
fn barycentrics_inside(u: f64, v: f64) -> bool {
    min(min(u, v), 1.0 - (u + v)) >= 0.0
}

#[inline(always)]
fn minus8(a: DVec3x8, b: DVec3x8) -> DVec3x8 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn cross8(a: DVec3x8, b: DVec3x8) -> DVec3x8 {
    [a[1] * b[2] - b[1] * a[2], a[2] * b[0] - b[2] * a[0], a[0] * b[1] - b[0] * a[1]]
}

impl Intersect<f32> for MollerTrumboreF64<f32> {
    type Setup = ();

    #[inline(always)]
    fn setup(_: &Ray<f32>) {}

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32>, (): &()) -> Candidate<f32> {
        let Self { vertices: Vertices { v0, v1, v2 } } = *self;

        // Convert to f64.
        let (v0, v1, v2) = (v0.as_dvec3(), v1.as_dvec3(), v2.as_dvec3());
        let (origin, dir) = (ray.origin.as_dvec3(), ray.dir.as_dvec3());

        // Compute the determinant.
        let (e1, e2) = (v1 - v0, v2 - v0);
        let p = dir.cross(e2);
        let inv_det = 1.0 / e1.dot(p);

        // Compute the barycentrics.
        let s = origin - v0;
        let u = s.dot(p) * inv_det;
        let q = s.cross(e1);
        let v = dir.dot(q) * inv_det;

        // Test the barycentrics. The test is true for a hit, so a NaN is a miss.
        if !barycentrics_inside(u, v) {
            return Candidate::MISS;
        }

        // Compute t, round it and test its range.
        let t = (e2.dot(q) * inv_det) as f32;
        Candidate::<f32>::new(t_in_range(ray.t_min, t, ray.t_max), t, u as f32, v as f32)
    }
}

impl<P: Lanes> Intersect<f32x8> for MollerTrumboreF64<P> {
    type Setup = ();

    #[inline(always)]
    fn setup(_: &Ray<f32x8>) {}

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32x8>, (): &()) -> Candidate<f32x8> {
        let MollerTrumboreF64 { vertices: Vertices { v0, v1, v2 } } = self.widen();

        // Convert to f64.
        let (v0, v1, v2) = (double8(v0), double8(v1), double8(v2));
        let (origin, dir) = (double8(ray.origin), double8(ray.dir));
        let (zero, one) = (f64x8::splat(0.0), f64x8::splat(1.0));

        // Compute the determinant.
        let (e1, e2) = (minus8(v1, v0), minus8(v2, v0));
        let p = cross8(dir, e2);
        let inv_det = one / dot_f64x8(e1, p);

        // Compute the barycentrics.
        let s = minus8(origin, v0);
        let u = dot_f64x8(s, p) * inv_det;
        let q = cross8(s, e1);
        let v = dot_f64x8(dir, q) * inv_det;

        // Test the barycentrics. The test is true for a hit, so a NaN is a miss.
        let inside = (ge64(u, zero) & ge64(v, zero) & le64(u + v, one)).narrow();

        // Compute t, round it and test its range.
        let t = to_f32x8(dot_f64x8(e2, q) * inv_det);
        Candidate::<f32x8>::new(inside & t_in_range8(ray.t_min, t, ray.t_max), t, to_f32x8(u), to_f32x8(v))
    }
}
