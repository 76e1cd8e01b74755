//! `triangle/moller_trumbore_epsilon`: Möller–Trumbore as most people copy it, with an absolute epsilon. A warning.
//!
//! **Source:** T. Möller, B. Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997. Its listing defines
//! `EPSILON` as 0.000001 and rejects a ray if the determinant is between `-EPSILON` and `EPSILON`. Public code
//! repeats these lines, with 1e-6 to 1e-8.
//!
//! **Idea:** a small determinant shall mean that the ray is parallel to the triangle.
//!
//! **Differs from `triangle/moller_trumbore`** only in the epsilon. It is the form of the paper that does not cull:
//! both sides hit.
//!
//! **Fails:** the determinant is the length of the direction times the triangle's doubled area times the cosine at the
//! normal. It is small if the ray is parallel, but also if the triangle is small or the direction is short. A direction
//! of length 1 hits a right triangle with legs of 0.001 only if it is almost perpendicular. In metres that is a
//! millimetre. The epsilon saves nothing: a division by zero already is a miss. Leaks and slivers are as with
//! `triangle/moller_trumbore`.
//!
//! **Degenerate input:** as `triangle/moller_trumbore`.
//!
//! **Operations:** those of `triangle/moller_trumbore`, and 1 comparison. 36 bytes prepared.

use wide::f32x8;

use super::MollerTrumbore;
use crate::geom::lanes::{Lanes, ge8};
use crate::geom::{Candidate, Ray, Triangle};
use crate::kernels::{Id, Info, Intersect, Kernel, Operations};

/// Smaller determinants are taken for parallel rays.
const EPSILON: f32 = 1e-6;

prepared! {
    /// Triangles for the Möller–Trumbore test with an absolute epsilon.
    pub struct MollerTrumboreEpsilon<P: Lanes> {
        inner: MollerTrumbore<P>,
    }
}

impl Kernel for MollerTrumboreEpsilon<f32> {
    type Shape = Triangle;
    type Packet = MollerTrumboreEpsilon<f32x8>;
    const INFO: Info = Info {
        id: Id::of("triangle/moller_trumbore_epsilon"),
        idea: "a warning: Möller–Trumbore that rejects absolute determinants below 1e-6",
        operations: MollerTrumbore::INFO.operations.and(Operations { compare: 1, ..Operations::NONE }),
        ..MollerTrumbore::INFO
    };

    fn prepare(shape: &Triangle) -> Self {
        Self { inner: MollerTrumbore::prepare(shape) }
    }

    prepared!(gather, lane);
}

impl Intersect<f32> for MollerTrumboreEpsilon<f32> {
    type Setup = ();

    #[inline(always)]
    fn setup(_: &Ray<f32>) {}

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32>, (): &()) -> Candidate<f32> {
        let Self { inner } = self;

        // Reject a small determinant. The test is true for a hit, so a NaN is a miss.
        let det = inner.e1.dot(ray.dir.cross(inner.e2));
        let steep = det.abs() >= EPSILON;
        if !steep {
            return Candidate::MISS;
        }

        // Test as usual. The compiler does not compute the determinant again.
        Intersect::<f32>::candidate(inner, ray, &())
    }
}

impl<P: Lanes> Intersect<f32x8> for MollerTrumboreEpsilon<P> {
    type Setup = ();

    #[inline(always)]
    fn setup(_: &Ray<f32x8>) {}

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32x8>, (): &()) -> Candidate<f32x8> {
        let MollerTrumboreEpsilon { inner } = self.widen();

        // Reject a small determinant. The test is true for a hit, so a NaN is a miss.
        let det = inner.e1.dot(ray.dir.cross(inner.e2));
        let steep = ge8(det.abs(), f32x8::splat(EPSILON));

        // Test as usual. The compiler does not compute the determinant again.
        let hit = inner.candidate(ray, &());
        hit.narrowed(steep, hit.t())
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn a_determinant_of_the_epsilon_is_not_rejected() {
        let kernel = MollerTrumboreEpsilon::prepare(&Triangle { v0: Vec3::ZERO, v1: Vec3::X, v2: Vec3::Y });
        for (size, hits) in [(EPSILON, true), (EPSILON.next_down(), false)] {
            for det in [size, -size] {
                let ray = Ray::new(Vec3::new(0.25, 0.25, det), Vec3::new(0.0, 0.0, -det));
                assert_eq!(Intersect::<f32>::hit(&kernel, &ray).mask, hits, "{det:e}");
                let bits = Intersect::<f32x8>::hit(&kernel, &Ray::splat(&ray)).mask.bits();
                assert_eq!(bits, if hits { 0xff } else { 0 }, "{det:e}");
            }
        }
    }
}
