//! `quadric/naive`: the textbook's formula.
//!
//! **Source:** A. S. Glassner (ed.), "An Introduction to Ray Tracing", 1989, chapter 2 (E. Haines).
//!
//! **Idea:** put the ray into the surface's equation. The result is `a·t² + b·t + c = 0`, with the roots
//! `(-b ± √(b² - 4ac)) / 2a`.
//!
//! **Differs from the source:** no early return, because a packet cannot do that. The box limits the roots.
//!
//! **Edges:** the surface belongs to its box, up to rounding. For a tangent ray, rounding decides whether the
//! discriminant is negative. Its square root, which is part of `t`, is wrong by the square root of an ulp.
//!
//! **Fails:** `b²` and `4ac` grow with the square of the distance from the origin of coordinates. Their difference
//! does not. Unit spheres a thousand radii away are hit or missed by chance. The root of the smaller magnitude
//! cancels wherever `4ac` is small beside `b²`. That happens near the surface, and where `a` is small, as for a
//! paraboloid and a ray nearly along its axis. Products overflow and underflow where the discriminant does. It is of
//! fourth degree in the sizes involved and of second degree in the coefficients.
//!
//! **Degenerate input:** where `a` is exactly zero, the equation is linear. Where `b` is zero too, the ray runs in
//! the surface or nowhere near it. Its root is infinite or NaN, and it misses.
//!
//! **Operations:** 60 multiplications, 34 additions, 3 divisions, 1 square root, 23 minima, maxima and comparisons.
//! The box needs 10 of the multiplications and 6 of the additions. Setup: 3 divisions. 64 bytes prepared.

use glam::Vec3;
use wide::f32x8;

use super::ClipInterval;
use crate::geom::lanes::{Lanes, Vec3x8, eq8, sqrt, sqrt8};
use crate::geom::{Candidate, Quadric, Ray};
use crate::kernels::aabb::{InverseDirection, Slabs};
use crate::kernels::{Id, Info, Intersect, Kernel, Operations};

prepared! {
    /// Quadrics for the textbook's formula: the unchanged coefficients, and the box.
    pub struct Naive<P: Lanes> {
        squares: P::Vec3,
        products: P::Vec3,
        linear: P::Vec3,
        constant: P,
        clip: Slabs<P>,
    }
}

impl Kernel for Naive<f32> {
    type Shape = Quadric;
    type Packet = Naive<f32x8>;
    const INFO: Info = Info {
        id: Id::of("quadric/naive"),
        idea: "the textbook's formula, (-b ± √(b² - 4ac)) / 2a",
        source: "Glassner (ed.), \"An Introduction to Ray Tracing\", 1989, chapter 2",
        operations: Operations { mul: 60, add: 34, compare: 23, div: 4, reads: 16, ..Operations::NONE },
        setup: InverseDirection::OPERATIONS,
        claims: &[],
    };

    fn prepare(shape: &Quadric) -> Self {
        let Quadric { squares, products, linear, constant, .. } = *shape;
        Self { squares, products, linear, constant, clip: shape.bounds().into() }
    }

    prepared!(gather, lane);
}

/// The products yz, zx and xy.
#[inline(always)]
fn pairs(a: Vec3) -> Vec3 {
    Vec3::new(a.y * a.z, a.z * a.x, a.x * a.y)
}

/// [`pairs`] in eight lanes.
#[inline(always)]
fn pairs8(a: Vec3x8) -> Vec3x8 {
    Vec3x8 { x: a.y * a.z, y: a.z * a.x, z: a.x * a.y }
}

/// The part of [`pairs`] of `a + t·b` that is linear in `t`.
#[inline(always)]
fn mixed_pairs(a: Vec3, b: Vec3) -> Vec3 {
    Vec3::new(a.y * b.z + b.y * a.z, a.z * b.x + b.z * a.x, a.x * b.y + b.x * a.y)
}

/// [`mixed_pairs`] in eight lanes.
#[inline(always)]
fn mixed_pairs8(a: Vec3x8, b: Vec3x8) -> Vec3x8 {
    Vec3x8 { x: a.y * b.z + b.y * a.z, y: a.z * b.x + b.z * a.x, z: a.x * b.y + b.x * a.y }
}

/// The product component by component, in eight lanes.
#[inline(always)]
fn product8(a: Vec3x8, b: Vec3x8) -> Vec3x8 {
    Vec3x8 { x: a.x * b.x, y: a.y * b.y, z: a.z * b.z }
}

impl Intersect<f32> for Naive<f32> {
    type Setup = InverseDirection<f32>;

    #[inline(always)]
    fn setup(ray: &Ray<f32>) -> Self::Setup {
        InverseDirection::<f32>::of(ray)
    }

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32>, setup: &Self::Setup) -> Candidate<f32> {
        let Self { squares, products, linear, constant, clip } = *self;

        // Put the ray into the surface's equation: a·t² + b·t + c = 0.
        let (o, d) = (ray.origin, ray.dir);
        let a = squares.dot(d * d) + products.dot(pairs(d));
        let b = 2.0 * squares.dot(o * d) + products.dot(mixed_pairs(o, d)) + linear.dot(d);
        let c = squares.dot(o * o) + products.dot(pairs(o)) + linear.dot(o) + constant;

        // Solve it. Where a is zero, it is linear.
        let root = sqrt(b * b - 4.0 * a * c);
        let roots = if a == 0.0 { [-c / b; 2] } else { [(-b - root) / (2.0 * a), (-b + root) / (2.0 * a)] };

        // Take the nearer root that lies in the box and in the interval.
        ClipInterval::<f32>::of(&clip, o, setup).hit(roots)
    }
}

impl<P: Lanes> Intersect<f32x8> for Naive<P> {
    type Setup = InverseDirection<f32x8>;

    #[inline(always)]
    fn setup(ray: &Ray<f32x8>) -> Self::Setup {
        InverseDirection::<f32x8>::of(ray)
    }

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32x8>, setup: &Self::Setup) -> Candidate<f32x8> {
        let Naive { squares, products, linear, constant, clip } = self.widen();

        // Put the ray into the surface's equation: a·t² + b·t + c = 0.
        let (o, d) = (ray.origin, ray.dir);
        let two = f32x8::splat(2.0);
        let a = squares.dot(product8(d, d)) + products.dot(pairs8(d));
        let b = two * squares.dot(product8(o, d)) + products.dot(mixed_pairs8(o, d)) + linear.dot(d);
        let c = squares.dot(product8(o, o)) + products.dot(pairs8(o)) + linear.dot(o) + constant;

        // Solve it. Where a is zero, it is linear.
        let root = sqrt8(b * b - f32x8::splat(4.0) * a * c);
        let (flat, linear_root) = (eq8(a, f32x8::ZERO), -c / b);
        let roots = [(-b - root) / (two * a), (-b + root) / (two * a)].map(|root| flat.select(linear_root, root));

        // Take the nearer root that lies in the box and in the interval.
        ClipInterval::<f32x8>::of(&clip, o, setup).hit(roots)
    }
}
