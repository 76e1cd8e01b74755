//! One mesh as a kernel sees it: its prepared triangles, the tree over them, and what each walk does in a leaf.
//!
//! `mesh_tree` holds the data and the triangle tests under the box rule. The other files are named after the walks in
//! `walk`.

mod block;
mod mesh_tree;
mod packet;
mod scalar;
mod scratch;
mod single;
mod stream;

pub(crate) use mesh_tree::MeshTree;
pub(crate) use scratch::TraversalScratch;
