//! Scene files in TOML: meshes and quadrics, instances of them, a camera and a light.
//!
//! `toml` parses a file into the structs of [`format`]. From these, [`builder`] makes the world, and [`view`] makes
//! camera and light. [`write`] makes a file of a world.

mod builder;
mod error;
mod format;
mod number;
mod quadric;
mod scatter;
mod transform;
mod view;
mod write;

use std::io::Read;
use std::path::Path;

use self::builder::WorldBuilder;
use self::error::{SceneError, SpanError};
use self::format::SceneFile;
pub use self::write::write_scene;
use super::loaded::LoadedScene;
use crate::error::{Error, quoted};
use crate::files::Input;

/// Largest size in bytes of a scene file. About 170,000 instances with matrices fit. `toml` takes some 25 times the
/// memory.
const MAX_BYTES: u64 = 1 << 25;

/// Loads a scene file in TOML, and the mesh files that it names.
///
/// # Tables
///
/// - `[camera]` has `eye` and `look_at`. Optional: `field_of_view` (vertical, in degrees, default 45) and `transform`,
///   which is applied to the camera.
/// - `[light]` has either `point`, its position, or `direction`, a vector towards it.
/// - `[[mesh]]` has `name`, and either `file` or `generator`. `file` is the path of an OBJ, PLY or STL file, relative
///   to the scene file. `generator` is `room`, `terrain`, `sphere`, `tree` or `square`. All but `square` can have a
///   number of triangles, as in `terrain:1e6`; the default is 100,000.
/// - `[[quadric]]` has `name`, and one of `sphere`, `ellipsoid`, `paraboloid`, `elliptic_paraboloid`,
///   `hyperboloid_of_one_sheet`, `hyperboloid_of_two_sheets`, `cone`, `cylinder`, `plane`. This is a table with the
///   arguments of the [constructor](crate::geom::Quadric) of the same name. With `closed = true`, cones, cylinders and
///   paraboloids [end in discs](crate::tracer::Geometry::closed_cylinder); without it, they are open. Or it has `disc`
///   with a `radius`. Or it has `coefficients`, ten numbers for x², y², z², yz, zx, xy, x, y, z and 1, and
///   `clip = { lo, hi }`.
/// - `[[instance]]` places a geometry. It has `of`, the name of a mesh or quadric. Optional: `transform`, and either
///   `color` or `checker`. The default is the colours of the mesh, or white for a quadric.
/// - `[[scatter]]` places many instances. It has `of` and `count`. Optional: `seed`, `on`, `area = { lo, hi }`,
///   `transform`, `scale = [least, greatest]`, `lean`, and either `color` or `checker`.
///
/// Any other key is an error.
///
/// # Values
///
/// A `transform` is a list of steps. The first step is applied first; see [`Transform3`](crate::geom::Transform3).
///
/// - `{ translate = [x, y, z] }`
/// - `{ scale = [x, y, z] }`, or `{ scale = factor }` for all axes
/// - `{ rotate_x = degrees }`, `rotate_y`, `rotate_z`
/// - `{ rotate = { axis = [x, y, z], degrees = 30 } }`, about any axis through the origin; its length does not matter
/// - `{ shear = { axis = "x", by = "y", factor = 0.5 } }`
/// - `{ matrix = [[…], […], […]] }`, the rows of the matrix, four numbers each. The fourth column is the translation. A
///   fourth row must be `[0, 0, 0, 1]`. The numbers are nested, because a flat list does not tell rows from columns.
///
/// A `checker` has two `colors` and an optional `transform` of the plane, from the surface's (u, v) to unit squares.
/// Its steps are `translate`, `scale`, `rotate`, `shear_x`, `shear_y` and `matrix`; see
/// [`Transform2`](crate::geom::Transform2). `scale` takes two factors or one. `matrix` takes two rows of three numbers;
/// the third column is the translation.
///
/// Colours are linear red, green and blue from 0 to 1.
///
/// # Scattered instances
///
/// They stand at random places in `area`, a rectangle in x and z, at height 0. If there is `on`, the name of a mesh or
/// quadric, they stand on top of that geometry, as its `[[instance]]` tables place it. Then `area` is optional. Each
/// instance is scaled, rotated about the y axis and sheared by up to `lean` times its height. The same file gives the
/// same bits on every machine.
///
/// # Order and defaults
///
/// Geometries are numbered in file order, meshes first, then quadrics. Instances are numbered in file order too, those
/// of `[[instance]]` first, then scattered ones. A geometry that is never placed gives a remark. The default for camera
/// and light is [`View::around`](crate::tracer::View::around).
///
/// # Errors
/// If a file cannot be read or is not valid. The error names the line and the key.
pub fn load_scene(path: &Path) -> Result<LoadedScene, Error> {
    let mut bytes = Vec::new();
    Input::open(path, MAX_BYTES)?.read_to_end(&mut bytes).map_err(Error::reading(path))?;
    let text = str::from_utf8(&bytes).map_err(|error| {
        let (before, rest) = bytes.split_at(error.valid_up_to());
        let line = before.iter().filter(|&&byte| byte == b'\n').count() + 1;
        let rest = rest.split(|&byte| byte == b'\n').next().unwrap_or_default();
        Error::in_line(path, line, format!("not UTF-8: {}", quoted(rest)))
    })?;
    from_text(path, text, None)
}

/// Makes the scene that `text` describes. Paths in it are relative to `file`. Generators and scatters without a size
/// get `size`.
pub(crate) fn from_text(file: &Path, text: &str, size: Option<u32>) -> Result<LoadedScene, Error> {
    make_scene(file, text, size).map_err(|error| error.in_file(file, text))
}

fn make_scene(path: &Path, text: &str, size: Option<u32>) -> Result<LoadedScene, SceneError> {
    let file: SceneFile = toml::from_str(text).map_err(|error| SpanError::of_parser(&error, text))?;
    let mut builder = WorldBuilder::new(path, size);
    for mesh in &file.mesh {
        builder.add_mesh(mesh)?;
    }
    for quadric in &file.quadric {
        builder.add_quadric(quadric)?;
    }
    for instance in &file.instance {
        builder.add_instance(instance)?;
    }
    builder.add_scatters(&file.scatter)?;
    let (world, remarks) = builder.finish()?;
    let view = view::view(&file, &world)?;
    Ok(LoadedScene { world, view, remarks })
}
