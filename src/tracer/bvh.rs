//! The bounding volume hierarchy: built by obvhs with two children per node, collapsed by us to eight.
//!
//! A tree is over items that have boxes: triangles, or instances. Every node, leaf or not, holds the boxes of what is in it
//! as structure of arrays, so that one ray, or what bounds many rays, is tested against eight boxes at once. Boxes are exact
//! unions of the boxes of whole items; there are no spatial splits, since a clipped box could cull a candidate that counts
//! (see [`crate::tracer`]).

use glam::Vec3;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::ploc::PlocSearchDistance;
use obvhs::{Boundable, BvhBuildParams};
use wide::f32x8;

use super::collapse::{Collapse, Costs, slots};
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
    pub(super) fn new(boxes: [Aabb; 8]) -> Self {
        let planes = [0, 1, 2]
            .map(|axis| [f32x8::new(boxes.map(|one| one.lo[axis])), f32x8::new(boxes.map(|one| one.hi[axis]))]);
        Self { planes }
    }

    /// The boxes of a leaf's items.
    pub(super) fn of_items(leaf: &Leaf, bounds_of: impl Fn(u32) -> Aabb) -> Self {
        Self::new(leaf.0.map(|item| if item == Leaf::NONE { Aabb::EMPTY } else { bounds_of(item) }))
    }

    /// As eight lanes of the slab test.
    #[inline(always)]
    pub(super) fn slabs(&self) -> Slabs<f32x8> {
        let [x, y, z] = self.planes;
        Slabs { lo: Vec3x8 { x: x[0], y: y[0], z: z[0] }, hi: Vec3x8 { x: x[1], y: y[1], z: z[1] } }
    }

    /// The planes across an axis that rays meet first; `side` says for each axis whether that is the upper one.
    #[inline(always)]
    pub(super) fn near(&self, axis: usize, side: [usize; 3]) -> f32x8 {
        self.planes[axis][side[axis] & 1]
    }

    /// The planes that they meet last.
    #[inline(always)]
    pub(super) fn far(&self, axis: usize, side: [usize; 3]) -> f32x8 {
        self.planes[axis][side[axis] & 1 ^ 1]
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

impl From<Slabs<f32x8>> for Boxes {
    #[inline(always)]
    fn from(Slabs { lo, hi }: Slabs<f32x8>) -> Self {
        Self { planes: [[lo.x, hi.x], [lo.y, hi.y], [lo.z, hi.z]] }
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

/// What is above items: their numbers, [`Leaf::NONE`] in unused slots, which are the last.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaf(pub(super) [u32; 8]);

impl Leaf {
    pub(super) const NONE: u32 = u32::MAX;

    /// The items, in as many slots as are in use.
    pub(super) fn numbers(&self) -> impl Iterator<Item = u32> {
        self.0.into_iter().take_while(|&item| item != Self::NONE)
    }

    /// How many slots are in use, from the first on.
    #[inline(always)]
    pub(super) fn len(&self) -> usize {
        self.0.iter().filter(|&&item| item != Self::NONE).count()
    }
}

/// A tree over items.
#[derive(Debug)]
pub(super) struct Bvh {
    /// Parents before children.
    pub(super) nodes: Vec<Node>,
    pub(super) leaves: Vec<Leaf>,
    pub(super) root: Child,
    /// Of all items.
    pub(super) bounds: Aabb,
    /// Mean length of the items' diagonals.
    pub(super) item_size: f32,
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

/// A leaf costs as much as a node, whose boxes take as long as its triangles; fewer items are a little better, since packets
/// test them one by one. A leaf half or one and a half times as dear made nothing faster by more than the noise; items of 0.15
/// made shadow rays in a closed room 1.13 times as fast, and primary rays where triangles are small 0.87 to 0.93 times.
const COSTS: Costs = Costs { node: 1.0, leaf: 1.0, item: 0.05 };

impl Bvh {
    /// Memory that it takes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.leaves[..])
    }

    /// A tree over `count` items, at least one. Their boxes are not empty.
    pub(super) fn build(count: usize, bounds_of: impl Fn(u32) -> Aabb) -> Self {
        let params = BvhBuildParams {
            max_prims_per_leaf: 1,
            // obvhs' presets look only at direct neighbours on the first levels. On a regular grid all of those tie, and the
            // tree degenerates: 230 triangle tests per ray of the built-in room instead of 4. The build takes a third longer.
            search_depth_threshold: 0,
            // Of all that obvhs offers, what makes closed rooms cheaper for the least time: 5 % fewer nodes a ray than its
            // preset. Reinsertion of 30 % of the nodes takes another 2 % away, and makes the build 2.2 times as long.
            ploc_search_distance: PlocSearchDistance::VeryHigh,
            ..BvhBuildParams::medium_build()
        };
        let bounds = (0..count as u32).fold(Aabb::EMPTY, |bounds, item| bounds.union(&bounds_of(item)));
        let source = build_bvh2(&unit_boxes(&bounds, count, &bounds_of), params, &mut Default::default());
        let mut bvh = Self::pack(&Collapse::new(&source, COSTS), bounds);
        bvh.fit(bounds_of, count);
        bvh
    }

    /// A node with a leaf for each of at most eight items.
    #[cfg(test)]
    pub(super) fn with_leaves(items: &[Aabb]) -> Self {
        let slot = |slot: usize| (slot < items.len()).then_some(slot as u32);
        let leaf = |item: u32| Leaf([item, u32::MAX, u32::MAX, u32::MAX, u32::MAX, u32::MAX, u32::MAX, u32::MAX]);
        Self {
            nodes: vec![Node {
                boxes: Boxes::new(std::array::from_fn(|index| items.get(index).copied().unwrap_or(Aabb::EMPTY))),
                children: std::array::from_fn(|index| {
                    slot(index).map_or(Child::NONE, |item| Child(item | Child::LEAF))
                }),
            }],
            leaves: (0..items.len() as u32).map(leaf).collect(),
            root: Child(0),
            bounds: items.iter().fold(Aabb::EMPTY, |bounds, one| bounds.union(one)),
            item_size: 0.0,
        }
    }

    /// Copies the tree depth first, without boxes.
    fn pack(plan: &Collapse<'_>, bounds: Aabb) -> Self {
        let no_boxes = Boxes::new([Aabb::EMPTY; 8]);
        let mut bvh = Self { nodes: Vec::new(), leaves: Vec::new(), root: Child::NONE, bounds, item_size: 0.0 };
        // (node of the binary tree, node that it is a child of and in which slot)
        let mut open = vec![(0, None)];
        while let Some((number, parent)) = open.pop() {
            let child = if let Some(items) = plan.leaf(number) {
                let mut leaf = Leaf([Leaf::NONE; 8]);
                leaf.0[..items.len()].copy_from_slice(&items);
                bvh.leaves.push(leaf);
                Child((bvh.leaves.len() - 1) as u32 | Child::LEAF)
            } else {
                let index = bvh.nodes.len();
                bvh.nodes.push(Node { boxes: no_boxes, children: [Child::NONE; 8] });
                let children = plan.children(number);
                let middles: Vec<_> = children.iter().map(|&child| plan.middle(child)).collect();
                for (slot, child) in slots(&middles).into_iter().enumerate().rev() {
                    open.extend(child.map(|child| (children[child], Some((index, slot)))));
                }
                Child(index as u32)
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

    /// Computes every box as the exact union of the boxes of the items below it.
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
