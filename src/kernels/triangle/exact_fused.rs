//! `triangle/exact_fused`: the exact half-open test with fused multiply-add.
//!
//! **Source:** as `triangle/exact_half_open`.
//!
//! **Idea:** half of the multiplications of the test are followed by an addition. One instruction does both, and rounds
//! once. So no product is rounded more often than in `triangle/exact`, and the same bound holds.
//!
//! **Differs from `triangle/exact_half_open`** only in the last digits of `t`, `u` and `v`. Decisions are exact, so
//! they are the same. The last digits are those of every machine that fuses.
//!
//! **Edges, claims, range, degenerate input:** as `triangle/exact_half_open`.
//!
//! **Operations:** as `triangle/exact`. 11 multiplications are fused with an addition. The kernel exists only in builds
//! with fused multiply-add.

use glam::Vec3;
use wide::f32x8;

use super::exact::{Arithmetic, Exact, OPERATIONS, SETUP_OPERATIONS, setup, setup8, variant};
use super::exact_half_open::{CLAIMS, HalfOpen};
use crate::geom::lanes::{Lanes, Vec3x8, mul_add, mul_add8};
use crate::geom::{Candidate, Ray, Triangle};
use crate::kernels::aabb::Slabs;
use crate::kernels::{Id, Info, Intersect, Kernel, Operations};

variant! {
    /// Triangles for the exact half-open test with fused multiply-add.
    ExactFused, HalfOpen, Fused, false,
    Info {
        id: Id::of("triangle/exact_fused"),
        idea: "the exact half-open test with fused multiply-add",
        source: "Kensler, Shirley, 2006; Edelsbrunner, Mücke, \"Simulation of Simplicity\", 1990",
        operations: Operations { fused: 11, ..OPERATIONS },
        setup: SETUP_OPERATIONS,
        claims: CLAIMS,
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
