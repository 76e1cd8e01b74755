//! Pictures, because they are how people check a tracer.

use std::path::Path;

use glam::Vec3;

use super::{Camera, Error, Light, Mode, Scene, SurfacePoint, block_order, trace, write_atomically};
use crate::geom::{Hit, Ray, Triangle};
use crate::kernels::Kernel;

/// What a pixel shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shade {
    /// The geometric normal: x, y and z from -1 … 1 as red, green and blue. Shows winding, since it is not turned towards
    /// the eye.
    Normals,
    /// Distance from the eye, near white, far dark, on a scale that spans the picture.
    Depth,
    /// Diffuse reflection of the one light, with hard shadows.
    Lambert,
}

/// What is seen where nothing is hit.
const BACKGROUND: Vec3 = Vec3::new(0.53, 0.65, 0.80);
/// Light that reaches even the shadows, brightest on what faces the eye, so that surfaces in shadow keep their shape.
const AMBIENT: f32 = 0.25;
/// A shadow ray starts this fraction of its length away from the surface: relative, so that no scene is too small.
const SHADOW_START: f32 = 1e-4;

/// Traces and shades a picture and writes it as PNG.
///
/// # Errors
/// If the file cannot be written.
#[expect(clippy::too_many_arguments, reason = "a picture is made of these; a struct would only name them again")]
pub fn render<K: Kernel<Shape = Triangle>>(
    path: &Path,
    scene: &Scene<K>,
    camera: &Camera,
    light: Light,
    shade: Shade,
    mode: Mode,
    width: u32,
    height: u32,
) -> Result<(), Error> {
    let rays = camera.rays(width, height);
    let hits = trace(scene, &rays, false, mode);
    let colors = match shade {
        Shade::Normals => rays
            .iter()
            .zip(&hits)
            .map(|(ray, hit)| of_hit(hit, |hit| scene.surface(ray, hit).normal * 0.5 + 0.5))
            .collect(),
        Shade::Depth => depth(&rays, &hits),
        Shade::Lambert => lambert(scene, &rays, &hits, light, mode),
    };
    let mut image = image::RgbImage::new(width, height);
    for (pixel, color) in block_order(width, height).into_iter().zip(colors) {
        image.put_pixel(pixel % width, pixel / width, image::Rgb(color.to_array().map(encode)));
    }
    let mut png = Vec::new();
    let encoder = image::codecs::png::PngEncoder::new(&mut png);
    image.write_with_encoder(encoder).expect("an RGB picture in memory can always be encoded");
    write_atomically(path, |file| file.write_all(&png))
}

/// The sRGB byte of a linear intensity.
fn encode(linear: f32) -> u8 {
    let linear = linear.clamp(0.0, 1.0);
    let encoded = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0 + 0.5) as u8
}

fn of_hit(hit: &Hit<f32>, color: impl FnOnce(&Hit<f32>) -> Vec3) -> Vec3 {
    if hit.mask { color(hit) } else { BACKGROUND }
}

fn depth(rays: &[Ray<f32>], hits: &[Hit<f32>]) -> Vec<Vec3> {
    let distances = || rays.iter().zip(hits).filter(|(_, hit)| hit.mask).map(|(ray, hit)| hit.t * ray.dir.length());
    let near = distances().fold(f32::INFINITY, f32::min);
    let far = distances().fold(0.0, f32::max);
    let span = if far > near { far - near } else { 1.0 };
    rays.iter()
        .zip(hits)
        .map(|(ray, hit)| of_hit(hit, |hit| Vec3::splat(1.0 - 0.9 * (hit.t * ray.dir.length() - near) / span)))
        .collect()
}

fn lambert<K: Kernel<Shape = Triangle>>(
    scene: &Scene<K>,
    rays: &[Ray<f32>],
    hits: &[Hit<f32>],
    light: Light,
    mode: Mode,
) -> Vec<Vec3> {
    let shadow_rays = shadow_rays(scene, rays, hits, light);
    let shadowed = trace(scene, &shadow_rays, true, mode);
    (0..rays.len())
        .map(|index| {
            of_hit(&hits[index], |hit| {
                let SurfacePoint { normal, color, .. } = scene.surface(&rays[index], hit);
                let to_light = shadow_rays[index].dir.normalize_or_zero();
                let to_eye = -rays[index].dir.normalize_or_zero();
                // Both sides reflect, but only the side that is seen.
                let facing = normal.dot(to_light) * to_eye.dot(normal).signum();
                let direct = if shadowed[index].mask { 0.0 } else { facing.max(0.0) };
                let ambient = AMBIENT * (0.5 + 0.5 * to_eye.dot(normal).abs());
                color * (ambient + (1.0 - AMBIENT) * direct)
            })
        })
        .collect()
}

/// The rays from each hit to the light, which is at `t = 1` if it is a point; an inactive one for a miss.
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
        Ray { origin, dir, t_min: SHADOW_START, t_max }
    };
    rays.iter().zip(hits).map(towards_light).collect()
}
