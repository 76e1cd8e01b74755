//! `quadric/naive`: the textbook's formula for the roots of `a·t² + b·t + c`.

use glam::Vec3;
use wide::f32x8;

use crate::geom::lanes::{Lanes, Vec3x8, eq8, ge8, le8, lt8, max, max8, min, min8};
use crate::geom::{Hit, Quadric, Ray};
use crate::kernels::aabb::{InverseDirection, Slabs, pad, pad8, slab_interval, slab_interval8};
use crate::kernels::{Id, Info, Intersect, Kernel, Operations};

/// One prepared quadric or eight: its coefficients and its box, 64 bytes a quadric.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Naive<P: Lanes> {
    squares: P::Vec3,
    products: P::Vec3,
    linear: P::Vec3,
    constant: P,
    clip: Slabs<P>,
}

impl Intersect<f32> for Naive<f32> {
    type Setup = InverseDirection<f32>;

    #[inline(always)]
    fn setup(ray: &Ray<f32>) -> Self::Setup {
        InverseDirection::<f32>::of(ray)
    }

    #[inline(always)]
    fn closest_hit(&self, ray: &Ray<f32>, setup: &Self::Setup) -> Hit<f32> {
        let (o, d) = (ray.origin, ray.dir);
        let mixed = |a: Vec3, b: Vec3| Vec3::new(a.y * b.z + b.y * a.z, a.z * b.x + b.z * a.x, a.x * b.y + b.x * a.y);
        let a = self.squares.dot(d * d) + self.products.dot(Vec3::new(d.y * d.z, d.z * d.x, d.x * d.y));
        let b = 2.0 * self.squares.dot(o * d) + self.products.dot(mixed(o, d)) + self.linear.dot(d);
        let c = self.squares.dot(o * o)
            + self.products.dot(Vec3::new(o.y * o.z, o.z * o.x, o.x * o.y))
            + self.linear.dot(o)
            + self.constant;
        let root = (b * b - 4.0 * a * c).sqrt();
        let (t0, t1) = if a == 0.0 { (-c / b, -c / b) } else { ((-b - root) / (2.0 * a), (-b + root) / (2.0 * a)) };
        let (near, far) = (min(t0, t1), max(t0, t1));
        let (entry, exit) = slab_interval(&self.clip, o, setup);
        let exit = pad(exit, setup.t_max);
        let within = |t: f32| (t >= entry) & (t <= exit) & (t.abs() < f32::INFINITY);
        let t = if within(near) { near } else { far };
        Hit::<f32>::new(within(t), t, 0.0, 0.0)
    }
}

impl<P: Lanes> Intersect<f32x8> for Naive<P> {
    type Setup = InverseDirection<f32x8>;

    #[inline(always)]
    fn setup(ray: &Ray<f32x8>) -> Self::Setup {
        InverseDirection::<f32x8>::of(ray)
    }

    #[inline(always)]
    fn closest_hit(&self, ray: &Ray<f32x8>, setup: &Self::Setup) -> Hit<f32x8> {
        let (o, d) = (ray.origin, ray.dir);
        let (squares, products) = (P::widen_vec3(self.squares), P::widen_vec3(self.products));
        let (linear, constant) = (P::widen_vec3(self.linear), self.constant.widen());
        let product = |a: Vec3x8, b: Vec3x8| Vec3x8 { x: a.x * b.x, y: a.y * b.y, z: a.z * b.z };
        let mixed = |a: Vec3x8, b: Vec3x8| Vec3x8 {
            x: a.y * b.z + b.y * a.z,
            y: a.z * b.x + b.z * a.x,
            z: a.x * b.y + b.x * a.y,
        };
        let pairs = |a: Vec3x8| Vec3x8 { x: a.y * a.z, y: a.z * a.x, z: a.x * a.y };
        let two = f32x8::splat(2.0);
        let a = squares.dot(product(d, d)) + products.dot(pairs(d));
        let b = two * squares.dot(product(o, d)) + products.dot(mixed(o, d)) + linear.dot(d);
        let c = squares.dot(product(o, o)) + products.dot(pairs(o)) + linear.dot(o) + constant;
        let root = (b * b - f32x8::splat(4.0) * a * c).sqrt();
        let flat = eq8(a, f32x8::ZERO);
        let (t0, t1) = (flat.select(-c / b, (-b - root) / (two * a)), flat.select(-c / b, (-b + root) / (two * a)));
        let (near, far) = (min8(t0, t1), max8(t0, t1));
        let (entry, exit) = slab_interval8(&self.clip.widen(), o, setup);
        let exit = pad8(exit, setup.t_max);
        let within = |t: f32x8| ge8(t, entry) & le8(t, exit) & lt8(t.abs(), f32x8::splat(f32::INFINITY));
        let t = within(near).select(near, far);
        Hit::<f32x8>::new(within(t), t, f32x8::ZERO, f32x8::ZERO)
    }
}

impl Kernel for Naive<f32> {
    type Shape = Quadric;
    type Packet = Naive<f32x8>;
    const INFO: Info = Info {
        id: Id::of("quadric/naive"),
        idea: "the textbook's formula, (-b ± √(b² - 4ac)) / 2a",
        source: "A. Glassner (ed.), \"An Introduction to Ray Tracing\", 1989, chapter 2",
        operations: Operations { mul: 40, add: 30, div: 2 },
        claims: &[],
    };

    fn prepare(shape: &Quadric) -> Self {
        Self {
            squares: shape.squares,
            products: shape.products,
            linear: shape.linear,
            constant: shape.constant,
            clip: shape.bounds().into(),
        }
    }

    fn gather(primitives: &[Self; 8]) -> Self::Packet {
        Naive {
            squares: Vec3x8::from_lanes(primitives.map(|one| one.squares)),
            products: Vec3x8::from_lanes(primitives.map(|one| one.products)),
            linear: Vec3x8::from_lanes(primitives.map(|one| one.linear)),
            constant: f32x8::new(primitives.map(|one| one.constant)),
            clip: Slabs::gather(primitives.map(|one| one.clip)),
        }
    }
}
