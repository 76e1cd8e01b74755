//! The peers on crates.io, called as their users would: with the crate's tree, its traversal, and its own triangle test
//! if that sees both sides of a triangle.

use std::time::{Duration, Instant};

use bvh::aabb::{Aabb, Bounded};
use bvh::bounding_hierarchy::{BHShape, BoundingHierarchy};
use bvh::bvh::{Bvh, BvhNode};
use nalgebra::{Point3, Vector3};
use obvhs::BvhBuildParams;
use obvhs::bvh2::{Bvh2, builder::build_bvh2_from_tris, node::Bvh2Node};
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh_from_tris, node::CwBvhNode};
use obvhs::ray::RayHit;
use obvhs::rt_triangle::RtTriangle;
use parry3d::math::Vector;
use parry3d::partitioning::{Bvh as ParryBvh, BvhBuildStrategy};
use parry3d::query::details::local_ray_intersection_with_triangle;
use parry3d::shape::Triangle as ParryTriangle;

use super::contender::{Contender, Tracer, in_chunks};
use crate::geom::{Hit, Ray, Triangle};
use crate::kernels::triangle::MollerTrumbore;
use crate::kernels::{Intersect, Kernel};
use crate::tracer::Mesh;

/// Every crate in its best configurations, with a tree built over the mesh.
pub fn rust_peers(mesh: &Mesh) -> Vec<Contender<'static>> {
    // The presets may split large triangles before the tree is built (spatial splits).
    let presets =
        [("medium build", BvhBuildParams::medium_build()), ("very slow build", BvhBuildParams::very_slow_build())];
    let mut peers = Vec::new();
    for (preset, parameters) in presets {
        peers.push(contender("obvhs", format!("Bvh2, {preset}"), || Obvhs::<Bvh2>::new(mesh, parameters)));
        peers.push(contender("obvhs", format!("CwBvh, {preset}"), || Obvhs::<CwBvh>::new(mesh, parameters)));
    }
    for (name, strategy) in [("binned", BvhBuildStrategy::Binned), ("PLOC", BvhBuildStrategy::Ploc)] {
        peers.push(contender("parry3d", name.into(), || Parry::new(mesh, strategy)));
    }
    peers.push(contender("bvh", "nearer child first".into(), || BvhCrate::new(mesh)));
    peers
}

/// Builds a peer and times the build. None of these crates promises watertight edges.
fn contender<T: Tracer + Size + 'static>(
    tracer: &'static str,
    configuration: String,
    build: impl FnOnce() -> T,
) -> Contender<'static> {
    let start = Instant::now();
    let scene = build();
    let build_seconds = start.elapsed().as_secs_f64();
    Contender { tracer, configuration, watertight: false, build_seconds, bytes: scene.bytes(), scene: Box::new(scene) }
}

trait Size {
    /// Bytes of tree and triangles; `None` if the crate hides them.
    fn bytes(&self) -> Option<usize>;
}

/// The hit of an any-hit ray: only the mask matters.
fn any(hit: bool) -> Hit<f32> {
    Hit::<f32>::new(hit, 0.0, 0.0, 0.0)
}

/// A tree of obvhs, and its triangles in the order of the leaves.
struct Obvhs<B> {
    tree: B,
    triangles: Vec<RtTriangle>,
}

/// The operations that both trees of obvhs have.
trait ObvhsTree: Send + Sync {
    fn build(triangles: &[obvhs::triangle::Triangle], parameters: BvhBuildParams) -> Self;
    fn primitives(&self) -> &[u32];
    fn node_bytes(&self) -> usize;
    fn closest(&self, ray: obvhs::ray::Ray, test: impl FnMut(&obvhs::ray::Ray, usize) -> f32) -> Option<RayHit>;
    fn any(&self, ray: obvhs::ray::Ray, test: impl FnMut(&obvhs::ray::Ray, usize) -> f32) -> bool;
}

impl ObvhsTree for Bvh2 {
    fn build(triangles: &[obvhs::triangle::Triangle], parameters: BvhBuildParams) -> Self {
        build_bvh2_from_tris(triangles, parameters, &mut Duration::default())
    }

    fn primitives(&self) -> &[u32] {
        &self.primitive_indices
    }

    fn node_bytes(&self) -> usize {
        self.nodes.len() * size_of::<Bvh2Node>()
    }

    fn closest(&self, ray: obvhs::ray::Ray, test: impl FnMut(&obvhs::ray::Ray, usize) -> f32) -> Option<RayHit> {
        let mut found = RayHit::none();
        self.ray_traverse(ray, &mut found, test).then_some(found)
    }

