//! The packet walk in a leaf: eight rays against one triangle after the other.

use wide::f32x8;

use super::mesh_tree::{MeshTree, Setup};
use super::scratch::TraversalScratch;
use crate::geom::{Hit, Mask8, Ray, Triangle};
use crate::kernels::Kernel;
use crate::tracer::bvh::Child;
use crate::tracer::walk::Counter;
use crate::tracer::walk::filter::Filter;
use crate::tracer::walk::packet::{PacketHits, PacketSearch};
use crate::tracer::walk::rays::hit_in_lane;
use crate::tracer::walk::single;
use crate::tracer::walk::stack::StackStorage;

impl<K: Kernel<Shape = Triangle>> MeshTree<K> {
    /// [`MeshTree::trace_scalar`] in eight lanes.
    #[inline(never)]
    pub(crate) fn trace_packet<const ANY: bool>(
        &self,
        ray: &Ray<f32x8>,
        farthest: f32x8,
        filter: &impl Filter,
        TraversalScratch { single, packet, .. }: &mut TraversalScratch,
        counter: &mut impl Counter,
    ) -> Hit<f32x8> {
        let mut limit = Hit::<f32x8>::miss();
        limit.t = farthest;
        let setup = Setup::<K, f32x8>::of(ray);
        let hits = PacketHits::<ANY>::new(limit, setup.slabs.t_max);
        let mut search = MeshSearch { tree: self, ray, setup, hits, filter, single, counter };
        self.bvh.walk_packet::<ANY>(ray, &setup.slabs, packet, &mut search);
        search.hits.into_hits()
    }
}

/// Eight rays on their way through a mesh.
struct MeshSearch<'a, K: Kernel, F, T, const ANY: bool> {
    tree: &'a MeshTree<K>,
    ray: &'a Ray<f32x8>,
    setup: Setup<K, f32x8>,
    hits: PacketHits<ANY>,
    filter: &'a F,
    single: &'a mut StackStorage<single::StackEntry>,
    counter: &'a mut T,
}

impl<K, F, T, const ANY: bool> PacketSearch for MeshSearch<'_, K, F, T, ANY>
where
    K: Kernel<Shape = Triangle>,
    F: Filter,
    T: Counter,
{
    #[inline(always)]
    fn limit(&self) -> f32x8 {
        self.hits.limit
    }

    #[inline(always)]
    fn count_node(&mut self) {
        self.counter.node();
    }

    #[inline(always)]
    fn test_leaf(&mut self, leaf: usize, _active: Mask8) {
        self.counter.leaf();
        let boxes = self.tree.boxes(leaf);
        for slot in 0..self.tree.leaves[leaf].numbers.len() {
            let Self { tree, ray, setup, filter, counter, .. } = self;
            if let Some(candidate) = tree.test_packet(leaf, slot, &boxes, ray, setup, *filter, *counter) {
                self.hits.keep(&candidate);
            }
        }
    }

    #[inline(always)]
    fn trace_single(&mut self, child: Child, lane: usize) {
        let ray = self.ray.lane(lane);
        let before = if ANY { Hit::MISS } else { self.hits.best.lane(lane) };
        let hit = self.tree.trace_single_below::<ANY, _>(child, &ray, before, self.filter, self.single, self.counter);
        if ANY {
            if hit.mask {
                self.hits.end_in_lane(lane);
            }
        } else if hit.primitive != before.primitive {
            self.hits.keep(&hit_in_lane(lane, &hit));
        }
    }
}
