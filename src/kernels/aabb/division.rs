//! `aabb/division`: the textbook's slab test.
//!
//! **Source:** T. L. Kay, J. T. Kajiya, "Ray Tracing Complex Scenes", 1986, in the form of P. Shirley, S. Marschner
//! et al., "Fundamentals of Computer Graphics" (chapter on ray tracing).
//!
//! **Idea:** divide the distance to each plane by the direction. Order each pair of planes by the sign of the
//! direction. Compare the latest entry with the earliest exit.
//!
//! **Differs from the textbook:** a ray has an interval. Comparisons are true for a hit, so a NaN is a miss.
//!
//! **Fails:** parallel to a slab. `d >= 0` holds for `-0` too, but the division by it gives `-∞` for planes ahead. So
//! near and far are exchanged, and the ray misses. On a plane of the slab `0/0` is NaN, and the ray misses. At edges
//! and corners entry and exit differ only by rounding, and some rays are lost.
//!
//! **Operations:** 6 subtractions, 6 divisions, 13 comparisons. The setup only checks the ray; the divisions per box
//! are the price.

use wide::f32x8;

use super::{Interval, Slabs, VALIDITY};
use crate::geom::lanes::{Lanes, eq8, ge8, gt8, le8, lt8};
use crate::geom::{Aabb, Candidate, Mask8, Ray};
use crate::kernels::{Id, Info, Intersect, Kernel, Operations};

prepared! {
    /// Boxes for the division slab test.
    pub struct Division<P: Lanes> {
        slabs: Slabs<P>,
    }
}

impl Kernel for Division<f32> {
    type Shape = Aabb;
    type Packet = Division<f32x8>;
    const INFO: Info = Info {
        id: Id::of("aabb/division"),
        idea: "distances to the six planes by division, near and far by the sign of the direction",
        source: "Kay, Kajiya, \"Ray Tracing Complex Scenes\", 1986; \
                 Shirley, Marschner, \"Fundamentals of Computer Graphics\"",
        operations: Operations { add: 6, compare: 13, div: 6, reads: 6, ..Operations::NONE },
        setup: VALIDITY,
        claims: &[],
    };

    fn prepare(shape: &Aabb) -> Self {
        Self { slabs: Slabs::prepare(shape) }
    }

    prepared!(gather, lane);
}

impl Intersect<f32> for Division<f32> {
    type Setup = Interval<f32>;

    #[inline(always)]
    fn setup(ray: &Ray<f32>) -> Self::Setup {
        Interval::<f32>::of(ray)
    }

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32>, setup: &Self::Setup) -> Candidate<f32> {
        let Self { slabs: Slabs { lo, hi } } = *self;

        // Start with the ray's interval.
        let (mut entry, mut exit) = (setup.t_min, setup.t_max);
        let mut ordered = true;
        for axis in 0..3 {
            let (o, d) = (ray.origin[axis], ray.dir[axis]);

            // Choose the near and the far plane by the sign of the direction.
            let (near, far) = if d >= 0.0 { (lo[axis], hi[axis]) } else { (hi[axis], lo[axis]) };

            // Compute the distances to both planes.
            let (t_near, t_far) = ((near - o) / d, (far - o) / d);

            // Cut the interval, and remember whether a distance is NaN.
            entry = if t_near > entry { t_near } else { entry };
            exit = if t_far < exit { t_far } else { exit };
            ordered &= !t_near.is_nan() & !t_far.is_nan();
        }

        // Test that the interval is not empty and that no distance is NaN.
        Candidate::<f32>::select(ordered & (entry <= exit), entry, exit, 0.0)
    }
}

impl<P: Lanes> Intersect<f32x8> for Division<P> {
    type Setup = Interval<f32x8>;

    #[inline(always)]
    fn setup(ray: &Ray<f32x8>) -> Self::Setup {
        Interval::<f32x8>::of(ray)
    }

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32x8>, setup: &Self::Setup) -> Candidate<f32x8> {
        let Division { slabs: Slabs { lo, hi } } = self.widen();

        // Start with the ray's interval.
        let (mut entry, mut exit) = (setup.t_min, setup.t_max);
        let mut ordered = Mask8::all_lanes();
        for (lo, hi, o, d) in [
            (lo.x, hi.x, ray.origin.x, ray.dir.x),
            (lo.y, hi.y, ray.origin.y, ray.dir.y),
            (lo.z, hi.z, ray.origin.z, ray.dir.z),
        ] {
            // Choose the near and the far plane by the sign of the direction.
            let forward = ge8(d, f32x8::ZERO);
            let (near, far) = (forward.select(lo, hi), forward.select(hi, lo));

            // Compute the distances to both planes.
            let (t_near, t_far) = ((near - o) / d, (far - o) / d);

            // Cut the interval, and remember whether a distance is NaN.
            entry = gt8(t_near, entry).select(t_near, entry);
            exit = lt8(t_far, exit).select(t_far, exit);
            ordered = ordered & eq8(t_near, t_near) & eq8(t_far, t_far);
        }

        // Test that the interval is not empty and that no distance is NaN.
        Candidate::<f32x8>::new(ordered & le8(entry, exit), entry, exit, f32x8::ZERO)
    }
}
