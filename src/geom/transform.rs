//! Affine transforms of the plane and of space: scaling, rotation, shear, translation and any other matrix, each with
//! its inverse in closed form, and chains of them.
//!
//! A chain applies its transforms from left to right: the first one first. In the product of matrices the first one
//! is rightmost. The inverse of a chain is the chain of the inverses in reverse order.
//!
//! | | row equations | inverse |
//! | --- | --- | --- |
//! | translation by (a, b, c) | `x' = x + a`, `y' = y + b`, `z' = z + c` | by (-a, -b, -c) |
//! | scaling by (a, b, c) | `x' = a·x`, `y' = b·y`, `z' = c·z` | by (1/a, 1/b, 1/c) |
//! | rotation about x by φ | `x' = x`, `y' = cos φ·y - sin φ·z`, `z' = sin φ·y + cos φ·z` | by -φ, the transpose |
//! | rotation about y by φ | `x' = cos φ·x + sin φ·z`, `y' = y`, `z' = -sin φ·x + cos φ·z` | by -φ, the transpose |
//! | rotation about z by φ | `x' = cos φ·x - sin φ·y`, `y' = sin φ·x + cos φ·y`, `z' = z` | by -φ, the transpose |
//! | rotation about the unit vector k by φ | `p' = cos φ·p + sin φ·k×p + (1 - cos φ)·(k·p)·k` | by -φ, the transpose |
//! | shear of x by y, factor h | `x' = x + h·y`, `y' = y`, `z' = z` | factor -h |
//! | matrix L, translation T | `p' = L·p + T` | L⁻¹ by cofactors, -L⁻¹·T |
//!
//! and the same shear for the five other pairs of axes. In the plane leave out z; the rotation is the one about z. The
//! slides to the textbook print the first row of the shear as `x' = x + h`, without the factor y. That is a
//! translation. The shear matrix beside it, with h in row x and column y, is right and is used here.
//!
//! Entries are computed in `f64` and rounded to `f32` once, after all products. So a chain of many transforms is as
//! accurate as one. Sine and cosine come from the `libm` crate, because those of the platform differ from machine to
//! machine.
//!
//! Results are glam's affine types. They leave out the last row of the homogeneous matrix, which is always (0, …, 0,
//! 1). `Mat3::from` and `Mat4::from` give the full 3×3 and 4×4 matrices:
//!
//! ```
//! use glam::{Mat4, Vec3};
//! use raylanes::geom::{Axis, Transform3};
//!
//! let chain = [
//!     Transform3::Scale(Vec3::new(2.0, 1.0, 1.0)),
//!     Transform3::Shear { axis: Axis::X, by: Axis::Y, factor: 0.5 },
//!     Transform3::RotateZ(90.0),
//!     Transform3::Translate(Vec3::new(0.0, 0.0, 3.0)),
//! ];
//! // (1, 2, 0) is scaled to (2, 2, 0), sheared to (3, 2, 0), rotated to (-2, 3, 0) and moved to (-2, 3, 3).
//! let object_to_world = Transform3::chain(&chain);
//! assert_eq!(object_to_world.transform_point3(Vec3::new(1.0, 2.0, 0.0)), Vec3::new(-2.0, 3.0, 3.0));
//!
//! let world_to_object = Transform3::chain_inverse(&chain)?;
//! assert_eq!(world_to_object.transform_point3(Vec3::new(-2.0, 3.0, 3.0)), Vec3::new(1.0, 2.0, 0.0));
//!
//! let homogeneous = Mat4::from(object_to_world) * Vec3::new(1.0, 2.0, 0.0).extend(1.0);
//! assert_eq!(homogeneous.to_array(), [-2.0, 3.0, 3.0, 1.0]);
//! # Ok::<(), raylanes::geom::InvalidTransform<Transform3>>(())
//! ```
//!
//! Source: P. Shirley, S. Marschner et al., "Fundamentals of Computer Graphics", chapter on transformation matrices.

use core::fmt;

use glam::{Affine2, Affine3, DAffine2, DAffine3, DMat2, DMat3, DVec2, DVec3, Vec2, Vec3};

/// An axis of space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// The first.
    X,
    /// The second.
    Y,
    /// The third.
    Z,
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
        })
    }
}

