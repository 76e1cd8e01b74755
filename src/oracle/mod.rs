//! The exact answer to "does this ray hit this shape, and where?", for everything the study measures.
//!
//! Every finite `f32` is a whole number times a power of two, and an intersection needs only sums, products and signs
//! of such numbers, plus one division, or for quadrics one root, whose result is rounded once. So the answer can be exact, with no tolerance
//! anywhere: [`Exact::truth_exact`] computes it in whole numbers of any size. As that takes about a microsecond,
//! [`Exact::truth`] first tries an `f64` filter, which carries a proven error bound beside each value and keeps silent
//! where the bound leaves a doubt.
//!
//! Each shape states its formulas once (`triangle.rs`, `aabb.rs`, `quadric.rs`), over any number that has what `number.rs` asks for;
//! the exact numbers (`exact.rs`) and the bounded ones (`filter.rs`) both run that one body. The oracle knows nothing of
//! the kernels it judges.

mod aabb;
mod exact;
mod filter;
mod number;
mod quadric;
mod triangle;

use crate::geom::Ray;
use crate::geom::Shape;

use exact::Dyadic;
use filter::Bounded;
use number::Number;

/// The exact outcome of intersecting one ray with one shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// Whether the closed shape is hit within the closed interval `t_min <= t <= t_max`.
    pub hit: bool,
    /// Whether that hangs on an equality, so that the slightest error may decide it the other way. A triangle: the hit
    /// is on an edge or a vertex, or `t` is an end of the interval. A box: the part of the ray within the interval
    /// meets the surface but not the inside, as every hit of a flat box does. A quadric: the ray is tangent, or the hit is on
    /// a plane of the clip box or at an end of the interval. Never set for a miss.
    pub boundary: bool,
    /// Ray parameter of the hit, as in [`Hit`](crate::geom::Hit).
    ///
    /// Like `u` and `v` it is the exact value rounded once, to nearest even: it is `±∞` where the exact value exceeds
    /// [`f32::MAX`], and `-0` where it is negative and too small.
    pub t: f32,
    /// First surface parameter of the hit, as in [`Hit`](crate::geom::Hit); for a box, where the ray leaves it.
    pub u: f32,
    /// Second surface parameter of the hit, as in [`Hit`](crate::geom::Hit).
    pub v: f32,
}

impl Truth {
    /// The content of every miss: that of [`Hit::MISS`](crate::geom::Hit::MISS).
    pub const MISS: Self = Self { hit: false, boundary: false, t: f32::INFINITY, u: 0.0, v: 0.0 };
}

/// A shape whose intersection with a ray is known exactly: a triangle, a box, a quadric, or one of them
/// [`Placed`](crate::geom::Placed) by a transform.
///
/// A quadric is hit at the nearest point of its surface that lies both in the closed interval and in the closed clip box.
///
/// What cannot be hit misses: a ray that is not valid, a triangle of zero area or not finite, an empty box, a quadric that
/// is not finite or has an empty clip box or contains the whole line of the ray, a transform that is singular or not
/// finite.
pub trait Exact: Shape {
    /// The exact answer: by the filter where it is sure, else in whole numbers.
    fn truth(&self, ray: &Ray<f32>) -> Truth {
        self.truth_filtered(ray).unwrap_or_else(|| self.truth_exact(ray))
    }

    /// The exact answer, in whole numbers only.
    fn truth_exact(&self, ray: &Ray<f32>) -> Truth;

    /// The exact answer, in `f64` only; `None` where rounding errors leave a doubt about any part of it.
    fn truth_filtered(&self, ray: &Ray<f32>) -> Option<Truth>;
}

/// A shape that states its formulas once for both kinds of numbers.
trait Locate: Shape {
    /// The exact answer; `None` where a sign or a rounding that it needs is unsure.
    fn locate<N: Number>(&self, ray: &Ray<f32>) -> Option<Truth>;
}

impl<S: Locate> Exact for S {
    fn truth_exact(&self, ray: &Ray<f32>) -> Truth {
        self.locate::<Dyadic>(ray).expect("whole numbers leave no doubt")
    }

    fn truth_filtered(&self, ray: &Ray<f32>) -> Option<Truth> {
        self.locate::<Bounded>(ray)
    }
}

/// Whether the ray can hit anything at all: see [`Ray`]. An interval needs a finite `t`, as no ray reaches infinity.
fn can_hit(ray: &Ray<f32>) -> bool {
    ray.is_valid() && ray.t_min <= ray.t_max && ray.t_min < f32::INFINITY && ray.t_max > f32::NEG_INFINITY
}
