//! Tests that rays that leave a surface do not hit it again, and miss none of its neighbours.
//!
//! Bounce rays of whole pictures are compared with a reference in `f64`: a ray from the exact point, which leaves out
//! the triangle that it starts on. The table that the test prints also shows what other ways to start a ray do.
//! `spawn.expected` pins it; `RAYLANES_BLESS=1 cargo test --test hits` writes it anew.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use glam::{Affine3, Vec3};
use raylanes::conformance::Random;
use raylanes::geom::{Hit, Quadric, Ray, Triangle};
use raylanes::kernels::triangle::ExactHalfOpen;
use raylanes::kernels::{Claim, Intersect, Kernel};
use raylanes::registry::{self, Visitor};
use raylanes::tracer::{Geometry, Mesh, Mode, Scene, SceneSource, SurfacePoint, View, World, trace};
use rayon::prelude::*;

use crate::reference::Reference;
use crate::worlds::{self, place, unit, vec3};

/// A direction on the side that was seen, by Lambert's cosine law.
fn bounce(random: &mut Random, surface: &SurfacePoint) -> Vec3 {
    let normal = if surface.front { surface.normal } else { -surface.normal };
    (normal + vec3(random).normalize_or(Vec3::X)).normalize_or(normal)
}

/// A picture of a mesh: where rays bounce, and where they should arrive.
struct Bounces {
    surface: SurfacePoint,
    /// The triangle that the ray leaves.
    own: u32,
    dir: Vec3,
    /// The first triangle that the ray meets, and its `t`; `u32::MAX` and infinity if there is none.
    expected: (f64, u32),
}

/// Ways to start a ray that leaves a surface.
#[derive(Clone, Copy)]
enum Way {
    /// [`SurfacePoint::spawn`].
    Spawn,
    /// From the rounded point, with `t_min = 0`.
    Nothing,
    /// From the rounded point, with `t_min` this share of the scene's size.
    Epsilon(f32),
    /// From the rounded point, with a filter that leaves out the triangle.
    Skip,
}

const WAYS: [(&str, Way); 4] =
    [("spawn", Way::Spawn), ("t_min 0", Way::Nothing), ("t_min 1e-4", Way::Epsilon(1e-4)), ("skip", Way::Skip)];

struct Table<'a> {
    name: &'a str,
    world: &'a World,
    view: &'a View,
    size: u32,
    reference: &'a Reference,
    lines: Vec<String>,
}

impl Visitor<Triangle> for Table<'_> {
    fn visit<K: Kernel<Shape = Triangle>>(&mut self) {
        let scene = Scene::<K>::new(self.world.clone());
        let bounces = self.bounces(&scene);
        let size = scene.bounds().extent().length();
        let mut line = format!("{} {} {}", self.name, K::INFO.id, bounces.len());
        for (name, way) in WAYS {
            let ray = |bounce: &Bounces| {
                let start = Ray::new(bounce.surface.point, bounce.dir);
                match way {
                    Way::Spawn => bounce.surface.spawn(bounce.dir),
                    Way::Epsilon(share) => Ray { t_min: share * size, ..start },
                    Way::Nothing | Way::Skip => start,
                }
            };
            let hit = |bounce: &Bounces| {
                let own = bounce.own;
                match way {
                    Way::Skip => {
                        let others = |_: &Ray<f32>, hit: &Hit<f32>| hit.primitive != own;
                        Intersect::<f32>::hit(&scene.with_filter(others), &ray(bounce))
                    }
                    _ => Intersect::<f32>::hit(&scene, &ray(bounce)),
                }
            };
            let hits: Vec<_> = bounces.par_iter().map(hit).collect();
            let (mut own, mut wrong) = (0, 0);
            for (bounce, hit) in bounces.iter().zip(&hits) {
                own += usize::from(hit.primitive == bounce.own);
                // Near an edge, another triangle is no other place.
                let (t, primitive) = bounce.expected;
                let near = (f64::from(hit.t) - t).abs() <= 1e-5 * f64::from(size);
                wrong += usize::from(hit.primitive != bounce.own && hit.primitive != primitive && !near);
            }
            if matches!(way, Way::Spawn) && K::INFO.claims_to(Claim::NoHitBehind) {
                assert_eq!(own, 0, "{}, {}: rays that hit what they leave", self.name, K::INFO.id);
            }
            write!(line, " | {name}: {own} own, {wrong} wrong").unwrap();
        }
        self.lines.push(line);
    }
}

