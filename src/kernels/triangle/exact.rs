//! `triangle/exact`: a fast test that knows when it may be wrong, and two slower ones behind it.
//!
//! **Source:** the test is that of A. Kensler, P. Shirley, "Optimizing Ray-Triangle Intersection via Automated Search",
//! 2006. The stages follow J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
//! Predicates", 1997. The bound is ours, in the manner of N. J. Higham, "Accuracy and Stability of Numerical
//! Algorithms", 2002.
//!
//! **Idea:** `triangle/kensler_shirley` in `f32`, with a bound on all its rounding errors. A ray that is farther inside
//! or outside than the bound is decided. The few others are decided again in `f64`, and where that does not tell, by an
//! exact sum (`kernels::volume`). So every ray is decided as if nothing were ever rounded. In packets, all of this
//! happens behind one branch that is almost never taken.
//!
//! **The bound.** Let `ε = 2⁻²⁴`. `|x|₁` is the sum of the components' sizes and `|x|∞` the largest of them. Edges and
//! normal are divided by `S`, the 1-norm of the longer of the two prepared edges. So `|e|₁ <= 1` and `|n|₁ <= S`. Let
//! `c = v0 - origin`, `a = (c × d)·e2`, `b = (c × d)·e1` and `D = n·d`. `^` marks computed numbers. The ray is inside
//! exactly if `a/D`, `b/D` and `(D - a - b)/D` are not negative. Let `E = |c|₁·|d|∞` and `F = S·|d|∞`.
//!
//! 1. In `a`, a product of three factors is rounded at most 7 times: `c` once, `e2` once, and 5 times by `×` and `·`.
//!    The sizes of all products add up to at most `Σ|eᵢ|(|cⱼ||dₖ| + |cₖ||dⱼ|) <= E`. So `|â - a| <= 7εE`. `b` likewise.
//! 2. In `D`, a product is rounded 4 times: `n` once, and 3 times by `·`. So `|D̂ - D| <= 4εF`.
//! 3. Count errors relative to `D̂`, and let `g = ε(E + F)/|D̂|`. Those of `a/D̂` and `b/D̂` are at most `7g`. That of
//!    the third weight is at most `(14E + 4F)ε/|D̂| <= 14g`. The division and `1 - (u + v)` round too. Beside a weight
//!    of zero, this adds `3ε`. Because `|D̂| <= F(1 + 4ε)`, that is less than `3.01g`. All in all, less than `17.1g`.
//! 4. So take `B = 18g`. What is left covers terms of second order and the roundings of `B`, below `2⁻²⁰·B`. If the
//!    smallest weight is above `B`, all three true weights have the sign of `D̂`. Their sum is `D`: the ray is inside.
//!    If it is below `-B`, one true weight has the other sign: the ray is outside.
//! 5. That includes a `D̂` of the wrong sign. Then `|D|` and `|D̂|` are at most `4εF`, and `B >= 4.5`. If the ray is
//!    inside, `|a|` and `|b|` add up to `|D|`. So no weight is below `-B`.
//!
//! **The distance.** `t = T/D` with `T = n·c`. By the same count `T` is off by at most `5ε|n|∞|c|₁`, and `D` by at most
//! `4ε|n|∞|d|₁`. At a hit, `|t||d|₁ <= |c|₁ + S`. So `t` is off by at most `9ε|n|∞(|c|₁ + S)/|D̂|`, and by two
//! roundings. At every angle, the point `origin + t·dir` is at most `9ε(|c|₁ + S)` off the plane. Where this bound on
//! the error of `t` is not below `|t|/16`, `t` is computed again in `f64`, and has the right sign. That happens to
//! rays that start on the triangle or run nearly in its plane.
//!
//! **Range:** `|d|∞` from 2⁻⁴⁰, `|d|∞ + |origin|₁` to 2⁴⁰, vertices to 2⁴⁰, `S` from 2⁻³⁰ to 2³⁰. There no product
//! overflows, and what underflow loses is below `2⁻⁴⁰` of the bounds. Where the reciprocal of `D̂` overflows, and
//! outside this range, the bound is infinite. Such rays go to the later stages, which are right for all finite numbers.
//!
//! **Edges:** closed. A ray exactly through an edge or a vertex hits all triangles that it meets there.
//!
//! **Claims:** every decision is right, for every ray and every triangle. So meshes are watertight, at silhouettes too.
//! Of rays that leave a triangle, none hits it.
//!
//! **Degenerate input:** a triangle of zero area is found when it is prepared, exactly, and misses. Its numbers are
//! such that the bound is `-∞`: it never takes the branch. A ray that is not valid takes it, and misses.
//!
//! **Cost:** against `triangle/kensler_shirley`, 1.17 times the time scalar, 1.29 to 1.34 times in packets of rays,
//! 1.27 to 1.38 times in packets of triangles. In a tracer, 0.9 to 1.0 times that of `triangle/woop`, but 1.05 to 1.12
//! times for packets of primary rays: they read 80 bytes per triangle.
//!
//! Tried, and not kept: edges computed from the vertices (56 bytes): packets 1.09 times as long; a tracer 0.92 to 0.98
//! times with a million triangles, 1.0 to 1.2 times with fewer. Edges and normal computed (44 bytes): 1.15 to 1.3
//! times. `|origin| + |v0|` in place of `|c|`: packets 0.95 times, but far from the origin most rays are not sure.
//!
//! **Operations:** 24 multiplications, 17 additions, 1 division, 9 minima, maxima and comparisons. Setup: 1
//! multiplication, 5 additions, 2 comparisons. 80 bytes prepared.

