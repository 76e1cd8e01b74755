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
//! **The bound.** Let `ε = 2⁻²⁴`, and `S` the length of the longer prepared edge. Edges and normal are divided by `S`.
//! So `|e| <= 1` and `|n| <= S`. Let `c = v0 - origin`, `a = (c × d)·e2`, `b = (c × d)·e1` and `D = n·d`. `^` marks
//! computed numbers. The ray is inside exactly if `a`, `b` and `D - a - b` have no other sign than `D`.
//!
//! 1. In `a`, a product of three factors is rounded at most 7 times: `c` once, `e2` once, and 5 times by `×` and `·`.
//!    The sizes of all products add up to at most `Σ|eᵢ|(|cⱼ||dₖ| + |cₖ||dⱼ|)`. With `x = |c₁d₁|`, `y = |c₂d₂|` and
//!    `z = |c₃d₃|`, the squares of the three brackets add up to `|c|²|d|² + (x + y + z)² - 2(x² + y² + z²)`. That is at
//!    most `4/3·|c|²|d|²`. So `|â - a| <= 8.09ε|c||d|`. `b` likewise.
//! 2. In `D`, a product is rounded 4 times: `n` once, and 3 times by `·`. So `|D̂ - D| <= 4εS|d|`.
//! 3. The third determinant has the errors of all three. In `|D̂| - (â + b̂)`, the sum is rounded too. Where the true
//!    sum is at most `|D|`, that is at most `1.01εS|d|`. All in all, less than `ε|d|(16.18|c| + 5.02S)`.
//! 4. So take `B = 16.25ε|d|(|c|₁ + S)`, where `|c|₁ >= |c|` is the sum of the components' sizes. What is left covers
//!    terms of second order and the roundings of `B`, below `10ε·B`. If the smallest determinant, with the sign of `D̂`
//!    taken away, is above `B`, all true ones are positive: the ray is inside. If it is below `-B`, the ray is outside.
//! 5. That includes a `D̂` of the wrong sign. Then `|D̂| <= 4εS|d|`, which is less than three times `B`, so no ray is
//!    taken to be inside. If the ray is inside, `|a|` and `|b|` add up to `|D| <= 4εS|d|`. So no determinant is below
//!    `-ε|d|(16.18|c| + 8S)`, and no ray is taken to be outside.
//!
//! **The distance.** `t = T/D` with `T = n·c`. By the same count, `T` is off by at most `5ε|n|∞|c|₁`, and `D` by at
//! most `4ε|n|∞|d|₁`. `|x|∞` is the largest component. At a hit, `|t||d|₁ <= |c|₁ + 2S`. So `t` is off by at most
//! `9ε|n|∞(|c|₁ + S)/|D̂|`, and by two roundings. At every angle, the point `origin + t·dir` is at most `9ε(|c|₁ + S)`
//! off the plane. Where this bound on the error of `t` is not below `|t|/16`, `t` is computed again in `f64`, and has
//! the right sign. That happens to rays that start on the triangle or run nearly in its plane.
//!
//! **Range:** `|origin|² + |d|²` to 2⁸⁰, vertices to 2⁴⁰, `S` from 2⁻³⁰ to 2³⁰. There no product overflows. In the
//! bound, `|d|` is at least 2⁻⁵⁰, so what underflow loses is below `2⁻⁴⁰` of it. Outside this range, the bound is
//! infinite. Such rays go to the later stages, which are right for all finite numbers.
//!
//! **Edges:** closed. A ray exactly through an edge or a vertex hits all triangles that it meets there.
//!
//! **Claims:** every decision is right, for every ray and every triangle. So meshes are watertight, at silhouettes too.
//! Of rays that leave a triangle, none hits it.
//!
//! **Degenerate input:** a triangle of zero area is found when it is prepared, exactly, and misses. Its numbers are
//! such that the bound is `-∞`: it never takes the branch. A ray that is not valid takes it, and misses.
//!
//! **Cost:** against `triangle/kensler_shirley`, 1.2 times the time scalar, 1.34 times in packets of rays, 1.35 times
//! in packets of triangles. In a tracer, 0.85 to 1.0 times that of `triangle/woop`, but up to 1.1 times for packets of
//! primary rays at a mesh that does not fit into the second-level cache.
//!
//! Tried, and not kept: edges computed from the vertices (56 bytes): packets 1.09 times as long; a tracer 0.92 to 0.98
//! times with a million triangles, 1.0 to 1.2 times with fewer. Edges and normal computed (44 bytes): 1.15 to 1.3
//! times. Edges stored for packets of triangles, and computed for packets of rays, which then read 60 bytes of 84: no
//! faster. A miss before the division where all lanes miss: packets of rays 1.7 times as long, a tracer the same.
//! `|origin| + |v0|` in place of `|c|`: packets 0.95 times, but far from the origin most rays are not sure.
//! `|t|` in place of `|c|`: 7 instructions of 92 less, but packets 1.08 times as long, because all wait for the
//! division.
//!
//! **Operations:** 23 multiplications, 19 additions, 1 division, 7 minima and comparisons. Setup: 7 multiplications, 5
//! additions, 1 square root, 2 comparisons. 80 bytes prepared.

