//! What may stand in a scene file: one struct for each table, with the ranges of its numbers. `toml` refuses all else, and
//! knows where.

use std::fmt::Debug;
use std::path::PathBuf;

use glam::{Vec2, Vec3};
use serde::Deserialize;
use serde::de::{Deserializer, Error, Unexpected, Visitor};
use toml::Spanned;

use crate::geom::{Aabb, Axis, Quadric, Transform2, Transform3};
use crate::tracer::meshes::generator::MAX_SIZE;

/// A file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SceneFile {
    pub(super) camera: Option<Spanned<Camera>>,
    pub(super) light: Option<Spanned<Light>>,
    #[serde(default)]
    pub(super) mesh: Vec<Spanned<Mesh>>,
    #[serde(default)]
    pub(super) quadric: Vec<Spanned<QuadricTable>>,
    #[serde(default)]
    pub(super) instance: Vec<Spanned<Instance>>,
    #[serde(default)]
    pub(super) scatter: Vec<Spanned<Scatter>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Camera {
    pub(super) eye: Point,
    pub(super) look_at: Point,
    pub(super) field_of_view: Option<FieldOfView>,
    pub(super) transform: Option<Steps<Step3>>,
}

/// One of the two.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Light {
    pub(super) point: Option<Point>,
    pub(super) direction: Option<Spanned<Point>>,
}

/// One of the two beside the name.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Mesh {
    pub(super) name: Spanned<String>,
    pub(super) file: Option<Spanned<PathBuf>>,
    pub(super) generator: Option<Spanned<String>>,
}

