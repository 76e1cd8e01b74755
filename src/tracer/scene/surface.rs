//! What there is to shade where a ray hits: point, normal, surface parameters and colour, in the world.
//!
//! All of it is computed in `f64` from the exact transform, not from its rounded inverse, and rounded once.

use std::f64::consts::TAU;

use glam::{DMat3, DVec2, DVec3, Vec2, Vec3};

use super::two_level::Scene;
use super::world::{Geometry, Paint};
use crate::geom::{Hit, Quadric, Ray, Triangle};
use crate::kernels::Kernel;

/// The surface where a ray hits it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Where in the world. Of a triangle, the point that the hit's barycentrics name; of a quadric, the ray's point at the
    /// hit's `t`.
    pub point: Vec3,
    /// The geometric normal in the world, of unit length. Of a triangle, to where its vertices in the world appear
    /// counter-clockwise, so that a mirror turns it over; of a quadric, to the outside, also of one that is mirrored. Zero
    /// where there is none, as at the apex of a cone.
    pub normal: Vec3,
    /// Of a triangle, the barycentrics of the hit. Of a quadric, the angle about its z axis in turns from 0, at `+x`, to 1,
    /// and the height between the clip planes across that axis, from 0 to 1.
    pub uv: Vec2,
    /// Linear red, green and blue from 0 to 1.
    pub color: Vec3,
}

impl<K: Kernel<Shape = Triangle>> Scene<K> {
    /// The surface at a hit that this scene reported for this ray.
    ///
    /// Each coordinate of the point lies within half an ulp, and 2⁻⁴⁷ of the largest term of its sum, of the exact image of
    /// what the hit says. The normal is turned from the exact one by at most 2⁻²⁴, and 2⁻⁵⁰ times the condition of the
    /// transform; that of a quadric also by what 2⁻⁵⁰ of the ray's way from its origin to the hit, or to the object, turns it.
    ///
    /// # Panics
    /// If the hit is a miss, or not of this scene.
    pub fn surface(&self, ray: &Ray<f32>, hit: &Hit<f32>) -> SurfacePoint {
        let placement = &self.world().instances()[hit.instance as usize];
        let (linear, translation) =
            (placement.object_to_world.matrix3.as_dmat3(), placement.object_to_world.translation.as_dvec3());
        let primitive = hit.primitive - self.first_primitive(hit.instance);
        let (point, normal, uv, own_color) = match &self.world().geometries()[placement.geometry as usize] {
            Geometry::Mesh(mesh) => {
                let [v0, v1, v2] = mesh.triangle(primitive).vertices().map(Vec3::as_dvec3);
                let (e1, e2) = (v1 - v0, v2 - v0);
                let point = linear * (v0 + e1 * f64::from(hit.u) + e2 * f64::from(hit.v)) + translation;
                let normal = (linear * e1).cross(linear * e2);
                (point, normal, Vec2::new(hit.u, hit.v), mesh.color(primitive))
            }
            Geometry::Quadric(quadric) => {
                let (origin, along) = (ray.origin.as_dvec3(), ray.dir.as_dvec3() * f64::from(hit.t));
                let point = origin + along;
                // The translation is taken off first, as for the ray: far from the world's origin that loses nothing.
                let in_object = linear.inverse() * ((origin - translation) + along);
                (
                    point,
                    cofactors(linear) * gradient(quadric, in_object),
                    turn_and_height(quadric, in_object),
                    Vec3::ONE,
                )
            }
        };
        let color = match &placement.paint {
            Paint::Own => own_color,
            Paint::Plain(color) => *color,
            Paint::Checker(checker) => checker.at(uv),
        };
        SurfacePoint { point: point.as_vec3(), normal: unit(normal), uv, color }
    }
}

/// The direction of the inverse transpose, which takes gradients to the world, without a division: the cofactors, with
/// the sign of the determinant.
fn cofactors(linear: DMat3) -> DMat3 {
    let DMat3 { x_axis: x, y_axis: y, z_axis: z } = linear;
    let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    if x.dot(cofactors.x_axis) < 0.0 { -cofactors } else { cofactors }
}

/// Of the polynomial, towards its outside.
fn gradient(quadric: &Quadric, point: DVec3) -> DVec3 {
    let (squares, linear) = (quadric.squares.as_dvec3(), quadric.linear.as_dvec3());
    let (DVec3 { x, y, z }, DVec3 { x: yz, y: zx, z: xy }) = (point, quadric.products.as_dvec3());
    squares * point * 2.0 + DVec3::new(xy * y + zx * z, xy * x + yz * z, zx * x + yz * y) + linear
}

fn turn_and_height(quadric: &Quadric, point: DVec3) -> Vec2 {
    let turn = DVec2::new(point.x, point.y).to_angle() / TAU;
    let (bottom, top) = (f64::from(quadric.clip.lo.z), f64::from(quadric.clip.hi.z));
    let height = if top > bottom { (point.z - bottom) / (top - bottom) } else { 0.0 };
    // The hit may lie outside of the clip planes by the padding of their box.
    Vec2::new((if turn < 0.0 { turn + 1.0 } else { turn }) as f32, height.clamp(0.0, 1.0) as f32)
}

/// The vector at unit length, whatever its own; zero stays zero.
fn unit(vector: DVec3) -> Vec3 {
    // Its largest component becomes 1, since the square of a length may be beyond the range of f64.
    (vector / vector.abs().max_element()).normalize_or_zero().as_vec3()
}
