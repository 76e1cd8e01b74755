//! Instances: a primitive, or a whole scene, placed in the world by an affine transform.
//!
//! The transform `x ↦ L x + T` takes the object to the world. Instead of the shape, the ray is transformed, by the
//! inverse: `origin' = L⁻¹(origin - T)`, `dir' = L⁻¹ dir`. The direction is not normalised again, so `t` means the
//! same in both spaces, and the interval stays. The methods, one file each, differ in where they round. Only
//! `instance/baked` transforms the shape; the others are compared with it.

pub mod baked;
pub mod f64;
pub mod inverse;
pub mod subtract_first;

#[doc(inline)]
pub use baked::Baked;
#[doc(inline)]
pub use f64::SubtractFirstF64;
#[doc(inline)]
pub use inverse::Inverse;
#[doc(inline)]
pub use subtract_first::SubtractFirst;

use glam::{Affine3, DMat3, Mat3, Vec3};
use wide::f32x8;

use crate::geom::{Candidate, Lanes, Placed, Ray, Vec3x8, is_singular};
use crate::kernels::{Id, Info, Intersect, Kernel};

/// An instance of anything that can be intersected, with `W` one transform. Or eight instances of eight prepared
/// primitives, with `W` eight transforms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance<T, W = SubtractFirst<f32>> {
    /// The object in its own coordinates.
    object: T,
    /// Transforms rays into the object's space.
    world_to_object: W,
}

prepared! {
    /// The columns of one 3×3 matrix, or of eight.
    struct Columns<P: Lanes> {
        x: P::Vec3,
        y: P::Vec3,
        z: P::Vec3,
    }
}

impl From<Mat3> for Columns<f32> {
    fn from(matrix: Mat3) -> Self {
        Self { x: matrix.x_axis, y: matrix.y_axis, z: matrix.z_axis }
    }
}

impl Columns<f32> {
    const ZERO: Self = Self { x: Vec3::ZERO, y: Vec3::ZERO, z: Vec3::ZERO };

    /// Matrix times vector.
    #[inline(always)]
    fn apply(&self, v: Vec3) -> Vec3 {
        (self.x * v.x + self.y * v.y) + self.z * v.z
    }
}

impl Columns<f32x8> {
    /// [`Columns::<f32>::apply`] in eight lanes.
    #[inline(always)]
    fn apply(&self, v: Vec3x8) -> Vec3x8 {
        (self.x * v.x + self.y * v.y) + self.z * v.z
    }
}

/// The twins of a method. One ray by one transform (`L = f32`), or eight rays by one transform or by eight
/// (`L = f32x8`).
pub trait RayTransform<L: Lanes>: Copy {
    /// The ray in the object's space.
    fn ray_to_object(&self, ray: &Ray<L>) -> Ray<L>;
}

/// A method of transforming rays. Its scalar form implements this trait.
pub trait TransformMethod:
    RayTransform<f32> + RayTransform<f32x8> + core::fmt::Debug + PartialEq + Send + Sync + 'static
{
    /// Eight transforms.
    type Packet: RayTransform<f32x8> + Copy + core::fmt::Debug + Send + Sync;
    /// Name, idea, source, and the operations in addition to those of the inner kernel.
    const INFO: Info;
    /// A transform that gives every ray the direction zero, so every ray misses.
    const NOWHERE: Self;

    /// Computes what does not depend on the ray.
    ///
    /// # Errors
    /// If the transform has no inverse, or none in the method's precision.
    fn prepare(object_to_world: &Affine3) -> Result<Self, SingularTransform>;

    /// Lane `i` becomes `transforms[i]`.
    fn gather(transforms: [Self; 8]) -> Self::Packet;

    /// The transform in a lane.
    ///
    /// # Panics
    /// If `lane >= 8`.
    fn lane(packet: &Self::Packet, lane: usize) -> Self;
}

/// A transform without inverse. It is singular or not finite, or its inverse exceeds the range of the numbers that
/// would store it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SingularTransform {
    /// The transform that was refused.
    pub transform: Affine3,
}

impl core::fmt::Display for SingularTransform {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let (columns, translation) = (self.transform.matrix3.to_cols_array_2d(), self.transform.translation.to_array());
        write!(f, "transform has no inverse: columns {columns:?}, translation {translation:?}")
    }
}

impl core::error::Error for SingularTransform {}

/// L⁻¹.
///
/// # Errors
/// If the transform has no inverse.
fn inverse_linear(transform: &Affine3) -> Result<DMat3, SingularTransform> {
    let linear = transform.matrix3.as_dmat3();
    if transform.is_finite() && !is_singular(&linear) {
        Ok(linear.inverse())
    } else {
        Err(SingularTransform { transform: *transform })
    }
}

impl<T, W> Instance<T, W> {
    /// The object in its own coordinates.
    pub fn object(&self) -> &T {
        &self.object
    }

    /// The ray in the object's space.
    #[inline(always)]
    pub fn ray_to_object(&self, ray: &Ray<f32>) -> Ray<f32>
    where
        W: RayTransform<f32>,
    {
        self.world_to_object.ray_to_object(ray)
    }

    /// [`Instance::ray_to_object`] in eight lanes.
    #[inline(always)]
    pub fn rays_to_object(&self, rays: &Ray<f32x8>) -> Ray<f32x8>
    where
        W: RayTransform<f32x8>,
    {
        self.world_to_object.ray_to_object(rays)
    }
}

impl<L: Lanes, T: Intersect<L>, W: RayTransform<L>> Intersect<L> for Instance<T, W> {
    type Setup = ();

    #[inline(always)]
    fn setup(_: &Ray<L>) {}

    #[inline(always)]
    fn candidate(&self, ray: &Ray<L>, (): &()) -> Candidate<L> {
        // Transform the ray into the object's space.
        let ray = self.world_to_object.ray_to_object(ray);

        // Test the object there.
        self.object.candidate(&ray, &T::setup(&ray))
    }

    #[inline(always)]
    fn any_hit(&self, ray: &Ray<L>, (): &()) -> L::Mask {
        // Transform the ray into the object's space.
        let ray = self.world_to_object.ray_to_object(ray);

        // Test the object there.
        self.object.any_hit(&ray, &T::setup(&ray))
    }
}

impl<K: Kernel, W: TransformMethod> Kernel for Instance<K, W> {
    type Shape = Placed<K::Shape>;
    type Packet = Instance<K::Packet, W::Packet>;
    const INFO: Info = K::INFO.inside(W::INFO);

    fn prepare(shape: &Self::Shape) -> Self {
        let world_to_object = W::prepare(&shape.object_to_world).unwrap_or(W::NOWHERE);
        Self { object: K::prepare(&shape.shape), world_to_object }
    }

    fn gather(primitives: &[Self; 8]) -> Self::Packet {
        Instance {
            object: K::gather(&primitives.map(|instance| instance.object)),
            world_to_object: W::gather(primitives.map(|instance| instance.world_to_object)),
        }
    }

    #[inline(always)]
    fn lane(packet: &Self::Packet, lane: usize) -> Self {
        Self { object: K::lane(&packet.object, lane), world_to_object: W::lane(&packet.world_to_object, lane) }
    }
}

impl Info {
    /// What an instance of this kernel says about itself. It claims nothing: two instances that share an edge in the
    /// world see two differently rounded rays.
    const fn inside(self, method: Self) -> Self {
        Self {
            id: Id { method: method.id.method, inner: Some(self.id.method) },
            // Each instance sees another ray. So each test includes the inner kernel's setup.
            operations: method.operations.and(self.setup).and(self.operations),
            claims: &[],
            ..method
        }
    }
}
