//! temporary
use glam::{DVec3, Vec3};
use wide::f32x8;

use super::normal;
use crate::geom::lanes::{Lanes, t_in_range, t_in_range8};
use crate::geom::{Candidate, Ray, Triangle};
use crate::kernels::{Id, Info, Intersect, Kernel, Operations};
use super::embree_moller::{times_sign, times_sign8, weights_inside, weights_inside8};

prepared! {
    /// Triangles
    pub struct HavelHerout<P: Lanes> {
        u_row: P::Vec3,
        u0: P,
        v_row: P::Vec3,
        v0: P,
        n_row: P::Vec3,
        n0: P,
    }
}

impl Kernel for HavelHerout<f32> {
    type Shape = Triangle;
    type Packet = HavelHerout<f32x8>;
    const INFO: Info = Info {
        id: Id::of("triangle/havel_herout"),
        idea: "planes",
        source: "Havel, Herout, 2010",
        operations: Operations { mul: 23, add: 15, compare: 5, div: 1, reads: 12, ..Operations::NONE },
        setup: Operations::NONE,
        claims: &[],
    };

    fn prepare(shape: &Triangle) -> Self {
        let [v0, v1, v2] = shape.vertices().map(Vec3::as_dvec3);
        let (e1, e2, n) = (v1 - v0, v2 - v0, normal(shape));
        let squared = n.length_squared();
        let (u, v) = (e2.cross(n) / squared, n.cross(e1) / squared);
        let n = n / n.abs().max_element();
        let row = |gradient: DVec3| (gradient.as_vec3(), -gradient.dot(v0) as f32);
        let ((u_row, u0), (v_row, v0), (n_row, n0)) = (row(u), row(v), row(n));
        Self { u_row, u0, v_row, v0, n_row, n0 }
    }

    prepared!(gather, lane);
}

impl Intersect<f32> for HavelHerout<f32> {
    type Setup = ();
    #[inline(always)]
    fn setup(_: &Ray<f32>) {}

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32>, (): &()) -> Candidate<f32> {
        let Self { u_row, u0, v_row, v0, n_row, n0 } = *self;
        let det = n_row.dot(ray.dir);
        let size = det.abs();
        let det_t = -(n_row.dot(ray.origin) + n0);
        let p = ray.origin * det + ray.dir * det_t;
        let u = times_sign(u_row.dot(p) + u0 * det, det);
        let v = times_sign(v_row.dot(p) + v0 * det, det);
        if !weights_inside(u, v, size) {
            return Candidate::MISS;
        }
        let inv = 1.0 / size;
        let t = times_sign(det_t, det) * inv;
        Candidate::<f32>::new((size < f32::INFINITY) & t_in_range(ray.t_min, t, ray.t_max), t, u * inv, v * inv)
    }
}

impl<P: Lanes> Intersect<f32x8> for HavelHerout<P> {
    type Setup = ();
    #[inline(always)]
    fn setup(_: &Ray<f32x8>) {}

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32x8>, (): &()) -> Candidate<f32x8> {
        let HavelHerout { u_row, u0, v_row, v0, n_row, n0 } = self.widen();
        let det = n_row.dot(ray.dir);
        let size = det.abs();
        let det_t = -(n_row.dot(ray.origin) + n0);
        let p = ray.origin * det + ray.dir * det_t;
        let u = times_sign8(u_row.dot(p) + u0 * det, det);
        let v = times_sign8(v_row.dot(p) + v0 * det, det);
        let inside = weights_inside8(u, v, size);
        let inv = f32x8::ONE / size;
        let t = times_sign8(det_t, det) * inv;
        Candidate::<f32x8>::new(inside & t_in_range8(ray.t_min, t, ray.t_max), t, u * inv, v * inv)
    }
}
