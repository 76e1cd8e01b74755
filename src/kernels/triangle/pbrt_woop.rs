//! `triangle/pbrt_woop`: pbrt's triangle test, which returns a hit only if its `t` is certainly positive.
//!
//! **Source:** pbrt-v4, `IntersectTriangle` in `src/pbrt/shapes.cpp`; M. Pharr, W. Jakob, G. Humphreys, "Physically
//! Based Rendering", 4th edition, 2023, chapter 6. The test is that of S. Woop, C. Benthin, I. Wald,
//! "Watertight Ray/Triangle Intersection", 2013, with the determinants of `triangle/woop_dop`.
//!
//! **Idea:** bound the error of `t` by the largest coordinates of the sheared triangle and the largest weight. A hit
//! within this bound, δt, of the ray's start is rejected. Then a ray that leaves a triangle does not hit it.
//!
//! **Differs from the source:** both ends of the interval count, and δt is added to the first one. In pbrt that is
//! always zero. The interval is compared with `t`, not with `t` times the determinant, because rounding may move `t`
//! over the end. Only determinants that are zero are computed again in `f64`, not all three. On a tie between axes,
//! another one is the longest.
//!
//! **Fails:** δt is relative to the largest weight, but `t` is relative to their sum. In the bound the weights have the
//! error of a shear of the distance. So δt exceeds `t` where a triangle is thin or seen at a grazing angle, and the
//! triangle vanishes for such rays. Besides, the bound adds lengths across the ray to depths that are already divided
//! by the direction: it is meant for directions of about length 1. With short ones, δt exceeds `t`, and hits are lost.
//!
//! **Degenerate input:** as `triangle/woop`. pbrt also rejects a triangle whose squared normal vanishes in `f32`: with
//! legs below about 5e-12.
//!
//! **Operations:** 38 multiplications, 35 additions, 1 division, 18 minima, maxima and comparisons. 6 multiplications
//! are fused with an addition. Setup: 3 divisions. 36 bytes prepared. The kernel exists only in builds with fused
//! multiply-add, which the determinants need.

use glam::Vec3;
use wide::f32x8;

use super::woop::{Shear, Shear8, Sheared, Sheared8, prepare};
use super::woop_dop::{difference, difference8};
use super::{Vertices, sign_agreement, sign_agreement8};
use crate::geom::lanes::{Lanes, eq8, ge8, gt8, max, max8, t_in_range, t_in_range8};
use crate::geom::{Candidate, Ray, Triangle};
use crate::kernels::aabb::Slabs;
use crate::kernels::{Id, Info, Intersect, Kernel, Operations};

prepared! {
    /// Triangles for pbrt's test.
    pub struct PbrtWoop<P: Lanes> {
        vertices: Vertices<P>,
    }
}

impl Kernel for PbrtWoop<f32> {
    type Shape = Triangle;
    type Packet = PbrtWoop<f32x8>;
    const INFO: Info = Info {
        id: Id::of("triangle/pbrt_woop"),
        idea: "pbrt's watertight shear: a t within its own error bound is no hit",
        source: "Pharr, Jakob, Humphreys, \"Physically Based Rendering\", 4th edition, 2023; pbrt-v4, shapes.cpp",
        operations: Operations { mul: 38, add: 35, compare: 18, div: 1, reads: 9, fused: 6, ..Operations::NONE },
        setup: Shear::OPERATIONS,
        claims: &[],
    };

    fn prepare(shape: &Triangle) -> Self {
        let vertices = prepare(shape);
        let Vertices { v0, v1, v2 } = vertices;
        let vanishes = (v2 - v0).cross(v1 - v0).length_squared() == 0.0;
        Self { vertices: Vertices { v0: if vanishes { Vec3::NAN } else { v0 }, v1, v2 } }
    }

    prepared!(gather, lane);

    #[inline(always)]
    fn bounds(packet: &Self::Packet) -> Option<Slabs<f32x8>> {
        Some(packet.vertices.bounds())
    }
}

/// γₙ = nε / (1 - nε), ε = 2⁻²⁴: the relative error of n roundings.
const fn gamma(n: f32) -> f32 {
    const EPSILON: f32 = f32::EPSILON / 2.0;
    n * EPSILON / (1.0 - n * EPSILON)
}

/// The largest magnitude of three numbers.
#[inline(always)]
fn largest([a, b, c]: [f32; 3]) -> f32 {
    max(max(a.abs(), b.abs()), c.abs())
}

