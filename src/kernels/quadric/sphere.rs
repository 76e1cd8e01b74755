//! `quadric/sphere`: the test for spheres only. Other quadrics are left to `quadric/stable`.
//!
//! **Source:** E. Haines, J. Günther, T. Akenine-Möller, "Precision Improvements for Ray/Sphere Intersection", Ray
//! Tracing Gems, 2019, chapter 7.
//!
//! **Idea:** the discriminant is `|d|²·(r² - l²)`, where l is the distance of the centre from the line. It is computed
//! from the point closest to the centre, so its terms have the sphere's size, not its distance. The roots are `q/a` and
//! `c/q`, and `q` adds numbers of one sign.
//!
//! **Differs from the source:** a quadric is a sphere if its three squares are equal, its products are 0, and r² is a
//! normal `f32`. Centre and r² are computed from the coefficients in `f64` and rounded once. If a packet has a lane
//! with another quadric, `quadric/stable` tests all lanes too. The box is tested as for every quadric. Directions are
//! divided by a power of two.
//!
//! **Edges:** as `quadric/stable`.
//!
//! **Fails:** near the surface of a large sphere `c` cancels, as in `quadric/stable`. Spheres with a radius below 1e-19
//! or above 1.8e19 have no normal r², and are left to `quadric/stable`. From farther than 1e19 away `c` overflows, and
//! the ray misses. In packets with other quadrics, both tests are paid for.
//!
//! **Seen:** on spheres it has the errors of `quadric/stable`. Of 11,084 rays that hit within 1e-7 radii of the
//! silhouette it loses 404 (`quadric/stable`: 460), and it hits with 1724 of 8916 that miss (1686). From afar 99 of 100
//! hits are within 3 ulp (1). What it saves is a third of the operations.
//!
//! **Operations:** for a sphere 31 multiplications, 25 additions, 2 divisions, 1 square root, 24 minima, maxima and
//! comparisons. The box needs 10 of the multiplications and 6 of the additions. Setup: 5 divisions. 92 bytes prepared.

use glam::Vec3;
use wide::f32x8;

use super::{Approach, ClipInterval, Stable, roots, roots8};
use crate::geom::lanes::{Lanes, eq8};
use crate::geom::{Candidate, Quadric, Ray};
use crate::kernels::{Id, Info, Intersect, Kernel, Operations};

prepared! {
    /// Spheres, and what `quadric/stable` prepares.
    pub struct Sphere<P: Lanes> {
        center: P::Vec3,
        /// The square of the radius. NaN if the quadric is no sphere.
        radius2: P,
        stable: Stable<P>,
    }
}

impl Kernel for Sphere<f32> {
    type Shape = Quadric;
    type Packet = Sphere<f32x8>;
    const INFO: Info = Info {
        id: Id::of("quadric/sphere"),
        idea: "spheres by the distance of the centre from the ray, roots as q/a and c/q; others as quadric/stable",
        source: "Haines, Günther, Akenine-Möller, \"Precision Improvements for Ray/Sphere Intersection\", 2019",
        operations: Operations { mul: 31, add: 25, compare: 24, div: 3, reads: 10, ..Operations::NONE },
        setup: Approach::OPERATIONS,
        claims: &[],
    };

    fn prepare(shape: &Quadric) -> Self {
        let stable = Stable::prepare(shape);
        // Complete the squares.
        let (square, half) = (f64::from(shape.squares.x), shape.linear.as_dvec3() * 0.5);
        let center = half / -square;
        let radius2 = (center.length_squared() - f64::from(shape.constant) / square) as f32;
        // Also false where a number is NaN or infinite.
        let is_sphere = (shape.squares == Vec3::splat(shape.squares.x))
            & (shape.products == Vec3::ZERO)
            & radius2.is_normal()
            & center.as_vec3().is_finite();
        Self { center: center.as_vec3(), radius2: if is_sphere { radius2 } else { f32::NAN }, stable }
    }

    prepared!(gather, lane);
}

impl Intersect<f32> for Sphere<f32> {
    type Setup = Approach<f32>;

    #[inline(always)]
    fn setup(ray: &Ray<f32>) -> Approach<f32> {
        Approach::<f32>::of(ray)
    }

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32>, setup: &Approach<f32>) -> Candidate<f32> {
        let Self { center, radius2, stable } = self;
        // Leave other quadrics to the general test.
        if radius2.is_nan() {
            return Intersect::<f32>::candidate(stable, ray, setup);
        }

        // Find where the ray runs through the box.
        let interval = ClipInterval::<f32>::of(&stable.clip, ray.origin, &setup.slabs);

        // Find the point of the line that is closest to the centre.
        let from_center = ray.origin - center;
        let closest = from_center + ray.dir * from_center.dot(setup.to_closest);

        // Compute the discriminant from its distance.
        let (a, b) = (setup.dir.dot(setup.dir), setup.dir.dot(from_center));
        let c = from_center.dot(from_center) - radius2;
        let discriminant = a * (radius2 - closest.dot(closest));

        // Solve it and take the nearer root that counts.
        interval.hit(roots(discriminant, a, b, c).map(|t| t * setup.inv_unit))
    }
}

impl<P: Lanes> Intersect<f32x8> for Sphere<P> {
    type Setup = Approach<f32x8>;

    #[inline(always)]
    fn setup(ray: &Ray<f32x8>) -> Approach<f32x8> {
        Approach::<f32x8>::of(ray)
    }

    #[inline(always)]
    fn candidate(&self, ray: &Ray<f32x8>, setup: &Approach<f32x8>) -> Candidate<f32x8> {
        let Sphere { center, radius2, stable } = self.widen();

        // Find where the ray runs through the box.
        let interval = ClipInterval::<f32x8>::of(&stable.clip, ray.origin, &setup.slabs);

        // Find the point of the line that is closest to the centre.
        let from_center = ray.origin - center;
        let closest = from_center + ray.dir * from_center.dot(setup.to_closest);

        // Compute the discriminant from its distance.
        let (a, b) = (setup.dir.dot(setup.dir), setup.dir.dot(from_center));
        let c = from_center.dot(from_center) - radius2;
        let discriminant = a * (radius2 - closest.dot(closest));

        // Solve it and take the nearer root that counts.
        let hits = interval.hit(roots8(discriminant, a, b, c).map(|t| t * setup.inv_unit));

        // Leave other quadrics to the general test.
        let is_sphere = eq8(radius2, radius2);
        if is_sphere.all() {
            return hits;
        }
        let others = Intersect::<f32x8>::candidate(&stable, ray, setup);
        let mask = (is_sphere & hits.mask()) | (!is_sphere & others.mask());
        Candidate::<f32x8>::new(mask, is_sphere.select(hits.t(), others.t()), f32x8::ZERO, f32x8::ZERO)
    }
}
