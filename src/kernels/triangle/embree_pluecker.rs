//! `triangle/embree_pluecker`: Embree's robust test, as in its source.
//!
//! **Source:** Embree 4, `kernels/geometry/triangle_intersector_pluecker.h`. I. Wald, S. Woop, C. Benthin, G. S.
//! Johnson, M. Ernst, "Embree: A Kernel Framework for Efficient CPU Ray Tracing", 2014.
//!
//! **Idea:** the edge functions of `triangle/pluecker`, compared with an epsilon that is relative to their sum: a
//! weight of the wrong sign still counts if it is below 1.2e-7 of the sum. The normal is computed for every ray. Each
//! component comes from the pair of edges whose products are smaller.
//!
//! **Differs from the source:** products are not fused, as in Embree's builds without AVX2. Reciprocals are correctly
//! rounded. The normal and the distance are not doubled, because that cancels. A sum of weights that overflows is a
//! miss.
//!
//! **Differs from `triangle/pluecker`:** the epsilon, and the normal, which costs 12 multiplications per test and no
//! memory.
//!
//! **Fails:** the epsilon adds double hits beside edges. It closes most gaps but not all: T-junctions and distant
//! grounds at a grazing angle still leak. The normal of a sliver loses its digits, and then `t` does. As with
//! `triangle/pluecker`, weights lose their digits with the distance.
//!
//! **Degenerate input:** a triangle of zero area has a normal of zero, unless it is rounded. It is stored as NaN and
//! misses.
//!
//! **Operations:** 49 multiplications, 54 additions, 2 divisions, 15 minima, maxima and comparisons. 36 bytes prepared.

use glam::{DVec3, Vec3};
use wide::f32x8;

use super::{Vertices, normal};
use crate::geom::lanes::{Lanes, Vec3x8, ge8, le8, lt8, max, max8, min, min8, t_in_range, t_in_range8};
use crate::geom::{Candidate, Ray, Triangle};
use crate::kernels::aabb::Slabs;
use crate::kernels::{Claim, Id, Info, Intersect, Kernel, Operations};

prepared! {
    /// Triangles for Embree's robust test: the unchanged vertices.
    pub struct EmbreePluecker<P: Lanes> {
        vertices: Vertices<P>,
    }
}

