//! Lane types, and every operation whose scalar and packet meaning could drift apart, as a tested pair.
//!
//! `+ - * /`, negation and comparisons mean the same for `f32` and `f32x8` on every target, so kernels use them
//! directly. What follows is the rest: minimum and maximum (`f32::min`, `f32x8::min` and `f32x8::fast_min` disagree on
//! signed zeros and NaN), sign tests (`x < 0` misses `-0`), and selection, which is only defined for comparison masks
//! and therefore goes through [`Mask8`]. There is deliberately no reciprocal (`f32x8::recip` has 12 bits; write
//! `1.0 / x`). `f32x8::mul_add` fuses only where the build enables FMA, so `mul_add` and `mul_add8` exist only there
//! (`cfg(fused)`, set by the build script): a kernel that needs them is absent elsewhere, and none has two meanings.

use core::fmt::Debug;
use core::ops::{Add, BitAnd, BitOr, Mul, Neg, Not, Sub};

use glam::Vec3;
use wide::{f32x4, f32x8, f64x2, f64x8, u32x8};

use super::Hit;

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for wide::f32x8 {}
}

/// What a ray, a hit or a prepared primitive is made of: `f32` (one) or `f32x8` (eight, as structure of arrays).
pub trait Lanes: sealed::Sealed + Copy + Debug + PartialEq + Send + Sync + 'static {
    /// Three-dimensional vector: [`glam::Vec3`] or [`Vec3x8`].
    type Vec3: Copy + Debug + PartialEq + Send + Sync + 'static;
    /// Outcome of a comparison: `bool` or [`Mask8`].
    type Mask: Copy + Debug + PartialEq + Send + Sync + 'static;
    /// Primitive numbers: `u32` or `u32x8`.
    type Index: Copy + Debug + PartialEq + Send + Sync + 'static;

    /// Eight lanes holding this value; eight lanes stay as they are.
    fn widen(self) -> f32x8;
    /// [`Lanes::widen`] for each component. Kernels call it for each vector by name: through `array::map` it remains a call
    /// in builds without link-time optimisation, which doubles the time of eight rays against one triangle.
    fn widen_vec3(vector: Self::Vec3) -> Vec3x8;
    /// [`Hit::MISS`] in the lanes of eight that miss; a single hit stays as it is.
    fn or_miss(hit: Hit<Self>) -> Hit<Self>;
}

impl Lanes for f32 {
    type Vec3 = Vec3;
    type Mask = bool;
    type Index = u32;

    #[inline(always)]
    fn widen(self) -> f32x8 {
        f32x8::splat(self)
    }

    #[inline(always)]
    fn widen_vec3(vector: Vec3) -> Vec3x8 {
        Vec3x8::splat(vector)
    }

    #[inline(always)]
    fn or_miss(hit: Hit<Self>) -> Hit<Self> {
        hit
    }
}

impl Lanes for f32x8 {
    type Vec3 = Vec3x8;
    type Mask = Mask8;
    type Index = u32x8;

    #[inline(always)]
    fn widen(self) -> f32x8 {
        self
    }

    #[inline(always)]
    fn widen_vec3(vector: Vec3x8) -> Vec3x8 {
        vector
    }

    #[inline(always)]
    fn or_miss(hit: Hit<Self>) -> Hit<Self> {
        hit.or_miss()
    }
}

/// Eight comparison outcomes. It can only be made by comparing, so selecting with it is well defined on every target.
#[derive(Clone, Copy, Debug)]
pub struct Mask8(f32x8);

impl Mask8 {
    /// No lane.
    #[inline(always)]
    pub fn none() -> Self {
        // What a comparison gives that holds nowhere. The compiler knows this constant, but looks into no comparison.
        Self(f32x8::ZERO)
    }

    /// Every lane.
    #[inline(always)]
    pub fn all_lanes() -> Self {
        le8(f32x8::ZERO, f32x8::ZERO)
    }

    /// Lane `i` is set where `lanes[i]` is.
    #[inline]
    pub fn from_lanes(lanes: [bool; 8]) -> Self {
        ne8(f32x8::new(lanes.map(|lane| f32::from(u8::from(lane)))), f32x8::ZERO)
    }

    /// Bit `i` is lane `i`; the upper 24 bits are zero.
    #[inline(always)]
    pub fn bits(self) -> u32 {
        self.0.to_bitmask()
    }

