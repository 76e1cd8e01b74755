//! The two-level scene: a tree over instances, and below it one tree per mesh.

use glam::Affine3;
use wide::{f32x8, u32x8};

use super::faces::{Face, PreparedDisc};
use super::instance::{AnyQuadric, Object, PreparedInstance, closest_accepted_hit};
use super::world::{Geometry, Placement, World};
use super::world_box::world_box;
use crate::geom::{Aabb, Candidate, Hit, Quadric, Ray, Triangle};
use crate::kernels::Kernel;
use crate::kernels::aabb::InverseDirection;
use crate::kernels::box_rule::TInterval;
use crate::kernels::instance::Instance;
use crate::kernels::quadric::Mixed;
use crate::tracer::bvh::Bvh;
use crate::tracer::leaf::MeshTree;
use crate::tracer::meshes::Mesh;
use crate::tracer::walk::filter::Everything;

/// A [`World`] prepared for tracing. Its triangles are intersected by the kernel `K`.
///
/// Primitive numbers of hits count the primitives of all geometries in order: the triangles of a mesh in file order, a
/// quadric as one, and each face of [`Geometry::Faces`]. The instance number is the index of the [`Placement`]. Single
/// rays and packets give identical hits.
///
/// Instances share their geometry. One instance takes about 275 bytes, including its placement and its share of the
/// tree.
#[derive(Debug)]
pub struct Scene<K: Kernel> {
    world: World,
    /// For each geometry of the world, the place of its prepared form.
    prepared: Vec<Prepared>,
    trees: Vec<MeshTree<K>>,
    quadrics: Vec<Box<dyn AnyQuadric>>,
    /// For each instance of the world.
    instances: Vec<PreparedInstance>,
    /// Tree over the instances.
    pub(super) bvh: Bvh,
}

/// Place of the prepared form of a geometry.
#[derive(Clone, Copy, Debug)]
struct Prepared {
    /// Number of its first primitive.
    first_primitive: u32,
    /// Index among the meshes, or of its first quadric.
    of_its_kind: u32,
}

impl<K: Kernel<Shape = Triangle>> Scene<K> {
    /// Builds the trees and prepares the primitives, on all threads of the current rayon pool.
    ///
    /// Quadrics use the kernel [`Mixed`]: the fastest one that decides hit or miss correctly under any instance
    /// transform.
    pub fn new(world: World) -> Self {
        Self::with_quadrics::<Mixed<f32>>(world)
    }

    /// [`Scene::new`] with the kernel `Q` for quadrics.
    pub fn with_quadrics<Q: Kernel<Shape = Quadric>>(world: World) -> Self {
        Self::build(world, &mut MeshTree::new, prepared::<Q>)
    }

    /// The same world and the same trees for the kernels `L` and `Q`, as [`Scene::with_quadrics`] would make them.
    /// Building is the slow part, and it does not depend on the kernels.
    #[cfg(feature = "study")]
    pub(crate) fn prepared_for<L: Kernel<Shape = Triangle>, Q: Kernel<Shape = Quadric>>(&self) -> Scene<L> {
        let mut trees = self.trees.iter();
        let mut next = |mesh: &Mesh| trees.next().expect("one tree for each mesh").prepared_for(mesh);
        Scene::build(self.world.clone(), &mut next, prepared::<Q>)
    }

    /// `tree` makes the tree of each mesh, in order. Not generic over the kernel of quadrics, so the code for triangles
    /// is compiled once.
    fn build(
        world: World,
        tree: &mut dyn FnMut(&Mesh) -> MeshTree<K>,
        prepare: fn(&Quadric) -> Box<dyn AnyQuadric>,
    ) -> Self {
        let (mut prepared, mut trees, mut quadrics) = (Vec::new(), Vec::new(), Vec::<Box<dyn AnyQuadric>>::new());
        let mut first_primitive = 0;
        for geometry in world.geometries() {
            let of_its_kind = match geometry {
                Geometry::Mesh(mesh) => {
                    trees.push(tree(mesh));
                    trees.len() - 1
                }
                Geometry::Quadric(quadric) => {
                    quadrics.push(prepare(quadric));
                    quadrics.len() - 1
                }
                Geometry::Faces(faces) => {
                    quadrics.extend(faces.iter().map(|face| match face {
                        Face::Quadric(quadric) => prepare(quadric),
                        Face::Disc(disc) => Box::new(PreparedDisc { square: prepare(&disc.square()), disc: *disc }),
                    }));
                    quadrics.len() - faces.len()
                }
            };
            prepared.push(Prepared { first_primitive, of_its_kind: of_its_kind as u32 });
            first_primitive += geometry.primitives() as u32;
        }
        let bounds: Vec<_> = world.geometries().iter().map(Geometry::bounds).collect();
        let prepare = |&Placement { geometry, object_to_world, .. }: &Placement| PreparedInstance {
            transform: (object_to_world != Affine3::IDENTITY)
                .then(|| Instance::new((), object_to_world).expect("a world refuses transforms without inverse")),
            bounds: world_box(&bounds[geometry as usize], &object_to_world),
            geometry,
        };
        let instances: Vec<_> = world.instances().iter().map(prepare).collect();
        let bvh = Bvh::build(instances.len(), |number| instances[number as usize].bounds);
        Self { world, prepared, trees, quadrics, instances, bvh }
    }

