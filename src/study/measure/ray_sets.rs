//! The four sets of rays that a picture needs: primary rays from the eye, and three sets that start where these hit.
//! They are ordered from coherent rays (similar origins and directions) to incoherent ones.

use crate::geom::{Ray, Triangle};
use crate::kernels::Kernel;
use crate::tracer::{Mode, OCCLUSION_REACH, Scene, View, hemisphere_rays, shadow_rays, surfaces, trace};

/// Rays that a renderer traces together, in the order of the picture's blocks ([`crate::tracer::block_order`]).
#[derive(Clone, Debug)]
pub struct RaySet {
    /// Name, as used in records: one of [`NAMES`].
    pub name: &'static str,
    /// Whether any hit will do. Otherwise the closest hit is wanted.
    pub any_hit: bool,
    /// The rays. All of them are active.
    pub rays: Vec<Ray<f32>>,
}

/// Names of the sets, in the order of [`ray_sets`].
pub const NAMES: [&str; 4] = ["primary", "shadow", "bounce", "ambient occlusion"];

/// Name of one more set, which is judged but not timed: rays from the eye at edges in sight.
pub(crate) const EDGES: &str = "edges";

/// The rays of a picture of `size` × `size` pixels:
///
/// - *primary*: from the eye through each pixel; closest hit;
/// - *shadow*: from each primary hit whose visible side faces the view's light, to that light; any hit;
/// - *bounce*: from each primary hit into the hemisphere on the visible side, distributed by Lambert's cosine law (a
///   matt surface), of infinite length; closest hit;
/// - *ambient occlusion*: like bounce, but in other directions, and at most a tenth of the scene's diagonal long; any
///   hit.
///
/// Bounce and ambient occlusion rays depend on `seed`. They are the same on every machine for the same primary hits.
pub fn ray_sets<K: Kernel<Shape = Triangle>>(scene: &Scene<K>, view: &View, size: u32, seed: u64) -> [RaySet; 4] {
    let pixels = view.camera(size, size).rays(size, size);
    let hits = trace(scene, &pixels, Mode::Auto);
    let diagonal = scene.bounds().extent().length();
    let sample = (seed ^ (seed >> 32)) as u32;
    let surfaces = surfaces(scene, &pixels, &hits);
    let shadow = shadow_rays(&surfaces, view.light, diagonal);
    let bounce = hemisphere_rays(&surfaces, 0, sample, diagonal, f32::INFINITY);
    let occlusion = hemisphere_rays(&surfaces, 0, sample.wrapping_add(1), diagonal * OCCLUSION_REACH, 1.0);
    // Pixels that show the background have no secondary rays.
    let active = |rays: Vec<Ray<f32>>| rays.into_iter().filter(|ray| ray.t_min <= ray.t_max).collect();
    let [shadow, bounce, occlusion] = [shadow, bounce, occlusion].map(active);
    let set = |number: usize, any_hit, rays| RaySet { name: NAMES[number], any_hit, rays };
    [set(0, false, pixels), set(1, true, shadow), set(2, false, bounce), set(3, true, occlusion)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Hit;
    use crate::kernels::triangle::Woop;
    use crate::tracer::{Light, SceneSource, checksum};

    fn sets(seed: u64) -> (Scene<Woop<f32>>, View, [RaySet; 4]) {
        let loaded = SceneSource::parse("room:small").unwrap().load().unwrap();
        let scene = Scene::new(loaded.world);
        let sets = ray_sets(&scene, &loaded.view, 32, seed);
        (scene, loaded.view, sets)
    }

    #[test]
    fn secondary_rays_leave_the_surface_on_the_visible_side() {
        let (scene, view, [primary, shadow, bounce, occlusion]) = sets(7);
        let hits = trace(&scene, &primary.rays, Mode::Scalar);
        let seen: Vec<_> = primary.rays.iter().zip(&hits).filter(|(_, hit)| hit.mask).collect();
        assert!(seen.len() > primary.rays.len() / 2, "the room is closed, so most rays hit");
        assert_eq!([&bounce, &occlusion].map(|set| set.rays.len()), [seen.len(); 2]);
        let towards_light = |(ray, hit): &&(&Ray<f32>, &Hit<f32>)| {
            let Light::Point(light) = view.light else { panic!("the room has a lamp") };
            let surface = scene.surface(ray, hit);
            (surface.normal.dot(light - surface.point) > 0.0) == surface.front
        };
        assert_eq!(shadow.rays.len(), seen.iter().filter(towards_light).count());
        let diagonal = scene.bounds().extent().length();
        let (mut cosines, mut turned) = (0.0, 0);
        for (index, (ray, hit)) in seen.iter().enumerate() {
            let surface = scene.surface(ray, hit);
            let towards_eye = -ray.dir.dot(surface.normal).signum();
            let (bounce, occlusion) = (&bounce.rays[index], &occlusion.rays[index]);
            for (ray, length) in [(bounce, diagonal), (occlusion, 0.1 * diagonal)] {
                let off = (ray.origin - surface.point).dot(surface.normal) * towards_eye;
                let cosine = ray.dir.dot(surface.normal) * towards_eye / length;
                assert!(cosine > -1e-6, "{cosine}");
                assert!(off * cosine >= 0.0 && ray.origin.distance(surface.point) < 1e-5, "{off}");
                assert!((ray.dir.length() / length - 1.0).abs() < 1e-5);
                cosines += cosine;
            }
            assert_eq!((bounce.t_max, occlusion.t_max), (f32::INFINITY, 1.0));
            turned += usize::from(bounce.dir.normalize().dot(occlusion.dir.normalize()) < 0.999);
        }
        // The mean cosine is 2/3 under Lambert's law, and 1/2 under a uniform distribution.
        let mean = cosines / (2 * seen.len()) as f32;
        assert!((mean - 2.0 / 3.0).abs() < 0.03, "{mean}");
        assert!(turned > seen.len() * 9 / 10, "{turned}: bounce and occlusion rays must be different samples");
    }

    #[test]
    fn the_seed_determines_the_rays() {
        let hits = |seed| {
            let (scene, _, sets) = sets(seed);
            sets.map(|set| checksum(&trace(&scene, &set.rays, Mode::Scalar)))
        };
        let (first, again, other) = (hits(1), hits(1), hits(2));
        assert_eq!(first, again);
        assert_eq!(first[..2], other[..2], "primary and shadow rays do not depend on the seed");
        assert!(first[2] != other[2] && first[3] != other[3]);
    }
}