impl Kernel for EmbreePluecker<f32> {
    type Shape = Triangle;
    type Packet = EmbreePluecker<f32x8>;
    const INFO: Info = Info {
        id: Id::of("triangle/embree_pluecker"),
        idea: "Embree's robust test: Plücker edge functions against an epsilon relative to their sum",
        source: "Embree 4, triangle_intersector_pluecker.h; Wald, Woop, Benthin, Johnson, Ernst, \"Embree\", 2014",
        operations: Operations { mul: 49, add: 54, compare: 15, div: 2, reads: 9, ..Operations::NONE },
        setup: Operations::NONE,
        claims: &[Claim::EdgeWatertight],
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

/// `a × b` or `b × c`, which are equal for edges of one triangle. Each component is the one whose subtracted product
/// is smaller.
#[inline(always)]
fn stable_normal(a: Vec3, b: Vec3, c: Vec3) -> Vec3 {
    let ab = Vec3::new(a.z * b.y, a.x * b.z, a.y * b.x);
    let bc = Vec3::new(b.z * c.y, b.x * c.z, b.y * c.x);
    let cross_ab = Vec3::new(a.y * b.z, a.z * b.x, a.x * b.y) - ab;
    let cross_bc = Vec3::new(b.y * c.z, b.z * c.x, b.x * c.y) - bc;
    let pick = |ab: f32, bc: f32, of_ab, of_bc| if ab.abs() < bc.abs() { of_ab } else { of_bc };
    Vec3::new(
        pick(ab.x, bc.x, cross_ab.x, cross_bc.x),
        pick(ab.y, bc.y, cross_ab.y, cross_bc.y),
        pick(ab.z, bc.z, cross_ab.z, cross_bc.z),
    )
}

/// [`stable_normal`] in eight lanes.
#[inline(always)]
fn stable_normal8(a: Vec3x8, b: Vec3x8, c: Vec3x8) -> Vec3x8 {
    let ab = Vec3x8 { x: a.z * b.y, y: a.x * b.z, z: a.y * b.x };
    let bc = Vec3x8 { x: b.z * c.y, y: b.x * c.z, z: b.y * c.x };
    let cross_ab = Vec3x8 { x: a.y * b.z, y: a.z * b.x, z: a.x * b.y } - ab;
    let cross_bc = Vec3x8 { x: b.y * c.z, y: b.z * c.x, z: b.x * c.y } - bc;
    let pick = |ab: f32x8, bc: f32x8, of_ab, of_bc| lt8(ab.abs(), bc.abs()).select(of_ab, of_bc);
    Vec3x8 {
        x: pick(ab.x, bc.x, cross_ab.x, cross_bc.x),
        y: pick(ab.y, bc.y, cross_ab.y, cross_bc.y),
        z: pick(ab.z, bc.z, cross_ab.z, cross_bc.z),
    }
}

impl Intersect<f32> for EmbreePluecker<f32> {
    type Setup = ();

    #[inline(always)]
    fn setup(_: &Ray<f32>) {}

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32>, (): &()) -> Candidate<f32> {
        let Self { vertices: Vertices { v0, v1, v2 } } = *self;

        // Move the origin to zero.
        let (a, b, c) = (v0 - ray.origin, v1 - ray.origin, v2 - ray.origin);

        // Evaluate the edge functions: the weights of v1, v2 and v0, up to a common factor.
        let (ca, ab, bc) = (c - a, a - b, b - c);
        let u = ca.cross(c + a).dot(ray.dir);
        let v = ab.cross(a + b).dot(ray.dir);
        let w = bc.cross(b + c).dot(ray.dir);

        // Test whether the three signs agree, except for small weights. A sum that is not finite is a miss.
        let sum = u + v + w;
        let eps = f32::EPSILON * sum.abs();
        let (least, greatest) = (min(min(u, v), w), max(max(u, v), w));
        let inside = ((least >= -eps) | (greatest <= eps)) & (eps < f32::INFINITY);
        if !inside {
            return Candidate::MISS;
        }

        // Intersect the plane. A ray parallel to it divides by zero: t is infinite or NaN.
        let n = stable_normal(ca, ab, bc);
        let t = (1.0 / n.dot(ray.dir)) * a.dot(n);

        // Normalise the weights. They are zero if the sum has no reciprocal.
        let inv_sum = if sum.abs() < f32::MIN_POSITIVE { 0.0 } else { 1.0 / sum };
        let (u, v) = (min(u * inv_sum, 1.0), min(v * inv_sum, 1.0));
        Candidate::<f32>::new(t_in_range(ray.t_min, t, ray.t_max), t, u, v)
    }
}

impl<P: Lanes> Intersect<f32x8> for EmbreePluecker<P> {
    type Setup = ();

    #[inline(always)]
    fn setup(_: &Ray<f32x8>) {}

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32x8>, (): &()) -> Candidate<f32x8> {
        let EmbreePluecker { vertices: Vertices { v0, v1, v2 } } = self.widen();

        // Move the origin to zero.
        let (a, b, c) = (v0 - ray.origin, v1 - ray.origin, v2 - ray.origin);

        // Evaluate the edge functions: the weights of v1, v2 and v0, up to a common factor.
        let (ca, ab, bc) = (c - a, a - b, b - c);
        let u = ca.cross(c + a).dot(ray.dir);
        let v = ab.cross(a + b).dot(ray.dir);
        let w = bc.cross(b + c).dot(ray.dir);

        // Test whether the three signs agree, except for small weights. A sum that is not finite is a miss.
        let sum = u + v + w;
        let eps = f32x8::splat(f32::EPSILON) * sum.abs();
        let (least, greatest) = (min8(min8(u, v), w), max8(max8(u, v), w));
        let inside = (ge8(least, -eps) | le8(greatest, eps)) & lt8(eps, f32x8::splat(f32::INFINITY));

        // Intersect the plane. A ray parallel to it divides by zero: t is infinite or NaN.
        let n = stable_normal8(ca, ab, bc);
        let t = (f32x8::ONE / n.dot(ray.dir)) * a.dot(n);

        // Normalise the weights. They are zero if the sum has no reciprocal.
        let inv_sum = lt8(sum.abs(), f32x8::splat(f32::MIN_POSITIVE)).select(f32x8::ZERO, f32x8::ONE / sum);
        let (u, v) = (min8(u * inv_sum, f32x8::ONE), min8(v * inv_sum, f32x8::ONE));
        Candidate::<f32x8>::new(inside & t_in_range8(ray.t_min, t, ray.t_max), t, u, v)
    }
}
