//! One mesh's prepared triangles and the tree over them, in the mesh's own coordinates.

use wide::{f32x8, u32x8};

use super::Mesh;
use super::box_rule::Span;
use super::bvh::Bvh;
use super::traverse::{Room, Visit, keep_closer8};
use crate::geom::{Hit, Lanes, Mask8, Ray, Triangle};
use crate::kernels::aabb::{InverseDirection, Slabs};
use crate::kernels::{Intersect, Kernel};

/// What the kernel `K` needs to trace a mesh. The mesh itself stays where it is, and is handed to every call.
#[derive(Debug)]
pub(super) struct MeshTree<K> {
    bvh: Bvh,
    /// In slot order.
    prepared: Vec<K>,
}

impl<K: Kernel<Shape = Triangle>> MeshTree<K> {
    /// Builds the tree and prepares the triangles, on all threads of the current rayon pool.
    pub(super) fn new(mesh: &Mesh) -> Self {
        use rayon::prelude::*;

        // Packets test a few triangles faster than the boxes of more nodes.
        let bvh = Bvh::build(mesh.len(), 4, |primitive| mesh.triangle(primitive).bounds());
        let prepared = bvh.item_of_slot.par_iter().map(|&primitive| K::prepare(&mesh.triangle(primitive))).collect();
        Self { bvh, prepared }
    }

    /// Bytes of nodes and prepared triangles, without the mesh.
    pub(super) fn bytes(&self) -> usize {
        self.bvh.bytes() + size_of_val(&self.prepared[..])
    }

    /// The closest hit, if its `t` is at most `farthest`; else that, or a hit beyond `farthest`, or a miss. As a call it
    /// would be a tenth slower for single rays.
    #[inline(always)]
    pub(super) fn closest_hit(
        &self,
        mesh: &Mesh,
        ray: &Ray<f32>,
        farthest: f32,
        room: &mut Room<Visit<f32>>,
    ) -> Hit<f32> {
        let setup = Setup::<K, f32>::of(ray);
        let nothing = Hit { t: farthest, ..Hit::MISS };
        self.bvh.closest_hit(ray, &setup.slabs, nothing, room, |slot, best| {
            if let Some(candidate) = self.candidate(mesh, slot, ray, &setup)
                && candidate.is_closer_than(best)
            {
                *best = candidate;
            }
        })
    }

    /// Whether there is a hit.
    pub(super) fn any_hit(&self, mesh: &Mesh, ray: &Ray<f32>) -> bool {
        let setup = Setup::<K, f32>::of(ray);
        self.bvh.any_hit(ray, &setup.slabs, |slot| self.candidate(mesh, slot, ray, &setup).is_some())
    }

    /// [`MeshTree::closest_hit`] in eight lanes.
    #[inline(always)]
    pub(super) fn closest_hit8(
        &self,
        mesh: &Mesh,
        ray: &Ray<f32x8>,
        farthest: f32x8,
        room: &mut Room<Visit<f32x8>>,
    ) -> Hit<f32x8> {
        let setup = Setup::<K, f32x8>::of(ray);
        let mut nothing = Hit::<f32x8>::miss();
        nothing.t = farthest;
        self.bvh.closest_hit8(ray, &setup.slabs, nothing, room, |slot, best| {
            if let Some(candidate) = self.candidate8(mesh, slot, ray, &setup) {
                keep_closer8(best, &candidate);
            }
        })
    }

    /// [`MeshTree::any_hit`] in eight lanes.
    pub(super) fn any_hit8(&self, mesh: &Mesh, ray: &Ray<f32x8>) -> Mask8 {
        let setup = Setup::<K, f32x8>::of(ray);
        self.bvh.any_hit8(ray, &setup.slabs, |slot, _| Some(self.candidate8(mesh, slot, ray, &setup)?.mask))
    }

    /// The closest hit by trying every triangle, in any order.
    pub(super) fn closest_hit_brute_force(&self, mesh: &Mesh, ray: &Ray<f32>) -> Hit<f32> {
        let setup = Setup::<K, f32>::of(ray);
        (0..self.prepared.len())
            .filter_map(|slot| self.candidate(mesh, slot, ray, &setup))
            .fold(Hit::MISS, |best, candidate| if candidate.is_closer_than(&best) { candidate } else { best })
    }

    /// The triangle in a slot, by the box rule.
    #[inline(always)]
    fn candidate(&self, mesh: &Mesh, slot: usize, ray: &Ray<f32>, setup: &Setup<K, f32>) -> Option<Hit<f32>> {
        let hit = self.prepared[slot].closest_hit(ray, &setup.kernel);
        if !hit.mask {
            return None;
        }
        let (primitive, bounds) = self.own_box(mesh, slot);
        let span = Span::<f32>::of(&bounds, ray.origin, &setup.slabs)?;
        Some(Hit { t: span.clamp(hit.t), primitive, ..hit })
    }

    /// [`MeshTree::candidate`] in eight lanes. Lanes that miss hold anything, not the fixed content of a miss.
    #[inline(always)]
    fn candidate8(&self, mesh: &Mesh, slot: usize, ray: &Ray<f32x8>, setup: &Setup<K, f32x8>) -> Option<Hit<f32x8>> {
        let hit = Intersect::<f32x8>::closest_hit(&self.prepared[slot], ray, &setup.kernel);
        if !hit.mask.any() {
            return None;
        }
        let (primitive, bounds) = self.own_box(mesh, slot);
        let (inside, span) = Span::<f32x8>::of(&bounds, ray.origin, &setup.slabs);
        Some(Hit {
            mask: hit.mask & inside,
            t: span.clamp(hit.t),
            u: hit.u,
            v: hit.v,
            primitive: u32x8::splat(primitive),
            instance: hit.instance,
        })
    }

    /// The primitive in a slot, and the box of its triangle.
    #[inline(always)]
    fn own_box(&self, mesh: &Mesh, slot: usize) -> (u32, Slabs<f32>) {
        let primitive = self.bvh.item_of_slot[slot];
        (primitive, mesh.triangle(primitive).bounds().into())
    }
}

/// The per-ray data of the tree and of the kernel.
struct Setup<K: Intersect<L>, L: Lanes> {
    slabs: InverseDirection<L>,
    kernel: K::Setup,
}

impl<K: Intersect<f32>> Setup<K, f32> {
    #[inline(always)]
    fn of(ray: &Ray<f32>) -> Self {
        Self { slabs: InverseDirection::<f32>::of(ray), kernel: K::setup(ray) }
    }
}

impl<K: Intersect<f32x8>> Setup<K, f32x8> {
    #[inline(always)]
    fn of(ray: &Ray<f32x8>) -> Self {
        Self { slabs: InverseDirection::<f32x8>::of(ray), kernel: K::setup(ray) }
    }
}
