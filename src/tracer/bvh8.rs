//! The bounding volume hierarchy: built by obvhs with two children per node, collapsed by us to eight.
//!
//! A tree is over items that have boxes: triangles, or instances. Every node, leaf or not, holds the boxes of what is in it
//! as structure of arrays, so that one ray, or what bounds many rays, is tested against eight boxes at once. Boxes are exact
//! unions of the boxes of whole items; there are no spatial splits, since a clipped box could cull a candidate that counts
//! (see [`crate::tracer`]).
//!
//! The collapse is the one of H. Ylitie, T. Karras, S. Laine, "Efficient Incoherent Ray Traversal on GPUs Through
//! Compressed Wide BVHs", 2017: dynamic programming over the binary tree finds the wide one of least expected cost. As there,
//! children are put into slots by the octant that they lie in, seen from the middle of the node: a ray that visits the slots
//! in the order of `slot ^ octant of its direction` visits them about front to back, without looking at distances.

use glam::Vec3;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{Boundable, BvhBuildParams};
use wide::f32x8;

use crate::geom::Aabb;
use crate::geom::lanes::Vec3x8;
use crate::kernels::aabb::Slabs;

/// Eight boxes. Unused ones are empty, which no ray hits.
#[derive(Clone, Copy, Debug)]
pub(super) struct Boxes {
    /// For each axis, the lower planes and the upper planes.
    pub(super) planes: [[f32x8; 2]; 3],
}

impl Boxes {
    fn new(boxes: [Aabb; 8]) -> Self {
        let planes = [0, 1, 2]
            .map(|axis| [f32x8::new(boxes.map(|one| one.lo[axis])), f32x8::new(boxes.map(|one| one.hi[axis]))]);
        Self { planes }
    }

    /// As eight lanes of the slab test.
    #[inline(always)]
    pub(super) fn slabs(&self) -> Slabs<f32x8> {
        let [x, y, z] = self.planes;
        Slabs { lo: Vec3x8 { x: x[0], y: y[0], z: z[0] }, hi: Vec3x8 { x: x[1], y: y[1], z: z[1] } }
    }

    /// One of the boxes.
    #[inline(always)]
    pub(super) fn lane(&self, lane: usize) -> Slabs<f32> {
        let side = |side: usize| Vec3::from_array([0, 1, 2].map(|axis| self.planes[axis][side].as_array()[lane]));
        Slabs { lo: side(0), hi: side(1) }
    }

    fn union(&self) -> Aabb {
        let side = |side: usize, start: f32, of: fn(f32, f32) -> f32| {
            Vec3::from_array([0, 1, 2].map(|axis| self.planes[axis][side].to_array().into_iter().fold(start, of)))
        };
        Aabb { lo: side(0, f32::INFINITY, f32::min), hi: side(1, f32::NEG_INFINITY, f32::max) }
    }
}

/// What a slot of a node refers to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Child(u32);

impl Child {
    const LEAF: u32 = 1 << 31;
    pub(super) const NONE: Self = Self(0);

    /// The number of the leaf, if it is one.
    #[inline(always)]
    pub(super) fn leaf(self) -> Result<usize, usize> {
        if self.0 & Self::LEAF != 0 { Ok((self.0 & !Self::LEAF) as usize) } else { Err(self.0 as usize) }
    }
}

/// A node above others: 224 bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub(super) boxes: Boxes,
    pub(super) children: [Child; 8],
}

/// A node above items.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaf {
    pub(super) boxes: Boxes,
    /// Numbers of the items, [`Leaf::NONE`] in unused slots.
    pub(super) items: [u32; 8],
}

impl Leaf {
    pub(super) const NONE: u32 = u32::MAX;
}

/// A tree over items.
#[derive(Debug)]
pub(super) struct Bvh8 {
    /// Parents before children.
    pub(super) nodes: Vec<Node>,
    pub(super) leaves: Vec<Leaf>,
    pub(super) root: Child,
    /// Of all items.
    pub(super) bounds: Aabb,
    /// How many nodes and leaves there are from the root to the farthest leaf.
    pub(super) depth: usize,
}

/// The box of an item, moved and scaled into the unit cube: obvhs computes areas in `f32`, and panics where they overflow
/// or underflow. Only the shape of the tree comes from these boxes.
struct UnitBox(obvhs::aabb::Aabb);

