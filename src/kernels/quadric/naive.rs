//! `quadric/naive`: the textbook's formula.
//!
//! **Source:** A. S. Glassner (ed.), "An Introduction to Ray Tracing", 1989, chapter 2 (E. Haines).
//!
//! **Idea:** the ray put into the surface's equation gives `a·t² + b·t + c = 0`, whose roots are `(-b ± √(b² - 4ac)) / 2a`.
//!
//! **Differs from the source:** nothing is returned early, since a packet cannot be, and the box limits the roots.
//!
//! **Edges:** the surface belongs to its box, but for rounding. At a tangent ray, whether the discriminant is negative
//! is up to rounding, and its root, which `t` has a share of, is wrong by the root of an ulp.
//!
//! **Fails:** `b²` and `4ac` grow with the square of the distance from the coordinates' origin, and what is left of
//! their difference does not: unit spheres a thousand radii away are hit or missed by chance. The root of the smaller
//! magnitude cancels wherever `4ac` is small beside `b²`: near the surface, and where `a` is, as for a paraboloid and a
//! ray nearly along its axis. Products over- and underflow where the discriminant does, which is of the fourth degree
//! in the sizes involved and of the second in the coefficients.
//!
//! **Degenerate input:** where `a` is exactly zero the equation is linear. Where `b` is zero too, the ray runs within the
//! surface or nowhere near it, and misses: its root is infinite or NaN.
//!
//! **Operations:** 60 multiplications, 34 additions, 3 divisions, 1 square root, 23 minima, maxima and comparisons, of
//! which 10 and 6 are the box's; setup 3 divisions. 64 bytes prepared.

use glam::Vec3;
use wide::f32x8;

use super::ClipInterval;
use crate::geom::lanes::{Lanes, Vec3x8, eq8, sqrt, sqrt8};
use crate::geom::{Hit, Quadric, Ray};
use crate::kernels::aabb::{InverseDirection, Slabs};
use crate::kernels::{Id, Info, Intersect, Kernel, Operations};

prepared! {
    /// Quadrics for the textbook's formula: the coefficients as they are, and the box.
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

/// yz, zx and xy.
#[inline(always)]
fn pairs(a: Vec3) -> Vec3 {
    Vec3::new(a.y * a.z, a.z * a.x, a.x * a.y)
}

/// [`pairs`] in eight lanes.
#[inline(always)]
fn pairs8(a: Vec3x8) -> Vec3x8 {
    Vec3x8 { x: a.y * a.z, y: a.z * a.x, z: a.x * a.y }
}

/// What is linear in `t` of [`pairs`] of `a + t·b`.
#[inline(always)]
fn mixed_pairs(a: Vec3, b: Vec3) -> Vec3 {
    Vec3::new(a.y * b.z + b.y * a.z, a.z * b.x + b.z * a.x, a.x * b.y + b.x * a.y)
}

/// [`mixed_pairs`] in eight lanes.
#[inline(always)]
fn mixed_pairs8(a: Vec3x8, b: Vec3x8) -> Vec3x8 {
    Vec3x8 { x: a.y * b.z + b.y * a.z, y: a.z * b.x + b.z * a.x, z: a.x * b.y + b.x * a.y }
}

/// Component by component.
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
    fn candidate(&self, ray: &Ray<f32>, setup: &Self::Setup) -> Hit<f32> {
        let Self { squares, products, linear, constant, clip } = *self;

        // Put the ray into the surface's equation: a·t² + b·t + c = 0.
        let (o, d) = (ray.origin, ray.dir);
        let a = squares.dot(d * d) + products.dot(pairs(d));
        let b = 2.0 * squares.dot(o * d) + products.dot(mixed_pairs(o, d)) + linear.dot(d);
        let c = squares.dot(o * o) + products.dot(pairs(o)) + linear.dot(o) + constant;

        // Solve it. Where a is zero, the equation is linear.
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
    fn candidate(&self, ray: &Ray<f32x8>, setup: &Self::Setup) -> Hit<f32x8> {
        let Naive { squares, products, linear, constant, clip } = self.widen();

        // Put the ray into the surface's equation: a·t² + b·t + c = 0.
        let (o, d) = (ray.origin, ray.dir);
        let two = f32x8::splat(2.0);
        let a = squares.dot(product8(d, d)) + products.dot(pairs8(d));
        let b = two * squares.dot(product8(o, d)) + products.dot(mixed_pairs8(o, d)) + linear.dot(d);
        let c = squares.dot(product8(o, o)) + products.dot(pairs8(o)) + linear.dot(o) + constant;

        // Solve it. Where a is zero, the equation is linear.
        let root = sqrt8(b * b - f32x8::splat(4.0) * a * c);
        let (flat, linear_root) = (eq8(a, f32x8::ZERO), -c / b);
        let roots = [(-b - root) / (two * a), (-b + root) / (two * a)].map(|root| flat.select(linear_root, root));

        // Take the nearer root that lies in the box and in the interval.
        ClipInterval::<f32x8>::of(&clip, o, setup).hit(roots)
    }
}
