//! Building a tree: obvhs makes one with two children per node, `collapse` makes eight of two, and the boxes are
//! computed anew.

use glam::Vec3;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::ploc::PlocSearchDistance;
use obvhs::{Boundable, BvhBuildParams};

use super::boxes::Boxes;
use super::collapse::{Collapse, Costs, slots};
use super::leaf::Leaf;
use super::tree::{Bvh, Child, Node};
use crate::geom::Aabb;

/// The box of an item, moved and scaled into the unit cube. obvhs computes areas in `f32` and panics where they
/// overflow or underflow. Only the shape of the tree depends on these boxes.
struct UnitBox(obvhs::aabb::Aabb);

impl Boundable for UnitBox {
    fn aabb(&self) -> obvhs::aabb::Aabb {
        self.0
    }
}

fn unit_boxes(bounds: &Aabb, count: usize, bounds_of: impl Fn(u32) -> Aabb) -> Vec<UnitBox> {
    // A side of the box may be infinite.
    let finite = |point: Vec3| point.clamp(Vec3::MIN, Vec3::MAX).as_dvec3();
    let (least, extent) = (finite(bounds.lo), (finite(bounds.hi) - finite(bounds.lo)).max_element());
    let scale = if extent > 0.0 { 1.0 / extent } else { 0.0 };
    let place = |point: Vec3| ((finite(point) - least) * scale).as_vec3a();
    (0..count as u32)
        .map(|item| {
            let Aabb { lo, hi } = bounds_of(item);
            UnitBox(obvhs::aabb::Aabb::new(place(lo), place(hi)))
        })
        .collect()
}

/// A leaf costs as much as a node: testing eight triangles takes as long as testing eight boxes. Items have a small
/// cost of their own, since packets test them one by one. Leaf costs of 0.5 and 1.5 made nothing faster by more than
/// the noise. An item cost of 0.15 made shadow rays in a closed room 1.13 times as fast, and primary rays on small
/// triangles 0.87 to 0.93 times.
const COSTS: Costs = Costs { node: 1.0, leaf: 1.0, item: 0.05 };

impl Bvh {
    /// Builds a tree over `count` items, at least one. Their boxes must not be empty.
    pub(crate) fn build(count: usize, bounds_of: impl Fn(u32) -> Aabb) -> Self {
        let params = BvhBuildParams {
            max_prims_per_leaf: 1,
            // The presets of obvhs look only at direct neighbours on the first levels. On a regular grid these all tie,
            // and the tree degenerates: 230 triangle tests per ray of the built-in room instead of 4. This setting
            // takes a third longer.
            search_depth_threshold: 0,
            // 5 % fewer nodes per ray of closed rooms than with the preset, for the least build time of all settings.
            // Reinsertion of 30 % of the nodes saves another 2 %, and makes the build 2.2 times as long.
            ploc_search_distance: PlocSearchDistance::VeryHigh,
            ..BvhBuildParams::medium_build()
        };
        let bounds = (0..count as u32).fold(Aabb::EMPTY, |bounds, item| bounds.union(&bounds_of(item)));
        let source = build_bvh2(&unit_boxes(&bounds, count, &bounds_of), params, &mut Default::default());
        let mut bvh = Self::pack(&Collapse::new(&source, COSTS), bounds);
        bvh.fit(bounds_of, count);
        bvh
    }

    /// Copies the collapsed tree depth first, without boxes.
    fn pack(plan: &Collapse<'_>, bounds: Aabb) -> Self {
        let no_boxes = Boxes::new([Aabb::EMPTY; 8]);
        let mut bvh = Self { nodes: Vec::new(), leaves: Vec::new(), root: Child::NONE, bounds, item_size: 0.0 };
        // (node of the binary tree, its parent here and the slot there)
        let mut open = vec![(0, None)];
        while let Some((number, parent)) = open.pop() {
            let child = if let Some(items) = plan.leaf(number) {
                let mut leaf = Leaf([Leaf::NONE; 8]);
                leaf.0[..items.len()].copy_from_slice(&items);
                bvh.leaves.push(leaf);
                Child::of_leaf(bvh.leaves.len() - 1)
            } else {
                let index = bvh.nodes.len();
                bvh.nodes.push(Node { boxes: no_boxes, children: [Child::NONE; 8] });
                let children = plan.children(number);
                let middles: Vec<_> = children.iter().map(|&child| plan.middle(child)).collect();
                for (slot, child) in slots(&middles).into_iter().enumerate().rev() {
                    open.extend(child.map(|child| (children[child], Some((index, slot)))));
                }
                Child::of_node(index)
            };
            match parent {
                Some((parent, slot)) => bvh.nodes[parent].children[slot] = child,
                None => bvh.root = child,
            }
        }
        bvh.nodes.shrink_to_fit();
        bvh.leaves.shrink_to_fit();
        bvh
    }

    /// Computes every box as the exact union of the boxes of the items below it, and the mean item size.
    fn fit(&mut self, bounds_of: impl Fn(u32) -> Aabb, count: usize) {
        let size = (0..count as u32).map(|item| f64::from(bounds_of(item).extent().length())).sum::<f64>();
        self.item_size = (size / count as f64) as f32;
        let union = |bounds: Aabb, item| bounds.union(&bounds_of(item));
        // Children come after their parents.
        for number in (0..self.nodes.len()).rev() {
            let boxes = self.nodes[number].children.map(|child| match child.leaf() {
                Ok(leaf) => self.leaves[leaf].numbers().fold(Aabb::EMPTY, union),
                Err(0) => Aabb::EMPTY,
                Err(node) => self.nodes[node].boxes.union(),
            });
            self.nodes[number].boxes = Boxes::new(boxes);
        }
    }
}
