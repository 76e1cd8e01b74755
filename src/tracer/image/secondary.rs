//! Rays that start where a picture's rays hit: towards the light, and into the hemisphere above the surface.

use glam::Vec3;
use rayon::prelude::*;

use super::view::Light;
use crate::geom::{Hit, Ray, Triangle};
use crate::kernels::Kernel;
use crate::tracer::meshes::generator::{hash, unit_interval};
use crate::tracer::scene::{Scene, SurfacePoint};

/// `t_min` of these rays, so that a ray does not hit the surface that it leaves. It is a fraction of the ray's length,
/// so it suits scenes of any size.
const T_MIN: f32 = 1e-4;

/// One ray from each hit to the light. A point light is at `t = 1`. A miss gives an inactive ray.
pub(crate) fn shadow_rays<K: Kernel<Shape = Triangle>>(
    scene: &Scene<K>,
    rays: &[Ray<f32>],
    hits: &[Hit<f32>],
    light: Light,
) -> Vec<Ray<f32>> {
    let size = scene.bounds().extent().length();
    let towards_light = |(ray, hit): (&Ray<f32>, &Hit<f32>)| {
        if !hit.mask {
            return Ray::INACTIVE;
        }
        let origin = ray.at(hit.t);
        let (dir, t_max) = match light {
            Light::Point(position) => (position - origin, 1.0),
            Light::Directional(to_light) => (to_light.normalize_or_zero() * size, f32::INFINITY),
        };
        Ray { origin, dir, t_min: T_MIN, t_max }
    };
    rays.iter().zip(hits).map(towards_light).collect()
}

/// One ray from each hit into the hemisphere on the side that the ray came from. Directions follow the cosine
/// distribution (Lambert's law), have the given length, and depend on the index of the ray and on `sample`. A miss
/// gives an inactive ray.
pub(crate) fn hemisphere_rays<K: Kernel<Shape = Triangle>>(
    scene: &Scene<K>,
    rays: &[Ray<f32>],
    hits: &[Hit<f32>],
    sample: u32,
    length: f32,
    t_max: f32,
) -> Vec<Ray<f32>> {
    let leaving = |(index, (ray, hit)): (usize, (&Ray<f32>, &Hit<f32>))| {
        if !hit.mask {
            return Ray::INACTIVE;
        }
        let SurfacePoint { point, normal, .. } = scene.surface(ray, hit);
        let seen_side = if normal.dot(ray.dir) > 0.0 { -normal } else { normal };
        // A random point of the unit sphere that touches the surface has the cosine distribution, seen from the
        // touching point. This needs no sine.
        let dir = (seen_side + on_sphere(index as u32, sample)).normalize_or(seen_side) * length;
        Ray { origin: point, dir, t_min: T_MIN, t_max }
    };
    rays.par_iter().zip(hits).enumerate().map(leaving).collect()
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
