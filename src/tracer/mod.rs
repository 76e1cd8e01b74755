//! A small tracer: meshes and quadrics, instances of them, two levels of trees, single rays and many rays, pictures.
//!
//! The closest hit is the same, bit for bit, for every mode, traversal order, tree, packet width and number of threads, and
//! for brute force. The *box rule* makes it so; `ARCHITECTURE.md` states and proves it.
//!
//! # Rooms
//!
//! | room | content |
//! | --- | --- |
//! | `meshes` | triangle meshes, OBJ files, generated meshes |
//! | `bvh` | the tree with eight children per node, how it is built, the box rule |
//! | `walk` | ways to walk a tree: which nodes and leaves rays visit |
//! | `leaf` | a mesh prepared for a kernel, and what each walk does in a leaf |
//! | `scene` | geometries, instances, and the two-level scene |
//! | `trace` | many rays at once: modes, threads, ray files |
//! | `image` | camera, light, shading |
//! | `load` | scene files, built-in scenes |
//!
//! Each room uses only those above it.
//!
//! # Walks
//!
//! TABLE

mod bvh;
mod image;
mod leaf;
mod load;
mod meshes;
mod scene;
mod trace;
mod walk;

pub use crate::error::Error;
pub use crate::files::{hold_writes, write_atomically};
pub use image::{
    Camera, Differences, Light, OCCLUSION_RAYS, Picture, Shade, Shot, View, block_order, compare, parse_point,
    picture_hits, shade,
};
#[cfg(feature = "study")]
pub(crate) use image::{OCCLUSION_REACH, hemisphere_rays, shadow_rays};
pub use load::{BuiltIn, LoadedScene, SceneSource, load_scene};
pub use meshes::{Mesh, MeshError, ObjReport, Part, load_obj};
pub use scene::{Checker, Geometry, Paint, Placement, Scene, SurfacePoint, World, WorldError};
pub use trace::{Mode, checksum, count, read_rays, thread_pool, trace, trace_into, write_hits, write_rays};
pub use walk::TraversalStats;