/// One transform of space. Angles are in degrees, counter-clockwise as seen from the tip of the axis. Multiples of 90
/// about x, y and z are exact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Transform3 {
    /// Moves by this vector.
    Translate(Vec3),
    /// Multiplies each coordinate by its own factor. A negative factor mirrors.
    Scale(Vec3),
    /// Rotates y towards z.
    RotateX(f32),
    /// Rotates z towards x.
    RotateY(f32),
    /// Rotates x towards y.
    RotateZ(f32),
    /// Rotates about any axis through the origin. An axis along x, y or z gives the same bits as the variant of that
    /// name.
    RotateAbout {
        /// The direction of the axis, of any length but zero.
        axis: Vec3,
        /// The angle.
        degrees: f32,
    },
    /// Adds `factor` times the coordinate `by` to the coordinate `axis`.
    Shear {
        /// The coordinate that changes.
        axis: Axis,
        /// The coordinate that is added. It differs from `axis`.
        by: Axis,
        /// The multiple of it that is added.
        factor: f32,
    },
    /// Multiplies by the matrix, then adds the translation.
    Matrix(Affine3),
}

/// One transform of the plane. Angles are in degrees, counter-clockwise. Multiples of 90 are exact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Transform2 {
    /// Moves by this vector.
    Translate(Vec2),
    /// Multiplies each coordinate by its own factor. A negative factor mirrors.
    Scale(Vec2),
    /// Rotates x towards y.
    Rotate(f32),
    /// Adds this many times y to x.
    ShearX(f32),
    /// Adds this many times x to y.
    ShearY(f32),
    /// Multiplies by the matrix, then adds the translation.
    Matrix(Affine2),
}

/// A transform without inverse or without meaning.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct InvalidTransform<T> {
    /// The transform that was refused.
    pub transform: T,
    /// What is wrong with it.
    pub reason: &'static str,
}

impl<T: fmt::Display> fmt::Display for InvalidTransform<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.transform, self.reason)
    }
}

impl<T: fmt::Display + fmt::Debug> core::error::Error for InvalidTransform<T> {}

const NOT_FINITE: &str = "not a finite number";
const ZERO_SCALE: &str = "a factor of zero has no inverse";
const SELF_SHEAR: &str = "an axis cannot be sheared by itself";
const NO_AXIS: &str = "an axis of length zero has no direction";
const SINGULAR: &str = "its determinant is zero, or too near to zero, so it has no inverse";

impl fmt::Display for Transform3 {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Translate(by) => write!(f, "translation by {by}"),
            Self::Scale(by) => write!(f, "scaling by {by}"),
            Self::RotateX(degrees) => write!(f, "rotation about x by {degrees} degrees"),
            Self::RotateY(degrees) => write!(f, "rotation about y by {degrees} degrees"),
            Self::RotateZ(degrees) => write!(f, "rotation about z by {degrees} degrees"),
            Self::RotateAbout { axis, degrees } => write!(f, "rotation about {axis} by {degrees} degrees"),
            Self::Shear { axis, by, factor } => write!(f, "shear of {axis} by {by} with factor {factor}"),
            Self::Matrix(affine) => {
                let [x, y, z] = [0, 1, 2].map(|axis| affine.matrix3.row(axis).extend(affine.translation[axis]));
                write!(f, "matrix of the rows {x}, {y}, {z}")
            }
        }
    }
}

impl fmt::Display for Transform2 {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Translate(by) => write!(f, "translation by {by}"),
            Self::Scale(by) => write!(f, "scaling by {by}"),
            Self::Rotate(degrees) => write!(f, "rotation by {degrees} degrees"),
            Self::ShearX(factor) => write!(f, "shear of x by y with factor {factor}"),
            Self::ShearY(factor) => write!(f, "shear of y by x with factor {factor}"),
            Self::Matrix(affine) => {
                let [x, y] = [0, 1].map(|axis| affine.matrix2.row(axis).extend(affine.translation[axis]));
                write!(f, "matrix of the rows {x}, {y}")
            }
        }
    }
}

