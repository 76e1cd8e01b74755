//! A path tracer's bounce: the light that reaches each surface from the lamp, and over one other surface.
//!
//! No ray needs an epsilon: a surface spawns the rays that leave it. Writes `bounce.png`.
//! `cargo run --release --example bounce -- SCENE`, with a mesh file, a scene file or a built-in scene.

use std::error::Error;
use std::path::Path;

use raylanes::geom::{Hit, Ray};
use raylanes::glam::Vec3;
use raylanes::kernels::triangle::ExactHalfOpen;
use raylanes::tracer::{Light, Mode, Picture, Scene, SceneSource, SurfacePoint, occluded, trace};

const SIZE: u32 = 512;
const SAMPLES: u32 = 32;
const SKY: Vec3 = Vec3::new(0.4, 0.5, 0.7);

type Tracer = Scene<ExactHalfOpen<f32>>;

/// The surface at each hit.
fn surfaces(scene: &Tracer, rays: &[Ray<f32>], hits: &[Hit<f32>]) -> Vec<Option<SurfacePoint>> {
    rays.iter().zip(hits).map(|(ray, hit)| hit.mask.then(|| scene.surface(ray, hit))).collect()
}

/// The normal on the side that was seen.
fn normal(surface: &SurfacePoint) -> Vec3 {
    if surface.front { surface.normal } else { -surface.normal }
}

/// The colour of each surface in the light of the lamp, without the light that other surfaces reflect.
fn direct(scene: &Tracer, light: Light, surfaces: &[Option<SurfacePoint>]) -> Vec<Vec3> {
    let to_light = |surface: &SurfacePoint| match light {
        Light::Point(lamp) => surface.spawn_to(lamp),
        Light::Directional(towards) => surface.spawn(towards),
    };
    let rays: Vec<_> = surfaces.iter().map(|surface| surface.as_ref().map_or(Ray::INACTIVE, to_light)).collect();
    let shadowed = occluded(scene, &rays, Mode::Auto);
    let lit = |((surface, ray), shadowed): ((&Option<SurfacePoint>, &Ray<f32>), bool)| {
        let Some(surface) = surface else { return SKY };
        let cosine = normal(surface).dot(ray.dir.normalize_or_zero()).max(0.0);
        if shadowed { Vec3::ZERO } else { surface.color * cosine }
    };
    surfaces.iter().zip(&rays).zip(shadowed).map(lit).collect()
}

fn main() -> Result<(), Box<dyn Error>> {
    let name = std::env::args().nth(1).unwrap_or_else(|| "gallery".into());
    let loaded = SceneSource::parse(&name)?.load()?;
    let (light, scene) = (loaded.view.light, Tracer::new(loaded.world));
    let rays = loaded.view.camera(SIZE, SIZE).rays(SIZE, SIZE);
    let seen = surfaces(&scene, &rays, &trace(&scene, &rays, Mode::Auto));
    let mut colors = direct(&scene, light, &seen);

    let mut state = 1_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1 << 23) as f32 - 1.0
    };
    for _ in 0..SAMPLES {
        // By Lambert's law: a point of the sphere that touches the surface.
        let mut bounce = |surface: &SurfacePoint| {
            let on_sphere = Vec3::new(random(), random(), random()).normalize_or(Vec3::X);
            surface.spawn((normal(surface) + on_sphere).normalize_or(normal(surface)))
        };
        let rays: Vec<_> = seen.iter().map(|surface| surface.as_ref().map_or(Ray::INACTIVE, &mut bounce)).collect();
        let met = surfaces(&scene, &rays, &trace(&scene, &rays, Mode::Auto));
        for ((color, surface), reflected) in colors.iter_mut().zip(&seen).zip(direct(&scene, light, &met)) {
            *color += surface.map_or(Vec3::ZERO, |surface| surface.color * reflected / SAMPLES as f32);
        }
    }
    Picture::from_rays(SIZE, SIZE, &colors).write(Path::new("bounce.png"))?;
    println!("{name}: {} rays bounced, see bounce.png", seen.iter().flatten().count() * SAMPLES as usize);
    Ok(())
}
