//! Memory that walks reuse, so that tracing a ray allocates nothing.

use crate::tracer::walk::block::{self, Block};
use crate::tracer::walk::stack::StackStorage;
use crate::tracer::walk::stream::StreamScratch;
use crate::tracer::walk::{packet, scalar, single};

/// Stacks and ray storage for every walk through one level of trees.
#[derive(Debug)]
pub(crate) struct TraversalScratch {
    pub(crate) scalar: StackStorage<scalar::StackEntry>,
    pub(crate) single: StackStorage<single::StackEntry>,
    pub(crate) packet: StackStorage<packet::StackEntry>,
    pub(super) block: StackStorage<block::StackEntry>,
    pub(super) block_rays: Box<Block>,
    /// Leaf and slot of the triangle that the last block of any-hit rays hit. The next block often hits it too. The
    /// numbers may stem from another tree: any triangle is a correct first choice.
    pub(super) occluder: Option<(usize, usize)>,
    pub(super) stream: StreamScratch,
}

impl TraversalScratch {
    pub(crate) fn new() -> Self {
        Self {
            scalar: StackStorage::new(scalar::StackEntry::EMPTY),
            single: StackStorage::new(single::StackEntry::EMPTY),
            packet: StackStorage::new(packet::StackEntry::EMPTY),
            block: StackStorage::new(block::StackEntry::EMPTY),
            block_rays: Box::new(Block::new()),
            occluder: None,
            stream: StreamScratch::new(),
        }
    }
}
