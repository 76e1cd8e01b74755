//! The bounding volume hierarchy: built by obvhs, stored in our own layout.
//!
//! A node holds the boxes of its two children, so that one cache line decides about both. Boxes are exact unions of
//! whole-triangle boxes; there are no spatial splits, since a clipped box could cull a candidate that counts
//! (see [`crate::tracer`]).

use glam::Vec3;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{Boundable, BvhBuildParams};

use super::Mesh;
use crate::geom::Aabb;
use crate::kernels::aabb::Slabs;

/// Two children: 64 bytes, one cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Node {
    /// Their boxes.
    pub(crate) bounds: [Slabs<f32>; 2],
    /// For an inner node its number, for a leaf its first slot.
    pub(crate) first: [u32; 2],
    /// Slots of a leaf; 0 for an inner node.
    pub(crate) count: [u32; 2],
}

/// A tree over primitives. Leaves name ranges of *slots*; `primitive_of_slot` says which primitive is in a slot.
#[derive(Debug)]
pub(crate) struct Bvh {
    /// Parents before children; the root is number 0.
    pub(crate) nodes: Vec<Node>,
    /// A permutation of the primitive numbers.
    pub(crate) primitive_of_slot: Vec<u32>,
}

/// The box of a triangle, moved and scaled into the unit cube: obvhs computes areas in `f32`, and panics where they overflow
/// or underflow. Only the shape of the tree comes from these boxes.
struct UnitBox(obvhs::aabb::Aabb);

impl Boundable for UnitBox {
    fn aabb(&self) -> obvhs::aabb::Aabb {
        self.0
    }
}

fn unit_boxes(mesh: &Mesh) -> Vec<UnitBox> {
    let Aabb { lo, hi } = mesh.bounds();
    let (least, extent) = (lo.as_dvec3(), (hi.as_dvec3() - lo.as_dvec3()).max_element());
    let scale = if extent > 0.0 { 1.0 / extent } else { 0.0 };
    let place = |point: Vec3| ((point.as_dvec3() - least) * scale).as_vec3a();
    mesh.iter()
        .map(|triangle| {
            let Aabb { lo, hi } = triangle.bounds();
            UnitBox(obvhs::aabb::Aabb::new(place(lo), place(hi)))
        })
        .collect()
}

impl Bvh {
    /// A tree over the triangles of a mesh, which has at least one.
    pub(crate) fn build(mesh: &Mesh) -> Self {
        let params = BvhBuildParams {
            // Packets test a few triangles faster than the boxes of more nodes.
            max_prims_per_leaf: 4,
            // obvhs' presets look only at direct neighbours on the first levels. On a regular grid all of those tie, and the
            // tree degenerates: 230 triangle tests per ray of the built-in room instead of 4. The build takes a third longer.
            search_depth_threshold: 0,
            ..BvhBuildParams::medium_build()
        };
        let mut bvh = Self::pack(&build_bvh2(&unit_boxes(mesh), params, &mut Default::default()));
        bvh.fit(mesh);
        bvh
    }

    /// Copies the tree depth first, without boxes.
    fn pack(source: &Bvh2) -> Self {
        let absent = Node { bounds: [Aabb::EMPTY.into(); 2], first: [0; 2], count: [0; 2] };
        let mut nodes = vec![absent];
        let root = &source.nodes[0];
        if root.is_leaf() {
            // The second child stays an empty box, which no ray hits.
            (nodes[0].first[0], nodes[0].count[0]) = (root.first_index, root.prim_count);
        } else {
            // (our node, first of the two obvhs nodes that are its children)
            let mut open = vec![(0, root.first_index as usize)];
            while let Some((parent, children)) = open.pop() {
                for side in [1, 0] {
                    let child = &source.nodes[children + side];
                    nodes[parent].count[side] = child.prim_count;
                    nodes[parent].first[side] = if child.is_leaf() {
                        child.first_index
                    } else {
                        nodes.push(absent);
                        open.push((nodes.len() - 1, child.first_index as usize));
                        (nodes.len() - 1) as u32
                    };
                }
            }
        }
        Self { nodes, primitive_of_slot: source.primitive_indices.clone() }
    }

    /// Computes every box as the exact union of the boxes of the triangles below it.
    fn fit(&mut self, mesh: &Mesh) {
        // Children come after their parents.
        for number in (0..self.nodes.len()).rev() {
            for side in [0, 1] {
                let Node { first, count, .. } = self.nodes[number];
                let (first, count) = (first[side] as usize, count[side] as usize);
                let bounds = if count > 0 {
                    self.primitive_of_slot[first..first + count]
                        .iter()
                        .fold(Aabb::EMPTY, |bounds, &primitive| bounds.union(&mesh.triangle(primitive).bounds()))
                } else if first > number {
                    let [left, right] = self.nodes[first].bounds.map(|slabs| Aabb { lo: slabs.lo, hi: slabs.hi });
                    left.union(&right)
                } else {
                    Aabb::EMPTY
                };
                self.nodes[number].bounds[side] = bounds.into();
            }
        }
    }
}
