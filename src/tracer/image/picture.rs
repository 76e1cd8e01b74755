//! Pictures, because they are how people check a tracer.

use std::path::Path;

use glam::Vec3;
use rayon::prelude::*;

use super::camera::{Camera, block_order};
use super::view::Light;
use crate::error::Error;
use crate::files::write_atomically;
use crate::geom::{Hit, Ray, Triangle};
use crate::kernels::Kernel;
use crate::tracer::meshes::generator::hash;
use crate::tracer::scene::{Scene, SurfacePoint};
use crate::tracer::trace::{Mode, trace};

/// What a pixel shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shade {
    /// Diffuse reflection of the one light, with hard shadows.
    Lambert,
    /// The geometric normal: x, y and z from -1 … 1 as red, green and blue. Shows winding, since it is not turned towards
    /// the eye.
    Normals,
    /// Distance from the eye, near white, far dark, on a scale that spans the picture.
    Depth,
    /// A colour for each primitive, another one in each instance.
    Primitives,
    /// A colour for each instance.
    Instances,
    /// How much of the hemisphere above the surface is open, by [`OCCLUSION_RAYS`] rays.
    AmbientOcclusion,
}

/// How a picture is taken.
#[derive(Clone, Copy, Debug)]
pub struct Shot {
    /// Where from.
    pub camera: Camera,
    /// What shines.
    pub light: Light,
    /// How rays are taken; the picture is the same.
    pub mode: Mode,
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

/// What is seen where nothing is hit.
const BACKGROUND: Vec3 = Vec3::new(0.53, 0.65, 0.80);
/// Light that reaches even the shadows, brightest on what faces the eye, so that surfaces in shadow keep their shape.
const AMBIENT: f32 = 0.25;
/// A ray that leaves a surface starts this fraction of its length away from it: relative, so that no scene is too small.
const START: f32 = 1e-4;
/// Rays for each pixel of an ambient-occlusion picture.
pub const OCCLUSION_RAYS: u32 = 64;
/// How far away something occludes, as a share of the scene's diagonal.
pub(crate) const OCCLUSION_REACH: f32 = 0.1;

/// Colours, row by row from the upper left: linear red, green and blue from 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    width: u32,
    height: u32,
    pixels: Vec<Vec3>,
}

impl Picture {
    /// From colours in the order of [`Camera::rays`].
    fn from_rays(shot: &Shot, colors: &[Vec3]) -> Self {
        let Shot { width, height, .. } = *shot;
        let mut pixels = vec![Vec3::ZERO; colors.len()];
        for (pixel, color) in block_order(width, height).into_iter().zip(colors) {
            pixels[pixel as usize] = *color;
        }
        Self { width, height, pixels }
    }

    /// Writes it as PNG, in sRGB.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        let bytes = self.pixels.iter().flat_map(|color| color.to_array().map(encode)).collect();
        let image = image::RgbImage::from_raw(self.width, self.height, bytes).expect("three bytes for each pixel");
        let mut png = Vec::new();
        let encoder = image::codecs::png::PngEncoder::new(&mut png);
        image.write_with_encoder(encoder).expect("an RGB picture in memory can always be encoded");
        write_atomically(path, |file| file.write_all(&png))
    }
}

/// The hits of a picture's rays, in the order of [`Camera::rays`].
pub fn picture_hits<K: Kernel<Shape = Triangle>>(scene: &Scene<K>, shot: &Shot) -> Vec<Hit<f32>> {
    trace(scene, &shot.camera.rays(shot.width, shot.height), false, shot.mode)
}

/// Shades hits that [`picture_hits`] found.
pub fn shade<K: Kernel<Shape = Triangle>>(scene: &Scene<K>, shot: &Shot, hits: &[Hit<f32>], shade: Shade) -> Picture {
    let rays = shot.camera.rays(shot.width, shot.height);
    let seen = Seen { scene, rays: &rays, hits, mode: shot.mode };
    let colors = match shade {
        Shade::Lambert => seen.lambert(shot.light),
        Shade::Normals => seen.each(|_, _, surface| surface.normal * 0.5 + 0.5),
        Shade::Depth => seen.depth(),
        Shade::Primitives => seen.each(|ray, hit, surface| {
            distinct_color(hit.primitive ^ hit.instance.rotate_left(16)) * facing(ray, surface)
        }),
        Shade::Instances => seen.each(|ray, hit, surface| distinct_color(hit.instance) * facing(ray, surface)),
        Shade::AmbientOcclusion => seen.ambient_occlusion(),
    };
    Picture::from_rays(shot, &colors)
}

/// What a picture's rays have hit.
struct Seen<'a, K: Kernel> {
    scene: &'a Scene<K>,
    rays: &'a [Ray<f32>],
    hits: &'a [Hit<f32>],
    mode: Mode,
}

