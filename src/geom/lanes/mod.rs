//! Lane types, and every operation whose scalar and eight-lane forms could differ. The suffix 8 means eight lanes:
//! `min8` is `min` in eight lanes. Tests compare the two forms of each pair, bit by bit.
//!
//! `+ - * /`, negation and comparisons mean the same for `f32` and `f32x8` on every target. Kernels use them directly.
//! The other operations do not mean the same, so they live here:
//!
//! - Minimum and maximum: `f32::min`, `f32x8::min` and `f32x8::fast_min` disagree on signed zeros and NaN.
//! - Sign tests: `x < 0` is false for `-0`.
//! - Selection is only defined for comparison masks. It goes through [`Mask8`].
//! - `f32x8::mul_add` is fused only where the build enables FMA. `mul_add` and `mul_add8` exist only in such a build
//!   (`cfg(fused)`, set by the build script). In other builds the kernels that need them are absent.
//!
//! There is no reciprocal, on purpose: `f32x8::recip` has 12 bits. Write `1.0 / x`.

mod mask;
mod ops;
mod ops_f64;
mod vec;

pub use mask::{Mask8, eq8, ge8, gt8, le8, lt8, ne8, sign_bit, sign_bit8};
pub use ops::{max, max8, min, min8, power_of_two, power_of_two8, sqrt, sqrt8, t_in_range, t_in_range8};
#[cfg(fused)]
pub use ops::{mul_add, mul_add8};
pub use ops_f64::{
    DVec3x8, Mask64, dot_f64x8, double8, ge64, le64, lt64, sign_bit_f64x8, sqrt_f64, sqrt_f64x8, to_f32x8, to_f64x8,
};
pub use vec::Vec3x8;

use core::fmt::Debug;

use glam::Vec3;
use wide::{f32x8, u32x8};

use super::Hit;

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for wide::f32x8 {}
}

/// The number type of a ray, a hit or a prepared primitive: `f32` for one, `f32x8` for eight as structure of arrays.
pub trait Lanes: sealed::Sealed + Copy + Debug + PartialEq + Send + Sync + 'static {
    /// Vector of three components: [`glam::Vec3`] or [`Vec3x8`].
    type Vec3: Copy + Debug + PartialEq + Send + Sync + 'static;
    /// Outcome of a comparison: `bool` or [`Mask8`].
    type Mask: Copy + Debug + PartialEq + Send + Sync + 'static;
    /// Primitive numbers: `u32` or `u32x8`.
    type Index: Copy + Debug + PartialEq + Send + Sync + 'static;

    /// An `f32` in each of eight lanes. An `f32x8` is returned unchanged.
    fn widen(self) -> f32x8;
    /// [`Lanes::widen`] for each component.
    ///
    /// Call it by name for each vector, not through `array::map`. In builds without link-time optimisation that remains
    /// a call, and eight rays against one triangle take twice the time.
    fn widen_vec3(vector: Self::Vec3) -> Vec3x8;
    /// Writes [`Hit::MISS`] into the lanes that miss, for eight lanes. A single hit is returned unchanged.
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

/// Numbers at which similar operations differ: signed zeros, subnormals, infinities, NaN of both signs.
#[cfg(test)]
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
