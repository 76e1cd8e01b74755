//! Operations on eight numbers in `f64`, for kernels that compute in double precision.

use core::ops::{BitAnd, BitOr, Not};

use wide::{f32x8, f64x2, f64x8};

use super::mask::Mask8;
use super::vec::Vec3x8;

/// `f64::from` in eight lanes. Exact.
#[inline(always)]
pub fn to_f64x8(a: f32x8) -> f64x8 {
    f64x8::new(a.to_array().map(f64::from))
}

/// `as f32` in eight lanes: rounded to nearest.
#[inline(always)]
pub fn to_f32x8(a: f64x8) -> f32x8 {
    f32x8::new(a.to_array().map(|a| a as f32))
}

/// [`sqrt`](super::sqrt) in `f64`.
#[inline(always)]
pub fn sqrt_f64(a: f64) -> f64 {
    f64x2::splat(a).sqrt().to_array()[0]
}

/// [`sqrt_f64`] in eight lanes. A NaN may differ in sign and payload.
#[inline(always)]
pub fn sqrt_f64x8(a: f64x8) -> f64x8 {
    a.sqrt()
}

/// Eight vectors in `f64`. Their operations have the order of [`glam::DVec3`], so they round the same.
pub type DVec3x8 = [f64x8; 3];

/// [`glam::Vec3::as_dvec3`] in eight lanes. Exact.
#[inline(always)]
pub fn double8(v: Vec3x8) -> DVec3x8 {
    [to_f64x8(v.x), to_f64x8(v.y), to_f64x8(v.z)]
}

/// `x·x' + y·y' + z·z'` in `f64`, added from the left.
#[inline(always)]
pub fn dot_f64x8(a: DVec3x8, b: DVec3x8) -> f64x8 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The outcomes of eight comparisons of `f64`. [`Mask64::narrow`] turns them into a [`Mask8`].
#[derive(Clone, Copy, Debug)]
pub struct Mask64(f64x8);

impl Mask64 {
    /// The same lanes as a [`Mask8`].
    #[inline(always)]
    pub fn narrow(self) -> Mask8 {
        // Each lane is all ones or all zeros, and so are both of its halves.
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

/// [`sign_bit`](super::sign_bit) of eight `f64`.
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

#[cfg(test)]
mod tests {
    use super::super::SHARP;
    use super::*;

    /// Numbers at which conversions and sign tests differ.
    const SHARP64: [f64; 8] =
        [0.0, -0.0, 0.1, 1e-46, -1e300, f64::MIN_POSITIVE, f64::NEG_INFINITY, 1.000_000_059_604_644_8];

    #[test]
    fn square_roots_agree_in_eight_lanes() {
        for a in SHARP {
            let a = f64::from(a);
            let root = sqrt_f64(a);
            for lane in sqrt_f64x8(f64x8::splat(a)).to_array() {
                assert!(
                    lane.to_bits() == root.to_bits() || (lane.is_nan() && root.is_nan()),
                    "{a:?}: {lane:?}, {root:?}"
                );
            }
        }
        // The constant is the `f64` nearest to the root of 2.
        assert_eq!(sqrt_f64(2.0), core::f64::consts::SQRT_2);
    }

    #[test]
    fn conversions_round_like_scalar_casts() {
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
    }

    #[test]
    fn comparisons_and_selection_agree_with_scalar_f64() {
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
    }

    #[test]
    fn sign_bits_and_masks_work_lane_by_lane() {
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
}
