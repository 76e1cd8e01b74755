//! `aabb/sign_selected`: near and far plane by sign bit; a NaN drops out.
//!
//! **Source:** A. Williams, S. Barrus, R. K. Morley, P. Shirley, "An Efficient and Robust Ray-Box Intersection
//! Algorithm", 2005 (sign of the inverse direction). The order of operands that lets a NaN drop out is discussed in
//! T. Barnes, "Fast, Branchless Ray/Bounding Box Intersections, Part 2: NaNs", 2015, and "Part 3: Boundaries", 2022.
//! Part 3 ends with this test.
//!
//! **Left out:** the other test of Part 3, `min(max(t₁, entry), max(t₂, entry))`. It gives the same figures in all
//! regimes, to the last ray, and takes 19 minima, maxima and comparisons instead of 7.
//!
//! **Idea:** the sign bit of the inverse direction says which plane of a slab is near. −0 has it, +0 does not. An
//! accumulator changes only if a comparison succeeds, and a comparison with `0·∞` never does.
//!
//! **Edges:** a ray in a plane of a slab that it runs parallel to hits, as it should. At edges and corners entry and
//! exit differ only by rounding, and some rays are lost.
//!
//! **Operations:** 6 subtractions, 6 multiplications, 7 minima, maxima and comparisons. Setup: 3 divisions. Each
//! distance has a relative error of at most γ₃ = 3ε / (1 - 3ε), ε = 2⁻²⁴, unless a product overflows or underflows.

use wide::f32x8;

use super::{InverseDirection, Slabs, slab_interval, slab_interval8};
use crate::geom::lanes::{Lanes, le8};
use crate::geom::{Aabb, Candidate, Ray};
use crate::kernels::{Id, Info, Intersect, Kernel, Operations};

prepared! {
    /// Boxes for the sign-selected slab test.
    pub struct SignSelected<P: Lanes> {
        slabs: Slabs<P>,
    }
}

impl Kernel for SignSelected<f32> {
    type Shape = Aabb;
    type Packet = SignSelected<f32x8>;
    const INFO: Info = Info {
        id: Id::of("aabb/sign_selected"),
        idea: "near and far plane by the sign bit of the inverse direction; NaN drops out",
        source: "Williams, Barrus, Morley, Shirley, \"An Efficient and Robust Ray-Box Intersection Algorithm\", 2005",
        operations: Operations { mul: 6, add: 6, compare: 7, reads: 6, ..Operations::NONE },
        setup: InverseDirection::OPERATIONS,
        claims: &[],
    };

    fn prepare(shape: &Aabb) -> Self {
        Self { slabs: Slabs::prepare(shape) }
    }

    prepared!(gather, lane);
}

impl Intersect<f32> for SignSelected<f32> {
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

        // Test that the interval is not empty.
        Candidate::<f32>::select(entry <= exit, entry, exit, 0.0)
    }
}

impl<P: Lanes> Intersect<f32x8> for SignSelected<P> {
    type Setup = InverseDirection<f32x8>;

    #[inline(always)]
    fn setup(ray: &Ray<f32x8>) -> Self::Setup {
        InverseDirection::<f32x8>::of(ray)
    }

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32x8>, setup: &Self::Setup) -> Candidate<f32x8> {
        let SignSelected { slabs } = self.widen();

        // Cut the ray's interval by the slabs.
        let (entry, exit) = slab_interval8(&slabs, ray.origin, setup);

        // Test that the interval is not empty.
        Candidate::<f32x8>::new(le8(entry, exit), entry, exit, f32x8::ZERO)
    }
}
