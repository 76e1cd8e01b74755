//! The stream walk in a leaf: packets of eight listed rays against one triangle after the other; few rays, one by one
//! against all triangles of the leaf.

use wide::f32x8;

use super::mesh_tree::{LeafTriangles, MeshTree, apply_box_rule, lanes_in_box};
use super::scratch::TraversalScratch;
use crate::geom::lanes;
use crate::geom::{Hit, Ray, Triangle};
use crate::kernels::aabb::InverseDirection;
use crate::kernels::{Intersect, Kernel};
use crate::tracer::walk::Counter;
use crate::tracer::walk::filter::{Filter, accepted, closest_accepted};
use crate::tracer::walk::rays::{ANY_HIT, packet};
use crate::tracer::walk::stream::{self, MIN_WIDE_RAYS, StreamRay};

/// With fewer listed rays than this, each is tested alone against all triangles of the leaf. On incoherent rays, 3 was
/// 0.96 to 1.09 times as fast, 6 was 0.96 to 1.04, and three quarters of the leaf's triangles 0.90 to 1.04.
const MIN_PACKET_RAYS: usize = 4;

impl<K: Kernel<Shape = Triangle>> MeshTree<K> {
    /// Traces the rays with these numbers; their directions must be in `octant`, and their hits must be misses. Writes
    /// their hits, and changes the order of the numbers.
    #[inline(never)]
    #[expect(clippy::too_many_arguments, reason = "a stream, and what it needs")]
    pub(crate) fn trace_stream<const ANY: bool, T: Counter>(
        &self,
        rays: &[Ray<f32>],
        octant: usize,
        numbers: &mut [u16],
        hits: &mut [Hit<f32>],
        filter: &impl Filter,
        scratch: &mut TraversalScratch,
        counter: &mut T,
    ) {
        let long = numbers.len() >= MIN_WIDE_RAYS;
        let (mut len, mut t_min) = (0, f32::INFINITY);
        for index in 0..numbers.len() {
            let number = numbers[index];
            let ray = &rays[usize::from(number)];
            if let Some(ready) = StreamRay::of(ray, &self.bvh.extent).filter(|_| long) {
                scratch.stream.rays[usize::from(number) % stream::RAYS] = ready;
                t_min = lanes::min(ray.t_min, t_min);
                numbers[len] = number;
                len += 1;
            } else {
                hits[usize::from(number)] = self.trace_single::<ANY>(ray, f32::INFINITY, filter, scratch, counter);
            }
        }
        let mut search = StreamSearch::<K, _, ANY> { tree: self, rays, hits, filter };
        self.bvh.walk_stream::<ANY, T>(octant, &numbers[..len], t_min, &mut scratch.stream, counter, &mut search);
    }
}

/// The rays of a stream on their way through a mesh.
struct StreamSearch<'a, K: Kernel, F, const ANY: bool> {
    tree: &'a MeshTree<K>,
    rays: &'a [Ray<f32>],
    hits: &'a mut [Hit<f32>],
    filter: &'a F,
}

impl<K, F, T, const ANY: bool> stream::Leaves<T> for StreamSearch<'_, K, F, ANY>
where
    K: Kernel<Shape = Triangle>,
    F: Filter,
    T: Counter,
{
    #[inline(always)]
    fn test(&mut self, leaf: usize, numbers: &[u16], rays: &mut [StreamRay; stream::RAYS], counter: &mut T) {
        for numbers in numbers.chunks(8) {
            if numbers.len() < MIN_PACKET_RAYS {
                for &number in numbers {
                    self.test_one(leaf, number, rays, counter);
                }
            } else {
                self.test_eight(leaf, numbers, rays, counter);
            }
        }
    }
}

impl<K: Kernel<Shape = Triangle>, F: Filter, const ANY: bool> StreamSearch<'_, K, F, ANY> {
    /// Tests one ray against all triangles of a leaf.
    #[inline(always)]
    fn test_one<T: Counter>(
        &mut self,
        leaf: usize,
        number: u16,
        rays: &mut [StreamRay; stream::RAYS],
        counter: &mut T,
    ) {
        let ready = &mut rays[usize::from(number) % stream::RAYS];
        if ANY && ready.limit().is_nan() {
            return;
        }
        let ray = Ray::splat(&self.rays[usize::from(number)]);
        let setup = <K as Intersect<f32x8>>::setup(&ray);
        let slabs = || InverseDirection::<f32x8>::of(&ray);
        let candidates = self.tree.test_all_triangles(leaf, &ray, &setup, counter, slabs);
        if candidates.mask().any() {
            let closest = closest_accepted(&candidates, || ray.lane(0), self.filter);
            if F::ALL || closest.mask {
                self.keep(number, closest, ready);
            }
        }
    }

    /// Tests at most eight rays against one triangle of a leaf after the other.
    #[inline(always)]
    fn test_eight<T: Counter>(
        &mut self,
        leaf: usize,
        numbers: &[u16],
        rays: &mut [StreamRay; stream::RAYS],
        counter: &mut T,
    ) {
        let ray = packet(numbers.iter().map(|&number| &self.rays[usize::from(number)]));
        let setup = <K as Intersect<f32x8>>::setup(&ray);
        let LeafTriangles { prepared, numbers: triangles } = &self.tree.leaves[leaf];
        let (mut best, mut slabs) = (Hit::<f32x8>::miss(), None);
        for slot in 0..triangles.len() {
            let hit = K::candidate_in_lane(prepared, slot & 7, &ray, &setup);
            counter.test(|| lanes_in_box(&self.tree.boxes(leaf), slot, &ray, &InverseDirection::<f32x8>::of(&ray)));
            if hit.mask().any() {
                let slabs = slabs.get_or_insert_with(|| InverseDirection::<f32x8>::of(&ray));
                let bounds = self.tree.boxes(leaf).lane(slot & 7);
                let hit = apply_box_rule(hit, &bounds, triangles.0[slot & 7], &ray, slabs);
                best.keep_closer(&accepted(hit, &ray, self.filter));
            }
        }
        let mut hit = best.mask.bits();
        while hit != 0 {
            let lane = hit.trailing_zeros() as usize & 7;
            hit &= hit - 1;
            self.keep(numbers[lane], best.lane(lane), &mut rays[usize::from(numbers[lane]) % stream::RAYS]);
        }
    }

    /// Keeps the candidate of a ray if it is closer; with `ANY`, ends the ray's search.
    #[inline(always)]
    fn keep(&mut self, number: u16, candidate: Hit<f32>, ready: &mut StreamRay) {
        let best = &mut self.hits[usize::from(number)];
        if ANY {
            *best = ANY_HIT;
            ready.set_limit(f32::NAN);
        } else if candidate.is_closer_than(best) {
            *best = candidate;
            ready.set_limit(lanes::min(candidate.t, ready.limit()));
        }
    }
}
