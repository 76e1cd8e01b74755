//! The quadric through given points, in a frame in which its polynomial has no products.
//!
//! Two methods. The first finds round cylinders and cones from the normals of their triangles. Such meshes often have
//! only two rings of vertices, and infinitely many quadrics pass through two circles. The second finds any quadric by
//! least squares, if the points leave no choice.
//!
//! Coordinates are those of the points, whose size should be about 1.

use glam::{DMat3, DVec3};

use super::symmetric::eigen;

/// Numbers below this fraction of the others come from rounding.
const NEARLY_ZERO: f64 = 1e-6;
/// The normals of a cylinder have no component along the axis, those of a cone all have the same. This variance, or
/// less, is none.
const NO_VARIANCE: f64 = 1e-6;
/// And across the axis they have at least this one.
const SOME_VARIANCE: f64 = 1e-3;

/// A quadric: `squares·p² + linear·p + constant = 0` in its own frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surface {
    /// The axes of the frame, as unit vectors.
    pub(super) axes: DMat3,
    /// The origin of the frame.
    pub(super) origin: DVec3,
    /// The coefficients. The largest is 1.
    pub(super) squares: DVec3,
    pub(super) linear: DVec3,
    pub(super) constant: f64,
}

impl Surface {
    /// A point in the frame of the surface.
    pub(super) fn in_frame(&self, point: DVec3) -> DVec3 {
        self.axes.transpose() * (point - self.origin)
    }

    /// The polynomial, at a point in the frame.
    pub(super) fn value(&self, point: DVec3) -> f64 {
        self.squares.dot(point * point) + self.linear.dot(point) + self.constant
    }

    /// Its gradient.
    pub(super) fn gradient(&self, point: DVec3) -> DVec3 {
        self.squares * point * 2.0 + self.linear
    }

    /// About how far a point in the frame is from the surface: the distance at which the polynomial could vanish, as
    /// its gradient and its second derivative limit it.
    pub(super) fn distance(&self, point: DVec3) -> f64 {
        let (value, slope) = (self.value(point).abs(), self.gradient(point).length());
        2.0 * value / (slope + (slope * slope + 4.0 * value).sqrt()).max(f64::MIN_POSITIVE)
    }

    /// The same surface in simpler numbers: around its own centre or apex, without what rounding left.
    fn simplified(mut self) -> Self {
        let largest = self.squares.to_array().into_iter().fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
        (self.squares, self.linear, self.constant) =
            (self.squares / largest, self.linear / largest, self.constant / largest);
        for axis in 0..3 {
            let square = self.squares[axis];
            if square.abs() < NEARLY_ZERO {
                self.squares[axis] = 0.0;
            } else if self.linear[axis].abs() < 20.0 * square.abs() {
                // Completes the square. A centre very far away would cost digits.
                let shift = -self.linear[axis] / (2.0 * square);
                self.constant -= square * shift * shift;
                self.origin += self.axes.col(axis) * shift;
                self.linear[axis] = 0.0;
            }
            if (square - 1.0).abs() < NEARLY_ZERO {
                self.squares[axis] = 1.0;
            }
            if self.linear[axis].abs() < NEARLY_ZERO {
                self.linear[axis] = 0.0;
            }
        }
        if self.constant.abs() < NEARLY_ZERO * 0.1 {
            self.constant = 0.0;
        }
        self
    }
}

/// The surfaces that the points may lie on, the simplest first. `normals` are those of the triangles, with lengths in
/// proportion to their areas. Whether points do lie on a surface is not checked.
pub(super) fn candidates(points: &[DVec3], normals: &[DVec3]) -> impl Iterator<Item = Surface> + use<> {
    [round(points, normals), general(points)].into_iter().flatten()
}