    /// Whether lane `index` is set.
    ///
    /// # Panics
    /// If `index >= 8`.
    #[inline(always)]
    pub fn lane(self, index: usize) -> bool {
        assert!(index < 8, "a mask has 8 lanes, asked for {index}");
        self.bits() >> index & 1 == 1
    }

    /// Whether any lane is set.
    #[inline(always)]
    pub fn any(self) -> bool {
        self.bits() != 0
    }

    /// Whether all eight lanes are set.
    #[inline(always)]
    pub fn all(self) -> bool {
        self.bits() == 0xff
    }

    /// `if lane { if_set } else { if_clear }`, lane by lane.
    #[inline(always)]
    pub fn select(self, if_set: f32x8, if_clear: f32x8) -> f32x8 {
        self.0.select(if_set, if_clear)
    }

    /// [`Mask8::select`] for whole numbers.
    #[inline(always)]
    pub fn select_u32(self, if_set: u32x8, if_clear: u32x8) -> u32x8 {
        f32x8::to_bits(self.0.select(f32x8::from_bits(if_set), f32x8::from_bits(if_clear)))
    }
}

impl PartialEq for Mask8 {
    fn eq(&self, other: &Self) -> bool {
        self.bits() == other.bits()
    }
}

impl BitAnd for Mask8 {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl BitOr for Mask8 {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl Not for Mask8 {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}

/// `a < b`; a NaN on either side clears the lane, as it makes the scalar comparison false.
#[inline(always)]
pub fn lt8(a: f32x8, b: f32x8) -> Mask8 {
    Mask8(a.simd_lt(b))
}

/// `a <= b`; a NaN on either side clears the lane.
#[inline(always)]
pub fn le8(a: f32x8, b: f32x8) -> Mask8 {
    Mask8(a.simd_le(b))
}

/// `a > b`; a NaN on either side clears the lane.
#[inline(always)]
pub fn gt8(a: f32x8, b: f32x8) -> Mask8 {
    Mask8(a.simd_gt(b))
}

/// `a >= b`; a NaN on either side clears the lane.
#[inline(always)]
pub fn ge8(a: f32x8, b: f32x8) -> Mask8 {
    Mask8(a.simd_ge(b))
}

/// `a == b`; a NaN on either side clears the lane.
#[inline(always)]
pub fn eq8(a: f32x8, b: f32x8) -> Mask8 {
    Mask8(a.simd_eq(b))
}

/// `a != b`; a NaN on either side **sets** the lane, as it makes the scalar comparison true.
#[inline(always)]
pub fn ne8(a: f32x8, b: f32x8) -> Mask8 {
    Mask8(a.simd_ne(b))
}

/// The smaller of two numbers; `b` when they are equal (also as ±0) or one is NaN.
#[inline(always)]
pub fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// [`min`] in eight lanes.
#[inline(always)]
pub fn min8(a: f32x8, b: f32x8) -> f32x8 {
    // On x86 this definition is the `minps` instruction, which the compiler does not find by itself in compare and select.
    if cfg!(any(target_arch = "x86", target_arch = "x86_64")) { a.fast_min(b) } else { lt8(a, b).select(a, b) }
}

/// The larger of two numbers; `b` when they are equal (also as ±0) or one is NaN.
#[inline(always)]
pub fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// [`max`] in eight lanes.
#[inline(always)]
pub fn max8(a: f32x8, b: f32x8) -> f32x8 {
    // As in `min8`: `maxps`.
    if cfg!(any(target_arch = "x86", target_arch = "x86_64")) { a.fast_max(b) } else { gt8(a, b).select(a, b) }
}

/// Whether the sign bit is set: true for `-0.0`, `-inf` and negative NaN.
#[inline(always)]
pub fn sign_bit(a: f32) -> bool {
    a.is_sign_negative()
}

/// [`sign_bit`] in eight lanes.
#[inline(always)]
pub fn sign_bit8(a: f32x8) -> Mask8 {
    Mask8(a.is_sign_negative())
}

/// Whether a hit at `t` lies in the closed interval and is a number that a ray can reach: NaN and ±∞ are refused,
/// also by an infinite interval.
#[inline(always)]
pub fn accepts(t_min: f32, t: f32, t_max: f32) -> bool {
    // The ends are made finite once for a ray, where a look at `t` itself would be taken for every primitive.
    (t >= max(-f32::MAX, t_min)) & (t <= min(f32::MAX, t_max))
}

/// [`accepts`] in eight lanes.
#[inline(always)]
pub fn accepts8(t_min: f32x8, t: f32x8, t_max: f32x8) -> Mask8 {
    let most = f32x8::splat(f32::MAX);
    ge8(t, max8(-most, t_min)) & le8(t, min8(most, t_max))
}

/// The square root, correctly rounded; NaN below -0.
#[inline(always)]
pub fn sqrt(a: f32) -> f32 {
    // `f32::sqrt` is not in core; of these four lanes one is used.
    f32x4::splat(a).sqrt().to_array()[0]
}

/// [`sqrt`] in eight lanes. A NaN may differ in sign and payload.
#[inline(always)]
pub fn sqrt8(a: f32x8) -> f32x8 {
    a.sqrt()
}

/// The greatest power of two that is at most `|a|`: 0 where `a` is zero or subnormal, +∞ where it is not finite.
#[inline(always)]
pub fn power_of_two(a: f32) -> f32 {
    f32::from_bits(a.to_bits() & f32::INFINITY.to_bits())
}

/// [`power_of_two`] in eight lanes.
#[inline(always)]
pub fn power_of_two8(a: f32x8) -> f32x8 {
    f32x8::from_bits(f32x8::to_bits(a) & u32x8::splat(f32::INFINITY.to_bits()))
}

/// `a·b + c`, rounded once.
#[cfg(fused)]
#[inline(always)]
pub fn mul_add(a: f32, b: f32, c: f32) -> f32 {
    // `f32::mul_add` is not in core; of these four lanes the compiler keeps one.
    let [a, b, c] = [a, b, c].map(f32x4::splat);
    a.mul_add(b, c).to_array()[0]
}

/// [`mul_add`] in eight lanes.
#[cfg(fused)]
#[inline(always)]
pub fn mul_add8(a: f32x8, b: f32x8, c: f32x8) -> f32x8 {
    a.mul_add(b, c)
}

/// `f64::from`, in eight lanes.
#[inline(always)]
pub fn to_f64x8(a: f32x8) -> f64x8 {
    f64x8::new(a.to_array().map(f64::from))
}

/// `as f32`, rounded to nearest, in eight lanes.
#[inline(always)]
pub fn to_f32x8(a: f64x8) -> f32x8 {
    f32x8::new(a.to_array().map(|a| a as f32))
}

/// [`sqrt`] in `f64`.
#[inline(always)]
pub fn sqrt_f64(a: f64) -> f64 {
    f64x2::splat(a).sqrt().to_array()[0]
}

/// [`sqrt_f64`] in eight lanes. A NaN may differ in sign and payload.
#[inline(always)]
pub fn sqrt_f64x8(a: f64x8) -> f64x8 {
    a.sqrt()
}

/// Eight vectors in `f64`, spelled operation for operation like [`glam::DVec3`].
pub type DVec3x8 = [f64x8; 3];

/// [`Vec3::as_dvec3`] in eight lanes.
#[inline(always)]
pub fn double8(v: Vec3x8) -> DVec3x8 {
    [to_f64x8(v.x), to_f64x8(v.y), to_f64x8(v.z)]
}

/// `x·x' + y·y' + z·z'` in `f64`, added from the left.
#[inline(always)]
pub fn dot_f64x8(a: DVec3x8, b: DVec3x8) -> f64x8 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Eight outcomes of comparing `f64`; [`Mask64::narrow`] makes a [`Mask8`] of them.
#[derive(Clone, Copy, Debug)]
pub struct Mask64(f64x8);

impl Mask64 {
    /// The same lanes.
    #[inline(always)]
    pub fn narrow(self) -> Mask8 {
        // Each lane is all ones or all zeros, and so is either half of it.
        Mask8(f32x8::new(self.0.to_array().map(|lane| f32::from_bits(lane.to_bits() as u32))))
    }

