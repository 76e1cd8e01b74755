//! `instance/baked`: no instance at all, but the vertices put into the world beforehand.
//!
//! **Source:** what every scene without instancing does.
//!
//! **Idea:** each vertex is transformed in `f64` and rounded to `f32` once; the kernel then tests the ray as it is. Only
//! triangles can be baked: a box that is turned or sheared is no box any more, nor is the one that a quadric is clipped
//! by.
//!
//! **Fails:** where the world's coordinates are too coarse for the object: far from the origin each vertex is moved by up
//! to half an ulp of its distance; and under a transform of great condition number, which makes a sliver of a good triangle
//! and a grazing ray of a steep one. And it is no instancing: every instance has its own copy.
//!
//! **Edges, claims:** the inner kernel's. Triangles that share vertices and the transform still share them when baked, so
//! that a watertight kernel stays watertight; but what is called a hit is so of the rounded triangle.
//!
//! **Degenerate input:** a transform without inverse, or not finite, makes a triangle that misses every ray, as with the
//! other methods; so does a vertex beyond the range of `f32`.
//!
//! **Operations:** the inner kernel's, and its bytes.

use glam::Vec3;

use super::inverse_linear;
use crate::geom::{Hit, Lanes, Placed, Ray, Triangle};
use crate::kernels::{Id, Info, Intersect, Kernel};

/// A primitive prepared in the world, or eight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Baked<T>(T);

/// Both twins are the inner kernel's.
impl<L: Lanes, T: Intersect<L>> Intersect<L> for Baked<T> {
    type Setup = T::Setup;

    #[inline(always)]
    fn setup(ray: &Ray<L>) -> Self::Setup {
        T::setup(ray)
    }

    #[inline(always)]
    fn candidate(&self, ray: &Ray<L>, setup: &Self::Setup) -> Hit<L> {
        self.0.candidate(ray, setup)
    }

    #[inline(always)]
    fn any_hit(&self, ray: &Ray<L>, setup: &Self::Setup) -> L::Mask {
        self.0.any_hit(ray, setup)
    }
}

impl<K: Kernel<Shape = Triangle>> Kernel for Baked<K> {
    type Shape = Placed<Triangle>;
    type Packet = Baked<K::Packet>;
    const INFO: Info = Info {
        id: Id { method: "instance/baked", inner: Some(K::INFO.id.method) },
        idea: "no instance: vertices transformed beforehand, in f64",
        source: "common practice",
        operations: K::INFO.operations,
        setup: K::INFO.setup,
        claims: &[],
    };

    fn prepare(&Placed { shape, object_to_world }: &Self::Shape) -> Self {
        let (linear, translation) = (object_to_world.matrix3.as_dmat3(), object_to_world.translation.as_dvec3());
        let [v0, v1, v2] = shape.vertices().map(|vertex| (linear * vertex.as_dvec3() + translation).as_vec3());
        let can_be_hit = inverse_linear(&object_to_world).is_ok() && v0.is_finite() && v1.is_finite() && v2.is_finite();
        Self(K::prepare(&Triangle { v0: if can_be_hit { v0 } else { Vec3::NAN }, v1, v2 }))
    }

    fn gather(primitives: &[Self; 8]) -> Self::Packet {
        Baked(K::gather(&primitives.map(|primitive| primitive.0)))
    }

    #[inline(always)]
    fn lane(packet: &Self::Packet, lane: usize) -> Self {
        Self(K::lane(&packet.0, lane))
    }
}