impl Transform3 {
    /// Checks that the transform has an inverse.
    ///
    /// # Errors
    /// If a number is not finite, a scaling has a factor of zero, an axis is sheared by itself, the axis of a rotation
    /// has length zero, or a matrix is singular. A matrix counts as singular if the rounding errors of its determinant
    /// in `f64` could hide a zero.
    pub fn check(&self) -> Result<(), InvalidTransform<Self>> {
        let refuse = |reason| Err(InvalidTransform { transform: *self, reason });
        match *self {
            Self::Translate(by) | Self::Scale(by) if !by.is_finite() => refuse(NOT_FINITE),
            Self::RotateX(number)
            | Self::RotateY(number)
            | Self::RotateZ(number)
            | Self::RotateAbout { degrees: number, .. }
            | Self::Shear { factor: number, .. }
                if !number.is_finite() =>
            {
                refuse(NOT_FINITE)
            }
            Self::RotateAbout { axis, .. } if !axis.is_finite() => refuse(NOT_FINITE),
            Self::Matrix(affine) if !affine.is_finite() => refuse(NOT_FINITE),
            Self::Scale(by) if by.cmpeq(Vec3::ZERO).any() => refuse(ZERO_SCALE),
            Self::Shear { axis, by, .. } if axis == by => refuse(SELF_SHEAR),
            Self::RotateAbout { axis, .. } if axis == Vec3::ZERO => refuse(NO_AXIS),
            Self::Matrix(affine) if is_singular(&affine.matrix3.as_dmat3()) => refuse(SINGULAR),
            _ => Ok(()),
        }
    }

    /// The matrix. Exact for translation, scaling, shear and [`Transform3::Matrix`]. Sines and cosines have a relative
    /// error below 2⁻⁵⁰. About an axis that is not x, y or z, entries have an absolute error below 2⁻⁴⁸. A NaN or an
    /// axis of length zero gives NaN entries.
    pub fn matrix(&self) -> DAffine3 {
        let about = |[from, to]: [usize; 2], degrees| {
            let (sin, cos) = sin_cos(degrees);
            let mut linear = DMat3::IDENTITY;
            linear.col_mut(from)[from] = cos;
            linear.col_mut(from)[to] = sin;
            linear.col_mut(to)[from] = -sin;
            linear.col_mut(to)[to] = cos;
            DAffine3::from_mat3(linear)
        };
        match *self {
            Self::Translate(by) => DAffine3::from_translation(by.as_dvec3()),
            Self::Scale(by) => DAffine3::from_scale(by.as_dvec3()),
            Self::RotateX(degrees) => about([1, 2], degrees),
            Self::RotateY(degrees) => about([2, 0], degrees),
            Self::RotateZ(degrees) => about([0, 1], degrees),
            Self::RotateAbout { axis, degrees } => match axis.to_array() {
                [x, 0.0, 0.0] if x != 0.0 => about([1, 2], degrees * x.signum()),
                [0.0, y, 0.0] if y != 0.0 => about([2, 0], degrees * y.signum()),
                [0.0, 0.0, z] if z != 0.0 => about([0, 1], degrees * z.signum()),
                _ => DAffine3::from_mat3(rodrigues(axis.as_dvec3(), degrees)),
            },
            Self::Shear { axis, by, factor } => {
                let mut linear = DMat3::IDENTITY;
                linear.col_mut(by as usize)[axis as usize] += f64::from(factor);
                DAffine3::from_mat3(linear)
            }
            Self::Matrix(affine) => affine.as_daffine3(),
        }
    }

    /// The matrix of the inverse, in closed form. As accurate as [`Transform3::matrix`], except for one rounding
    /// where a scaling is inverted. The inverse of a [`Transform3::Matrix`] has a relative error of about 2⁻⁵⁰ times
    /// its condition number.
    ///
    /// # Errors
    /// See [`Transform3::check`].
    pub fn inverse(&self) -> Result<DAffine3, InvalidTransform<Self>> {
        self.check()?;
        Ok(match *self {
            Self::Translate(by) => Self::Translate(-by).matrix(),
            Self::Scale(by) => DAffine3::from_scale(DVec3::ONE / by.as_dvec3()),
            Self::RotateX(degrees) => Self::RotateX(-degrees).matrix(),
            Self::RotateY(degrees) => Self::RotateY(-degrees).matrix(),
            Self::RotateZ(degrees) => Self::RotateZ(-degrees).matrix(),
            Self::RotateAbout { axis, degrees } => Self::RotateAbout { axis, degrees: -degrees }.matrix(),
            Self::Shear { axis, by, factor } => Self::Shear { axis, by, factor: -factor }.matrix(),
            Self::Matrix(_) => self.matrix().inverse(),
        })
    }

