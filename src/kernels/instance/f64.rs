//! `instance/f64`: the ray transformed in double precision.
//!
//! **Source:** none. It is `instance/subtract_first` without its rounding.
//!
//! **Idea:** `f32` in and out, `f64` in between: the best that transforming the ray can do for an inner kernel that
//! takes `f32`.
//!
//! **Fails:** where an `f32` ray in the object's space cannot express the ray of the world. Each of its six
//! coordinates is still rounded once, by an ulp of its distance from the object's origin.
//!
//! **Edges, claims:** those of the inner kernel, for the transformed ray.
//!
//! **Degenerate input:** a transform that is not finite or has no inverse misses every ray. No inverse of `f32`
//! numbers overflows in `f64`. A transformed direction may overflow in `f32`, and then misses, as at a scale of
//! 1e-39.
//!
//! **Operations:** 18 multiplications and 15 additions, all in `f64`, and for every instance the inner kernel's setup
//! and test. 96 bytes prepared.

use glam::{Affine3, DVec3};
use wide::{f32x8, f64x8};

use super::{RayTransform, SingularTransform, TransformMethod, inverse_linear};
use crate::geom::Ray;
use crate::geom::lanes::{Vec3x8, double8, to_f32x8};
use crate::kernels::{DoubleOperations, Id, Info, Operations};

/// One transform (`V` a [`DVec3`]), or eight (`V` a `[f64x8; 3]`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SubtractFirstF64<V> {
    /// Columns of L⁻¹.
    inverse: [V; 3],
    /// T.
    translation: V,
}

impl RayTransform<f32> for SubtractFirstF64<DVec3> {
    #[inline(always)]
    fn ray_to_object(&self, ray: &Ray<f32>) -> Ray<f32> {
        let Self { inverse: [x, y, z], translation } = *self;
        let apply = |v: DVec3| ((x * v.x + y * v.y) + z * v.z).as_vec3();

        // Subtract the translation, then transform origin and direction. The interval stays.
        let origin = ray.origin.as_dvec3() - translation;
        Ray { origin: apply(origin), dir: apply(ray.dir.as_dvec3()), t_min: ray.t_min, t_max: ray.t_max }
    }
}

impl RayTransform<f32x8> for SubtractFirstF64<[f64x8; 3]> {
    #[inline(always)]
    fn ray_to_object(&self, ray: &Ray<f32x8>) -> Ray<f32x8> {
        let Self { inverse: [x, y, z], translation: [tx, ty, tz] } = *self;
        let row = |axis: usize, v: [f64x8; 3]| to_f32x8((x[axis] * v[0] + y[axis] * v[1]) + z[axis] * v[2]);
        let apply = |v: [f64x8; 3]| Vec3x8 { x: row(0, v), y: row(1, v), z: row(2, v) };

        // Subtract the translation, then transform origin and direction. The interval stays.
        let [ox, oy, oz] = double8(ray.origin);
        let origin = [ox - tx, oy - ty, oz - tz];
        Ray { origin: apply(origin), dir: apply(double8(ray.dir)), t_min: ray.t_min, t_max: ray.t_max }
    }
}

/// Eight rays by one transform, which is widened first.
impl RayTransform<f32x8> for SubtractFirstF64<DVec3> {
    #[inline(always)]
    fn ray_to_object(&self, ray: &Ray<f32x8>) -> Ray<f32x8> {
        let widen = |v: DVec3| [f64x8::splat(v.x), f64x8::splat(v.y), f64x8::splat(v.z)];
        let [x, y, z] = self.inverse;
        let wide = SubtractFirstF64 { inverse: [widen(x), widen(y), widen(z)], translation: widen(self.translation) };
        wide.ray_to_object(ray)
    }
}

impl TransformMethod for SubtractFirstF64<DVec3> {
    type Packet = SubtractFirstF64<[f64x8; 3]>;
    const INFO: Info = Info {
        id: Id::of("instance/f64"),
        idea: "transform the ray by the inverse, subtracting the translation first, in f64",
        source: "what a transformed f32 ray can be at best",
        operations: Operations {
            mul: 18,
            add: 15,
            reads: 12,
            double: DoubleOperations { mul: 18, add: 15, ..DoubleOperations::NONE },
            ..Operations::NONE
        },
        setup: Operations::NONE,
        claims: &[],
    };
    const NOWHERE: Self = Self { inverse: [DVec3::ZERO; 3], translation: DVec3::ZERO };

    fn prepare(object_to_world: &Affine3) -> Result<Self, SingularTransform> {
        let inverse = inverse_linear(object_to_world)?;
        Ok(Self {
            inverse: [inverse.x_axis, inverse.y_axis, inverse.z_axis],
            translation: object_to_world.translation.as_dvec3(),
        })
    }

    fn gather(transforms: [Self; 8]) -> Self::Packet {
        let gather = |vectors: [DVec3; 8]| [0, 1, 2].map(|axis| f64x8::new(vectors.map(|vector| vector[axis])));
        SubtractFirstF64 {
            inverse: [0, 1, 2].map(|column| gather(transforms.map(|one| one.inverse[column]))),
            translation: gather(transforms.map(|one| one.translation)),
        }
    }

    #[inline(always)]
    fn lane(packet: &Self::Packet, lane: usize) -> Self {
        let vector = |[x, y, z]: &[f64x8; 3]| DVec3::new(x.as_array()[lane], y.as_array()[lane], z.as_array()[lane]);
        Self { inverse: packet.inverse.each_ref().map(vector), translation: vector(&packet.translation) }
    }
}
