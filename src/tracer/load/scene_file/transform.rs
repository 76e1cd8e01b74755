//! The `transform` lists of a scene file, in space and in the plane, and their composition.

use std::fmt::Display;

use glam::{Affine2, Affine3, Mat3, Vec2, Vec3};
use serde::Deserialize;
use toml::Spanned;

use super::error::SpanError;
use super::number::{Array, Factors, Finite, Matrix, Point};
use crate::geom::{Axis, InvalidTransform, Transform2, Transform3};
use crate::tracer::scene::is_singular;

/// A list of transforms. The first one is applied first.
pub(super) type Steps<S> = Spanned<Vec<Spanned<S>>>;

/// One transform of space.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum Step3 {
    Translate(Point),
    Scale(Factors<3>),
    RotateX(Finite),
    RotateY(Finite),
    RotateZ(Finite),
    Rotate(Rotation),
    Shear { axis: AxisName, by: AxisName, factor: Finite },
    Matrix(Matrix),
}

#[derive(Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table of axis and degrees")]
pub(super) struct Rotation {
    axis: Point,
    degrees: Finite,
}

impl From<Step3> for Transform3 {
    fn from(step: Step3) -> Self {
        match step {
            Step3::Translate(by) => Self::Translate(by.0),
            Step3::Scale(by) => Self::Scale(Vec3::from_array(by.0.map(|factor| factor.0))),
            Step3::RotateX(degrees) => Self::RotateX(degrees.0),
            Step3::RotateY(degrees) => Self::RotateY(degrees.0),
            Step3::RotateZ(degrees) => Self::RotateZ(degrees.0),
            Step3::Rotate(Rotation { axis, degrees }) => Self::RotateAbout { axis: axis.0, degrees: degrees.0 },
            Step3::Shear { axis, by, factor } => Self::Shear { axis: axis.into(), by: by.into(), factor: factor.0 },
            Step3::Matrix(matrix) => Self::Matrix(matrix.0),
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

/// One transform of the plane.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Step2 {
    Translate(Array<Finite, 2>),
    Scale(Factors<2>),
    Rotate(Finite),
    ShearX(Finite),
    ShearY(Finite),
    Matrix(Array<Array<Finite, 3>, 2>),
}

impl From<Step2> for Transform2 {
    fn from(step: Step2) -> Self {
        let vector = |[x, y]: [Finite; 2]| Vec2::new(x.0, y.0);
        match step {
            Step2::Translate(by) => Self::Translate(vector(by.0)),
            Step2::Scale(by) => Self::Scale(vector(by.0)),
            Step2::Rotate(degrees) => Self::Rotate(degrees.0),
            Step2::ShearX(factor) => Self::ShearX(factor.0),
            Step2::ShearY(factor) => Self::ShearY(factor.0),
            Step2::Matrix(Array(rows)) => {
                let [x, y] = rows.map(|Array(row)| Vec3::from_array(row.map(|number| number.0)));
                Self::Matrix(Affine2::from_mat3(Mat3::from_cols(x, y, Vec3::Z).transpose()))
            }
        }
    }
}

/// Composes transforms of space. Refuses a result that has no inverse.
pub(super) fn compose3(steps: &Steps<Step3>) -> Result<Affine3, SpanError> {
    let transform = Transform3::chain(&checked(steps, Transform3::check)?);
    if is_singular(transform) {
        return Err(SpanError::new(steps.span(), format!("too large, or has no inverse: {transform}")));
    }
    Ok(transform)
}

/// Composes transforms of the plane. Refuses a result that is not finite.
pub(super) fn compose2(steps: &Steps<Step2>) -> Result<Affine2, SpanError> {
    let transform = Transform2::chain(&checked(steps, Transform2::check)?);
    if !transform.is_finite() {
        return Err(SpanError::new(steps.span(), format!("too large: {transform}")));
    }
    Ok(transform)
}

/// Converts the steps and checks each.
fn checked<S: Copy + Into<T>, T: Display>(
    steps: &Steps<S>,
    check: impl Fn(&T) -> Result<(), InvalidTransform<T>>,
) -> Result<Vec<T>, SpanError> {
    let steps = steps.get_ref().iter().map(|step| {
        let transform = (*step.get_ref()).into();
        check(&transform).map_err(|error| SpanError::new(step.span(), error.to_string()))?;
        Ok(transform)
    });
    steps.collect()
}
