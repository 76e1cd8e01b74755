//! All hits of a ray: in order, their number, and which points are inside closed shapes.
//!
//! A tree holds each triangle once. So a search in which no hit ends the search finds each hit once, for every tree,
//! also where several triangles are hit at the same `t`. There is no need to start again behind each hit, which loses
//! hits at equal `t` or finds them twice.

use std::cell::RefCell;
use std::cmp::Ordering;

use glam::Vec3;

use super::filtered::Filtered;
use super::traverse::{Visible, with_scratch};
use super::two_level::Scene;
use crate::geom::{Hit, Ray, Triangle};
use crate::kernels::{Claim, Kernel};
use crate::tracer::walk::filter::Filter;

/// The direction in which crossings are counted. It lies in no plane that is common in models, so few rays touch a
/// quadric.
const OUTWARDS: Vec3 = Vec3::new(0.537_319_6, 0.339_077_1, 0.772_198_5);

impl<K: Kernel<Shape = Triangle>> Scene<K> {
    /// All hits of the ray, by `t`. The first one is the closest hit. At equal `t`, the lower instance number comes
    /// first, and within an instance the lower primitive number. Only if the box of an instance clamps several of its
    /// hits to one `t`, they keep the order of their `t` in the object.
    ///
    /// Each triangle is hit at most once. A quadric is hit once or twice; where the ray touches it, once.
    ///
    /// With a kernel that claims [even crossings](Claim::EvenCrossings), a line crosses a closed mesh an even number of
    /// times, also through edges, vertices and silhouettes. Other kernels lose or double such crossings.
    ///
    /// ```
    /// use glam::Vec3;
    /// use raylanes::geom::Ray;
    /// use raylanes::kernels::triangle::ExactHalfOpen;
    /// use raylanes::tracer::{Scene, SceneSource};
    ///
    /// let scene = Scene::<ExactHalfOpen<f32>>::new(SceneSource::parse("sphere:1e3")?.load()?.world);
    /// let middle = scene.bounds().center();
    /// // Through the middle, exactly along an axis: where the mesh has vertices.
    /// let ray = Ray::new(middle + Vec3::Z * 1e3, Vec3::NEG_Z);
    /// let hits = scene.all_hits(&ray);
    /// assert_eq!((hits.len(), scene.count_hits(&ray)), (2, 2));
    /// assert!(hits[0].t < 1e3 && hits[1].t > 1e3);
    /// assert!(scene.contains(middle) && !scene.contains(ray.origin));
    /// # Ok::<(), raylanes::tracer::Error>(())
    /// ```
    pub fn all_hits(&self, ray: &Ray<f32>) -> Vec<Hit<f32>> {
        self.with_mask(u32::MAX).all_hits(ray)
    }

    /// The number of [all hits](Scene::all_hits).
    pub fn count_hits(&self, ray: &Ray<f32>) -> usize {
        self.with_mask(u32::MAX).count_hits(ray)
    }

    /// Whether the point is inside an instance: in each of them, crossings are counted from the point outwards. Every
    /// geometry must be closed: a mesh in which each edge has its opposite ([`Mesh::is_closed`]), or a sphere or an
    /// ellipsoid. A point on the surface may be inside or outside. A point that is not finite is outside.
    ///
    /// The kernel must claim [even crossings](Claim::EvenCrossings) and [no hit behind](Claim::NoHitBehind). With
    /// another one, this does not compile.
    ///
    /// [`Mesh::is_closed`]: crate::tracer::Mesh::is_closed
    pub fn contains(&self, point: Vec3) -> bool {
        self.with_mask(u32::MAX).contains(point)
    }
}

impl<K: Kernel<Shape = Triangle>, F: Filter> Filtered<'_, K, F> {
    /// [`Scene::all_hits`], of those that count.
    pub fn all_hits(&self, ray: &Ray<f32>) -> Vec<Hit<f32>> {
        let mut hits = Vec::new();
        self.for_each_hit(ray, |hit, t_in_object| hits.push((*hit, t_in_object)));
        // No hit holds a NaN.
        let order = |(hit, t_in_object): &(Hit<f32>, f32)| (hit.t, hit.instance, *t_in_object, hit.primitive);
        hits.sort_unstable_by(|a, b| order(a).partial_cmp(&order(b)).unwrap_or(Ordering::Equal));
        hits.into_iter().map(|(hit, _)| hit).collect()
    }

    /// [`Scene::count_hits`], of those that count.
    pub fn count_hits(&self, ray: &Ray<f32>) -> usize {
        let mut count = 0;
        self.for_each_hit(ray, |_, _| count += 1);
        count
    }

    /// [`Scene::contains`], by the instances and hits that count.
    pub fn contains(&self, point: Vec3) -> bool {
        const {
            assert!(
                K::INFO.claims_to(Claim::EvenCrossings) && K::INFO.claims_to(Claim::NoHitBehind),
                "the kernel must claim even crossings and no hit behind, such as ExactHalfOpen"
            );
        }
        let mut instances = Vec::new();
        self.for_each_hit(&Ray::new(point, OUTWARDS), |hit, _| instances.push(hit.instance));
        instances.sort_unstable();
        instances.chunk_by(|a, b| a == b).any(|crossings| crossings.len() % 2 == 1)
    }

    /// Calls `visit` with each hit that counts and its `t` in the object, in any order.
    fn for_each_hit(&self, ray: &Ray<f32>, visit: impl FnMut(&Hit<f32>, f32)) {
        let Visible { mask, filter } = &self.visible;
        let visible = Visible { mask: *mask, filter: Visitor { filter, visit: RefCell::new(visit) } };
        with_scratch(|scratch| self.scene.trace_single::<false>(ray, &visible, scratch, &mut ()));
    }
}

/// Shows every hit that counts to `visit`, and refuses it. So no hit ends the search.
struct Visitor<'a, F, V> {
    filter: &'a F,
    visit: RefCell<V>,
}

impl<F: Filter, V: FnMut(&Hit<f32>, f32)> Filter for Visitor<'_, F, V> {
    fn accepts(&self, ray: &Ray<f32>, hit: &Hit<f32>) -> bool {
        self.accepts_in_instance(ray, hit, hit.t)
    }

    fn accepts_in_instance(&self, ray: &Ray<f32>, hit: &Hit<f32>, t_in_object: f32) -> bool {
        if self.filter.accepts(ray, hit) {
            (self.visit.borrow_mut())(hit, t_in_object);
        }
        false
    }
}