impl<K: Kernel<Shape = Triangle>> Seen<'_, K> {
    /// A colour for every ray that hits, the background for the others.
    fn each(&self, color: impl Fn(&Ray<f32>, &Hit<f32>, &SurfacePoint) -> Vec3 + Sync) -> Vec<Vec3> {
        let of_ray = |(ray, hit): (&Ray<f32>, &Hit<f32>)| {
            if hit.mask { color(ray, hit, &self.scene.surface(ray, hit)) } else { BACKGROUND }
        };
        self.rays.par_iter().zip(self.hits).map(of_ray).collect()
    }

    fn depth(&self) -> Vec<Vec3> {
        let distance = |ray: &Ray<f32>, hit: &Hit<f32>| hit.t * ray.dir.length();
        let distances =
            || self.rays.iter().zip(self.hits).filter(|(_, hit)| hit.mask).map(|(ray, hit)| distance(ray, hit));
        let near = distances().fold(f32::INFINITY, f32::min);
        let far = distances().fold(0.0, f32::max);
        let span = if far > near { far - near } else { 1.0 };
        self.each(|ray, hit, _| Vec3::splat(1.0 - 0.9 * (distance(ray, hit) - near) / span))
    }

    fn lambert(&self, light: Light) -> Vec<Vec3> {
        let shadow_rays = shadow_rays(self.scene, self.rays, self.hits, light);
        let shadowed = trace(self.scene, &shadow_rays, true, self.mode);
        let lit = |index: usize| {
            let (ray, hit, shadow_ray) = (&self.rays[index], &self.hits[index], &shadow_rays[index]);
            if !hit.mask {
                return BACKGROUND;
            }
            let surface = self.scene.surface(ray, hit);
            let to_light = shadow_ray.dir.normalize_or_zero();
            let to_eye = -ray.dir.normalize_or_zero();
            // Both sides reflect, but only the side that is seen.
            let towards = surface.normal.dot(to_light) * to_eye.dot(surface.normal).signum();
            let direct = if shadowed[index].mask { 0.0 } else { towards.max(0.0) };
            surface.color * (AMBIENT * facing(ray, &surface) + (1.0 - AMBIENT) * direct)
        };
        (0..self.rays.len()).into_par_iter().map(lit).collect()
    }

    /// Grey by the share of rays, sent off with the cosine's distribution, that reach as far as occlusion does.
    fn ambient_occlusion(&self) -> Vec<Vec3> {
        let reach = self.scene.bounds().extent().length() * OCCLUSION_REACH;
        let mut open = vec![0; self.rays.len()];
        // One ray of every pixel at a time, or a large picture would need gigabytes.
        for sample in 0..OCCLUSION_RAYS {
            let rays = hemisphere_rays(self.scene, self.rays, self.hits, sample, reach, 1.0);
            for (open, occluded) in open.iter_mut().zip(trace(self.scene, &rays, true, self.mode)) {
                *open += u32::from(!occluded.mask);
            }
        }
        let grey = |(hit, open): (&Hit<f32>, &u32)| {
            if hit.mask { Vec3::splat(*open as f32 / OCCLUSION_RAYS as f32) } else { BACKGROUND }
        };
        self.hits.iter().zip(&open).map(grey).collect()
    }
}

/// From 0.5 for what is seen edge-on to 1 for what faces the eye.
fn facing(ray: &Ray<f32>, surface: &SurfacePoint) -> f32 {
    0.5 + 0.5 * ray.dir.normalize_or_zero().dot(surface.normal).abs()
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
        Ray { origin, dir, t_min: START, t_max }
    };
    rays.iter().zip(hits).map(towards_light).collect()
}

/// From each hit one ray into the hemisphere on the side that is seen, with the cosine's distribution; an inactive one for a
/// miss. Directions have this length, and differ between samples.
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
        // A point of the unit sphere that touches the surface: K. Lambert's cosine law, without a sine.
        let dir = (seen_side + on_sphere(index as u32, sample)).normalize_or(seen_side) * length;
        Ray { origin: point, dir, t_min: START, t_max }
    };
    rays.par_iter().zip(hits).enumerate().map(leaving).collect()
}

/// Where two kernels disagree about a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Differences {
    /// Pixels where only the first one hits.
    pub only_first: usize,
    /// Pixels where only the second one hits.
    pub only_second: usize,
    /// Pixels where they hit different primitives or instances.
    pub other_primitive: usize,
    /// Pixels where they hit the same primitive at another `t`, by any number of ulp.
    pub other_t: usize,
}