use glam::{DVec3, Vec3};
use wide::f32x8;

use super::{Vertices, normal};
use crate::geom::lanes::{Lanes, Mask8, Vec3x8, ge8, gt8, le8, max, max8, min, min8, t_in_range};
use crate::geom::{Hit, Ray, Triangle};
use crate::kernels::aabb::Slabs;
use crate::kernels::volume::{plane_t, volume};
use crate::kernels::{Claim, Id, Info, Intersect, Kernel, Operations};

prepared! {
    /// Triangles for the exact test.
    pub struct Exact<P: Lanes> {
        vertices: Vertices<P>,
        /// `S`. Infinite for a triangle out of range. `-∞` for one that misses everything.
        size: P,
        /// How small `|t·D̂|/(|c|₁ + S)` may be, before `t` is computed again.
        near: P,
        /// `(v0 - v1)/S`.
        e1: P::Vec3,
        /// `(v2 - v0)/S`.
        e2: P::Vec3,
        /// The normal, divided by `S`.
        n: P::Vec3,
    }
}

impl Kernel for Exact<f32> {
    type Shape = Triangle;
    type Packet = Exact<f32x8>;
    const INFO: Info = Info {
        id: Id::of("triangle/exact"),
        idea: "Kensler–Shirley with a proven error bound; where that does not decide: f64, then exact signs",
        source: "Kensler, Shirley, 2006; Shewchuk, \"Adaptive Precision […] Robust Geometric Predicates\", 1997",
        operations: OPERATIONS,
        setup: SETUP_OPERATIONS,
        claims: &[Claim::EdgeWatertight, Claim::VertexWatertight, Claim::NoHitBehind, Claim::RightDecision],
    };

    fn prepare(shape: &Triangle) -> Self {
        Self::of(shape)
    }

    prepared!(gather, lane);

    #[inline(always)]
    fn bounds(packet: &Self::Packet) -> Option<Slabs<f32x8>> {
        Some(packet.vertices.bounds())
    }
}

impl Intersect<f32> for Exact<f32> {
    type Setup = f32;

    #[inline(always)]
    fn setup(ray: &Ray<f32>) -> f32 {
        setup(ray)
    }

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32>, setup: &f32) -> Hit<f32> {
        self.test::<Closed, Separate, false>(ray, *setup)
    }
}

impl<P: Lanes> Intersect<f32x8> for Exact<P> {
    type Setup = f32x8;

    #[inline(always)]
    fn setup(ray: &Ray<f32x8>) -> f32x8 {
        setup8(ray)
    }

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32x8>, setup: &f32x8) -> Hit<f32x8> {
        self.test8::<Closed, Separate, false>(ray, *setup)
    }
}

/// Operations of [`Exact::test8`].
pub(super) const OPERATIONS: Operations =
    Operations { mul: 24, add: 17, compare: 9, div: 1, reads: 14, ..Operations::NONE };

/// Operations of [`setup`].
pub(super) const SETUP_OPERATIONS: Operations = Operations { mul: 1, add: 5, compare: 2, ..Operations::NONE };

