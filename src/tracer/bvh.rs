//! The bounding volume hierarchy: built by obvhs, stored in our own layout.
//!
//! A node holds the boxes of its two children, so that one cache line decides about both. Boxes are exact unions of
//! whole-triangle boxes; there are no spatial splits, since a clipped box could cull a candidate that counts
//! (see [`crate::tracer`]).

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

struct Bounds<'a>(&'a Mesh, u32);

impl Boundable for Bounds<'_> {
    fn aabb(&self) -> obvhs::aabb::Aabb {
        let Aabb { lo, hi } = self.0.triangle(self.1).bounds();
        obvhs::aabb::Aabb::new(lo.into(), hi.into())
    }
}

impl Bvh {
    /// A tree over the triangles of a mesh, which has at least one.
    pub(crate) fn build(mesh: &Mesh) -> Self {
        let triangles: Vec<_> = (0..mesh.len() as u32).map(|primitive| Bounds(mesh, primitive)).collect();
        let params = BvhBuildParams {
            // Packets test a few triangles faster than the boxes of more nodes.
            max_prims_per_leaf: 4,
            // obvhs' presets look only at direct neighbours on the first levels. On a regular grid all of those tie, and the
            // tree degenerates: 230 triangle tests per ray of the built-in room instead of 4. The build takes a third longer.
            search_depth_threshold: 0,
            ..BvhBuildParams::medium_build()
        };
        Self::pack(&build_bvh2(&triangles, params, &mut Default::default()))
    }

    /// Copies the tree depth first, so that a node's first child follows it.
    fn pack(source: &Bvh2) -> Self {
        let mut nodes = vec![Node { bounds: [empty(); 2], first: [0; 2], count: [0; 2] }];
        let root = &source.nodes[0];
        if root.is_leaf() {
            nodes[0].bounds[0] = slabs(root.aabb());
            (nodes[0].first[0], nodes[0].count[0]) = (root.first_index, root.prim_count);
        } else {
            // (our node, first of the two obvhs nodes that are its children)
            let mut open = vec![(0, root.first_index as usize)];
            while let Some((parent, children)) = open.pop() {
                for side in [1, 0] {
                    let child = &source.nodes[children + side];
                    nodes[parent].bounds[side] = slabs(child.aabb());
                    nodes[parent].count[side] = child.prim_count;
                    nodes[parent].first[side] = if child.is_leaf() {
                        child.first_index
                    } else {
                        let number = nodes.len();
                        nodes.push(nodes[0]);
                        open.push((number, child.first_index as usize));
                        number as u32
                    };
                }
            }
        }
        Self { nodes, primitive_of_slot: source.primitive_indices.clone() }
    }
}

fn slabs(bounds: &obvhs::aabb::Aabb) -> Slabs<f32> {
    Slabs { lo: bounds.min.into(), hi: bounds.max.into() }
}

/// The box of a child that is not there: no ray hits it.
fn empty() -> Slabs<f32> {
    Slabs { lo: Aabb::EMPTY.lo, hi: Aabb::EMPTY.hi }
}
