//! A small tracer: meshes and quadrics, instances of them, two levels of trees, single rays and packets, pictures.
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
//!
//! Nor does it matter by what test a box is culled, as long as that is never stricter than the slab test of the rule. Walks that
//! test eight boxes at a time use cheaper ones: a fused slab test whose rounding errors are folded into its addends (`single`,
//! `packet`, `stream`), and intervals that contain many rays (`block`). The slab test itself only judges candidates.
//!
//! # Ways of walking
//!
//! | file | rays | against |
//! | --- | --- | --- |
//! | `scalar` | one | one box, one triangle: the reference |
//! | `single` | one | the eight boxes of a node, the up to eight triangles of a leaf |
//! | `packet` | eight in one octant, alone once they part | each of the eight boxes, each triangle |
//! | `block` | up to 64 that are alike, as eight packets | eight boxes; one box for eight packets; each triangle |
//! | `stream` | up to 4096 in one octant | each of the eight boxes, eight rays at a time; each triangle likewise |
//!
//! All walk the same tree (`bvh`, `collapse`). Its leaves know their triangles' boxes too, which the rule needs, and which cull
//! triangle by triangle: for kernels that keep vertices as they are, the boxes are computed from those. `trace` chooses among the
//! walks.
//!
//! # Instances
//!
//! Within an instance the box rule holds as it stands, in the object's coordinates and with the transformed ray, which is the
//! same in every path. So its closest hit, taken over the ray's original interval, depends on ray and instance alone. But
//! that ray is rounded, and so the hit's `t` may lie before the world ray's entry into the instance's world box, or beyond
//! its exit, and no box of the upper tree may be culled by it. Therefore the rule is applied once more:
//!
//! > An instance's closest hit counts if the world ray hits the instance's own padded world box. Its `t` is clamped to
//! > that box's entry `e` and padded exit `x`, and only the clamped value is compared with the best so far. Between equal
//! > `t`, the lower instance number wins.
//!
//! - *The upper tree* may cull as the lower one does, by the same argument: boxes of nodes contain the boxes below them, so
//!   their entries are no later than `e`, and `e` is at most the clamped `t`.
//! - *Within an instance* the search may end at the best hit so far only where `x` is beyond it. Let the best be at `b`, and
//!   let a hit have `t' > b` in the object. If `x > b`, its clamped `t`, which is at least the smaller of `t'` and `x`, is
//!   beyond `b` too: such a hit loses, and so does whatever is found in its stead. If `x <= b`, it may be clamped down to
//!   `x` and win: then the whole interval is searched. That costs nothing, since the object ends at `x` but for rounding.
//! - *Any hit* needs no more than that an instance has a hit in its own coordinates and the world ray hits its world box.
//! - *An instance by exactly the identity* takes the ray as it is, and its box in the world is that of the object. Its
//!   interval then contains those of all triangles, and the second clamp changes nothing: a mesh as
//!   it is has the same hits, bit for bit, as that instance of it, and a scene of nothing else goes without the upper tree.
//! - *World boxes* contain the exactly transformed object, so that here too the rule only ever removes false hits.

mod block;
mod box_rule;
mod builtin;
mod bvh;
mod camera;
mod collapse;
#[cfg(test)]
mod culling;
mod error;
mod generator;
mod mesh;
mod mesh_tree;
mod obj;
mod output;
mod packet;
mod picture;
mod rayfile;
mod scalar;
mod scene;
mod scenefile;
mod single;
mod source;
mod stack;
mod stream;
mod surface;
mod tally;
mod trace;
mod view;
mod world;
mod world_box;

pub use builtin::BuiltIn;
pub use camera::{Camera, block_order};
pub use error::Error;
pub use mesh::{Mesh, MeshError, Part};
pub use obj::{ObjReport, load_obj};
pub use output::{hold_writes, write_atomically};
#[cfg(feature = "study")]
pub(crate) use output::{try_folder, write_new_folder, write_together};
pub use picture::{Differences, OCCLUSION_RAYS, Picture, Shade, Shot, compare, picture_hits, shade};
#[cfg(feature = "study")]
pub(crate) use picture::{OCCLUSION_REACH, hemisphere_rays, shadow_rays};
pub use rayfile::{read_rays, write_hits, write_rays};
pub use scene::Scene;
pub use scenefile::load_scene;
pub use source::{LoadedScene, SceneSource};
pub use surface::SurfacePoint;
pub use tally::Counts;
pub use trace::{Mode, checksum, count, thread_pool, trace, trace_into};
pub use view::{Light, View, parse_point};
pub use world::{Checker, Geometry, Paint, Placement, World, WorldError};