/// `ε`, half an ulp of 1.
const EPSILON: f32 = f32::EPSILON / 2.0;

/// Where the error of `t` may be larger than this, relative to `t`, its sign is not sure.
const T_ERROR: f64 = 1.0 / 16.0;
/// The same for kernels that compute `t` again where it is not precise.
const PRECISE_T_ERROR: f64 = 1.0 / 4096.0;
const PRECISE_T: f32 = (T_ERROR / PRECISE_T_ERROR) as f32;

/// Range in which no product overflows or loses digits that count.
const LONGEST_RAY: f32 = (1u64 << 40) as f32;
const SHORTEST_RAY: f32 = 1.0 / LONGEST_RAY;
const LARGEST: f64 = (1 << 30) as f64;

/// `18ε|d|∞`, the part of the bound that depends on the ray alone. Infinite for a ray out of range or not valid.
#[inline(always)]
pub(super) fn setup(ray: &Ray<f32>) -> f32 {
    let (d, o) = (ray.dir.abs(), ray.origin.abs());
    let length = max(max(d.x, d.y), d.z);
    let reach = length + (o.x + o.y + o.z);
    let fits = (length >= SHORTEST_RAY) & (reach <= LONGEST_RAY);
    if fits { length * (18.0 * EPSILON) } else { f32::INFINITY }
}

/// [`setup`] in eight lanes.
#[inline(always)]
pub(super) fn setup8(ray: &Ray<f32x8>) -> f32x8 {
    let (d, o) = (ray.dir, ray.origin);
    let length = max8(max8(d.x.abs(), d.y.abs()), d.z.abs());
    let reach = length + (o.x.abs() + o.y.abs() + o.z.abs());
    let fits = ge8(length, f32x8::splat(SHORTEST_RAY)) & le8(reach, f32x8::splat(LONGEST_RAY));
    fits.select(length * f32x8::splat(18.0 * EPSILON), f32x8::splat(f32::INFINITY))
}

/// Products and sums, rounded separately or together. The bound covers both: no product is rounded more than stated.
pub(super) trait Arithmetic {
    fn cross(a: Vec3, b: Vec3) -> Vec3;
    fn cross8(a: Vec3x8, b: Vec3x8) -> Vec3x8;
    fn dot(a: Vec3, b: Vec3) -> f32;
    fn dot8(a: Vec3x8, b: Vec3x8) -> f32x8;
}

/// Every product is rounded, as on every machine.
pub(super) struct Separate;

impl Arithmetic for Separate {
    #[inline(always)]
    fn cross(a: Vec3, b: Vec3) -> Vec3 {
        a.cross(b)
    }

    #[inline(always)]
    fn cross8(a: Vec3x8, b: Vec3x8) -> Vec3x8 {
        a.cross(b)
    }

    #[inline(always)]
    fn dot(a: Vec3, b: Vec3) -> f32 {
        a.dot(b)
    }

    #[inline(always)]
    fn dot8(a: Vec3x8, b: Vec3x8) -> f32x8 {
        a.dot(b)
    }
}

impl Exact<f32> {
    /// The prepared triangle.
    pub(super) fn of(shape: &Triangle) -> Self {
        let [v0, v1, v2] = shape.vertices().map(Vec3::as_dvec3);
        let norm = |v: DVec3| v.x.abs() + v.y.abs() + v.z.abs();
        let (e1, e2, n) = (v0 - v1, v2 - v0, normal(shape));
        let size = norm(e1).max(norm(e2));
        if !size.is_finite() || n == DVec3::ZERO && is_degenerate([v0, v1, v2]) {
            return Self::MISSES;
        }
        let far = [v0, v1, v2].map(|v| v.abs().max_element()).into_iter().fold(0.0, f64::max);
        let fits = (1.0 / LARGEST..=LARGEST).contains(&size) && far <= LONGEST_RAY.into();
        let scaled = |v: DVec3| (v / size).as_vec3();
        // The last term covers the roundings of a normal that is short, because the triangle is a sliver.
        let near = 9.0 / T_ERROR * f64::from(EPSILON) * (n.abs().max_element() / size + f64::from(EPSILON) * size);
        Self {
            vertices: shape.into(),
            size: if fits { size as f32 } else { f32::INFINITY },
            near: near as f32,
            e1: scaled(e1),
            e2: scaled(e2),
            n: scaled(n),
        }
    }

