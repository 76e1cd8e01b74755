//! Numbers, points and colours of a scene file. Each type has a range and refuses other numbers while the file is
//! parsed, so that the error names the place.

use std::fmt::Debug;

use glam::Vec3;
use serde::Deserialize;
use serde::de::{Deserializer, Error, Unexpected, Visitor};

use crate::tracer::meshes::generator::MAX_SIZE;

/// Three finite numbers.
#[derive(Clone, Copy)]
pub(super) struct Point(pub(super) Vec3);

impl<'de> Deserialize<'de> for Point {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let [x, y, z] = <[Finite; 3]>::deserialize(deserializer)?;
        Ok(Self(Vec3::new(x.0, y.0, z.0)))
    }
}

/// Linear red, green and blue from 0 to 1.
#[derive(Clone, Copy)]
pub(super) struct Color(pub(super) Vec3);

impl<'de> Deserialize<'de> for Color {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let [r, g, b] = <[Fraction; 3]>::deserialize(deserializer)?;
        Ok(Self(Vec3::new(r.0, g.0, b.0)))
    }
}

/// Declares number types: name, stored type, what the error message says is expected, and which numbers are accepted.
macro_rules! numbers {
    ($($(#[$comment:meta])* $name:ident($number:ident), $expected:literal, $accepts:expr;)*) => {$(
        $(#[$comment])*
        #[derive(Clone, Copy)]
        pub(super) struct $name(pub(super) $number);

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let number = deserializer.deserialize_any(NumberVisitor { expected: $expected, accepts: $accepts })?;
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

/// Parses an integer or a floating-point number that `accepts` allows.
struct NumberVisitor {
    expected: &'static str,
    accepts: fn(f64) -> bool,
}

impl Visitor<'_> for NumberVisitor {
    type Value = f64;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.expected)
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

impl NumberVisitor {
    /// Returns the number if it is accepted. `found` is the number as the file has it, for the message.
    fn check<E: Error>(&self, number: f64, found: impl Debug) -> Result<f64, E> {
        if (self.accepts)(number) {
            return Ok(number);
        }
        Err(E::invalid_value(Unexpected::Other(&format!("`{found:?}`")), self))
    }
}
