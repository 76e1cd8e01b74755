//! A kernel of one's own, and what `raylanes::conformance` says about it.
//!
//! `cargo run --release --example own_kernel --no-default-features --features std`

use raylanes::geom::lanes::{Lanes, Vec3x8, ge8, le8, t_in_range, t_in_range8};
use raylanes::geom::{Candidate, Ray, Triangle};
use raylanes::kernels::{Info, Intersect, Kernel, Operations};
use raylanes::{conformance, glam, glam::Vec3, wide::f32x8};

/// The test of Möller and Trumbore. `OwnKernel<f32>` is one triangle, `OwnKernel<f32x8>` is eight.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OwnKernel<P: Lanes> {
    pub(crate) v0: P::Vec3,
    e1: P::Vec3,
    e2: P::Vec3,
}

impl Kernel for OwnKernel<f32> {
    type Shape = Triangle;
    type Packet = OwnKernel<f32x8>;
    const INFO: Info = Info::new("triangle/own", "Cramer's rule with two cross products", "Möller, Trumbore, 1997")
        .with_operations(Operations::new(27, 18, 5, 1).with_reads(9));

    fn prepare(shape: &Triangle) -> Self {
        // A triangle without an area must miss. In f64, the normal of such a triangle is exactly zero.
        let [v0, v1, v2] = shape.vertices().map(Vec3::as_dvec3);
        let v0 = if (v1 - v0).cross(v2 - v0) == glam::DVec3::ZERO { Vec3::NAN } else { shape.v0 };
        Self { v0, e1: shape.v1 - v0, e2: shape.v2 - v0 }
    }

    fn gather(primitives: &[Self; 8]) -> Self::Packet {
        let eight = |part: fn(&Self) -> Vec3| Vec3x8::from_lanes(primitives.each_ref().map(part));
        OwnKernel { v0: eight(|one| one.v0), e1: eight(|one| one.e1), e2: eight(|one| one.e2) }
    }

    fn lane(packet: &Self::Packet, lane: usize) -> Self {
        Self { v0: packet.v0.lane(lane), e1: packet.e1.lane(lane), e2: packet.e2.lane(lane) }
    }
}

impl Intersect<f32> for OwnKernel<f32> {
    type Setup = ();
    fn setup(_: &Ray<f32>) {}
    fn candidate(&self, ray: &Ray<f32>, (): &()) -> Candidate<f32> {
        let p = ray.dir.cross(self.e2);
        let inv_det = 1.0 / self.e1.dot(p);
        let s = ray.origin - self.v0;
        let u = s.dot(p) * inv_det;
        let q = s.cross(self.e1);
        let v = ray.dir.dot(q) * inv_det;
        let t = self.e2.dot(q) * inv_det;
        // True for a hit, so a NaN is a miss.
        let inside = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0);
        Candidate::<f32>::new(inside & t_in_range(ray.t_min, t, ray.t_max), t, u, v)
    }
}

impl<P: Lanes> Intersect<f32x8> for OwnKernel<P> {
    type Setup = ();
    fn setup(_: &Ray<f32x8>) {}
    fn candidate(&self, ray: &Ray<f32x8>, (): &()) -> Candidate<f32x8> {
        let (v0, e1, e2) = (P::widen_vec3(self.v0), P::widen_vec3(self.e1), P::widen_vec3(self.e2));
        let p = ray.dir.cross(e2);
        let inv_det = f32x8::ONE / e1.dot(p);
        let s = ray.origin - v0;
        let u = s.dot(p) * inv_det;
        let q = s.cross(e1);
        let v = ray.dir.dot(q) * inv_det;
        let t = e2.dot(q) * inv_det;
        let inside = ge8(u, f32x8::ZERO) & ge8(v, f32x8::ZERO) & le8(u + v, f32x8::ONE);
        Candidate::<f32x8>::new(inside & t_in_range8(ray.t_min, t, ray.t_max), t, u, v)
    }
}

fn main() {
    let report = conformance::check::<OwnKernel<f32>>();
    println!("{report}");
    report.assert_ok();
}
