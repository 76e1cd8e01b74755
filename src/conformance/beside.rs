//! Rays that pass the edges of random triangles ever closer, and rays that leave a triangle.

use super::counts::Counts;
use super::exact::decide;
use super::random::Random;
use super::triangles::describe;
use super::twins::hit8;
use super::{Options, threads};
use crate::geom::{Ray, Triangle};
use crate::kernels::{Claim, Kernel};
use glam::{DVec3, Vec3};

/// A random triangle, and sixteen rays that pass beside its edges and vertices, at all distances down to zero.
///
/// Triangles are of all sizes and shapes. The rays aim at points beside an edge or a vertex, from far away or from
/// close by, steeply or grazing. Rounding moves them by about 1e-7 of their coordinates.
pub fn beside_edges(seed: u64) -> (Triangle, [Ray<f32>; 16]) {
    let mut random = Random::from_seed(seed << 20);
    let triangle = triangle(&mut random);
    (triangle, [(); 16].map(|()| beside_an_edge(&triangle, &mut random)))
}

/// Counts how often a kernel decides wrongly beside edges, or hits a triangle behind the start of the ray. Rays whose
/// exact answer needs more than 128 bits are not counted.
pub(super) fn count<K: Kernel<Shape = Triangle>>(options: &Options) -> Counts {
    let triangles = if options.exhaustive { 12_000 } else { 4_000 };
    let seeds: Vec<_> = (0..triangles).map(|index| options.seed_of(index)).collect();
    threads::sum(&seeds, |&seed| {
        let (triangle, rays) = beside_edges(seed);
        let (leaving, rays_leaving) = leaving(seed);
        decisions::<K>(&triangle, &rays).plus(decisions::<K>(&leaving, &rays_leaving))
    })
}

fn decisions<K: Kernel<Shape = Triangle>>(triangle: &Triangle, rays: &[Ray<f32>; 16]) -> Counts {
    let mut counts = Counts::default();
    let prepared = K::prepare(triangle);
    for rays in rays.as_chunks().0 {
        let mask = hit8(&prepared, &Ray::from_lanes(rays)).mask;
        for (lane, ray) in rays.iter().enumerate() {
            let Some(truth) = decide(ray, triangle) else { continue };
            let hit = mask.lane(lane);
            let mut add = |claim, broken: bool| {
                counts.add(claim, 1, broken.into(), || describe(ray, &[(0, *triangle, hit)]));
            };
            add(Claim::RightDecision, !truth.boundary & (hit != truth.hit));
            let line = Ray { t_min: f32::NEG_INFINITY, ..*ray };
            if !truth.hit && decide(&line, triangle).is_some_and(|truth| truth.hit) {
                add(Claim::NoHitBehind, hit);
            }
        }
    }
    counts
}

fn vector(random: &mut Random) -> DVec3 {
    DVec3::new(random.signed(), random.signed(), random.signed())
}

/// `10^-x` with `x` in 0..greatest, of either sign.
fn small(greatest: f64, random: &mut Random) -> f64 {
    10f64.powf(-greatest * random.signed().abs()) * random.signed().signum()
}

/// Of a size from 1e-19 to 1e19, but mostly about 1; somewhere, but mostly near the origin; one in four a sliver. Half
/// of them have few digits, so rays meet edges exactly.
fn triangle(random: &mut Random) -> Triangle {
    let unit = if random.below(4) == 0 { 10f64.powf(19.0 * random.signed()) } else { 1.0 };
    let place = vector(random) / small(if random.below(4) == 0 { 6.0 } else { 0.5 }, random);
    let (v0, e1, mut e2) = (place, vector(random), vector(random));
    if random.below(4) == 0 {
        e2 = e1 * random.signed() + e2 * small(7.0, random);
    }
    let coarse = random.below(2) == 0;
    let point = |p: DVec3| {
        let p = if coarse { (p * 64.0).round() / 64.0 } else { p };
        (p * unit).as_vec3()
    };
    Triangle { v0: point(v0), v1: point(v0 + e1), v2: point(v0 + e2) }
}

