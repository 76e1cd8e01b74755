//! The two-level scene: a tree over instances, and below it one tree for each mesh.
//! [`crate::tracer`] states the box rule for both, and proves that every way of walking them finds the same hits.

use std::cell::RefCell;
use std::fmt::Debug;

use glam::Affine3;
use wide::{f32x8, u32x8};

use super::block::{Outcome, PACKETS};
use super::box_rule::Span;
use super::bvh::{Bvh, Child};
use super::mesh_tree::{MeshTree, Stacks};
use super::packet::{self, Found, in_lane};
use super::single::{self, SingleRay};
use super::stack::Places;
use super::tally::Tally;
use super::world_box::world_box;
use super::{Geometry, Mesh, Placement, World};
use crate::geom::lanes::{gt8, le8};
use crate::geom::{Aabb, Hit, Mask8, Quadric, Ray, Triangle};
use crate::kernels::aabb::InverseDirection;
use crate::kernels::instance::Instance;
use crate::kernels::quadric::Mixed;
use crate::kernels::{Intersect, Kernel};

/// A world that can be traced, its triangles with the kernel `K`, by single rays and by packets, with identical hits.
///
/// A hit's primitive number counts the primitives of all geometries in their order, triangles in the order of their mesh; a
/// quadric counts one. The instance number is that of the [`Placement`].
///
/// Geometry is shared by its instances. An instance takes about 275 bytes, with its placement and its share of the tree.
#[derive(Debug)]
pub struct Scene<K: Kernel> {
    world: World,
    /// For each geometry of the world, where its prepared form is.
    prepared: Vec<Prepared>,
    trees: Vec<MeshTree<K>>,
    quadrics: Vec<Box<dyn AnyQuadric>>,
    /// For each instance of the world.
    placed: Vec<Placed>,
    /// Over the instances.
    bvh: Bvh,
}

/// Where the prepared form of a geometry is.
#[derive(Clone, Copy, Debug)]
struct Prepared {
    /// Number of its first primitive.
    first_primitive: u32,
    /// Its number among the meshes, or among the quadrics.
    of_its_kind: u32,
}

/// A prepared instance.
#[derive(Clone, Copy, Debug)]
struct Placed {
    /// `None` for the identity: even a product with 1 can change a ray, which turns -0 + 0 into 0.
    transform: Option<Instance<()>>,
    /// Its box in the world.
    bounds: Aabb,
    geometry: u32,
}

impl Placed {
    #[inline(always)]
    fn ray_to_object(&self, ray: &Ray<f32>) -> Ray<f32> {
        self.transform.map_or(*ray, |transform| transform.ray_to_object(ray))
    }

    /// The rays in these lanes as the object sees them; in the others, inactive ones.
    #[inline(always)]
    fn rays_to_object(&self, ray: &Ray<f32x8>, lanes: Mask8) -> Ray<f32x8> {
        let Ray { origin, dir, t_min, t_max } = self.transform.map_or(*ray, |transform| transform.rays_to_object(ray));
        Ray {
            origin,
            dir,
            t_min: lanes.select(t_min, f32x8::splat(f32::INFINITY)),
            t_max: lanes.select(t_max, f32x8::splat(f32::NEG_INFINITY)),
        }
    }
}

/// A prepared quadric of a kernel that is chosen at run time: the call costs once per instance, not per node.
trait AnyQuadric: Debug + Send + Sync {
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

impl<K: Kernel<Shape = Triangle>> Scene<K> {
    /// Builds the trees and prepares the primitives, on all threads of the current rayon pool; quadrics for the kernel
    /// [`Mixed`], the fastest of those that are right about whether they are hit wherever an instance may put them.
    pub fn new(world: World) -> Self {
        Self::with_quadrics::<Mixed<f32>>(world)
    }

    /// [`Scene::new`], with another kernel for quadrics.
    pub fn with_quadrics<Q: Kernel<Shape = Quadric>>(world: World) -> Self {
        Self::build(world, |quadric| Box::new(Q::prepare(quadric)))
    }