    /// The transforms one after the other, the first one first. No transform gives the identity. Nothing is checked:
    /// a scaling by zero gives a singular matrix, a NaN gives NaN, and an entry beyond the range of `f32` is
    /// infinite. A [`Transform3::Matrix`] alone is returned as it is, bit for bit.
    pub fn chain(transforms: &[Self]) -> Affine3 {
        if let [Self::Matrix(affine)] = transforms {
            // A product, also with the identity, would lose the sign of a zero.
            return *affine;
        }
        transforms.iter().fold(DAffine3::IDENTITY, |chain, next| next.matrix() * chain).as_affine3()
    }

    /// The inverse of [`Transform3::chain`]: the inverses one after the other, the last one first. An entry beyond
    /// the range of `f32` is infinite.
    ///
    /// # Errors
    /// The first transform that has no inverse: see [`Transform3::check`].
    pub fn chain_inverse(transforms: &[Self]) -> Result<Affine3, InvalidTransform<Self>> {
        let inverse = |chain, next: &Self| Ok(chain * next.inverse()?);
        Ok(transforms.iter().try_fold(DAffine3::IDENTITY, inverse)?.as_affine3())
    }
}

impl Transform2 {
    /// Checks that the transform has an inverse.
    ///
    /// # Errors
    /// If a number is not finite, a scaling has a factor of zero, or a matrix is singular. This is decided exactly.
    pub fn check(&self) -> Result<(), InvalidTransform<Self>> {
        let refuse = |reason| Err(InvalidTransform { transform: *self, reason });
        match *self {
            Self::Translate(by) | Self::Scale(by) if !by.is_finite() => refuse(NOT_FINITE),
            Self::Rotate(number) | Self::ShearX(number) | Self::ShearY(number) if !number.is_finite() => {
                refuse(NOT_FINITE)
            }
            Self::Matrix(affine) if !affine.is_finite() => refuse(NOT_FINITE),
            Self::Scale(by) if by.cmpeq(Vec2::ZERO).any() => refuse(ZERO_SCALE),
            // Both products are exact in `f64`, and their difference is zero only if they are equal.
            Self::Matrix(affine) if affine.matrix2.as_dmat2().determinant() == 0.0 => refuse(SINGULAR),
            _ => Ok(()),
        }
    }

    /// The matrix. Exact for translation, scaling, shear and [`Transform2::Matrix`]. Sines and cosines have a relative
    /// error below 2⁻⁵⁰. A NaN gives NaN entries.
    pub fn matrix(&self) -> DAffine2 {
        let linear = |x_axis: [f64; 2], y_axis: [f64; 2]| {
            DAffine2::from_mat2(DMat2::from_cols(DVec2::from(x_axis), DVec2::from(y_axis)))
        };
        match *self {
            Self::Translate(by) => DAffine2::from_translation(by.as_dvec2()),
            Self::Scale(by) => DAffine2::from_scale(by.as_dvec2()),
            Self::Rotate(degrees) => {
                let (sin, cos) = sin_cos(degrees);
                linear([cos, sin], [-sin, cos])
            }
            Self::ShearX(factor) => linear([1.0, 0.0], [factor.into(), 1.0]),
            Self::ShearY(factor) => linear([1.0, factor.into()], [0.0, 1.0]),
            Self::Matrix(affine) => affine.as_daffine2(),
        }
    }

    /// The matrix of the inverse, in closed form. As accurate as [`Transform2::matrix`], except for one rounding
    /// where a scaling is inverted.
    ///
    /// # Errors
    /// See [`Transform2::check`].
    pub fn inverse(&self) -> Result<DAffine2, InvalidTransform<Self>> {
        self.check()?;
        Ok(match *self {
            Self::Translate(by) => Self::Translate(-by).matrix(),
            Self::Scale(by) => DAffine2::from_scale(DVec2::ONE / by.as_dvec2()),
            Self::Rotate(degrees) => Self::Rotate(-degrees).matrix(),
            Self::ShearX(factor) => Self::ShearX(-factor).matrix(),
            Self::ShearY(factor) => Self::ShearY(-factor).matrix(),
            Self::Matrix(_) => self.matrix().inverse(),
        })
    }

    /// The transforms one after the other, the first one first. No transform gives the identity. Nothing is checked:
    /// a scaling by zero gives a singular matrix, a NaN gives NaN, and an entry beyond the range of `f32` is
    /// infinite. A [`Transform2::Matrix`] alone is returned as it is, bit for bit.
    pub fn chain(transforms: &[Self]) -> Affine2 {
        if let [Self::Matrix(affine)] = transforms {
            // A product, also with the identity, would lose the sign of a zero.
            return *affine;
        }
        transforms.iter().fold(DAffine2::IDENTITY, |chain, next| next.matrix() * chain).as_affine2()
    }

