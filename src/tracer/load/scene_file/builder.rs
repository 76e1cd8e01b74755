//! Makes a world from the tables of a scene file.

use std::collections::HashMap;
use std::ops::Range;
use std::path::Path;

use glam::{Affine2, Affine3, DVec2};
use toml::Spanned;

use super::error::{SceneError, SpanError, quoted_name};
use super::format::{self, Area};
use super::number::{Array, Color};
use super::quadric::QuadricTable;
use super::scatter::{self, Ground, Variation};
use super::transform::{compose2, compose3};
use crate::error::{Error, and_more, printable, quoted};
use crate::tracer::load::loaded::{MESH_FILES, is_mesh_file, load_mesh, mesh_remarks};
use crate::tracer::memory::check_memory;
use crate::tracer::meshes::generator::{DEFAULT_SIZE, Generator, MAX_SIZE};
use crate::tracer::scene::{Checker, Geometry, Paint, Placement, World, is_singular};

/// The world as far as it has been read.
pub(super) struct WorldBuilder<'a> {
    /// Path of the scene file.
    path: &'a Path,
    /// Size of generators and scatters that have none.
    size: Option<u32>,
    /// Number of each geometry, by name.
    numbers: HashMap<&'a str, u32>,
    /// Names of the geometries.
    names: Vec<&'a str>,
    geometries: Vec<Geometry>,
    placements: Vec<Placement>,
    remarks: Vec<String>,
}

