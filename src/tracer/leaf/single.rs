//! The single-ray walk in a leaf: one ray against up to eight triangles at once.

use wide::f32x8;

use super::mesh_tree::MeshTree;
use super::scratch::TraversalScratch;
use crate::geom::{Hit, Ray, Triangle};
use crate::kernels::{Intersect, Kernel};
use crate::tracer::bvh::Child;
use crate::tracer::walk::Counter;
use crate::tracer::walk::filter::{Filter, closest_accepted};
use crate::tracer::walk::rays::ANY_HIT;
use crate::tracer::walk::single::{self, SingleRay};
use crate::tracer::walk::stack::StackStorage;

impl<K: Kernel<Shape = Triangle>> MeshTree<K> {
    /// [`MeshTree::trace_scalar`] with one ray against eight boxes or triangles at a time.
    #[inline(never)]
    pub(crate) fn trace_single<const ANY: bool>(
        &self,
        ray: &Ray<f32>,
        farthest: f32,
        filter: &impl Filter,
        scratch: &mut TraversalScratch,
        counter: &mut impl Counter,
    ) -> Hit<f32> {
        let limit = Hit { t: farthest, ..Hit::MISS };
        self.trace_single_below::<ANY, _>(self.bvh.root, ray, limit, filter, &mut scratch.single, counter)
    }

    /// [`MeshTree::trace_single`] in the subtree of `root`, starting with `best`.
    #[inline(always)]
    pub(super) fn trace_single_below<const ANY: bool, F: Filter>(
        &self,
        root: Child,
        ray: &Ray<f32>,
        best: Hit<f32>,
        filter: &F,
        storage: &mut StackStorage<single::StackEntry>,
        counter: &mut impl Counter,
    ) -> Hit<f32> {
        let walk = SingleRay::of(ray, &self.bvh.extent);
        let ray = Ray::splat(ray);
        let setup = <K as Intersect<f32x8>>::setup(&ray);
        let search = SingleSearch::<K, F, ANY> { tree: self, walk, ray, setup, filter };
        self.bvh.walk_single::<ANY, _>(root, &search.walk, best, storage, counter, &mut &search)
    }
}

/// One ray, splatted, on its way through a mesh.
struct SingleSearch<'a, K: Kernel, F, const ANY: bool> {
    tree: &'a MeshTree<K>,
    walk: SingleRay,
    ray: Ray<f32x8>,
    setup: <K as Intersect<f32x8>>::Setup,
    filter: &'a F,
}

impl<K, F, T, const ANY: bool> single::Leaves<T> for &SingleSearch<'_, K, F, ANY>
where
    K: Kernel<Shape = Triangle>,
    F: Filter,
    T: Counter,
{
    #[inline(always)]
    fn test(&mut self, leaf: usize, best: &mut Hit<f32>, counter: &mut T) {
        let candidates = self.tree.test_all_triangles(leaf, &self.ray, &self.setup, counter, || self.walk.slabs);
        if !candidates.mask().any() {
            return;
        }
        if ANY && F::ALL {
            *best = ANY_HIT;
            return;
        }
        let closest = closest_accepted(&candidates, || self.ray.lane(0), self.filter);
        if ANY {
            if closest.mask {
                *best = ANY_HIT;
            }
        } else if closest.is_closer_than(best) {
            *best = closest;
        }
    }
}
