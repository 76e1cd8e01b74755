//! The binary tree that a build begins with. It is made by `split`, improved by `reinsert` and collapsed by `collapse`.

use glam::DVec3;

use crate::geom::Aabb;

/// The binary tree over all items: one leaf per item.
#[derive(Debug)]
pub(super) struct BinaryTree {
    /// The root comes first. Two siblings are neighbours, the first of them at an odd index.
    pub(super) nodes: Vec<BinaryNode>,
}

/// A node of a [`BinaryTree`].
#[derive(Clone, Copy, Debug)]
pub(super) struct BinaryNode {
    /// A box around all items below.
    pub(super) bounds: Aabb,
    content: u32,
}

/// What is below a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Content {
    Item(u32),
    /// Index of the first of two neighbouring children.
    Children(u32),
}

impl BinaryNode {
    const ITEM: u32 = 1 << 31;

    pub(super) fn of_item(item: u32, bounds: Aabb) -> Self {
        Self { bounds, content: item | Self::ITEM }
    }

    pub(super) fn of_children(first: u32, bounds: Aabb) -> Self {
        Self { bounds, content: first }
    }

    pub(super) fn content(&self) -> Content {
        if self.content & Self::ITEM != 0 {
            Content::Item(self.content & !Self::ITEM)
        } else {
            Content::Children(self.content)
        }
    }
}

/// Half of a box's surface. In `f64` no box of `f32` numbers overflows, and none that has a volume vanishes.
#[inline(always)]
pub(super) fn half_area(bounds: &Aabb) -> f64 {
    let DVec3 { x, y, z } = bounds.hi.as_dvec3() - bounds.lo.as_dvec3();
    x * y + y * z + z * x
}
