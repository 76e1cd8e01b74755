//! Eight vectors of three components as structure of arrays.

use core::ops::{Add, Mul, Neg, Sub};

use glam::Vec3;
use wide::f32x8;

use super::ops::{max8, min8};

/// Eight vectors as structure of arrays. Its operations have the order of [`glam::Vec3`], so they round the same.
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
        // Through references: a packet in memory is not copied first.
        Vec3::new(self.x.as_array()[index], self.y.as_array()[index], self.z.as_array()[index])
    }

    /// The smaller of each two components, by [`min8`].
    #[inline(always)]
    pub fn min(&self, other: &Self) -> Self {
        Self { x: min8(self.x, other.x), y: min8(self.y, other.y), z: min8(self.z, other.z) }
    }

    /// The larger of each two components, by [`max8`].
    #[inline(always)]
    pub fn max(&self, other: &Self) -> Self {
        Self { x: max8(self.x, other.x), y: max8(self.y, other.y), z: max8(self.z, other.z) }
    }

    /// `x·x' + y·y' + z·z'`, added from the left.
    #[inline(always)]
    pub fn dot(self, other: Self) -> f32x8 {
        (self.x * other.x) + (self.y * other.y) + (self.z * other.z)
    }

    /// The cross product, with the factors in glam's order.
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
