//! `instance/baked`: not an instance. The vertices are transformed into the world beforehand.
//!
//! **Source:** what every scene without instancing does.
//!
//! **Idea:** each vertex is transformed in `f64` and rounded to `f32` once. The kernel then tests the unchanged ray.
//! Only triangles can be baked: a box that is rotated or sheared is no longer axis-aligned. The same holds for the
//! clip box of a quadric.
//!
//! **Fails:** where the world's coordinates are too coarse for the object. Far from the origin each vertex moves by
//! up to half an ulp of its distance. A transform with a large condition number makes a sliver of a good triangle and
//! a grazing ray of a steep one. And nothing is shared: every instance is a copy.
//!
//! **Edges, claims:** those of the inner kernel, for the rounded triangle. Triangles that share vertices and the
//! transform still share them when baked, so a watertight kernel stays watertight.
//!
//! **Degenerate input:** a transform that is not finite or has no inverse makes a triangle that misses every ray, as
//! with the other methods. So does a vertex beyond the range of `f32`.
//!
//! **Operations:** those of the inner kernel, and its bytes.

use glam::{DVec3, Vec3};

use super::inverse_linear;
use crate::geom::{Candidate, Lanes, Placed, Ray, Triangle};
use crate::kernels::{Id, Info, Intersect, Kernel};

/// A primitive prepared in the world, or eight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Baked<T>(T);

/// Both twins are those of the inner kernel.
impl<L: Lanes, T: Intersect<L>> Intersect<L> for Baked<T> {
    type Setup = T::Setup;

    #[inline(always)]
    fn setup(ray: &Ray<L>) -> Self::Setup {
        T::setup(ray)
    }

    #[inline(always)]
    fn candidate(&self, ray: &Ray<L>, setup: &Self::Setup) -> Candidate<L> {
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
        // Rounding may give an area to a triangle that has none.
        let [a, b, c] = shape.vertices().map(Vec3::as_dvec3);
        let has_area = (b - a).cross(c - a) != DVec3::ZERO;
        let is_finite = v0.is_finite() && v1.is_finite() && v2.is_finite();
        let can_be_hit = has_area && is_finite && inverse_linear(&object_to_world).is_ok();
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