/// [`largest`] in eight lanes.
#[inline(always)]
fn largest8([a, b, c]: [f32x8; 3]) -> f32x8 {
    max8(max8(a.abs(), b.abs()), c.abs())
}

impl Intersect<f32> for PbrtWoop<f32> {
    type Setup = Shear;

    #[inline(always)]
    fn setup(ray: &Ray<f32>) -> Shear {
        Shear::of(ray)
    }

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32>, setup: &Shear) -> Candidate<f32> {
        let Self { vertices } = self;

        // Shear space: the ray becomes an axis.
        let sheared = Sheared::of(vertices, ray, setup);

        // Compute the weights of v1, v2 and v0 and compare their signs. Compute zeros again in f64.
        let [u, v, w] = sheared.edges();
        let mut weights = [difference(u), difference(v), difference(w)];
        let mut signs = sign_agreement(weights);
        if signs == 0.0 {
            weights = sheared.exact_weights(weights);
            signs = sign_agreement(weights);
        }
        let inside = signs >= 0.0;
        if !inside {
            return Candidate::MISS;
        }

        // Interpolate t.
        let Sheared { a, b, c } = sheared;
        let [u, v, w] = weights;
        let depths = [b.z * setup.z, c.z * setup.z, a.z * setup.z];
        let inv_det = 1.0 / (u + v + w);
        let t = (u * depths[0] + v * depths[1] + w * depths[2]) * inv_det;

        // Bound the errors of the coordinates, of the weights, and of t.
        let (x, y, z) = (largest([a.x, b.x, c.x]), largest([a.y, b.y, c.y]), largest(depths));
        let (delta_x, delta_y, delta_z) = (gamma(5.0) * (x + z), gamma(5.0) * (y + z), gamma(3.0) * z);
        let delta_weight = 2.0 * (gamma(2.0) * x * y + delta_y * x + delta_x * y);
        let weight = largest(weights);
        let delta_t = 3.0 * (gamma(3.0) * weight * z + delta_weight * z + delta_z * weight) * inv_det.abs();

        // Test the range of t. It has to be past the start by its error.
        let certain = t - delta_t > ray.t_min;
        Candidate::<f32>::new(certain & t_in_range(ray.t_min, t, ray.t_max), t, u * inv_det, v * inv_det)
    }
}

impl<P: Lanes> Intersect<f32x8> for PbrtWoop<P> {
    type Setup = Shear8;

    #[inline(always)]
    fn setup(ray: &Ray<f32x8>) -> Shear8 {
        Shear8::of(ray)
    }

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32x8>, setup: &Shear8) -> Candidate<f32x8> {
        let PbrtWoop { vertices } = self.widen();

        // Shear space: the ray becomes an axis.
        let sheared = Sheared8::of(&vertices, ray, setup);

        // Compute the weights of v1, v2 and v0 and compare their signs. Compute zeros again in f64.
        let [u, v, w] = sheared.edges();
        let mut weights = [difference8(u), difference8(v), difference8(w)];
        let mut signs = sign_agreement8(weights);
        if eq8(signs, f32x8::ZERO).any() {
            weights = sheared.exact_weights(weights);
            signs = sign_agreement8(weights);
        }
        let inside = ge8(signs, f32x8::ZERO);

        // Interpolate t.
        let Sheared8 { a, b, c } = sheared;
        let [u, v, w] = weights;
        let depths = [b.z * setup.z, c.z * setup.z, a.z * setup.z];
        let inv_det = f32x8::ONE / (u + v + w);
        let t = (u * depths[0] + v * depths[1] + w * depths[2]) * inv_det;

        // Bound the errors of the coordinates, of the weights, and of t.
        let [gamma2, gamma3, gamma5] = [2.0, 3.0, 5.0].map(|n| f32x8::splat(gamma(n)));
        let (x, y, z) = (largest8([a.x, b.x, c.x]), largest8([a.y, b.y, c.y]), largest8(depths));
        let (delta_x, delta_y, delta_z) = (gamma5 * (x + z), gamma5 * (y + z), gamma3 * z);
        let delta_weight = f32x8::splat(2.0) * (gamma2 * x * y + delta_y * x + delta_x * y);
        let weight = largest8(weights);
        let delta_t = f32x8::splat(3.0) * (gamma3 * weight * z + delta_weight * z + delta_z * weight) * inv_det.abs();

        // Test the range of t. It has to be past the start by its error.
        let certain = gt8(t - delta_t, ray.t_min);
        let hits = inside & certain & t_in_range8(ray.t_min, t, ray.t_max);
        Candidate::<f32x8>::new(hits, t, u * inv_det, v * inv_det)
    }
}