    /// Weights of zero, and a bound of `-∞`. The normal is such that hardly any ray is parallel to it.
    const MISSES: Self = Self {
        vertices: Vertices { v0: Vec3::ZERO, v1: Vec3::ZERO, v2: Vec3::ZERO },
        size: f32::NEG_INFINITY,
        near: 0.0,
        e1: Vec3::ZERO,
        e2: Vec3::ZERO,
        n: Vec3::new(0.618_034, 1.324_718, 0.414_214),
    };

    /// The scalar twin. `PRECISE` if the `t` of a hit must be.
    #[inline(always)]
    pub(super) fn test<R: Rule, A: Arithmetic, const PRECISE: bool>(&self, ray: &Ray<f32>, setup: f32) -> Hit<f32> {
        let Self { vertices: Vertices { v0, v1, v2 }, size, near, e1, e2, n } = *self;

        // Compute the shared cross product and the determinants.
        let c = v0 - ray.origin;
        let r = A::cross(c, ray.dir);
        let det = A::dot(n, ray.dir);
        let (a, b) = (A::dot(r, e2), A::dot(r, e1));

        // Miss early, without a division. The bound holds before the division too.
        let reach = c.x.abs() + c.y.abs() + c.z.abs() + size;
        let sign = det.to_bits() & (1 << 31);
        let [a_by_sign, b_by_sign] = [a, b].map(|x| f32::from_bits(x.to_bits() ^ sign));
        if min(min(a_by_sign, b_by_sign), det.abs() - (a_by_sign + b_by_sign)) < -(setup * reach) {
            return Hit::MISS;
        }

        // Compute the barycentrics and t.
        let inv_det = 1.0 / det;
        let (u, v) = (a * inv_det, b * inv_det);
        let t = A::dot(n, c) * inv_det;

        // Compare the smallest weight and t with their bounds.
        let weight = min(min(u, v), 1.0 - (u + v));
        let reach = reach * inv_det.abs();
        let decided = weight.abs() > setup * reach;
        let inside = weight > 0.0;
        let near = near * reach;
        let mut sure = decided & (!inside | (t.abs() > near));

        // Test the range of t. It is finite, because the ray is inside.
        let hit = inside & (t >= ray.t_min) & (t <= ray.t_max);
        if PRECISE {
            sure &= !hit | (t.abs() > near * PRECISE_T);
        }

        // Decide again what is not sure.
        if !sure {
            return decide::<R>([v0, v1, v2], ray);
        }
        Hit::<f32>::new(hit, t, u, v)
    }
}

impl<P: Lanes> Exact<P> {
    /// The boxes of the triangles.
    #[inline(always)]
    pub(super) fn bounds(&self) -> Slabs<f32x8> {
        self.vertices.widen().bounds()
    }

    /// The packet twin.
    #[inline(always)]
    pub(super) fn test8<R: Rule, A: Arithmetic, const PRECISE: bool>(
        &self,
        ray: &Ray<f32x8>,
        setup: f32x8,
    ) -> Hit<f32x8> {
        let Exact { vertices: Vertices { v0, .. }, size, near, e1, e2, n } = self.widen();

        // Compute the shared cross product and the determinants.
        let c = v0 - ray.origin;
        let r = A::cross8(c, ray.dir);
        let det = A::dot8(n, ray.dir);
        let (a, b) = (A::dot8(r, e2), A::dot8(r, e1));

        // Compute the barycentrics and t.
        let inv_det = f32x8::ONE / det;
        let (u, v) = (a * inv_det, b * inv_det);
        let t = A::dot8(n, c) * inv_det;

        // Compare the smallest weight and t with their bounds.
        let weight = min8(min8(u, v), f32x8::ONE - (u + v));
        let reach = (c.x.abs() + c.y.abs() + c.z.abs() + size) * inv_det.abs();
        let decided = gt8(weight.abs(), setup * reach);
        let inside = gt8(weight, f32x8::ZERO);
        let near = near * reach;
        let mut sure = decided & (!inside | gt8(t.abs(), near));

        // Test the range of t. It is finite, because the ray is inside.
        let hit = inside & ge8(t, ray.t_min) & le8(t, ray.t_max);
        if PRECISE {
            sure = sure & (!hit | gt8(t.abs(), near * f32x8::splat(PRECISE_T)));
        }
        let hit = Hit::<f32x8>::candidate(hit, t, u, v);

        // Decide again what is not sure. Copies are handed over: of values whose address is taken, the others would be
        // copies in memory, and a packet would take 1.1 times as long.
        let unsure = !sure;
        if unsure.any() {
            let (vertices, ray) = (self.vertices.widen(), *ray);
            return Decided::lanes::<R>(unsure.bits(), &vertices, &ray).blend(unsure, hit);
        }
        hit
    }
}