/// One kind beside the name; coefficients have a clip box.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct QuadricTable {
    pub(super) name: Spanned<String>,
    sphere: Option<Ball>,
    ellipsoid: Option<Ellipsoid>,
    paraboloid: Option<Bowl>,
    elliptic_paraboloid: Option<EllipticBowl>,
    hyperboloid_of_one_sheet: Option<Hyperboloid>,
    hyperboloid_of_two_sheets: Option<Hyperboloid>,
    cone: Option<Bowl>,
    cylinder: Option<Tube>,
    coefficients: Option<[Finite; 10]>,
    clip: Option<Clip>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Ball {
    radius: Length,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Ellipsoid {
    semi_axes: [Length; 3],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Bowl {
    radius: Length,
    height: Length,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EllipticBowl {
    semi_axes: [Length; 2],
    height: Length,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Hyperboloid {
    semi_axes: [Length; 3],
    half_height: Length,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Tube {
    radius: Length,
    half_height: Length,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Clip {
    lo: Point,
    hi: Point,
}

impl QuadricTable {
    /// The surface, or what is missing or too much. Whether a ray can hit it is for the world to judge.
    pub(super) fn quadric(&self) -> Result<Quadric, &'static str> {
        if let Some(Hyperboloid { semi_axes: [.., c], half_height }) = self.hyperboloid_of_two_sheets
            && half_height.0 <= c.0
        {
            return Err("nothing is left of two sheets that begin beyond half_height, at the third semi-axis");
        }
        let three = |[a, b, c]: [Length; 3]| Vec3::new(a.0, b.0, c.0);
        let named = [
            self.sphere.as_ref().map(|ball| Quadric::sphere(ball.radius.0)),
            self.ellipsoid.as_ref().map(|ellipsoid| Quadric::ellipsoid(three(ellipsoid.semi_axes))),
            self.paraboloid.as_ref().map(|bowl| Quadric::paraboloid(bowl.radius.0, bowl.height.0)),
            self.elliptic_paraboloid.as_ref().map(|bowl| {
                let [a, b] = bowl.semi_axes.map(|axis| axis.0);
                Quadric::elliptic_paraboloid(Vec2::new(a, b), bowl.height.0)
            }),
            self.hyperboloid_of_one_sheet
                .as_ref()
                .map(|sheet| Quadric::hyperboloid_of_one_sheet(three(sheet.semi_axes), sheet.half_height.0)),
            self.hyperboloid_of_two_sheets
                .as_ref()
                .map(|sheets| Quadric::hyperboloid_of_two_sheets(three(sheets.semi_axes), sheets.half_height.0)),
            self.cone.as_ref().map(|cone| Quadric::cone(cone.radius.0, cone.height.0)),
            self.cylinder.as_ref().map(|tube| Quadric::cylinder(tube.radius.0, tube.half_height.0)),
        ];
        let mut named = named.into_iter().flatten();
        match (named.next(), named.next(), &self.coefficients, &self.clip) {
            (Some(quadric), None, None, None) => Ok(quadric),
            (None, _, Some(coefficients), Some(Clip { lo, hi })) => {
                let [xx, yy, zz, yz, zx, xy, x, y, z, constant] = coefficients.each_ref().map(|number| number.0);
                Ok(Quadric {
                    squares: Vec3::new(xx, yy, zz),
                    products: Vec3::new(yz, zx, xy),
                    linear: Vec3::new(x, y, z),
                    constant,
                    clip: Aabb { lo: lo.0, hi: hi.0 },
                })
            }
            (None, _, None, None) => Err("a quadric needs its kind, such as sphere, or coefficients with a clip box"),
            (None, ..) => Err("coefficients and clip need each other"),
            _ => Err("a quadric is of one kind only"),
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Instance {
    pub(super) of: Spanned<String>,
    pub(super) transform: Option<Steps<Step3>>,
    pub(super) color: Option<Color>,
    pub(super) checker: Option<Checker>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Checker {
    pub(super) colors: [Color; 2],
    pub(super) transform: Option<Steps<Step2>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Scatter {
    pub(super) of: Spanned<String>,
    /// Without it, the size of the built-in scene.
    pub(super) count: Option<Spanned<Count>>,
    pub(super) seed: Option<Seed>,
    pub(super) on: Option<Spanned<String>>,
    pub(super) area: Option<Spanned<Area>>,
    pub(super) transform: Option<Steps<Step3>>,
    pub(super) scale: Option<Spanned<[Length; 2]>>,
    pub(super) lean: Option<Fraction>,
    pub(super) color: Option<Color>,
    pub(super) checker: Option<Checker>,
}

/// A rectangle in x and z.
#[derive(Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Area {
    pub(super) lo: [Finite; 2],
    pub(super) hi: [Finite; 2],
}

/// Transforms, the first one applied first.
pub(super) type Steps<S> = Spanned<Vec<Spanned<S>>>;

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum Step3 {
    Translate(Point),
    Scale(Point),
    RotateX(Finite),
    RotateY(Finite),
    RotateZ(Finite),
    Shear { axis: AxisName, by: AxisName, factor: Finite },
}

impl From<Step3> for Transform3 {
    fn from(step: Step3) -> Self {
        match step {
            Step3::Translate(by) => Self::Translate(by.0),
            Step3::Scale(by) => Self::Scale(by.0),
            Step3::RotateX(degrees) => Self::RotateX(degrees.0),
            Step3::RotateY(degrees) => Self::RotateY(degrees.0),
            Step3::RotateZ(degrees) => Self::RotateZ(degrees.0),
            Step3::Shear { axis, by, factor } => Self::Shear { axis: axis.into(), by: by.into(), factor: factor.0 },
        }
    }
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum AxisName {
    X,
    Y,
    Z,
}

impl From<AxisName> for Axis {
    fn from(name: AxisName) -> Self {
        match name {
            AxisName::X => Self::X,
            AxisName::Y => Self::Y,
            AxisName::Z => Self::Z,
        }
    }
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Step2 {
    Translate([Finite; 2]),
    Scale([Finite; 2]),
    Rotate(Finite),
    ShearX(Finite),
    ShearY(Finite),
}

impl From<Step2> for Transform2 {
    fn from(step: Step2) -> Self {
        let vector = |[x, y]: [Finite; 2]| Vec2::new(x.0, y.0);
        match step {
            Step2::Translate(by) => Self::Translate(vector(by)),
            Step2::Scale(by) => Self::Scale(vector(by)),
            Step2::Rotate(degrees) => Self::Rotate(degrees.0),
            Step2::ShearX(factor) => Self::ShearX(factor.0),
            Step2::ShearY(factor) => Self::ShearY(factor.0),
        }
    }
}

/// Three finite numbers.
#[derive(Clone, Copy)]
pub(super) struct Point(pub(super) Vec3);

impl<'de> Deserialize<'de> for Point {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let [x, y, z] = <[Finite; 3]>::deserialize(deserializer)?;
        Ok(Self(Vec3::new(x.0, y.0, z.0)))
    }
}

/// Linear red, green and blue.
#[derive(Clone, Copy)]
pub(super) struct Color(pub(super) Vec3);

impl<'de> Deserialize<'de> for Color {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let [r, g, b] = <[Fraction; 3]>::deserialize(deserializer)?;
        Ok(Self(Vec3::new(r.0, g.0, b.0)))
    }
}

/// Numbers that are checked where they are read, so that the error points to them.
macro_rules! numbers {
    ($($(#[$comment:meta])* $name:ident($number:ident), $expected:literal, $accepts:expr;)*) => {$(
        $(#[$comment])*
        #[derive(Clone, Copy)]
        pub(super) struct $name(pub(super) $number);

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let number = deserializer.deserialize_any(Number { expected: $expected, accepts: $accepts })?;
                Ok(Self(number as $number))
            }
        }
    )*};
}

numbers! {
    Finite(f32), "a finite number", |number| number.abs() <= f64::from(f32::MAX);
    /// Its square neither overflows nor vanishes.
    Length(f32), "a number from 1e-15 to 1e15", |number| (1e-15..=1e15).contains(&number);
    Fraction(f32), "a number from 0 to 1", |number| (0.0..=1.0).contains(&number);
    FieldOfView(f32), "degrees from 1 to 170", |number| (1.0..=170.0).contains(&number);
    Seed(u32), "a whole number from 0 to 4294967295", |number| {
        (0.0..=f64::from(u32::MAX)).contains(&number) && number.fract() == 0.0
    };
    Count(u32), "a whole number from 1 to 10000000", |number| {
        (1.0..=f64::from(MAX_SIZE)).contains(&number) && number.fract() == 0.0
    };
}

/// Reads a number, with or without a point, if it is accepted.
struct Number {
    expected: &'static str,
    accepts: fn(f64) -> bool,
}

impl Visitor<'_> for Number {
    type Value = f64;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.expected)
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<f64, E> {
        self.check(number, number)
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<f64, E> {
        self.check(number as f64, number)
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<f64, E> {
        self.check(number as f64, number)
    }
}

impl Number {
    /// The number, if it is accepted; `found` is how the file has it.
    fn check<E: Error>(&self, number: f64, found: impl Debug) -> Result<f64, E> {
        if (self.accepts)(number) {
            return Ok(number);
        }
        Err(E::invalid_value(Unexpected::Other(&format!("`{found:?}`")), self))
    }
}
