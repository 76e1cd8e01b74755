//! `triangle/woop_dop`: the watertight test without its fallback. The letters stand for difference of products.
//!
//! **Source:** S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle Intersection", 2013. Difference of products: W.
//! Kahan, "On the Cost of Floating-Point Computation Without Extra-Precise Arithmetic", 2004; C.-P. Jeannerod, N.
//! Louvet, J.-M. Muller, "Further analysis of Kahan's algorithm for the accurate computation of 2×2 determinants",
//! 2013.
//!
//! **Idea:** one fused operation recovers what the rounding of `c·d` lost. Then `a·b - c·d` has a relative error of at
//! most 2ε, ε = 2⁻²⁴. Its sign is right, and it is zero only where the exact value is zero. So no sign is computed
//! twice. The only branch is the one for a `t` that cancels, as in `triangle/woop`. With it packets take 1.07 to 1.13
//! times as long.
//!
//! **Differs from `triangle/woop`** only in the determinants. The two triangles at an edge may get different
//! magnitudes, because they round different products first. They always get opposite signs.
//!
//! **Edges, claims, failures, degenerate input:** as `triangle/woop`. The recovered rounding error must not be
//! subnormal, so the range below ends at products of 1e-31.
//!
//! **Operations:** 22 multiplications, 28 additions, 1 division, 9 minima, maxima and comparisons. 6 multiplications
//! are fused with an addition. Setup: 3 divisions. 40 bytes prepared. The kernel exists only in builds with fused
//! multiply-add.

use glam::Vec3;
use wide::f32x8;

use super::woop::{Interpolated, Shear, Shear8, Sheared, Sheared8, close, prepare};
use super::{Vertices, sign_agreement, sign_agreement8};
use crate::geom::lanes::{Lanes, Mask8, Vec3x8, ge8, mul_add, mul_add8};
use crate::geom::{Hit, Ray, Triangle};
use crate::kernels::aabb::Slabs;
use crate::kernels::{Claim, Id, Info, Intersect, Kernel, Operations};

prepared! {
    /// Triangles for the watertight test by differences of products.
    pub struct WoopDop<P: Lanes> {
        vertices: Vertices<P>,
        /// [`close`].
        close: P,
    }
}

impl Kernel for WoopDop<f32> {
    type Shape = Triangle;
    type Packet = WoopDop<f32x8>;
    const INFO: Info = Info {
        id: Id::of("triangle/woop_dop"),
        idea: "watertight shear, signs by Kahan's difference of products: none is computed twice",
        source: "Woop, Benthin, Wald, 2013; Jeannerod, Louvet, Muller, \"Further analysis of Kahan's algorithm\", 2013",
        operations: Operations { mul: 22, add: 28, compare: 9, div: 1, reads: 10, fused: 6, ..Operations::NONE },
        setup: Shear::OPERATIONS,
        claims: &[Claim::EdgeWatertight, Claim::VertexWatertight, Claim::NoHitBehind],
    };

    fn prepare(shape: &Triangle) -> Self {
        Self { vertices: prepare(shape), close: close(shape) }
    }

    prepared!(gather, lane);

    #[inline(always)]
    fn bounds(packet: &Self::Packet) -> Option<Slabs<f32x8>> {
        Some(packet.vertices.bounds())
    }
}

/// `p.x·q.y - p.y·q.x` with a relative error of at most 2ε.
#[inline(always)]
fn difference((p, q): (Vec3, Vec3)) -> f32 {
    // Round one product and recover its rounding error.
    let product = p.y * q.x;
    let lost = mul_add(-p.y, q.x, product);
    // Add it to the difference of products.
    mul_add(p.x, q.y, -product) + lost
}

/// [`difference`] in eight lanes.
#[inline(always)]
fn difference8((p, q): (Vec3x8, Vec3x8)) -> f32x8 {
    // Round one product and recover its rounding error.
    let product = p.y * q.x;
    let lost = mul_add8(-p.y, q.x, product);
    // Add it to the difference of products.
    mul_add8(p.x, q.y, -product) + lost
}

/// The hit with `t` from the plane.
#[cold]
#[inline(never)]
fn with_plane_t(hit: Interpolated<f32>, vertices: &Vertices<f32>, ray: &Ray<f32>) -> Hit<f32> {
    hit.with_plane_t(true, vertices, ray).in_range(true, ray)
}

/// [`with_plane_t`] in eight lanes.
#[cold]
#[inline(never)]
fn with_plane_t8<P: Lanes>(inside: Mask8, hit: Interpolated<f32x8>, of: &WoopDop<P>, ray: &Ray<f32x8>) -> Hit<f32x8> {
    hit.with_plane_t(inside, &of.widen().vertices, ray).in_range(inside, ray)
}

impl Intersect<f32> for WoopDop<f32> {
    type Setup = Shear;

    #[inline(always)]
    fn setup(ray: &Ray<f32>) -> Shear {
        Shear::of(ray)
    }

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32>, setup: &Shear) -> Hit<f32> {
        let Self { vertices, close } = self;

        // Shear space: the ray becomes an axis.
        let sheared = Sheared::of(vertices, ray, setup);

        // Compute the weights with exact signs.
        let [u, v, w] = sheared.edges();
        let weights = [difference(u), difference(v), difference(w)];

        // Compare the signs.
        let inside = sign_agreement(weights) >= 0.0;
        if !inside {
            return Hit::MISS;
        }

        // Interpolate t. Take it from the plane where it cancels.
        let hit = sheared.interpolate(weights, *close, setup);
        if hit.cancels {
            return with_plane_t(hit, vertices, ray);
        }

        // Test the range of t.
        hit.in_range(inside, ray)
    }
}

impl<P: Lanes> Intersect<f32x8> for WoopDop<P> {
    type Setup = Shear8;

    #[inline(always)]
    fn setup(ray: &Ray<f32x8>) -> Shear8 {
        Shear8::of(ray)
    }

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32x8>, setup: &Shear8) -> Hit<f32x8> {
        let WoopDop { vertices, close } = self.widen();

        // Shear space: the ray becomes an axis.
        let sheared = Sheared8::of(&vertices, ray, setup);

        // Compute the weights with exact signs.
        let [u, v, w] = sheared.edges();
        let weights = [difference8(u), difference8(v), difference8(w)];

        // Compare the signs.
        let inside = ge8(sign_agreement8(weights), f32x8::ZERO);

        // Interpolate t. Take it from the plane where it cancels.
        let hit = sheared.interpolate(weights, close, setup);
        if (inside & hit.cancels).any() {
            return with_plane_t8(inside, hit, self, ray);
        }

        // Test the range of t.
        hit.in_range(inside, ray)
    }
}
