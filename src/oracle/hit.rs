//! Point and normal of an exact hit: what the errors of points and normals are measured from.
//!
//! `t` is a quotient `num / den` of exact numbers, so a coordinate of the point is `(origin·den + num·dir) / den`. It
//! is rounded once, to `f64`. Its error is at most 2⁻⁵³ of the coordinate, while rounding a point to `f32` may change
//! each coordinate by 2⁻²⁴ of it. So the reference is 2²⁹ times as exact as any point in `f32` that has to be rounded,
//! however hard the input. The root of a quadric is cut off after 150 binary digits of `t` at least.

use core::cmp::Ordering;

use glam::DVec3;

use crate::geom::Ray;

use super::exact::Dyadic;
use super::number::Number;

/// Where a ray exactly hits a shape. Each number is rounded once, to `f64`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExactHit {
    /// Ray parameter.
    pub t: f64,
    /// The point in the world.
    pub point: DVec3,
    /// The unit normal in the world. Its side is that of [`Triangle::normal`](crate::geom::Triangle::normal), from the
    /// vertices in the world, or of [`Quadric::normal`](crate::geom::Quadric::normal). Zero for a box, and where there
    /// is none, as at the apex of a cone.
    pub normal: DVec3,
}

impl ExactHit {
    /// The hit at `t = num / den`. `normal` makes the normal, of any length, from `num` and `den`. The divisor is then
    /// positive; as an argument it may also be negative.
    pub(super) fn at(
        ray: &Ray<f32>,
        [num, den]: [Dyadic; 2],
        normal: impl FnOnce(&Dyadic, &Dyadic) -> [Dyadic; 3],
    ) -> Self {
        let negative = den.sign() == Some(Ordering::Less);
        let [num, den] = if negative { [num.negated(), den.negated()] } else { [num, den] };
        let [origin, dir] = [ray.origin, ray.dir].map(|vector| vector.to_array().map(Dyadic::new));
        let point = [0, 1, 2].map(|axis| origin[axis].times(&den).plus(&num.times(&dir[axis])).over(&den));
        let one = Dyadic::new(1.0);
        let normal = DVec3::from(normal(&num, &den).map(|component| component.over(&one)));
        // First scale the largest component to 1: the square of the length may be beyond the range of `f64`.
        let normal = (normal / normal.abs().max_element()).normalize_or_zero();
        Self { t: num.over(&den), point: point.into(), normal }
    }
}

#[cfg(test)]
mod tests {
    use glam::{Affine3, DVec3, Mat3, Vec3};
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;
    use crate::geom::{Aabb, Placed, Quadric, Triangle};
    use crate::oracle::Exact;
    use crate::oracle::number::{cross, dot, minus};

    fn hit<S: Exact>(shape: &S, ray: &Ray<f32>) -> ExactHit {
        let truth = shape.truth(ray);
        assert!(truth.hit, "{ray:?}");
        shape.exact_hit(ray, &truth)
    }

    #[test]
    fn a_hit_at_a_third_is_rounded_once() {
        let third = 1.0 / 3.0;
        let triangle = Triangle { v0: Vec3::ZERO, v1: Vec3::X, v2: Vec3::Y };
        let ray = Ray::new(Vec3::new(0.25, 0.5, 1.0), Vec3::new(0.25, -0.5, -3.0));
        let expected = ExactHit { t: third, point: DVec3::new(third, third, 0.0), normal: DVec3::Z };
        assert_eq!(hit(&triangle, &ray), expected);
        let turned = Triangle { v1: Vec3::Y, v2: Vec3::X, ..triangle };
        assert_eq!(hit(&turned, &ray), ExactHit { normal: -DVec3::Z, ..expected });
        // Exchanging two axes turns the normal in the world.
        let object_to_world = Affine3::from_mat3(Mat3::from_cols(Vec3::Y, Vec3::X, Vec3::Z));
        let placed = Placed { shape: triangle, object_to_world };
        assert_eq!(hit(&placed, &ray), ExactHit { normal: -DVec3::Z, ..expected });
        let shape = Aabb { lo: -Vec3::ONE, hi: Vec3::new(1.0, 1.0, 0.0) };
        assert_eq!(hit(&shape, &ray), ExactHit { normal: DVec3::ZERO, ..expected });
    }