    /// The inverse of [`Transform2::chain`]: the inverses one after the other, the last one first. An entry beyond
    /// the range of `f32` is infinite.
    ///
    /// # Errors
    /// The first transform that has no inverse: see [`Transform2::check`].
    pub fn chain_inverse(transforms: &[Self]) -> Result<Affine2, InvalidTransform<Self>> {
        let inverse = |chain, next: &Self| Ok(chain * next.inverse()?);
        Ok(transforms.iter().try_fold(DAffine2::IDENTITY, inverse)?.as_affine2())
    }
}

/// The rotation about an axis of any length, by Rodrigues' formula. Products of two components are exact, and so is
/// the symmetry: the matrix for `-degrees` is exactly the transpose.
fn rodrigues(axis: DVec3, degrees: f32) -> DMat3 {
    let (sin, cos) = sin_cos(degrees);
    let length_squared = axis.dot(axis);
    let DVec3 { x, y, z } = axis / libm::sqrt(length_squared) * sin;
    let across = DMat3::from_cols(DVec3::new(cos, z, -y), DVec3::new(-z, cos, x), DVec3::new(y, -x, cos));
    let along = axis.to_array().map(|component| axis * component / length_squared * (1.0 - cos));
    across + DMat3::from_cols(along[0], along[1], along[2])
}

/// Whether the determinant of `f32` numbers, computed in `f64`, cannot be told from zero. True for every matrix that
/// is exactly singular, even if rounding makes its determinant non-zero.
pub(crate) fn is_singular(matrix: &DMat3) -> bool {
    // Products of two entries are exact, so each cofactor is rounded once. Three products and two sums follow.
    let cofactors = matrix.x_axis.cross(matrix.y_axis);
    let rounding = 5.0 * 1.110_223_024_625_156_5e-16 * matrix.z_axis.abs().dot(cofactors.abs());
    matrix.z_axis.dot(cofactors).abs() <= rounding
}

