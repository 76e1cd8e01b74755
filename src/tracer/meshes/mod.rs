//! Triangle meshes: the data, OBJ, PLY and STL files, and generated meshes.

mod closed;
mod corner_values;
#[cfg(feature = "study")]
mod derived;
pub(crate) mod generator;
mod line;
mod mesh;
mod number;
mod obj;
mod ply;
mod polygon;
mod reader;
mod report;
mod stl;

#[cfg(feature = "study")]
pub(crate) use mesh::has_zero_area;
pub(crate) use mesh::two_sum;
pub use mesh::{Mesh, MeshError, Part};
pub(crate) use number::Shortest;
pub use obj::load_obj;
pub(crate) use obj::{Materials, write_obj};
pub use ply::load_ply;
pub use report::MeshReport;
pub use stl::load_stl;
