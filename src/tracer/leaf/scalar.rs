//! The scalar walk in a leaf: each triangle in turn. Also brute force over all leaves.

use super::mesh_tree::{LeafTriangles, MeshTree, Setup};
use super::scratch::TraversalScratch;
use crate::geom::{Hit, Ray, Triangle};
use crate::kernels::Kernel;
use crate::kernels::box_rule::TInterval;
use crate::tracer::walk::Counter;
use crate::tracer::walk::filter::{Everything, Filter};
use crate::tracer::walk::rays::ANY_HIT;

impl<K: Kernel<Shape = Triangle>> MeshTree<K> {
    /// The closest hit, if its `t` is at most `farthest`. Otherwise the result is a miss, possibly with `t = farthest`,
    /// or a hit beyond `farthest`. With `ANY`, [`ANY_HIT`] or a miss; `farthest` must then be infinite. Only hits count
    /// that the filter accepts.
    ///
    /// Not inlined: the scene calls it from two places, for a mesh alone and for one of many instances.
    #[inline(never)]
    pub(crate) fn trace_scalar<const ANY: bool>(
        &self,
        ray: &Ray<f32>,
        farthest: f32,
        filter: &impl Filter,
        scratch: &mut TraversalScratch,
        counter: &mut impl Counter,
    ) -> Hit<f32> {
        let setup = Setup::<K, f32>::of(ray);
        let limit = Hit { t: farthest, ..Hit::MISS };
        self.bvh.walk_scalar::<ANY, _>(ray, &setup.slabs, limit, &mut scratch.scalar, counter, |leaf, best, counter| {
            for candidate in self.candidates(leaf, ray, &setup, filter, counter) {
                if ANY {
                    *best = ANY_HIT;
                    return;
                }
                if candidate.is_closer_than(best) {
                    *best = candidate;
                }
            }
        })
    }

    /// The closest hit by testing every triangle.
    pub(crate) fn closest_hit_brute_force(&self, ray: &Ray<f32>) -> Hit<f32> {
        let setup = Setup::<K, f32>::of(ray);
        (0..self.leaves.len())
            .flat_map(|leaf| self.candidates(leaf, ray, &setup, &Everything, &mut ()).collect::<Vec<_>>())
            .fold(Hit::MISS, |best, candidate| if candidate.is_closer_than(&best) { candidate } else { best })
    }

    /// The hits of a ray with the triangles of a leaf, by the box rule.
    #[inline(always)]
    fn candidates(
        &self,
        leaf: usize,
        ray: &Ray<f32>,
        setup: &Setup<K, f32>,
        filter: &impl Filter,
        counter: &mut impl Counter,
    ) -> impl Iterator<Item = Hit<f32>> {
        let LeafTriangles { prepared, numbers } = &self.leaves[leaf];
        numbers.numbers().enumerate().filter_map(move |(slot, primitive)| {
            let hit = K::lane(prepared, slot & 7).closest_hit(ray, &setup.kernel);
            let interval = || TInterval::<f32>::of(&self.boxes(leaf).lane(slot), ray.origin, &setup.slabs);
            counter.test(|| u32::from(interval().is_some()));
            if !hit.mask {
                return None;
            }
            let interval = interval()?;
            let hit = Hit { t: interval.clamp(hit.t), primitive, ..hit };
            filter.accepts(ray, &hit).then_some(hit)
        })
    }
}
