//! Numbers as text that reads back to the same bits.

use std::fmt::{self, Display, Formatter};

/// Displays a finite number with the fewest digits that read back to the same `f32`, also where a reader first rounds
/// to `f64` and refuses more than `f32::MAX`, as the one of scene files does. A negative zero keeps its sign.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shortest(pub(crate) f32);

impl Display for Shortest {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        // Unlike Display, Debug writes large and small numbers with an exponent.
        let text = format!("{:?}", self.0);
        let reads_back = |number: f64| number as f32 == self.0 && number.abs() <= f64::from(f32::MAX);
        if text.parse().is_ok_and(reads_back) {
            // -0 would be a whole number in TOML, which has no sign if it is zero.
            f.write_str(text.strip_suffix(".0").filter(|whole| *whole != "-0").unwrap_or(&text))
        } else {
            write!(f, "{:?}", f64::from(self.0))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_back_from_few_digits() {
        for (number, text) in [
            (0.0, "0"),
            (-0.0, "-0.0"),
            (1.0, "1"),
            (-2.5, "-2.5"),
            (0.1, "0.1"),
            (16_777_216.0, "16777216"),
            (1e30, "1e30"),
            (1e-45, "1e-45"),
            (f32::MIN_POSITIVE, "1.1754944e-38"),
            (f32::MIN, "-3.4028234663852886e38"),
        ] {
            assert_eq!(Shortest(number).to_string(), text);
        }
        // Of the fewest digits, 7.038531e-26, an f64 is exactly between two f32.
        let tie = f32::from_bits(0x15ae_43fd);
        assert_ne!("7.038531e-26".parse::<f64>().unwrap() as f32, tie);
        let mut bits = 0u32;
        let strides = std::iter::from_fn(|| {
            bits = bits.wrapping_add(0x0012_3457);
            Some(f32::from_bits(bits))
        });
        for number in strides.take(20_000).filter(|number| number.is_finite()).chain([tie, -tie]) {
            let text = Shortest(number).to_string();
            assert_eq!(text.parse::<f32>().unwrap().to_bits(), number.to_bits(), "{text}");
            assert_eq!((text.parse::<f64>().unwrap() as f32).to_bits(), number.to_bits(), "{text}");
        }
    }
}
