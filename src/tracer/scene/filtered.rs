//! A scene of which some rays see only a part: groups of instances, and hits that a filter accepts.

use wide::f32x8;

use super::traverse::{Visible, with_scratch};
use super::two_level::Scene;
use crate::geom::{Candidate, Mask8, Ray, Triangle};
use crate::kernels::{Intersect, Kernel};
use crate::tracer::walk::filter::{Everything, Filter};

/// A scene in which only some instances and hits count; see [`Scene::with_mask`] and [`Scene::with_filter`].
///
/// It can be traced like the scene. The hits are those of a scene without all that does not count, and they are the
/// same for every mode. With a filter, rays through instances are traced one at a time.
#[derive(Clone, Copy, Debug)]
pub struct Filtered<'a, K: Kernel, F = Everything> {
    pub(super) scene: &'a Scene<K>,
    pub(super) visible: Visible<F>,
}

impl<K: Kernel<Shape = Triangle>> Scene<K> {
    /// The scene for rays that see only the instances whose [mask](crate::tracer::Placement::mask) has one of these
    /// bits.
    ///
    /// ```
    /// use glam::{Affine3, Vec3};
    /// use raylanes::geom::{Quadric, Ray};
    /// use raylanes::kernels::{Intersect, triangle::ExactHalfOpen};
    /// use raylanes::tracer::{Geometry, Placement, Scene, World};
    ///
    /// // A glass ball, in group 2, around a small one, in group 1.
    /// let balls = [2.0, 1.0].map(|radius| Geometry::Quadric(Quadric::sphere(radius)));
    /// let place = |number, mask| Placement::new(number, Affine3::IDENTITY).with_mask(mask);
    /// let world = World::new(balls.into(), vec![place(0, 0b10), place(1, 0b01)])?;
    /// let scene = Scene::<ExactHalfOpen<f32>>::new(world);
    ///
    /// let ray = Ray::new(Vec3::new(0.0, 0.0, 5.0), Vec3::NEG_Z);
    /// assert_eq!(scene.hit(&ray).t, 3.0);
    /// assert_eq!(scene.with_mask(0b01).hit(&ray).t, 4.0);
    /// # Ok::<(), raylanes::tracer::WorldError>(())
    /// ```
    pub fn with_mask(&self, mask: u32) -> Filtered<'_, K> {
        Filtered { scene: self, visible: Visible { mask, filter: Everything } }
    }

    /// The scene for rays for which only the hits count that the filter accepts: for transparent parts of a surface,
    /// for culling by side, for leaving out a primitive.
    ///
    /// ```
    /// use glam::Vec3;
    /// use raylanes::geom::{Hit, Ray, Triangle};
    /// use raylanes::kernels::{Intersect, triangle::ExactHalfOpen};
    /// use raylanes::tracer::{Mesh, Mode, Scene, occluded, trace};
    ///
    /// let leaf = |z| Triangle { v0: Vec3::new(0.0, 0.0, z), v1: Vec3::new(1.0, 0.0, z), v2: Vec3::new(0.0, 1.0, z) };
    /// let scene = Scene::<ExactHalfOpen<f32>>::from(Mesh::from_triangles(&[leaf(0.0), leaf(1.0)])?);
    /// let rays = [0.2, 0.8].map(|x| Ray::new(Vec3::new(x, 0.1, 5.0), Vec3::NEG_Z));
    ///
    /// // The upper leaf has a hole where u < 1/2.
    /// let alpha = |_: &Ray<f32>, hit: &Hit<f32>| hit.primitive == 0 || hit.u >= 0.5;
    /// let hits = trace(&scene.with_filter(alpha), &rays, Mode::Auto);
    /// assert_eq!((hits[0].t, hits[1].t), (5.0, 4.0));
    ///
    /// // Only front faces: the leaves show their front to a ray that comes from above.
    /// let front = |ray: &Ray<f32>, hit: &Hit<f32>| scene.is_front(ray, hit);
    /// let upwards = Ray::new(Vec3::new(0.2, 0.1, -5.0), Vec3::Z);
    /// assert_eq!(occluded(&scene.with_filter(front), &[rays[0], upwards], Mode::Auto), [true, false]);
    /// # Ok::<(), raylanes::tracer::MeshError>(())
    /// ```
    pub fn with_filter<F: Filter>(&self, filter: F) -> Filtered<'_, K, F> {
        self.with_mask(u32::MAX).with_filter(filter)
    }
}

impl<'a, K: Kernel<Shape = Triangle>, F> Filtered<'a, K, F> {
    /// The scene that is filtered.
    pub fn scene(&self) -> &'a Scene<K> {
        self.scene
    }

    pub(crate) fn visible(&self) -> &Visible<F> {
        &self.visible
    }

    /// With this filter in place of the present one; see [`Scene::with_filter`].
    pub fn with_filter<G: Filter>(self, filter: G) -> Filtered<'a, K, G> {
        let Self { scene, visible: Visible { mask, .. } } = self;
        Filtered { scene, visible: Visible { mask, filter } }
    }

    /// With this mask in place of the present one; see [`Scene::with_mask`].
    #[must_use]
    pub fn with_mask(self, mask: u32) -> Self {
        let Self { scene, visible: Visible { filter, .. } } = self;
        Self { scene, visible: Visible { mask, filter } }
    }
}

impl<K: Kernel<Shape = Triangle>, F: Filter> Intersect<f32> for Filtered<'_, K, F> {
    type Setup = ();

    fn setup(_: &Ray<f32>) {}

    fn candidate(&self, ray: &Ray<f32>, (): &()) -> Candidate<f32> {
        with_scratch(|scratch| self.scene.trace_single::<false>(ray, &self.visible, scratch, &mut ())).into()
    }

    fn any_hit(&self, ray: &Ray<f32>, (): &()) -> bool {
        with_scratch(|scratch| self.scene.trace_single::<true>(ray, &self.visible, scratch, &mut ())).mask
    }
}

impl<K: Kernel<Shape = Triangle>, F: Filter> Intersect<f32x8> for Filtered<'_, K, F> {
    type Setup = ();

    fn setup(_: &Ray<f32x8>) {}

    fn candidate(&self, ray: &Ray<f32x8>, (): &()) -> Candidate<f32x8> {
        with_scratch(|scratch| self.scene.trace_packet::<false>(ray, &self.visible, scratch, &mut ())).into()
    }

    fn any_hit(&self, ray: &Ray<f32x8>, (): &()) -> Mask8 {
        with_scratch(|scratch| self.scene.trace_packet::<true>(ray, &self.visible, scratch, &mut ())).mask
    }
}
