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

pub use mask::{Mask, Mask8, SetLanes, eq8, ge8, gt8, le8, lt8, ne8, sign_bit, sign_bit8};
pub use ops::{max, max8, min, min8, power_of_two, power_of_two8, sqrt, sqrt8, t_in_range, t_in_range8};
#[cfg(any(fused, doc))]
pub use ops::{mul_add, mul_add8};
pub use ops_f64::{
    DVec3x8, Mask64, dot_f64x8, double8, ge64, le64, lt64, sign_bit_f64x8, sqrt_f64, sqrt_f64x8, to_f32x8, to_f64x8,
};
pub use vec::Vec3x8;

use core::fmt::Debug;
use core::ops::{Add, Div, Mul, Neg, Sub};

use glam::Vec3;
use wide::{f32x8, u32x8};

use super::{Candidate, Hit};

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for wide::f32x8 {}
}

/// The number type of a ray, a hit or a prepared primitive: `f32` for one, `f32x8` for eight as structure of arrays.
///
/// Code that is generic over it serves one ray and eight:
///
/// ```
/// use raylanes::geom::lanes::{Lanes, Mask};
/// use raylanes::geom::{Hit, Ray, Triangle};
/// use raylanes::kernels::{Intersect, Kernel, triangle::Exact};
///
/// /// How many rays a primitive stops, and the distance to it, or `none` where it is missed.
/// fn depth<L: Lanes>(primitive: &impl Intersect<L>, ray: &Ray<L>, none: f32) -> (usize, L) {
///     let hit = primitive.hit(ray);
///     (hit.mask.set_lanes().count(), hit.mask.select(hit.t, L::splat(none)))
/// }
///
/// # use glam::Vec3;
/// let triangle = Exact::prepare(&Triangle { v0: Vec3::ZERO, v1: Vec3::X, v2: Vec3::Y });
/// let rays = [0.25, 0.75, 0.5].map(|x| Ray::new(Vec3::new(x, 0.5, 3.0), Vec3::NEG_Z));
/// assert_eq!(depth(&triangle, &rays[1], -1.0), (0, -1.0));
/// let (stopped, depths) = depth(&triangle, &Ray::from_slice(&rays), -1.0);
/// assert_eq!((stopped, depths.lane(0), depths.lane(1)), (2, 3.0, -1.0));
/// ```
pub trait Lanes:
    sealed::Sealed
    + Copy
    + Debug
    + PartialEq
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// Vector of three components: [`glam::Vec3`] or [`Vec3x8`].
    type Vec3: Copy + Debug + PartialEq + Send + Sync + 'static;
    /// Outcome of a comparison: `bool` or [`Mask8`].
    type Mask: Mask<Self>;
    /// Primitive numbers: `u32` or `u32x8`.
    type Index: Copy + Debug + PartialEq + Send + Sync + 'static;

    /// Number of lanes: 1 or 8.
    const LANES: usize;

    /// The same number in every lane.
    fn splat(number: f32) -> Self;
    /// The number in a lane.
    ///
    /// # Panics
    /// If `lane >= Self::LANES`.
    fn lane(self, lane: usize) -> f32;
    /// The primitive number in a lane.
    ///
    /// # Panics
    /// If `lane >= Self::LANES`.
    fn lane_of_index(index: Self::Index, lane: usize) -> u32;
    /// `self < other`, lane by lane. False for a NaN.
    fn is_less(self, other: Self) -> Self::Mask;
    /// `self <= other`, lane by lane. False for a NaN.
    fn is_at_most(self, other: Self) -> Self::Mask;
    /// `self == other`, lane by lane. False for a NaN.
    fn is_equal(self, other: Self) -> Self::Mask;

    /// An `f32` in each of eight lanes. An `f32x8` is returned unchanged.
    fn widen(self) -> f32x8;
    /// [`Lanes::widen`] for each component.
    ///
    /// Call it by name for each vector, not through `array::map`. In builds without link-time optimisation that remains
    /// a call, and eight rays against one triangle take twice the time.
    fn widen_vec3(vector: Self::Vec3) -> Vec3x8;
    /// Writes [`Hit::MISS`] into the lanes that miss, for eight lanes. A single hit is returned unchanged.
    fn or_miss(candidate: Candidate<Self>) -> Hit<Self>;
}

impl Lanes for f32 {
    type Vec3 = Vec3;
    type Mask = bool;
    type Index = u32;

    const LANES: usize = 1;

    #[inline(always)]
    fn splat(number: f32) -> Self {
        number
    }

    #[inline(always)]
    fn lane(self, lane: usize) -> f32 {
        [self][lane]
    }

    #[inline(always)]
    fn lane_of_index(index: u32, lane: usize) -> u32 {
        [index][lane]
    }

    #[inline(always)]
    fn is_less(self, other: Self) -> bool {
        self < other
    }

    #[inline(always)]
    fn is_at_most(self, other: Self) -> bool {
        self <= other
    }

    #[inline(always)]
    fn is_equal(self, other: Self) -> bool {
        self == other
    }

    #[inline(always)]
    fn widen(self) -> f32x8 {
        f32x8::splat(self)
    }

    #[inline(always)]
    fn widen_vec3(vector: Vec3) -> Vec3x8 {
        Vec3x8::splat(vector)
    }

    #[inline(always)]
    fn or_miss(candidate: Candidate<Self>) -> Hit<Self> {
        candidate.values()
    }
}

impl Lanes for f32x8 {
    type Vec3 = Vec3x8;
    type Mask = Mask8;
    type Index = u32x8;

    const LANES: usize = 8;

    #[inline(always)]
    fn splat(number: f32) -> Self {
        Self::splat(number)
    }

    #[inline(always)]
    fn lane(self, lane: usize) -> f32 {
        self.as_array()[lane]
    }

    #[inline(always)]
    fn lane_of_index(index: u32x8, lane: usize) -> u32 {
        index.as_array()[lane]
    }

    #[inline(always)]
    fn is_less(self, other: Self) -> Mask8 {
        lt8(self, other)
    }

    #[inline(always)]
    fn is_at_most(self, other: Self) -> Mask8 {
        le8(self, other)
    }

    #[inline(always)]
    fn is_equal(self, other: Self) -> Mask8 {
        eq8(self, other)
    }

    #[inline(always)]
    fn widen(self) -> f32x8 {
        self
    }

    #[inline(always)]
    fn widen_vec3(vector: Vec3x8) -> Vec3x8 {
        vector
    }

    #[inline(always)]
    fn or_miss(candidate: Candidate<Self>) -> Hit<Self> {
        let Hit { mask, t, u, v, primitive, instance } = candidate.values();
        let none = u32x8::splat(u32::MAX);
        Hit {
            mask,
            t: mask.select(t, Self::splat(f32::INFINITY)),
            u: mask.select(u, Self::ZERO),
            v: mask.select(v, Self::ZERO),
            primitive: mask.select_u32(primitive, none),
            instance: mask.select_u32(instance, none),
        }
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
