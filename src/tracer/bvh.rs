//! The bounding volume hierarchy: built by obvhs, stored in our own layout.
//!
//! A tree is over items that have boxes: triangles, or instances. A node holds the boxes of its two children, so that one
//! cache line decides about both. Boxes are exact unions of the boxes of whole items; there are no spatial splits, since a
//! clipped box could cull a candidate that counts (see [`crate::tracer`]).

use glam::Vec3;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{Boundable, BvhBuildParams};

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

/// A tree over items. Leaves name ranges of *slots*; `item_of_slot` says which item is in a slot.
#[derive(Debug)]
pub(crate) struct Bvh {
    /// Parents before children; the root is number 0.
    pub(crate) nodes: Vec<Node>,
    /// A permutation of the items' numbers.
    pub(crate) item_of_slot: Vec<u32>,
}

/// The box of an item, moved and scaled into the unit cube: obvhs computes areas in `f32`, and panics where they overflow
/// or underflow. Only the shape of the tree comes from these boxes.
struct UnitBox(obvhs::aabb::Aabb);

impl Boundable for UnitBox {
    fn aabb(&self) -> obvhs::aabb::Aabb {
        self.0
    }
}

fn unit_boxes(count: usize, bounds_of: impl Fn(u32) -> Aabb) -> Vec<UnitBox> {
    let Aabb { lo, hi } = (0..count as u32).fold(Aabb::EMPTY, |bounds, item| bounds.union(&bounds_of(item)));
    // A side may be infinite.
    let finite = |point: Vec3| point.clamp(Vec3::MIN, Vec3::MAX).as_dvec3();
    let (least, extent) = (finite(lo), (finite(hi) - finite(lo)).max_element());
    let scale = if extent > 0.0 { 1.0 / extent } else { 0.0 };
    let place = |point: Vec3| ((finite(point) - least) * scale).as_vec3a();
    (0..count as u32)
        .map(|item| {
            let Aabb { lo, hi } = bounds_of(item);
            UnitBox(obvhs::aabb::Aabb::new(place(lo), place(hi)))
        })
        .collect()
}

impl Bvh {
    /// Memory that it takes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.item_of_slot[..])
    }

    /// A tree over `count` items, at least one, of which no leaf has more than `leaf`. Their boxes are not empty.
    pub(crate) fn build(count: usize, leaf: u32, bounds_of: impl Fn(u32) -> Aabb) -> Self {
        let params = BvhBuildParams {
            max_prims_per_leaf: leaf,
            // obvhs' presets look only at direct neighbours on the first levels. On a regular grid all of those tie, and the
            // tree degenerates: 230 triangle tests per ray of the built-in room instead of 4. The build takes a third longer.
            search_depth_threshold: 0,
            ..BvhBuildParams::medium_build()
        };
        let mut bvh = Self::pack(&build_bvh2(&unit_boxes(count, &bounds_of), params, &mut Default::default()));
        bvh.fit(bounds_of);
        bvh
    }

    /// Copies the tree depth first, without boxes.
    fn pack(source: &Bvh2) -> Self {
        let absent = Node { bounds: [Aabb::EMPTY.into(); 2], first: [0; 2], count: [0; 2] };
        // Two of theirs, less the root, are one of ours: a growing vector would take up to twice as much.
        let mut nodes = Vec::with_capacity(source.nodes.len() / 2 + 1);
        nodes.push(absent);
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
        Self { nodes, item_of_slot: source.primitive_indices.clone() }
    }

    /// Computes every box as the exact union of the boxes of the items below it.
    fn fit(&mut self, bounds_of: impl Fn(u32) -> Aabb) {
        // Children come after their parents.
        for number in (0..self.nodes.len()).rev() {
            for side in [0, 1] {
                let Node { first, count, .. } = self.nodes[number];
                let (first, count) = (first[side] as usize, count[side] as usize);
                let bounds = if count > 0 {
                    self.item_of_slot[first..first + count]
                        .iter()
                        .fold(Aabb::EMPTY, |bounds, &item| bounds.union(&bounds_of(item)))
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
