//! `aabb/padded`: the slab test that never misses.
//!
//! **Source:** T. Ize, "Robust BVH Ray Traversal", 2013; the constant as in M. Pharr, W. Jakob, G. Humphreys,
//! "Physically Based Rendering", chapter on rounding error.
//!
//! **Idea:** each distance has a relative error of at most γ₃, so an exit that is later by 2γ₃ relative to itself cannot
//! come before an entry that it truly follows. A miss is then a proof of a true miss; a hit may be off by a few ulp.
//!
//! **Differs from the sources** in that intervals may start behind the origin. A negative exit is moved towards zero,
//! not away from it, by taking the larger of `exit·(1 + 2γ₃)` and `exit·(1 - 2γ₃)`. Both are monotonic in `exit` under
//! rounding, hence so is the larger one.
//!
//! **Edges:** loses none: planes, edges and corners all hit. **Claim:** conservative, unless a product over- or
//! underflows (a direction component below 2⁻¹²⁸ has no finite reciprocal; a distance below 2⁻¹²⁶ has no relative bound).
//!
//! **Operations:** 6 subtractions, 6 multiplications and 2 for the padding, 9 minima, maxima and comparisons; setup 3
//! divisions.

use wide::f32x8;

use super::{InverseDirection, Slabs, slab_interval, slab_interval8};
use crate::geom::lanes::{Lanes, le8, max, max8, min, min8};
use crate::geom::{Aabb, Hit, Ray};
use crate::kernels::{Claim, Id, Info, Intersect, Kernel, Operations};

/// What a positive exit distance is multiplied by: 1 + 2γ₃, rounded up. γ₃ = 3ε / (1 - 3ε), ε = 2⁻²⁴, bounds the relative
/// error of `(plane - origin) * (1 / dir)`. Rounded to nearest it would be 1 + 6ε, which is less than 1 + 2γ₃ by 18ε²:
/// a bound that is nearly always enough proves nothing.
const PAD_AHEAD: f32 = 1.0 + 4.0 * f32::EPSILON;
/// What a negative exit distance is multiplied by: 1 - 2γ₃, rounded down.
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
        idea: "sign-selected, with the exit moved out by the error bound: a miss is a proof",
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
    fn candidate(&self, ray: &Ray<f32>, setup: &Self::Setup) -> Hit<f32> {
        let Self { slabs } = self;

        // Cut the ray's interval by the slabs.
        let (entry, exit) = slab_interval(slabs, ray.origin, setup);

        // Move the exit out by the error bound.
        let exit = pad(exit, setup.t_max);

        // Test that the interval is not empty.
        Hit::<f32>::select(entry <= exit, entry, exit, 0.0)
    }
}

impl<P: Lanes> Intersect<f32x8> for Padded<P> {
    type Setup = InverseDirection<f32x8>;

    #[inline(always)]
    fn setup(ray: &Ray<f32x8>) -> Self::Setup {
        InverseDirection::<f32x8>::of(ray)
    }

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32x8>, setup: &Self::Setup) -> Hit<f32x8> {
        let Padded { slabs } = self.widen();

        // Cut the ray's interval by the slabs.
        let (entry, exit) = slab_interval8(&slabs, ray.origin, setup);

        // Move the exit out by the error bound.
        let exit = pad8(exit, setup.t_max);

        // Test that the interval is not empty.
        Hit::<f32x8>::candidate(le8(entry, exit), entry, exit, f32x8::ZERO)
    }
}
