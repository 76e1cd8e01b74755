//! A prepared instance: its transform, its box in the world, and the geometry that it shows.

use std::fmt::Debug;

use wide::{f32x8, u32x8};

use crate::geom::{Aabb, Candidate, Hit, Mask8, Quadric, Ray};
use crate::kernels::Kernel;
use crate::kernels::instance::Instance;
use crate::tracer::leaf::MeshTree;
use crate::tracer::walk::filter::Filter;

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
    /// A quadric, or faces.
    Quadrics(&'a [Box<dyn AnyQuadric>]),
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

/// The closest hit that counts of several quadrics. Its primitive is the number of the quadric.
#[inline(always)]
pub(super) fn closest_accepted_hit<F: Filter>(
    quadrics: &[Box<dyn AnyQuadric>],
    ray: &Ray<f32>,
    filter: &F,
) -> Hit<f32> {
    (0..).zip(quadrics).fold(Hit::MISS, |best, (number, quadric)| {
        let hit = accepted_hit(&**quadric, number, ray, filter);
        if hit.is_closer_than(&best) { hit } else { best }
    })
}

/// The closest hit that counts of one quadric.
#[inline(always)]
fn accepted_hit<F: Filter>(quadric: &dyn AnyQuadric, number: u32, ray: &Ray<f32>, filter: &F) -> Hit<f32> {
    let hit = |ray: &Ray<f32>| {
        let hit = quadric.closest_hit(ray);
        if hit.mask { Hit { primitive: number, ..hit } } else { hit }
    };
    let first = hit(ray);
    if F::ALL || !first.mask || filter.accepts(ray, &first) {
        return first;
    }
    // A line meets a quadric twice at most.
    let behind = Ray { t_min: first.t.next_up(), ..*ray };
    let second = hit(&behind);
    if second.mask && filter.accepts(&behind, &second) { second } else { Hit::MISS }
}

/// [`closest_accepted_hit`] in eight lanes, where every hit counts.
#[inline(always)]
pub(super) fn closest_hit8(quadrics: &[Box<dyn AnyQuadric>], ray: &Ray<f32x8>) -> Hit<f32x8> {
    let mut best = Hit::<f32x8>::miss();
    for (number, quadric) in (0..).zip(quadrics) {
        best.keep_closer(&Candidate::from(quadric.closest_hit8(ray)).of_primitives(u32x8::splat(number)));
    }
    best
}
