//! `triangle/cramer`: the textbook's solution, by Cramer's rule.
//!
//! **Source:** P. Shirley, S. Marschner et al., "Fundamentals of Computer Graphics", chapter on ray tracing; J. M.
//! Snyder, A. H. Barr, "Ray Tracing Complex Models Containing Surface Tessellations", 1987.
//!
//! **Idea:** write the hit as a linear system in (β, γ, t). Its columns are `v0 - v1`, `v0 - v2` and `dir`, its right
//! side is `v0 - origin`. Each unknown is a quotient of two 3×3 determinants.
//!
//! **Differs from the textbook:** edges belong to the triangle. With the textbook's strict inequalities, a ray
//! through a shared edge can miss both neighbours.
//!
//! **Fails:** rounding moves a ray off an edge, independently for each of the two triangles, so a mesh leaks.
//! Determinants grow with the cube of the size. Legs below about 5e-14 miss, because their determinants would be
//! subnormal or zero, and `t` could be anything. From 1e13 they overflow: a miss too. For grazing rays and slivers the
//! determinant cancels.
//!
//! **Degenerate input:** a zero determinant is a miss: a parallel ray. A triangle of zero area is stored as NaN, like
//! one that is too small. There is no epsilon.
//!
//! **Operations:** 36 multiplications, 30 additions, 3 divisions, 5 minima and comparisons. Nothing is prepared: a
//! primitive is its 9 coordinates.

use glam::Vec3;
use wide::f32x8;

use super::{Vertices, barycentrics_inside, barycentrics_inside8, representable};
use crate::geom::lanes::{Lanes, Vec3x8, t_in_range, t_in_range8};
use crate::geom::{Candidate, Ray, Triangle};
use crate::kernels::aabb::Slabs;
use crate::kernels::{Id, Info, Intersect, Kernel, Operations};

prepared! {
    /// Triangles for Cramer's rule: the unchanged vertices.
    pub struct Cramer<P: Lanes> {
        vertices: Vertices<P>,
    }
}

impl Kernel for Cramer<f32> {
    type Shape = Triangle;
    type Packet = Cramer<f32x8>;
    const INFO: Info = Info {
        id: Id::of("triangle/cramer"),
        idea: "β, γ and t from four 3×3 determinants",
        source: "Shirley, Marschner, \"Fundamentals of Computer Graphics\"; Snyder, Barr, 1987",
        operations: Operations { mul: 36, add: 30, compare: 5, div: 3, reads: 9, ..Operations::NONE },
        setup: Operations::NONE,
        claims: &[],
    };

    fn prepare(shape: &Triangle) -> Self {
        let [v0, v1, v2] = representable(shape);
        Self { vertices: Vertices { v0, v1, v2 } }
    }

    prepared!(gather, lane);

    #[inline(always)]
    fn bounds(packet: &Self::Packet) -> Option<Slabs<f32x8>> {
        Some(packet.vertices.bounds())
    }
}

/// The determinant of the matrix with these columns, expanded along the first column.
#[inline(always)]
fn determinant(a: Vec3, b: Vec3, c: Vec3) -> f32 {
    a.x * (b.y * c.z - c.y * b.z) + a.y * (c.x * b.z - b.x * c.z) + a.z * (b.x * c.y - b.y * c.x)
}

/// [`determinant`] in eight lanes.
#[inline(always)]
fn determinant8(a: Vec3x8, b: Vec3x8, c: Vec3x8) -> f32x8 {
    a.x * (b.y * c.z - c.y * b.z) + a.y * (c.x * b.z - b.x * c.z) + a.z * (b.x * c.y - b.y * c.x)
}

impl Intersect<f32> for Cramer<f32> {
    type Setup = ();

    #[inline(always)]
    fn setup(_: &Ray<f32>) {}

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32>, (): &()) -> Candidate<f32> {
        let Self { vertices: Vertices { v0, v1, v2 } } = *self;

        // Set up the system (v0 - v1)·β + (v0 - v2)·γ + dir·t = v0 - origin.
        let (a, b, s) = (v0 - v1, v0 - v2, v0 - ray.origin);

        // Solve it for the barycentrics.
        let det = determinant(a, b, ray.dir);
        let u = determinant(s, b, ray.dir) / det;
        let v = determinant(a, s, ray.dir) / det;

        // Test the barycentrics. The test is true for a hit, so a NaN is a miss.
        if !barycentrics_inside(u, v) {
            return Candidate::MISS;
        }

        // Solve it for t and test the range.
        let t = determinant(a, b, s) / det;
        Candidate::<f32>::new(t_in_range(ray.t_min, t, ray.t_max), t, u, v)
    }
}

impl<P: Lanes> Intersect<f32x8> for Cramer<P> {
    type Setup = ();

    #[inline(always)]
    fn setup(_: &Ray<f32x8>) {}

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32x8>, (): &()) -> Candidate<f32x8> {
        let Cramer { vertices: Vertices { v0, v1, v2 } } = self.widen();

        // Set up the system (v0 - v1)·β + (v0 - v2)·γ + dir·t = v0 - origin.
        let (a, b, s) = (v0 - v1, v0 - v2, v0 - ray.origin);

        // Solve it for the barycentrics.
        let det = determinant8(a, b, ray.dir);
        let u = determinant8(s, b, ray.dir) / det;
        let v = determinant8(a, s, ray.dir) / det;

        // Test the barycentrics. The test is true for a hit, so a NaN is a miss.
        let inside = barycentrics_inside8(u, v);

        // Solve it for t and test the range.
        let t = determinant8(a, b, s) / det;
        Candidate::<f32x8>::new(inside & t_in_range8(ray.t_min, t, ray.t_max), t, u, v)
    }
}
