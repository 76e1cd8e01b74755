//! Exact arithmetic on integers times powers of two, and the one rounding at the end.

use core::cmp::Ordering;

use dashu_int::ops::{BitTest, DivRem, SquareRootRem, UnsignedAbs};
use dashu_int::{IBig, Sign};
use glam::Vec3;

use super::number::{Number, Root};

/// `int · 2^exponent`, exactly.
///
/// A sum of numbers with different exponents shifts one operand. The formulas for triangles and boxes are
/// homogeneous. So this hardly ever happens there if the inputs that are added to each other have one exponent
/// ([`Number::vectors`]).
#[derive(Clone, Debug)]
pub(super) struct Dyadic {
    int: IBig,
    exponent: i32,
}

impl Number for Dyadic {
    fn new(value: f32) -> Self {
        let (mantissa, exponent) = split(value);
        Self { int: mantissa.into(), exponent }
    }

    fn vectors<const K: usize>(vectors: [Vec3; K]) -> [[Self; 3]; K] {
        let parts = vectors.map(|vector| vector.to_array().map(split));
        let exponents = parts.as_flattened().iter().filter(|part| part.0 != 0).map(|part| part.1);
        let exponent = exponents.min().unwrap_or(0);
        parts.map(|vector| {
            vector.map(|(mantissa, own)| {
                let shift = if mantissa == 0 { 0 } else { own.abs_diff(exponent) as usize };
                Self { int: IBig::from(mantissa) << shift, exponent }
            })
        })
    }

    fn plus(&self, other: &Self) -> Self {
        let (low, high) = if self.exponent <= other.exponent { (self, other) } else { (other, self) };
        let exponent = low.exponent;
        let int = match high.exponent.abs_diff(exponent) {
            0 => &low.int + &high.int,
            shift => &low.int + (&high.int << shift as usize),
        };
        Self { int, exponent }
    }

    fn minus(&self, other: &Self) -> Self {
        if self.exponent == other.exponent {
            return Self { int: &self.int - &other.int, exponent: self.exponent };
        }
        self.plus(&other.negated())
    }

    fn times(&self, other: &Self) -> Self {
        Self { int: &self.int * &other.int, exponent: self.exponent + other.exponent }
    }

    fn negated(&self) -> Self {
        Self { int: -&self.int, exponent: self.exponent }
    }

    fn sign(&self) -> Option<Ordering> {
        Some(if self.int.is_zero() {
            Ordering::Equal
        } else if self.int.sign() == Sign::Positive {
            Ordering::Greater
        } else {
            Ordering::Less
        })
    }

    /// `f64` holds the bits of the quotient exactly. Its conversion rounds them to `f32`, also to subnormals and to
    /// infinity. An `f32` has at most 24 bits, so the sticky bit is to the right of the first bit that is rounded off,
    /// and every tie is a true one.
    fn divided_by(&self, divisor: &Self) -> Option<f32> {
        Some(self.quotient(divisor, 31) as f32)
    }

    /// Replaces `√discriminant` by a number that gives the same rounding.
    ///
    /// The midpoints between neighbours in `f32` decide the rounding. They are multiples of 2⁻¹⁵⁰. A root `t`
    /// compares with a midpoint m as `√discriminant` compares with ±(m·a + b), a multiple of some power of two. So it
    /// is enough to take the largest multiple of that power that is in the square root, and to add half of that power
    /// if anything is left.
    fn root(a: &Self, b: &Self, _c: &Self, discriminant: &Self, which: Root) -> Option<f32> {
        Self::root_numerator(a, b, discriminant, which).divided_by(a)
    }
}

impl Dyadic {
    /// `a` times the number that replaces a root; see [`Number::root`].
    pub(super) fn root_numerator(a: &Self, b: &Self, discriminant: &Self, which: Root) -> Self {
        let exponent = (a.exponent - 150).min(b.exponent).min(discriminant.exponent.div_euclid(2));
        let shift = (discriminant.exponent - 2 * exponent) as usize;
        let (whole, rest) = ((&discriminant.int).unsigned_abs() << shift).sqrt_rem();
        let doubled = (IBig::from(whole) << 1_usize) + IBig::from(u8::from(!rest.is_zero()));
        let root = Self { int: doubled, exponent: exponent - 1 };
        match which {
            Root::Lesser => b.plus(&root).negated(),
            Root::Greater => root.minus(b),
        }
    }

    /// `self / divisor`, rounded once, to nearest even. The divisor must be positive.
    pub(super) fn over(&self, divisor: &Self) -> f64 {
        self.quotient(divisor, 63)
    }

    /// `self / divisor` from `bits` or `bits + 1` bits of the quotient, at most 64, and a sticky bit that tells whether
    /// any bits follow. `f64` rounds them if they are more than 53.
    #[inline(always)]
    fn quotient(&self, divisor: &Self, bits: usize) -> f64 {
        if self.int.is_zero() {
            return 0.0;
        }
        let (mut num, mut den) = ((&self.int).unsigned_abs(), (&divisor.int).unsigned_abs());
        let lengths = (num.bit_len(), den.bit_len());
        let mut exponent = self.exponent - divisor.exponent;
        if lengths.0 < lengths.1 + bits {
            let shift = lengths.1 + bits - lengths.0;
            num <<= shift;
            exponent -= shift as i32;
        } else {
            let shift = lengths.0 - (lengths.1 + bits);
            den <<= shift;
            exponent += shift as i32;
        }
        let (quotient, rest) = num.div_rem(den);
        let bits = u64::try_from(quotient).expect("a quotient has at most 64 bits") | u64::from(!rest.is_zero());
        let magnitude = bits as f64 * power_of_two(exponent);
        if self.int.sign() == Sign::Negative { -magnitude } else { magnitude }
    }
}

/// A finite number as `(mantissa, exponent)`, with the smallest mantissa. Its value is `mantissa · 2^exponent`.
fn split(value: f32) -> (i32, i32) {
    let bits = value.to_bits();
    let (field, fraction) = ((bits >> 23 & 0xff) as i32, (bits & 0x7f_ffff) as i32);
    // Subnormals have the exponent of the smallest normal numbers and no implicit leading bit.
    let magnitude = if field == 0 { fraction } else { fraction | 1 << 23 };
    if magnitude == 0 {
        return (0, 0);
    }
    let zeros = magnitude.trailing_zeros();
    let mantissa = magnitude >> zeros;
    (if value < 0.0 { -mantissa } else { mantissa }, field.max(1) - 150 + zeros as i32)
}

/// `2^exponent`. Exponents beyond ±500 become ±500, which is also beyond the range of `f32`.
fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((exponent.clamp(-500, 500) + 1023) as u64) << 52)
}