impl Table<'_> {
    fn bounces<K: Kernel<Shape = Triangle>>(&self, scene: &Scene<K>) -> Vec<Bounces> {
        let rays = self.view.camera(self.size, self.size).rays(self.size, self.size);
        let hits = trace(scene, &rays, Mode::Auto);
        let bounce = |(pixel, (ray, hit)): (usize, (&Ray<f32>, &Hit<f32>))| {
            let surface = scene.surface(ray, hit);
            let dir = bounce(&mut Random::from_seed(pixel as u64), &surface);
            let point = self.reference.point(ray, hit.primitive);
            let expected = self.reference.closest(point, dir.as_dvec3(), hit.primitive);
            Bounces { surface, own: hit.primitive, dir, expected }
        };
        rays.par_iter().zip(&hits).enumerate().filter(|(_, (_, hit))| hit.mask).map(bounce).collect()
    }
}

fn table(name: &str, size: u32) -> Vec<String> {
    let loaded = SceneSource::parse(name).unwrap().load().unwrap();
    let [Geometry::Mesh(mesh)] = loaded.world.geometries() else { panic!("{name} is a mesh") };
    let reference = Reference::new(mesh.iter());
    let name = Path::new(name).file_stem().unwrap().to_str().unwrap();
    let mut table =
        Table { name, world: &loaded.world, view: &loaded.view, size, reference: &reference, lines: Vec::new() };
    registry::triangles(&mut table);
    table.lines
}

#[test]
fn bounce_rays_miss_what_they_leave_and_hit_the_rest() {
    let lines: Vec<_> = ["terrain:1e4", "room:1e4"].into_iter().flat_map(|name| table(name, 256)).collect();
    println!("{}", lines.join("\n"));
    let expected = Path::new("tests/hits/spawn.expected");
    let known = fs::read_to_string(expected).unwrap_or_default();
    // Lines of kernels that this build lacks are kept.
    let key = |line: &str| line.split(" | ").next().unwrap().to_owned();
    let absent = |line: &&str| registry::absent().iter().any(|absent| line.contains(&format!(" {} ", absent.id)));
    let mut all: Vec<_> = known.lines().filter(absent).map(str::to_owned).chain(lines).collect();
    all.sort_by_key(|line| known.lines().position(|other| key(other) == key(line)).unwrap_or(usize::MAX));
    let text = all.join("\n") + "\n";
    if std::env::var_os("RAYLANES_BLESS").is_some() {
        fs::write(expected, text).unwrap();
    } else {
        assert_eq!(known, text, "RAYLANES_BLESS=1 cargo test --test hits writes {}", expected.display());
    }
}

/// Triangles that are turned, sheared and far away, and slivers. No ray from any of them may hit it again, in any
/// direction, with a kernel that tells `t` from 0.
#[derive(Default)]
struct EveryInstance {
    claiming: usize,
    others: Vec<String>,
}

impl Visitor<Triangle> for EveryInstance {
    fn visit<K: Kernel<Shape = Triangle>>(&mut self) {
        let mut random = Random::from_seed(29);
        let (mut rays, mut own) = (0, 0);
        for round in 0..300 {
            let size = worlds::pick(&mut random, &[1e-3, 1.0, 1.0, 1e3]);
            let at = vec3(&mut random) * worlds::pick(&mut random, &[0.0, 1.0, 1e3, 1e5]);
            let [a, b, c] = [(); 3].map(|()| vec3(&mut random) * size);
            let v2 = if round % 4 == 0 { a + (b - a) * 0.3 + c * 1e-4 } else { c };
            let triangle = Triangle { v0: a + at, v1: b + at, v2: v2 + at };
            let transform = if round % 3 == 0 { Affine3::IDENTITY } else { worlds::transform(&mut random, 1e3) };
            let mesh = Geometry::Mesh(Mesh::from_triangles(&[triangle]).unwrap());
            let scene = Scene::<K>::new(World::new(vec![mesh], vec![place(0, transform)]).unwrap());
            for _ in 0..40 {
                let target = transform.transform_point3(worlds::on_triangle(&mut random, triangle));
                let distance = size * worlds::pick(&mut random, &[0.1, 1.0, 100.0]);
                let from = target + vec3(&mut random) * distance;
                let ray = Ray::new(from, target - from);
                for hit in scene.all_hits(&ray) {
                    let surface = scene.surface(&ray, &hit);
                    let along = transform.transform_vector3(b - a);
                    let grazing = along + surface.normal * along.length() * (unit(&mut random) - 0.5) * 1e-6;
                    for dir in [vec3(&mut random), -vec3(&mut random) * 1e-3, along, grazing, surface.normal] {
                        rays += 1;
                        own += usize::from(Intersect::<f32>::hit(&scene, &surface.spawn(dir)).mask);
                    }
                    let target = surface.point + vec3(&mut random) * distance;
                    let to = surface.spawn_to(target);
                    assert_eq!(to.t_max, 1.0);
                    // A target that is no higher than the start may be on the triangle.
                    let height = |point: Vec3| (point - surface.point).dot(surface.normal).abs();
                    if height(target) > 10.0 * height(to.origin) + target.abs().max_element() * 1e-6 {
                        rays += 1;
                        own += usize::from(Intersect::<f32>::hit(&scene, &to).mask);
                    }
                }
            }
        }
        assert!(rays > 20_000, "{rays}");
        if K::INFO.claims_to(Claim::NoHitBehind) {
            assert_eq!(own, 0, "{} of {rays} rays", K::INFO.id);
            self.claiming += 1;
        } else {
            self.others.push(format!("{}: {own} of {rays}", K::INFO.id));
        }
    }
}