use glam::{DVec3, Vec3};
use wide::f32x8;

use super::{Vertices, normal};
use crate::geom::lanes::{Lanes, Mask8, Vec3x8, ge8, gt8, le8, max, max8, min, min8, sqrt, sqrt8, t_in_range};
use crate::geom::{Candidate, Ray, Triangle};
use crate::kernels::aabb::Slabs;
use crate::kernels::volume::{plane_t, volume};
use crate::kernels::{Claim, Id, Info, Intersect, Kernel, Operations};

prepared! {
    /// Triangles for the exact test.
    pub struct Exact<P: Lanes> {
        vertices: Vertices<P>,
        /// `S`. Infinite for a triangle out of range. `-∞` for one that misses everything.
        size: P,
        /// How small `|T̂|/(|c|₁ + S)` may be, before `t` is computed again.
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
    fn candidate(&self, ray: &Ray<f32>, setup: &f32) -> Candidate<f32> {
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
    fn candidate(&self, ray: &Ray<f32x8>, setup: &f32x8) -> Candidate<f32x8> {
        self.test8::<Closed, Separate, false>(ray, *setup)
    }
}

/// Declares a kernel that prepares what [`Exact`] does, and differs in the rule for ties, in the arithmetic or in the
/// precision of `t`.
macro_rules! variant {
    ($(#[$attribute:meta])* $Name:ident, $rule:ty, $arithmetic:ty, $precise:literal, $info:expr) => {
        prepared! {
            $(#[$attribute])*
            pub struct $Name<P: Lanes> {
                exact: Exact<P>,
            }
        }

        impl Kernel for $Name<f32> {
            type Shape = Triangle;
            type Packet = $Name<f32x8>;
            const INFO: Info = $info;

            fn prepare(shape: &Triangle) -> Self {
                Self { exact: Exact::of(shape) }
            }

            prepared!(gather, lane);

            #[inline(always)]
            fn bounds(packet: &Self::Packet) -> Option<Slabs<f32x8>> {
                Some(packet.exact.bounds())
            }
        }

        impl Intersect<f32> for $Name<f32> {
            type Setup = f32;

            #[inline(always)]
            fn setup(ray: &Ray<f32>) -> f32 {
                setup(ray)
            }

            #[inline(always)]
            fn candidate(&self, ray: &Ray<f32>, setup: &f32) -> Candidate<f32> {
                self.exact.test::<$rule, $arithmetic, $precise>(ray, *setup)
            }
        }

        impl<P: Lanes> Intersect<f32x8> for $Name<P> {
            type Setup = f32x8;

            #[inline(always)]
            fn setup(ray: &Ray<f32x8>) -> f32x8 {
                setup8(ray)
            }

            #[inline(always)]
            fn candidate(&self, ray: &Ray<f32x8>, setup: &f32x8) -> Candidate<f32x8> {
                self.widen().exact.test8::<$rule, $arithmetic, $precise>(ray, *setup)
            }
        }
    };
}
pub(super) use variant;

/// Operations of [`Exact::test8`].
pub(super) const OPERATIONS: Operations =
    Operations { mul: 23, add: 19, compare: 7, div: 1, reads: 14, ..Operations::NONE };

/// Operations of [`setup`].
pub(super) const SETUP_OPERATIONS: Operations = Operations { mul: 7, add: 5, div: 1, compare: 2, ..Operations::NONE };

/// `ε`, half an ulp of 1.
const EPSILON: f32 = f32::EPSILON / 2.0;

/// Where the error of `t` may be larger than this, relative to `t`, its sign is not sure.
const T_ERROR: f64 = 1.0 / 16.0;
/// The same for kernels that compute `t` again where it is not precise.
const PRECISE_T_ERROR: f64 = 1.0 / 4096.0;
const PRECISE_T: f32 = (T_ERROR / PRECISE_T_ERROR) as f32;

/// The range in which no product overflows or loses digits that count.
const LONGEST_EDGE: f64 = (1 << 30) as f64;
const FARTHEST: f32 = (1u64 << 40) as f32;
const SHORTEST_RAY_SQUARED: f32 = 1.0 / ((1u128 << 100) as f32);

/// `16.25ε|d|`, the part of the bound that depends on the ray alone. Infinite for a ray out of range or not valid.
#[inline(always)]
pub(super) fn setup(ray: &Ray<f32>) -> f32 {
    let (d, o) = (ray.dir.dot(ray.dir), ray.origin.dot(ray.origin));
    let length = sqrt(max(d, SHORTEST_RAY_SQUARED));
    if d + o <= FARTHEST * FARTHEST { length * (16.25 * EPSILON) } else { f32::INFINITY }
}

/// [`setup`] in eight lanes.
#[inline(always)]
pub(super) fn setup8(ray: &Ray<f32x8>) -> f32x8 {
    let (d, o) = (ray.dir.dot(ray.dir), ray.origin.dot(ray.origin));
    let length = sqrt8(max8(d, f32x8::splat(SHORTEST_RAY_SQUARED)));
    let fits = le8(d + o, f32x8::splat(FARTHEST * FARTHEST));
    fits.select(length * f32x8::splat(16.25 * EPSILON), f32x8::splat(f32::INFINITY))
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
        let (e1, e2, n) = (v0 - v1, v2 - v0, normal(shape));
        let size = e1.length().max(e2.length());
        if !size.is_finite() || n == DVec3::ZERO && is_degenerate([v0, v1, v2]) {
            return Self::MISSES;
        }
        let far = [v0, v1, v2].map(|v| v.abs().max_element()).into_iter().fold(0.0, f64::max);
        let fits = (1.0 / LONGEST_EDGE..=LONGEST_EDGE).contains(&size) && far <= FARTHEST.into();
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
    pub(super) fn test<R: Rule, A: Arithmetic, const PRECISE: bool>(
        &self,
        ray: &Ray<f32>,
        setup: f32,
    ) -> Candidate<f32> {
        let Self { vertices: Vertices { v0, v1, v2 }, size, near, e1, e2, n } = *self;

        // Compute the shared cross product and the determinants.
        let c = v0 - ray.origin;
        let r = A::cross(c, ray.dir);
        let det = A::dot(n, ray.dir);
        let (a, b) = (A::dot(r, e2), A::dot(r, e1));

        // Compare the smallest determinant with its bound. Miss early, without a division.
        let sign = det.to_bits() & (1 << 31);
        let [a_by_sign, b_by_sign] = [a, b].map(|x| f32::from_bits(x.to_bits() ^ sign));
        let smallest = min(min(a_by_sign, b_by_sign), det.abs() - (a_by_sign + b_by_sign));
        let reach = c.x.abs() + c.y.abs() + c.z.abs() + size;
        let bound = setup * reach;
        if smallest < -bound {
            return Candidate::MISS;
        }

        // Compute the barycentrics and t.
        let inv_det = 1.0 / det;
        let (u, v) = (a * inv_det, b * inv_det);
        let height = A::dot(n, c);
        let t = height * inv_det;

        // Test the range of t. It is finite, because the ray is inside.
        let hit = (t >= ray.t_min) & (t <= ray.t_max);

        // Decide again what is not sure.
        let near = near * reach;
        let precise = !PRECISE | !hit | (height.abs() > near * PRECISE_T);
        if (smallest > bound) & (height.abs() > near) & precise {
            return Candidate::<f32>::new(hit, t, u, v);
        }
        decide::<R>([v0, v1, v2], ray)
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
    ) -> Candidate<f32x8> {
        let Exact { vertices: Vertices { v0, .. }, size, near, e1, e2, n } = self.widen();

        // Compute the shared cross product and the determinants.
        let c = v0 - ray.origin;
        let r = A::cross8(c, ray.dir);
        let det = A::dot8(n, ray.dir);
        let (a, b) = (A::dot8(r, e2), A::dot8(r, e1));

        // Compare the smallest determinant and the ray's height above the plane with their bounds.
        let sign = det & f32x8::splat(-0.0);
        let (a_by_sign, b_by_sign) = (a ^ sign, b ^ sign);
        let smallest = min8(min8(a_by_sign, b_by_sign), det.abs() - (a_by_sign + b_by_sign));
        let height = A::dot8(n, c);
        let reach = c.x.abs() + c.y.abs() + c.z.abs() + size;
        let inside = gt8(smallest, f32x8::ZERO);
        let near = near * reach;
        let mut sure = gt8(smallest.abs(), setup * reach) & (!inside | gt8(height.abs(), near));

        // Compute the barycentrics and t.
        let inv_det = f32x8::ONE / det;
        let (u, v) = (a * inv_det, b * inv_det);
        let t = height * inv_det;

        // Test the range of t. It is finite, because the ray is inside.
        let hit = inside & ge8(t, ray.t_min) & le8(t, ray.t_max);
        if PRECISE {
            sure = sure & (!hit | gt8(height.abs(), near * f32x8::splat(PRECISE_T)));
        }
        let hit = Candidate::<f32x8>::new(hit, t, u, v);

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
fn decide<R: Rule>(vertices: [Vec3; 3], ray: &Ray<f32>) -> Candidate<f32> {
    if !ray.is_valid() || ray.t_min > ray.t_max {
        return Candidate::MISS;
    }
    // Compute the weights: the volumes between the ray and the three edges.
    let corners = vertices.map(Vec3::as_dvec3);
    let ([a, b, c], o, d) = (corners, ray.origin.as_dvec3(), ray.dir.as_dvec3());
    let [u, v, w] = [[c, a], [a, b], [b, c]].map(|[p, q]| volume(&[o, p, q], d, &[d]));
    if !R::is_inside([u, v, w], corners, d) {
        return Candidate::MISS;
    }

    // Compute t from the plane, and test its range.
    let t = plane_t(vertices, ray.origin, ray.dir);
    let sum = u + v + w;
    Candidate::<f32>::new(t_in_range(ray.t_min, t, ray.t_max), t, (u / sum) as f32, (v / sum) as f32)
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
            hit[lane] = if decided.mask() { 1.0 } else { 0.0 };
            (t[lane], u[lane], v[lane]) = (decided.t(), decided.u(), decided.v());
            lanes &= lanes - 1;
        }
        let [hit, t, u, v] = [hit, t, u, v].map(f32x8::new);
        Self { hit, t, u, v }
    }

    /// Puts these lanes into `hit`.
    #[inline(always)]
    fn blend(self, lanes: Mask8, hit: Candidate<f32x8>) -> Candidate<f32x8> {
        Candidate::<f32x8>::new(
            lanes & gt8(self.hit, f32x8::ZERO) | !lanes & hit.mask(),
            lanes.select(self.t, hit.t()),
            lanes.select(self.u, hit.u()),
            lanes.select(self.v, hit.v()),
        )
    }
}

/// Whether three points are exactly in line.
fn is_degenerate(vertices: [DVec3; 3]) -> bool {
    DVec3::AXES.into_iter().all(|axis| volume(&vertices, axis, &[axis]) == 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A triangle and a ray, by their coordinates.
    type Case = [f32; 15];

    /// The worst of 900 million steps like those of [`climb`].
    const WORST: [Case; 2] = [
        [
            -0.31441125,
            0.2541399,
            0.05398681,
            0.6672314,
            0.8359475,
            -0.7427271,
            0.2793945,
            -0.93845046,
            -0.28928158,
            -0.31636563,
            -0.056258824,
            -0.968553,
            0.7757817,
            -0.05857762,
            0.4687984,
        ],
        [
            -0.44124052,
            0.057107028,
            -0.4214082,
            -0.31323537,
            0.5563104,
            0.9137567,
            0.7053816,
            -0.27717203,
            -0.60981286,
            0.5132778,
            0.29929426,
            -0.45139995,
            0.0630031,
            -0.4708413,
            0.03468953,
        ],
    ];

    /// How much of the bound the smallest determinant uses up, where it has the wrong sign. Above 1, a ray would be
    /// decided wrongly. Negative where the sign is right.
    fn used(case: &Case) -> f32 {
        let [v0, v1, v2, origin, dir] = [0, 3, 6, 9, 12].map(|i| Vec3::new(case[i], case[i + 1], case[i + 2]));
        let corners = [v0, v1, v2].map(Vec3::as_dvec3);
        let ([a, b, c], o, d) = (corners, origin.as_dvec3(), dir.as_dvec3());
        let weights = [[c, a], [a, b], [b, c]].map(|[p, q]| volume(&[o, p, q], d, &[d]));

        let Exact { size, e1, e2, n, .. } = Exact::of(&Triangle { v0, v1, v2 });
        let c = v0 - origin;
        let r = Separate::cross(c, dir);
        let (det, a, b) = (Separate::dot(n, dir), Separate::dot(r, e2), Separate::dot(r, e1));
        let sign = 1f32.copysign(det);
        let smallest = min(min(a * sign, b * sign), det.abs() - (a * sign + b * sign));
        let reach = c.x.abs() + c.y.abs() + c.z.abs() + size;
        let used = smallest / (setup(&Ray { origin, dir, t_min: 0.0, t_max: 1.0 }) * reach);
        if Closed::is_inside(weights, corners, d) { -used } else { used }
    }

    /// Changes digits of a case at random, and keeps what uses more of the bound.
    fn climb(case: &mut Case, steps: u32, random: &mut impl FnMut(u32) -> u32) -> f32 {
        let mut best = used(case);
        for _ in 0..steps {
            let mut other = *case;
            for _ in 0..=random(2) {
                let number = &mut other[random(15) as usize];
                let digits = number.to_bits();
                *number = f32::from_bits(match random(2) {
                    0 => digits ^ 1 << random(23),
                    _ => digits.wrapping_add(random(9)).wrapping_sub(4),
                });
            }
            let used = used(&other);
            if used >= best && used.is_finite() {
                (*case, best) = (other, used);
            }
        }
        best
    }

    #[test]
    fn a_search_for_wrong_decisions_stays_within_the_bound() {
        // Xorshift of G. Marsaglia, 2003.
        let mut state = 1u64;
        let mut random = |below: u32| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 32) as u32 % below
        };
        let most = WORST.iter().map(used).fold(0.0, f32::max);
        assert!((0.19..1.0).contains(&most), "{most}");

        for seed in 0..100 {
            // A ray at a point of an edge. The other cases start from the worst.
            let mut case = match WORST.get(seed) {
                Some(worst) => *worst,
                None => [(); 15].map(|()| random(1 << 24) as f32 / (1 << 23) as f32 - 1.0),
            };
            if seed >= WORST.len() {
                let along = random(1 << 24) as f32 / (1 << 24) as f32;
                for i in 0..3 {
                    case[12 + i] = case[i] + (case[3 + i] - case[i]) * along - case[9 + i];
                }
            }
            let most = climb(&mut case, 4_000, &mut random);
            assert!(most < 1.0, "{most} of the bound: {case:?}");
        }
    }
}