    /// `if lane { if_set } else { if_clear }`, lane by lane.
    #[inline(always)]
    pub fn select(self, if_set: f64x8, if_clear: f64x8) -> f64x8 {
        self.0.select(if_set, if_clear)
    }
}

impl BitOr for Mask64 {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl Not for Mask64 {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}

impl BitAnd for Mask64 {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

/// [`sign_bit`] of eight `f64`.
#[inline(always)]
pub fn sign_bit_f64x8(a: f64x8) -> Mask64 {
    Mask64(a.is_sign_negative())
}

/// `a < b` in `f64`; a NaN on either side clears the lane.
#[inline(always)]
pub fn lt64(a: f64x8, b: f64x8) -> Mask64 {
    Mask64(a.simd_lt(b))
}

/// `a <= b` in `f64`; a NaN on either side clears the lane.
#[inline(always)]
pub fn le64(a: f64x8, b: f64x8) -> Mask64 {
    Mask64(a.simd_le(b))
}

/// `a >= b` in `f64`; a NaN on either side clears the lane.
#[inline(always)]
pub fn ge64(a: f64x8, b: f64x8) -> Mask64 {
    Mask64(a.simd_ge(b))
}

/// Eight vectors as structure of arrays, spelled operation for operation like [`glam::Vec3`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vec3x8 {
    /// First components.
    pub x: f32x8,
    /// Second components.
    pub y: f32x8,
    /// Third components.
    pub z: f32x8,
}

impl Vec3x8 {
    /// Eight copies of one vector.
    #[inline(always)]
    pub fn splat(v: Vec3) -> Self {
        Self { x: f32x8::splat(v.x), y: f32x8::splat(v.y), z: f32x8::splat(v.z) }
    }

