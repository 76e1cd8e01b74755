//! The prepared triangles of a mesh with the tree over them, in the mesh's own coordinates; and the triangle tests
//! under the box rule that all walks share.

use wide::{f32x8, u32x8};

use crate::geom::{Candidate, Lanes, Ray, Triangle};
use crate::kernels::aabb::{InverseDirection, Slabs};
use crate::kernels::box_rule::{self, TInterval};
use crate::kernels::{Intersect, Kernel, Shape};
use crate::tracer::bvh::{Boxes, Bvh, Leaf};
use crate::tracer::meshes::Mesh;
use crate::tracer::walk::Counter;
use crate::tracer::walk::filter::{Filter, accepted};

/// A mesh, prepared for the kernel `K`.
#[derive(Debug)]
pub(crate) struct MeshTree<K: Kernel> {
    /// Its own list of leaves is empty; `leaves` replaces it.
    pub(super) bvh: Bvh,
    pub(super) leaves: Vec<LeafTriangles<K>>,
    /// For each leaf, the triangles' boxes. Empty if the kernel can compute them.
    boxes: Vec<Boxes>,
}

/// The triangles of a leaf.
#[derive(Debug)]
#[repr(align(64))]
pub(super) struct LeafTriangles<K: Kernel> {
    pub(super) prepared: K::Packet,
    pub(super) numbers: Leaf,
}

impl<K: Kernel<Shape = Triangle>> MeshTree<K> {
    /// Builds the tree and prepares the triangles, on all threads of the current rayon pool.
    pub(crate) fn new(mesh: &Mesh) -> Self {
        let mut bvh = Bvh::build(mesh.len(), |primitive| mesh.triangle(primitive).bounds());
        let leaves = std::mem::take(&mut bvh.leaves);
        Self::prepare(bvh, &leaves, mesh)
    }

    /// The same tree, with the mesh's triangles prepared for the kernel `L`.
    #[cfg(feature = "study")]
    pub(crate) fn prepared_for<L: Kernel<Shape = Triangle>>(&self, mesh: &Mesh) -> MeshTree<L> {
        let leaves: Vec<_> = self.leaves.iter().map(|leaf| leaf.numbers).collect();
        MeshTree::prepare(self.bvh.clone(), &leaves, mesh)
    }

    /// Prepares the triangles of a tree whose list of leaves is given apart.
    fn prepare(bvh: Bvh, numbers: &[Leaf], mesh: &Mesh) -> Self {
        use rayon::prelude::*;

        let triangle = |primitive| if primitive == Leaf::NONE { Triangle::MISSED } else { mesh.triangle(primitive) };
        let gather = |&numbers: &Leaf| LeafTriangles {
            prepared: K::gather(&numbers.0.map(|item| K::prepare(&triangle(item)))),
            numbers,
        };
        let leaves: Vec<_> = numbers.par_iter().map(gather).collect();
        let kernel_knows_boxes =
            leaves.first().is_none_or(|leaf: &LeafTriangles<K>| K::bounds(&leaf.prepared).is_some());
        let of_leaf = |leaf: &Leaf| Boxes::of_items(leaf, |primitive| mesh.triangle(primitive).bounds());
        let boxes = if kernel_knows_boxes { Vec::new() } else { numbers.par_iter().map(of_leaf).collect() };
        Self { bvh, leaves, boxes }
    }

    /// Bytes of nodes and prepared triangles, without the mesh.
    pub(crate) fn bytes(&self) -> usize {
        self.bvh.bytes() + size_of_val(&self.leaves[..]) + size_of_val(&self.boxes[..])
    }

    /// The boxes of a leaf's triangles. Boxes of unused slots are undefined.
    #[inline(always)]
    pub(super) fn boxes(&self, leaf: usize) -> Boxes {
        K::bounds(&self.leaves[leaf].prepared).map_or_else(|| self.boxes[leaf], Boxes::from)
    }

    /// The hits of one ray, splatted, with the triangles of a leaf, by the box rule.
    #[inline(always)]
    pub(super) fn test_all_triangles(
        &self,
        leaf: usize,
        ray: &Ray<f32x8>,
        setup: &<K as Intersect<f32x8>>::Setup,
        counter: &mut impl Counter,
        slabs: impl Fn() -> InverseDirection<f32x8>,
    ) -> Candidate<f32x8> {
        let LeafTriangles { prepared, numbers } = &self.leaves[leaf];
        let hit = prepared.candidate(ray, setup);
        let boxes = || self.boxes(leaf).slabs();
        counter.test(|| {
            let (inside, _) = TInterval::<f32x8>::of_each(&boxes(), ray.origin, &slabs());
            (inside.bits() & ((1 << numbers.len()) - 1)).count_ones()
        });
        if !hit.mask().any() {
            return hit;
        }
        box_rule::apply8(hit, &boxes(), ray.origin, &slabs()).of_primitives(u32x8::new(numbers.0))
    }

    /// The hits of a packet with one triangle that count, by the box rule; possibly in no lane. `None` if the kernel
    /// reports no hit. `boxes` are the leaf's boxes.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "eight rays, one triangle, and what they need")]
    pub(super) fn test_packet(
        &self,
        leaf: usize,
        slot: usize,
        boxes: &Boxes,
        ray: &Ray<f32x8>,
        setup: &Setup<K, f32x8>,
        filter: &impl Filter,
        counter: &mut impl Counter,
    ) -> Option<Candidate<f32x8>> {
        let LeafTriangles { prepared, numbers } = &self.leaves[leaf];
        let hit = K::candidate_in_lane(prepared, slot & 7, ray, &setup.kernel);
        counter.test(|| lanes_in_box(boxes, slot, ray, &setup.slabs));
        let apply = || apply_box_rule(hit, &boxes.lane(slot), numbers.0[slot & 7], ray, &setup.slabs);
        hit.mask().any().then(|| accepted(apply(), ray, filter))
    }
}

/// How many of eight rays hit the box of a triangle.
pub(super) fn lanes_in_box(boxes: &Boxes, slot: usize, ray: &Ray<f32x8>, setup: &InverseDirection<f32x8>) -> u32 {
    TInterval::<f32x8>::of(&boxes.lane(slot), ray.origin, setup).0.bits().count_ones()
}

/// Applies the box rule to the hits of a packet with one triangle.
#[inline(always)]
pub(super) fn apply_box_rule(
    hit: Candidate<f32x8>,
    bounds: &Slabs<f32>,
    primitive: u32,
    ray: &Ray<f32x8>,
    setup: &InverseDirection<f32x8>,
) -> Candidate<f32x8> {
    box_rule::apply8(hit, &bounds.widen(), ray.origin, setup).of_primitives(u32x8::splat(primitive))
}

/// Per-ray data of the slab test and of the kernel.
#[derive(Clone, Copy)]
pub(super) struct Setup<K: Intersect<L>, L: Lanes> {
    pub(super) slabs: InverseDirection<L>,
    pub(super) kernel: K::Setup,
}

impl<K: Intersect<f32>> Setup<K, f32> {
    #[inline(always)]
    pub(super) fn of(ray: &Ray<f32>) -> Self {
        Self { slabs: InverseDirection::<f32>::of(ray), kernel: K::setup(ray) }
    }
}

impl<K: Intersect<f32x8>> Setup<K, f32x8> {
    #[inline(always)]
    pub(super) fn of(ray: &Ray<f32x8>) -> Self {
        Self { slabs: InverseDirection::<f32x8>::of(ray), kernel: K::setup(ray) }
    }
}