    #[test]
    fn a_quadric_is_hit_at_its_root() {
        // t² = 2 - 1.
        let sphere = Quadric { constant: -2.0, ..Quadric::sphere(1.5) };
        let ray = Ray::new(Vec3::new(1.0, 0.0, 3.0), -Vec3::Z);
        let normal = DVec3::new(1.0, 0.0, 1.0).normalize();
        assert_eq!(hit(&sphere, &ray), ExactHit { t: 2.0, point: DVec3::new(1.0, 0.0, 1.0), normal });
        // √2, from inside. The normal points outwards.
        let inside = Ray::new(Vec3::ZERO, Vec3::Z);
        let root = ExactHit { t: 2f64.sqrt(), point: DVec3::Z * 2f64.sqrt(), normal: DVec3::Z };
        assert_eq!(hit(&sphere, &inside), root);
        // A mirroring and scaling transform: an ellipsoid that is half as high.
        let object_to_world = Affine3::from_mat3(Mat3::from_diagonal(Vec3::new(-1.0, 1.0, 0.5)));
        let placed = hit(&Placed { shape: sphere, object_to_world }, &ray);
        let normal = DVec3::new(1.0, 0.0, 2.0).normalize();
        assert_eq!((placed.t, placed.point), (2.5, DVec3::new(1.0, 0.0, 0.5)));
        assert!((placed.normal - normal).length() < 1e-15, "{placed:?}");
    }

    #[test]
    fn a_normal_whose_square_is_beyond_f64_is_normalised() {
        const M: f32 = f32::MAX;
        let shape = Triangle { v0: Vec3::new(-M, -M, 0.0), v1: Vec3::new(M, -M, 0.0), v2: Vec3::new(-M, M, 0.0) };
        let placed = Placed { shape, object_to_world: Affine3::from_scale(Vec3::splat(M)) };
        assert_eq!(hit(&placed, &Ray::new(Vec3::new(-1.0, -1.0, 1.0), Vec3::NEG_Z)).normal, DVec3::Z);
    }

    /// The exact sum of the `f32` numbers that a number of 53 bits is made of.
    fn exact(value: f64) -> Dyadic {
        let (high, middle) = (value as f32, (value - f64::from(value as f32)) as f32);
        let low = (value - f64::from(high) - f64::from(middle)) as f32;
        assert_eq!(f64::from(high) + f64::from(middle) + f64::from(low), value);
        Dyadic::new(high).plus(&Dyadic::new(middle)).plus(&Dyadic::new(low))
    }

    /// Triangles of about unit size, and rays at them: at an angle of 1e-6, at a sliver of 1e6, from 1e5 away, and 1e6
    /// from the origin.
    fn hard_inputs(rng: &mut Pcg64) -> [(Triangle, Ray<f32>); 4] {
        let mut vector = || Vec3::from([0; 3].map(|_| rng.random_range(-1.0..1.0)));
        let [v0, e1, e2, far] = [vector(), vector(), vector(), vector() * 1e6];
        let wide = Triangle { v0, v1: v0 + e1, v2: v0 + e2 };
        let sliver = Triangle { v2: v0 + e1 * 0.25 + e2 * 1e-6, ..wide };
        let moved = Triangle { v0: wide.v0 + far, v1: wide.v1 + far, v2: wide.v2 + far };
        let normal = wide.normal();
        let ray = |shape: &Triangle, away: Vec3| Ray::new(shape.point(0.3, 0.4) + away, -away);
        [
            (wide, ray(&wide, e1 + normal * 1e-6)),
            (sliver, ray(&sliver, e1 + normal)),
            (wide, ray(&wide, (e1 + normal) * 1e5)),
            (moved, ray(&moved, e1 + normal)),
        ]
    }

    #[test]
    fn the_error_of_the_point_is_one_rounding_on_hard_inputs() {
        let mut rng = Pcg64::seed_from_u64(1);
        let mut checked = [0; 4];
        for _ in 0..1_000 {
            for ((triangle, ray), checked) in hard_inputs(&mut rng).into_iter().zip(&mut checked) {
                let truth = triangle.truth(&ray);
                if !truth.hit {
                    continue;
                }
                *checked += 1;
                let ExactHit { t, point, normal } = triangle.exact_hit(&ray, &truth);
                assert_eq!(t as f32, truth.t);
                let [p, n] = [point, normal].map(|vector| vector.to_array().map(exact));
                let [o, d, v0] = [ray.origin, ray.dir, triangle.v0].map(|vector| vector.to_array().map(Dyadic::new));
                let one = Dyadic::new(1.0);
                // On the plane, up to the rounding of the point, and of the normal over the distance to a vertex.
                let height = dot(&n, &minus(&p, &v0)).over(&one);
                let reach = (point - triangle.v0.as_dvec3()).abs();
                let rounding = f64::EPSILON / 2.0;
                assert!(height.abs() <= normal.abs().dot(point.abs() + 4.0 * reach) * rounding, "{ray:?} {height:e}");
                // On the ray.
                let offside = DVec3::from(cross(&d, &minus(&p, &o)).map(|component| component.over(&one))).abs();
                let (p, d) = (point.abs(), ray.dir.as_dvec3().abs());
                let allowed = DVec3::new(d.y * p.z + d.z * p.y, d.z * p.x + d.x * p.z, d.x * p.y + d.y * p.x);
                assert!(offside.cmple(allowed * rounding).all(), "{ray:?} {offside}");
            }
        }
        assert!(checked.iter().all(|&checked| checked > 300), "{checked:?}");
    }
}
