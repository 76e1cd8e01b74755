//! `instance/subtract_first`: the ray transformed by the inverse. The translation is subtracted before the linear
//! part is applied.
//!
//! **Source:** P. Shirley, S. Marschner et al., "Fundamentals of Computer Graphics", chapter on instancing. The order
//! is that of triangle tests that subtract first.
//!
//! **Idea:** `L⁻¹(origin - T)` costs as much as the 3×4 inverse matrix times the origin, but it cancels before it
//! rounds. An object far from the world's origin loses nothing. The inverse is computed in `f64` and rounded once.
//!
//! **Fails:** where L is badly conditioned. The rounding of L⁻¹, and of its product with the origin, is then larger
//! than the object in the direction in which it is flattest in the world.
//!
//! **Edges, claims:** those of the inner kernel, for the transformed ray. Two instances that share an edge in the
//! world see two differently rounded rays, so nothing is claimed between them.
//!
//! **Degenerate input:** [`Instance::new`] refuses a transform that is not finite or has no inverse. Prepared through
//! [`Kernel::prepare`](crate::kernels::Kernel::prepare), such a transform misses every ray, as a degenerate primitive
//! does.
//!
//! **Operations:** 18 multiplications and 15 additions, and for every instance the inner kernel's setup and test. 84
//! bytes prepared. A test reads 48 of them. The others, L unchanged, are for normals.

use glam::{Affine3, Vec3};
use wide::f32x8;

use super::{Columns, Instance, RayTransform, SingularTransform, TransformMethod, inverse_linear, is_singular};
use crate::geom::{Lanes, Ray};
use crate::kernels::{Id, Info, Operations};

prepared! {
    /// One transform, or eight.
    pub struct SubtractFirst<P: Lanes> {
        /// L⁻¹.
        inverse: Columns<P>,
        /// T.
        translation: P::Vec3,
        /// L.
        linear: Columns<P>,
    }
}

impl<T> Instance<T> {
    /// Places `object` in the world.
    ///
    /// # Errors
    /// If the transform has no finite inverse.
    pub fn new(object: T, object_to_world: Affine3) -> Result<Self, SingularTransform> {
        Ok(Self { object, world_to_object: SubtractFirst::prepare(&object_to_world)? })
    }

    /// The unit normal in the world, from a normal of any length in the object's space: `cof(L)·n`, the inverse
    /// transpose times the determinant. The sign of the determinant is part of it, because a mirror turns
    /// counter-clockwise into clockwise. Zero stays zero, and a NaN gives zero.
    ///
    /// Computed in `f64` from the unchanged L. Except for the rounding of the result to `f32`, the angle to the exact
    /// normal is below 2⁻⁴⁹ times the condition number of L.
    #[inline]
    pub fn normal_to_world(&self, normal: Vec3) -> Vec3 {
        let Columns { x, y, z } = self.world_to_object.linear;
        let [x, y, z] = [x, y, z].map(Vec3::as_dvec3);
        let n = normal.as_dvec3();
        (y.cross(z) * n.x + z.cross(x) * n.y + x.cross(y) * n.z).normalize_or_zero().as_vec3()
    }
}

impl RayTransform<f32> for SubtractFirst<f32> {
    #[inline(always)]
    fn ray_to_object(&self, ray: &Ray<f32>) -> Ray<f32> {
        let Self { inverse, translation, .. } = self;

        // Subtract the translation, then transform origin and direction. The interval stays.
        let origin = inverse.apply(ray.origin - translation);
        Ray { origin, dir: inverse.apply(ray.dir), t_min: ray.t_min, t_max: ray.t_max }
    }
}

impl<P: Lanes> RayTransform<f32x8> for SubtractFirst<P> {
    #[inline(always)]
    fn ray_to_object(&self, ray: &Ray<f32x8>) -> Ray<f32x8> {
        let SubtractFirst { inverse, translation, .. } = self.widen();

        // Subtract the translation, then transform origin and direction. The interval stays.
        let origin = inverse.apply(ray.origin - translation);
        Ray { origin, dir: inverse.apply(ray.dir), t_min: ray.t_min, t_max: ray.t_max }
    }
}

impl TransformMethod for SubtractFirst<f32> {
    type Packet = SubtractFirst<f32x8>;
    const INFO: Info = Info {
        id: Id::of("instance/subtract_first"),
        idea: "transform the ray by the inverse, subtracting the translation first",
        source: "Shirley, Marschner, \"Fundamentals of Computer Graphics\"",
        operations: Operations { mul: 18, add: 15, reads: 12, ..Operations::NONE },
        setup: Operations::NONE,
        claims: &[],
    };
    const NOWHERE: Self = Self { inverse: Columns::ZERO, translation: Vec3::ZERO, linear: Columns::ZERO };

    fn prepare(object_to_world: &Affine3) -> Result<Self, SingularTransform> {
        let inverse = inverse_linear(object_to_world)?.as_mat3();
        // The inverse may have overflowed, or lost an axis by underflow.
        if !inverse.is_finite() || is_singular(&inverse.as_dmat3()) {
            return Err(SingularTransform { transform: *object_to_world });
        }
        let (linear, translation) = (object_to_world.matrix3.into(), object_to_world.translation);
        Ok(Self { inverse: inverse.into(), translation, linear })
    }

    fn gather(transforms: [Self; 8]) -> Self::Packet {
        Self::Packet::gather(&transforms)
    }

    #[inline(always)]
    fn lane(packet: &Self::Packet, lane: usize) -> Self {
        packet.lane(lane)
    }
}