    fn any(&self, ray: obvhs::ray::Ray, test: impl FnMut(&obvhs::ray::Ray, usize) -> f32) -> bool {
        !self.ray_traverse_miss(ray, test)
    }
}

impl ObvhsTree for CwBvh {
    fn build(triangles: &[obvhs::triangle::Triangle], parameters: BvhBuildParams) -> Self {
        build_cwbvh_from_tris(triangles, parameters, &mut Duration::default())
    }

    fn primitives(&self) -> &[u32] {
        &self.primitive_indices
    }

    fn node_bytes(&self) -> usize {
        self.nodes.len() * size_of::<CwBvhNode>()
    }

    fn closest(&self, ray: obvhs::ray::Ray, test: impl FnMut(&obvhs::ray::Ray, usize) -> f32) -> Option<RayHit> {
        let mut found = RayHit::none();
        self.ray_traverse(ray, &mut found, test).then_some(found)
    }

    fn any(&self, ray: obvhs::ray::Ray, test: impl FnMut(&obvhs::ray::Ray, usize) -> f32) -> bool {
        !self.ray_traverse_miss(ray, test)
    }
}

impl<B: ObvhsTree> Obvhs<B> {
    fn new(mesh: &Mesh, parameters: BvhBuildParams) -> Self {
        let triangles: Vec<_> = mesh
            .iter()
            .map(|Triangle { v0, v1, v2 }| obvhs::triangle::Triangle { v0: v0.into(), v1: v1.into(), v2: v2.into() })
            .collect();
        let tree = B::build(&triangles, parameters);
        let triangles = tree.primitives().iter().map(|&index| (&triangles[index as usize]).into()).collect();
        Self { tree, triangles }
    }
}

impl<B: ObvhsTree> Size for Obvhs<B> {
    fn bytes(&self) -> Option<usize> {
        Some(self.tree.node_bytes() + size_of_val(self.tree.primitives()) + size_of_val(&self.triangles[..]))
    }
}

impl<B: ObvhsTree> Tracer for Obvhs<B> {
    fn trace(&self, rays: &[Ray<f32>], any_hit: bool, hits: &mut [Hit<f32>]) {
        in_chunks(rays, hits, |rays, hits| {
            for (ray, hit) in rays.iter().zip(hits) {
                let ray = obvhs::ray::Ray::new(ray.origin.into(), ray.dir.into(), ray.t_min, ray.t_max);
                let test = |ray: &obvhs::ray::Ray, index: usize| self.triangles[index].intersect(ray);
                *hit = if any_hit {
                    any(self.tree.any(ray, test))
                } else {
                    self.tree.closest(ray, test).map_or(Hit::MISS, |found| {
                        let index = found.primitive_id as usize;
                        let uv = self.triangles[index].compute_barycentric(&ray);
                        let primitive = self.tree.primitives()[index];
                        Hit { mask: true, t: found.t, u: uv.x, v: uv.y, primitive, instance: 0 }
                    })
                };
            }
        });
    }
}

/// A tree of parry3d, and its triangles.
struct Parry {
    tree: ParryBvh,
    triangles: Vec<ParryTriangle>,
}

impl Parry {
    fn new(mesh: &Mesh, strategy: BvhBuildStrategy) -> Self {
        let point = |point: glam::Vec3| Vector::from_array(point.to_array());
        let triangles: Vec<_> =
            mesh.iter().map(|Triangle { v0, v1, v2 }| ParryTriangle::new(point(v0), point(v1), point(v2))).collect();
        let bounds: Vec<_> = triangles.iter().map(ParryTriangle::local_aabb).collect();
        Self { tree: ParryBvh::from_leaves(strategy, &bounds), triangles }
    }
}

impl Size for Parry {
    fn bytes(&self) -> Option<usize> {
        None
    }
}

impl Tracer for Parry {
    fn trace(&self, rays: &[Ray<f32>], any_hit: bool, hits: &mut [Hit<f32>]) {
        in_chunks(rays, hits, |rays, hits| {
            for (&Ray { origin, dir, t_min, t_max }, hit) in rays.iter().zip(hits) {
                let [origin, dir] = [origin, dir].map(|vector| Vector::from_array(vector.to_array()));
                let ray = parry3d::query::Ray::new(origin, dir);
                let test = |index: u32| {
                    let ParryTriangle { a, b, c } = self.triangles[index as usize];
                    let (found, weights) = local_ray_intersection_with_triangle(a, b, c, &ray)?;
                    Some((found.time_of_impact, weights))
                };
                // The crate's rays start at zero, so the interval is checked here.
                let in_interval = |index| test(index).map(|(t, _)| t).filter(|t| (t_min..=t_max).contains(t));
                let end = t_max.min(f32::MAX);
                *hit = if any_hit {
                    // No hit is closer than minus infinity, so the search ends.
                    let stop = |index, _| in_interval(index).map(|_| f32::NEG_INFINITY);
                    any(self.tree.cast_ray(&ray, end, stop).is_some())
                } else {
                    let found = self.tree.cast_ray(&ray, end, |index, _| in_interval(index));
                    found.and_then(|(index, _)| Some((index, test(index)?))).map_or(
                        Hit::MISS,
                        |(primitive, (t, weights))| Hit {
                            mask: true,
                            t,
                            u: weights.y,
                            v: weights.z,
                            primitive,
                            instance: 0,
                        },
                    )
                };
            }
        });
    }
}

