//! Exact answers in 128 bits, for rays and shapes whose numbers are not too different.
//!
//! The coordinates of ray and shape become whole numbers, in units of their last digit. Where these have too many bits,
//! there is no answer. It knows nothing of the kernels.

use glam::Vec3;

use super::int3::{cross, dot, minus};
use crate::geom::{Aabb, Ray, Triangle};

/// The exact answer for one ray and one shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Decision {
    /// Whether the closed shape is hit.
    pub hit: bool,
    /// Whether an equality decides. Never set for a miss.
    pub boundary: bool,
}

const MISS: Decision = Decision { hit: false, boundary: false };

/// Most bits of a coordinate. The product of two differences of such numbers has at most 126.
const BITS: i32 = 62;

/// Whole numbers in the ratio of these numbers. `None` if they need more than [`BITS`] bits, or if one is not finite.
fn whole<const N: usize>(vectors: [Vec3; N]) -> Option<[[i128; 3]; N]> {
    let all = || vectors.iter().flat_map(Vec3::to_array);
    if !all().all(f32::is_finite) {
        return None;
    }
    // Without their trailing zeros.
    let exponents = all().filter(|x| *x != 0.0).map(|x| {
        let (digits, exponent) = parts(x);
        exponent + digits.trailing_zeros() as i32
    });
    let unit = exponents.min().unwrap_or(0);
    let number = |x: f32| {
        let (digits, exponent) = parts(x);
        let shift = exponent - unit;
        let bits = 32 - digits.leading_zeros() as i32 + shift;
        if digits == 0 {
            return Some(0);
        }
        if bits > BITS {
            return None;
        }
        let size = if shift < 0 { i128::from(digits) >> -shift } else { i128::from(digits) << shift };
        Some(if x < 0.0 { -size } else { size })
    };
    let mut numbers = [[0; 3]; N];
    for (to, from) in numbers.iter_mut().zip(vectors) {
        for axis in 0..3 {
            to[axis] = number(from[axis])?;
        }
    }
    Some(numbers)
}

/// `|x|` as digits, times two to the power of the exponent.
fn parts(x: f32) -> (u32, i32) {
    let (exponent, digits) = (x.to_bits() >> 23 & 0xff, x.to_bits() & 0x7f_ffff);
    if exponent == 0 { (digits, -149) } else { (digits | 0x80_0000, exponent as i32 - 150) }
}

/// The most bits of any component.
fn bits(vectors: &[[i128; 3]]) -> u32 {
    128 - vectors.as_flattened().iter().fold(0, |all, x| all | x.unsigned_abs()).leading_zeros()
}

/// Whether the interval starts at 0. `None` if it neither starts at 0 nor is without a start, or if it has an end.
fn starts_at_zero(ray: &Ray<f32>) -> Option<bool> {
    (ray.t_max == f32::INFINITY && (ray.t_min == 0.0 || ray.t_min == f32::NEG_INFINITY)).then_some(ray.t_min == 0.0)
}

/// Whether a ray hits a triangle, exactly. `None` if the answer needs more than 128 bits, or if the ray's interval has
/// an end or a start other than 0.
pub fn decide(ray: &Ray<f32>, triangle: &Triangle) -> Option<Decision> {
    let starts = starts_at_zero(ray)?;
    let [v0, v1, v2] = triangle.vertices();
    let [origin, v0, v1, v2] = whole([ray.origin, v0, v1, v2])?;
    // The length of the direction does not matter.
    let [dir] = whole([ray.dir])?;
    let (e1, e2, s) = (minus(v1, v0), minus(v2, v0), minus(origin, v0));
    // The sign of t does not change if the edges are divided by a power of two.
    let zeros = e1.iter().chain(&e2).fold(0, |all, x| all | x).trailing_zeros().min(BITS as u32);
    let reduced = [e1, e2].map(|edge| edge.map(|x| x >> zeros));
    let (e, d, s_bits, r) = (bits(&[e1, e2]), bits(&[dir]), bits(&[s]), bits(&reduced));
    // A determinant is the sum of six products, and three determinants are added.
    if (e.max(s_bits) + d + e).max(2 * r + s_bits) > 122 {
        return None;
    }
    let p = cross(dir, e2);
    let det = dot(e1, p);
    if det == 0 {
        return Some(MISS);
    }
    // Negates the determinants if `det` is negative. Each then has the sign of its quantity.
    let facing = det.signum();
    let (u, q) = (facing * dot(s, p), cross(s, e1));
    let v = facing * dot(dir, q);
    let t = if starts { facing * dot(reduced[1], cross(s, reduced[0])) } else { 1 };
    let signs = [u, v, facing * det - u - v, t];
    let hit = signs.iter().all(|sign| *sign >= 0);
    Some(Decision { hit, boundary: hit && signs.contains(&0) })
}

/// Whether a ray hits a box, exactly. `None` as in [`decide`].
pub(super) fn hits_box(ray: &Ray<f32>, Aabb { lo, hi }: &Aabb) -> Option<bool> {
    let starts = starts_at_zero(ray)?;
    let [origin, lo, hi] = whole([ray.origin, *lo, *hi])?;
    let [dir] = whole([ray.dir])?;
    // Quotients with positive denominators.
    let at_most = |[a, b]: [i128; 2], [c, d]: [i128; 2]| a * d <= c * b;
    let (mut entries, mut exits) = (Vec::from_iter(starts.then_some([0, 1])), Vec::new());
    for axis in 0..3 {
        let planes = [lo[axis] - origin[axis], hi[axis] - origin[axis]];
        if lo[axis] > hi[axis] || dir[axis] == 0 && !(planes[0] <= 0 && planes[1] >= 0) {
            return Some(false);
        }
        if dir[axis] != 0 {
            let [low, high] = planes.map(|plane| [plane * dir[axis].signum(), dir[axis].abs()]);
            let [entry, exit] = if dir[axis] > 0 { [low, high] } else { [high, low] };
            entries.push(entry);
            exits.push(exit);
        }
    }
    Some(!exits.is_empty() && entries.iter().all(|entry| exits.iter().all(|exit| at_most(*entry, *exit))))
}