    /// The world that the scene was made of.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Returns the world and drops the prepared data.
    pub fn into_world(self) -> World {
        self.world
    }

    /// A box around all instances.
    pub fn bounds(&self) -> Aabb {
        self.instances.iter().fold(Aabb::EMPTY, |bounds, instance| bounds.union(&instance.bounds))
    }

    /// Number of primitives of all geometries. Instances do not multiply it.
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
                    Geometry::Faces(faces) => size_of_val(&faces[..]),
                }
        };
        self.world.geometries().iter().map(geometry).sum::<usize>()
            + size_of_val(self.world.instances())
            + size_of_val(&self.prepared[..])
            + self.trees.iter().map(|tree| size_of_val(tree) + tree.bytes()).sum::<usize>()
            + self.quadrics.iter().map(|quadric| size_of_val(quadric) + size_of_val(&**quadric)).sum::<usize>()
            + size_of_val(&self.instances[..])
            + self.bvh.bytes()
    }

    /// The closest hit by testing every primitive of every instance. The trees must give the same.
    pub fn closest_hit_brute_force(&self, ray: &Ray<f32>) -> Hit<f32> {
        let setup = InverseDirection::<f32>::of(ray);
        let mut best = Hit::MISS;
        for number in 0..self.instances.len() as u32 {
            let (instance, object) = self.instance(number);
            let Some(interval) = TInterval::<f32>::of(&instance.bounds.into(), ray.origin, &setup) else { continue };
            let ray = instance.ray_to_object(ray);
            let hit = match object {
                Object::Mesh(tree) => tree.closest_hit_brute_force(&ray),
                Object::Quadrics(quadrics) => closest_accepted_hit(quadrics, &ray, &Everything),
            };
            let hit = self.hit_in_world(hit, number, interval);
            if hit.is_closer_than(&best) {
                best = hit;
            }
        }
        best
    }

    /// Instance `number` and its object.
    #[inline(always)]
    pub(super) fn instance(&self, number: u32) -> (&PreparedInstance, Object<'_, K>) {
        let instance = &self.instances[number as usize];
        let of_its_kind = self.prepared[instance.geometry as usize].of_its_kind as usize;
        let object = match &self.world.geometries()[instance.geometry as usize] {
            Geometry::Mesh(_) => Object::Mesh(&self.trees[of_its_kind]),
            Geometry::Quadric(_) => Object::Quadrics(&self.quadrics[of_its_kind..=of_its_kind]),
            Geometry::Faces(faces) => Object::Quadrics(&self.quadrics[of_its_kind..of_its_kind + faces.len()]),
        };
        (instance, object)
    }

    /// Turns an instance's closest hit in object coordinates into a candidate in the world, by the box rule. A miss
    /// stays a miss. `interval` is that of the ray in the instance's world box.
    #[inline(always)]
    pub(super) fn hit_in_world(&self, hit: Hit<f32>, number: u32, interval: TInterval<f32>) -> Hit<f32> {
        if !hit.mask {
            return Hit::MISS;
        }
        let primitive = hit.primitive + self.first_primitive(number);
        Hit { t: interval.clamp(hit.t), primitive, instance: number, ..hit }
    }

    /// [`Scene::hit_in_world`] in eight lanes.
    #[inline(always)]
    pub(super) fn hit_in_world8(&self, hit: Hit<f32x8>, number: u32, interval: TInterval<f32x8>) -> Candidate<f32x8> {
        let primitive = hit.primitive + u32x8::splat(self.first_primitive(number));
        Candidate::from(hit).narrowed(hit.mask, interval.clamp(hit.t)).of_primitives(primitive).of_instance(number)
    }

    /// The tree of the mesh, if the world is one untransformed mesh. Its hits are then those of the scene.
    #[inline(always)]
    pub(super) fn only_mesh(&self) -> Option<&MeshTree<K>> {
        match (self.world.geometries(), &self.instances[..]) {
            ([Geometry::Mesh(_)], [PreparedInstance { transform: None, .. }]) => Some(&self.trees[0]),
            _ => None,
        }
    }

    /// Number of the first primitive of an instance's geometry.
    #[inline(always)]
    pub(super) fn first_primitive(&self, instance: u32) -> u32 {
        self.prepared[self.instances[instance as usize].geometry as usize].first_primitive
    }
}

/// A quadric, prepared for the kernel `Q`.
fn prepared<Q: Kernel<Shape = Quadric>>(quadric: &Quadric) -> Box<dyn AnyQuadric> {
    Box::new(Q::prepare(quadric))
}

impl<K: Kernel<Shape = Triangle>> From<Mesh> for Scene<K> {
    /// One instance of the mesh, untransformed, in its own colours.
    fn from(mesh: Mesh) -> Self {
        Self::new(mesh.into())
    }
}
