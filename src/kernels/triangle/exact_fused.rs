//! `triangle/exact_fused`: the exact test with fused multiply-add.
//!
//! **Source:** as `triangle/exact`.
//!
//! **Idea:** half of the multiplications of `triangle/exact` are followed by an addition. One instruction does both,
//! and rounds once. So no product is rounded more often than there, and the same bound holds.
//!
//! **Differs from `triangle/exact`** only in the last digits of `t`, `u` and `v`. Decisions are exact, so they are the
//! same. The last digits are those of every machine that fuses.
//!
//! **Edges, claims, range, degenerate input:** as `triangle/exact`.
//!
//! **Operations:** as `triangle/exact`. 11 multiplications are fused with an addition. The kernel exists only in builds
//! with fused multiply-add.

use glam::Vec3;
use wide::f32x8;

use super::exact::{Arithmetic, Closed, Exact, OPERATIONS, SETUP_OPERATIONS, setup, setup8};
use crate::geom::lanes::{Lanes, Vec3x8, mul_add, mul_add8};
use crate::geom::{Hit, Ray, Triangle};
use crate::kernels::aabb::Slabs;
use crate::kernels::{Claim, Id, Info, Intersect, Kernel, Operations};

prepared! {
    /// Triangles for the exact test with fused multiply-add.
    pub struct ExactFused<P: Lanes> {
        exact: Exact<P>,
    }
}

impl Kernel for ExactFused<f32> {
    type Shape = Triangle;
    type Packet = ExactFused<f32x8>;
    const INFO: Info = Info {
        id: Id::of("triangle/exact_fused"),
        idea: "the exact test with fused multiply-add",
        source: "Kensler, Shirley, 2006; Shewchuk, \"Adaptive Precision […] Robust Geometric Predicates\", 1997",
        operations: Operations { fused: 11, ..OPERATIONS },
        setup: SETUP_OPERATIONS,
        claims: &[Claim::EdgeWatertight, Claim::VertexWatertight, Claim::NoHitBehind, Claim::RightDecision],
    };

    fn prepare(shape: &Triangle) -> Self {
        Self { exact: Exact::of(shape) }
    }

    prepared!(gather, lane);

    #[inline(always)]
    fn bounds(packet: &Self::Packet) -> Option<Slabs<f32x8>> {
        Some(packet.exact.bounds())
    }
}

impl Intersect<f32> for ExactFused<f32> {
    type Setup = f32;

    #[inline(always)]
    fn setup(ray: &Ray<f32>) -> f32 {
        setup(ray)
    }

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32>, setup: &f32) -> Hit<f32> {
        self.exact.test::<Closed, Fused, false>(ray, *setup)
    }
}

impl<P: Lanes> Intersect<f32x8> for ExactFused<P> {
    type Setup = f32x8;

    #[inline(always)]
    fn setup(ray: &Ray<f32x8>) -> f32x8 {
        setup8(ray)
    }

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32x8>, setup: &f32x8) -> Hit<f32x8> {
        self.widen().exact.test8::<Closed, Fused, false>(ray, *setup)
    }
}

/// One of two products, and two of three, are rounded together with a sum.
struct Fused;

impl Arithmetic for Fused {
    // In each component, `a` is negated and not `b`. `b` is the ray's direction, and the compiler would keep its
    // negative in three registers.
    #[inline(always)]
    fn cross(a: Vec3, b: Vec3) -> Vec3 {
        Vec3 { x: mul_add(-a.z, b.y, a.y * b.z), y: mul_add(-a.x, b.z, a.z * b.x), z: mul_add(-a.y, b.x, a.x * b.y) }
    }

    #[inline(always)]
    fn cross8(a: Vec3x8, b: Vec3x8) -> Vec3x8 {
        Vec3x8 {
            x: mul_add8(-a.z, b.y, a.y * b.z),
            y: mul_add8(-a.x, b.z, a.z * b.x),
            z: mul_add8(-a.y, b.x, a.x * b.y),
        }
    }

    #[inline(always)]
    fn dot(a: Vec3, b: Vec3) -> f32 {
        mul_add(a.x, b.x, mul_add(a.y, b.y, a.z * b.z))
    }

    #[inline(always)]
    fn dot8(a: Vec3x8, b: Vec3x8) -> f32x8 {
        mul_add8(a.x, b.x, mul_add8(a.y, b.y, a.z * b.z))
    }
}