/// A tree of the crate bvh. The crate's triangle test sees one side only. Its iterators do not know the end of a ray,
/// and cannot be told that a hit was found. So the triangle test and the traversal are ours, over the crate's nodes and
/// with its box test.
struct BvhCrate {
    tree: Bvh<f32, 3>,
    shapes: Vec<BvhShape>,
}

struct BvhShape {
    bounds: Aabb<f32, 3>,
    triangle: MollerTrumbore<f32>,
    node: usize,
}

impl Bounded<f32, 3> for BvhShape {
    fn aabb(&self) -> Aabb<f32, 3> {
        self.bounds
    }
}

impl BHShape<f32, 3> for BvhShape {
    fn set_bh_node_index(&mut self, node: usize) {
        self.node = node;
    }

    fn bh_node_index(&self) -> usize {
        self.node
    }
}

impl BvhCrate {
    fn new(mesh: &Mesh) -> Self {
        let shape = |triangle: Triangle| {
            let bounds = triangle.bounds();
            let [lo, hi] = [bounds.lo, bounds.hi].map(|corner| Point3::from(corner.to_array()));
            BvhShape { bounds: Aabb::with_bounds(lo, hi), triangle: MollerTrumbore::prepare(&triangle), node: 0 }
        };
        let mut shapes: Vec<_> = mesh.iter().map(shape).collect();
        Self { tree: Bvh::build_par(&mut shapes), shapes }
    }

    fn trace_one(&self, ray: &Ray<f32>, any_hit: bool, stack: &mut Vec<(usize, f32)>) -> Hit<f32> {
        // The constructor is not used, because it would normalise the direction.
        let direction = Vector3::from(ray.dir.to_array());
        let inv_direction = direction.map(f32::recip);
        let query = bvh::ray::Ray { origin: Point3::from(ray.origin.to_array()), direction, inv_direction };
        let mut ray = *ray;
        let mut best = Hit::MISS;
        stack.clear();
        stack.push((0, 0.0));
        while let Some((number, entry)) = stack.pop() {
            if entry > ray.t_max {
                continue;
            }
            match self.tree.nodes[number] {
                BvhNode::Leaf { shape_index, .. } => {
                    let hit = self.shapes[shape_index].triangle.hit(&ray);
                    if hit.mask && (!best.mask || hit.t < best.t) {
                        if any_hit {
                            return any(true);
                        }
                        best = Hit { primitive: shape_index as u32, ..hit };
                        ray.t_max = hit.t;
                    }
                }
                BvhNode::Node { child_l_index, ref child_l_aabb, child_r_index, ref child_r_aabb, .. } => {
                    let entry = |bounds| query.intersection_slice_for_aabb(bounds).map(|(entry, _)| entry);
                    match (entry(child_l_aabb), entry(child_r_aabb)) {
                        (Some(left), Some(right)) if left <= right => {
                            stack.extend([(child_r_index, right), (child_l_index, left)]);
                        }
                        (Some(left), Some(right)) => stack.extend([(child_l_index, left), (child_r_index, right)]),
                        (Some(left), None) => stack.push((child_l_index, left)),
                        (None, Some(right)) => stack.push((child_r_index, right)),
                        (None, None) => {}
                    }
                }
            }
        }
        best
    }
}

impl Size for BvhCrate {
    fn bytes(&self) -> Option<usize> {
        Some(size_of_val(&self.tree.nodes[..]) + size_of_val(&self.shapes[..]))
    }
}

impl Tracer for BvhCrate {
    fn trace(&self, rays: &[Ray<f32>], any_hit: bool, hits: &mut [Hit<f32>]) {
        in_chunks(rays, hits, |rays, hits| {
            let mut stack = Vec::new();
            for (ray, hit) in rays.iter().zip(hits) {
                *hit = self.trace_one(ray, any_hit, &mut stack);
            }
        });
    }
}
