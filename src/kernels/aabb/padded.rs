//! `aabb/padded`: the slab test that loses no hit.
//!
//! **Source:** T. Ize, "Robust BVH Ray Traversal", 2013; the constant as in M. Pharr, W. Jakob, G. Humphreys,
//! "Physically Based Rendering", chapter on rounding error.
//!
//! **Idea:** each distance has a relative error of at most γ₃. The exit is moved out by 2γ₃ relative to itself. Then
//! it cannot come before an entry that it truly follows. So a miss is a proof of a true miss. A hit may be off by a
//! few ulp.
//!
//! **Differs from the sources:** intervals may start behind the origin. A negative exit has to move towards zero, not
//! away from it. The larger of `exit·(1 + 2γ₃)` and `exit·(1 - 2γ₃)` does that. Both are monotonic in `exit` under
//! rounding, and so is the larger one.
//!
//! **Edges:** planes, edges and corners all hit; no ray is lost. **Claim:** conservative, unless a product overflows
//! or underflows. A direction component below 2⁻¹²⁸ has no finite reciprocal, and a distance below 2⁻¹²⁶ has no
//! relative error bound.
//!
//! **Operations:** 6 subtractions, 6 multiplications and 2 for the padding, 9 minima, maxima and comparisons. Setup:
//! 3 divisions.

use wide::f32x8;

use super::{InverseDirection, Slabs, slab_interval, slab_interval8};
use crate::geom::lanes::{Lanes, le8, max, max8, min, min8};
use crate::geom::{Aabb, Candidate, Ray};
use crate::kernels::{Claim, Id, Info, Intersect, Kernel, Operations};

/// Factor for a positive exit distance: 1 + 2γ₃, rounded up. γ₃ = 3ε / (1 - 3ε), ε = 2⁻²⁴, bounds the relative error
/// of `(plane - origin) * (1 / dir)`. Rounded to nearest, the factor would be 1 + 6ε. That is less than 1 + 2γ₃ by
/// 18ε², and a bound that is almost large enough proves nothing.
const PAD_AHEAD: f32 = 1.0 + 4.0 * f32::EPSILON;
/// Factor for a negative exit distance: 1 - 2γ₃, rounded down.
const PAD_BEHIND: f32 = 1.0 - 3.5 * f32::EPSILON;

/// The exit distance, moved out by the error bound and clipped to the ray's interval.
#[inline(always)]
pub(crate) fn pad(exit: f32, t_max: f32) -> f32 {
    min(max(exit * PAD_AHEAD, exit * PAD_BEHIND), t_max)
}

/// [`pad`] in eight lanes.
#[inline(always)]
pub(crate) fn pad8(exit: f32x8, t_max: f32x8) -> f32x8 {
    min8(max8(exit * f32x8::splat(PAD_AHEAD), exit * f32x8::splat(PAD_BEHIND)), t_max)
}

prepared! {
    /// Boxes for the padded slab test.
    pub struct Padded<P: Lanes> {
        slabs: Slabs<P>,
    }
}

impl Kernel for Padded<f32> {
    type Shape = Aabb;
    type Packet = Padded<f32x8>;
    const INFO: Info = Info {
        id: Id::of("aabb/padded"),
        idea: "sign-selected, with the exit moved out by the error bound: a miss is proven",
        source: "Ize, \"Robust BVH Ray Traversal\", 2013",
        operations: Operations { mul: 8, add: 6, compare: 9, reads: 6, ..Operations::NONE },
        setup: InverseDirection::OPERATIONS,
        claims: &[Claim::Conservative],
    };

    fn prepare(shape: &Aabb) -> Self {
        Self { slabs: Slabs::prepare(shape) }
    }

    prepared!(gather, lane);
}

impl Intersect<f32> for Padded<f32> {
    type Setup = InverseDirection<f32>;

    #[inline(always)]
    fn setup(ray: &Ray<f32>) -> Self::Setup {
        InverseDirection::<f32>::of(ray)
    }

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32>, setup: &Self::Setup) -> Candidate<f32> {
        let Self { slabs } = self;

        // Cut the ray's interval by the slabs.
        let (entry, exit) = slab_interval(slabs, ray.origin, setup);

        // Move the exit out by the error bound.
        let exit = pad(exit, setup.t_max);

        // Test that the interval is not empty.
        Candidate::<f32>::select(entry <= exit, entry, exit, 0.0)
    }
}

impl<P: Lanes> Intersect<f32x8> for Padded<P> {
    type Setup = InverseDirection<f32x8>;

    #[inline(always)]
    fn setup(ray: &Ray<f32x8>) -> Self::Setup {
        InverseDirection::<f32x8>::of(ray)
    }

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32x8>, setup: &Self::Setup) -> Candidate<f32x8> {
        let Padded { slabs } = self.widen();

        // Cut the ray's interval by the slabs.
        let (entry, exit) = slab_interval8(&slabs, ray.origin, setup);

        // Move the exit out by the error bound.
        let exit = pad8(exit, setup.t_max);

        // Test that the interval is not empty.
        Candidate::<f32x8>::new(le8(entry, exit), entry, exit, f32x8::ZERO)
    }
}
