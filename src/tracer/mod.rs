//! A small tracer: meshes, a tree, single rays and packets, pictures.
//!
//! # The box rule
//!
//! A tree visits triangles in an order that depends on ray, packet and node. With rounded distances an early hit can cull
//! a box whose triangle would have given a smaller `t`, so ordinary tracers give different answers for different
//! traversals. This one does not:
//!
//! > A candidate counts if the kernel's own `t` lies in the ray's original interval and the ray hits the triangle's own
//! > padded box. Its `t` is clamped to that box's entry and exit distance, and only the clamped value is compared with the
//! > best so far. Between equal `t`, the lower primitive number wins.
//!
//! Whether a candidate counts, and with which `t`, depends on ray and triangle alone. The slab test is monotonic under
//! rounding: the box of an ancestor, which contains the triangle's own, has no later entry and no earlier exit. A box is
//! culled only when the ray misses it, or when its entry is strictly beyond the best `t`; neither can lose the winner. So
//! the closest hit is the same for every order of visits, every tree, every packet, every thread count, and for trying
//! all triangles one by one. And since a miss of a padded box is a proof, the rule only ever removes false hits.

mod box_rule;
mod builtin;
mod bvh;
mod camera;
mod error;
mod generator;
mod mesh;
mod mesh_tree;
mod obj;
mod output;
mod picture;
mod rayfile;
mod scene;
mod scenefile;
mod source;
mod surface;
mod trace;
mod traverse;
mod view;
mod world;
mod world_box;

pub use builtin::BuiltIn;
pub use camera::{Camera, block_order};
pub use error::Error;
pub use mesh::{Mesh, MeshError, Part};
pub use obj::{ObjReport, load_obj};
pub use output::write_atomically;
pub(crate) use picture::shadow_rays;
pub use picture::{Differences, OCCLUSION_RAYS, Picture, Shade, Shot, compare, picture_hits, shade};
pub use rayfile::{read_rays, write_hits, write_rays};
pub use scene::Scene;
pub use scenefile::load_scene;
pub use source::{LoadedScene, SceneSource};
pub use surface::SurfacePoint;
pub use trace::{Mode, checksum, thread_pool, trace};
pub use view::{Light, View};
pub use world::{Checker, Geometry, Paint, Placement, World, WorldError};
