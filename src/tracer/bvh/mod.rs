//! The bounding volume hierarchy: eight children per node, built over triangles or over instances.

mod binary;
mod boxes;
mod build;
#[cfg(test)]
mod build_tests;
mod collapse;
mod leaf;
mod reinsert;
mod split;
mod tree;

pub(crate) use boxes::Boxes;
pub(crate) use leaf::Leaf;
pub(crate) use tree::{Bvh, Child, Extent, Node};
