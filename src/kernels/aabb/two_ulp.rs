//! `aabb/two_ulp`: the slab test with the exit moved out by at least two ulp. A warning.
//!
//! **Source:** T. Ize, "Robust BVH Ray Traversal", 2013, in its form with one multiplication, `exit·1.00000024`. Many
//! tracers have copied it.
//!
//! **Idea:** the factor 1 + 2⁻²² is 2 to 4 ulp. Rounding should then not put the exit before an entry that it truly
//! follows. The rest is as in `aabb/sign_selected`.
//!
//! **Differs from the source:** an interval may start behind the origin.
//!
//! **Edges:** planes, edges and corners in front of the origin hit.
//!
//! **Fails:** a negative exit moves away from zero, the wrong way. An exit ahead moves by 4ε, ε = 2⁻²⁴. Entry and exit
//! together may err by 6ε, which is what `aabb/padded` adds (2γ₃). So rays that cut off an edge are lost, though rarely
//! ahead. `tests/cases/boxes.toml` has one of each kind.
//!
//! **Seen:** of 3.0e8 rays that cut off an edge ahead, within an ulp, it loses 2 (`aabb/padded` none,
//! `aabb/sign_selected` 1.97e7). Of 1.5e7 behind the origin, it loses 1.16e7 (none, 9.8e5). From 1e5 sizes away, 9,414
//! in a million of the rays that miss are hits (`aabb/padded`: 17,257). In all other regimes these rates differ by at
//! most 4 %.
//!
//! **Operations:** 6 subtractions, 6 multiplications and 1 for the padding, 8 minima, maxima and comparisons. Setup:
//! 3 divisions.

use wide::f32x8;

use super::{InverseDirection, Slabs, slab_interval, slab_interval8};
use crate::geom::lanes::{Lanes, le8, min, min8};
use crate::geom::{Aabb, Candidate, Ray};
use crate::kernels::{Id, Info, Intersect, Kernel, Operations};

/// 1 + 2⁻²²: at least two ulp more.
const PAD: f32 = 1.0 + 2.0 * f32::EPSILON;

prepared! {
    /// Boxes for the slab test with an exit two ulp later.
    pub struct TwoUlp<P: Lanes> {
        slabs: Slabs<P>,
    }
}

impl Kernel for TwoUlp<f32> {
    type Shape = Aabb;
    type Packet = TwoUlp<f32x8>;
    const INFO: Info = Info {
        id: Id::of("aabb/two_ulp"),
        idea: "sign-selected, with the exit times 1 + 2 ulp",
        source: "Ize, \"Robust BVH Ray Traversal\", 2013",
        operations: Operations { mul: 7, add: 6, compare: 8, reads: 6, ..Operations::NONE },
        setup: InverseDirection::OPERATIONS,
        claims: &[],
    };

    fn prepare(shape: &Aabb) -> Self {
        Self { slabs: Slabs::prepare(shape) }
    }

    prepared!(gather, lane);
}

impl Intersect<f32> for TwoUlp<f32> {
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

        // Move the exit out.
        let exit = min(exit * PAD, setup.t_max);

        // Test that the interval is not empty.
        Candidate::<f32>::select(entry <= exit, entry, exit, 0.0)
    }
}

impl<P: Lanes> Intersect<f32x8> for TwoUlp<P> {
    type Setup = InverseDirection<f32x8>;

    #[inline(always)]
    fn setup(ray: &Ray<f32x8>) -> Self::Setup {
        InverseDirection::<f32x8>::of(ray)
    }

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32x8>, setup: &Self::Setup) -> Candidate<f32x8> {
        let TwoUlp { slabs } = self.widen();

        // Cut the ray's interval by the slabs.
        let (entry, exit) = slab_interval8(&slabs, ray.origin, setup);

        // Move the exit out.
        let exit = min8(exit * f32x8::splat(PAD), setup.t_max);

        // Test that the interval is not empty.
        Candidate::<f32x8>::new(le8(entry, exit), entry, exit, f32x8::ZERO)
    }
}
