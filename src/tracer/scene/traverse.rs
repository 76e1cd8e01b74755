//! Tracing rays through the two-level scene: each walk over the instances, and what it does in a leaf of them.
//!
//! A scene that is one untransformed mesh skips the upper level. Blocks and streams exist only there.

use std::cell::RefCell;

use wide::f32x8;

use super::instance::{Object, closest_accepted_hit, closest_hit8};
use super::two_level::Scene;
use super::world::Placement;
use crate::geom::lanes::{gt8, le8};
use crate::geom::{Candidate, Hit, Mask8, Ray, Triangle};
use crate::kernels::aabb::InverseDirection;
use crate::kernels::box_rule::TInterval;
use crate::kernels::{Intersect, Kernel};
use crate::tracer::bvh::Child;
use crate::tracer::leaf::{MeshTree, TraversalScratch};
use crate::tracer::walk::Counter;
use crate::tracer::walk::block::Outcome;
use crate::tracer::walk::filter::{Everything, Filter};
use crate::tracer::walk::packet::{PacketHits, PacketSearch};
use crate::tracer::walk::rays::{ANY_HIT, hit_in_lane};
use crate::tracer::walk::single::{self, SingleRay};
use crate::tracer::walk::stack::StackStorage;

/// Memory for both levels of trees.
#[derive(Debug)]
pub(crate) struct Scratch {
    upper: TraversalScratch,
    lower: TraversalScratch,
}

impl Scratch {
    pub(crate) fn new() -> Self {
        Self { upper: TraversalScratch::new(), lower: TraversalScratch::new() }
    }
}

thread_local! {
    /// For rays that come one at a time. Allocating stacks for each ray would cost as much as visiting some nodes.
    static SCRATCH: RefCell<Scratch> = RefCell::new(Scratch::new());
}

/// One method per walk. With `ANY`, hits are [`ANY_HIT`] or a miss.
impl<K: Kernel<Shape = Triangle>> Scene<K> {
    pub(crate) fn trace_scalar<const ANY: bool>(
        &self,
        ray: &Ray<f32>,
        visible: &Visible<impl Filter>,
        scratch: &mut Scratch,
        counter: &mut impl Counter,
    ) -> Hit<f32> {
        let Scratch { upper, lower } = scratch;
        if let Some(tree) = self.only_mesh() {
            if !visible.shows(&self.world().instances()[0]) {
                return Hit::MISS;
            }
            return tree.trace_scalar::<ANY>(ray, f32::INFINITY, &visible.filter, lower, counter);
        }
        let setup = InverseDirection::<f32>::of(ray);
        self.bvh.walk_scalar::<ANY, _>(ray, &setup, Hit::MISS, &mut upper.scalar, counter, |leaf, best, counter| {
            for number in self.bvh.leaves[leaf].numbers() {
                self.intersect_instance::<ANY, _>(number, ray, &setup, visible, best, |tree, ray, farthest, filter| {
                    tree.trace_scalar::<ANY>(ray, farthest, filter, lower, counter)
                });
                if ANY && best.mask {
                    return;
                }
            }
        })
    }

    pub(crate) fn trace_single<const ANY: bool>(
        &self,
        ray: &Ray<f32>,
        visible: &Visible<impl Filter>,
        scratch: &mut Scratch,
        counter: &mut impl Counter,
    ) -> Hit<f32> {
        if let Some(tree) = self.only_mesh() {
            if !visible.shows(&self.world().instances()[0]) {
                return Hit::MISS;
            }
            return tree.trace_single::<ANY>(ray, f32::INFINITY, &visible.filter, &mut scratch.lower, counter);
        }
        let Scratch { upper, lower } = scratch;
        self.trace_single_below::<ANY, _>(self.bvh.root, ray, Hit::MISS, visible, &mut upper.single, lower, counter)
    }

