//! Where a ray starts that leaves the surface at a hit.

use glam::{Affine3, DVec3, Vec3};

use super::surface::{gradient, value};
use super::two_level::Scene;
use super::world::Geometry;
use crate::geom::{Hit, Ray, Triangle};
use crate::kernels::Kernel;

/// Bound on the error of a kernel's test of the surface that a ray leaves, in units of 2⁻²⁴ of the terms of its sums:
/// subtracting the origin, transforming it, and the products with the normal.
const ERROR: f64 = 24.0 / (1_u64 << 24) as f64;

/// The least distance from the surface, relative to its size and place, also where the error bound is zero.
const LEAST: f64 = 1.0 / (1_u64 << 50) as f64;

/// The start of rays that leave a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Start {
    /// A point on the side that the first ray came from. It is as near to the surface as rounding allows.
    pub(crate) point: Vec3,
    /// Normal on that side.
    pub(crate) normal: Vec3,
}

impl<K: Kernel<Shape = Triangle>> Scene<K> {
    /// Where a ray starts that leaves the surface at a hit, on the side that the hit's ray came from.
    ///
    /// The distance of the rounded point from the triangle's plane, or from the quadric, is more than the error that an
    /// intersection can make there. So `t_min` of the new ray can be 0, whatever the scale of the scene and its
    /// distance from the origin.
    pub(crate) fn start(&self, ray: &Ray<f32>, hit: &Hit<f32>) -> Start {
        let placement = &self.world().instances()[hit.instance as usize];
        let transform = &placement.object_to_world;
        let (linear, translation) = (transform.matrix3.as_dmat3(), transform.translation.as_dvec3());
        let to_object = linear.inverse();
        let mut normal = self.exact_surface(ray, hit).normal;
        if normal.dot(ray.dir.as_dvec3()) > 0.0 {
            normal = -normal;
        }
        let geometry = &self.world().geometries()[placement.geometry as usize];
        // What the surface is made of: vertices, or the place of the quadric.
        let anchors = match geometry {
            Geometry::Mesh(mesh) => {
                let vertices = mesh.triangle(self.primitive_of_mesh(hit)).vertices();
                vertices.map(|vertex| linear * vertex.as_dvec3() + translation)
            }
            Geometry::Quadric(_) => [translation; 3],
        };
        // How far a point is above the surface on the seen side. Rounding also moves a point along the surface, so on a
        // curved one the tangent plane does not tell.
        let height = |point: DVec3| match geometry {
            Geometry::Mesh(_) => (point - anchors[0]).dot(normal),
            Geometry::Quadric(quadric) => {
                let in_object = to_object * (point - translation);
                value(quadric, in_object) / (to_object.transpose() * gradient(quadric, in_object)).dot(normal)
            }
        };
        // Both `t` and the barycentrics are rounded. In a large triangle `t` is more precise. A step along the normal
        // brings the point to the surface.
        let mut point = ray.origin.as_dvec3() + ray.dir.as_dvec3() * f64::from(hit.t);
        let step = height(point);
        if step.is_finite() {
            point -= normal * step;
        }
        let parts = anchors.map(|anchor| anchor - point);
        // The products with the normal that an intersection sums up.
        let terms = |vector: DVec3| normal.abs().dot(vector.abs());
        let mut error = parts.into_iter().map(terms).fold(0.0, f64::max);
        if *transform != Affine3::IDENTITY {
            // The origin is multiplied by the rounded inverse. This is what the error amounts to in the world.
            let place = (point - translation).abs();
            let in_object = to_object.abs() * place;
            error += (linear.transpose() * normal).abs().dot(in_object);
        }
        let needed = error * ERROR;
        let size = parts.into_iter().map(|part| part.abs().max_element()).fold(point.abs().max_element(), f64::max);
        let mut offset = needed.max(size * LEAST);
        loop {
            let start = (point + normal * offset).as_vec3();
            // A surface without a normal, or with one beyond the range of numbers: nothing is better.
            if height(start.as_dvec3()) > needed || offset >= size || !offset.is_finite() {
                return Start { point: start, normal: normal.as_vec3() };
            }
            offset *= 2.0;
        }
    }
}
