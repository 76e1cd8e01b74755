//! Scene files, in TOML: meshes and quadrics, instances of them, a camera and a light.

mod fault;
mod format;
mod scatter;

use std::collections::HashMap;
use std::fmt::Display;
use std::fs::File;
use std::io::Read;
use std::ops::Range;
use std::path::Path;

use glam::{Affine2, Affine3, DVec2, Vec3};
use toml::Spanned;

use self::fault::Fault;
use self::format::{Area, SceneFile, Step2, Step3, Steps};
use self::scatter::{Ground, Variation};
use super::loaded::{LoadedScene, has_extension, remarks};
use crate::error::{Error, quoted};
use crate::geom::{Aabb, InvalidTransform, Transform2, Transform3};
use crate::tracer::image::{Light, View};
use crate::tracer::meshes::generator::{DEFAULT_SIZE, Generator, MOST};
use crate::tracer::meshes::load_obj;
use crate::tracer::scene::{Checker, Geometry, Paint, Placement, World, can_be_hit, is_singular};

/// Longest file, in bytes. What needs more lines is a mesh or a scatter.
const LONGEST: u64 = 1 << 24;

/// Loads a scene file, and the OBJ files it names.
///
/// | table | keys |
/// | --- | --- |
/// | `[camera]` | `eye`, `look_at`; if wanted, `field_of_view` (vertical, in degrees, else 45) and `transform`, which is applied to the camera that these describe |
/// | `[light]` | `point`, where it is, or `direction`, towards it |
/// | `[[mesh]]` | `name`, and `file`, an OBJ file whose path starts at the scene file, or `generator`: `room`, `terrain`, `sphere`, `tree`, with a size if you like (`terrain:1e6`, else 100,000 triangles), or `square` |
/// | `[[quadric]]` | `name`, and one of `sphere`, `ellipsoid`, `paraboloid`, `elliptic_paraboloid`, `hyperboloid_of_one_sheet`, `hyperboloid_of_two_sheets`, `cone`, `cylinder`, each a table of what the [constructor](crate::geom::Quadric) of that name takes; or `coefficients`, ten of them, of x², y², z², yz, zx, xy, x, y, z, 1, with `clip = { lo, hi }` |
/// | `[[instance]]` | `of`, a name; if wanted, `transform`, and `color` or `checker`, else it has the mesh's own colours, or is white |
/// | `[[scatter]]` | many instances: `of`, `count`; if wanted, `seed`, `on`, `area = { lo, hi }`, `transform`, `scale = [least, greatest]`, `lean`, and `color` or `checker` |
///
/// A `transform` is a list of steps, the first one applied first: `{ translate = [x, y, z] }`, `{ scale = [x, y, z] }`,
/// `{ rotate_x = degrees }`, `rotate_y`, `rotate_z`, `{ shear = { axis = "x", by = "y", factor = 0.5 } }`; see
/// [`Transform3`]. A checker has two `colors` and a `transform` of its own, in the plane, from the surface's (u, v) to unit
/// squares: `translate`, `scale`, `rotate`, `shear_x`, `shear_y`; see [`Transform2`]. Colours are linear red, green and
/// blue from 0 to 1.
///
/// A scatter puts its instances at random places of the area, a rectangle in x and z, at height 0; with `on`, the name of a
/// mesh, on top of that mesh as its instances place it, and `area` need not be given. Each is scaled, turned about the y
/// axis and sheared by up to `lean` times its height. The same file gives the same bits on every machine.
///
/// Nothing is placed but by an instance or a scatter; what is never placed is told in a remark. Geometries are numbered
/// meshes first, then quadrics, instances before what is scattered, each in the order of the file. Without camera or light
/// there is that of [`View::around`].
///
/// Whatever else stands in a file is an error that tells its line and key.
///
/// # Errors
/// If a file cannot be read, or has something in it that makes no sense.
pub fn load_scene(path: &Path) -> Result<LoadedScene, Error> {
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(Error::reading(path))?;
    file.take(LONGEST + 1).read_to_end(&mut bytes).map_err(Error::reading(path))?;
    if bytes.len() as u64 > LONGEST {
        return Err(Error::in_file(path, format!("longer than {LONGEST} bytes")));
    }
    let text = str::from_utf8(&bytes).map_err(|error| {
        let (before, rest) = bytes.split_at(error.valid_up_to());
        let line = before.iter().filter(|&&byte| byte == b'\n').count() + 1;
        let rest = rest.split(|&byte| byte == b'\n').next().unwrap_or_default();
        Error::in_line(path, line, format!("not UTF-8: {}", quoted(rest)))
    })?;
    from_text(path, text, None)
}