    /// For any kernel for quadrics: the triangles' code is not compiled anew for each.
    fn build(world: World, prepare: fn(&Quadric) -> Box<dyn AnyQuadric>) -> Self {
        let (mut prepared, mut trees, mut quadrics) = (Vec::new(), Vec::new(), Vec::<Box<dyn AnyQuadric>>::new());
        let mut first_primitive = 0;
        for geometry in world.geometries() {
            let of_its_kind = match geometry {
                Geometry::Mesh(mesh) => {
                    trees.push(MeshTree::new(mesh));
                    trees.len() - 1
                }
                Geometry::Quadric(quadric) => {
                    quadrics.push(prepare(quadric));
                    quadrics.len() - 1
                }
            };
            prepared.push(Prepared { first_primitive, of_its_kind: of_its_kind as u32 });
            first_primitive += geometry.primitives() as u32;
        }
        let bounds: Vec<_> = world.geometries().iter().map(Geometry::bounds).collect();
        let place = |&Placement { geometry, object_to_world, .. }: &Placement| Placed {
            transform: (object_to_world != Affine3::IDENTITY)
                .then(|| Instance::new((), object_to_world).expect("a world refuses transforms without inverse")),
            bounds: world_box(&bounds[geometry as usize], &object_to_world),
            geometry,
        };
        let placed: Vec<_> = world.instances().iter().map(place).collect();
        let bvh = Bvh::build(placed.len(), |instance| placed[instance as usize].bounds);
        Self { world, prepared, trees, quadrics, placed, bvh }
    }

    /// The world as it came in.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The world again, without what was prepared for it.
    pub fn into_world(self) -> World {
        self.world
    }

    /// A box around all instances.
    pub fn bounds(&self) -> Aabb {
        self.placed.iter().fold(Aabb::EMPTY, |bounds, placed| bounds.union(&placed.bounds))
    }

    /// How many primitives there are, each counted once, however many instances it has.
    pub fn primitives(&self) -> usize {
        self.world.geometries().iter().map(Geometry::primitives).sum()
    }

    /// Bytes of geometries, instances, nodes and prepared primitives.
    pub fn bytes(&self) -> usize {
        let geometry = |geometry: &Geometry| {
            size_of_val(geometry)
                + match geometry {
                    Geometry::Mesh(mesh) => mesh.bytes(),
                    Geometry::Quadric(_) => 0,
                }
        };
        self.world.geometries().iter().map(geometry).sum::<usize>()
            + size_of_val(self.world.instances())
            + size_of_val(&self.prepared[..])
            + self.trees.iter().map(|tree| size_of_val(tree) + tree.bytes()).sum::<usize>()
            + self.quadrics.iter().map(|quadric| size_of_val(quadric) + size_of_val(&**quadric)).sum::<usize>()
            + size_of_val(&self.placed[..])
            + self.bvh.bytes()
    }

    /// The closest hit by trying every primitive of every instance, in any order: what the trees must agree with.
    pub fn closest_hit_brute_force(&self, ray: &Ray<f32>) -> Hit<f32> {
        let setup = InverseDirection::<f32>::of(ray);
        let mut best = Hit::MISS;
        for number in 0..self.placed.len() as u32 {
            let (placed, object) = self.instance(number);
            let Some(span) = Span::<f32>::of(&placed.bounds.into(), ray.origin, &setup) else { continue };
            let ray = placed.ray_to_object(ray);
            let hit = match object {
                Object::Mesh(tree) => tree.closest_hit_brute_force(&ray),
                Object::Quadric(quadric) => quadric.closest_hit(&ray),
            };
            let hit = self.in_world(hit, number, span);
            if hit.is_closer_than(&best) {
                best = hit;
            }
        }
        best
    }

    /// Instance `number`, and what it is an instance of.
    #[inline(always)]
    fn instance(&self, number: u32) -> (&Placed, Object<'_, K>) {
        let placed = &self.placed[number as usize];
        let of_its_kind = self.prepared[placed.geometry as usize].of_its_kind as usize;
        let object = match &self.world.geometries()[placed.geometry as usize] {
            Geometry::Mesh(_) => Object::Mesh(&self.trees[of_its_kind]),
            Geometry::Quadric(_) => Object::Quadric(&*self.quadrics[of_its_kind]),
        };
        (placed, object)
    }

