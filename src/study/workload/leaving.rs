//! Rays that start on a triangle and leave it. They hit it only if a kernel gets the sign of `t` wrong.

use glam::Vec3;
use rand::RngExt;
use rand_pcg::Pcg64;

use super::triangle::{inside, moved, regular};
use super::{RAYS_PER_SAMPLE, Sample, direction, frame, in_cube, sign};
use crate::geom::{Ray, Triangle};

/// A direction on the side of `normal`, with the cosine distribution.
fn away(normal: Vec3, rng: &mut Pcg64) -> Vec3 {
    (normal + direction(rng)).normalize_or(normal)
}

/// Rays that start `ulps` off a triangle, in ulp of their largest coordinate.
pub(super) fn off_surface(ulps: f32, rng: &mut Pcg64) -> Sample<Triangle> {
    let plane = frame(rng);
    let shape = moved(&regular(plane, rng.random_range(0.5..4.0), rng), in_cube(rng, 1.0));
    Sample::of(shape, rng, |shape, rng| {
        let normal = plane.z_axis * sign(rng);
        let point = inside(shape, rng);
        let largest = point.abs().max_element();
        let ulp = largest.next_up() - largest;
        Ray::new(point + normal * (ulps * ulp), away(normal, rng))
    })
}

/// Coordinates on the lattice are whole numbers up to about this.
const REACH: i64 = 1 << 21;

type Int3 = [i128; 3];

fn dot(a: Int3, b: Int3) -> i128 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Int3, b: Int3) -> Int3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `a·factor + b`.
fn combined(a: Int3, factor: i128, b: Int3) -> Int3 {
    [0, 1, 2].map(|axis| a[axis] * factor + b[axis])
}

/// The greatest common divisor, and a factor of each number: the products with them add up to it.
fn bezout(a: i128, b: i128) -> (i128, i128, i128) {
    if b == 0 {
        return (a, 1, 0);
    }
    let (divisor, x, y) = bezout(b, a % b);
    (divisor, y, x - a / b * y)
}

/// A whole `s` with `n·s = 1`. `None` if the components of `n` have a common divisor, or if one is zero.
fn unit_step(n: Int3) -> Option<Int3> {
    let (xy, x, _) = bezout(n[0], n[1]);
    let (all, w, z) = bezout(xy, n[2]);
    if n.contains(&0) || all.abs() != 1 {
        return None;
    }
    // Any multiple of n[1] / xy may be added to x, so it can stay small.
    let x = (x * w * all).rem_euclid((n[1] / xy).abs());
    let z = z * all;
    Some([x, (1 - n[2] * z - n[0] * x) / n[1], z])
}

/// Rays that start on a lattice, at the points next to the plane of a triangle. The distance is a few times `1/|n|`,
/// where `n` is the normal in whole numbers. `f64` cannot tell it from zero.
pub(super) fn next_to_lattice_plane(rng: &mut Pcg64) -> Sample<Triangle> {
    let whole = |rng: &mut Pcg64| [0; 3].map(|_| i128::from(rng.random_range(-REACH..=REACH)));
    let (e1, e2, n, step) = loop {
        let (e1, e2) = (whole(rng), whole(rng));
        let n = cross(e1, e2);
        if let Some(step) = unit_step(n) {
            break (e1, e2, n, step);
        }
    };
    let v0 = whole(rng);
    // Small numbers are exact in f32. So is a product with a power of two.
    let float = |v: Int3| Vec3::from(v.map(|x| x as f32)) / REACH as f32;
    let point = |v: Int3| float(combined(v, 1, v0));
    let rays = (0..RAYS_PER_SAMPLE as i128).map(|index| {
        // From 1 to 8 steps off the plane, then moved along the edges into the parallelogram.
        let steps = index / 2 + 1;
        let far = combined(step, steps, [0; 3]);
        let along = |gradient: Int3| -dot(far, gradient).div_euclid(dot(n, n));
        let inside = combined(e1, along(cross(e2, n)), combined(e2, along(cross(n, e1)), far));
        // Turning the parallelogram by half changes the side. One of two points is in the triangle.
        let turned = combined(inside, -1, combined(e1, 1, e2));
        let (start, side) = if index % 2 == 0 { (inside, 1.0) } else { (turned, -1.0) };
        let normal = Vec3::from(n.map(|x| x as f32)).normalize() * side;
        Ray::new(point(start), away(normal, rng))
    });
    let rays = rays.collect();
    Sample { shapes: vec![Triangle { v0: float(v0), v1: point(e1), v2: point(e2) }], rays }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oracle::Exact;
    use crate::study::workload::rng;

    #[test]
    fn rays_from_the_lattice_start_where_only_exact_numbers_tell_the_side() {
        let (mut behind, mut sure) = (0, 0);
        for index in 0..200 {
            let sample = next_to_lattice_plane(&mut rng(1, "triangle", "lattice", &[], index));
            for ray in &sample.rays {
                let line = Ray { t_min: f32::NEG_INFINITY, ..*ray };
                let truth = sample.shapes[0].truth(&line);
                assert!(!truth.hit || truth.t < 0.0, "{ray:?} {truth:?}");
                behind += u32::from(truth.hit);
                sure += u32::from(sample.shapes[0].truth_filtered(ray).is_some() & truth.hit);
            }
        }
        // The other half passes beside the triangle.
        assert!((1_500..1_700).contains(&behind), "{behind} rays leave the triangle");
        assert_eq!(sure, 0, "f64 tells the side");
    }
}
