//! `instance/subtract_first`: the inversely transformed ray, with the translation taken off before the linear part is
//! applied.
//!
//! **Source:** P. Shirley, S. Marschner et al., "Fundamentals of Computer Graphics", chapter on instancing; the order is
//! the one that subtract-first triangle tests use.
//!
//! **Idea:** `L⁻¹(origin - T)` costs as much as the 3×4 inverse matrix applied to the origin, but cancels before
//! rounding: an object far from the world's origin loses nothing. The inverse is computed in `f64` and rounded once.
//!
//! **Edges, claims:** the inner kernel's, for the transformed ray. Two instances that share an edge in the world see two
//! differently rounded rays, so nothing is promised between them.
//!
//! **Degenerate input:** a transform without inverse, or not finite, is refused by [`Instance::new`]; prepared through
//! [`Kernel::prepare`] it misses every ray, as a degenerate primitive does.
//!
//! **Operations:** 18 multiplications and 15 additions on top of the inner kernel's test and, anew for every instance,
//! its setup.

use glam::{Affine3, Vec3};
use wide::f32x8;

use crate::geom::lanes::{Lanes, Mask8, Vec3x8};
use crate::geom::{Hit, Placed, Ray};
use crate::kernels::{Id, Info, Intersect, Kernel, Operations};

/// One instance (`M = f32`) of anything that can be intersected, or eight instances of eight prepared primitives
/// (`M = f32x8`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance<T, M: Lanes = f32> {
    /// What is put into the world, in its own coordinates.
    object: T,
    /// Columns of L⁻¹.
    inverse: [M::Vec3; 3],
    /// T.
    translation: M::Vec3,
    /// +1, or -1 for a transform that mirrors.
    orientation: M,
}

/// The transform has no inverse in `f32`: its linear part is singular, or not finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SingularTransform {
    /// The transform that was refused.
    pub transform: Affine3,
}

impl core::fmt::Display for SingularTransform {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Affine3 { matrix3, translation } = self.transform;
        write!(f, "transform has no inverse: columns {matrix3}, translation {translation}")
    }
}

impl core::error::Error for SingularTransform {}

impl<T> Instance<T> {
    /// Puts `object` into the world.
    ///
    /// # Errors
    /// If the transform has no finite inverse.
    pub fn new(object: T, object_to_world: Affine3) -> Result<Self, SingularTransform> {
        let refused = SingularTransform { transform: object_to_world };
        let linear = object_to_world.matrix3.as_dmat3();
        let inverse = linear.inverse().as_mat3();
        // An infinite entry of L gives an inverse with a zero column, which is finite but no inverse.
        if !object_to_world.is_finite() || !inverse.is_finite() || inverse.as_dmat3().determinant() == 0.0 {
            return Err(refused);
        }
        Ok(Self {
            object,
            inverse: [inverse.x_axis, inverse.y_axis, inverse.z_axis],
            translation: object_to_world.translation,
            orientation: if linear.determinant() < 0.0 { -1.0 } else { 1.0 },
        })
    }

    /// What is put into the world, in its own coordinates.
    pub fn object(&self) -> &T {
        &self.object
    }

    /// A surface normal in the world, of unit length, from one in the object: by the inverse transpose, times the sign
    /// of the determinant, since a mirror turns counter-clockwise into clockwise. Zero stays zero.
    #[inline]
    pub fn normal_to_world(&self, normal: Vec3) -> Vec3 {
        let [x, y, z] = self.inverse;
        (Vec3::new(x.dot(normal), y.dot(normal), z.dot(normal)) * self.orientation).normalize_or_zero()
    }

    /// The ray as the object sees it.
    #[inline(always)]
    pub fn ray_to_object(&self, ray: &Ray<f32>) -> Ray<f32> {
        let [x, y, z] = self.inverse;
        let apply = |v: Vec3| (x * v.x + y * v.y) + z * v.z;
        Ray { origin: apply(ray.origin - self.translation), dir: apply(ray.dir), t_min: ray.t_min, t_max: ray.t_max }
    }
}

impl<T, M: Lanes> Instance<T, M> {
    /// [`Instance::<T, f32>::ray_to_object`] in eight lanes.
    #[inline(always)]
    pub fn rays_to_object(&self, ray: &Ray<f32x8>) -> Ray<f32x8> {
        let [x, y, z] = self.inverse.map(M::widen_vec3);
        let translation = M::widen_vec3(self.translation);
        let apply = |v: Vec3x8| (x * v.x + y * v.y) + z * v.z;
        Ray { origin: apply(ray.origin - translation), dir: apply(ray.dir), t_min: ray.t_min, t_max: ray.t_max }
    }
}

impl<T: Intersect<f32>> Intersect<f32> for Instance<T> {
    type Setup = ();

    #[inline(always)]
    fn setup(_: &Ray<f32>) {}

    #[inline(always)]
    fn closest_hit(&self, ray: &Ray<f32>, (): &()) -> Hit<f32> {
        let ray = self.ray_to_object(ray);
        self.object.closest_hit(&ray, &T::setup(&ray))
    }

    #[inline(always)]
    fn any_hit(&self, ray: &Ray<f32>, (): &()) -> bool {
        let ray = self.ray_to_object(ray);
        self.object.any_hit(&ray, &T::setup(&ray))
    }
}

impl<T: Intersect<f32x8>, M: Lanes> Intersect<f32x8> for Instance<T, M> {
    type Setup = ();

    #[inline(always)]
    fn setup(_: &Ray<f32x8>) {}

    #[inline(always)]
    fn closest_hit(&self, ray: &Ray<f32x8>, (): &()) -> Hit<f32x8> {
        let ray = self.rays_to_object(ray);
        self.object.closest_hit(&ray, &T::setup(&ray))
    }

    #[inline(always)]
    fn any_hit(&self, ray: &Ray<f32x8>, (): &()) -> Mask8 {
        let ray = self.rays_to_object(ray);
        self.object.any_hit(&ray, &T::setup(&ray))
    }
}

impl<K: Kernel> Kernel for Instance<K> {
    type Shape = Placed<K::Shape>;
    type Packet = Instance<K::Packet, f32x8>;
    const INFO: Info = Info {
        id: Id { method: "instance/subtract_first", inner: Some(K::INFO.id.method) },
        idea: "transform the ray by the inverse, subtracting the translation first",
        source: "Shirley, Marschner, \"Fundamentals of Computer Graphics\"",
        operations: Operations {
            mul: K::INFO.operations.mul + 18,
            add: K::INFO.operations.add + 15,
            div: K::INFO.operations.div,
        },
        claims: &[],
    };

    fn prepare(shape: &Self::Shape) -> Self {
        let object = K::prepare(&shape.shape);
        Self::new(object, shape.object_to_world).unwrap_or(Self {
            object,
            inverse: [Vec3::ZERO; 3],
            translation: Vec3::ZERO,
            orientation: 1.0,
        })
    }

    fn gather(primitives: &[Self; 8]) -> Self::Packet {
        Instance {
            object: K::gather(&primitives.map(|instance| instance.object)),
            inverse: [0, 1, 2].map(|column| Vec3x8::from_lanes(primitives.map(|instance| instance.inverse[column]))),
            translation: Vec3x8::from_lanes(primitives.map(|instance| instance.translation)),
            orientation: f32x8::new(primitives.map(|instance| instance.orientation)),
        }
    }
}