    /// An instance's closest hit in its own coordinates, or a miss, as a candidate in the world.
    #[inline(always)]
    fn in_world(&self, hit: Hit<f32>, number: u32, span: Span<f32>) -> Hit<f32> {
        if !hit.mask {
            return Hit::MISS;
        }
        let primitive = hit.primitive + self.first_primitive(number);
        Hit { t: span.clamp(hit.t), primitive, instance: number, ..hit }
    }

    /// [`Scene::in_world`] in eight lanes, of which those that miss hold anything.
    #[inline(always)]
    fn in_world8(&self, hit: Hit<f32x8>, number: u32, span: Span<f32x8>) -> Hit<f32x8> {
        Hit {
            mask: hit.mask,
            t: span.clamp(hit.t),
            u: hit.u,
            v: hit.v,
            primitive: hit.primitive + u32x8::splat(self.first_primitive(number)),
            instance: u32x8::splat(number),
        }
    }

    /// The one mesh of a world that is nothing else, and as it is: its hits are those of the scene.
    #[inline(always)]
    fn only_mesh(&self) -> Option<&MeshTree<K>> {
        match (self.world.geometries(), &self.placed[..]) {
            ([Geometry::Mesh(_)], [Placed { transform: None, .. }]) => Some(&self.trees[0]),
            _ => None,
        }
    }

