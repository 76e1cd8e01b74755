//! The nodes of the tree.
//!
//! Items are triangles or instances. An inner node holds the boxes of its eight children, exact unions of the boxes of
//! whole items. There are no spatial splits: a clipped box could cull a candidate that counts (see `ARCHITECTURE.md`).

use super::boxes::Boxes;
use super::leaf::Leaf;
use crate::geom::Aabb;

/// A slot of a node: an inner node or a leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Child(u32);

impl Child {
    const LEAF: u32 = 1 << 31;
    /// Content of unused slots. No inner node has the root as a child.
    pub(crate) const NONE: Self = Self(0);

    pub(crate) fn of_leaf(number: usize) -> Self {
        Self(number as u32 | Self::LEAF)
    }

    pub(crate) fn of_node(number: usize) -> Self {
        Self(number as u32)
    }

    /// `Ok` with the number of a leaf, or `Err` with that of an inner node.
    #[inline(always)]
    pub(crate) fn leaf(self) -> Result<usize, usize> {
        if self.0 & Self::LEAF != 0 { Ok((self.0 & !Self::LEAF) as usize) } else { Err(self.0 as usize) }
    }
}

/// An inner node: 224 bytes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node {
    pub(crate) boxes: Boxes,
    pub(crate) children: [Child; 8],
}

/// The largest and the smallest box of a tree.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    /// A box around all items.
    pub(crate) bounds: Aabb,
    /// Length of the shortest diagonal of a leaf's box that is not a point. Infinite if there is none.
    pub(crate) smallest_leaf: f32,
}

/// A tree over items.
#[derive(Clone, Debug)]
pub(crate) struct Bvh {
    /// Parents before children.
    pub(crate) nodes: Vec<Node>,
    pub(crate) leaves: Vec<Leaf>,
    pub(crate) root: Child,
    pub(crate) extent: Extent,
    /// Mean length of the items' diagonals. Where few items are much larger than the others, eight times the median.
    pub(crate) item_size: f32,
}

impl Bvh {
    /// Bytes of nodes and leaves.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.leaves[..])
    }

    /// A node with a leaf for each of at most eight items.
    #[cfg(test)]
    pub(crate) fn with_leaves(items: &[Aabb]) -> Self {
        let leaf = |item: u32| Leaf([item, u32::MAX, u32::MAX, u32::MAX, u32::MAX, u32::MAX, u32::MAX, u32::MAX]);
        Self {
            nodes: vec![Node {
                boxes: Boxes::new(std::array::from_fn(|slot| items.get(slot).copied().unwrap_or(Aabb::EMPTY))),
                children: std::array::from_fn(
                    |slot| if slot < items.len() { Child::of_leaf(slot) } else { Child::NONE },
                ),
            }],
            leaves: (0..items.len() as u32).map(leaf).collect(),
            root: Child::of_node(0),
            extent: Extent {
                bounds: items.iter().fold(Aabb::EMPTY, |bounds, one| bounds.union(one)),
                smallest_leaf: f32::INFINITY,
            },
            item_size: 0.0,
        }
    }
}
