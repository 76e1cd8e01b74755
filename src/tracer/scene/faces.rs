//! Surfaces of several faces: discs, and quadrics that discs close.
//!
//! The faces of a geometry share its transform, so a ray is transformed once for all of them, and they meet where the
//! kernel computes them to meet. At the rim, both the quadric and the disc may round: a ray within a few ulp of it can
//! miss both, or hit both.

use glam::{DVec3, Vec2};
use wide::{f32x8, f64x8};

use super::instance::AnyQuadric;
use super::world::Geometry;
use crate::geom::lanes::{double8, le64, to_f64x8};
use crate::geom::{Candidate, Hit, Mask8, Quadric, Ray};

/// One face of [`Geometry::Faces`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Face {
    /// A quadric.
    Quadric(Quadric),
    /// A disc.
    Disc(Disc),
}

/// `x² + y² <= radius²`, `z = height`: a flat disc.
///
/// A ray in its plane misses. Whether the point of the plane that a ray meets is in the circle is decided in `f64` from
/// the ray, before `t` is rounded. A point exactly on the circle belongs to the disc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Radius. Positive.
    pub radius: f32,
    /// Where it is on the z axis.
    pub height: f32,
    /// Whether its normal is -z instead of +z.
    pub faces_down: bool,
}

impl Disc {
    /// The square around the disc, as a quadric.
    pub(super) fn square(&self) -> Quadric {
        let sign = if self.faces_down { -1.0 } else { 1.0 };
        let mut square = Quadric::plane(Vec2::splat(self.radius));
        square.linear *= sign;
        square.constant = -sign * self.height;
        // Far from 0 the box must still not be flat.
        let half_depth = square.clip.hi.z.max(self.height.abs() * f32::EPSILON * 4.0);
        (square.clip.lo.z, square.clip.hi.z) = (self.height - half_depth, self.height + half_depth);
        square
    }

    /// Whether a ray that meets the plane meets it in the circle.
    #[inline(always)]
    fn contains(&self, ray: &Ray<f32>) -> bool {
        // With o = origin - (0, 0, height), the point is o - d·o.z/d.z. Everything is multiplied by d.z instead. No
        // product of four `f32` numbers overflows or underflows in `f64`.
        let (o, d) = (ray.origin.as_dvec3() - DVec3::Z * f64::from(self.height), ray.dir.as_dvec3());
        let (x, y) = (o.x * d.z - o.z * d.x, o.y * d.z - o.z * d.y);
        let reach = f64::from(self.radius) * d.z;
        x * x + y * y <= reach * reach
    }

    /// [`Disc::contains`] in eight lanes.
    #[inline(always)]
    fn contains8(&self, ray: &Ray<f32x8>) -> Mask8 {
        let ([ox, oy, oz], [dx, dy, dz]) = (double8(ray.origin), double8(ray.dir));
        let oz = oz - f64x8::splat(f64::from(self.height));
        let (x, y) = (ox * dz - oz * dx, oy * dz - oz * dy);
        let reach = to_f64x8(f32x8::splat(self.radius)) * dz;
        le64(x * x + y * y, reach * reach).narrow()
    }
}

/// A disc with its square prepared for a kernel.
#[derive(Debug)]
pub(super) struct PreparedDisc {
    pub(super) square: Box<dyn AnyQuadric>,
    pub(super) disc: Disc,
}

impl AnyQuadric for PreparedDisc {
    fn closest_hit(&self, ray: &Ray<f32>) -> Hit<f32> {
        let hit = self.square.closest_hit(ray);
        if hit.mask && self.disc.contains(ray) { hit } else { Hit::MISS }
    }

    fn closest_hit8(&self, ray: &Ray<f32x8>) -> Hit<f32x8> {
        let hit = self.square.closest_hit8(ray);
        Candidate::from(hit).narrowed(self.disc.contains8(ray), hit.t).or_miss()
    }
}

impl Face {
    /// Whether rays can hit it.
    pub(super) fn is_valid(&self) -> bool {
        match self {
            Self::Quadric(_) => true,
            Self::Disc(disc) => disc.radius > 0.0,
        }
    }

    /// The face as a quadric: of a disc, the square around it.
    pub(crate) fn quadric(&self) -> Quadric {
        match self {
            Self::Quadric(quadric) => *quadric,
            Self::Disc(disc) => disc.square(),
        }
    }
}

/// Round solids, and the disc alone.
impl Geometry {
    /// A disc around the origin in the plane `z = 0`. Its normal is +z.
    pub fn disc(radius: f32) -> Self {
        Self::Faces(vec![Face::Disc(Disc { radius, height: 0.0, faces_down: false })])
    }

    /// [`Quadric::cylinder`], closed by two discs. The side is primitive 0, the lower disc 1, the upper one 2.
    pub fn closed_cylinder(radius: f32, half_height: f32) -> Self {
        let disc = |faces_down| {
            let height = if faces_down { -half_height } else { half_height };
            Face::Disc(Disc { radius, height, faces_down })
        };
        Self::Faces(vec![Face::Quadric(Quadric::cylinder(radius, half_height)), disc(true), disc(false)])
    }

    /// [`Quadric::cone`], closed by a disc. The side is primitive 0, the disc 1.
    pub fn closed_cone(radius: f32, height: f32) -> Self {
        Self::with_lid(Quadric::cone(radius, height), radius, height)
    }

    /// [`Quadric::paraboloid`], closed by a disc. The bowl is primitive 0, the disc 1.
    pub fn closed_paraboloid(radius: f32, height: f32) -> Self {
        Self::with_lid(Quadric::paraboloid(radius, height), radius, height)
    }

    fn with_lid(side: Quadric, radius: f32, height: f32) -> Self {
        Self::Faces(vec![Face::Quadric(side), Face::Disc(Disc { radius, height, faces_down: false })])
    }
}
