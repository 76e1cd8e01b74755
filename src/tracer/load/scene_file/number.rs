//! Numbers, arrays, points and colours of a scene file. Each type has a range and refuses other numbers while the file
//! is parsed, so that the error names the place.

use std::fmt::{self, Debug, Formatter};
use std::marker::PhantomData;

use glam::{Affine3, Mat4, Vec3, Vec4};
use serde::Deserialize;
use serde::de::{Deserializer, Error, IntoDeserializer, SeqAccess, Unexpected, Visitor};

use crate::tracer::meshes::generator::MAX_SIZE;

/// Exactly `N` values. An array of `serde` ignores what follows the last one.
#[derive(Clone, Copy)]
pub(super) struct Array<T, const N: usize>(pub(super) [T; N]);

impl<'de, T: Deserialize<'de>, const N: usize> Deserialize<'de> for Array<T, N> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(ArrayVisitor(PhantomData))
    }
}

struct ArrayVisitor<T, const N: usize>(PhantomData<T>);

impl<'de, T: Deserialize<'de>, const N: usize> Visitor<'de> for ArrayVisitor<T, N> {
    type Value = Array<T, N>;

    fn expecting(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "an array of length {N}")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Self::Value, A::Error> {
        let mut array = Vec::with_capacity(N);
        while let Some(item) = items.next_element()? {
            array.push(item);
        }
        array.try_into().map(Array).map_err(|array: Vec<T>| A::Error::invalid_length(array.len(), &self))
    }
}

/// Three finite numbers.
#[derive(Clone, Copy)]
pub(super) struct Point(pub(super) Vec3);

impl<'de> Deserialize<'de> for Point {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Array([x, y, z]) = <Array<Finite, 3>>::deserialize(deserializer)?;
        Ok(Self(Vec3::new(x.0, y.0, z.0)))
    }
}

/// A factor for each axis, or one number for all.
#[derive(Clone, Copy)]
pub(super) struct Factors<const N: usize>(pub(super) [Finite; N]);

impl<'de, const N: usize> Deserialize<'de> for Factors<N> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(FactorsVisitor)
    }
}

struct FactorsVisitor<const N: usize>;

impl<'de, const N: usize> Visitor<'de> for FactorsVisitor<N> {
    type Value = Factors<N>;

    fn expecting(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "a finite number or an array of length {N}")
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<Self::Value, E> {
        Finite::deserialize(number.into_deserializer()).map(|factor| Factors([factor; N]))
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<Self::Value, E> {
        Finite::deserialize(number.into_deserializer()).map(|factor| Factors([factor; N]))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, factors: A) -> Result<Self::Value, A::Error> {
        ArrayVisitor(PhantomData).visit_seq(factors).map(|Array(factors)| Factors(factors))
    }
}

/// The rows of an affine matrix: three, or four with the last row 0, 0, 0, 1. The last column is the translation.
#[derive(Clone, Copy)]
pub(super) struct Matrix(pub(super) Affine3);

impl<'de> Deserialize<'de> for Matrix {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(MatrixVisitor)
    }
}

struct MatrixVisitor;

impl<'de> Visitor<'de> for MatrixVisitor {
    type Value = Matrix;

    fn expecting(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str("3 or 4 rows")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Matrix, A::Error> {
        let mut rows = Vec::new();
        while let Some(Array(row)) = items.next_element::<Array<Finite, 4>>()? {
            rows.push(Vec4::from_array(row.map(|number| number.0)));
        }
        let [x, y, z] = match rows[..] {
            [x, y, z] => [x, y, z],
            [x, y, z, last] if last == Vec4::W => [x, y, z],
            [_, _, _, last] => {
                let message = "the last of four rows must be [0, 0, 0, 1]; a translation is the last column";
                return Err(A::Error::custom(format!("{message}: {last}")));
            }
            _ => return Err(A::Error::invalid_length(rows.len(), &self)),
        };
        Ok(Matrix(Affine3::from_mat4(Mat4::from_cols(x, y, z, Vec4::W).transpose())))
    }
}

/// Linear red, green and blue from 0 to 1.
#[derive(Clone, Copy)]
pub(super) struct Color(pub(super) Vec3);

impl<'de> Deserialize<'de> for Color {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Array([r, g, b]) = <Array<Fraction, 3>>::deserialize(deserializer)?;
        Ok(Self(Vec3::new(r.0, g.0, b.0)))
    }
}

/// A type of numbers with a range.
pub(super) trait Number {
    /// The range, as the error message says what is expected.
    const EXPECTED: &'static str;

    /// Whether the number is in the range.
    fn accepts(number: f64) -> bool;
}

/// Declares number types: name, stored type, what the error message says is expected, and which numbers are accepted.
macro_rules! numbers {
    ($($(#[$comment:meta])* $name:ident($number:ident), $expected:literal, $accepts:expr;)*) => {$(
        $(#[$comment])*
        #[derive(Clone, Copy)]
        pub(super) struct $name(pub(super) $number);

        impl Number for $name {
            const EXPECTED: &'static str = $expected;

            fn accepts(number: f64) -> bool {
                let accepts: fn(f64) -> bool = $accepts;
                accepts(number)
            }
        }

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let number = deserializer.deserialize_any(NumberVisitor(PhantomData::<Self>))?;
                Ok(Self(number as $number))
            }
        }
    )*};
}

numbers! {
    Finite(f32), "a finite number", |number| number.abs() <= f64::from(f32::MAX);
    /// The range guarantees that the square neither overflows nor underflows.
    Length(f32), "a number from 1e-15 to 1e15", |number| (1e-15..=1e15).contains(&number);
    Fraction(f32), "a number from 0 to 1", |number| (0.0..=1.0).contains(&number);
    FieldOfView(f32), "degrees from 1 to 170", |number| (1.0..=170.0).contains(&number);
    Seed(u32), "a whole number from 0 to 4294967295", |number| {
        (0.0..=f64::from(u32::MAX)).contains(&number) && number.fract() == 0.0
    };
    Count(u32), "a whole number from 1 to 10000000", |number| {
        (1.0..=f64::from(MAX_SIZE)).contains(&number) && number.fract() == 0.0
    };
}

/// Parses an integer or a floating-point number that is in the range of `N`.
struct NumberVisitor<N>(PhantomData<N>);

impl<N: Number> Visitor<'_> for NumberVisitor<N> {
    type Value = f64;

    fn expecting(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(N::EXPECTED)
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<f64, E> {
        self.check(number, number)
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<f64, E> {
        self.check(number as f64, number)
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<f64, E> {
        self.check(number as f64, number)
    }
}

impl<N: Number> NumberVisitor<N> {
    /// Returns the number if it is accepted. `found` is the number as the file has it, for the message.
    fn check<E: Error>(&self, number: f64, found: impl Debug) -> Result<f64, E> {
        if N::accepts(number) {
            return Ok(number);
        }
        Err(E::invalid_value(Unexpected::Other(&format!("`{found:?}`")), self))
    }
}
