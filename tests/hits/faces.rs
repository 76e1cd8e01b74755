//! Discs, and quadrics that discs close, against a solution in `f64`.

use glam::{DVec3, Vec2, Vec3};
use raylanes::conformance::Random;
use raylanes::geom::{Hit, Quadric, Ray};
use raylanes::kernels::triangle::Woop;
use raylanes::tracer::{Disc, Face, Geometry, Mode, Scene, World, occluded, trace};

use crate::worlds::{self, place, unit, vec3};

const MODES: [Mode; 4] = [Mode::Scalar, Mode::Single, Mode::Packet, Mode::Auto];

/// A closed quadric: `x² + y² = squares·z² + linear·z + constant`, between two heights.
#[derive(Clone, Copy)]
struct Solid {
    curve: DVec3,
    heights: [f64; 2],
}

impl Solid {
    /// The way from a point inside along `d` to the surface, and the number of the face there.
    fn exit(&self, p: DVec3, d: DVec3) -> (f64, u32) {
        let Self { curve: DVec3 { x: squares, y: linear, z: constant }, heights } = *self;
        let a = d.x * d.x + d.y * d.y - squares * d.z * d.z;
        let b = p.x * d.x + p.y * d.y - squares * p.z * d.z - linear * d.z / 2.0;
        let c = p.x * p.x + p.y * p.y - squares * p.z * p.z - linear * p.z - constant;
        let root = (b * b - a * c).sqrt();
        let side = [(-b + root) / a, (-b - root) / a].map(|t| (t, 0));
        let ends = heights.map(|height| (height - p.z) / d.z);
        // A cone and a bowl have one disc, at the upper height. The lower one is their tip.
        let numbers = if self.has_two_discs() { [1, 2] } else { [0, 1] };
        let ahead = side.into_iter().chain(ends.into_iter().zip(numbers)).filter(|&(t, _)| t > 0.0);
        ahead.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
    }

    fn has_two_discs(&self) -> bool {
        self.curve.truncate() == glam::DVec2::ZERO
    }

    /// A point inside, not near the surface.
    fn inside(&self, random: &mut Random) -> DVec3 {
        let z = self.heights[0] + (self.heights[1] - self.heights[0]) * f64::from(0.05 + 0.9 * unit(random));
        let radius = self.curve.dot(DVec3::new(z * z, z, 1.0)).sqrt() * 0.9;
        let (sin, cos) = (f64::from(unit(random)) * std::f64::consts::TAU).sin_cos();
        DVec3::new(cos, sin, 0.0) * (radius * f64::from(unit(random))) + DVec3::Z * z
    }
}

/// Lines through the inside cross a closed solid twice, at the right places, on the right faces, in front and behind.
#[test]
fn closed_quadrics_have_an_inside() {
    let solids = [
        (Geometry::closed_cylinder(0.5, 1.0), DVec3::new(0.0, 0.0, 0.25), [-1.0, 1.0]),
        (Geometry::closed_cone(1.0, 2.0), DVec3::new(0.25, 0.0, 0.0), [0.0, 2.0]),
        (Geometry::closed_paraboloid(1.0, 2.0), DVec3::new(0.0, 0.5, 0.0), [0.0, 2.0]),
    ];
    let mut random = Random::from_seed(61);
    let mut faces_met = [0; 3];
    for (geometry, curve, heights) in solids {
        let solid = Solid { curve, heights };
        for _ in 0..60 {
            let transform = worlds::transform(&mut random, 3.0);
            let scene = Scene::<Woop<f32>>::new(World::new(vec![geometry.clone()], vec![place(0, transform)]).unwrap());
            let (linear, translation) = (transform.matrix3.as_dmat3(), transform.translation.as_dvec3());
            let to_object = linear.inverse();
            let rays: Vec<_> = (0..50)
                .map(|_| {
                    let (through, dir) = (solid.inside(&mut random), vec3(&mut random).normalize());
                    let dir = (linear * dir.as_dvec3()).as_vec3();
                    let origin = linear * through + translation - dir.as_dvec3() * 5.0;
                    Ray::new(origin.as_vec3(), dir)
                })
                .collect();
            let closest = trace(&scene, &rays, Mode::Auto);
            for mode in MODES {
                let same = |a: &[Hit<f32>], b: &[Hit<f32>]| a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits());
                assert!(same(&closest, &trace(&scene, &rays, mode)), "{mode:?} {geometry:?} {transform:?}");
                assert!(occluded(&scene, &rays, mode).iter().all(|&hit| hit));
            }
            for (ray, closest) in rays.iter().zip(closest) {
                let (o, d) = (to_object * (ray.origin.as_dvec3() - translation), to_object * ray.dir.as_dvec3());
                let inside = o + d * 5.0;
                // Coordinates far from 0 are coarse: the ray may pass the solid.
                if f64::from(transform.translation.length()) > 100.0 * linear.determinant().abs().cbrt() {
                    continue;
                }
                let ((before, first), (behind, second)) = (solid.exit(inside, -d), solid.exit(inside, d));
                let hits = scene.all_hits(ray);
                let what = || format!("{geometry:?} {transform:?} {ray:?} {hits:?} {before} {behind}");
                assert_eq!(hits.len(), 2, "{}", what());
                assert_eq!(hits[0].to_bits(), closest.to_bits(), "{}", what());
                let near = |t: f32, expected: f64| (f64::from(t) - expected).abs() < 2e-4;
                assert!(near(hits[0].t, 5.0 - before) && near(hits[1].t, 5.0 + behind), "{}", what());
                let at_rim = |t: f64| {
                    let p = inside + d * t;
                    heights.iter().any(|height| (p.z - height).abs() < 1e-3)
                        && (solid.curve.dot(DVec3::new(p.z * p.z, p.z, 1.0)).sqrt() - p.truncate().length()).abs()
                            < 1e-3
                };
                for (hit, t, face, front) in [(hits[0], -before, first, true), (hits[1], behind, second, false)] {
                    if !at_rim(t) {
                        assert_eq!((hit.primitive, scene.is_front(ray, &hit)), (face, front), "{}", what());
                        faces_met[face as usize] += 1;
                    }
                }
            }
        }
    }
    assert!(faces_met.iter().all(|&count| count > 200), "{faces_met:?}");
}