impl Differences {
    /// Pixels where the kernels see something else: all but those that differ in `t` alone.
    pub fn marked(&self) -> usize {
        self.only_first + self.only_second + self.other_primitive
    }
}

/// Marks every pixel where two kernels see something else, on a picture that is otherwise dark and grey: red where only the
/// first hits, blue where only the second does, yellow where they hit different primitives. A differing `t` is counted, but
/// not marked: it differs nearly everywhere, by an ulp or two.
pub fn compare(shot: &Shot, picture: &Picture, first: &[Hit<f32>], second: &[Hit<f32>]) -> (Picture, Differences) {
    let mut differences = Differences::default();
    let mut marked = picture.clone();
    for pixel in &mut marked.pixels {
        *pixel = Vec3::splat(0.25 * pixel.element_sum() / 3.0);
    }
    for ((pixel, a), b) in block_order(shot.width, shot.height).into_iter().zip(first).zip(second) {
        let (count, mark) = match (a.mask, b.mask) {
            (true, false) => (&mut differences.only_first, Some(Vec3::X)),
            (false, true) => (&mut differences.only_second, Some(Vec3::new(0.1, 0.4, 1.0))),
            (true, true) if (a.instance, a.primitive) != (b.instance, b.primitive) => {
                (&mut differences.other_primitive, Some(Vec3::new(1.0, 1.0, 0.0)))
            }
            (true, true) if a.t.to_bits() != b.t.to_bits() => (&mut differences.other_t, None),
            _ => continue,
        };
        *count += 1;
        if let Some(mark) = mark {
            marked.pixels[pixel as usize] = mark;
        }
    }
    (marked, differences)
}

/// The sRGB byte of a linear intensity.
fn encode(linear: f32) -> u8 {
    let linear = linear.clamp(0.0, 1.0);
    let encoded = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0 + 0.5) as u8
}

/// A number from 0 to 1, excluding 1.
fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 / (1 << 24) as f32
}

/// A bright colour of its own for (nearly) each number.
fn distinct_color(number: u32) -> Vec3 {
    let hue = unit(hash(number, 0, 0)) * 6.0;
    let ramp = |from: f32| (((hue + from) % 6.0 - 3.0).abs() - 1.0).clamp(0.0, 1.0);
    let saturation = 0.45 + 0.5 * unit(hash(number, 1, 0));
    Vec3::ONE.lerp(Vec3::new(ramp(0.0), ramp(4.0), ramp(2.0)), saturation)
}

/// A point of the unit sphere's surface, evenly distributed.
fn on_sphere(pixel: u32, sample: u32) -> Vec3 {
    let coordinate = |number| 2.0 * unit(hash(pixel, sample, number)) - 1.0;
    let points = (0..).map(|attempt| Vec3::from([0, 1, 2].map(|axis| coordinate(3 * attempt + axis))));
    let mut inside = points.filter(|point| (0.01..1.0).contains(&point.length_squared()));
    inside.next().expect("half of the cube is inside of the sphere").normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hit(primitive: u32, instance: u32, t: f32) -> Hit<f32> {
        Hit { mask: true, t, u: 0.0, v: 0.0, primitive, instance }
    }

    #[test]
    fn differences_are_counted_and_marked() {
        let camera = Camera::new(Vec3::Z, Vec3::ZERO, 40.0, 3, 2);
        let shot = Shot { camera, light: Light::Point(Vec3::ONE), mode: Mode::Scalar, width: 3, height: 2 };
        let white = Picture { width: 3, height: 2, pixels: vec![Vec3::ONE; 6] };
        let one = hit(0, 0, 1.0);
        let first = [one, one, Hit::MISS, one, one, Hit::MISS];
        let second = [one, Hit::MISS, one, hit(0, 1, 1.0), hit(0, 0, 2.0), Hit::MISS];
        let (marked, differences) = compare(&shot, &white, &first, &second);
        assert_eq!(differences, Differences { only_first: 1, only_second: 1, other_primitive: 1, other_t: 1 });
        assert_eq!(differences.marked(), 3);
        let grey = marked.pixels.iter().filter(|pixel| **pixel == Vec3::splat(0.25)).count();
        assert_eq!((grey, marked.pixels[1]), (3, Vec3::X));
    }

    #[test]
    fn sphere_points_and_colours_are_spread_evenly() {
        let mean: Vec3 = (0..10_000).map(|pixel| on_sphere(pixel, pixel % 7)).sum::<Vec3>() / 10_000.0;
        assert!(mean.length() < 0.02, "{mean}");
        for number in 0..1_000 {
            let color = distinct_color(number);
            assert!(color.max_element() == 1.0 && color.min_element() >= 0.0, "{color}");
            assert_ne!(color, distinct_color(number + 1));
        }
    }
}
