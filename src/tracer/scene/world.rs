//! A world: geometries and their instances, before any kernel prepares them.

use glam::{Affine2, Affine3, BVec3, Vec2, Vec3};

use super::faces::Face;
use crate::geom::{Aabb, Quadric};
use crate::kernels::instance::Instance;
use crate::tracer::meshes::Mesh;

/// A shape in its own coordinates. Instances place it in the world.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Geometry {
    /// A triangle mesh.
    Mesh(Mesh),
    /// One quadric.
    Quadric(Quadric),
    /// Several faces, such as the side and the caps of a cylinder.
    Faces(Vec<Face>),
}

impl Geometry {
    /// Number of primitives: triangles of a mesh, or faces, or 1 for a quadric.
    pub fn primitives(&self) -> usize {
        match self {
            Self::Mesh(mesh) => mesh.len(),
            Self::Quadric(_) => 1,
            Self::Faces(faces) => faces.len(),
        }
    }

    /// A box around all primitives, in object coordinates.
    pub fn bounds(&self) -> Aabb {
        match self {
            Self::Mesh(mesh) => mesh.bounds(),
            Self::Quadric(quadric) => quadric.bounds(),
            Self::Faces(faces) => faces.iter().fold(Aabb::EMPTY, |bounds, face| bounds.union(&face.quadric().bounds())),
        }
    }

    /// Whether [`World::new`] accepts the geometry. Every mesh is valid; for quadrics see [`WorldError::BadQuadric`].
    pub(crate) fn is_valid(&self) -> bool {
        let is_valid = |quadric: &Quadric| {
            let Aabb { lo, hi } = quadric.bounds();
            let varies = (quadric.squares, quadric.products, quadric.linear) != (Vec3::ZERO, Vec3::ZERO, Vec3::ZERO);
            varies && lo.is_finite() && hi.is_finite()
        };
        match self {
            Self::Mesh(_) => true,
            Self::Quadric(quadric) => is_valid(quadric),
            Self::Faces(faces) => {
                !faces.is_empty() && faces.iter().all(|face| face.is_valid() && is_valid(&face.quadric()))
            }
        }
    }

    /// A face as a quadric; see [`Face::quadric`]. None for a mesh.
    pub(super) fn quadric(&self, face: u32) -> Option<Quadric> {
        match self {
            Self::Mesh(_) => None,
            Self::Quadric(quadric) => Some(*quadric),
            Self::Faces(faces) => Some(faces[face as usize].quadric()),
        }
    }
}

impl From<Quadric> for Geometry {
    fn from(quadric: Quadric) -> Self {
        Self::Quadric(quadric)
    }
}

/// An instance: a geometry, its transform, and its colours.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Placement {
    /// Number of the geometry.
    pub geometry: u32,
    /// From the geometry's coordinates to the world's. It must have an inverse.
    pub object_to_world: Affine3,
    /// The colours.
    pub paint: Paint,
    /// A bit for each group that the instance belongs to. Rays see it if
    /// [their mask](crate::tracer::Scene::with_mask) has one of these bits.
    pub mask: u32,
}

impl Placement {
    /// An instance in its own colours, in every group.
    pub fn new(geometry: u32, object_to_world: Affine3) -> Self {
        Self { geometry, object_to_world, paint: Paint::Own, mask: u32::MAX }
    }

    /// With these colours.
    #[must_use]
    pub fn with_paint(self, paint: Paint) -> Self {
        Self { paint, ..self }
    }

    /// With these groups.
    #[must_use]
    pub fn with_mask(self, mask: u32) -> Self {
        Self { mask, ..self }
    }
}

/// The colours of an instance.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Paint {
    /// The colours of the mesh. Quadrics and discs are white.
    Own,
    /// One colour: linear red, green and blue from 0 to 1.
    Plain(Vec3),
    /// Two colours in a checker pattern over (u, v).
    Checker(Checker),
}

/// A checker pattern of unit squares over the surface's (u, v). A transform of (u, v) scales, rotates, shears and moves
/// the pattern.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Checker {
    /// Both colours: linear red, green and blue from 0 to 1.
    pub colors: [Vec3; 2],
    /// From the surface's (u, v) to unit squares.
    pub uv_to_squares: Affine2,
}

impl Checker {
    /// The colour at (u, v). The first colour is that of the unit square from (0, 0) to (1, 1), after the transform.
    pub fn at(&self, uv: Vec2) -> Vec3 {
        let square = self.uv_to_squares.transform_point2(uv).floor();
        self.colors[usize::from((square.x + square.y).rem_euclid(2.0) != 0.0)]
    }
}

/// Geometries and their instances. Every world is valid: [`World::new`] lists the conditions.
#[derive(Clone, Debug, PartialEq)]
pub struct World {
    geometries: Vec<Geometry>,
    instances: Vec<Placement>,
}

