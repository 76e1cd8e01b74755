//! Collapsing a binary tree to eight children per node: which of its nodes to keep.
//!
//! **Source:** H. Ylitie, T. Karras, S. Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide
//! BVHs", 2017. Dynamic programming over the binary tree finds the wide tree of least expected cost. Each child gets
//! the slot of the octant that it lies in, seen from the middle of the node. A packet that visits slots in the order of
//! `slot ^ octant of its direction` then visits them roughly front to back, without comparing distances. (Single rays
//! do compare: on closed rooms the order of octants alone made their primary rays 0.55 times as fast.)

use glam::Vec3;

use super::binary::{BinaryTree, Content, half_area};

/// Relative costs of visiting a node, a leaf, and an item in a leaf.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Costs {
    pub(crate) node: f32,
    pub(crate) leaf: f32,
    pub(crate) item: f32,
}

/// The plan for a node of the binary tree.
#[derive(Clone, Copy, Default)]
struct Plan {
    /// Least cost of the items below it as a forest of at most 1, 2, … 7 trees.
    cost: [f32; 7],
    /// In a forest of at most 1, 2, … 8 trees, how many the left child gets; 0 where one tree fewer costs no more. The
    /// first entry is 1 for a leaf and 0 for a node.
    left: [u8; 8],
    /// Number of items below it; 9 if there are too many for a leaf.
    items: u8,
}

/// The plans for all nodes of a binary tree.
pub(crate) struct Collapse<'a> {
    source: &'a BinaryTree,
    plans: Vec<Plan>,
}

impl<'a> Collapse<'a> {
    pub(crate) fn new(source: &'a BinaryTree, costs: Costs) -> Self {
        let mut order = Vec::with_capacity(source.nodes.len());
        let mut open = vec![0];
        while let Some(number) = open.pop() {
            order.push(number);
            if let Content::Children(first) = source.nodes[number as usize].content() {
                open.extend([first, first + 1]);
            }
        }
        // Relative to the root's, an area vanishes in `f32` only if the box is 1e19 times smaller. Boxes of no area
        // cost the same, so the plan makes few nodes of them.
        let scale = 1.0 / half_area(&source.nodes[0].bounds).max(f64::MIN_POSITIVE);
        let mut plans = vec![Plan::default(); source.nodes.len()];
        for number in order.into_iter().rev() {
            let node = &source.nodes[number as usize];
            let area = ((half_area(&node.bounds) * scale) as f32).max(f32::MIN_POSITIVE);
            plans[number as usize] = match node.content() {
                Content::Item(_) => {
                    let cost = area * (costs.leaf + costs.item);
                    Plan { cost: [cost; 7], left: [1, 0, 0, 0, 0, 0, 0, 0], items: 1 }
                }
                Content::Children(first) => {
                    let first = first as usize;
                    Self::plan(area, &plans[first], &plans[first + 1], costs)
                }
            };
        }
        Self { source, plans }
    }

    fn plan(area: f32, left: &Plan, right: &Plan, costs: Costs) -> Plan {
        let mut plan = Plan { items: (left.items + right.items).min(9), ..Plan::default() };
        let mut forest = [f32::INFINITY; 9];
        for (trees, least) in forest.iter_mut().enumerate().skip(2) {
            for to_left in 1..trees {
                let cost = left.cost[to_left - 1] + right.cost[trees - to_left - 1];
                if cost < *least {
                    (*least, plan.left[trees - 1]) = (cost, to_left as u8);
                }
            }
        }
        let node = area * costs.node + forest[8];
        let leaf =
            if plan.items <= 8 { area * (costs.leaf + costs.item * f32::from(plan.items)) } else { f32::INFINITY };
        (plan.cost[0], plan.left[0]) = if leaf <= node { (leaf, 1) } else { (node, 0) };
        for (trees, &least) in forest.iter().enumerate().take(8).skip(2) {
            plan.cost[trees - 1] = least;
            if plan.cost[trees - 2] <= least {
                (plan.cost[trees - 1], plan.left[trees - 1]) = (plan.cost[trees - 2], 0);
            }
        }
        plan
    }

    /// Appends the roots of the best forest of at most `trees` trees below a node.
    fn forest(&self, number: u32, mut trees: usize, found: &mut Vec<u32>) {
        let plan = &self.plans[number as usize];
        while trees > 1 && plan.left[trees - 1] == 0 {
            trees -= 1;
        }
        if trees == 1 {
            found.push(number);
        } else {
            let (first, left) = (self.first_child(number), plan.left[trees - 1] as usize);
            self.forest(first, left, found);
            self.forest(first + 1, trees - left, found);
        }
    }

    /// The first child of a node that has children.
    fn first_child(&self, number: u32) -> u32 {
        match self.source.nodes[number as usize].content() {
            Content::Children(first) => first,
            Content::Item(_) => unreachable!("an item is planned as a leaf"),
        }
    }

    /// The children of a node of the wide tree.
    pub(crate) fn children(&self, number: u32) -> Vec<u32> {
        let mut children = Vec::with_capacity(8);
        let (first, left) = (self.first_child(number), self.plans[number as usize].left[7] as usize);
        self.forest(first, left, &mut children);
        self.forest(first + 1, 8 - left, &mut children);
        children
    }

    /// The centre of a node's box.
    pub(crate) fn middle(&self, number: u32) -> Vec3 {
        self.source.nodes[number as usize].bounds.center()
    }

    /// The items of a leaf of the wide tree; `None` if the node becomes an inner node.
    pub(crate) fn leaf(&self, number: u32) -> Option<Vec<u32>> {
        if self.plans[number as usize].left[0] == 0 {
            return None;
        }
        let mut open = vec![number];
        let mut items = Vec::with_capacity(8);
        while let Some(number) = open.pop() {
            match self.source.nodes[number as usize].content() {
                Content::Item(item) => items.push(item),
                Content::Children(first) => open.extend([first + 1, first]),
            }
        }
        Some(items)
    }
}

/// Assigns each child to the slot whose octant it lies in, or to a similar slot. Returns the child in each slot.
pub(crate) fn slots(middles: &[Vec3]) -> [Option<usize>; 8] {
    let middle = middles.iter().sum::<Vec3>() / middles.len() as f32;
    let mut slots = [None; 8];
    let mut placed = [false; 8];
    for _ in middles {
        let mut best = (f32::NEG_INFINITY, 0, 0);
        for (index, &at) in middles.iter().enumerate().filter(|(index, _)| !placed[*index]) {
            for slot in (0..8).filter(|&slot| slots[slot].is_none()) {
                let side = |bit: usize| if slot >> bit & 1 == 1 { 1.0 } else { -1.0 };
                let gain = (at - middle).dot(Vec3::new(side(0), side(1), side(2)));
                if gain > best.0 || best.0 == f32::NEG_INFINITY {
                    best = (gain, index, slot);
                }
            }
        }
        slots[best.2] = Some(best.1);
        placed[best.1] = true;
    }
    slots
}
