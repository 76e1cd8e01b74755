//! Ways to walk a tree: which nodes and leaves a ray, or many rays, visit.
//!
//! Every walk visits the same tree and gives the same hits. What happens in a leaf is not here but in `leaf`, which has
//! a file of the same name for each walk.

pub(crate) mod block;
mod counter;
#[cfg(test)]
mod culling_tests;
pub(crate) mod filter;
pub(crate) mod fused_slabs;
pub(crate) mod packet;
pub(crate) mod rays;
pub(crate) mod scalar;
pub(crate) mod single;
pub(crate) mod stack;
pub(crate) mod stream;

pub(crate) use counter::Counter;
pub use counter::TraversalStats;
