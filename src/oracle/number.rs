//! What the formulas of the shapes need of a number, and vectors of such numbers.

use core::cmp::Ordering;

use glam::{Affine3, Vec3};

use crate::geom::Ray;

/// A number for computing signs and rounded quotients. It is exact, or has an error bound. A function returns `None`
/// if the bound leaves a doubt.
pub(super) trait Number: Clone {
    /// The number `value`, which must be finite.
    fn new(value: f32) -> Self;
    /// Vectors that will be added to or subtracted from each other. All must be finite.
    fn vectors<const K: usize>(vectors: [Vec3; K]) -> [[Self; 3]; K];

    /// `self + other`.
    fn plus(&self, other: &Self) -> Self;
    /// `self · other`.
    fn times(&self, other: &Self) -> Self;
    /// `-self`.
    fn negated(&self) -> Self;
    /// `self - other`.
    fn minus(&self, other: &Self) -> Self {
        self.plus(&other.negated())
    }

    /// How the number compares with zero.
    fn sign(&self) -> Option<Ordering>;
    /// `self / divisor`, correctly rounded. The divisor must be known to be positive.
    fn divided_by(&self, divisor: &Self) -> Option<f32>;
    /// A root of `a·t² + 2b·t + c`, correctly rounded. `a` must be known to be positive, and `discriminant`, which is
    /// `b² - a·c`, not to be negative.
    fn root(a: &Self, b: &Self, c: &Self, discriminant: &Self, which: Root) -> Option<f32>;
}

/// Which root of a polynomial of second degree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Root {
    /// `(-b - √discriminant) / a`.
    Lesser,
    /// `(-b + √discriminant) / a`.
    Greater,
}

/// How `num / den` compares with `limit`, for `den > 0`. `limit` may be infinite.
pub(super) fn compare<N: Number>(num: &N, den: &N, limit: f32) -> Option<Ordering> {
    if limit.is_infinite() {
        return 0.0.partial_cmp(&limit);
    }
    num.minus(&den.times(&N::new(limit))).sign()
}

/// `a - b`.
pub(super) fn minus<N: Number>(a: &[N; 3], b: &[N; 3]) -> [N; 3] {
    core::array::from_fn(|axis| a[axis].minus(&b[axis]))
}

/// `a · b`.
pub(super) fn dot<N: Number>(a: &[N; 3], b: &[N; 3]) -> N {
    a[0].times(&b[0]).plus(&a[1].times(&b[1])).plus(&a[2].times(&b[2]))
}

/// `a × b`.
pub(super) fn cross<N: Number>(a: &[N; 3], b: &[N; 3]) -> [N; 3] {
    [(1, 2), (2, 0), (0, 1)].map(|(j, k)| a[j].times(&b[k]).minus(&a[k].times(&b[j])))
}

/// The linear part L of an affine transform, and its inverse without the division.
pub(super) struct Linear<N> {
    rows: [[N; 3]; 3],
    /// Rows of |det L| · L⁻¹, the adjugate with the sign of the determinant.
    adjugate: [[N; 3]; 3],
    /// |det L|.
    det: N,
}

impl<N: Number> Linear<N> {
    /// Splits a finite transform. The outer `None` is a doubt. The inner `None` is a transform without inverse.
    pub(super) fn of(transform: &Affine3) -> Option<Option<Self>> {
        let matrix = &transform.matrix3;
        let rows = N::vectors([matrix.row(0), matrix.row(1), matrix.row(2)]);
        let [x, y, z] = &N::vectors([matrix.x_axis, matrix.y_axis, matrix.z_axis]);
        let adjugate = [cross(y, z), cross(z, x), cross(x, y)];
        let det = dot(x, &adjugate[0]);
        Some(match det.sign()? {
            Ordering::Equal => None,
            Ordering::Greater => Some(Self { rows, adjugate, det }),
            Ordering::Less => {
                let adjugate = adjugate.map(|row| row.map(|entry| entry.negated()));
                Some(Self { rows, adjugate, det: det.negated() })
            }
        })
    }

    /// L · `vector`.
    pub(super) fn apply(&self, vector: &[N; 3]) -> [N; 3] {
        self.rows.each_ref().map(|row| dot(row, vector))
    }

    /// |det L| · L⁻¹ · `vector`.
    pub(super) fn apply_adjugate(&self, vector: &[N; 3]) -> [N; 3] {
        self.adjugate.each_ref().map(|row| dot(row, vector))
    }

    /// |det L| · L⁻ᵀ · `gradient`: a gradient in the world, but for its length.
    pub(super) fn apply_adjugate_transposed(&self, gradient: &[N; 3]) -> [N; 3] {
        let [x, y, z] = &self.adjugate;
        [0, 1, 2].map(|axis| dot(&[x[axis].clone(), y[axis].clone(), z[axis].clone()], gradient))
    }
}

/// The ray in the coordinates of a shape: the points `(origin + t·dir) / scale`.
pub(super) struct Line<N> {
    pub(super) origin: [N; 3],
    pub(super) dir: [N; 3],
    /// Positive. `None` stands for 1 and saves multiplications.
    scale: Option<N>,
}

impl<N: Number> Line<N> {
    /// The unchanged ray. It must be valid.
    pub(super) fn of(ray: &Ray<f32>) -> Self {
        let [origin] = N::vectors([ray.origin]);
        let [dir] = N::vectors([ray.dir]);
        Self { origin, dir, scale: None }
    }

    /// The ray in the space of the object that the transform places. The ray must be valid. Everything is multiplied
    /// by the determinant, so nothing is divided. The outer `None` is a doubt. The inner `None` is a transform that
    /// is not finite or has no inverse.
    pub(super) fn in_object_space(transform: &Affine3, ray: &Ray<f32>) -> Option<Option<Self>> {
        if !transform.is_finite() {
            return Some(None);
        }
        let Some(linear) = Linear::<N>::of(transform)? else {
            return Some(None);
        };
        let [o, translation] = &N::vectors([ray.origin, transform.translation]);
        let origin = linear.apply_adjugate(&minus(o, translation));
        let [d] = &N::vectors([ray.dir]);
        Some(Some(Self { origin, dir: linear.apply_adjugate(d), scale: Some(linear.det) }))
    }

    /// `number · scale`.
    pub(super) fn scaled(&self, number: N) -> N {
        match &self.scale {
            Some(scale) => number.times(scale),
            None => number,
        }
    }
}