/// The scene that `text` describes. Paths start at `file`; generators and scatters that tell no size take this one.
pub(crate) fn from_text(file: &Path, text: &str, size: Option<u32>) -> Result<LoadedScene, Error> {
    assemble(file, text, size).map_err(|problem| match problem {
        Problem::Here(fault) => fault.in_file(file, text),
        Problem::Elsewhere(error) => error,
    })
}

enum Problem {
    Here(Fault),
    Elsewhere(Error),
}

impl<F: Into<Fault>> From<F> for Problem {
    fn from(fault: F) -> Self {
        Self::Here(fault.into())
    }
}

fn fault(span: Range<usize>, message: impl Into<String>) -> Fault {
    Fault { span, message: message.into() }
}

fn assemble(path: &Path, text: &str, size: Option<u32>) -> Result<LoadedScene, Problem> {
    let file: SceneFile = toml::from_str(text)?;
    let mut assembly = Assembly::new(path, size);
    for mesh in &file.mesh {
        assembly.add_mesh(mesh)?;
    }
    for quadric in &file.quadric {
        let shape = quadric.get_ref().quadric().map_err(|message| fault(quadric.span(), message))?;
        assembly.add(&quadric.get_ref().name, Geometry::Quadric(shape))?;
    }
    for instance in &file.instance {
        assembly.place(instance)?;
    }
    let fixed = assembly.placements.len();
    let mut grounds = HashMap::new();
    for scatter in &file.scatter {
        assembly.scatter(scatter, fixed, &mut grounds)?;
    }
    let (world, remarks) = assembly.finish()?;
    let mut view = View::around(&bounds(&world));
    if let Some(camera) = &file.camera {
        let (span, camera) = (camera.span(), camera.get_ref());
        view.eye = camera.eye.0;
        view.look_at = camera.look_at.0;
        view.vertical_fov = camera.field_of_view.map_or(45.0, |degrees| degrees.0);
        view.transform = camera.transform.as_ref().map(chain).transpose()?;
        if (view.look_at - view.eye).try_normalize().is_none() {
            let message = format!("eye and look_at give no direction: {} and {}", view.eye, view.look_at);
            return Err(fault(span, message).into());
        }
    }
    if let Some(light) = &file.light {
        view.light = match (&light.get_ref().point, &light.get_ref().direction) {
            (Some(point), None) => Light::Point(point.0),
            (None, Some(direction)) if direction.get_ref().0.try_normalize().is_some() => {
                Light::Directional(direction.get_ref().0)
            }
            (None, Some(direction)) => {
                let message = format!("no direction: {}", direction.get_ref().0);
                return Err(fault(direction.span(), message).into());
            }
            _ => return Err(fault(light.span(), "a light needs either point or direction").into()),
        };
    }
    Ok(LoadedScene { world, view, remarks })
}

/// What has been read so far.
struct Assembly<'a> {
    path: &'a Path,
    size: Option<u32>,
    numbers: HashMap<&'a str, u32>,
    names: Vec<&'a str>,
    geometries: Vec<Geometry>,
    placements: Vec<Placement>,
    remarks: Vec<String>,
}

impl<'a> Assembly<'a> {
    fn new(path: &'a Path, size: Option<u32>) -> Self {
        Self {
            path,
            size,
            numbers: HashMap::new(),
            names: Vec::new(),
            geometries: Vec::new(),
            placements: Vec::new(),
            remarks: Vec::new(),
        }
    }