    #[inline(always)]
    pub(super) fn first_primitive(&self, instance: u32) -> u32 {
        self.prepared[self.placed[instance as usize].geometry as usize].first_primitive
    }
}

/// What an instance is an instance of.
enum Object<'a, K: Kernel> {
    Mesh(&'a MeshTree<K>),
    Quadric(&'a dyn AnyQuadric),
}

/// Stacks for both levels.
#[derive(Debug)]
pub(super) struct Scratch {
    upper: Stacks,
    lower: Stacks,
}

impl Scratch {
    pub(super) fn new() -> Self {
        Self { upper: Stacks::new(), lower: Stacks::new() }
    }
}

thread_local! {
    /// For rays that come one at a time: to allocate stacks for each would cost as much as to visit some nodes.
    static SCRATCH: RefCell<Scratch> = RefCell::new(Scratch::new());
}

/// Every way of tracing, with stacks that are used again, and something that counts.
impl<K: Kernel<Shape = Triangle>> Scene<K> {
    pub(super) fn closest_hit_scalar(&self, ray: &Ray<f32>, scratch: &mut Scratch, tally: &mut impl Tally) -> Hit<f32> {
        let Scratch { upper, lower } = scratch;
        if let Some(tree) = self.only_mesh() {
            return tree.closest_hit_scalar(ray, f32::INFINITY, lower, tally);
        }
        let setup = InverseDirection::<f32>::of(ray);
        self.bvh.closest_hit_scalar(ray, &setup, Hit::MISS, &mut upper.scalar, tally, |leaf, best, tally| {
            for number in self.bvh.leaves[leaf].numbers() {
                self.meet(number, ray, &setup, best, |tree, ray, farthest| {
                    tree.closest_hit_scalar(ray, farthest, lower, tally)
                });
            }
        })
    }

    pub(super) fn any_hit_scalar(&self, ray: &Ray<f32>, scratch: &mut Scratch, tally: &mut impl Tally) -> bool {
        let Scratch { upper, lower } = scratch;
        if let Some(tree) = self.only_mesh() {
            return tree.any_hit_scalar(ray, lower, tally);
        }
        let setup = InverseDirection::<f32>::of(ray);
        self.bvh.any_hit_scalar(ray, &setup, &mut upper.scalar, tally, |leaf, tally| {
            self.bvh.leaves[leaf]
                .numbers()
                .any(|number| self.meets(number, ray, &setup, |tree, ray| tree.any_hit_scalar(ray, lower, tally)))
        })
    }

    pub(super) fn closest_hit_single(&self, ray: &Ray<f32>, scratch: &mut Scratch, tally: &mut impl Tally) -> Hit<f32> {
        if let Some(tree) = self.only_mesh() {
            return tree.closest_hit_single(ray, f32::INFINITY, &mut scratch.lower, tally);
        }
        let Scratch { upper, lower } = scratch;
        self.closest_hit_below(self.bvh.root, ray, Hit::MISS, &mut upper.single, lower, tally)
    }

    /// [`Scene::closest_hit_single`] in part of the upper tree. A call of its own: beside it, a single mesh was 0.8 times as fast.
    #[inline(never)]
    fn closest_hit_below(
        &self,
        root: Child,
        ray: &Ray<f32>,
        best: Hit<f32>,
        places: &mut Places<single::Visit>,
        lower: &mut Stacks,
        tally: &mut impl Tally,
    ) -> Hit<f32> {
        let setup = InverseDirection::<f32>::of(ray);
        let walk = SingleRay::of(ray, &self.bvh.bounds);
        let mut instances = Instances { scene: self, ray, setup, lower };
        self.bvh.closest_hit_single(root, &walk, best, places, tally, &mut instances)
    }

    pub(super) fn any_hit_single(&self, ray: &Ray<f32>, scratch: &mut Scratch, tally: &mut impl Tally) -> bool {
        if let Some(tree) = self.only_mesh() {
            return tree.any_hit_single(ray, &mut scratch.lower, tally);
        }
        let Scratch { upper, lower } = scratch;
        self.any_hit_below(self.bvh.root, ray, &mut upper.single, lower, tally)
    }

    /// [`Scene::any_hit_single`] in part of the upper tree.
    #[inline(never)]
    fn any_hit_below(
        &self,
        root: Child,
        ray: &Ray<f32>,
        places: &mut Places<single::Visit>,
        lower: &mut Stacks,
        tally: &mut impl Tally,
    ) -> bool {
        let setup = InverseDirection::<f32>::of(ray);
        let walk = SingleRay::of(ray, &self.bvh.bounds);
        let mut instances = Instances { scene: self, ray, setup, lower };
        self.bvh.any_hit_single(root, &walk, places, tally, &mut instances)
    }

    pub(super) fn closest_hit_packet(
        &self,
        ray: &Ray<f32x8>,
        scratch: &mut Scratch,
        tally: &mut impl Tally,
    ) -> Hit<f32x8> {
        match self.only_mesh() {
            Some(tree) => tree.closest_hit_packet(ray, f32x8::splat(f32::INFINITY), &mut scratch.lower, tally),
            None => self.search::<_, false>(ray, scratch, tally).found.best,
        }
    }

    pub(super) fn any_hit_packet(&self, ray: &Ray<f32x8>, scratch: &mut Scratch, tally: &mut impl Tally) -> Mask8 {
        match self.only_mesh() {
            Some(tree) => tree.any_hit_packet(ray, &mut scratch.lower, tally),
            None => self.search::<_, true>(ray, scratch, tally).found.any,
        }
    }

    #[inline(never)]
    fn search<'a, T: Tally, const ANY: bool>(
        &'a self,
        ray: &'a Ray<f32x8>,
        Scratch { upper, lower }: &'a mut Scratch,
        tally: &'a mut T,
    ) -> Search<'a, K, T, ANY> {
        let setup = InverseDirection::<f32x8>::of(ray);
        let Stacks { single, packet, .. } = upper;
        let found = Found::new(Hit::<f32x8>::miss(), setup.t_max);
        let mut search = Search { scene: self, ray, setup, found, places: single, lower, tally };
        self.bvh.walk_packets::<ANY>(ray, &setup, packet, &mut search);
        search
    }

    /// Whether the scene is a mesh and nothing else, and so has streams and blocks.
    pub(super) fn is_one_mesh(&self) -> bool {
        self.only_mesh().is_some()
    }

    /// [`MeshTree::trace_stream`], where the scene is a mesh and nothing else.
    pub(super) fn trace_stream<const ANY: bool>(
        &self,
        rays: &[Ray<f32>],
        octant: usize,
        numbers: &mut [u16],
        hits: &mut [Hit<f32>],
        scratch: &mut Scratch,
        tally: &mut impl Tally,
    ) {
        if let Some(tree) = self.only_mesh() {
            tree.trace_stream::<ANY, _>(rays, octant, numbers, hits, &mut scratch.lower, tally);
        }
    }

