//! Improving a binary tree: subtrees are taken out and inserted again where that makes the boxes smaller.
//!
//! **Source:** D. Meister, J. Bittner, "Parallel Reinsertion for Bounding Volume Hierarchy Optimization", 2018; the
//! choice of candidates after the crate obvhs.
//!
//! **Differs from the paper:** a search ends after [`MAX_VISITS`] nodes, since among equal boxes no bound ends it. A
//! move that would make the tree deeper than [`MAX_DEPTH`] is not made.

use rayon::prelude::*;

use super::binary::{BinaryNode, BinaryTree, Content, half_area};
use super::split::MAX_DEPTH;

/// The most nodes that the search for a place visits. With ten times as many, trees of real meshes are no better.
const MAX_VISITS: usize = 100;

/// Shares of the nodes that are tried, in two rounds of sixteen passes each. The later passes of a round try only nodes
/// with large boxes.
const SHARES: [f64; 2] = [0.05, 0.1];
const PASSES: usize = 16;

/// A subtree that is better off elsewhere.
#[derive(Clone, Copy, Debug)]
struct Move {
    from: u32,
    /// It becomes the sibling of this node.
    to: u32,
    /// By how much the areas of all boxes together decrease.
    gain: f64,
}

/// A tree with what is needed to move subtrees.
struct Reinsertion<'a> {
    nodes: &'a mut [BinaryNode],
    parents: Vec<u32>,
    /// For each node, the length of the longest path down to a leaf.
    heights: Vec<u8>,
    /// Nodes that a move of this pass has changed.
    touched: Vec<bool>,
}

/// Improves the tree.
pub(super) fn reinsert(tree: &mut BinaryTree) {
    let count = tree.nodes.len();
    if count < 5 {
        return;
    }
    let mut parents = vec![0; count];
    let mut heights = vec![0; count];
    // Children come after their parents.
    for index in (0..count).rev() {
        if let Content::Children(first) = tree.nodes[index].content() {
            let first = first as usize;
            parents[first..first + 2].fill(index as u32);
            heights[index] = 1 + heights[first].max(heights[first + 1]);
        }
    }
    let mut reinsertion = Reinsertion { nodes: &mut tree.nodes, parents, heights, touched: vec![false; count] };
    for share in SHARES {
        let tried = count as f64 * share;
        let pool = reinsertion.largest(1..count as u32, 2.0 * tried);
        for pass in 0..PASSES {
            let candidates = reinsertion.largest(pool.iter().copied(), tried / (2 * pass + 1) as f64);
            reinsertion.pass(&candidates);
        }
    }
}

fn sibling(node: u32) -> u32 {
    // The first sibling has an odd index.
    ((node - 1) ^ 1) + 1
}

