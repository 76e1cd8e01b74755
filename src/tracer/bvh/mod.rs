//! The bounding volume hierarchy: eight children per node, built over triangles or over instances.

pub(crate) mod box_rule;
mod boxes;
mod build;
mod collapse;
mod leaf;
mod tree;

pub(crate) use boxes::Boxes;
pub(crate) use leaf::Leaf;
pub(crate) use tree::{Bvh, Child, Node};