#[test]
fn no_ray_hits_what_it_leaves_in_any_instance() {
    let mut every = EveryInstance::default();
    registry::triangles(&mut every);
    println!("without the claim: {}", every.others.join(", "));
    assert!(every.claiming > 4);
}

/// A ray from a sphere outwards misses it. A ray inwards hits the other side.
#[test]
fn rays_leave_quadrics_on_both_sides() {
    let mut random = Random::from_seed(31);
    for round in 0..400 {
        let transform = if round % 2 == 0 { Affine3::IDENTITY } else { worlds::transform(&mut random, 100.0) };
        let geometry = Geometry::Quadric(Quadric::sphere(1.0));
        let scene = Scene::<ExactHalfOpen<f32>>::new(World::new(vec![geometry], vec![place(0, transform)]).unwrap());
        let Affine3 { matrix3, translation } = transform;
        for _ in 0..20 {
            let from = translation + matrix3 * (vec3(&mut random).normalize_or(Vec3::X) * 3.0);
            let ray = Ray::new(from, translation + matrix3 * (vec3(&mut random) * 0.5) - from);
            let hit: Hit<f32> = scene.hit(&ray);
            if !hit.mask {
                continue;
            }
            let surface = scene.surface(&ray, &hit);
            let dir = matrix3 * vec3(&mut random);
            let ray = surface.spawn(dir);
            let hit: Hit<f32> = scene.hit(&ray);
            // In the sphere's coordinates: where the ray starts, and where its line crosses the sphere.
            let inverse = matrix3.as_dmat3().inverse();
            let (o, d) = (inverse * (ray.origin.as_dvec3() - translation.as_dvec3()), inverse * dir.as_dvec3());
            let (a, b, c) = (d.dot(d), o.dot(d), o.dot(o) - 1.0);
            // What some roundings of the coordinates amount to, far from the origin.
            let coarse = (inverse.abs() * ray.origin.as_dvec3().abs()).max_element() * 1e-5;
            assert!(
                (c > 0.0) == (dir.dot(surface.normal) > 0.0) && c.abs() < 1e-3 + coarse,
                "{ray:?} {surface:?}: {c}"
            );
            let far = (-b + (b * b - a * c).sqrt()) / a;
            if c > 0.0 {
                assert!(!hit.mask, "{ray:?} {hit:?}");
            } else if coarse < 1e-3 {
                assert!(hit.mask && (f64::from(hit.t) - far).abs() < 1e-2 * far, "{ray:?} {hit:?} {far}");
            }
        }
    }
}

/// Far from the origin, rounding moves a start so far along a sphere that the sphere bends away below it.
#[test]
fn rays_leave_small_quadrics_far_away_on_both_sides() {
    let mut random = Random::from_seed(32);
    let mut seen = 0;
    for _ in 0..2_000 {
        let center = vec3(&mut random) * 1e6;
        let world = World::new(vec![Quadric::sphere(1.0).into()], vec![place(0, Affine3::from_translation(center))]);
        let scene = Scene::<ExactHalfOpen<f32>>::new(world.unwrap());
        let towards = vec3(&mut random).normalize_or(Vec3::X);
        let ray = Ray::new(center - towards * 3.0, towards);
        let hit: Hit<f32> = scene.hit(&ray);
        if !hit.mask {
            continue;
        }
        let surface = scene.surface(&ray, &hit);
        for (side, outside) in [(1.0, true), (-1.0, false)] {
            let start = surface.spawn(surface.normal * side).origin;
            let from_center = (start.as_dvec3() - center.as_dvec3()).length();
            assert_eq!(from_center > 1.0, outside, "{ray:?} {surface:?} {from_center}");
            assert!((from_center - 1.0).abs() < 0.3, "{ray:?} {surface:?} {from_center}");
        }
        seen += 1;
    }
    assert!(seen > 1_900, "{seen}");
}