impl Boundable for UnitBox {
    fn aabb(&self) -> obvhs::aabb::Aabb {
        self.0
    }
}

fn unit_boxes(bounds: &Aabb, count: usize, bounds_of: impl Fn(u32) -> Aabb) -> Vec<UnitBox> {
    // A side may be infinite.
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

/// What the ray tests cost, relative to each other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Costs {
    pub(super) node: f32,
    pub(super) leaf: f32,
    pub(super) item: f32,
}

/// What the collapse knows of a node of the binary tree.
#[derive(Clone, Copy, Default)]
struct Plan {
    /// Least costs of the items below as a forest of at most 1, 2, … 7 trees.
    cost: [f32; 7],
    /// How many trees of a forest of at most 1, 2, … 8 go to the left child. At the first place, 0 for a node and 1 for a
    /// leaf; else 0 where one tree fewer costs no more.
    left: [u8; 8],
    /// Items below, where there are no more than can be in a leaf; else 9.
    items: u8,
}

struct Collapse<'a> {
    source: &'a Bvh2,
    plans: Vec<Plan>,
}

impl<'a> Collapse<'a> {
    fn new(source: &'a Bvh2, costs: Costs) -> Self {
        let mut order = Vec::with_capacity(source.nodes.len());
        let mut open = vec![0];
        while let Some(number) = open.pop() {
            order.push(number);
            let node = &source.nodes[number as usize];
            if !node.is_leaf() {
                open.extend([node.first_index, node.first_index + 1]);
            }
        }
        let mut plans = vec![Plan::default(); source.nodes.len()];
        for number in order.into_iter().rev() {
            let node = &source.nodes[number as usize];
            let area = node.aabb().half_area();
            plans[number as usize] = if node.is_leaf() {
                let cost = area * (costs.leaf + costs.item * node.prim_count as f32);
                Plan { cost: [cost; 7], left: [1, 0, 0, 0, 0, 0, 0, 0], items: node.prim_count as u8 }
            } else {
                let first = node.first_index as usize;
                Self::plan(area, &plans[first], &plans[first + 1], costs)
            };
        }
        Self { source, plans }
    }

    fn plan(area: f32, left: &Plan, right: &Plan, costs: Costs) -> Plan {
        let mut plan = Plan { items: (left.items + right.items).min(9), ..Plan::default() };
        let mut forest = [f32::INFINITY; 9];
        for trees in 2..=8 {
            for to_left in 1..trees {
                let cost = left.cost[to_left.min(7) - 1] + right.cost[(trees - to_left).min(7) - 1];
                if cost < forest[trees] {
                    (forest[trees], plan.left[trees - 1]) = (cost, to_left as u8);
                }
            }
        }
        let node = area * costs.node + forest[8];
        let leaf =
            if plan.items <= 8 { area * (costs.leaf + costs.item * f32::from(plan.items)) } else { f32::INFINITY };
        (plan.cost[0], plan.left[0]) = if leaf <= node { (leaf, 1) } else { (node, 0) };
        for trees in 2..=7 {
            plan.cost[trees - 1] = forest[trees];
            if plan.cost[trees - 2] <= forest[trees] {
                (plan.cost[trees - 1], plan.left[trees - 1]) = (plan.cost[trees - 2], 0);
            }
        }
        plan
    }

    /// The trees of the forest of at most `trees` below a node.
    fn forest(&self, number: u32, mut trees: usize, found: &mut Vec<u32>) {
        let plan = &self.plans[number as usize];
        while trees > 1 && plan.left[trees - 1] == 0 {
            trees -= 1;
        }
        if trees == 1 {
            found.push(number);
        } else {
            let (first, left) = (self.source.nodes[number as usize].first_index, plan.left[trees - 1] as usize);
            self.forest(first, left, found);
            self.forest(first + 1, trees - left, found);
        }
    }

    fn is_leaf(&self, number: u32) -> bool {
        self.plans[number as usize].left[0] == 1
    }

    fn items(&self, number: u32) -> Vec<u32> {
        let mut open = vec![number];
        let mut items = Vec::with_capacity(8);
        while let Some(number) = open.pop() {
            let node = &self.source.nodes[number as usize];
            if node.is_leaf() {
                let first = node.first_index as usize;
                items.extend(&self.source.primitive_indices[first..first + node.prim_count as usize]);
            } else {
                open.extend([node.first_index + 1, node.first_index]);
            }
        }
        items
    }
}