/// Why [`World::new`] refuses its arguments. Geometries and instances are counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WorldError {
    /// There are no instances.
    #[error("no instances")]
    NoInstances,
    /// There are more primitives or instances than [`Mesh::MAX_TRIANGLES`]. The number `u32::MAX` is reserved: it means
    /// a miss.
    #[error("too many {what}: {count}, but at most {max} are possible", max = Mesh::MAX_TRIANGLES)]
    TooMany {
        /// `primitives` (of all geometries together) or `instances`.
        what: &'static str,
        /// Their number.
        count: usize,
    },
    /// An instance refers to a geometry that does not exist.
    #[error("instance {0} refers to a geometry that does not exist")]
    MissingGeometry(usize),
    /// A quadric needs finite coefficients, and at least one besides the constant must not be zero. Its clip box must
    /// be finite and not empty. A disc needs a positive radius. There must be at least one face.
    #[error(
        "geometry {0} has a face that no ray hits: its coefficients are not finite or all zero, \
         or its box is empty or infinite"
    )]
    BadQuadric(usize),
    /// The transform of an instance has no inverse.
    #[error("instance {0}: the transform has no inverse")]
    Singular(usize),
    /// A colour is outside 0 to 1.
    #[error("instance {0} has a colour outside 0 to 1")]
    BadColor(usize),
}

impl World {
    /// Makes a world. Conditions:
    ///
    /// - there is at least one instance, and at most [`Mesh::MAX_TRIANGLES`];
    /// - all geometries together have at most [`Mesh::MAX_TRIANGLES`] primitives;
    /// - every quadric is valid; see [`WorldError::BadQuadric`];
    /// - every instance refers to a geometry, its transform has an inverse, and its colours are from 0 to 1.
    ///
    /// # Errors
    /// The first condition that does not hold, with the number of the geometry or instance.
    pub fn new(geometries: Vec<Geometry>, instances: Vec<Placement>) -> Result<Self, WorldError> {
        if instances.is_empty() {
            return Err(WorldError::NoInstances);
        }
        let primitives = geometries.iter().map(Geometry::primitives).sum();
        for (what, count) in [("primitives", primitives), ("instances", instances.len())] {
            if count > Mesh::MAX_TRIANGLES {
                return Err(WorldError::TooMany { what, count });
            }
        }
        if let Some(bad) = geometries.iter().position(|geometry| !geometry.is_valid()) {
            return Err(WorldError::BadQuadric(bad));
        }
        for (number, instance) in instances.iter().enumerate() {
            if instance.geometry as usize >= geometries.len() {
                return Err(WorldError::MissingGeometry(number));
            }
            if is_singular(instance.object_to_world) {
                return Err(WorldError::Singular(number));
            }
            let colors = match instance.paint {
                Paint::Own => [Vec3::ZERO; 2],
                Paint::Plain(color) => [color; 2],
                Paint::Checker(Checker { colors, .. }) => colors,
            };
            if !colors.iter().all(|color| color.cmpge(Vec3::ZERO).all() && color.cmple(Vec3::ONE).all()) {
                return Err(WorldError::BadColor(number));
            }
        }
        Ok(Self { geometries, instances })
    }

    /// The geometries.
    pub fn geometries(&self) -> &[Geometry] {
        &self.geometries
    }

    /// The instances.
    pub fn instances(&self) -> &[Placement] {
        &self.instances
    }

    /// Number of triangles of all geometries. Instances do not multiply it.
    pub fn triangles(&self) -> usize {
        self.geometries.iter().map(|geometry| if let Geometry::Mesh(mesh) = geometry { mesh.len() } else { 0 }).sum()
    }

    /// Number of quadrics and discs of all geometries.
    pub fn quadrics(&self) -> usize {
        let faces = |geometry: &Geometry| if matches!(geometry, Geometry::Mesh(_)) { 0 } else { geometry.primitives() };
        self.geometries.iter().map(faces).sum()
    }

    /// A box around all instances. It may be off by rounding, so it serves only to place a camera.
    pub(crate) fn bounds(&self) -> Aabb {
        let object_bounds: Vec<_> = self.geometries.iter().map(Geometry::bounds).collect();
        self.instances.iter().fold(Aabb::EMPTY, |bounds, placement| {
            let Aabb { lo, hi } = object_bounds[placement.geometry as usize];
            (0..8).fold(bounds, |bounds, corner| {
                let corner = Vec3::select(BVec3::new(corner & 1 != 0, corner & 2 != 0, corner & 4 != 0), hi, lo);
                bounds.including(placement.object_to_world.transform_point3(corner))
            })
        })
    }

    /// Returns the geometries and the instances.
    pub fn into_parts(self) -> (Vec<Geometry>, Vec<Placement>) {
        (self.geometries, self.instances)
    }
}

/// One instance of the mesh, untransformed, in its own colours.
impl From<Mesh> for World {
    fn from(mesh: Mesh) -> Self {
        Self { geometries: vec![Geometry::Mesh(mesh)], instances: vec![Placement::new(0, Affine3::IDENTITY)] }
    }
}

/// Whether a transform has no inverse, so that rays cannot be transformed to the object.
pub(crate) fn is_singular(object_to_world: Affine3) -> bool {
    Instance::new((), object_to_world).is_err()
}