/// The cylinder or cone whose normals these are.
fn round(points: &[DVec3], normals: &[DVec3]) -> Option<Surface> {
    let area: f64 = normals.iter().map(|normal| normal.length()).sum();
    let mean = normals.iter().sum::<DVec3>() / area;
    let mut covariance = [[0.0; 3]; 3];
    for normal in normals {
        let length = normal.length().max(f64::MIN_POSITIVE);
        add_square(&mut covariance, (*normal / length - mean).to_array(), length / area);
    }
    let mut spread = eigen(covariance);
    spread.sort_by(|a, b| a.0.total_cmp(&b.0));
    if spread[0].0 > NO_VARIANCE || spread[1].0 < SOME_VARIANCE {
        return None;
    }
    let z = DVec3::from_array(spread[0].1);
    let (x, y) = z.any_orthonormal_pair();
    let axes = DMat3::from_cols(x, y, z);
    let in_axes: Vec<_> = points.iter().map(|point| axes.transpose() * *point).collect();

    // Points at one height have the same distance from the axis: x² + y² = 2a·x + 2b·y + polynomial in z.
    let mut normal_equations = [[0.0; 5]; 5];
    let mut right_side = [0.0; 5];
    for point in &in_axes {
        let row = [point.x, point.y, 1.0, point.z, point.z * point.z];
        add_square(&mut normal_equations, row, 1.0);
        for (sum, factor) in right_side.iter_mut().zip(row) {
            *sum += factor * (point.x * point.x + point.y * point.y);
        }
    }
    let [a, b, ..] = least_squares(normal_equations, right_side);
    let center = DVec3::new(a / 2.0, b / 2.0, 0.0);

    // The radius is `base + slope·z`.
    let mut normal_equations = [[0.0; 2]; 2];
    let mut right_side = [0.0; 2];
    for point in &in_axes {
        let radius = (*point - center).truncate().length();
        add_square(&mut normal_equations, [1.0, point.z], 1.0);
        right_side = [right_side[0] + radius, right_side[1] + radius * point.z];
    }
    let [base, slope] = least_squares(normal_equations, right_side);
    let slope = if slope.abs() < NEARLY_ZERO { 0.0 } else { slope };
    let surface = Surface {
        axes,
        origin: axes * center,
        squares: DVec3::new(1.0, 1.0, -slope * slope),
        linear: DVec3::new(0.0, 0.0, -2.0 * base * slope),
        constant: -base * base,
    };
    Some(surface.simplified())
}

/// The quadric that fits the points best, if only one does.
fn general(points: &[DVec3]) -> Option<Surface> {
    let mut moments = [[0.0; 10]; 10];
    for &DVec3 { x, y, z } in points {
        let monomials = [x * x, y * y, z * z, y * z, z * x, x * y, x, y, z, 1.0];
        add_square(&mut moments, monomials, 1.0 / points.len() as f64);
    }
    let mut fits = eigen(moments);
    fits.sort_by(|a, b| a.0.total_cmp(&b.0));
    // The coordinates have errors of about 1e-7, and the moments have the squares of them.
    if fits[1].0 < 1e4 * fits[0].0.max(1e-16) {
        return None;
    }
    let coefficients = fits[0].1;
    let largest = coefficients[..6].iter().fold(0.0, |largest: f64, coefficient| largest.max(coefficient.abs()));
    let [xx, yy, zz, yz, zx, xy, x, y, z, constant] = coefficients.map(|coefficient| coefficient / largest);
    let [yz, zx, xy] = [yz, zx, xy].map(|product| if product.abs() < NEARLY_ZERO { 0.0 } else { product / 2.0 });
    let principal = eigen([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]]);
    let mut axes = DMat3::from_cols_array_2d(&principal.map(|(_, axis)| axis));
    if axes.determinant() < 0.0 {
        axes.z_axis = -axes.z_axis;
    }
    let surface = Surface {
        axes,
        origin: DVec3::ZERO,
        squares: DVec3::from_array(principal.map(|(value, _)| value)),
        linear: axes.transpose() * DVec3::new(x, y, z),
        constant,
    };
    Some(surface.simplified())
}

/// Adds the matrix of all products of two factors, times the weight.
fn add_square<const N: usize>(sum: &mut [[f64; N]; N], factors: [f64; N], weight: f64) {
    for (row, a) in sum.iter_mut().zip(factors) {
        for (entry, b) in row.iter_mut().zip(factors) {
            *entry += weight * a * b;
        }
    }
}

/// The solution of normal equations. Where several fit equally well, the shortest.
fn least_squares<const N: usize>(matrix: [[f64; N]; N], right_side: [f64; N]) -> [f64; N] {
    let directions = eigen(matrix);
    let largest = directions.iter().fold(0.0, |largest: f64, (value, _)| largest.max(*value));
    let mut solution = [0.0; N];
    for (value, direction) in directions.iter().filter(|(value, _)| *value > 1e-12 * largest) {
        let share = direction.iter().zip(right_side).map(|(a, b)| a * b).sum::<f64>() / value;
        for (entry, along) in solution.iter_mut().zip(direction) {
            *entry += share * along;
        }
    }
    solution
}
