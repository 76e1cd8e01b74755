//! Building a tree: `split` makes one with two children per node, `reinsert` improves it, `collapse` makes eight of
//! two, and the boxes are computed anew.

use super::boxes::Boxes;
use super::collapse::{Collapse, Costs, slots};
use super::leaf::Leaf;
use super::reinsert::reinsert;
use super::split::split;
use super::tree::{Bvh, Child, Extent, Node};
use crate::geom::Aabb;

/// A leaf costs as much as a node: testing eight triangles takes as long as testing eight boxes. Items have a small
/// cost of their own, since packets test them one by one. Leaf costs of 0.5 and 1.5 made nothing faster by more than
/// the noise. An item cost of 0.15 made shadow rays in a closed room 1.13 times as fast, and primary rays on small
/// triangles 0.87 to 0.93 times.
const COSTS: Costs = Costs { node: 1.0, leaf: 1.0, item: 0.05 };

impl Bvh {
    /// Builds a tree over `count` items, at least one. Their boxes must not be empty.
    pub(crate) fn build(count: usize, bounds_of: impl Fn(u32) -> Aabb + Sync) -> Self {
        let mut source = split(count, &bounds_of);
        reinsert(&mut source);
        let mut bvh = Self::pack(&Collapse::new(&source, COSTS));
        bvh.fit(bounds_of, count);
        bvh
    }

    /// Copies the collapsed tree depth first, without boxes.
    fn pack(plan: &Collapse<'_>) -> Self {
        let no_boxes = Boxes::new([Aabb::EMPTY; 8]);
        let extent = Extent { bounds: Aabb::EMPTY, smallest_leaf: f32::INFINITY };
        let mut bvh = Self { nodes: Vec::new(), leaves: Vec::new(), root: Child::NONE, extent, item_size: 0.0 };
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

    /// Computes every box as the exact union of the boxes of the items below it, and the sizes of leaves and items.
    fn fit(&mut self, bounds_of: impl Fn(u32) -> Aabb, count: usize) {
        self.item_size = item_size(count, &bounds_of);
        let union = |bounds: Aabb, item| bounds.around(&bounds_of(item));
        self.extent.bounds = (0..count as u32).fold(Aabb::EMPTY, union);
        // Children come after their parents.
        for number in (0..self.nodes.len()).rev() {
            let boxes = self.nodes[number].children.map(|child| match child.leaf() {
                Ok(leaf) => {
                    let bounds = self.leaves[leaf].numbers().fold(Aabb::EMPTY, union);
                    let size = bounds.diagonal() as f32;
                    if size > 0.0 {
                        self.extent.smallest_leaf = self.extent.smallest_leaf.min(size);
                    }
                    bounds
                }
                Err(0) => Aabb::EMPTY,
                Err(node) => self.nodes[node].boxes.union(),
            });
            self.nodes[number].boxes = Boxes::new(boxes);
        }
    }
}

/// Mean length of the items' diagonals, or eight times the median if that is less.
fn item_size(count: usize, bounds_of: impl Fn(u32) -> Aabb) -> f32 {
    let mut sizes: Vec<_> = (0..count as u32).map(|item| bounds_of(item).diagonal()).collect();
    let mean = sizes.iter().sum::<f64>() / count as f64;
    let (_, &mut median, _) = sizes.select_nth_unstable_by(count / 2, f64::total_cmp);
    mean.min(8.0 * median) as f32
}
