//! What a scene consists of, before any kernel prepares it: geometries, and instances of them.

use glam::{Affine2, Affine3, Vec2, Vec3};

use crate::geom::{Aabb, Quadric};
use crate::kernels::instance::Instance;
use crate::tracer::meshes::Mesh;

/// Something that instances are made of, in its own coordinates.
#[derive(Clone, Debug, PartialEq)]
pub enum Geometry {
    /// Triangles.
    Mesh(Mesh),
    /// One surface of second degree.
    Quadric(Quadric),
}

impl Geometry {
    /// How many primitives there are.
    pub fn primitives(&self) -> usize {
        match self {
            Self::Mesh(mesh) => mesh.len(),
            Self::Quadric(_) => 1,
        }
    }

    /// A box around them.
    pub fn bounds(&self) -> Aabb {
        match self {
            Self::Mesh(mesh) => mesh.bounds(),
            Self::Quadric(quadric) => quadric.bounds(),
        }
    }
}

/// A geometry put into the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Number of the geometry.
    pub geometry: u32,
    /// From the geometry's coordinates to the world's.
    pub object_to_world: Affine3,
    /// What it looks like.
    pub paint: Paint,
}

/// What an instance looks like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Paint {
    /// The mesh's own colours; a quadric is white.
    Own,
    /// One colour: linear red, green and blue from 0 to 1.
    Plain(Vec3),
    /// Two colours in a pattern of unit squares, over (u, v).
    Checker(Checker),
}

/// A pattern of unit squares. The surface's (u, v) are transformed first, which scales, turns, shears and moves the
/// pattern.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Checker {
    /// Linear red, green and blue from 0 to 1.
    pub colors: [Vec3; 2],
    /// From the surface's (u, v) to squares.
    pub uv_to_squares: Affine2,
}

impl Checker {
    /// The colour at (u, v).
    pub fn at(&self, uv: Vec2) -> Vec3 {
        let square = self.uv_to_squares.transform_point2(uv).floor();
        self.colors[usize::from((square.x + square.y).rem_euclid(2.0) != 0.0)]
    }
}

/// Geometries and instances of them, all valid: see [`World::new`].
#[derive(Clone, Debug, PartialEq)]
pub struct World {
    geometries: Vec<Geometry>,
    instances: Vec<Placement>,
}

/// Why geometries and instances make no [`World`].
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum WorldError {
    /// There is nothing to hit.
    #[error("no instances")]
    NoInstances,
    /// The number `u32::MAX` means a miss, and counts must fit beside it.
    #[error("too many {what}: {count}, but at most {max} are possible", max = Mesh::MAX_TRIANGLES)]
    TooMany {
        /// Primitives, of all geometries together, or instances.
        what: &'static str,
        /// How many there are.
        count: usize,
    },
    /// An instance refers to a geometry that is not there.
    #[error("instance {0} refers to a geometry that does not exist")]
    MissingGeometry(usize),
    /// A quadric needs finite coefficients, of which one but the constant is not zero, and a finite box that is not empty.
    #[error(
        "geometry {0} is a quadric that no ray hits: its coefficients are not finite or all zero, or its box is empty or infinite"
    )]
    BadQuadric(usize),
    /// A transform has no inverse.
    #[error("instance {0}: the transform has no inverse")]
    Singular(usize),
    /// A colour is not from 0 to 1.
    #[error("instance {0} has an impossible colour")]
    BadColor(usize),
}

impl World {
    /// A world, if everything in it can be hit and drawn.
    ///
    /// # Errors
    /// Says what cannot, and where.
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
        if let Some(bad) = geometries.iter().position(|geometry| !can_be_hit(geometry)) {
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

    /// How many triangles its geometries have: each counts once, whatever the number of instances.
    pub fn triangles(&self) -> usize {
        self.geometries.iter().map(|geometry| if let Geometry::Mesh(mesh) = geometry { mesh.len() } else { 0 }).sum()
    }

    /// How many of its geometries are quadrics.
    pub fn quadrics(&self) -> usize {
        self.geometries.iter().filter(|geometry| matches!(geometry, Geometry::Quadric(_))).count()
    }

    /// Takes it apart.
    pub fn into_parts(self) -> (Vec<Geometry>, Vec<Placement>) {
        (self.geometries, self.instances)
    }
}

/// A mesh as it is, in its own colours.
impl From<Mesh> for World {
    fn from(mesh: Mesh) -> Self {
        let instance = Placement { geometry: 0, object_to_world: Affine3::IDENTITY, paint: Paint::Own };
        Self { geometries: vec![Geometry::Mesh(mesh)], instances: vec![instance] }
    }
}

/// Whether rays cannot be taken to the object.
pub(crate) fn is_singular(object_to_world: Affine3) -> bool {
    Instance::new((), object_to_world).is_err()
}

/// Whether a geometry is anything that a ray could hit. A mesh always is.
pub(crate) fn can_be_hit(geometry: &Geometry) -> bool {
    let Geometry::Quadric(quadric) = geometry else { return true };
    let Aabb { lo, hi } = quadric.bounds();
    let varies = (quadric.squares, quadric.products, quadric.linear) != (Vec3::ZERO, Vec3::ZERO, Vec3::ZERO);
    varies && lo.is_finite() && hi.is_finite()
}