    /// Lane `i` becomes `lanes[i]`.
    #[inline]
    pub fn from_lanes(lanes: [Vec3; 8]) -> Self {
        Self { x: f32x8::new(lanes.map(|v| v.x)), y: f32x8::new(lanes.map(|v| v.y)), z: f32x8::new(lanes.map(|v| v.z)) }
    }

    /// The vector in lane `index`.
    ///
    /// # Panics
    /// If `index >= 8`.
    #[inline(always)]
    pub fn lane(&self, index: usize) -> Vec3 {
        // By reference: what lies in memory is not copied first.
        Vec3::new(self.x.as_array()[index], self.y.as_array()[index], self.z.as_array()[index])
    }

    /// The smaller components of two vectors, by [`min8`].
    #[inline(always)]
    pub fn min(&self, other: &Self) -> Self {
        Self { x: min8(self.x, other.x), y: min8(self.y, other.y), z: min8(self.z, other.z) }
    }

    /// The larger components of two vectors, by [`max8`].
    #[inline(always)]
    pub fn max(&self, other: &Self) -> Self {
        Self { x: max8(self.x, other.x), y: max8(self.y, other.y), z: max8(self.z, other.z) }
    }

    /// `x·x' + y·y' + z·z'`, added from the left.
    #[inline(always)]
    pub fn dot(self, other: Self) -> f32x8 {
        (self.x * other.x) + (self.y * other.y) + (self.z * other.z)
    }

    /// Cross product, with the factors in glam's order.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - other.y * self.z,
            y: self.z * other.x - other.z * self.x,
            z: self.x * other.y - other.x * self.y,
        }
    }
}

impl Add for Vec3x8 {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl Sub for Vec3x8 {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}

impl Mul<f32x8> for Vec3x8 {
    type Output = Self;
    #[inline(always)]
    fn mul(self, scale: f32x8) -> Self {
        Self { x: self.x * scale, y: self.y * scale, z: self.z * scale }
    }
}

impl Neg for Vec3x8 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers that separate definitions: signed zeros, subnormals, infinities, NaN of both signs.
    const SHARP: [f32; 14] = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        1.5,
        f32::MIN_POSITIVE,
        -f32::MIN_POSITIVE,
        1e-45,
        -1e-45,
        f32::MAX,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::NAN,
        -f32::NAN,
    ];

    /// Checks a binary pair on every pair of sharp numbers, in every lane.
    fn same_bits(name: &str, scalar: fn(f32, f32) -> f32, packet: fn(f32x8, f32x8) -> f32x8) {
        for a in SHARP {
            for b in SHARP {
                let expected = scalar(a, b).to_bits();
                for (lane, got) in packet(f32x8::splat(a), f32x8::splat(b)).to_array().iter().enumerate() {
                    assert_eq!(got.to_bits(), expected, "{name}({a:?}, {b:?}) in lane {lane}");
                }
            }
        }
    }

    fn same_masks(name: &str, scalar: fn(f32, f32) -> bool, packet: fn(f32x8, f32x8) -> Mask8) {
        for a in SHARP {
            for b in SHARP {
                let expected = if scalar(a, b) { 0xff } else { 0 };
                assert_eq!(packet(f32x8::splat(a), f32x8::splat(b)).bits(), expected, "{name}({a:?}, {b:?})");
            }
        }
    }

