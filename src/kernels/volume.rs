//! Signed volumes with signs that are always right, and where a ray meets the plane of a triangle.
//!
//! **Source:** J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates",
//! 1997. T. J. Dekker, "A Floating-Point Technique for Extending the Available Precision", 1971.
//!
//! **Idea:** a volume is computed in `f64`. Where the error bound does not tell enough about it, it is computed again
//! as an exact sum. `f64` holds each of its terms exactly.
//!
//! Both twins call these functions lane by lane, so they agree. They are for the few lanes in which `f32` does not tell
//! a sign.

use glam::{DVec3, Vec3};

/// The `t` of a ray and the plane through three points. It is negative exactly if the plane is behind the ray, and it
/// is 0 if the ray starts on the plane. It is infinite or NaN if the ray is parallel to the plane.
///
/// All numbers must be finite. No intermediate number overflows or underflows.
#[inline(always)]
pub(super) fn plane_t(vertices: [Vec3; 3], origin: Vec3, dir: Vec3) -> f32 {
    let vertices = vertices.map(Vec3::as_dvec3);
    let (origin, dir, [v0, ..]) = (origin.as_dvec3(), dir.as_dvec3(), vertices);
    let num = volume(&vertices, v0 - origin, &[v0, -origin]);
    let den = volume(&vertices, dir, &[dir]);
    let t = num / den;
    // A small negative t must not become a zero. A zero has no sign.
    if (t < 0.0) & (t as f32 == 0.0) { -f32::from_bits(1) } else { (t + 0.0) as f32 }
}

/// `((p1 - p0) × (p2 - p0)) · v` with the right sign and a relative error of at most 2⁻²⁰. All components of the points
/// must be `f32` numbers, and so must those of `exact`. `v` is the rounded sum of `exact`.
#[inline(always)]
pub(super) fn volume(points: &[DVec3; 3], v: DVec3, exact: &[DVec3]) -> f64 {
    // Each of at most 8 roundings changes a product by 2⁻⁵³. Twice that also covers the rounding of the bound.
    const BOUND: f64 = 8.0 * f64::EPSILON;
    const RELATIVE: f64 = 1.0 / (1 << 20) as f64;
    let [p0, p1, p2] = *points;
    let (e1, e2) = (p1 - p0, p2 - p0);
    let value = e1.cross(e2).dot(v);
    let (a, b, c) = (e1.abs(), e2.abs(), v.abs());
    let products = (a.y * b.z + a.z * b.y) * c.x + (a.z * b.x + a.x * b.z) * c.y + (a.x * b.y + a.y * b.x) * c.z;
    // Without products, the volume is exactly zero.
    if (value.abs() > BOUND / RELATIVE * products) | (products == 0.0) { value } else { unsure(value, points, exact) }
}

/// [`volume`], where the bound does not tell enough about `value`.
#[cold]
#[inline(never)]
fn unsure(value: f64, points: &[DVec3; 3], exact: &[DVec3]) -> f64 {
    // Differences have 16 bits, the normal 33, and the sum of three products 51. So `f64` rounded nothing. That decides
    // most exact ties: they are between numbers of few digits.
    if have_few_digits(points) && have_few_digits(exact) { value } else { exact_volume(points, exact) }
}

/// Whether all components are multiples of one number, by less than 2¹⁵.
fn have_few_digits(vectors: &[DVec3]) -> bool {
    let largest = vectors.iter().fold(0.0, |largest: f64, v| largest.max(v.abs().max_element()));
    // In a sum with this number, digits below `largest`·2⁻¹⁴ are rounded away.
    let coarse = DVec3::splat(largest * (1u64 << 39) as f64);
    vectors.iter().all(|v| (*v + coarse) - coarse == *v)
}

/// [`volume`], rounded once. The normal is `p0 × p1 + p1 × p2 + p2 × p0`, and its components are exact sums too.
fn exact_volume(&[p0, p1, p2]: &[DVec3; 3], exact: &[DVec3]) -> f64 {
    let normal = [(1, 2), (2, 0), (0, 1)].map(|(j, k)| {
        let mut component = ExactSum::<6>::ZERO;
        for (p, q) in [(p0, p1), (p1, p2), (p2, p0)] {
            component.add(p[j] * q[k]);
            component.add(-p[k] * q[j]);
        }
        component
    });
    let mut sum = ExactSum::<{ 2 * 3 * 6 * 2 }>::ZERO;
    for v in exact {
        for (component, v) in normal.iter().zip(v.to_array()) {
            component.parts[..component.len].iter().for_each(|part| sum.add_product(*part, v));
        }
    }
    sum.rounded()
}

/// A sum of at most `N` terms without rounding errors: numbers that do not overlap, from the smallest to the largest.
pub(super) struct ExactSum<const N: usize> {
    parts: [f64; N],
    len: usize,
}

impl<const N: usize> ExactSum<N> {
    pub(super) const ZERO: Self = Self { parts: [0.0; N], len: 0 };

