//! Shading: a colour for each ray of a picture, from its hit.

use glam::Vec3;
use rayon::prelude::*;

use super::picture::Picture;
use super::secondary::{hemisphere_rays, shadow_rays, surfaces};
use super::shot::Shot;
use super::view::Light;
use crate::geom::{Hit, Ray, Triangle};
use crate::kernels::Kernel;
use crate::tracer::meshes::generator::{hash, unit_interval};
use crate::tracer::scene::{Scene, SurfacePoint};
use crate::tracer::trace::{Mode, occluded};

/// What a pixel shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Shade {
    /// Diffuse reflection of the light, with hard shadows. Surfaces look smooth where a mesh has normals.
    Lambert,
    /// The geometric normal: x, y and z from -1 to 1 as red, green and blue. It is not flipped towards the eye, so it
    /// shows the winding of triangles.
    Normals,
    /// Distance from the eye as grey: the nearest point of the picture is white, the farthest one is dark.
    Depth,
    /// A colour for each primitive of each instance.
    Primitives,
    /// A colour for each instance.
    Instances,
    /// The unoccluded share of the hemisphere above the surface, estimated with [`OCCLUSION_RAYS`] rays.
    AmbientOcclusion,
}

/// Colour of pixels that show no surface.
const BACKGROUND: Vec3 = Vec3::new(0.53, 0.65, 0.80);
/// Share of ambient light. It depends on the angle to the eye, so surfaces in shadow keep their shape.
const AMBIENT: f32 = 0.25;
/// Rays per pixel of an ambient-occlusion picture.
pub const OCCLUSION_RAYS: u32 = 64;
/// Length of ambient-occlusion rays, as a fraction of the scene's diagonal.
pub(crate) const OCCLUSION_REACH: f32 = 0.1;

/// Shades the hits that [`picture_hits`](super::picture_hits) found for the same shot.
pub fn shade<K: Kernel<Shape = Triangle>>(scene: &Scene<K>, shot: &Shot, hits: &[Hit<f32>], shade: Shade) -> Picture {
    let rays = shot.camera.rays(shot.width, shot.height);
    let primary = PrimaryHits { scene, rays: &rays, hits, mode: shot.mode };
    let colors = match shade {
        Shade::Lambert => primary.lambert(shot.light),
        Shade::Normals => primary.color_each(|_, _, surface| surface.normal * 0.5 + 0.5),
        Shade::Depth => primary.depth(),
        Shade::Primitives => primary.color_each(|ray, hit, surface| {
            distinct_color(hit.primitive ^ hit.instance.rotate_left(16)) * facing(ray, surface.normal)
        }),
        Shade::Instances => {
            primary.color_each(|ray, hit, surface| distinct_color(hit.instance) * facing(ray, surface.normal))
        }
        Shade::AmbientOcclusion => primary.ambient_occlusion(),
    };
    Picture::from_rays(shot.width, shot.height, &colors)
}

/// A picture's rays and their hits.
struct PrimaryHits<'a, K: Kernel> {
    scene: &'a Scene<K>,
    rays: &'a [Ray<f32>],
    hits: &'a [Hit<f32>],
    mode: Mode,
}

impl<K: Kernel<Shape = Triangle>> PrimaryHits<'_, K> {
    /// The given colour for each ray that hits, and the background for the others.
    fn color_each(&self, color: impl Fn(&Ray<f32>, &Hit<f32>, &SurfacePoint) -> Vec3 + Sync) -> Vec<Vec3> {
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
        let range = if far > near { far - near } else { 1.0 };
        self.color_each(|ray, hit, _| Vec3::splat(1.0 - 0.9 * (distance(ray, hit) - near) / range))
    }

    fn lambert(&self, light: Light) -> Vec<Vec3> {
        let size = self.scene.bounds().extent().length();
        self.color_blocks(|_, rays, surfaces| {
            let shadow_rays = shadow_rays(surfaces, light, size);
            let shadowed = occluded(self.scene, &shadow_rays, self.mode);
            let lit = |index: usize| {
                let Some(surface) = &surfaces[index] else { return BACKGROUND };
                let shadow_ray = &shadow_rays[index];
                // Surfaces reflect on both sides, but only the side that faces the eye is seen. If the light is behind
                // it, the shadow ray is inactive.
                let is_lit = shadow_ray.t_min <= shadow_ray.t_max && !shadowed[index];
                let cosine = shadow_ray.dir.normalize_or_zero().dot(surface.shading_normal);
                let cosine = if surface.front { cosine } else { -cosine };
                let direct = if is_lit { cosine.max(0.0) } else { 0.0 };
                surface.color * (AMBIENT * facing(&rays[index], surface.shading_normal) + (1.0 - AMBIENT) * direct)
            };
            (0..rays.len()).into_par_iter().map(lit).collect()
        })
    }

    /// Grey: the share of hemisphere rays that hit nothing.
    fn ambient_occlusion(&self) -> Vec<Vec3> {
        let reach = self.scene.bounds().extent().length() * OCCLUSION_REACH;
        self.color_blocks(|first, rays, surfaces| {
            let mut open = vec![0; rays.len()];
            for sample in 0..OCCLUSION_RAYS {
                let rays = hemisphere_rays(surfaces, first, sample, reach, 1.0);
                for (open, occluded) in open.iter_mut().zip(occluded(self.scene, &rays, self.mode)) {
                    *open += u32::from(!occluded);
                }
            }
            let grey = |open: u32| Vec3::splat(open as f32 / OCCLUSION_RAYS as f32);
            surfaces.iter().zip(open).map(|(surface, open)| surface.map_or(BACKGROUND, |_| grey(open))).collect()
        })
    }

    /// The colours of all pixels, made for many of them at a time. All secondary rays of a large picture would need
    /// gigabytes. `color` gets the number of the first pixel, the rays, and the surfaces that they hit.
    fn color_blocks(&self, color: impl Fn(usize, &[Ray<f32>], &[Option<SurfacePoint>]) -> Vec<Vec3>) -> Vec<Vec3> {
        const PIXELS: usize = 1 << 18;
        let blocks = self.rays.chunks(PIXELS).zip(self.hits.chunks(PIXELS)).enumerate();
        let of_block = |(block, (rays, hits))| color(block * PIXELS, rays, &surfaces(self.scene, rays, hits));
        blocks.flat_map(of_block).collect()
    }
}

/// From 0.5 for a surface seen edge-on to 1 for a surface that faces the eye.
fn facing(ray: &Ray<f32>, normal: Vec3) -> f32 {
    0.5 + 0.5 * ray.dir.normalize_or_zero().dot(normal).abs()
}

/// A bright colour for a number. Different numbers nearly always have different colours.
fn distinct_color(number: u32) -> Vec3 {
    let hue = unit_interval(hash(number, 0, 0)) * 6.0;
    let ramp = |from: f32| (((hue + from) % 6.0 - 3.0).abs() - 1.0).clamp(0.0, 1.0);
    let saturation = 0.45 + 0.5 * unit_interval(hash(number, 1, 0));
    Vec3::ONE.lerp(Vec3::new(ramp(0.0), ramp(4.0), ramp(2.0)), saturation)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_bright_and_distinct_colours() {
        for number in 0..1_000 {
            let color = distinct_color(number);
            assert!(color.max_element() == 1.0 && color.min_element() >= 0.0, "{color}");
            assert_ne!(color, distinct_color(number + 1));
        }
    }
}