/// Puts each into the slot whose octant it lies in, or one like it. Returns for each slot who is in it.
fn slots(middles: &[Vec3]) -> [Option<usize>; 8] {
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

impl Bvh8 {
    /// Memory that it takes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.leaves[..])
    }

    /// A tree over `count` items, at least one. Their boxes are not empty.
    pub(super) fn build(count: usize, costs: Costs, bounds_of: impl Fn(u32) -> Aabb) -> Self {
        let params = BvhBuildParams {
            max_prims_per_leaf: 1,
            // obvhs' presets look only at direct neighbours on the first levels. On a regular grid all of those tie, and the
            // tree degenerates: 230 triangle tests per ray of the built-in room instead of 4. The build takes a third longer.
            search_depth_threshold: 0,
            ..BvhBuildParams::medium_build()
        };
        let bounds = (0..count as u32).fold(Aabb::EMPTY, |bounds, item| bounds.union(&bounds_of(item)));
        let source = build_bvh2(&unit_boxes(&bounds, count, &bounds_of), params, &mut Default::default());
        let mut bvh = Self::collapse(&Collapse::new(&source, costs), bounds);
        bvh.fit(bounds_of);
        bvh
    }

    /// Copies the tree depth first, without boxes.
    fn collapse(plan: &Collapse<'_>, bounds: Aabb) -> Self {
        let no_boxes = Boxes::new([Aabb::EMPTY; 8]);
        let mut bvh = Self { nodes: Vec::new(), leaves: Vec::new(), root: Child::NONE, bounds, depth: 1 };
        // (node of the binary tree, whose child, in which slot, how deep)
        let mut open = vec![(0, None, 1)];
        let mut forest = Vec::with_capacity(8);
        while let Some((number, parent, depth)) = open.pop() {
            bvh.depth = bvh.depth.max(depth);
            let middle_of = |number: &u32| {
                let aabb = plan.source.nodes[*number as usize].aabb();
                Vec3::from(aabb.min + aabb.max)
            };
            let child = if plan.is_leaf(number) {
                let items = plan.items(number);
                let mut leaf = Leaf { boxes: no_boxes, items: [Leaf::NONE; 8] };
                leaf.items[..items.len()].copy_from_slice(&items);
                bvh.leaves.push(leaf);
                Child((bvh.leaves.len() - 1) as u32 | Child::LEAF)
            } else {
                forest.clear();
                plan.forest(plan.source.nodes[number as usize].first_index, plan.plans[number as usize].left[7] as usize, &mut forest);
                plan.forest(plan.source.nodes[number as usize].first_index + 1, 8 - plan.plans[number as usize].left[7] as usize, &mut forest);
                let index = bvh.nodes.len();
                bvh.nodes.push(Node { boxes: no_boxes, children: [Child::NONE; 8] });
                let slots = slots(&forest.iter().map(middle_of).collect::<Vec<_>>());
                for (slot, tree) in slots.into_iter().enumerate().rev() {
                    if let Some(tree) = tree {
                        open.push((forest[tree], Some((index, slot)), depth + 1));
                    }
                }
                Child(index as u32)
            };
            match parent {
                Some((parent, slot)) => bvh.nodes[parent as usize].children[slot] = child,
                None => bvh.root = child,
            }
        }
        bvh.nodes.shrink_to_fit();
        bvh.leaves.shrink_to_fit();
        bvh
    }

    /// Computes every box as the exact union of the boxes of the items below it.
    fn fit(&mut self, bounds_of: impl Fn(u32) -> Aabb) {
        for leaf in &mut self.leaves {
            leaf.boxes =
                Boxes::new(leaf.items.map(|item| if item == Leaf::NONE { Aabb::EMPTY } else { bounds_of(item) }));
        }
        // Children come after their parents.
        for number in (0..self.nodes.len()).rev() {
            let boxes = self.nodes[number].children.map(|child| match child.leaf() {
                Ok(leaf) => self.leaves[leaf].boxes.union(),
                Err(0) => Aabb::EMPTY,
                Err(node) => self.nodes[node].boxes.union(),
            });
            self.nodes[number].boxes = Boxes::new(boxes);
        }
    }
}