/// Sine and cosine of an angle in degrees, with the same bits on every machine. Exact for multiples of 90. NaN for
/// NaN and infinity.
///
/// The angle is first reduced to at most 45 degrees, which is exact. Only then is it converted to radians, which
/// rounds.
fn sin_cos(degrees: f32) -> (f64, f64) {
    let (rest, quarters) = libm::remquo(degrees.into(), 90.0);
    let (sin, cos) = libm::sincos(rest.to_radians());
    match quarters & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Mat2, Mat3, Mat4};

    const fn v(x: f32, y: f32, z: f32) -> Vec3 {
        Vec3::new(x, y, z)
    }

    fn shear(axis: Axis, by: Axis, factor: f32) -> Transform3 {
        Transform3::Shear { axis, by, factor }
    }

    /// One transform of each kind, with numbers of few bits and multiples of 90 degrees: everything is exact.
    fn exact3() -> Vec<Transform3> {
        use Axis::{X, Y, Z};
        let pairs = [(X, Y), (X, Z), (Y, X), (Y, Z), (Z, X), (Z, Y)];
        let mut all = vec![
            Transform3::Translate(v(1.5, -2.0, 3.0)),
            Transform3::Scale(v(2.0, -0.5, 4.0)),
            Transform3::RotateX(90.0),
            Transform3::RotateY(-270.0),
            Transform3::RotateZ(180.0),
        ];
        all.extend(pairs.map(|(axis, by)| shear(axis, by, 0.25)));
        all.push(Transform3::RotateAbout { axis: v(0.0, -3.0, 0.0), degrees: 90.0 });
        all.push(Transform3::Matrix(Transform3::chain(&all)));
        all
    }

    fn exact2() -> [Transform2; 6] {
        let matrix =
            Affine2 { matrix2: Mat2::from_cols_array(&[1.0, 2.0, 0.5, -1.0]), translation: Vec2::new(3.0, -4.0) };
        [
            Transform2::Translate(Vec2::new(1.5, -2.0)),
            Transform2::Scale(Vec2::new(2.0, -0.5)),
            Transform2::Rotate(90.0),
            Transform2::ShearX(0.25),
            Transform2::ShearY(-3.0),
            Transform2::Matrix(matrix),
        ]
    }

    #[test]
    fn each_transform_does_what_its_row_equations_say() {
        use Axis::{X, Y, Z};
        let point = v(1.0, 2.0, 3.0);
        let about = |axis, degrees| Transform3::RotateAbout { axis, degrees };
        let rows = Affine3 {
            matrix3: Mat3::from_cols(v(1.0, 4.0, 0.0), v(0.0, 5.0, 1.0), v(3.0, 0.0, 2.0)),
            translation: v(4.0, 10.0, 30.0),
        };
        let cases = [
            (Transform3::Translate(v(10.0, 20.0, 30.0)), v(11.0, 22.0, 33.0)),
            (Transform3::Scale(v(2.0, 3.0, -4.0)), v(2.0, 6.0, -12.0)),
            (Transform3::RotateX(90.0), v(1.0, -3.0, 2.0)),
            (Transform3::RotateY(90.0), v(3.0, 2.0, -1.0)),
            (Transform3::RotateZ(90.0), v(-2.0, 1.0, 3.0)),
            (Transform3::RotateZ(-90.0), v(2.0, -1.0, 3.0)),
            (Transform3::RotateZ(180.0), v(-1.0, -2.0, 3.0)),
            (Transform3::RotateZ(360.0 * 4097.0), point),
            (about(v(5.0, 0.0, 0.0), 90.0), v(1.0, -3.0, 2.0)),
            (about(v(0.0, -0.1, 0.0), 90.0), v(-3.0, 2.0, 1.0)),
            (about(v(0.0, -0.0, -7.0), -90.0), v(-2.0, 1.0, 3.0)),
            (about(v(1e-30, 1e-30, 0.0), 180.0), v(2.0, 1.0, -3.0)),
            (about(v(1e30, 1e30, 1e30), 120.0), v(3.0, 1.0, 2.0)),
            (Transform3::Matrix(rows), v(14.0, 24.0, 38.0)),
            (shear(X, Y, 10.0), v(21.0, 2.0, 3.0)),
            (shear(X, Z, 10.0), v(31.0, 2.0, 3.0)),
            (shear(Y, X, 10.0), v(1.0, 12.0, 3.0)),
            (shear(Y, Z, 10.0), v(1.0, 32.0, 3.0)),
            (shear(Z, X, 10.0), v(1.0, 2.0, 13.0)),
            (shear(Z, Y, 10.0), v(1.0, 2.0, 23.0)),
        ];
        for (transform, expected) in cases {
            let affine = Transform3::chain(&[transform]);
            assert_eq!(affine.transform_point3(point), expected, "{transform}");
            assert_eq!(Mat4::from(affine) * point.extend(1.0), expected.extend(1.0), "{transform}");
        }
        let point = Vec2::new(1.0, 2.0);
        let cases = [
            (Transform2::Translate(Vec2::new(10.0, 20.0)), Vec2::new(11.0, 22.0)),
            (Transform2::Scale(Vec2::new(2.0, -3.0)), Vec2::new(2.0, -6.0)),
            (Transform2::Rotate(90.0), Vec2::new(-2.0, 1.0)),
            (Transform2::ShearX(10.0), Vec2::new(21.0, 2.0)),
            (Transform2::ShearY(10.0), Vec2::new(1.0, 12.0)),
            (Transform2::Matrix(Affine2::from_cols_array(&[1.0, 4.0, 3.0, 5.0, 10.0, 20.0])), Vec2::new(17.0, 34.0)),
        ];
        for (transform, expected) in cases {
            let affine = Transform2::chain(&[transform]);
            assert_eq!(affine.transform_point2(point), expected, "{transform}");
            assert_eq!(Mat3::from(affine) * point.extend(1.0), expected.extend(1.0), "{transform}");
        }
    }

    #[test]
    fn order_matters() {
        // Scaling, then rotation moves a point on x to twice its distance on y. Rotation, then scaling does not.
        let (stretch, turn) = (Transform3::Scale(v(2.0, 1.0, 1.0)), Transform3::RotateZ(90.0));
        assert_eq!(Transform3::chain(&[stretch, turn]).transform_point3(Vec3::X), v(0.0, 2.0, 0.0));
        assert_eq!(Transform3::chain(&[turn, stretch]).transform_point3(Vec3::X), v(0.0, 1.0, 0.0));
        let (move_, turn) = (Transform2::Translate(Vec2::X), Transform2::Rotate(90.0));
        assert_eq!(Transform2::chain(&[move_, turn]).transform_point2(Vec2::ZERO), Vec2::new(0.0, 1.0));
        assert_eq!(Transform2::chain(&[turn, move_]).transform_point2(Vec2::ZERO), Vec2::new(1.0, 0.0));
    }

    #[test]
    fn inverses_are_exact_for_numbers_of_few_bits() {
        for transform in exact3() {
            let (matrix, inverse) = (transform.matrix(), transform.inverse().unwrap());
            assert_eq!(matrix * inverse, DAffine3::IDENTITY, "{transform}");
            assert_eq!(inverse * matrix, DAffine3::IDENTITY, "{transform}");
        }
        for transform in exact2() {
            let (matrix, inverse) = (transform.matrix(), transform.inverse().unwrap());
            assert_eq!(matrix * inverse, DAffine2::IDENTITY, "{transform}");
            assert_eq!(inverse * matrix, DAffine2::IDENTITY, "{transform}");
        }
    }

    #[test]
    fn a_matrix_alone_keeps_every_bit() {
        let bits3 = |affine: Affine3| affine.to_cols_array().map(f32::to_bits);
        let odd = [1.0, -0.0, 1e-45, 0.0, -1.0, -0.0, f32::MAX, 0.0, 3.0, -0.0, 0.1, -1e-45];
        let matrix = Affine3::from_cols_array(&odd);
        assert_eq!(bits3(Transform3::chain(&[Transform3::Matrix(matrix)])), bits3(matrix));
        let bits2 = |affine: Affine2| affine.to_cols_array().map(f32::to_bits);
        let matrix = Affine2::from_cols_array(&[-0.0, 2.0, 1e-45, 0.0, -0.0, f32::MAX]);
        assert_eq!(bits2(Transform2::chain(&[Transform2::Matrix(matrix)])), bits2(matrix));
    }

    #[test]
    fn the_inverse_of_a_chain_undoes_the_chain() {
        let chain = exact3();
        assert_eq!(Transform3::chain_inverse(&chain).unwrap() * Transform3::chain(&chain), Affine3::IDENTITY);
        let chain = exact2();
        assert_eq!(Transform2::chain_inverse(&chain).unwrap() * Transform2::chain(&chain), Affine2::IDENTITY);
        assert_eq!(Transform3::chain(&[]), Affine3::IDENTITY);
        assert_eq!(Transform2::chain_inverse(&[]).unwrap(), Affine2::IDENTITY);
    }

    #[test]
    fn angles_are_reduced_before_they_become_radians() {
        let quarter = [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)];
        for turns in -9i16..=9 {
            assert_eq!(sin_cos(f32::from(turns) * 90.0), quarter[usize::from(turns.rem_euclid(4) as u16)], "{turns}");
        }
        // 2¹²⁷ degrees are a number of whole turns and this rest.
        let rest = (0..127).fold(1u16, |rest, _| rest * 2 % 360);
        assert_eq!(sin_cos(2f32.powi(127)), sin_cos(f32::from(rest)));
        assert_eq!(sin_cos(30.0).0 as f32, 0.5);
        assert_eq!(sin_cos(60.0).1 as f32, 0.5);
        assert_eq!(sin_cos(150.0).0 as f32, 0.5);
        for degrees in [45.0f32, 135.0, 225.0, 315.0] {
            let (sin, cos) = sin_cos(degrees);
            assert_eq!((sin.abs() as f32, cos.abs() as f32), (0.5f32.sqrt(), 0.5f32.sqrt()), "{degrees}");
        }
        // The point is on the unit circle, up to the rounding of two squares and a sum.
        for step in -2000i16..2000 {
            let (sin, cos) = sin_cos(f32::from(step) * 0.37);
            assert!((sin * sin + cos * cos - 1.0).abs() <= 4.0 * f64::EPSILON, "{step}");
        }
        assert!(sin_cos(f32::NAN).0.is_nan() && sin_cos(f32::INFINITY).1.is_nan());
    }

    #[test]
    fn transforms_without_inverse_are_refused_with_name_and_value() {
        let cases = [
            (Transform3::Scale(v(1.0, 0.0, 2.0)), "scaling by [1, 0, 2]: a factor of zero has no inverse"),
            (Transform3::Scale(v(1.0, -0.0, 2.0)), "scaling by [1, -0, 2]: a factor of zero has no inverse"),
            (Transform3::Scale(v(1.0, f32::NAN, 0.0)), "scaling by [1, NaN, 0]: not a finite number"),
            (Transform3::Translate(v(f32::INFINITY, 0.0, 0.0)), "translation by [inf, 0, 0]: not a finite number"),
            (Transform3::RotateY(f32::NAN), "rotation about y by NaN degrees: not a finite number"),
            (shear(Axis::Z, Axis::X, f32::NEG_INFINITY), "shear of z by x with factor -inf: not a finite number"),
            (shear(Axis::Y, Axis::Y, 3.0), "shear of y by y with factor 3: an axis cannot be sheared by itself"),
            (
                Transform3::RotateAbout { axis: v(0.0, -0.0, 0.0), degrees: 3.0 },
                "rotation about [0, -0, 0] by 3 degrees: an axis of length zero has no direction",
            ),
            (
                Transform3::RotateAbout { axis: v(0.0, f32::NAN, 0.0), degrees: 3.0 },
                "rotation about [0, NaN, 0] by 3 degrees: not a finite number",
            ),
            (
                Transform3::RotateAbout { axis: Vec3::X, degrees: f32::INFINITY },
                "rotation about [1, 0, 0] by inf degrees: not a finite number",
            ),
            (
                Transform3::Matrix(Affine3::from_translation(v(1.0, f32::NAN, 2.0))),
                "matrix of the rows [1, 0, 0, 1], [0, 1, 0, NaN], [0, 0, 1, 2]: not a finite number",
            ),
            (
                // The third column is the sum of the others, but the determinant in f64 is not zero.
                Transform3::Matrix(Affine3::from_mat3(Mat3::from_cols(
                    v(8130510.0, 6369923.0, 6160014.0),
                    v(5802770.0, 8139160.0, 8190244.0),
                    v(13933280.0, 14509083.0, 14350258.0),
                ))),
                "matrix of the rows [8130510, 5802770, 13933280, 0], [6369923, 8139160, 14509083, 0], \
                 [6160014, 8190244, 14350258, 0]: its determinant is zero, or too near to zero, so it has no inverse",
            ),
        ];
        for (transform, message) in cases {
            let chain = [Transform3::RotateX(90.0), transform, Transform3::Scale(Vec3::ZERO)];
            let error = Transform3::chain_inverse(&chain).unwrap_err();
            assert_eq!((error.transform.to_string(), error.to_string()), (transform.to_string(), message.into()));
        }
        let cases = [
            (Transform2::Scale(Vec2::new(0.0, 1.0)), "scaling by [0, 1]: a factor of zero has no inverse"),
            (Transform2::Translate(Vec2::NAN), "translation by [NaN, NaN]: not a finite number"),
            (Transform2::Rotate(f32::INFINITY), "rotation by inf degrees: not a finite number"),
            (Transform2::ShearX(f32::NAN), "shear of x by y with factor NaN: not a finite number"),
            (Transform2::ShearY(f32::NAN), "shear of y by x with factor NaN: not a finite number"),
            (
                Transform2::Matrix(Affine2::from_cols_array(&[1.0, 0.0, 0.0, 1.0, f32::NAN, 2.0])),
                "matrix of the rows [1, 0, NaN], [0, 1, 2]: not a finite number",
            ),
            (
                Transform2::Matrix(Affine2::from_cols_array(&[0.1, 0.3, 0.1, 0.3, 5.0, 6.0])),
                "matrix of the rows [0.1, 0.1, 5], [0.3, 0.3, 6]: its determinant is zero, or too near to \
                 zero, so it has no inverse",
            ),
        ];
        for (transform, message) in cases {
            assert_eq!(Transform2::chain_inverse(&[transform]).unwrap_err().to_string(), message);
        }
        assert!(exact3().iter().all(|transform| transform.check().is_ok()));
        assert!(exact2().iter().all(|transform| transform.check().is_ok()));
        // The determinants of these are small, or the difference of nearly equal products.
        let next_up = 0.3f32.next_up();
        for entries in [[1e-30, 0.0, 0.0, 1e-30], [0.1, 0.3, 0.1, next_up], [1e-45, 0.0, 1e30, 1e-45]] {
            let matrix2 = Mat2::from_cols_array(&entries);
            assert_eq!(Transform2::Matrix(Affine2 { matrix2, translation: Vec2::ZERO }).check(), Ok(()));
        }
    }
}
