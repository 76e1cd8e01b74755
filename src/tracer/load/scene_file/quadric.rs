//! The `[[quadric]]` table of a scene file: a named kind of quadric, open or closed by discs, or a disc, or
//! coefficients and a clip box.

use glam::{Vec2, Vec3};
use serde::Deserialize;
use toml::Spanned;

use super::number::{Array, Finite, Length, Point};
use crate::geom::{Aabb, Quadric};
use crate::tracer::scene::Geometry;

/// A name, and either one kind of quadric, or `coefficients` and `clip`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct QuadricTable {
    pub(super) name: Spanned<String>,
    sphere: Option<Sphere>,
    ellipsoid: Option<Ellipsoid>,
    paraboloid: Option<RadiusAndHeight>,
    elliptic_paraboloid: Option<EllipticParaboloid>,
    hyperboloid_of_one_sheet: Option<Hyperboloid>,
    hyperboloid_of_two_sheets: Option<Hyperboloid>,
    cone: Option<RadiusAndHeight>,
    cylinder: Option<Cylinder>,
    plane: Option<Plane>,
    disc: Option<Disc>,
    coefficients: Option<Array<Finite, 10>>,
    clip: Option<Clip>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Sphere {
    radius: Length,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Ellipsoid {
    semi_axes: Array<Length, 3>,
}

/// A paraboloid or a cone.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RadiusAndHeight {
    radius: Length,
    height: Length,
    #[serde(default)]
    closed: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EllipticParaboloid {
    semi_axes: Array<Length, 2>,
    height: Length,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Hyperboloid {
    semi_axes: Array<Length, 3>,
    half_height: Length,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Cylinder {
    radius: Length,
    half_height: Length,
    #[serde(default)]
    closed: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Plane {
    half_size: Array<Length, 2>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Disc {
    radius: Length,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Clip {
    lo: Point,
    hi: Point,
}

impl QuadricTable {
    /// The geometry. [`Geometry::is_valid`] checks coefficients and clip box later.
    ///
    /// # Errors
    /// If a key is missing or there are too many, or if a hyperboloid of two sheets is empty.
    pub(super) fn geometry(&self) -> Result<Geometry, &'static str> {
        if let Some(Hyperboloid { semi_axes: Array([.., c]), half_height }) = self.hyperboloid_of_two_sheets
            && half_height.0 <= c.0
        {
            return Err("half_height must be greater than the third semi-axis, where the two sheets begin");
        }
        let three = |Array([a, b, c]): Array<Length, 3>| Vec3::new(a.0, b.0, c.0);
        let two = |Array([a, b]): Array<Length, 2>| Vec2::new(a.0, b.0);
        let named = [
            self.sphere.as_ref().map(|sphere| Quadric::sphere(sphere.radius.0).into()),
            self.ellipsoid.as_ref().map(|ellipsoid| Quadric::ellipsoid(three(ellipsoid.semi_axes)).into()),
            self.paraboloid.as_ref().map(|&RadiusAndHeight { radius, height, closed }| {
                let (open, capped) = (Quadric::paraboloid, Geometry::closed_paraboloid);
                if closed { capped(radius.0, height.0) } else { open(radius.0, height.0).into() }
            }),
            self.elliptic_paraboloid
                .as_ref()
                .map(|paraboloid| Quadric::elliptic_paraboloid(two(paraboloid.semi_axes), paraboloid.height.0).into()),
            self.hyperboloid_of_one_sheet
                .as_ref()
                .map(|sheet| Quadric::hyperboloid_of_one_sheet(three(sheet.semi_axes), sheet.half_height.0).into()),
            self.hyperboloid_of_two_sheets
                .as_ref()
                .map(|sheets| Quadric::hyperboloid_of_two_sheets(three(sheets.semi_axes), sheets.half_height.0).into()),
            self.cone.as_ref().map(|&RadiusAndHeight { radius, height, closed }| {
                let (open, capped) = (Quadric::cone, Geometry::closed_cone);
                if closed { capped(radius.0, height.0) } else { open(radius.0, height.0).into() }
            }),
            self.cylinder.as_ref().map(|&Cylinder { radius, half_height, closed }| {
                let (open, capped) = (Quadric::cylinder, Geometry::closed_cylinder);
                if closed { capped(radius.0, half_height.0) } else { open(radius.0, half_height.0).into() }
            }),
            self.plane.as_ref().map(|plane| Quadric::plane(two(plane.half_size)).into()),
            self.disc.as_ref().map(|disc| Geometry::disc(disc.radius.0)),
        ];
        let mut named = named.into_iter().flatten();
        match (named.next(), named.next(), &self.coefficients, &self.clip) {
            (Some(geometry), None, None, None) => Ok(geometry),
            (None, _, Some(coefficients), Some(Clip { lo, hi })) => {
                let [xx, yy, zz, yz, zx, xy, x, y, z, constant] = coefficients.0.map(|number| number.0);
                let quadric = Quadric {
                    squares: Vec3::new(xx, yy, zz),
                    products: Vec3::new(yz, zx, xy),
                    linear: Vec3::new(x, y, z),
                    constant,
                    clip: Aabb { lo: lo.0, hi: hi.0 },
                };
                Ok(quadric.into())
            }
            (None, _, None, None) => Err("a quadric needs its kind, such as sphere, or coefficients with a clip box"),
            (None, ..) => Err("coefficients and clip need each other"),
            _ => Err("a quadric is of one kind only"),
        }
    }
}
