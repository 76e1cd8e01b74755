//! The exact answer to "does this ray hit this shape, and where?", for everything that the study measures.
//!
//! Every finite `f32` is an integer times a power of two. An intersection needs only sums, products and signs of such
//! numbers, and one division (for quadrics one root), whose result is rounded once. So the answer can be exact,
//! without any tolerance. [`Exact::truth_exact`] computes it in integers of any size and takes about a microsecond.
//! [`Exact::truth`] first tries a filter in `f64`. The filter carries a proven error bound beside each value, and
//! gives no answer where the bound leaves a doubt.
//!
//! Each shape states its formulas once (`triangle.rs`, `aabb.rs`, `quadric.rs`), for any type that implements the
//! trait of `number.rs`. The exact numbers (`exact.rs`) and the bounded ones (`filter.rs`) share these formulas. The
//! oracle knows nothing of the kernels that it judges.
//!
//! [`Exact::exact_hit`] gives point and normal of a hit, in `f64` (`hit.rs`).

mod aabb;
mod exact;
mod filter;
mod hit;
mod number;
mod quadric;
mod triangle;

use crate::geom::Ray;
use crate::geom::Shape;

use exact::Dyadic;
use filter::Bounded;
pub use hit::ExactHit;
use number::Number;

/// The exact outcome of intersecting one ray with one shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// Whether the closed shape is hit within the closed interval `t_min <= t <= t_max`.
    pub hit: bool,
    /// Whether an equality decides, so the smallest error may reverse the answer. Never set for a miss.
    ///
    /// - A triangle: the hit is on an edge or a vertex, or `t` is an end of the interval.
    /// - A box: the part of the ray in the interval meets the surface but not the inside. This holds for every hit of
    ///   a flat box.
    /// - A quadric: the ray is tangent, or the hit is on a plane of the clip box or at an end of the interval.
    pub boundary: bool,
    /// Ray parameter of the hit, as in [`Hit`](crate::geom::Hit).
    ///
    /// Like `u` and `v` it is the exact value, rounded once, to nearest even. It is `±∞` if the exact value exceeds
    /// [`f32::MAX`], and `-0` if it is negative and too small.
    pub t: f32,
    /// First surface parameter of the hit, as in [`Hit`](crate::geom::Hit). For a box: where the ray leaves it.
    pub u: f32,
    /// Second surface parameter of the hit, as in [`Hit`](crate::geom::Hit).
    pub v: f32,
}

impl Truth {
    /// The content of every miss, that of [`Hit::MISS`](crate::geom::Hit::MISS).
    pub const MISS: Self = Self { hit: false, boundary: false, t: f32::INFINITY, u: 0.0, v: 0.0 };
}

/// A shape whose intersection with a ray is known exactly: a triangle, a box, a quadric, or one of them
/// [`Placed`](crate::geom::Placed) by a transform.
///
/// A quadric is hit at the nearest point of its surface that lies in both the closed interval and the closed clip
/// box.
///
/// These miss: a ray that is not valid; a triangle that has zero area or is not finite; an empty box; a quadric that
/// is not finite, has an empty clip box, or contains the whole line of the ray; a transform that is singular or not
/// finite.
pub trait Exact: Shape {
    /// The exact answer: from the filter where it is sure, else from integers.
    fn truth(&self, ray: &Ray<f32>) -> Truth {
        self.truth_filtered(ray).unwrap_or_else(|| self.truth_exact(ray))
    }

    /// The exact answer, from integers only.
    fn truth_exact(&self, ray: &Ray<f32>) -> Truth;

    /// The exact answer, from `f64` only. `None` where rounding errors leave a doubt about any part of it.
    fn truth_filtered(&self, ray: &Ray<f32>) -> Option<Truth>;

    /// Point and normal of a hit. `truth` must be the answer for this ray, and a hit whose `t` is finite.
    fn exact_hit(&self, ray: &Ray<f32>, truth: &Truth) -> ExactHit;
}

/// A shape that states its formulas once, for both kinds of numbers.
trait Locate: Shape {
    /// The exact answer. `None` if a sign or a rounding that it needs is in doubt.
    fn locate<N: Number>(&self, ray: &Ray<f32>) -> Option<Truth>;

    /// [`Exact::exact_hit`].
    fn locate_hit(&self, ray: &Ray<f32>, truth: &Truth) -> ExactHit;
}

/// Why a hit has a determinant and a polynomial that are not zero.
const HIT: &str = "the ray hits the shape";

impl<S: Locate> Exact for S {
    fn truth_exact(&self, ray: &Ray<f32>) -> Truth {
        self.locate::<Dyadic>(ray).expect("integers leave no doubt")
    }

    fn truth_filtered(&self, ray: &Ray<f32>) -> Option<Truth> {
        self.locate::<Bounded>(ray)
    }

    fn exact_hit(&self, ray: &Ray<f32>, truth: &Truth) -> ExactHit {
        self.locate_hit(ray, truth)
    }
}

/// Whether the ray can hit anything: see [`Ray`]. Its interval must contain a finite `t`, because no ray reaches
/// infinity.
fn can_hit(ray: &Ray<f32>) -> bool {
    ray.is_valid() && ray.t_min <= ray.t_max && ray.t_min < f32::INFINITY && ray.t_max > f32::NEG_INFINITY
}
