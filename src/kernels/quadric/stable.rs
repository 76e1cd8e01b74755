//! `quadric/stable`: the roots that keep their digits in `f32`.
//!
//! **Source:** E. Haines, J. Günther, T. Akenine-Möller, "Precision Improvements for Ray/Sphere Intersection", Ray Tracing
//! Gems, 2019, chapter 7. The roots: W. Kahan, after D. Goldberg, "What Every Computer Scientist Should Know About
//! Floating-Point Arithmetic", 1991.
//!
//! **Idea:** the ray's origin is first moved along the ray to where it comes closest to the middle of things, and the
//! polynomial is evaluated there, with terms of the surface's size and not of its distance. `q = -(b + sgn(b)·√D)` adds what
//! has one sign; `q/a` and `c/q` are the roots. Wherever the move goes to, the roots belong to that point: that
//! it was rounded does not matter.
//!
//! **Differs from the source:** it is not for spheres alone. The point is the middle of the box, or rather 0 where the
//! box contains it, since that is where the named kinds have their centre or apex; the polynomial is prepared about it
//! in `f64`. Of a long thin surface the ray may come closest far outside, so the move ends at the box. Directions are
//! divided by a power of two, and so are coefficients: neither short nor long directions, unless they are subnormal,
//! nor a factor that all coefficients share, nor a surface's size bring a product near the end of the range.
//!
//! **Edges:** the surface belongs to its box, but for rounding. At a tangent ray, whether the discriminant is negative
//! is up to rounding, and its root, which `t` has a share of, is wrong by the root of an ulp. From 1e5 radii a sphere's
//! silhouette is known to a hundredth of its radius, as is `origin + t·dir`.
//!
//! **Fails:** near a surface that is much larger than the distance to it, `c` cancels, and so does `t`, which is the
//! sum of the move and a root: a ten-thousandth above a sphere of radius 8192, no digit is right. An ellipsoid that is
//! long, thin and not along an axis loses the square of its aspect. A ray that nearly runs within the surface, as along
//! a ruling, is moved to a point that is rounded: off the ray by more than the ray is off the surface. Coefficients
//! whose shares within the box are 1e38 apart lose the lesser, and where the box is endless, `a` underflows if the
//! other root is 1e19 sizes away. A ray whose direction is subnormal may be moved by infinity, and then misses.
//!
//! **Degenerate input:** where `a` is exactly zero, `c/q` is the root of the linear equation. Where `b` is zero too, both are
//! infinite or NaN: a miss. A discriminant that overflows is one too.
//!
//! **Seen:** 99 of 100 hits within 2 ulp for unit spheres from 10 to 1e5 radii and within 1 ulp for a paraboloid along its
//! axis, also 1e-7 rad off it; of 100,000 rays at a sphere 1000 radii away 1 was wrong about hitting, where
//! `quadric/naive` has 4615.
//!
//! **Operations:** 48 multiplications, 40 additions, 2 divisions, 1 square root, 25 minima, maxima and comparisons, of
//! which 10 and 6 are the box's; setup 5 divisions. 76 bytes prepared.

use wide::f32x8;

use super::{Approach, ClipInterval, Form, center, roots, roots8};
use crate::geom::lanes::Lanes;
use crate::geom::{Hit, Quadric, Ray};
use crate::kernels::aabb::Slabs;
use crate::kernels::{Id, Info, Intersect, Kernel, Operations};

prepared! {
    /// Quadrics for the roots that keep their digits: the polynomial about a point near the surface, that point, and the box.
    pub struct Stable<P: Lanes> {
        form: Form<P>,
        center: P::Vec3,
        clip: Slabs<P>,
    }
}

impl Kernel for Stable<f32> {
    type Shape = Quadric;
    type Packet = Stable<f32x8>;
    const INFO: Info = Info {
        id: Id::of("quadric/stable"),
        idea: "origin moved to the closest approach, roots as q/a and c/q: terms no larger than the surface",
        source: "Haines, Günther, Akenine-Möller, \"Precision Improvements for Ray/Sphere Intersection\", 2019",
        operations: Operations { mul: 48, add: 40, compare: 25, div: 3, reads: 19, ..Operations::NONE },
        setup: Approach::OPERATIONS,
        claims: &[],
    };

    fn prepare(shape: &Quadric) -> Self {
        let center = center(&shape.clip);
        Self { form: Form::about(shape, center), center, clip: shape.bounds().into() }
    }

    prepared!(gather, lane);
}

impl Intersect<f32> for Stable<f32> {
    type Setup = Approach<f32>;

    #[inline(always)]
    fn setup(ray: &Ray<f32>) -> Approach<f32> {
        Approach::<f32>::of(ray)
    }

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32>, setup: &Approach<f32>) -> Hit<f32> {
        let Self { form, center, clip } = self;

        // Find where the ray runs through the box.
        let interval = ClipInterval::<f32>::of(clip, ray.origin, &setup.slabs);

        // Move the origin to the closest approach, but not out of the box.
        let from_center = ray.origin - center;
        let moved = interval.clamp(from_center.dot(setup.to_closest));
        let p = from_center + ray.dir * moved;

        // Evaluate the polynomial there.
        let g = form.half_gradient(p);
        let a = form.curvature(setup.dir);
        let b = setup.dir.dot(g);
        let c = p.dot(g + form.linear) + form.constant;

        // Solve it and take the nearer root that counts.
        let [t0, t1] = roots(b * b - a * c, a, b, c);
        interval.hit([moved + t0 * setup.inv_unit, moved + t1 * setup.inv_unit])
    }
}

impl<P: Lanes> Intersect<f32x8> for Stable<P> {
    type Setup = Approach<f32x8>;

    #[inline(always)]
    fn setup(ray: &Ray<f32x8>) -> Approach<f32x8> {
        Approach::<f32x8>::of(ray)
    }

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32x8>, setup: &Approach<f32x8>) -> Hit<f32x8> {
        let Stable { form, center, clip } = self.widen();

        // Find where the ray runs through the box.
        let interval = ClipInterval::<f32x8>::of(&clip, ray.origin, &setup.slabs);

        // Move the origin to the closest approach, but not out of the box.
        let from_center = ray.origin - center;
        let moved = interval.clamp(from_center.dot(setup.to_closest));
        let p = from_center + ray.dir * moved;

        // Evaluate the polynomial there.
        let g = form.half_gradient(p);
        let a = form.curvature(setup.dir);
        let b = setup.dir.dot(g);
        let c = p.dot(g + form.linear) + form.constant;

        // Solve it and take the nearer root that counts.
        let [t0, t1] = roots8(b * b - a * c, a, b, c);
        interval.hit([moved + t0 * setup.inv_unit, moved + t1 * setup.inv_unit])
    }
}
