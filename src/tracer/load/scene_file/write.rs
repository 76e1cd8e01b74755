//! Writes a world and a view as a scene file, with an OBJ file for each mesh.

use std::ffi::OsStr;
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use glam::{Affine2, Affine3, Vec2, Vec3};

use super::MAX_BYTES;
use super::number::{FieldOfView, Finite, Length, Number};
use crate::error::{Error, printable};
use crate::files::{check_output, write_together};
use crate::geom::{Aabb, Quadric, Transform2};
use crate::tracer::image::{Light, View};
use crate::tracer::load::loaded::has_extension;
use crate::tracer::meshes::{Materials, Mesh, Shortest, write_obj};
use crate::tracer::scene::{Checker, Disc, Face, Geometry, Paint, Placement, World, is_singular};

/// Writes a scene file that [`load_scene`](super::load_scene) reads back, and beside it the files that it names.
/// Returns the paths of all, that of the scene file last.
///
/// For `out.toml` these are `out-mesh-1.obj` and so on, one for each mesh, and if meshes have colours, `out.mtl`. All
/// files are written completely, or none: no old file is replaced before all new ones are complete. Files that this
/// process has read are not written over.
///
/// # What is read back
///
/// The same world and view, bit for bit. Numbers have the fewest digits that read back to the same `f32`, and the signs
/// of zeros are kept. Meshes keep the order and the corners of their triangles, parts, normals and texture coordinates.
/// Instances keep their order, and their transforms are matrices. Quadrics are written as coefficients and clip box.
///
/// These differ:
///
/// - Geometries are read back meshes first. If quadrics come before meshes, geometries are numbered anew, each kind in
///   its old order. Primitive numbers follow them.
/// - Vertices that no triangle uses are left out, and so are normals and texture coordinates if no triangle has any.
///
/// # Errors
/// If the world or the view holds something that scene files do not: an instance with a mask; faces that are no disc
/// and no closed cylinder, cone or paraboloid, or are one beyond the range of a file; a checker whose transform has no
/// inverse; a camera or light that a file cannot have; more instances than the largest file can hold. If the path does
/// not end in `.toml`. If a file cannot be written, or has been read by this process. Nothing is written then.
pub fn write_scene(world: &World, view: &View, path: &Path) -> Result<Vec<PathBuf>, Error> {
    let refuse = |message: String| Error::writing(path)(io::Error::new(ErrorKind::InvalidInput, message));
    let names = Names::new(path).map_err(refuse)?;
    let meshes = || {
        world.geometries().iter().filter_map(|geometry| match geometry {
            Geometry::Mesh(mesh) => Some(mesh),
            _ => None,
        })
    };
    let materials = &Materials::of(meshes());
    let scene = scene_text(world, view, &names).map_err(refuse)?;
    if scene.len() as u64 > MAX_BYTES {
        let (bytes, instances) = (scene.len(), world.instances().len());
        let message = format!("{instances} instances take {bytes} bytes, but a scene file has at most {MAX_BYTES}");
        return Err(refuse(message));
    }

    let library = &names.library();
    let beside = |name: &str| path.with_file_name(name);
    let mut files: Vec<_> =
        (1..).zip(meshes()).map(|(number, mesh)| (beside(&names.mesh(number)), Content::Mesh(mesh))).collect();
    if !materials.is_empty() {
        files.push((beside(library), Content::Materials(materials)));
    }
    // The scene file comes last: where it is, the files that it names are too.
    files.push((path.to_owned(), Content::Scene(&scene)));
    let paths: Vec<_> = files.iter().map(|(path, _)| path.clone()).collect();
    paths.iter().try_for_each(|path| check_output(path))?;
    let contents = files.into_iter().map(|(path, content)| {
        let write = move |out: &mut dyn Write| match content {
            Content::Mesh(mesh) => write_obj(mesh, materials, library, out),
            Content::Materials(materials) => materials.write(out),
            Content::Scene(text) => out.write_all(text.as_bytes()),
        };
        (path, write)
    });
    write_together(path, contents)?;
    Ok(paths)
}