    pub(super) fn add(&mut self, term: f64) {
        let (mut sum, mut kept) = (term, 0);
        for index in 0..self.len {
            let part = self.parts[index];
            let rounded = sum + part;
            // What the rounding lost, exactly, whichever of the two is larger.
            let shared = rounded - sum;
            let lost = (sum - (rounded - shared)) + (part - shared);
            sum = rounded;
            if lost != 0.0 {
                self.parts[kept] = lost;
                kept += 1;
            }
        }
        if sum != 0.0 {
            self.parts[kept] = sum;
            kept += 1;
        }
        self.len = kept;
    }

    /// Adds `a·b`, where `b` is an `f32` number. The halves of `a` times `b` have 50 bits.
    fn add_product(&mut self, a: f64, b: f64) {
        /// 2²⁷ + 1: cuts a number into two halves of 26 bits.
        const SPLITTER: f64 = 134_217_729.0;
        let scaled = a * SPLITTER;
        let high = scaled - (scaled - a);
        self.add(high * b);
        self.add((a - high) * b);
    }

    /// The largest part decides the sign.
    pub(super) fn rounded(&self) -> f64 {
        self.parts[..self.len].iter().sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whole numbers of 24 bits, and points of the lattice next to the plane.
    #[test]
    fn a_point_beside_a_plane_is_on_the_right_side() {
        let points: [[i64; 3]; 3] = [[9_999_991, 17, -5], [-3, 9_999_973, 11], [7, -13, 9_999_943]];
        let minus = |a: [i64; 3], b: [i64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]].map(i128::from);
        let (e1, e2) = (minus(points[1], points[0]), minus(points[2], points[0]));
        let n = [e1[1] * e2[2] - e1[2] * e2[1], e1[2] * e2[0] - e1[0] * e2[2], e1[0] * e2[1] - e1[1] * e2[0]];
        let float = |p: [i64; 3]| Vec3::from(p.map(|x| x as f32));
        let vertices = points.map(float);
        let mut near = 0;
        for x in (-3_000_000..3_000_000).step_by(1009) {
            for y in [-2_000_003, -17, 0, 1, 1_234_567] {
                let rest = n[0] * i128::from(x - points[0][0]) + n[1] * i128::from(y - points[0][1]);
                let z = (i128::from(points[0][2]) - rest.div_euclid(n[2])) as i64;
                for z in z - 1..=z + 1 {
                    let exact = rest + n[2] * i128::from(z - points[0][2]);
                    let origin = float([x, y, z]);
                    let t = plane_t(vertices, origin, Vec3::Z);
                    assert_eq!(t.partial_cmp(&0.0), 0.partial_cmp(&(exact * n[2].signum())), "{origin}: {exact}");
                    near += 1;
                }
            }
        }
        assert!(near > 80_000, "{near} points");
    }

    /// The determinant of these vectors is 1, which `f64` does not find.
    #[test]
    fn a_determinant_that_f64_loses_is_exact() {
        let [e1, e2] = [Vec3::new(228_425.0, -221_513.0, 89_431.0), Vec3::new(173_414.0, 249_585.0, 254_038.0)];
        let origin = Vec3::new(136_534.0, 158_240.0, 182_961.0);
        let [v0, v1, v2, o] = [Vec3::ZERO, e1, e2, origin].map(Vec3::as_dvec3);
        assert_ne!(v1.cross(v2).dot(o), 1.0);
        assert_eq!(volume(&[v0, v1, v2], -o, &[v0, -o]), -1.0);
        assert!(plane_t([Vec3::ZERO, e1, e2], origin, Vec3::new(-1.0, -1.0, 1.0)) < 0.0);
    }

    #[test]
    fn fourteen_digits_are_few() {
        let most = f64::from((1 << 14) - 1);
        for scale in [-130, 0, 100].map(|exponent| 2f64.powi(exponent)) {
            assert!(have_few_digits(&[DVec3::new(most, -most, 1.0) * scale, DVec3::new(0.0, 1.0, -1.0) * scale]));
            assert!(!have_few_digits(&[DVec3::new(4.0 * most, 0.0, 0.0) * scale, DVec3::X * scale]));
        }
        assert!(have_few_digits(&[DVec3::ZERO]));
    }

    #[test]
    fn ends_of_the_range_keep_their_signs() {
        for scale in [1e-45, 1e-30, 1.0, 1e30] {
            let vertices = [Vec3::ZERO, Vec3::X, Vec3::Y].map(|v| v * scale);
            for z in [1.0, -1.0] {
                // Of the smallest size, t is too small for f32.
                let t = plane_t(vertices, Vec3::new(0.0, 0.0, z * scale), Vec3::Z * 1e8);
                assert_eq!(t < 0.0, z > 0.0, "{scale}: {t}");
            }
            assert_eq!(plane_t(vertices, Vec3::ZERO, -Vec3::Z).to_bits(), 0);
            assert!(!plane_t(vertices, -Vec3::Z, Vec3::X).is_finite());
        }
    }
}
