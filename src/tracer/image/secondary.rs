//! Rays that start where a picture's rays hit: towards the light, and into the hemisphere above the surface.

use glam::Vec3;
use rayon::prelude::*;

use super::view::Light;
use crate::geom::{Hit, Ray, Triangle};
use crate::kernels::Kernel;
use crate::tracer::meshes::generator::{hash, unit_interval};
use crate::tracer::scene::{Scene, SurfacePoint};

/// The surface at each hit; `None` for a miss.
pub(crate) fn surfaces<K: Kernel<Shape = Triangle>>(
    scene: &Scene<K>,
    rays: &[Ray<f32>],
    hits: &[Hit<f32>],
) -> Vec<Option<SurfacePoint>> {
    rays.par_iter().zip(hits).map(|(ray, hit)| hit.mask.then(|| scene.surface(ray, hit))).collect()
}

/// One ray from each surface to the light. A point light is at `t = 1`. `size` is the length of rays to a light at
/// infinity. If there is no surface, or if the light is behind it, the ray is inactive.
pub(crate) fn shadow_rays(surfaces: &[Option<SurfacePoint>], light: Light, size: f32) -> Vec<Ray<f32>> {
    let towards_light = |surface: &SurfacePoint| {
        let ray = match light {
            Light::Point(position) => surface.spawn_to(position),
            Light::Directional(to_light) => surface.spawn(direction(to_light) * size),
        };
        let is_lit = ray.dir.dot(surface.normal) > 0.0;
        if is_lit == surface.front { ray } else { Ray::INACTIVE }
    };
    surfaces.iter().map(|surface| surface.as_ref().map_or(Ray::INACTIVE, towards_light)).collect()
}

/// One ray from each surface into the hemisphere on the side that the hit's ray came from. Directions follow the cosine
/// distribution (Lambert's law), have the given length, and depend on the number of the surface and on `sample`. The
/// first surface has the number `first`. If there is no surface, the ray is inactive.
pub(crate) fn hemisphere_rays(
    surfaces: &[Option<SurfacePoint>],
    first: usize,
    sample: u32,
    length: f32,
    t_max: f32,
) -> Vec<Ray<f32>> {
    let leaving = |(index, surface): (usize, &Option<SurfacePoint>)| {
        surface.as_ref().map_or(Ray::INACTIVE, |surface| {
            let normal = if surface.front { surface.normal } else { -surface.normal };
            // A random point of the unit sphere that touches the surface has the cosine distribution, seen from the
            // touching point. This needs no sine.
            let dir = (normal + on_sphere((first + index) as u32, sample)).normalize_or(normal) * length;
            Ray { t_max, ..surface.spawn(dir) }
        })
    };
    surfaces.par_iter().enumerate().map(leaving).collect()
}

/// The vector scaled to unit length. In `f64` the square of its length neither overflows nor vanishes.
fn direction(vector: Vec3) -> Vec3 {
    vector.as_dvec3().normalize_or_zero().as_vec3()
}

/// A random point on the unit sphere, uniformly distributed.
fn on_sphere(pixel: u32, sample: u32) -> Vec3 {
    let coordinate = |number| 2.0 * unit_interval(hash(pixel, sample, number)) - 1.0;
    let points = (0..).map(|attempt| Vec3::from([0, 1, 2].map(|axis| coordinate(3 * attempt + axis))));
    let mut inside = points.filter(|point| (0.01..1.0).contains(&point.length_squared()));
    inside.next().expect("half of the cube is inside the sphere").normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sphere_points_are_spread_evenly() {
        let mean: Vec3 = (0..10_000).map(|pixel| on_sphere(pixel, pixel % 7)).sum::<Vec3>() / 10_000.0;
        assert!(mean.length() < 0.02, "{mean}");
    }
}