    fn add_mesh(&mut self, mesh: &'a Spanned<format::Mesh>) -> Result<(), Problem> {
        let (span, format::Mesh { name, file, generator }) = (mesh.span(), mesh.get_ref());
        let mesh = match (file, generator) {
            (Some(file), None) => {
                if !has_extension(file.get_ref(), "obj") {
                    let message = format!("expected an OBJ file (*.obj): {}", shown(file.get_ref()));
                    return Err(fault(file.span(), message).into());
                }
                let path = self.path.with_file_name("").join(file.get_ref());
                let (mesh, report) = load_obj(&path).map_err(Problem::Elsewhere)?;
                self.remarks.extend(remarks(report).into_iter().map(|remark| format!("{}: {remark}", name.get_ref())));
                mesh
            }
            (None, Some(generator)) => Generator::parse(generator.get_ref(), self.size.unwrap_or(DEFAULT_SIZE))
                .map_err(|message| {
                    fault(generator.span(), format!("{message}: {}", quoted(generator.get_ref().as_bytes())))
                })?
                .mesh(),
            _ => return Err(fault(span, "a mesh needs either file or generator").into()),
        };
        self.add(name, Geometry::Mesh(mesh))
    }

    fn add(&mut self, name: &'a Spanned<String>, geometry: Geometry) -> Result<(), Problem> {
        let number = self.geometries.len() as u32;
        if self.numbers.insert(name.get_ref(), number).is_some() {
            return Err(fault(name.span(), format!("another one has this name: {}", shown(name.get_ref()))).into());
        }
        if !can_be_hit(&geometry) {
            let message = "no ray hits it: the coefficients are too large or all zero, or the box is empty";
            return Err(fault(name.span(), format!("{message}: {}", shown(name.get_ref()))).into());
        }
        self.names.push(name.get_ref());
        self.geometries.push(geometry);
        Ok(())
    }

    /// The number of a geometry, by its name.
    fn number(&self, name: &Spanned<String>) -> Result<u32, Fault> {
        let number = self.numbers.get(name.get_ref().as_str());
        number
            .copied()
            .ok_or_else(|| fault(name.span(), format!("no mesh or quadric has this name: {}", shown(name.get_ref()))))
    }

    fn place(&mut self, instance: &Spanned<format::Instance>) -> Result<(), Problem> {
        let (span, format::Instance { of, transform, color, checker }) = (instance.span(), instance.get_ref());
        let object_to_world = transform.as_ref().map_or(Ok(Affine3::IDENTITY), chain)?;
        let paint = paint(&span, color.as_ref(), checker.as_ref())?;
        self.placements.push(Placement { geometry: self.number(of)?, object_to_world, paint });
        Ok(())
    }

    /// `fixed` placements come from instances; `grounds` are those that were needed before.
    fn scatter(
        &mut self,
        scatter: &Spanned<format::Scatter>,
        fixed: usize,
        grounds: &mut HashMap<u32, Ground>,
    ) -> Result<(), Problem> {
        let (span, scatter) = (scatter.span(), scatter.get_ref());
        let geometry = self.number(&scatter.of)?;
        let paint = paint(&span, scatter.color.as_ref(), scatter.checker.as_ref())?;
        let Some(count) = scatter.count.as_ref().map(|count| count.get_ref().0).or(self.size) else {
            return Err(fault(span, "missing field `count`").into());
        };
        if self.placements.len() + count as usize > MOST as usize {
            let span = scatter.count.as_ref().map_or(span, Spanned::span);
            return Err(fault(span, format!("more than {MOST} instances")).into());
        }
        let ground = match &scatter.on {
            None => None,
            Some(on) => {
                let number = self.number(on)?;
                let is_there = |placement: &&Placement| placement.geometry == number;
                if !self.placements[..fixed].iter().any(|placement| is_there(&placement)) {
                    let message = format!("has no instance to stand on: {}", shown(on.get_ref()));
                    return Err(fault(on.span(), message).into());
                }
                let here = self.placements[..fixed].iter().filter(is_there);
                let ground = || Ground::new(&self.geometries[number as usize], here);
                Some(&*grounds.entry(number).or_insert_with(ground))
            }
        };
        let area = match (&scatter.area, ground) {
            (Some(area), _) => rectangle(area)?,
            (None, Some(ground)) => ground.area(),
            (None, None) => return Err(fault(span, "a scatter needs on or area").into()),
        };
        let scale = match &scatter.scale {
            None => [1.0; 2],
            Some(scale) => {
                let [least, greatest] = scale.get_ref().map(|factor| factor.0);
                if least > greatest {
                    let message = format!("the least scale comes first: [{least}, {greatest}]");
                    return Err(fault(scale.span(), message).into());
                }
                [least.into(), greatest.into()]
            }
        };
        let transform = scatter.transform.as_ref().map_or(Ok(Affine3::IDENTITY), chain)?;
        let seed = scatter.seed.map_or(0, |seed| seed.0);
        let lean = scatter.lean.map_or(0.0, |lean| lean.0.into());
        let variation = Variation { seed, area, transform, scale, lean };
        for index in 0..count {
            let Some(object_to_world) = variation.transform(index, ground) else {
                return Err(fault(span, "hardly any ground in the area").into());
            };
            if is_singular(object_to_world) {
                return Err(fault(span, format!("instance {index} has no inverse: {object_to_world}")).into());
            }
            self.placements.push(Placement { geometry, object_to_world, paint });
        }
        Ok(())
    }

