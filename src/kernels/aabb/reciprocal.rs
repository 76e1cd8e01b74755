//! `aabb/reciprocal`: the slab test that most tracers start from.
//!
//! **Source:** A. Williams, S. Barrus, R. K. Morley, P. Shirley, "An Efficient and Robust Ray-Box Intersection
//! Algorithm", 2005, in its branch-free form with minimum and maximum.
//!
//! **Idea:** one reciprocal per ray and axis turns divisions into multiplications. Minimum and maximum order each
//! pair of planes, for any sign of the direction.
//!
//! **Fails:** on a plane of a slab that the ray runs parallel to. `0·∞` is NaN there, and minimum and maximum return
//! their second operand. On the upper plane that is the NaN. The accumulators drop it, and the ray hits, as it
//! should. On the lower plane it is +∞. The entry is then beyond everything, and the ray is lost. At edges and
//! corners rounding loses some rays, more than with division, because the reciprocal is rounded too.
//!
//! **Order of operands:** the accumulators are the second operands. A second operand survives a NaN in the first. If
//! it is itself the NaN, it is returned too: a NaN in the ray's interval must stay there and make a miss.
//!
//! **Empty boxes:** minimum and maximum cannot tell a box from the same box with its corners exchanged. So an empty
//! box is stored as a point at infinity, and the ray's interval is cut to finite numbers.
//!
//! **Operations:** 6 subtractions, 6 multiplications, 13 minima, maxima and comparisons. Setup: 3 divisions.

use wide::f32x8;

use super::{InverseDirection, Slabs};
use crate::geom::lanes::{Lanes, le8, max, max8, min, min8};
use crate::geom::{Aabb, Candidate, Ray};
use crate::kernels::{Id, Info, Intersect, Kernel, Operations};

prepared! {
    /// Boxes for the reciprocal slab test.
    pub struct Reciprocal<P: Lanes> {
        slabs: Slabs<P>,
    }
}

impl Kernel for Reciprocal<f32> {
    type Shape = Aabb;
    type Packet = Reciprocal<f32x8>;
    const INFO: Info = Info {
        id: Id::of("aabb/reciprocal"),
        idea: "multiply by the inverse direction, near and far by minimum and maximum",
        source: "Williams, Barrus, Morley, Shirley, \"An Efficient and Robust Ray-Box Intersection Algorithm\", 2005",
        operations: Operations { mul: 6, add: 6, compare: 13, reads: 6, ..Operations::NONE },
        setup: InverseDirection::OPERATIONS.and(Operations { compare: 2, ..Operations::NONE }),
        claims: &[],
    };

    fn prepare(shape: &Aabb) -> Self {
        let slabs = Slabs::prepare(shape);
        // Minimum and maximum would exchange the corners of an inverted box. No ray reaches a point at infinity.
        let empty = slabs.lo.x > slabs.hi.x;
        Self { slabs: if empty { Slabs { lo: slabs.lo, hi: slabs.lo } } else { slabs } }
    }

    prepared!(gather, lane);
}

impl Intersect<f32> for Reciprocal<f32> {
    type Setup = InverseDirection<f32>;

    #[inline(always)]
    fn setup(ray: &Ray<f32>) -> Self::Setup {
        let InverseDirection { inv_dir, t_min, t_max } = InverseDirection::<f32>::of(ray);
        // Make the interval finite. It must not reach an empty box, which is stored at infinity.
        InverseDirection { inv_dir, t_min: max(f32::MIN, t_min), t_max: min(f32::MAX, t_max) }
    }

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32>, setup: &Self::Setup) -> Candidate<f32> {
        let Self { slabs: Slabs { lo, hi } } = *self;

        // Start with the ray's interval.
        let (mut entry, mut exit) = (setup.t_min, setup.t_max);
        for axis in 0..3 {
            let (o, inv) = (ray.origin[axis], setup.inv_dir[axis]);
            // Compute the distances to both planes.
            let (t_lo, t_hi) = ((lo[axis] - o) * inv, (hi[axis] - o) * inv);

            // Cut the interval. A NaN in it must stay, so it comes second.
            entry = max(min(t_lo, t_hi), entry);
            exit = min(max(t_lo, t_hi), exit);
        }

        // Test that the interval is not empty.
        Candidate::<f32>::select(entry <= exit, entry, exit, 0.0)
    }
}

impl<P: Lanes> Intersect<f32x8> for Reciprocal<P> {
    type Setup = InverseDirection<f32x8>;

    #[inline(always)]
    fn setup(ray: &Ray<f32x8>) -> Self::Setup {
        let InverseDirection { inv_dir, t_min, t_max } = InverseDirection::<f32x8>::of(ray);
        // Make the interval finite. It must not reach an empty box, which is stored at infinity.
        let [least, greatest] = [f32::MIN, f32::MAX].map(f32x8::splat);
        InverseDirection { inv_dir, t_min: max8(least, t_min), t_max: min8(greatest, t_max) }
    }

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32x8>, setup: &Self::Setup) -> Candidate<f32x8> {
        let Reciprocal { slabs: Slabs { lo, hi } } = self.widen();

        // Start with the ray's interval.
        let (mut entry, mut exit) = (setup.t_min, setup.t_max);
        for (lo, hi, o, inv) in [
            (lo.x, hi.x, ray.origin.x, setup.inv_dir.x),
            (lo.y, hi.y, ray.origin.y, setup.inv_dir.y),
            (lo.z, hi.z, ray.origin.z, setup.inv_dir.z),
        ] {
            // Compute the distances to both planes.
            let (t_lo, t_hi) = ((lo - o) * inv, (hi - o) * inv);

            // Cut the interval. A NaN in it must stay, so it comes second.
            entry = max8(min8(t_lo, t_hi), entry);
            exit = min8(max8(t_lo, t_hi), exit);
        }

        // Test that the interval is not empty.
        Candidate::<f32x8>::new(le8(entry, exit), entry, exit, f32x8::ZERO)
    }
}
