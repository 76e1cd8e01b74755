//! `instance/inverse`: the ray transformed by the inverse matrix that glam computes.
//!
//! **Source:** the textbook's way: P. Shirley, S. Marschner et al., "Fundamentals of Computer Graphics", chapter on
//! instancing. The inverse is [`glam::Affine3::inverse`].
//!
//! **Idea:** one 3×4 matrix transforms the origin, and its linear part the direction.
//!
//! **Fails:** far from the world's origin. The last column of the inverse is -L⁻¹T. Where T is large, it is rounded
//! by an ulp of T, and so is `L⁻¹ origin`. Their difference then cancels to the size of the object. It also fails
//! where L is badly conditioned, because L is inverted in `f32`. Where the determinant overflows or underflows `f32`
//! (a uniform scale of about 1e-13 or 1e13), there is no inverse at all.
//!
//! **Edges, claims:** those of the inner kernel, for the transformed ray.
//!
//! **Degenerate input:** a transform that is not finite or has no inverse misses every ray.
//!
//! **Operations:** 18 multiplications and 15 additions, and for every instance the inner kernel's setup and test. 48
//! bytes prepared.

use glam::{Affine3, Vec3};
use wide::f32x8;

use super::{Columns, RayTransform, SingularTransform, TransformMethod, is_singular};
use crate::geom::{Lanes, Ray};
use crate::kernels::{Id, Info, Operations};

prepared! {
    /// One transform, or eight: the inverse matrix.
    pub struct Inverse<P: Lanes> {
        linear: Columns<P>,
        translation: P::Vec3,
    }
}

impl RayTransform<f32> for Inverse<f32> {
    #[inline(always)]
    fn ray_to_object(&self, ray: &Ray<f32>) -> Ray<f32> {
        let Self { linear, translation } = self;

        // Transform origin and direction. The interval stays.
        let origin = linear.apply(ray.origin) + translation;
        Ray { origin, dir: linear.apply(ray.dir), t_min: ray.t_min, t_max: ray.t_max }
    }
}

impl<P: Lanes> RayTransform<f32x8> for Inverse<P> {
    #[inline(always)]
    fn ray_to_object(&self, ray: &Ray<f32x8>) -> Ray<f32x8> {
        let Inverse { linear, translation } = self.widen();

        // Transform origin and direction. The interval stays.
        let origin = linear.apply(ray.origin) + translation;
        Ray { origin, dir: linear.apply(ray.dir), t_min: ray.t_min, t_max: ray.t_max }
    }
}

impl TransformMethod for Inverse<f32> {
    type Packet = Inverse<f32x8>;
    const INFO: Info = Info {
        id: Id::of("instance/inverse"),
        idea: "transform the ray by the inverse matrix, computed in f32",
        source: "Shirley, Marschner, \"Fundamentals of Computer Graphics\"; glam's Affine3::inverse",
        operations: Operations { mul: 18, add: 15, reads: 12, ..Operations::NONE },
        setup: Operations::NONE,
        claims: &[],
    };
    const NOWHERE: Self = Self { linear: Columns::ZERO, translation: Vec3::ZERO };

    fn prepare(object_to_world: &Affine3) -> Result<Self, SingularTransform> {
        let Affine3 { matrix3: linear, translation } = object_to_world.inverse();
        let bad = !object_to_world.is_finite() || is_singular(&object_to_world.matrix3.as_dmat3());
        if bad || !linear.is_finite() || !translation.is_finite() || is_singular(&linear.as_dmat3()) {
            return Err(SingularTransform { transform: *object_to_world });
        }
        Ok(Self { linear: linear.into(), translation })
    }

    fn gather(transforms: [Self; 8]) -> Self::Packet {
        Self::Packet::gather(&transforms)
    }

    #[inline(always)]
    fn lane(packet: &Self::Packet, lane: usize) -> Self {
        packet.lane(lane)
    }
}