    /// [`Scene::trace_single`] in the subtree of `root`, starting with `best`. Not inlined: inlined, it made a scene of
    /// a single mesh 0.8 times as fast.
    #[inline(never)]
    #[expect(clippy::too_many_arguments, reason = "a ray on its way through two levels of trees")]
    fn trace_single_below<const ANY: bool, F: Filter>(
        &self,
        root: Child,
        ray: &Ray<f32>,
        best: Hit<f32>,
        visible: &Visible<F>,
        storage: &mut StackStorage<single::StackEntry>,
        lower: &mut TraversalScratch,
        counter: &mut impl Counter,
    ) -> Hit<f32> {
        let setup = InverseDirection::<f32>::of(ray);
        let walk = SingleRay::of(ray, &self.bvh.extent);
        let mut instances = SingleSearch::<K, F, ANY> { scene: self, ray, setup, visible, lower };
        self.bvh.walk_single::<ANY, _>(root, &walk, best, storage, counter, &mut instances)
    }

    pub(crate) fn trace_packet<const ANY: bool>(
        &self,
        ray: &Ray<f32x8>,
        visible: &Visible<impl Filter>,
        scratch: &mut Scratch,
        counter: &mut impl Counter,
    ) -> Hit<f32x8> {
        let Some(tree) = self.only_mesh() else {
            return self.trace_packet_through_instances::<ANY, _>(ray, visible, scratch, counter);
        };
        if !visible.shows(&self.world().instances()[0]) {
            return Hit::<f32x8>::miss();
        }
        let infinite = f32x8::splat(f32::INFINITY);
        tree.trace_packet::<ANY>(ray, infinite, &visible.filter, &mut scratch.lower, counter)
    }

    #[inline(never)]
    fn trace_packet_through_instances<const ANY: bool, F: Filter>(
        &self,
        ray: &Ray<f32x8>,
        visible: &Visible<F>,
        scratch: &mut Scratch,
        counter: &mut impl Counter,
    ) -> Hit<f32x8> {
        if !F::ALL {
            // A filter is asked about one ray, before its hit is clamped to the instance's box.
            let trace = |lane| self.trace_single::<ANY>(&ray.lane(lane), visible, scratch, counter);
            return Hit::from_lanes(&std::array::from_fn(trace));
        }
        let Scratch { upper, lower } = scratch;
        let visible = Visible { mask: visible.mask, filter: Everything };
        let setup = InverseDirection::<f32x8>::of(ray);
        let TraversalScratch { single, packet, .. } = upper;
        let hits = PacketHits::<ANY>::new(Hit::<f32x8>::miss(), setup.t_max);
        let mut search = InstanceSearch { scene: self, ray, setup, visible, hits, single, lower, counter };
        self.bvh.walk_packet::<ANY>(ray, &setup, packet, &mut search);
        search.hits.into_hits()
    }

    /// Whether the scene is one untransformed mesh. Only such a scene has blocks and streams.
    pub(crate) fn is_one_mesh(&self) -> bool {
        self.only_mesh().is_some()
    }

    /// Whether any instance counts.
    pub(crate) fn shows_any(&self, visible: &Visible<impl Filter>) -> bool {
        self.world().instances().iter().any(|instance| visible.shows(instance))
    }

    /// [`MeshTree::trace_block`]; [`Outcome::Incoherent`] with misses if the scene is not one untransformed mesh.
    pub(crate) fn trace_block<const ANY: bool>(
        &self,
        rays: &[Ray<f32>],
        hits: &mut [Hit<f32>],
        filter: &impl Filter,
        scratch: &mut Scratch,
        counter: &mut impl Counter,
    ) -> Outcome {
        let Some(tree) = self.only_mesh() else {
            hits.fill(Hit::MISS);
            return Outcome::Incoherent;
        };
        tree.trace_block::<ANY, _>(rays, hits, filter, &mut scratch.lower, counter)
    }

    /// [`MeshTree::trace_stream`]; does nothing if the scene is not one untransformed mesh.
    #[expect(clippy::too_many_arguments, reason = "a stream, and what it needs")]
    pub(crate) fn trace_stream<const ANY: bool>(
        &self,
        rays: &[Ray<f32>],
        octant: usize,
        numbers: &mut [u16],
        hits: &mut [Hit<f32>],
        filter: &impl Filter,
        scratch: &mut Scratch,
        counter: &mut impl Counter,
    ) {
        if let Some(tree) = self.only_mesh() {
            tree.trace_stream::<ANY, _>(rays, octant, numbers, hits, filter, &mut scratch.lower, counter);
        }
    }