impl<'a> WorldBuilder<'a> {
    pub(super) fn new(path: &'a Path, size: Option<u32>) -> Self {
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

    pub(super) fn add_mesh(&mut self, mesh: &'a Spanned<format::Mesh>) -> Result<(), SceneError> {
        let (span, format::Mesh { name, file, generator }) = (mesh.span(), mesh.get_ref());
        let mesh = match (file, generator) {
            (Some(file), None) => {
                if !is_mesh_file(file.get_ref()) {
                    let message = format!("expected {MESH_FILES}: {}", quoted_name(file.get_ref()));
                    return Err(SpanError::new(file.span(), message).into());
                }
                let path = self.path.with_file_name("").join(file.get_ref());
                let (mesh, report) = load_mesh(&path).map_err(SceneError::Other)?;
                let remarks = mesh_remarks(report).into_iter();
                self.remarks.extend(remarks.map(|remark| format!("{}: {remark}", printable(name.get_ref()))));
                mesh
            }
            (None, Some(generator)) => {
                let refused = |message: String| {
                    let message = format!("{message}: {}", quoted(generator.get_ref().as_bytes()));
                    SpanError::new(generator.span(), message)
                };
                let parsed =
                    Generator::parse(generator.get_ref(), self.size.unwrap_or(DEFAULT_SIZE)).map_err(refused)?;
                check_memory(parsed.bytes()).map_err(refused)?;
                parsed.mesh()
            }
            _ => return Err(SpanError::new(span, "a mesh needs either file or generator").into()),
        };
        self.add_geometry(name, Geometry::Mesh(mesh))
    }

    pub(super) fn add_quadric(&mut self, quadric: &'a Spanned<QuadricTable>) -> Result<(), SceneError> {
        let (span, quadric) = (quadric.span(), quadric.get_ref());
        let geometry = quadric.geometry().map_err(|message| SpanError::new(span, message))?;
        self.add_geometry(&quadric.name, geometry)
    }

    fn add_geometry(&mut self, name: &'a Spanned<String>, geometry: Geometry) -> Result<(), SceneError> {
        let number = self.geometries.len() as u32;
        if self.numbers.insert(name.get_ref(), number).is_some() {
            let message = format!("another mesh or quadric has this name: {}", quoted_name(name.get_ref()));
            return Err(SpanError::new(name.span(), message).into());
        }
        if !geometry.is_valid() {
            let message = "no ray hits it: the coefficients are too large or all zero, or the box is empty";
            return Err(SpanError::new(name.span(), format!("{message}: {}", quoted_name(name.get_ref()))).into());
        }
        self.names.push(name.get_ref());
        self.geometries.push(geometry);
        Ok(())
    }

    /// The number of the geometry with this name.
    fn number(&self, name: &Spanned<String>) -> Result<u32, SpanError> {
        self.numbers.get(name.get_ref().as_str()).copied().ok_or_else(|| {
            let message = format!("no mesh or quadric has this name: {}", quoted_name(name.get_ref()));
            SpanError::new(name.span(), message)
        })
    }

    pub(super) fn add_instance(&mut self, instance: &Spanned<format::Instance>) -> Result<(), SceneError> {
        let (span, format::Instance { of, transform, color, checker }) = (instance.span(), instance.get_ref());
        let object_to_world = transform.as_ref().map_or(Ok(Affine3::IDENTITY), compose3)?;
        let paint = paint(&span, color.as_ref(), checker.as_ref())?;
        self.placements.push(Placement::new(self.number(of)?, object_to_world).with_paint(paint));
        Ok(())
    }

    /// Adds all scattered instances. Call it after all calls of [`WorldBuilder::add_instance`].
    pub(super) fn add_scatters(&mut self, scatters: &[Spanned<format::Scatter>]) -> Result<(), SceneError> {
        let instances = self.placements.len();
        let mut grounds = HashMap::new();
        for scatter in scatters {
            self.add_scatter(scatter, instances, &mut grounds)?;
        }
        Ok(())
    }

    /// Adds the instances of one scatter. They can stand on the first `instances` placements. `grounds` keeps prepared
    /// grounds for the next scatter.
    fn add_scatter(
        &mut self,
        scatter: &Spanned<format::Scatter>,
        instances: usize,
        grounds: &mut HashMap<u32, Ground>,
    ) -> Result<(), SceneError> {
        let (span, scatter) = (scatter.span(), scatter.get_ref());
        let geometry = self.number(&scatter.of)?;
        let paint = paint(&span, scatter.color.as_ref(), scatter.checker.as_ref())?;
        let Some(count) = scatter.count.as_ref().map(|count| count.get_ref().0).or(self.size) else {
            return Err(SpanError::new(span, "missing field `count`").into());
        };
        if self.placements.len() + count as usize > MAX_SIZE as usize {
            let span = scatter.count.as_ref().map_or(span, Spanned::span);
            return Err(SpanError::new(span, format!("more than {MAX_SIZE} instances")).into());
        }
        self.placements.try_reserve_exact(count as usize).map_err(|_| {
            let bytes = count as usize * size_of::<Placement>();
            SpanError::new(span.clone(), format!("not enough memory: {count} instances take {bytes} bytes"))
        })?;
        let ground = match &scatter.on {
            None => None,
            Some(on) => {
                let number = self.number(on)?;
                let shows_it = |placement: &&Placement| placement.geometry == number;
                if !self.placements[..instances].iter().any(|placement| shows_it(&placement)) {
                    let message = format!("there is no instance of this to stand on: {}", quoted_name(on.get_ref()));
                    return Err(SpanError::new(on.span(), message).into());
                }
                let placements = self.placements[..instances].iter().filter(shows_it);
                let ground = || Ground::new(&self.geometries[number as usize], placements);
                Some(&*grounds.entry(number).or_insert_with(ground))
            }
        };
        let area = match (&scatter.area, ground) {
            (Some(area), _) => corners(area)?,
            (None, Some(ground)) => ground.area(),
            (None, None) => return Err(SpanError::new(span, "a scatter needs on or area").into()),
        };
        let scale = match &scatter.scale {
            None => [1.0; 2],
            Some(scale) => {
                let [least, greatest] = scale.get_ref().0.map(|factor| factor.0);
                if least > greatest {
                    let message = format!("the least scale comes first: [{least}, {greatest}]");
                    return Err(SpanError::new(scale.span(), message).into());
                }
                [least.into(), greatest.into()]
            }
        };
        let transform = scatter.transform.as_ref().map_or(Ok(Affine3::IDENTITY), compose3)?;
        let seed = scatter.seed.map_or(0, |seed| seed.0);
        let lean = scatter.lean.map_or(0.0, |lean| lean.0.into());
        let variation = Variation { seed, area, transform, scale, lean };
        for index in 0..count {
            let Some(object_to_world) = variation.transform(index, ground) else {
                let message = format!("found no ground at {} random places in the area", scatter::ATTEMPTS);
                return Err(SpanError::new(span, message).into());
            };
            if is_singular(object_to_world) {
                return Err(SpanError::new(span, format!("instance {index} has no inverse: {object_to_world}")).into());
            }
            self.placements.push(Placement::new(geometry, object_to_world).with_paint(paint));
        }
        Ok(())
    }

    /// Returns the world and the remarks.
    ///
    /// # Errors
    /// If [`World::new`] refuses the world.
    pub(super) fn finish(mut self) -> Result<(World, Vec<String>), SceneError> {
        let mut is_placed = vec![false; self.geometries.len()];
        for placement in &self.placements {
            is_placed[placement.geometry as usize] = true;
        }
        let mut never_placed = self.names.iter().zip(is_placed).filter(|(_, is_placed)| !is_placed);
        if let Some((first, _)) = never_placed.next() {
            self.remarks.push(format!("never placed: {}{}", quoted_name(first), and_more(never_placed.count())));
        }
        let world = World::new(self.geometries, self.placements)
            .map_err(|error| SceneError::Other(Error::in_file(self.path, error.to_string())))?;
        Ok((world, self.remarks))
    }
}

/// The paint of an instance or a scatter. `span` is that of its table.
fn paint(span: &Range<usize>, color: Option<&Color>, checker: Option<&format::Checker>) -> Result<Paint, SpanError> {
    match (color, checker) {
        (None, None) => Ok(Paint::Own),
        (Some(color), None) => Ok(Paint::Plain(color.0)),
        (None, Some(format::Checker { colors: Array([a, b]), transform })) => {
            let uv_to_squares = transform.as_ref().map_or(Ok(Affine2::IDENTITY), compose2)?;
            Ok(Paint::Checker(Checker { colors: [a.0, b.0], uv_to_squares }))
        }
        (Some(_), Some(_)) => Err(SpanError::new(span.clone(), "either color or checker, not both")),
    }
}

/// The corners of an area, in x and z.
fn corners(area: &Spanned<Area>) -> Result<[DVec2; 2], SpanError> {
    let Area { lo, hi } = *area.get_ref();
    let [lo, hi] = [lo, hi].map(|Array([x, z])| DVec2::new(x.0.into(), z.0.into()));
    if lo.cmple(hi).all() {
        Ok([lo, hi])
    } else {
        Err(SpanError::new(area.span(), format!("empty: from {lo} to {hi}")))
    }
}
