//! `quadric/mixed`: the polynomial in `f64`, its roots in `f32`.
//!
//! **Source:** as `quadric/stable`. Which operations need the digits is our own measurement.
//!
//! **Idea:** the coefficients and the discriminant are the sums that cancel. Products of `f32` numbers are exact in
//! `f64`, so these sums lose almost nothing there. The root and the quotients keep the digits they are given.
//! `quadric/f64` computes them and the cut by the box in `f64` too. It takes 1.6 times as long for eight rays (Zen
//! 4).
//!
//! **Differs from `quadric/stable`:** the polynomial stays about 0, because `f64` has digits to spare.
//!
//! **Edges:** `f64` decides whether a tangent ray hits. The box cuts in `f32`, within its error bounds.
//!
//! **Fails:** if the box is much wider than the surface in it, the origin stays where it is. Beyond 1e7 sizes the
//! discriminant is lost in `f64` too. From an origin very close to a large surface, `c` cancels to 2⁻⁵³ of its terms.
//! Numbers that become `f32` can underflow there: coefficients whose shares in the box are 1e38 apart and, in an
//! endless box, `a` if the other root is 1e19 sizes away. A direction so short that its inverse overflows (2.9e-39)
//! never enters a box from outside.
//!
//! **Degenerate input:** as `quadric/stable`.
//!
//! **Seen:** in every regime 99 of 100 hits are within 3 ulp, also 1e-4 above a sphere of radius 8192. The exception
//! is 22 ulp at 100 above that sphere. On ellipsoids of 100:1:1 along a diagonal they are within 2 ulp. Of 200,000
//! rays that pass spheres at 1 ± 1e-6 radii, from 100 and 10,000 radii away, none was wrong about hitting.
//!
//! **Operations:** 49 multiplications, 37 additions, 2 divisions, 1 square root, 27 minima, maxima and comparisons.
//! In `f64` are 33 of the multiplications and 26 of the additions. Setup: 5 divisions. 64 bytes prepared.

use glam::Vec3;
use wide::f32x8;

use super::{Approach, ClipInterval, Form, roots, roots8};
use crate::geom::lanes::{Lanes, dot_f64x8, double8, to_f32x8, to_f64x8};
use crate::geom::{Candidate, Quadric, Ray};
use crate::kernels::aabb::Slabs;
use crate::kernels::{Claim, DoubleOperations, Id, Info, Intersect, Kernel, Operations};

prepared! {
    /// Quadrics with the polynomial in `f64` and its solution in `f32`: the coefficients and the box.
    pub struct Mixed<P: Lanes> {
        form: Form<P>,
        clip: Slabs<P>,
    }
}

impl Kernel for Mixed<f32> {
    type Shape = Quadric;
    type Packet = Mixed<f32x8>;
    const INFO: Info = Info {
        id: Id::of("quadric/mixed"),
        idea: "coefficients and discriminant in f64, where they cancel; root and quotients in f32",
        source: "Haines, Günther, Akenine-Möller, \"Precision Improvements for Ray/Sphere Intersection\", 2019",
        operations: Operations {
            mul: 49,
            add: 37,
            compare: 27,
            div: 3,
            reads: 16,
            double: DoubleOperations { mul: 33, add: 26, ..DoubleOperations::NONE },
            ..Operations::NONE
        },
        setup: Approach::OPERATIONS,
        claims: &[Claim::NoGrossError],
    };

    fn prepare(shape: &Quadric) -> Self {
        Self { form: Form::about(shape, Vec3::ZERO), clip: shape.bounds().into() }
    }

    prepared!(gather, lane);
}

impl Intersect<f32> for Mixed<f32> {
    type Setup = Approach<f32>;

    #[inline(always)]
    fn setup(ray: &Ray<f32>) -> Approach<f32> {
        Approach::<f32>::of(ray)
    }

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32>, setup: &Approach<f32>) -> Candidate<f32> {
        let Self { form, clip } = self;

        // Find where the ray runs through the box.
        let interval = ClipInterval::<f32>::of(clip, ray.origin, &setup.slabs);

        // Move the origin to the box if it is outside. Go on in f64.
        let moved = interval.start(ray.origin, setup.to_closest);
        let d = setup.dir.as_dvec3();
        let p = ray.origin.as_dvec3() + d * f64::from(moved * setup.unit);

        // Evaluate the polynomial there.
        let g = form.half_gradient_f64(p);
        let a = form.curvature_f64(d);
        let b = d.dot(g);
        let c = p.dot(g + form.linear.as_dvec3()) + f64::from(form.constant);

        // Solve it in f32 and take the nearer root that counts.
        let [t0, t1] = roots((b * b - a * c) as f32, a as f32, b as f32, c as f32);
        interval.hit([moved + t0 * setup.inv_unit, moved + t1 * setup.inv_unit])
    }
}

impl<P: Lanes> Intersect<f32x8> for Mixed<P> {
    type Setup = Approach<f32x8>;

    #[inline(always)]
    fn setup(ray: &Ray<f32x8>) -> Approach<f32x8> {
        Approach::<f32x8>::of(ray)
    }

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32x8>, setup: &Approach<f32x8>) -> Candidate<f32x8> {
        let Mixed { form, clip } = self.widen();

        // Find where the ray runs through the box.
        let interval = ClipInterval::<f32x8>::of(&clip, ray.origin, &setup.slabs);

        // Move the origin to the box if it is outside. Go on in f64.
        let moved = interval.start(ray.origin, setup.to_closest);
        let (o, d) = (double8(ray.origin), double8(setup.dir));
        let step = to_f64x8(moved * setup.unit);
        let p = [0, 1, 2].map(|axis| o[axis] + d[axis] * step);

        // Evaluate the polynomial there.
        let g = form.half_gradient_f64(p);
        let a = form.curvature_f64(d);
        let b = dot_f64x8(d, g);
        let h = double8(form.linear);
        let c = dot_f64x8(p, [0, 1, 2].map(|axis| g[axis] + h[axis])) + to_f64x8(form.constant);

        // Solve it in f32 and take the nearer root that counts.
        let [t0, t1] = roots8(to_f32x8(b * b - a * c), to_f32x8(a), to_f32x8(b), to_f32x8(c));
        interval.hit([moved + t0 * setup.inv_unit, moved + t1 * setup.inv_unit])
    }
}
