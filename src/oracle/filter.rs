//! The filter: arithmetic in `f64` that carries a bound of its own rounding error.

use core::cmp::Ordering;

use glam::Vec3;

use super::number::{Number, Root};

/// Half the distance from 1 to the next `f64`: the relative error of one rounding.
const UNIT: f64 = f64::EPSILON / 2.0;

/// Covers the roundings within the computation of one error bound: at most ten, each by at most one [`UNIT`].
const ROUND_UP: f64 = 1.0 + 16.0 * UNIT;

/// A number that is at most `error` away from `value`.
///
/// The bound is proven step by step: each operation adds its own rounding error to the errors of its operands (N.
/// Higham, "Accuracy and Stability of Numerical Algorithms", section 3.3, running error analysis). Overflow makes the
/// value or the bound infinite or NaN. Every question about such a number is answered with a doubt.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounded {
    value: f64,
    error: f64,
}

impl Bounded {
    /// The result of one operation, rounded to `value`. `inherited` bounds the errors that come from the operands.
    #[inline(always)]
    fn rounded(value: f64, inherited: f64) -> Self {
        Self { value, error: (inherited + value.abs() * UNIT) * ROUND_UP }
    }

    #[inline(always)]
    fn is_exactly_zero(&self) -> bool {
        (self.value == 0.0) & (self.error == 0.0)
    }
}

impl Number for Bounded {
    #[inline(always)]
    fn new(value: f32) -> Self {
        Self { value: f64::from(value), error: 0.0 }
    }

    #[inline(always)]
    fn vectors<const K: usize>(vectors: [Vec3; K]) -> [[Self; 3]; K] {
        vectors.map(|vector| vector.to_array().map(Self::new))
    }

    #[inline(always)]
    fn plus(&self, other: &Self) -> Self {
        // A sum cannot underflow: if the result is zero, nothing was rounded.
        Self::rounded(self.value + other.value, self.error + other.error)
    }

    #[inline(always)]
    fn times(&self, other: &Self) -> Self {
        // A product may underflow, here or in the bound: four times by at most half the smallest subnormal number. The
        // smallest normal number covers that. Products with an exact zero are the exception. Otherwise zero coordinates
        // would have subnormal bounds, which are slow, and a product with zero could not be told from a tiny number.
        let underflow = if self.is_exactly_zero() | other.is_exactly_zero() { 0.0 } else { f64::MIN_POSITIVE };
        let inherited = self.value.abs() * other.error + self.error * (other.value.abs() + other.error) + underflow;
        Self::rounded(self.value * other.value, inherited)
    }

    #[inline(always)]
    fn negated(&self) -> Self {
        Self { value: -self.value, error: self.error }
    }

    #[inline(always)]
    fn sign(&self) -> Option<Ordering> {
        if self.value > self.error {
            Some(Ordering::Greater)
        } else if self.value < -self.error {
            Some(Ordering::Less)
        } else {
            self.is_exactly_zero().then_some(Ordering::Equal)
        }
    }

    /// Rounds both ends of the interval that contains the quotient. Rounding is monotonic: if both ends give one
    /// number, so does everything between them.
    #[inline(always)]
    fn divided_by(&self, divisor: &Self) -> Option<f32> {
        let quotient = self.value / divisor.value;
        // |n/d - (n+δ)/(d+ε)| <= (|δ| + |n/d|·|ε|) / (d - |ε|)
        let inherited = (self.error + quotient.abs() * divisor.error) / (divisor.value - divisor.error);
        let Self { value, error } = Self::rounded(quotient, inherited + f64::MIN_POSITIVE);
        let (least, greatest) = ((value - error).next_down() as f32, (value + error).next_up() as f32);
        // Compares bits: a small negative number rounds to -0, a small positive one to 0.
        (least.to_bits() == greatest.to_bits() && !least.is_nan()).then_some(least)
    }

    /// Two quotients are equal: `(-b ± √discriminant) / a` and `c / (-b ∓ √discriminant)`. Takes the one in which
    /// nothing cancels.
    #[inline(always)]
    fn root(a: &Self, b: &Self, c: &Self, discriminant: &Self, which: Root) -> Option<f32> {
        if discriminant.sign()? != Ordering::Greater {
            return None;
        }
        // |√(v+δ) - √v| = |δ| / (√(v+δ) + √v) <= |δ| / √v
        let value = discriminant.value.sqrt();
        let root = Self::rounded(value, discriminant.error / value);
        let signed = if which == Root::Lesser { root.negated() } else { root };
        if (b.value > 0.0) == (which == Root::Lesser) {
            return signed.minus(b).divided_by(a);
        }
        let (num, den) = (c.negated(), b.plus(&signed));
        match den.sign()? {
            Ordering::Greater => num.divided_by(&den),
            Ordering::Less => num.negated().divided_by(&den.negated()),
            Ordering::Equal => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_product_that_underflows_is_not_zero() {
        let least = Bounded::new(f32::from_bits(1));
        let product = [least; 7].iter().fold(least, |product, factor| product.times(factor));
        assert_eq!(product.value, 0.0);
        assert_eq!(product.sign(), None);
        assert_eq!(product.times(&Bounded::new(0.0)).sign(), Some(Ordering::Equal));
    }

    #[test]
    fn overflow_gives_a_doubt() {
        let greatest = Bounded::new(f32::MAX);
        let product = [greatest; 8].iter().fold(greatest, |product, factor| product.times(factor));
        assert_eq!(product.sign(), None);
        assert_eq!(product.divided_by(&greatest), None);
        assert_eq!(greatest.divided_by(&product), None);
        assert_eq!(product.times(&Bounded::new(0.0)).sign(), None);
    }
}
