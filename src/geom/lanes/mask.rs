//! Masks of eight lanes: the outcomes of comparisons and sign tests, and selection by them.

use core::fmt::Debug;
use core::ops::{BitAnd, BitOr, Not};

use wide::{f32x8, u32x8};

use super::Lanes;

/// The outcome of a comparison: `bool` for one lane, [`Mask8`] for eight.
pub trait Mask<L: Lanes>:
    Copy + Debug + PartialEq + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> + Send + Sync + 'static
{
    /// Lane `i` as bit `i`. The other bits are zero.
    fn bits(self) -> u32;

    /// `if lane { if_set } else { if_clear }`, lane by lane.
    fn select(self, if_set: L, if_clear: L) -> L;

    /// [`Mask::select`] for primitive numbers.
    fn select_index(self, if_set: L::Index, if_clear: L::Index) -> L::Index;

    /// Whether any lane is set.
    #[inline(always)]
    fn any(self) -> bool {
        self.bits() != 0
    }

    /// Whether all lanes are set.
    #[inline(always)]
    fn all(self) -> bool {
        self.bits() == (1 << L::LANES) - 1
    }

    /// Whether a lane is set.
    ///
    /// # Panics
    /// If `lane >= L::LANES`.
    #[inline(always)]
    fn lane(self, lane: usize) -> bool {
        assert!(lane < L::LANES, "a mask of {} lanes, asked for lane {lane}", L::LANES);
        self.bits() >> lane & 1 == 1
    }

    /// The lanes that are set, in order.
    #[inline(always)]
    fn set_lanes(self) -> SetLanes {
        SetLanes(self.bits())
    }
}

/// The lanes of a mask that are set, in order; see [`Mask::set_lanes`].
#[derive(Clone, Debug)]
pub struct SetLanes(u32);

impl Iterator for SetLanes {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let lane = self.0.trailing_zeros() as usize;
        (self.0 != 0).then(|| {
            self.0 &= self.0 - 1;
            lane
        })
    }

    #[inline]
    fn size_hint(&self) -> (usize, Option<usize>) {
        let lanes = self.0.count_ones() as usize;
        (lanes, Some(lanes))
    }
}

impl ExactSizeIterator for SetLanes {}

impl Mask<f32> for bool {
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self)
    }

    #[inline(always)]
    fn select(self, if_set: f32, if_clear: f32) -> f32 {
        if self { if_set } else { if_clear }
    }

    #[inline(always)]
    fn select_index(self, if_set: u32, if_clear: u32) -> u32 {
        if self { if_set } else { if_clear }
    }
}

impl Mask<f32x8> for Mask8 {
    #[inline(always)]
    fn bits(self) -> u32 {
        Self::bits(self)
    }

    #[inline(always)]
    fn select(self, if_set: f32x8, if_clear: f32x8) -> f32x8 {
        Self::select(self, if_set, if_clear)
    }

    #[inline(always)]
    fn select_index(self, if_set: u32x8, if_clear: u32x8) -> u32x8 {
        self.select_u32(if_set, if_clear)
    }
}

/// The outcomes of eight comparisons. Only comparisons make a mask, so selection by it is well defined on every target.
#[derive(Clone, Copy, Debug)]
pub struct Mask8(pub(super) f32x8);

impl Mask8 {
    /// No lane.
    #[inline(always)]
    pub fn none() -> Self {
        // A comparison that is false in all lanes gives these bits. The compiler knows this constant, but it does not
        // evaluate comparisons.
        Self(f32x8::ZERO)
    }

    /// Every lane.
    #[inline(always)]
    pub fn all_lanes() -> Self {
        le8(f32x8::ZERO, f32x8::ZERO)
    }

    /// Lane `i` is set if `lanes[i]` is.
    #[inline]
    pub fn from_lanes(lanes: [bool; 8]) -> Self {
        ne8(f32x8::new(lanes.map(|lane| f32::from(u8::from(lane)))), f32x8::ZERO)
    }

    /// Lane `i` as bit `i`. The upper 24 bits are zero.
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

    /// [`Mask8::select`] for integers.
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

/// `a < b`; a NaN on either side clears the lane, like the scalar comparison, which is false.
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

/// `a != b`; a NaN on either side **sets** the lane, like the scalar comparison, which is true.
#[inline(always)]
pub fn ne8(a: f32x8, b: f32x8) -> Mask8 {
    Mask8(a.simd_ne(b))
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

#[cfg(test)]
mod tests {
    use super::super::SHARP;
    use super::*;

    /// Checks a comparison on every pair of sharp numbers, in every lane.
    fn same_masks(name: &str, scalar: fn(f32, f32) -> bool, packet: fn(f32x8, f32x8) -> Mask8) {
        for a in SHARP {
            for b in SHARP {
                let expected = if scalar(a, b) { 0xff } else { 0 };
                assert_eq!(packet(f32x8::splat(a), f32x8::splat(b)).bits(), expected, "{name}({a:?}, {b:?})");
            }
        }
    }

    #[test]
    fn comparisons_agree_with_their_scalar_twins() {
        same_masks("lt", |a, b| a < b, lt8);
        same_masks("le", |a, b| a <= b, le8);
        same_masks("gt", |a, b| a > b, gt8);
        same_masks("ge", |a, b| a >= b, ge8);
        same_masks("eq", |a, b| a == b, eq8);
        same_masks("ne", |a, b| a != b, ne8);
        same_masks("sign_bit", |a, _| sign_bit(a), |a, _| sign_bit8(a));
    }

    #[test]
    fn mask_operations_work_lane_by_lane() {
        let even = Mask8::from_lanes([true, false, true, false, true, false, true, false]);
        assert_eq!(even.bits(), 0b0101_0101);
        assert_eq!((!even).bits(), 0b1010_1010);
        assert!(even.lane(6) && !even.lane(7));
        assert!((even | !even).all() && !(even & !even).any());
        let chosen = even.select(f32x8::splat(1.0), f32x8::splat(-0.0)).to_array();
        assert_eq!(chosen.map(f32::to_bits), [1.0, -0.0, 1.0, -0.0, 1.0, -0.0, 1.0, -0.0].map(f32::to_bits));
        assert!(Mask::set_lanes(even).eq([0, 2, 4, 6]) && Mask::set_lanes(Mask8::none()).len() == 0);
        assert!(Mask::<f32>::all(true) && !Mask::<f32>::any(false) && Mask::<f32>::set_lanes(true).eq([0]));
        let numbers = even.select_u32(u32x8::splat(7), u32x8::splat(u32::MAX)).to_array();
        assert_eq!(numbers, [7, u32::MAX, 7, u32::MAX, 7, u32::MAX, 7, u32::MAX]);
    }
}