    /// [`MeshTree::closest_hit_block`], where the scene is a mesh and nothing else.
    pub(super) fn closest_hit_block(
        &self,
        rays: &[Ray<f32>],
        hits: &mut [Hit<f32>],
        scratch: &mut Scratch,
        tally: &mut impl Tally,
    ) -> Outcome {
        let Some(tree) = self.only_mesh() else { return Outcome::Unlike };
        tree.closest_hit_block(rays, hits, &mut scratch.lower, tally)
    }

    /// [`MeshTree::any_hit_block`], where the scene is a mesh and nothing else.
    pub(super) fn any_hit_block(
        &self,
        rays: &[Ray<f32>],
        scratch: &mut Scratch,
        tally: &mut impl Tally,
    ) -> (Outcome, [Mask8; PACKETS]) {
        let Some(tree) = self.only_mesh() else { return (Outcome::Unlike, [Mask8::none(); PACKETS]) };
        tree.any_hit_block(rays, &mut scratch.lower, tally)
    }

    /// Puts an instance's closest hit in place of a farther one. `closest_hit` gets a tree, the ray as the object sees it, and
    /// beyond which `t` a hit is of no use.
    #[inline(always)]
    fn meet(
        &self,
        number: u32,
        ray: &Ray<f32>,
        setup: &InverseDirection<f32>,
        best: &mut Hit<f32>,
        mut closest_hit: impl FnMut(&MeshTree<K>, &Ray<f32>, f32) -> Hit<f32>,
    ) {
        let (placed, object) = self.instance(number);
        let Some(span) = Span::<f32>::of(&placed.bounds.into(), ray.origin, setup) else { return };
        if span.entry > best.t {
            return;
        }
        let ray = placed.ray_to_object(ray);
        let hit = match object {
            // A hit beyond the box is going to be clamped to its exit.
            Object::Mesh(tree) => closest_hit(tree, &ray, if span.exit > best.t { best.t } else { f32::INFINITY }),
            Object::Quadric(quadric) => quadric.closest_hit(&ray),
        };
        let hit = self.in_world(hit, number, span);
        if hit.is_closer_than(best) {
            *best = hit;
        }
    }

    /// Whether an instance is hit. `any_hit` gets a tree and the ray as the object sees it.
    #[inline(always)]
    fn meets(
        &self,
        number: u32,
        ray: &Ray<f32>,
        setup: &InverseDirection<f32>,
        mut any_hit: impl FnMut(&MeshTree<K>, &Ray<f32>) -> bool,
    ) -> bool {
        let (placed, object) = self.instance(number);
        if Span::<f32>::of(&placed.bounds.into(), ray.origin, setup).is_none() {
            return false;
        }
        let ray = placed.ray_to_object(ray);
        match object {
            Object::Mesh(tree) => any_hit(tree, &ray),
            Object::Quadric(quadric) => quadric.closest_hit(&ray).mask,
        }
    }
}

/// The instances, and a single ray on its way through the upper tree.
struct Instances<'a, K: Kernel> {
    scene: &'a Scene<K>,
    ray: &'a Ray<f32>,
    setup: InverseDirection<f32>,
    lower: &'a mut Stacks,
}

impl<K: Kernel<Shape = Triangle>, T: Tally> single::Leaves<T> for Instances<'_, K> {
    #[inline(always)]
    fn closest_hit(&mut self, leaf: usize, best: &mut Hit<f32>, tally: &mut T) {
        let Self { scene, ray, setup, lower } = self;
        for number in scene.bvh.leaves[leaf].numbers() {
            scene.meet(number, ray, setup, best, |tree, ray, farthest| {
                tree.closest_hit_single(ray, farthest, lower, tally)
            });
        }
    }

    #[inline(always)]
    fn any_hit(&mut self, leaf: usize, tally: &mut T) -> bool {
        let Self { scene, ray, setup, lower } = self;
        let mut numbers = scene.bvh.leaves[leaf].numbers();
        numbers.any(|number| scene.meets(number, ray, setup, |tree, ray| tree.any_hit_single(ray, lower, tally)))
    }
}