/// To whom a ray belongs that is exactly on an edge.
pub(super) trait Rule {
    /// Whether a ray of this origin and direction is inside the triangle of these vertices. `weights` are those of v1,
    /// v2 and v0, up to a common factor, with exact signs.
    fn is_inside(weights: [f64; 3], vertices: [DVec3; 3], dir: DVec3) -> bool;
}

/// To all triangles around the edge.
pub(super) struct Closed;

impl Rule for Closed {
    #[inline(always)]
    fn is_inside(weights: [f64; 3], _: [DVec3; 3], _: DVec3) -> bool {
        let [u, v, w] = weights;
        // All three are zero only if the ray is in the triangle's plane, or the triangle has no area.
        ((u >= 0.0) & (v >= 0.0) & (w >= 0.0) | (u <= 0.0) & (v <= 0.0) & (w <= 0.0)) & (u + v + w != 0.0)
    }
}

/// The second and third stage: the test in `f64`, with exact signs.
#[cold]
#[inline(never)]
fn decide<R: Rule>(vertices: [Vec3; 3], ray: &Ray<f32>) -> Hit<f32> {
    if !ray.is_valid() || ray.t_min > ray.t_max {
        return Hit::MISS;
    }
    // Compute the weights: the volumes between the ray and the three edges.
    let corners = vertices.map(Vec3::as_dvec3);
    let ([a, b, c], o, d) = (corners, ray.origin.as_dvec3(), ray.dir.as_dvec3());
    let [u, v, w] = [[c, a], [a, b], [b, c]].map(|[p, q]| volume(&[o, p, q], d, &[d]));
    if !R::is_inside([u, v, w], corners, d) {
        return Hit::MISS;
    }

    // Compute t from the plane, and test its range.
    let t = plane_t(vertices, ray.origin, ray.dir);
    let sum = u + v + w;
    Hit::<f32>::new(t_in_range(ray.t_min, t, ray.t_max), t, (u / sum) as f32, (v / sum) as f32)
}

/// Some lanes of a packet, decided again.
struct Decided {
    /// 1 in lanes that hit.
    hit: f32x8,
    t: f32x8,
    u: f32x8,
    v: f32x8,
}

impl Decided {
    /// [`decide`] in the lanes of `lanes`.
    #[cold]
    #[inline(never)]
    fn lanes<R: Rule>(mut lanes: u32, vertices: &Vertices<f32x8>, ray: &Ray<f32x8>) -> Self {
        let [mut hit, mut t, mut u, mut v] = [[0.0; 8]; 4];
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            let Vertices { v0, v1, v2 } = vertices.lane(lane);
            let decided = decide::<R>([v0, v1, v2], &ray.lane(lane));
            hit[lane] = if decided.mask { 1.0 } else { 0.0 };
            (t[lane], u[lane], v[lane]) = (decided.t, decided.u, decided.v);
            lanes &= lanes - 1;
        }
        let [hit, t, u, v] = [hit, t, u, v].map(f32x8::new);
        Self { hit, t, u, v }
    }

    /// Puts these lanes into `hit`.
    #[inline(always)]
    fn blend(self, lanes: Mask8, hit: Hit<f32x8>) -> Hit<f32x8> {
        Hit::<f32x8>::candidate(
            lanes & gt8(self.hit, f32x8::ZERO) | !lanes & hit.mask,
            lanes.select(self.t, hit.t),
            lanes.select(self.u, hit.u),
            lanes.select(self.v, hit.v),
        )
    }
}

/// Whether three points are exactly in line.
fn is_degenerate(vertices: [DVec3; 3]) -> bool {
    DVec3::AXES.into_iter().all(|axis| volume(&vertices, axis, &[axis]) == 0.0)
}