/// A ray at a point on an edge, or beside it by 1e-12 to 1 of the triangle's size. One in sixteen starts there.
fn beside_an_edge(triangle: &Triangle, random: &mut Random) -> Ray<f32> {
    let [v0, v1, v2] = triangle.vertices().map(Vec3::as_dvec3);
    let along = if random.below(4) == 0 { random.below(2) as f64 } else { random.below(16) as f64 / 16.0 };
    let beside = if random.below(4) == 0 { 0.0 } else { small(12.0, random) };
    let (u, v) = match random.below(3) {
        0 => (along, beside),
        1 => (beside, along),
        _ => (along, 1.0 - along - beside),
    };
    let target = v0 + (v1 - v0) * u + (v2 - v0) * v;
    let size = (v1 - v0).length().max((v2 - v0).length());
    let distance = size / small(3.0, random).abs() * if random.below(16) == 0 { 1e-6 } else { 1.0 };
    let mut way = vector(random).normalize();
    if random.below(4) == 0 {
        let normal = (v1 - v0).cross(v2 - v0).normalize_or_zero();
        way -= normal * way.dot(normal) * (1.0 - small(7.0, random));
    }
    let origin = (target - way * distance).as_vec3();
    // The length of the direction does not matter. It is 1e-3 to 1e3, or the way to the target.
    let dir =
        (target - origin.as_dvec3()) / if random.below(2) == 0 { 1.0 } else { distance * small(3.0, random).abs() };
    Ray::new(origin, dir.as_vec3())
}

/// A random triangle of about unit size, and sixteen rays that start within a few ulp of it and leave. All numbers have
/// few digits.
fn leaving(seed: u64) -> (Triangle, [Ray<f32>; 16]) {
    let mut random = Random::from_seed(!seed << 20);
    let snapped = |point: DVec3| ((point * f64::from(1 << 24)).round() / f64::from(1 << 24)).as_vec3();
    let triangle = {
        let mut vertex = || snapped(vector(&mut random));
        Triangle { v0: vertex(), v1: vertex(), v2: vertex() }
    };
    let [v0, v1, v2] = triangle.vertices().map(Vec3::as_dvec3);
    let normal = (v1 - v0).cross(v2 - v0).normalize_or_zero();
    let rays = [(); 16].map(|()| {
        let (u, v) = (random.signed().abs() * 0.5, random.signed().abs() * 0.5);
        let side = random.signed().signum();
        let off = f64::from(f32::EPSILON) * 2.0 * random.signed().abs();
        let origin = snapped(v0 + (v1 - v0) * u + (v2 - v0) * v + normal * side * off);
        let mut dir = vector(&mut random);
        dir *= (dir.dot(normal) * side).signum();
        Ray::new(origin, snapped(dir))
    });
    (triangle, rays)
}

#[cfg(all(test, feature = "study"))]
mod tests {
    use super::*;
    use crate::oracle::Exact;

    #[test]
    fn answers_in_128_bits_are_those_of_the_oracle() {
        let (mut decided, mut on_boundary, mut behind) = ([0; 2], 0, 0);
        for seed in 0..12_000 {
            for (index, (triangle, rays)) in [beside_edges(seed), leaving(seed)].into_iter().enumerate() {
                for ray in rays {
                    let line = Ray { t_min: f32::NEG_INFINITY, ..ray };
                    let Some(answers) = decide(&ray, &triangle).zip(decide(&line, &triangle)) else { continue };
                    for (ray, answer) in [(ray, answers.0), (line, answers.1)] {
                        let truth = triangle.truth(&ray);
                        assert_eq!((answer.hit, answer.boundary), (truth.hit, truth.boundary), "{ray:?} {triangle:?}");
                    }
                    decided[index] += 1;
                    on_boundary += u32::from(answers.0.boundary);
                    behind += u32::from(answers.1.hit && !answers.0.hit);
                }
            }
        }
        println!("{decided:?} of 192000 each, {on_boundary} on the boundary, {behind} behind");
        assert!(decided[0] > 100_000 && decided[1] == 192_000, "{decided:?} of 192000 each");
        assert!(on_boundary > 5_000 && behind > 50_000, "{on_boundary} on the boundary, {behind} behind");
    }
}