    /// Intersects one instance and replaces `best` by a closer hit that counts; with `ANY`, by any.
    ///
    /// `trace` gets a mesh, the ray in object coordinates, the largest useful `t`, and which of its hits count.
    #[inline(always)]
    fn intersect_instance<const ANY: bool, F: Filter>(
        &self,
        number: u32,
        ray: &Ray<f32>,
        setup: &InverseDirection<f32>,
        visible: &Visible<F>,
        best: &mut Hit<f32>,
        mut trace: impl FnMut(&MeshTree<K>, &Ray<f32>, f32, &InInstance<'_, K, F>) -> Hit<f32>,
    ) {
        if !visible.shows(&self.world().instances()[number as usize]) {
            return;
        }
        let (instance, object) = self.instance(number);
        let Some(interval) = TInterval::<f32>::of(&instance.bounds.into(), ray.origin, setup) else { return };
        if !ANY && interval.entry > best.t {
            return;
        }
        let filter = InInstance { scene: self, ray, number, interval, filter: &visible.filter };
        let ray = instance.ray_to_object(ray);
        // A hit beyond the box is going to be clamped to its exit, so the search ends at `best` only if the exit is
        // beyond.
        let farthest = if !ANY && interval.exit > best.t { best.t } else { f32::INFINITY };
        let hit = match object {
            Object::Mesh(tree) => trace(tree, &ray, farthest, &filter),
            Object::Quadrics(quadrics) => closest_accepted_hit(quadrics, &ray, &filter),
        };
        if ANY {
            if hit.mask {
                *best = ANY_HIT;
            }
            return;
        }
        let hit = self.hit_in_world(hit, number, interval);
        if hit.is_closer_than(best) {
            *best = hit;
        }
    }
}

/// Which instances and which hits count.
#[derive(Clone, Copy, Debug)]
pub struct Visible<F> {
    /// An instance counts if its mask has one of these bits.
    pub(super) mask: u32,
    pub(crate) filter: F,
}

impl Visible<Everything> {
    pub(crate) const EVERYTHING: Self = Self { mask: u32::MAX, filter: Everything };
}

impl<F: Filter> Visible<F> {
    #[inline(always)]
    fn shows(&self, placement: &Placement) -> bool {
        placement.mask & self.mask != 0
    }
}

/// The filter of a ray's hits inside an instance: it asks about the ray and the hit in the world.
struct InInstance<'a, K: Kernel, F> {
    scene: &'a Scene<K>,
    /// The ray in the world.
    ray: &'a Ray<f32>,
    /// The number of the instance.
    number: u32,
    /// The interval of the ray in the instance's world box.
    interval: TInterval<f32>,
    filter: &'a F,
}

impl<K: Kernel<Shape = Triangle>, F: Filter> Filter for InInstance<'_, K, F> {
    const ALL: bool = F::ALL;

    #[inline(always)]
    fn accepts(&self, _: &Ray<f32>, hit: &Hit<f32>) -> bool {
        let in_world = self.scene.hit_in_world(*hit, self.number, self.interval);
        self.filter.accepts_in_instance(self.ray, &in_world, hit.t)
    }
}

/// One ray on its way through the instances.
struct SingleSearch<'a, K: Kernel, F, const ANY: bool> {
    scene: &'a Scene<K>,
    ray: &'a Ray<f32>,
    setup: InverseDirection<f32>,
    visible: &'a Visible<F>,
    lower: &'a mut TraversalScratch,
}

impl<K, F, T, const ANY: bool> single::Leaves<T> for SingleSearch<'_, K, F, ANY>
where
    K: Kernel<Shape = Triangle>,
    F: Filter,
    T: Counter,
{
    #[inline(always)]
    fn test(&mut self, leaf: usize, best: &mut Hit<f32>, counter: &mut T) {
        let Self { scene, ray, setup, visible, lower } = self;
        for number in scene.bvh.leaves[leaf].numbers() {
            scene.intersect_instance::<ANY, F>(number, ray, setup, visible, best, |tree, ray, farthest, filter| {
                tree.trace_single::<ANY>(ray, farthest, filter, lower, counter)
            });
            if ANY && best.mask {
                return;
            }
        }
    }
}

