//! Rays that leave a surface: where they start, so that they never hit again what they leave.
//!
//! **Idea:** the surface is known exactly, from its vertices or coefficients and its transform. So is the point where
//! the hit lies on it, up to the rounding of `f64`. A start is a point of `f32` numbers above that point or below it,
//! whose exact height is more than the error that an intersection of the new ray with the surface can make. There is
//! such a start on either side, and the direction of the new ray chooses one. Its `t_min` is 0, whatever the scale of
//! the scene and its distance from the origin.
//!
//! **Bound:** for a triangle that is not transformed, a kernel subtracts the origin from the vertices, which changes
//! each difference by 2⁻²⁴ of itself, and adds products with the normal. [`ERROR`] times these products bounds the
//! rounding, for kernels that multiply with the normal. A kernel that claims
//! [no hit behind](crate::kernels::Claim::NoHitBehind) decides correctly for any height. In an instance the ray is
//! transformed first. Its origin is then off by a few roundings of `L⁻¹(origin - T)`, and its direction by a few
//! roundings of `L⁻¹·dir`. Both amount to the same products as `L⁻¹`, taken without signs, times the distances from the
//! instance's position and across the triangle. Then the normal weighs them.
//!
//! **Not covered:** kernels without that claim lose the digits of `t` on slivers, whose normal is much shorter than the
//! product of their edges, and `triangle/baldwin_weber` loses them everywhere. `tests/hits/spawn.expected` counts, for
//! every kernel, rays that hit what they leave and rays that miss what they should hit.
//!
//! **Source:** C. Wächter, N. Binder, "A Fast and Robust Method for Avoiding Self-Intersection", 2019, moves the start
//! along the normal too, by a constant number of ulp. M. Pharr, W. Jakob, G. Humphreys, "Physically Based Rendering",
//! chapter on rounding error, moves it by an error bound of the point, which is computed in `f32`.

use glam::{Affine3, DMat3, DVec3, Vec3};

use super::surface::{ExactSurface, SurfacePoint, gradient, value};
use crate::geom::{Quadric, Ray, Triangle};

/// Bound on the rounding errors of a kernel's test, and of the transform of a ray, relative to the terms of their sums.
const ERROR: f64 = 24.0 * HALF_ULP;

/// The largest relative error of rounding to `f32`.
const HALF_ULP: f64 = 1.0 / (1_u64 << 24) as f64;

/// The least distance from the surface, relative to its size and place, also where the error bound is zero.
const LEAST: f64 = 1.0 / (1_u64 << 50) as f64;

impl SurfacePoint {
    /// The ray that leaves the surface in this direction, without end. It starts on the side to which `dir` points.
    ///
    /// With a kernel that claims [no hit behind](crate::kernels::Claim::NoHitBehind), the ray does not hit the triangle
    /// that it leaves. Others may hit slivers again. The start is off the surface by little more than rounding errors:
    /// those of its own coordinates, and of the test and the transform that the ray must pass. A quadric may be hit
    /// elsewhere, as by a ray inside a sphere. If `dir` is exactly along the surface, or the surface has no normal, the
    /// ray starts on the side from which the surface was hit.
    #[inline]
    pub fn spawn(&self, dir: Vec3) -> Ray<f32> {
        Ray::new(self.start(dir.as_dvec3().dot(self.footing.normal)), dir)
    }

    /// The ray that leaves the surface and ends at `target`, where `t` is 1: for light sources. It starts like that of
    /// [`SurfacePoint::spawn`]. It may hit the surface at its end if the target is no farther from it than the start.
    #[inline]
    pub fn spawn_to(&self, target: Vec3) -> Ray<f32> {
        let Footing { point, normal, .. } = self.footing;
        let start = self.start((target.as_dvec3() - point).dot(normal));
        Ray { t_max: 1.0, ..Ray::new(start, target - start) }
    }

    /// The start on the front side if `height` is positive.
    #[inline]
    fn start(&self, height: f64) -> Vec3 {
        let front = if height == 0.0 || height.is_nan() { self.front } else { height > 0.0 };
        self.footing.start(if front { 1.0 } else { -1.0 })
    }
}