    #[test]
    fn pairs_agree_on_sharp_numbers() {
        same_bits("min", min, min8);
        same_bits("max", max, max8);
        same_masks("lt", |a, b| a < b, lt8);
        same_masks("le", |a, b| a <= b, le8);
        same_masks("gt", |a, b| a > b, gt8);
        same_masks("ge", |a, b| a >= b, ge8);
        same_masks("eq", |a, b| a == b, eq8);
        same_masks("ne", |a, b| a != b, ne8);
        same_masks("sign_bit", |a, _| sign_bit(a), |a, _| sign_bit8(a));
        same_masks("accepts", |a, b| accepts(-1.0, a, b), |a, b| accepts8(f32x8::splat(-1.0), a, b));
    }

    #[test]
    fn what_is_accepted_is_finite_and_within() {
        for t in SHARP {
            for a in SHARP {
                for b in SHARP {
                    let expected = (t >= a) & (t <= b) & t.is_finite();
                    assert_eq!(accepts(a, t, b), expected, "{t:?} within {a:?} and {b:?}");
                    let eight = accepts8(f32x8::splat(a), f32x8::splat(t), f32x8::splat(b));
                    assert_eq!(
                        eight.bits(),
                        if expected { 0xff } else { 0 },
                        "eight times {t:?} within {a:?} and {b:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn square_roots_and_powers_of_two_agree() {
        for a in SHARP {
            let (root, power) = (sqrt(a), power_of_two(a));
            for lane in sqrt8(f32x8::splat(a)).to_array() {
                assert!(
                    lane.to_bits() == root.to_bits() || (lane.is_nan() && root.is_nan()),
                    "{a:?}: {lane:?}, {root:?}"
                );
            }
            for lane in power_of_two8(f32x8::splat(a)).to_array() {
                assert_eq!(lane.to_bits(), power.to_bits(), "{a:?}");
            }
            let a = f64::from(a);
            let root = sqrt_f64(a);
            for lane in sqrt_f64x8(f64x8::splat(a)).to_array() {
                assert!(
                    lane.to_bits() == root.to_bits() || (lane.is_nan() && root.is_nan()),
                    "{a:?}: {lane:?}, {root:?}"
                );
            }
        }
        // The nearest of all numbers: the squares of its neighbours' midpoints enclose 2.
        assert_eq!((sqrt(2.0), sqrt_f64(2.0)), (core::f32::consts::SQRT_2, core::f64::consts::SQRT_2));
        assert_eq!((sqrt(9.0), sqrt(-0.0).to_bits(), sqrt(-1e-45).is_nan()), (3.0, 1 << 31, true));
        assert_eq!([3.9, -4.0, 1e-45, -0.0, f32::MAX].map(power_of_two), [2.0, 4.0, 0.0, 0.0, 2f32.powi(127)]);
        assert_eq!([f32::INFINITY, f32::NAN].map(power_of_two), [f32::INFINITY; 2]);
    }

    #[cfg(fused)]
    #[test]
    fn multiply_add_rounds_once_in_both_twins() {
        for c in SHARP {
            let packet = |a, b, c| mul_add8(f32x8::splat(a), f32x8::splat(b), f32x8::splat(c)).to_array();
            for a in SHARP {
                for b in SHARP {
                    let expected = mul_add(a, b, c);
                    for (lane, got) in packet(a, b, c).into_iter().enumerate() {
                        let same = got.to_bits() == expected.to_bits() || (got.is_nan() && expected.is_nan());
                        assert!(same, "mul_add({a:?}, {b:?}, {c:?}) in lane {lane}: {got:?}, {expected:?}");
                    }
                }
            }
        }
        // (1 + ε)² - (1 + 2ε) is ε², which two roundings lose.
        let (a, c) = (1.0 + f32::EPSILON, -1.0 - 2.0 * f32::EPSILON);
        assert_eq!((mul_add(a, a, c), a * a + c), (f32::EPSILON * f32::EPSILON, 0.0));
    }

    #[test]
    fn conversions_to_and_from_f64_agree() {
        const SHARP64: [f64; 8] =
            [0.0, -0.0, 0.1, 1e-46, -1e300, f64::MIN_POSITIVE, f64::NEG_INFINITY, 1.000_000_059_604_644_8];
        for a in SHARP {
            for lane in to_f64x8(f32x8::splat(a)).to_array() {
                assert!(lane.to_bits() == f64::from(a).to_bits() || (lane.is_nan() && a.is_nan()), "{a:?}");
            }
        }
        for a in SHARP64 {
            for lane in to_f32x8(f64x8::splat(a)).to_array() {
                assert_eq!(lane.to_bits(), (a as f32).to_bits(), "{a:?}");
            }
        }
        assert!(to_f32x8(f64x8::splat(f64::NAN)).to_array().iter().all(|lane| lane.is_nan()));
        for (a, b) in [(1.0, 2.0), (2.0, 1.0), (0.0, -0.0), (f64::NAN, 1.0), (1.0, f64::NAN), (1.0, 1.0 + f64::EPSILON)]
        {
            let (a8, b8) = (f64x8::splat(a), f64x8::splat(b));
            assert_eq!(le64(a8, b8).narrow().bits(), if a <= b { 0xff } else { 0 });
            assert_eq!(ge64(a8, b8).narrow().bits(), if a >= b { 0xff } else { 0 });
            assert_eq!(lt64(a8, b8).narrow().bits(), if a < b { 0xff } else { 0 });
            assert_eq!((!lt64(a8, b8) | lt64(b8, a8)).narrow().bits(), if a < b { 0 } else { 0xff });
            let (least, expected) = (lt64(a8, b8).select(a8, b8), if a < b { a } else { b });
            assert!(least.to_array().iter().all(|lane| lane.to_bits() == expected.to_bits()), "{a:?}, {b:?}");
        }
        for a in SHARP64 {
            let expected = if a.is_sign_negative() { 0xff } else { 0 };
            assert_eq!(sign_bit_f64x8(f64x8::splat(a)).narrow().bits(), expected, "{a:?}");
            let signed = sign_bit_f64x8(f64x8::splat(a)).select(f64x8::splat(1.0), f64x8::splat(2.0)).to_array();
            assert_eq!(signed, [if a.is_sign_negative() { 1.0 } else { 2.0 }; 8], "{a:?}");
        }
        let lanes = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, f64::NAN];
        let (low, high) = (ge64(f64x8::new(lanes), f64x8::splat(2.0)), le64(f64x8::new(lanes), f64x8::splat(5.0)));
        assert_eq!((low & high).narrow().bits(), 0b0011_1100);
    }

    #[test]
    fn min_and_max_return_the_second_of_equals_and_beside_nan() {
        assert_eq!(min(0.0, -0.0).to_bits(), (-0.0f32).to_bits());
        assert_eq!(max(-0.0, 0.0).to_bits(), 0);
        assert_eq!(min(f32::NAN, 1.0), 1.0);
        assert!(min(1.0, f32::NAN).is_nan());
        assert_eq!(max(f32::NAN, 1.0), 1.0);
        assert!(max(1.0, f32::NAN).is_nan());
    }

    #[test]
    fn masks_keep_their_lanes_apart() {
        let even = Mask8::from_lanes([true, false, true, false, true, false, true, false]);
        assert_eq!(even.bits(), 0b0101_0101);
        assert_eq!((!even).bits(), 0b1010_1010);
        assert!(even.lane(6) && !even.lane(7));
        assert!((even | !even).all() && !(even & !even).any());
        let chosen = even.select(f32x8::splat(1.0), f32x8::splat(-0.0)).to_array();
        assert_eq!(chosen.map(f32::to_bits), [1.0, -0.0, 1.0, -0.0, 1.0, -0.0, 1.0, -0.0].map(f32::to_bits));
        let numbers = even.select_u32(u32x8::splat(7), u32x8::splat(u32::MAX)).to_array();
        assert_eq!(numbers, [7, u32::MAX, 7, u32::MAX, 7, u32::MAX, 7, u32::MAX]);
    }

    #[test]
    fn vectors_round_like_glam() {
        let (a, b) = (Vec3::new(0.1, -2.7, 1e8), Vec3::new(3.3, 0.7, -1e-3));
        let (a8, b8) = (Vec3x8::splat(a), Vec3x8::splat(b));
        for lane in 0..8 {
            assert_eq!(a8.dot(b8).to_array()[lane].to_bits(), a.dot(b).to_bits());
            assert_eq!(a8.cross(b8).lane(lane).to_array().map(f32::to_bits), a.cross(b).to_array().map(f32::to_bits));
            assert_eq!((a8 - b8).lane(lane), a - b);
            assert_eq!((a8 + b8).lane(lane), a + b);
            assert_eq!((a8 * f32x8::splat(0.3)).lane(lane), a * 0.3);
            assert_eq!((-a8).lane(lane), -a);
        }
    }
}