/// The circle is decided exactly where the numbers are exact. It belongs to the disc.
#[test]
fn a_disc_ends_at_its_circle() {
    for (height, faces_down) in [(0.0, false), (2.0, true), (-3e6, false)] {
        let geometry = Geometry::Faces(vec![Face::Disc(Disc { radius: 5.0, height, faces_down })]);
        let world = World::new(vec![geometry], vec![place(0, glam::Affine3::IDENTITY)]).unwrap();
        let scene = Scene::<Woop<f32>>::new(world);
        let normal = if faces_down { Vec3::NEG_Z } else { Vec3::Z };
        for (at, inside) in [
            (Vec2::new(3.0, 4.0), true),
            (Vec2::new(3.0, 4f32.next_up()), false),
            (Vec2::new(3f32.next_down(), 4.0), true),
            (Vec2::new(0.0, -5.0), true),
            (Vec2::new((-5f32).next_down(), 0.0), false),
            (Vec2::new(3.6, 3.6), false),
        ] {
            for side in [-1.0, 1.0] {
                for slope in [0.0, 0.5] {
                    let dir = Vec3::new(slope, 0.0, -side);
                    let origin = Vec3::new(at.x - slope * 8.0, at.y, height + side * 8.0);
                    let exact = (origin.x + slope * 8.0, origin.z - side * 8.0) == (at.x, height);
                    let ray = Ray::new(origin, dir);
                    for mode in MODES {
                        let hit = trace(&scene, &[ray], mode)[0];
                        if exact {
                            assert_eq!(hit.mask, inside, "{ray:?} {mode:?}");
                        }
                        if hit.mask {
                            let surface = scene.surface(&ray, &hit);
                            assert_eq!((hit.t, surface.normal), (8.0, normal), "{ray:?}");
                            let uv = (surface.uv - (at / 5.0 + 1.0) / 2.0).abs();
                            assert!(uv.max_element() < 1e-3, "{ray:?} {surface:?}");
                        }
                    }
                }
            }
        }
        let along = Ray::new(Vec3::new(-9.0, 0.0, height), Vec3::X);
        assert!(!trace(&scene, &[along], Mode::Scalar)[0].mask, "in the plane");
    }
}

/// Both twins decide the circle alike, for rays of all magnitudes.
#[test]
fn a_disc_is_the_same_in_every_mode() {
    let mut random = Random::from_seed(62);
    for radius in [1e-30, 1e-3, 1.0, 1e12] {
        let world = World::new(vec![Geometry::disc(radius)], vec![place(0, glam::Affine3::IDENTITY)]).unwrap();
        let scene = Scene::<Woop<f32>>::new(world);
        let rays: Vec<_> = (0..4000)
            .map(|_| {
                let at = vec3(&mut random).truncate().normalize() * radius;
                let dir = vec3(&mut random) * radius;
                Ray::new(at.extend(0.0) - dir * worlds::pick(&mut random, &[0.5, 1.0, 30.0]), dir)
            })
            .collect();
        let expected: Vec<_> = rays.iter().map(|ray| scene.closest_hit_brute_force(ray).to_bits()).collect();
        let hits = expected.iter().filter(|bits| **bits != Hit::MISS.to_bits()).count();
        assert!((1000..3500).contains(&hits), "{hits}");
        for mode in MODES {
            for (hit, expected) in trace(&scene, &rays, mode).iter().zip(&expected) {
                assert_eq!(hit.to_bits(), *expected, "{radius} {mode:?}");
            }
        }
    }
}

/// A face that no ray hits is refused.
#[test]
fn faces_that_no_ray_hits_are_refused() {
    let disc = |radius, height| Geometry::Faces(vec![Face::Disc(Disc { radius, height, faces_down: false })]);
    let bad = [disc(0.0, 0.0), disc(-1.0, 0.0), disc(f32::NAN, 0.0), disc(1.0, f32::INFINITY), disc(1.0, f32::NAN)];
    let twice = Geometry::Faces(vec![Face::Quadric(Quadric::sphere(1.0)), Face::Quadric(Quadric::sphere(f32::NAN))]);
    for geometry in bad.into_iter().chain([Geometry::Faces(Vec::new()), twice]) {
        let error = World::new(vec![geometry.clone()], vec![place(0, glam::Affine3::IDENTITY)]).unwrap_err();
        assert!(error.to_string().contains("no ray hits"), "{geometry:?}: {error}");
    }
}