/// Eight rays on their way through the instances.
struct InstanceSearch<'a, K: Kernel, T, const ANY: bool> {
    scene: &'a Scene<K>,
    ray: &'a Ray<f32x8>,
    setup: InverseDirection<f32x8>,
    visible: Visible<Everything>,
    hits: PacketHits<ANY>,
    single: &'a mut StackStorage<single::StackEntry>,
    lower: &'a mut TraversalScratch,
    counter: &'a mut T,
}

impl<K: Kernel<Shape = Triangle>, T: Counter, const ANY: bool> PacketSearch for InstanceSearch<'_, K, T, ANY> {
    #[inline(always)]
    fn limit(&self) -> f32x8 {
        self.hits.limit
    }

    #[inline(always)]
    fn count_node(&mut self) {
        self.counter.node();
    }

    #[inline(always)]
    fn test_leaf(&mut self, leaf: usize, active: Mask8) {
        self.counter.leaf();
        for number in self.scene.bvh.leaves[leaf].numbers() {
            if !self.visible.shows(&self.scene.world().instances()[number as usize]) {
                continue;
            }
            let (instance, object) = self.scene.instance(number);
            let (inside, interval) = TInterval::<f32x8>::of(&instance.bounds.into(), self.ray.origin, &self.setup);
            let lanes = active & inside & le8(interval.entry, self.hits.limit);
            if !lanes.any() {
                continue;
            }
            let ray = instance.rays_to_object(self.ray, lanes);
            let infinite = f32x8::splat(f32::INFINITY);
            // A hit beyond the box is going to be clamped to its exit: see `Scene::intersect_instance`.
            let best = self.hits.best.t;
            let farthest = if ANY { infinite } else { gt8(interval.exit, best).select(best, infinite) };
            let hit = match object {
                Object::Mesh(tree) => tree.trace_packet::<ANY>(&ray, farthest, &Everything, self.lower, self.counter),
                Object::Quadrics(quadrics) => closest_hit8(quadrics, &ray),
            };
            if ANY {
                self.hits.end_in(hit.mask);
            } else {
                self.hits.keep(&self.scene.hit_in_world8(hit, number, interval));
            }
        }
    }

    #[inline(always)]
    fn trace_single(&mut self, child: Child, lane: usize) {
        let ray = self.ray.lane(lane);
        let before = if ANY { Hit::MISS } else { self.hits.best.lane(lane) };
        let Self { scene, visible, single, lower, counter, .. } = self;
        let hit = scene.trace_single_below::<ANY, _>(child, &ray, before, visible, single, lower, *counter);
        if !ANY {
            self.hits.keep(&hit_in_lane(lane, &hit));
        } else if hit.mask {
            self.hits.end_in_lane(lane);
        }
    }
}

/// Calls `trace` with the memory of this thread. If that is in use, `trace` gets new memory: the kernel of a scene may
/// itself trace a scene.
pub(super) fn with_scratch<T>(trace: impl FnOnce(&mut Scratch) -> T) -> T {
    SCRATCH.with(|scratch| match scratch.try_borrow_mut() {
        Ok(mut scratch) => trace(&mut scratch),
        Err(_) => trace(&mut Scratch::new()),
    })
}

impl<K: Kernel<Shape = Triangle>> Intersect<f32> for Scene<K> {
    type Setup = ();

    fn setup(_: &Ray<f32>) {}

    fn candidate(&self, ray: &Ray<f32>, (): &()) -> Candidate<f32> {
        with_scratch(|scratch| self.trace_single::<false>(ray, &Visible::EVERYTHING, scratch, &mut ())).into()
    }

    fn any_hit(&self, ray: &Ray<f32>, (): &()) -> bool {
        with_scratch(|scratch| self.trace_single::<true>(ray, &Visible::EVERYTHING, scratch, &mut ())).mask
    }
}

impl<K: Kernel<Shape = Triangle>> Intersect<f32x8> for Scene<K> {
    type Setup = ();

    fn setup(_: &Ray<f32x8>) {}

    fn candidate(&self, ray: &Ray<f32x8>, (): &()) -> Candidate<f32x8> {
        with_scratch(|scratch| self.trace_packet::<false>(ray, &Visible::EVERYTHING, scratch, &mut ())).into()
    }

    fn any_hit(&self, ray: &Ray<f32x8>, (): &()) -> Mask8 {
        with_scratch(|scratch| self.trace_packet::<true>(ray, &Visible::EVERYTHING, scratch, &mut ())).mask
    }
}
