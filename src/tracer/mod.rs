//! A small tracer: meshes and quadrics, instances of them, two levels of trees, single rays and many rays, pictures.
//!
//! The closest hit is the same, bit for bit, for every mode, traversal order, tree, packet width and number of threads,
//! and for brute force. The *box rule* makes it so; `ARCHITECTURE.md` states and proves it.
//!
//! ```
//! use raylanes::kernels::triangle::ExactHalfOpen;
//! use raylanes::tracer::{Mode, Scene, SceneSource, occluded, trace};
//!
//! // A built-in scene; a mesh file or a scene file is loaded in the same way.
//! let loaded = SceneSource::parse("terrain:1e3")?.load()?;
//! let (view, scene) = (loaded.view, Scene::<ExactHalfOpen<f32>>::new(loaded.world));
//!
//! // The rays of a picture, and the closest hit of each.
//! let rays = view.camera(64, 64).rays(64, 64);
//! let hits = trace(&scene, &rays, Mode::Auto);
//!
//! // From each hit a ray straight up, away from the surface. On a terrain, nothing is there.
//! let seen = rays.iter().zip(&hits).filter(|(_, hit)| hit.mask);
//! let upwards: Vec<_> = seen.map(|(ray, hit)| scene.surface(ray, hit).spawn(glam::Vec3::Y)).collect();
//! assert!(upwards.len() > 1000);
//! assert!(!occluded(&scene, &upwards, Mode::Auto).contains(&true));
//! # Ok::<(), raylanes::tracer::Error>(())
//! ```
//!
//! # Rooms
//!
//! | room | content |
//! | --- | --- |
//! | `meshes` | triangle meshes, mesh files, generated meshes |
//! | `bvh` | the tree with eight children per node, how it is built, the box rule |
//! | `walk` | ways to walk a tree: which nodes and leaves rays visit |
//! | `leaf` | a mesh prepared for a kernel, and what each walk does in a leaf |
//! | `scene` | geometries, instances, and the two-level scene |
//! | `trace` | many rays at once: modes, threads, ray files |
//! | `image` | camera, light, shading |
//! | `load` | scene files, read and written; built-in scenes |
//!
//! Each room uses only those above it.
//!
//! # Walks
//!
//! All walks visit the same tree and give the same hits. `trace` chooses among them.
//!
//! | walk | rays | against |
//! | --- | --- | --- |
//! | `scalar` | one | one box, one triangle |
//! | `single` | one | eight boxes, eight triangles |
//! | `packet` | eight of one octant | each box, each triangle |
//! | `block` | up to 64 coherent ones | eight boxes, each triangle |
//! | `stream` | up to 4096 of one octant | each box, each triangle |
//!
//! Each earns its place by the speed with it, relative to the speed with the next best walk:
//!
//! | walk | instead of | primary | shadow | bounce | occlusion |
//! | --- | --- | --- | --- | --- | --- |
//! | `single` | `scalar`, bunny and sponza | 2.2, 2.7 | 2.7, 2.8 | 3.1, 2.4 | 2.8, 2.8 |
//! | `packet` | `single`, forest and gallery | 1.7, 3.3 | 1.5, 2.4 | 1.4, 2.0 | 1.2, 1.9 |
//! | `block` | `stream`, bunny and sponza | 2.1, 2.9 | 1.6, 1.8 | 0.97, 0.99 | 0.96, 0.99 |
//! | `stream` | `single`, bunny and sponza | 0.97, 1.02 | 2.4, 1.3 | 1.7, 1.5 | 1.7, 1.8 |
//! | `stream` | `packet`, bunny and sponza | 1.05, 1.00 | 1.3, 1.05 | 1.4, 1.5 | 1.4, 1.4 |
//!
//! `scalar` is the reference for all others. Measured with pictures of 512² pixels, one thread, kernel `woop`, on a
//! server processor with AVX-512 (Sapphire Rapids class). Blocks try incoherent rays first, which costs 1 to 4 %.

mod bvh;
mod image;
mod leaf;
mod load;
mod memory;
mod meshes;
mod scene;
mod trace;
mod walk;

pub use crate::error::{Error, printable, printable_path};
pub use crate::files::{check_output, hold_writes, write_atomically};
pub use image::{
    Camera, Differences, Light, OCCLUSION_RAYS, Picture, Shade, Shot, View, ViewError, block_order, compare,
    mark_colors, parse_point, picture_hits, shade,
};
#[cfg(feature = "study")]
pub(crate) use image::{OCCLUSION_REACH, hemisphere_rays, shadow_rays, surfaces};
pub use load::{BuiltIn, LoadedScene, SceneSource, load_mesh, load_scene, write_scene};
pub use memory::check_memory;
pub use meshes::{Mesh, MeshError, MeshReport, Part, load_obj, load_ply, load_stl};
#[cfg(feature = "study")]
pub(crate) use meshes::{has_zero_area, two_sum};
#[cfg(feature = "study")]
pub(crate) use scene::Leaving;
pub use scene::{Checker, Disc, Face, Filtered, Geometry, Paint, Placement, Scene, SurfacePoint, World, WorldError};
pub use trace::{
    Mode, Traceable, checksum, occluded, occluded_into, read_rays, start_global_pool, thread_pool, trace, trace_into,
    traversal_stats, write_hits, write_rays, write_wide_hits,
};
#[cfg(feature = "study")]
pub(crate) use trace::{threads_refused, trace_set_into};
pub use walk::TraversalStats;
pub use walk::filter::{Everything, Filter};