/// Where rays leave a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Footing {
    /// The hit on the surface, before rounding.
    point: DVec3,
    /// The unit normal before rounding.
    normal: DVec3,
    /// The height above the surface that a start must exceed.
    needed: f64,
    /// How the surface bends: coefficients of x², y², z² and of yz, zx, xy, from `point` on, in the height of a point.
    bend: [DVec3; 2],
    /// Size of the surface and of its coordinates. No start is farther away.
    size: f64,
}

impl Footing {
    /// That of the hit at `t` of this ray.
    pub(super) fn of(
        surface: &ExactSurface,
        ray: &Ray<f32>,
        t: f32,
        shape: &Leaving,
        object_to_world: &Affine3,
    ) -> Self {
        let (linear, translation) = (object_to_world.matrix3.as_dmat3(), object_to_world.translation.as_dvec3());
        let untransformed = *object_to_world == Affine3::IDENTITY;
        let to_object = if untransformed { DMat3::IDENTITY } else { linear.inverse() };
        let normal = surface.normal;
        // What the surface is made of: vertices, or the place of the quadric.
        let anchors = match shape {
            Leaving::Triangle(triangle) => triangle.vertices().map(|vertex| linear * vertex.as_dvec3() + translation),
            Leaving::Quadric(_) => [translation; 3],
        };
        // Both `t` and the barycentrics are rounded. In a large triangle `t` is more precise. A step along the normal
        // brings the point to the surface.
        let mut point = ray.origin.as_dvec3() + ray.dir.as_dvec3() * f64::from(t);
        let (height, bend) = match shape {
            Leaving::Triangle(_) => ((point - anchors[0]).dot(normal), [DVec3::ZERO; 2]),
            Leaving::Quadric(quadric) => {
                let in_object = to_object * (point - translation);
                let slope = (to_object.transpose() * gradient(quadric, in_object)).dot(normal);
                let DMat3 { x_axis: x, y_axis: y, z_axis: z } =
                    to_object.transpose() * quadric.matrix() * to_object * slope.recip();
                let bend = [DVec3::new(x.x, y.y, z.z), DVec3::new(y.z, z.x, x.y) * 2.0];
                (value(quadric, in_object) / slope, bend)
            }
        };
        if height.is_finite() {
            point -= normal * height;
        }
        let parts = anchors.map(|anchor| anchor - point);
        let across = parts.into_iter().fold(DVec3::ZERO, |across, part| across.max(part.abs()));
        // The products with the normal that an intersection sums up.
        let mut error = normal.abs().dot(across);
        if !untransformed {
            let from = (point - translation).abs() + across;
            error += (linear.transpose() * normal).abs().dot(to_object.abs() * from);
        }
        let size = across.max_element().max(point.abs().max_element());
        Self { point, normal, needed: error * ERROR, bend, size }
    }

    /// The start of a ray, on the side of the normal (1) or on the other side (-1).
    #[inline]
    fn start(&self, side: f64) -> Vec3 {
        let &Self { point, normal, needed, bend: [squares, products], size } = self;
        // How much lower a start can become when its coordinates are rounded.
        let rounding = normal.abs().dot(point.abs()) * HALF_ULP;
        let mut offset = needed.max(size * LEAST);
        loop {
            let start = (point + normal * (side * offset)).as_vec3();
            // Rounding also moves a point along the surface, which may bend there.
            let moved = start.as_dvec3() - point;
            let DVec3 { x, y, z } = moved;
            let bent = squares.dot(moved * moved) + products.dot(DVec3::new(y * z, z * x, x * y));
            // A surface without a normal, or with one beyond the range of numbers: nothing is better.
            if side * (moved.dot(normal) + bent) > needed || offset >= size || !offset.is_finite() {
                return start;
            }
            offset = (offset * 2.0).max(needed + rounding);
        }
    }
}

/// The surface that rays leave, in its own coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Leaving {
    /// All of a triangle.
    Triangle(Triangle),
    /// The part of a quadric in its clip box.
    Quadric(Quadric),
}