/// Eight rays on their way through the upper tree.
struct Search<'a, K: Kernel, T, const ANY: bool> {
    scene: &'a Scene<K>,
    ray: &'a Ray<f32x8>,
    setup: InverseDirection<f32x8>,
    found: Found<ANY>,
    places: &'a mut Places<single::Visit>,
    lower: &'a mut Stacks,
    tally: &'a mut T,
}

impl<K: Kernel<Shape = Triangle>, T: Tally, const ANY: bool> packet::Search for Search<'_, K, T, ANY> {
    #[inline(always)]
    fn limit(&self) -> f32x8 {
        self.found.limit
    }

    #[inline(always)]
    fn node(&mut self) {
        self.tally.node();
    }

    #[inline(always)]
    fn leaf(&mut self, leaf: usize, active: Mask8) {
        self.tally.leaf();
        for number in self.scene.bvh.leaves[leaf].numbers() {
            let (placed, object) = self.scene.instance(number);
            let (inside, span) = Span::<f32x8>::of(&placed.bounds.into(), self.ray.origin, &self.setup);
            let lanes = active & inside & le8(span.entry, self.found.limit);
            if !lanes.any() {
                continue;
            }
            let ray = placed.rays_to_object(self.ray, lanes);
            if ANY {
                let hit = match object {
                    Object::Mesh(tree) => tree.any_hit_packet(&ray, self.lower, self.tally),
                    Object::Quadric(quadric) => quadric.closest_hit8(&ray).mask,
                };
                self.found.end_in(hit);
            } else {
                let hit = match object {
                    Object::Mesh(tree) => {
                        // A hit beyond the box is going to be clamped to its exit.
                        let farthest =
                            gt8(span.exit, self.found.best.t).select(self.found.best.t, f32x8::splat(f32::INFINITY));
                        tree.closest_hit_packet(&ray, farthest, self.lower, self.tally)
                    }
                    Object::Quadric(quadric) => quadric.closest_hit8(&ray),
                };
                self.found.keep(&self.scene.in_world8(hit, number, span));
            }
        }
    }

    #[inline(always)]
    fn alone(&mut self, child: Child, lane: usize) {
        let ray = self.ray.lane(lane);
        if ANY {
            if self.scene.any_hit_below(child, &ray, self.places, self.lower, self.tally) {
                self.found.end(lane);
            }
        } else {
            let before = self.found.best.lane(lane);
            let hit = self.scene.closest_hit_below(child, &ray, before, self.places, self.lower, self.tally);
            self.found.keep(&in_lane(lane, &hit));
        }
    }
}

impl<K: Kernel<Shape = Triangle>> Intersect<f32> for Scene<K> {
    type Setup = ();

    fn setup(_: &Ray<f32>) {}

    fn candidate(&self, ray: &Ray<f32>, (): &()) -> Hit<f32> {
        SCRATCH.with_borrow_mut(|scratch| self.closest_hit_single(ray, scratch, &mut ()))
    }

    fn any_hit(&self, ray: &Ray<f32>, (): &()) -> bool {
        SCRATCH.with_borrow_mut(|scratch| self.any_hit_single(ray, scratch, &mut ()))
    }
}

impl<K: Kernel<Shape = Triangle>> Intersect<f32x8> for Scene<K> {
    type Setup = ();

    fn setup(_: &Ray<f32x8>) {}

    fn candidate(&self, ray: &Ray<f32x8>, (): &()) -> Hit<f32x8> {
        SCRATCH.with_borrow_mut(|scratch| self.closest_hit_packet(ray, scratch, &mut ()))
    }

    fn any_hit(&self, ray: &Ray<f32x8>, (): &()) -> Mask8 {
        SCRATCH.with_borrow_mut(|scratch| self.any_hit_packet(ray, scratch, &mut ()))
    }
}

impl<K: Kernel<Shape = Triangle>> From<Mesh> for Scene<K> {
    /// The mesh as it is, in its own colours.
    fn from(mesh: Mesh) -> Self {
        Self::new(mesh.into())
    }
}
