//! Rays that start where a picture's rays hit: towards the light, and into the hemisphere above the surface.

use glam::Vec3;
use rayon::prelude::*;

use super::view::Light;
use crate::geom::{Hit, Ray, Triangle};
use crate::kernels::Kernel;
use crate::tracer::meshes::generator::{hash, unit_interval};
use crate::tracer::scene::{Scene, Start};

/// Where secondary rays start, for each hit; `None` for a miss.
pub(crate) fn starts<K: Kernel<Shape = Triangle>>(
    scene: &Scene<K>,
    rays: &[Ray<f32>],
    hits: &[Hit<f32>],
) -> Vec<Option<Start>> {
    rays.par_iter().zip(hits).map(|(ray, hit)| hit.mask.then(|| scene.start(ray, hit))).collect()
}

/// One ray from each start to the light. A point light is at `t = 1`. `size` is the length of rays to a light at
/// infinity. No start gives an inactive ray.
pub(crate) fn shadow_rays(starts: &[Option<Start>], light: Light, size: f32) -> Vec<Ray<f32>> {
    let towards_light = |&Start { point, .. }: &Start| {
        let (dir, t_max) = match light {
            Light::Point(position) => (position - point, 1.0),
            Light::Directional(to_light) => (direction(to_light) * size, f32::INFINITY),
        };
        Ray { origin: point, dir, t_min: 0.0, t_max }
    };
    starts.iter().map(|start| start.as_ref().map_or(Ray::INACTIVE, towards_light)).collect()
}

/// One ray from each start into the hemisphere on the side that the hit's ray came from. Directions follow the cosine
/// distribution (Lambert's law), have the given length, and depend on the index of the ray and on `sample`. No start
/// gives an inactive ray.
pub(crate) fn hemisphere_rays(starts: &[Option<Start>], sample: u32, length: f32, t_max: f32) -> Vec<Ray<f32>> {
    let leaving = |(index, start): (usize, &Option<Start>)| {
        start.map_or(Ray::INACTIVE, |Start { point, normal }| {
            // A random point of the unit sphere that touches the surface has the cosine distribution, seen from the
            // touching point. This needs no sine.
            let dir = (normal + on_sphere(index as u32, sample)).normalize_or(normal) * length;
            Ray { origin: point, dir, t_min: 0.0, t_max }
        })
    };
    starts.par_iter().enumerate().map(leaving).collect()
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
