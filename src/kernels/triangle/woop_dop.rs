//! `triangle/woop_dop`: the watertight test without its fallback. The letters stand for difference of products.
//!
//! **Source:** S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle Intersection", 2013. Difference of products: W.
//! Kahan, "On the Cost of Floating-Point Computation Without Extra-Precise Arithmetic", 2004; C.-P. Jeannerod, N.
//! Louvet, J.-M. Muller, "Further analysis of Kahan's algorithm for the accurate computation of 2×2 determinants",
//! 2013.
//!
//! **Idea:** one fused operation recovers what the rounding of `c·d` lost. Then `a·b - c·d` has a relative error of at
//! most 2ε, ε = 2⁻²⁴. Its sign is right, and it is zero only where the exact value is zero. So no sign is computed
//! twice. The only branch is the one for a `t` that cancels, as in `triangle/woop`.
//!
//! **Differs from `triangle/woop`** only in the determinants. The two triangles at an edge may get different
//! magnitudes, because they round different products first. They always get opposite signs.
//!
//! **Edges, claims, failures, degenerate input:** as `triangle/woop`. The recovered rounding error must not be
//! subnormal, so the range below ends at products of 1e-31.
//!
//! **Operations:** 22 multiplications, 28 additions, 1 division, 8 minima, maxima and comparisons. 6 multiplications
//! are fused with an addition. Setup: 3 divisions. 36 bytes prepared. The kernel exists only in builds with fused
//! multiply-add.

use glam::Vec3;
use wide::f32x8;

use super::woop::{Shear, Shear8, Sheared, Sheared8, prepare};
use super::{Vertices, sign_agreement, sign_agreement8};
use crate::geom::lanes::{Lanes, Vec3x8, ge8, mul_add, mul_add8};
use crate::geom::{Candidate, Ray, Triangle};
use crate::kernels::aabb::Slabs;
use crate::kernels::{Claim, Id, Info, Intersect, Kernel, Operations};

prepared! {
    /// Triangles for the watertight test by differences of products.
    pub struct WoopDop<P: Lanes> {
        vertices: Vertices<P>,
    }
}

impl Kernel for WoopDop<f32> {
    type Shape = Triangle;
    type Packet = WoopDop<f32x8>;
    const INFO: Info = Info {
        id: Id::of("triangle/woop_dop"),
        idea: "watertight shear, signs by Kahan's difference of products: none is computed twice",
        source: "Woop, Benthin, Wald, 2013; Jeannerod, Louvet, Muller, \"Further analysis of Kahan's algorithm\", 2013",
        operations: Operations { mul: 22, add: 28, compare: 8, div: 1, reads: 9, fused: 6, ..Operations::NONE },
        setup: Shear::OPERATIONS,
        claims: &[Claim::EdgeWatertight, Claim::VertexWatertight, Claim::NoHitBehind],
    };

    fn prepare(shape: &Triangle) -> Self {
        Self { vertices: prepare(shape) }
    }

    prepared!(gather, lane);

    #[inline(always)]
    fn candidate_in_lane(packet: &Self::Packet, lane: usize, ray: &Ray<f32x8>, setup: &Shear8) -> Candidate<f32x8> {
        let vertices = Self::lane(packet, lane).widen().vertices;
        candidate8(&vertices, ray, setup, || Self::careful_in_lane(packet, lane, ray, setup))
    }

    #[inline(always)]
    fn bounds(packet: &Self::Packet) -> Option<Slabs<f32x8>> {
        Some(packet.vertices.bounds())
    }
}

/// `p.x·q.y - p.y·q.x` with a relative error of at most 2ε.
#[inline(always)]
pub(super) fn difference((p, q): (Vec3, Vec3)) -> f32 {
    // Round one product and recover its rounding error.
    let product = p.y * q.x;
    let lost = mul_add(-p.y, q.x, product);
    // Add it to the difference of products.
    mul_add(p.x, q.y, -product) + lost
}

/// [`difference`] in eight lanes.
#[inline(always)]
pub(super) fn difference8((p, q): (Vec3x8, Vec3x8)) -> f32x8 {
    // Round one product and recover its rounding error.
    let product = p.y * q.x;
    let lost = mul_add8(-p.y, q.x, product);
    // Add it to the difference of products.
    mul_add8(p.x, q.y, -product) + lost
}

impl WoopDop<f32> {
    /// The same test, with every `t` that cancels taken from the plane.
    #[cold]
    #[inline(never)]
    fn careful(&self, ray: &Ray<f32>, setup: &Shear) -> Candidate<f32> {
        let sheared = Sheared::of(&self.vertices, ray, setup);
        let weights = sheared.edges().map(difference);
        let inside = sign_agreement(weights) >= 0.0;
        sheared.careful_hit(inside, weights, &self.vertices, ray, setup)
    }

    /// [`WoopDop::careful8`] for the triangle in one lane.
    #[cold]
    #[inline(never)]
    fn careful_in_lane(packet: &WoopDop<f32x8>, lane: usize, ray: &Ray<f32x8>, setup: &Shear8) -> Candidate<f32x8> {
        <Self as Kernel>::lane(packet, lane).careful8(ray, setup)
    }
}

impl<P: Lanes> WoopDop<P> {
    /// [`WoopDop::careful`] in eight lanes.
    #[cold]
    #[inline(never)]
    fn careful8(&self, ray: &Ray<f32x8>, setup: &Shear8) -> Candidate<f32x8> {
        let WoopDop { vertices } = self.widen();
        let sheared = Sheared8::of(&vertices, ray, setup);
        let weights = sheared.edges().map(difference8);
        let inside = ge8(sign_agreement8(weights), f32x8::ZERO);
        sheared.careful_hit(inside, weights, &vertices, ray, setup)
    }
}

impl Intersect<f32> for WoopDop<f32> {
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

        // Compute the weights with exact signs.
        let [u, v, w] = sheared.edges();
        let weights = [difference(u), difference(v), difference(w)];

        // Compare the signs.
        let inside = sign_agreement(weights) >= 0.0;
        if !inside {
            return Candidate::MISS;
        }

        // Interpolate t.
        let hit = sheared.interpolate(weights, setup);

        // Start again where t cancels.
        if sheared.cancels(weights, &hit) {
            return self.careful(ray, setup);
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
    fn candidate(&self, ray: &Ray<f32x8>, setup: &Shear8) -> Candidate<f32x8> {
        candidate8(&self.widen().vertices, ray, setup, || self.careful8(ray, setup))
    }
}

/// The packet twin. `careful` gives the hits where this test is not exact enough.
#[inline(always)]
fn candidate8(
    vertices: &Vertices<f32x8>,
    ray: &Ray<f32x8>,
    setup: &Shear8,
    careful: impl FnOnce() -> Candidate<f32x8>,
) -> Candidate<f32x8> {
    // Shear space: the ray becomes an axis.
    let sheared = Sheared8::of(vertices, ray, setup);

    // Compute the weights with exact signs.
    let [u, v, w] = sheared.edges();
    let weights = [difference8(u), difference8(v), difference8(w)];

    // Compare the signs.
    let inside = ge8(sign_agreement8(weights), f32x8::ZERO);

    // Interpolate t.
    let hit = sheared.interpolate(weights, setup);

    // Start again where t cancels.
    if (inside & sheared.straddles()).any() && (inside & sheared.cancels(weights, &hit)).any() {
        return careful();
    }

    // Test the range of t.
    hit.in_range(inside, ray)
}
