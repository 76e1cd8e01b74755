//! The two-level scene: a tree over instances, and below it one tree for each mesh.
//! [`crate::tracer`] states the box rule for both, and proves that every way of walking them finds the same hits.

use std::fmt::Debug;

use glam::Affine3;
use wide::{f32x8, u32x8};

use super::box_rule::Span;
use super::bvh::Bvh;
use super::mesh_tree::MeshTree;
use super::traverse::{Child, Room, Visit, keep_closer8};
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
/// Geometry is shared by its instances. An instance takes 328 bytes, with its placement and all that the tree needs.
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
        // To enter an instance costs more than the boxes of a node.
        let bvh = Bvh::build(placed.len(), 1, |instance| placed[instance as usize].bounds);
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
                Object::Mesh(tree, mesh) => tree.closest_hit_brute_force(mesh, &ray),
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
            Geometry::Mesh(mesh) => Object::Mesh(&self.trees[of_its_kind], mesh),
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
    fn only_mesh(&self) -> Option<(&MeshTree<K>, &Mesh)> {
        match (self.world.geometries(), &self.placed[..]) {
            ([Geometry::Mesh(mesh)], [Placed { transform: None, .. }]) => Some((&self.trees[0], mesh)),
            _ => None,
        }
    }

    pub(super) fn experiment(&self, rays: &[Ray<f32>], any_hit: bool, block: bool, hits: &mut [Hit<f32>]) {
        let (tree, _) = self.only_mesh().unwrap();
        match (any_hit, block) {
            (false, false) => tree.single_closest(rays, hits),
            (true, false) => tree.single_any(rays, hits),
            (false, true) => tree.block_closest(rays, hits),
            (true, true) => tree.block_any(rays, hits),
        }
    }

    #[inline(always)]
    pub(super) fn first_primitive(&self, instance: u32) -> u32 {
        self.prepared[self.placed[instance as usize].geometry as usize].first_primitive
    }
}

/// What an instance is an instance of.
enum Object<'a, K: Kernel> {
    Mesh(&'a MeshTree<K>, &'a Mesh),
    Quadric(&'a dyn AnyQuadric),
}

impl<K: Kernel<Shape = Triangle>> Intersect<f32> for Scene<K> {
    type Setup = ();

    fn setup(_: &Ray<f32>) {}

    fn closest_hit(&self, ray: &Ray<f32>, (): &()) -> Hit<f32> {
        let mut room: Room<Visit<f32>> = [(0.0, Child::ROOT); _];
        if let Some((tree, mesh)) = self.only_mesh() {
            return tree.closest_hit(mesh, ray, f32::INFINITY, &mut room);
        }
        let mut upper = room;
        let setup = InverseDirection::<f32>::of(ray);
        self.bvh.closest_hit(ray, &setup, Hit::MISS, &mut upper, |slot, best| {
            let number = self.bvh.item_of_slot[slot];
            let (placed, object) = self.instance(number);
            let Some(span) = Span::<f32>::of(&placed.bounds.into(), ray.origin, &setup) else { return };
            if span.entry > best.t {
                return;
            }
            let ray = placed.ray_to_object(ray);
            let hit = match object {
                Object::Mesh(tree, mesh) => {
                    // A hit beyond the box is going to be clamped to its exit.
                    let farthest = if span.exit > best.t { best.t } else { f32::INFINITY };
                    tree.closest_hit(mesh, &ray, farthest, &mut room)
                }
                Object::Quadric(quadric) => quadric.closest_hit(&ray),
            };
            let hit = self.in_world(hit, number, span);
            if hit.is_closer_than(best) {
                *best = hit;
            }
        })
    }

    fn any_hit(&self, ray: &Ray<f32>, (): &()) -> bool {
        if let Some((tree, mesh)) = self.only_mesh() {
            return tree.any_hit(mesh, ray);
        }
        let setup = InverseDirection::<f32>::of(ray);
        self.bvh.any_hit(ray, &setup, |slot| {
            let (placed, object) = self.instance(self.bvh.item_of_slot[slot]);
            if Span::<f32>::of(&placed.bounds.into(), ray.origin, &setup).is_none() {
                return false;
            }
            let ray = placed.ray_to_object(ray);
            match object {
                Object::Mesh(tree, mesh) => tree.any_hit(mesh, &ray),
                Object::Quadric(quadric) => quadric.closest_hit(&ray).mask,
            }
        })
    }
}

impl<K: Kernel<Shape = Triangle>> Intersect<f32x8> for Scene<K> {
    type Setup = ();

    fn setup(_: &Ray<f32x8>) {}

    fn closest_hit(&self, ray: &Ray<f32x8>, (): &()) -> Hit<f32x8> {
        let mut room: Room<Visit<f32x8>> = [(f32x8::ZERO, Child::ROOT); _];
        if let Some((tree, mesh)) = self.only_mesh() {
            return tree.closest_hit8(mesh, ray, f32x8::splat(f32::INFINITY), &mut room);
        }
        let mut upper = room;
        let setup = InverseDirection::<f32x8>::of(ray);
        self.bvh.closest_hit8(ray, &setup, Hit::<f32x8>::miss(), &mut upper, |slot, best| {
            let number = self.bvh.item_of_slot[slot];
            let (placed, object) = self.instance(number);
            let (inside, span) = Span::<f32x8>::of(&placed.bounds.into(), ray.origin, &setup);
            let lanes = inside & le8(span.entry, best.t);
            if !lanes.any() {
                return;
            }
            let ray = placed.rays_to_object(ray, lanes);
            let hit = match object {
                Object::Mesh(tree, mesh) => {
                    // A hit beyond the box is going to be clamped to its exit.
                    let farthest = gt8(span.exit, best.t).select(best.t, f32x8::splat(f32::INFINITY));
                    tree.closest_hit8(mesh, &ray, farthest, &mut room)
                }
                Object::Quadric(quadric) => quadric.closest_hit8(&ray),
            };
            keep_closer8(best, &self.in_world8(hit, number, span));
        })
    }

    fn any_hit(&self, ray: &Ray<f32x8>, (): &()) -> Mask8 {
        if let Some((tree, mesh)) = self.only_mesh() {
            return tree.any_hit8(mesh, ray);
        }
        let setup = InverseDirection::<f32x8>::of(ray);
        self.bvh.any_hit8(ray, &setup, |slot, limit| {
            let (placed, object) = self.instance(self.bvh.item_of_slot[slot]);
            let (inside, _) = Span::<f32x8>::of(&placed.bounds.into(), ray.origin, &setup);
            let lanes = inside & gt8(limit, f32x8::splat(f32::NEG_INFINITY));
            if !lanes.any() {
                return None;
            }
            let ray = placed.rays_to_object(ray, lanes);
            Some(match object {
                Object::Mesh(tree, mesh) => tree.any_hit8(mesh, &ray),
                Object::Quadric(quadric) => quadric.closest_hit8(&ray).mask,
            })
        })
    }
}

impl<K: Kernel<Shape = Triangle>> From<Mesh> for Scene<K> {
    /// The mesh as it is, in its own colours.
    fn from(mesh: Mesh) -> Self {
        Self::new(mesh.into())
    }
}
