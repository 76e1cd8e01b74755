//! A prepared instance: its transform, its box in the world, and the geometry that it shows.

use std::fmt::Debug;

use wide::f32x8;

use crate::geom::{Aabb, Hit, Mask8, Quadric, Ray};
use crate::kernels::Kernel;
use crate::kernels::instance::Instance;
use crate::tracer::leaf::MeshTree;

/// A prepared instance.
#[derive(Clone, Copy, Debug)]
pub(super) struct PreparedInstance {
    /// `None` for the identity. A product with 1 can still change a ray: it turns -0 + 0 into 0.
    pub(super) transform: Option<Instance<()>>,
    /// Box in the world.
    pub(super) bounds: Aabb,
    /// Number of the geometry in the world.
    pub(super) geometry: u32,
}

impl PreparedInstance {
    /// The ray in the object's coordinates.
    #[inline(always)]
    pub(super) fn ray_to_object(&self, ray: &Ray<f32>) -> Ray<f32> {
        self.transform.map_or(*ray, |transform| transform.ray_to_object(ray))
    }

    /// The rays of these lanes in the object's coordinates. The other lanes become inactive.
    #[inline(always)]
    pub(super) fn rays_to_object(&self, ray: &Ray<f32x8>, lanes: Mask8) -> Ray<f32x8> {
        let Ray { origin, dir, t_min, t_max } = self.transform.map_or(*ray, |transform| transform.rays_to_object(ray));
        Ray {
            origin,
            dir,
            t_min: lanes.select(t_min, f32x8::splat(f32::INFINITY)),
            t_max: lanes.select(t_max, f32x8::splat(f32::NEG_INFINITY)),
        }
    }
}

/// A geometry, prepared for its kernel.
pub(super) enum Object<'a, K: Kernel> {
    Mesh(&'a MeshTree<K>),
    Quadric(&'a dyn AnyQuadric),
}

/// A quadric, prepared for a kernel that is chosen at run time. The dynamic call costs once per instance, not per node.
pub(super) trait AnyQuadric: Debug + Send + Sync {
    fn closest_hit(&self, ray: &Ray<f32>) -> Hit<f32>;
    fn closest_hit8(&self, ray: &Ray<f32x8>) -> Hit<f32x8>;
}

impl<Q: Kernel<Shape = Quadric>> AnyQuadric for Q {
    fn closest_hit(&self, ray: &Ray<f32>) -> Hit<f32> {
        self.hit(ray)
    }

    fn closest_hit8(&self, ray: &Ray<f32x8>) -> Hit<f32x8> {
        self.hit(ray)
    }
}