    /// The world, if it is one, and the remarks.
    fn finish(mut self) -> Result<(World, Vec<String>), Problem> {
        let mut is_placed = vec![false; self.geometries.len()];
        for placement in &self.placements {
            is_placed[placement.geometry as usize] = true;
        }
        let never = self.names.iter().zip(is_placed).filter(|(_, is_placed)| !is_placed);
        self.remarks.extend(never.map(|(name, _)| format!("never placed: {}", shown(name))));
        let world = World::new(self.geometries, self.placements)
            .map_err(|error| Problem::Elsewhere(Error::in_file(self.path, error.to_string())))?;
        Ok((world, self.remarks))
    }
}

/// A name or path of a file in quotes.
fn shown(name: impl AsRef<Path>) -> String {
    quoted(name.as_ref().to_string_lossy().as_bytes())
}

fn chain(steps: &Steps<Step3>) -> Result<Affine3, Fault> {
    let transform = Transform3::chain(&checked(steps, Transform3::check)?);
    if is_singular(transform) {
        return Err(fault(steps.span(), format!("too large, or has no inverse: {transform}")));
    }
    Ok(transform)
}

fn chain2(steps: &Steps<Step2>) -> Result<Affine2, Fault> {
    let transform = Transform2::chain(&checked(steps, Transform2::check)?);
    if !transform.is_finite() {
        return Err(fault(steps.span(), format!("too large: {transform}")));
    }
    Ok(transform)
}

fn checked<S: Copy + Into<T>, T: Display>(
    steps: &Steps<S>,
    check: impl Fn(&T) -> Result<(), InvalidTransform<T>>,
) -> Result<Vec<T>, Fault> {
    let steps = steps.get_ref().iter().map(|step| {
        let transform = (*step.get_ref()).into();
        check(&transform).map_err(|error| fault(step.span(), error.to_string()))?;
        Ok(transform)
    });
    steps.collect()
}

fn paint(
    span: &Range<usize>,
    color: Option<&format::Color>,
    checker: Option<&format::Checker>,
) -> Result<Paint, Fault> {
    match (color, checker) {
        (None, None) => Ok(Paint::Own),
        (Some(color), None) => Ok(Paint::Plain(color.0)),
        (None, Some(format::Checker { colors: [a, b], transform })) => {
            let uv_to_squares = transform.as_ref().map_or(Ok(Affine2::IDENTITY), chain2)?;
            Ok(Paint::Checker(Checker { colors: [a.0, b.0], uv_to_squares }))
        }
        (Some(_), Some(_)) => Err(fault(span.clone(), "either color or checker, not both")),
    }
}

fn rectangle(area: &Spanned<Area>) -> Result<[DVec2; 2], Fault> {
    let Area { lo, hi } = *area.get_ref();
    let [lo, hi] = [lo, hi].map(|[x, z]| DVec2::new(x.0.into(), z.0.into()));
    if lo.cmple(hi).all() { Ok([lo, hi]) } else { Err(fault(area.span(), format!("empty: from {lo} to {hi}"))) }
}

/// A box around a world, for a camera that the file does not tell.
fn bounds(world: &World) -> Aabb {
    let own: Vec<_> = world.geometries().iter().map(Geometry::bounds).collect();
    world.instances().iter().fold(Aabb::EMPTY, |bounds, placement| {
        let Aabb { lo, hi } = own[placement.geometry as usize];
        (0..8).fold(bounds, |bounds, corner| {
            let corner = Vec3::select(glam::BVec3::new(corner & 1 != 0, corner & 2 != 0, corner & 4 != 0), hi, lo);
            bounds.including(placement.object_to_world.transform_point3(corner))
        })
    })
}
