//! Triangle meshes: the data, OBJ files, and generated meshes.

mod closed;
mod corner_values;
pub(crate) mod generator;
mod mesh;
mod obj;

pub(crate) use mesh::two_sum;
pub use mesh::{Mesh, MeshError, Part};
pub use obj::{ObjReport, load_obj};