impl Reinsertion<'_> {
    /// The `count` nodes with the largest boxes, at least one, in no particular order.
    fn largest(&self, nodes: impl Iterator<Item = u32>, count: f64) -> Vec<u32> {
        let mut nodes: Vec<_> = nodes.map(|node| (self.area(node), node)).collect();
        let count = (count as usize).max(1);
        if count < nodes.len() {
            nodes.select_nth_unstable_by(count, |a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
            nodes.truncate(count);
        }
        nodes.into_iter().map(|(_, node)| node).collect()
    }

    /// Tries to move the subtrees at these nodes.
    fn pass(&mut self, candidates: &[u32]) {
        let mut moves: Vec<_> = candidates.par_iter().filter_map(|&node| self.best_move(node)).collect();
        moves.par_sort_unstable_by(|a, b| b.gain.total_cmp(&a.gain).then(a.from.cmp(&b.from)));
        self.touched.fill(false);
        for one in moves {
            self.apply(one);
        }
    }

    fn area(&self, node: u32) -> f64 {
        half_area(&self.nodes[node as usize].bounds)
    }

    fn parent(&self, node: u32) -> u32 {
        self.parents[node as usize]
    }

    /// The best place for a subtree, if it is better than where it is. Not for the root.
    fn best_move(&self, from: u32) -> Option<Move> {
        let bounds = self.nodes[from as usize].bounds;
        let (area, parent) = (half_area(&bounds), self.parent(from));
        let mut best = Move { from, to: 0, gain: 0.0 };
        // What taking out the subtree gains, in its ancestors up to `pivot`.
        let mut gain = self.area(parent);
        let mut pivot = parent;
        let mut other = sibling(from);
        // A box around what remains below the pivot.
        let mut remains = self.nodes[other as usize].bounds;
        let mut visits = 0;
        let mut open = Vec::with_capacity(64);
        loop {
            open.push((gain, other));
            while let Some((gain, node)) = open.pop() {
                if gain - area <= best.gain || visits == MAX_VISITS {
                    continue;
                }
                visits += 1;
                let node_bounds = &self.nodes[node as usize].bounds;
                let gain = gain - half_area(&node_bounds.around(&bounds));
                if gain > best.gain {
                    best = Move { to: node, gain, ..best };
                }
                if let Content::Children(first) = self.nodes[node as usize].content() {
                    let gain = gain + half_area(node_bounds);
                    open.extend([(gain, first), (gain, first + 1)]);
                }
            }
            if pivot != parent {
                remains = remains.around(&self.nodes[other as usize].bounds);
                gain += self.area(pivot) - half_area(&remains);
            }
            if pivot == 0 || visits == MAX_VISITS {
                break;
            }
            other = sibling(pivot);
            pivot = self.parent(pivot);
        }
        (best.to != 0 && best.to != sibling(from) && best.to != parent).then_some(best)
    }

    /// Makes a move, unless another move of this pass has changed the nodes that it changes or has brought the target
    /// into the subtree, or the tree would become too deep.
    fn apply(&mut self, Move { from, to, .. }: Move) {
        let parent = self.parent(from);
        let changed = [to, from, sibling(from), self.parent(to), parent];
        if changed.iter().any(|&node| self.touched[node as usize]) {
            return;
        }
        let height = 1 + self.heights[from as usize].max(self.heights[to as usize]);
        if self.depth_outside(to, from).is_none_or(|depth| depth + u32::from(height) > MAX_DEPTH) {
            return;
        }
        for node in changed {
            self.touched[node as usize] = true;
        }
        let sibling = sibling(from);
        let (moved, target) = (self.nodes[sibling as usize], self.nodes[to as usize]);
        // The sibling takes the place of the parent. The target takes the place of the sibling, and the pair of target
        // and subtree the place of the target.
        self.nodes[to as usize] = BinaryNode::of_children(from.min(sibling), target.bounds);
        self.place(sibling, target);
        self.place(parent, moved);
        self.parents[sibling as usize] = to;
        self.parents[from as usize] = to;
        self.refit(to);
        self.refit(parent);
    }

    /// Depth of a node; `None` if it is below `subtree`.
    fn depth_outside(&self, mut node: u32, subtree: u32) -> Option<u32> {
        let mut depth = 0;
        while node != 0 {
            if node == subtree {
                return None;
            }
            node = self.parent(node);
            depth += 1;
        }
        Some(depth)
    }

    /// Puts a node with what is below it at an index.
    fn place(&mut self, index: u32, node: BinaryNode) {
        self.nodes[index as usize] = node;
        self.heights[index as usize] = match node.content() {
            Content::Item(_) => 0,
            Content::Children(first) => {
                self.parents[first as usize..first as usize + 2].fill(index);
                1 + self.heights[first as usize].max(self.heights[first as usize + 1])
            }
        };
    }

    /// Computes the boxes and heights of a node and its ancestors anew.
    fn refit(&mut self, mut node: u32) {
        loop {
            if let Content::Children(first) = self.nodes[node as usize].content() {
                let first = first as usize;
                let bounds = self.nodes[first].bounds.around(&self.nodes[first + 1].bounds);
                self.nodes[node as usize].bounds = bounds;
                self.heights[node as usize] = 1 + self.heights[first].max(self.heights[first + 1]);
            }
            if node == 0 {
                return;
            }
            node = self.parent(node);
        }
    }
}