/// What one file holds.
enum Content<'a> {
    Mesh(&'a Mesh),
    Materials(&'a Materials),
    Scene(&'a str),
}

/// The names of the files beside a scene file.
struct Names<'a> {
    /// The name of the scene file without its extension.
    stem: &'a str,
}

impl<'a> Names<'a> {
    /// Refuses names that a scene file or an OBJ file cannot hold.
    fn new(path: &'a Path) -> Result<Self, String> {
        if !has_extension(path, "toml") {
            return Err("expected a scene file (*.toml)".into());
        }
        let stem = path.file_stem().and_then(OsStr::to_str).ok_or("its name is not UTF-8")?;
        if stem.contains(char::is_control) || stem.trim_start() != stem {
            return Err(format!("a mesh file cannot be named after \"{}\"", printable(stem)));
        }
        Ok(Self { stem })
    }

    /// The OBJ file of a mesh. Meshes are counted from 1.
    fn mesh(&self, number: usize) -> String {
        format!("{}-mesh-{number}.obj", self.stem)
    }

    /// The MTL file.
    fn library(&self) -> String {
        format!("{}.mtl", self.stem)
    }
}

/// The text of the scene file, or what it cannot hold. Geometries and instances are counted from 0 in messages.
fn scene_text(world: &World, view: &View, names: &Names<'_>) -> Result<String, String> {
    let mut text = view_text(view)?;
    let (mut meshes, mut quadrics) = (String::new(), String::new());
    let (mut mesh_count, mut quadric_count) = (0, 0);
    let mut geometry_names = Vec::new();
    for (number, geometry) in world.geometries().iter().enumerate() {
        let (table, kind, count, shape) = match geometry {
            Geometry::Mesh(_) => {
                let file = names.mesh(mesh_count + 1).replace('\\', "\\\\").replace('"', "\\\"");
                (&mut meshes, "mesh", &mut mesh_count, format!("file = \"{file}\""))
            }
            Geometry::Quadric(quadric) => (&mut quadrics, "quadric", &mut quadric_count, quadric_text(quadric)),
            Geometry::Faces(faces) => {
                let shape = faces_text(geometry, faces).map_err(|message| format!("geometry {number}: {message}"))?;
                (&mut quadrics, "quadric", &mut quadric_count, shape)
            }
        };
        *count += 1;
        let name = format!("{kind} {count}");
        *table += &format!("\n[[{kind}]]\nname = \"{name}\"\n{shape}\n");
        geometry_names.push(name);
    }
    text += &meshes;
    text += &quadrics;
    for (number, placement) in world.instances().iter().enumerate() {
        let instance = instance_text(placement).map_err(|message| format!("instance {number}: {message}"))?;
        text += &format!("\n[[instance]]\nof = \"{}\"\n{instance}", geometry_names[placement.geometry as usize]);
    }
    Ok(text)
}

/// The tables of camera and light.
fn view_text(view: &View) -> Result<String, String> {
    let &View { eye, look_at, vertical_fov, transform, light } = view;
    let point = |key: &str, point: Vec3| {
        point.to_array().into_iter().try_for_each(|number| check::<Finite>(key, number))?;
        Ok::<_, String>(list(&point.to_array()))
    };
    if eye == look_at {
        return Err(format!("camera.eye and camera.look_at give no direction: {eye} and {look_at}"));
    }
    check::<FieldOfView>("camera.field_of_view", vertical_fov)?;
    let mut text = format!(
        "[camera]\neye = {}\nlook_at = {}\nfield_of_view = {}\n",
        point("camera.eye", eye)?,
        point("camera.look_at", look_at)?,
        Shortest(vertical_fov)
    );
    if let Some(transform) = transform {
        if is_singular(transform) {
            return Err(format!("camera.transform has no inverse: {transform}"));
        }
        text += &format!("transform = {}\n", matrix3(&transform));
    }
    let light = match light {
        Light::Point(position) => format!("point = {}", point("light.point", position)?),
        Light::Directional(Vec3::ZERO) => return Err("light.direction is zero".into()),
        Light::Directional(direction) => format!("direction = {}", point("light.direction", direction)?),
    };
    text += &format!("\n[light]\n{light}\n");
    Ok(text)
}

fn quadric_text(quadric: &Quadric) -> String {
    let &Quadric { squares, products, linear, constant, clip: Aabb { lo, hi } } = quadric;
    let vectors = [squares, products, linear].map(|vector| vector.to_array());
    let coefficients = [vectors.as_flattened(), &[constant]].concat();
    let [lo, hi] = [lo, hi].map(|corner| list(&corner.to_array()));
    format!("coefficients = {}\nclip = {{ lo = {lo}, hi = {hi} }}", list(&coefficients))
}

/// The key of the constructor that makes these faces.
fn faces_text(geometry: &Geometry, faces: &[Face]) -> Result<String, String> {
    let unknown = || "its faces are no disc, and no closed cylinder, cone or paraboloid".to_owned();
    let Some(&Face::Disc(Disc { radius, height, .. })) = faces.last() else { return Err(unknown()) };
    let (r, h) = (Shortest(radius), Shortest(height));
    let known = [
        (Geometry::disc(radius), format!("disc = {{ radius = {r} }}")),
        (
            Geometry::closed_cylinder(radius, height),
            format!("cylinder = {{ radius = {r}, half_height = {h}, closed = true }}"),
        ),
        (Geometry::closed_cone(radius, height), format!("cone = {{ radius = {r}, height = {h}, closed = true }}")),
        (
            Geometry::closed_paraboloid(radius, height),
            format!("paraboloid = {{ radius = {r}, height = {h}, closed = true }}"),
        ),
    ];
    // Debug tells -0 from 0, and == does not.
    let is_same = |made: &Geometry| made == geometry && format!("{made:?}") == format!("{geometry:?}");
    let (_, text) = known.into_iter().find(|(made, _)| is_same(made)).ok_or_else(unknown)?;
    check::<Length>("the radius", radius)?;
    if faces.len() > 1 {
        check::<Length>("the height", height)?;
    }
    Ok(text)
}

/// The keys of an instance after `of`.
fn instance_text(placement: &Placement) -> Result<String, String> {
    let &Placement { object_to_world, paint, mask, .. } = placement;
    if mask != u32::MAX {
        return Err(format!("the mask {mask:#x} cannot be written: instances of a file are in every group"));
    }
    let mut text = String::new();
    if object_to_world.to_cols_array().map(f32::to_bits) != Affine3::IDENTITY.to_cols_array().map(f32::to_bits) {
        text += &format!("transform = {}\n", matrix3(&object_to_world));
    }
    match paint {
        Paint::Own => {}
        Paint::Plain(color) => text += &format!("color = {}\n", list(&color.to_array())),
        Paint::Checker(Checker { colors, uv_to_squares }) => {
            let [a, b] = colors.map(|color| list(&color.to_array()));
            text += &format!("checker = {{ colors = [{a}, {b}]{} }}\n", checker_transform(uv_to_squares)?);
        }
    }
    Ok(text)
}

/// The key `transform` of a checker, after a comma. Empty for the identity.
fn checker_transform(uv_to_squares: Affine2) -> Result<String, String> {
    if uv_to_squares.to_cols_array().map(f32::to_bits) == Affine2::IDENTITY.to_cols_array().map(f32::to_bits) {
        return Ok(String::new());
    }
    Transform2::Matrix(uv_to_squares).check().map_err(|error| format!("checker: {error}"))?;
    let Affine2 { matrix2, translation } = uv_to_squares;
    let row = |axis| list(&Vec2::extend(matrix2.row(axis), translation[axis]).to_array());
    Ok(format!(", transform = [{{ matrix = [{}, {}] }}]", row(0), row(1)))
}

/// A list of one transform.
fn matrix3(Affine3 { matrix3, translation }: &Affine3) -> String {
    let [x, y, z] = [0, 1, 2].map(|axis| list(&matrix3.row(axis).extend(translation[axis]).to_array()));
    format!("[{{ matrix = [{x}, {y}, {z}] }}]")
}

fn list(numbers: &[f32]) -> String {
    let numbers: Vec<_> = numbers.iter().map(|&number| Shortest(number).to_string()).collect();
    format!("[{}]", numbers.join(", "))
}

/// Checks that a number is in the range that the file allows.
fn check<N: Number>(what: &str, number: f32) -> Result<(), String> {
    if N::accepts(number.into()) { Ok(()) } else { Err(format!("{what} is {number:?}, expected {}", N::EXPECTED)) }
}
