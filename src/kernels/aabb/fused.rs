//! `aabb/fused`: the slab test with one fused operation per plane. A warning.
//!
//! **Source:** the usual advice to "precompute `-origin·inv_dir` and use FMA"; for instance I. Wald, S. Woop, C.
//! Benthin, G. S. Johnson, M. Ernst, "Embree: A Kernel Framework for Efficient CPU Ray Tracing", 2014 (its fast
//! traversal).
//!
//! **Idea:** `plane·inv_dir - origin·inv_dir`. The second product is computed once per ray. The rest is as in
//! `aabb/sign_selected`.
//!
//! **Fails:** the two products cancel. The rounding error of `origin·inv_dir` is proportional to the distance from
//! the origin of coordinates, not from the box, and all of it remains in the result. A box of size 1 seen from 1e6
//! away has planes that are off by a sixteenth. With a zero in the direction, both products are infinite or `0·∞`.
//! Their difference is NaN more often than not, and the slab drops out: a parallel ray *beside* the box hits. The
//! test is not monotonic in the way that the tracer's guarantee needs. It may be used for culling only with its error
//! added (see `tracer`).
//!
//! **Rays without a usable slab:** if `origin·inv_dir` is finite on no axis, all three slabs drop out, and the ray
//! would hit even an empty box. Such a ray gets an empty interval, and so loses true hits.
//!
//! **Operations:** 6 fused multiply-adds, 7 minima, maxima and comparisons. Setup: 3 divisions, 3 multiplications.
//! The kernel exists only in builds with fused multiply-add.

use glam::Vec3;
use wide::f32x8;

use super::{InverseDirection, Slabs};
use crate::geom::lanes::{Lanes, Vec3x8, le8, lt8, max, max8, min, min8, mul_add, mul_add8, sign_bit, sign_bit8};
use crate::geom::{Aabb, Candidate, Ray};
use crate::kernels::{Id, Info, Intersect, Kernel, Operations};

prepared! {
    /// Boxes for the fused slab test.
    pub struct Fused<P: Lanes> {
        slabs: Slabs<P>,
    }
}

/// The per-ray data of the fused slab test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Offset<L: Lanes> {
    /// `1 / dir`.
    inv_dir: L::Vec3,
    /// `-(origin · inv_dir)`.
    offset: L::Vec3,
    /// Least `t` of the ray's interval, or of an empty one.
    t_min: L,
    /// Greatest `t` of the ray's interval, or of an empty one.
    t_max: L,
}

impl Kernel for Fused<f32> {
    type Shape = Aabb;
    type Packet = Fused<f32x8>;
    const INFO: Info = Info {
        id: Id::of("aabb/fused"),
        idea: "fma(plane, inverse direction, -origin · inverse direction): a warning",
        source: "Wald, Woop, Benthin, Johnson, Ernst, \"Embree\", 2014 (its fast traversal)",
        operations: Operations { mul: 6, add: 6, compare: 7, reads: 6, fused: 6, ..Operations::NONE },
        setup: InverseDirection::OPERATIONS.and(Operations { mul: 3, compare: 3, ..Operations::NONE }),
        claims: &[],
    };

    fn prepare(shape: &Aabb) -> Self {
        Self { slabs: Slabs::prepare(shape) }
    }

    prepared!(gather, lane);
}

impl Intersect<f32> for Fused<f32> {
    type Setup = Offset<f32>;

    #[inline(always)]
    fn setup(ray: &Ray<f32>) -> Self::Setup {
        let InverseDirection { inv_dir, t_min, t_max } = InverseDirection::<f32>::of(ray);
        // Compute -origin·inv_dir.
        let [x, y, z] = [0, 1, 2].map(|axis| -(ray.origin[axis] * inv_dir[axis]));

        // Make the interval empty if no slab can cut it.
        let usable = (x.abs() < f32::INFINITY) | (y.abs() < f32::INFINITY) | (z.abs() < f32::INFINITY);
        let t_max = if usable { t_max } else { f32::NAN };
        Offset { inv_dir, offset: Vec3::new(x, y, z), t_min, t_max }
    }

    #[inline(always)]
    fn candidate(&self, _: &Ray<f32>, setup: &Self::Setup) -> Candidate<f32> {
        let Self { slabs: Slabs { lo, hi } } = *self;

        // Start with the ray's interval.
        let (mut entry, mut exit) = (setup.t_min, setup.t_max);
        for axis in 0..3 {
            let (lo, hi, inv, offset) = (lo[axis], hi[axis], setup.inv_dir[axis], setup.offset[axis]);
            // Choose the near and the far plane by the sign bit.
            let (near, far) = if sign_bit(inv) { (hi, lo) } else { (lo, hi) };

            // Cut the interval at the distances to both planes. A NaN drops out.
            entry = max(mul_add(near, inv, offset), entry);
            exit = min(mul_add(far, inv, offset), exit);
        }

        // Test that the interval is not empty.
        Candidate::<f32>::select(entry <= exit, entry, exit, 0.0)
    }
}

impl<P: Lanes> Intersect<f32x8> for Fused<P> {
    type Setup = Offset<f32x8>;

    #[inline(always)]
    fn setup(ray: &Ray<f32x8>) -> Self::Setup {
        let InverseDirection { inv_dir, t_min, t_max } = InverseDirection::<f32x8>::of(ray);
        // Compute -origin·inv_dir.
        let offset =
            Vec3x8 { x: -(ray.origin.x * inv_dir.x), y: -(ray.origin.y * inv_dir.y), z: -(ray.origin.z * inv_dir.z) };

        // Make the interval empty if no slab can cut it.
        let finite = |x: f32x8| lt8(x.abs(), f32x8::splat(f32::INFINITY));
        let usable = finite(offset.x) | finite(offset.y) | finite(offset.z);
        let t_max = usable.select(t_max, f32x8::splat(f32::NAN));
        Offset { inv_dir, offset, t_min, t_max }
    }

    #[inline(always)]
    fn candidate(&self, _: &Ray<f32x8>, setup: &Self::Setup) -> Candidate<f32x8> {
        let Fused { slabs: Slabs { lo, hi } } = self.widen();

        // Start with the ray's interval.
        let (mut entry, mut exit) = (setup.t_min, setup.t_max);
        for (lo, hi, inv, offset) in [
            (lo.x, hi.x, setup.inv_dir.x, setup.offset.x),
            (lo.y, hi.y, setup.inv_dir.y, setup.offset.y),
            (lo.z, hi.z, setup.inv_dir.z, setup.offset.z),
        ] {
            // Choose the near and the far plane by the sign bit.
            let negative = sign_bit8(inv);
            let (near, far) = (negative.select(hi, lo), negative.select(lo, hi));

            // Cut the interval at the distances to both planes. A NaN drops out.
            entry = max8(mul_add8(near, inv, offset), entry);
            exit = min8(mul_add8(far, inv, offset), exit);
        }

        // Test that the interval is not empty.
        Candidate::<f32x8>::new(le8(entry, exit), entry, exit, f32x8::ZERO)
    }
}
