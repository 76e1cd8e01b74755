//! Rays, and packets of eight rays.

use glam::Vec3;
use wide::f32x8;

use super::lanes::{Lanes, Mask8, Vec3x8, eq8, ne8};

/// One ray (`Ray<f32>`) or a packet of eight (`Ray<f32x8>`): the points `origin + t·dir` with `t_min <= t <= t_max`.
///
/// `dir` need not have unit length. `t` counts in units of `|dir|` and is the same before and after an affine
/// transform of the ray. `t_max` may be infinite. An interval with `t_min > t_max` is empty, which makes a lane of a
/// packet inactive. A ray misses everything if it holds a NaN, if its direction is zero, or if its origin or
/// direction is infinite.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Ray<L: Lanes> {
    /// The point at `t = 0`.
    pub origin: L::Vec3,
    /// Least `t` that counts.
    pub t_min: L,
    /// The step per unit of `t`.
    pub dir: L::Vec3,
    /// Greatest `t` that counts.
    pub t_max: L,
}

impl Ray<f32> {
    /// The ray from `origin` along `dir`, with `0 <= t`.
    #[inline]
    pub fn new(origin: Vec3, dir: Vec3) -> Self {
        Self { origin, dir, t_min: 0.0, t_max: f32::INFINITY }
    }

    /// The ray of eight numbers `ox oy oz t_min dx dy dz t_max`, in the order of memory and of ray files.
    #[inline]
    pub fn from_array([ox, oy, oz, t_min, dx, dy, dz, t_max]: [f32; 8]) -> Self {
        Self { origin: Vec3::new(ox, oy, oz), t_min, dir: Vec3::new(dx, dy, dz), t_max }
    }

    /// The eight numbers of [`Ray::from_array`].
    #[inline]
    pub fn to_array(&self) -> [f32; 8] {
        let Self { origin: o, t_min, dir: d, t_max } = self;
        [o.x, o.y, o.z, *t_min, d.x, d.y, d.z, *t_max]
    }

    /// A ray that misses everything: it fills the unused lanes of a partial packet. It has a direction, because kernels
    /// may take a slow way for rays without one.
    pub const INACTIVE: Self =
        Self { origin: Vec3::ZERO, dir: Vec3::Z, t_min: f32::INFINITY, t_max: f32::NEG_INFINITY };

    /// The point at parameter `t`.
    #[inline]
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + self.dir * t
    }

    /// Whether origin and direction are finite and the direction is not zero. The interval is not tested: a NaN bound
    /// already fails every comparison.
    #[inline(always)]
    pub fn is_valid(&self) -> bool {
        let (o, d) = (self.origin, self.dir);
        // x · 0 is ±0 for a finite x, and NaN for any other x.
        let residue = (o.x * 0.0 + o.y * 0.0 + o.z * 0.0) + (d.x * 0.0 + d.y * 0.0 + d.z * 0.0);
        (residue == 0.0) & ((d.x != 0.0) | (d.y != 0.0) | (d.z != 0.0))
    }
}

impl Ray<f32x8> {
    /// Eight copies of one ray.
    #[inline(always)]
    pub fn splat(ray: &Ray<f32>) -> Self {
        Self {
            origin: Vec3x8::splat(ray.origin),
            dir: Vec3x8::splat(ray.dir),
            t_min: f32x8::splat(ray.t_min),
            t_max: f32x8::splat(ray.t_max),
        }
    }

    /// Lane `i` becomes `lanes[i]`.
    #[inline]
    pub fn from_lanes(lanes: &[Ray<f32>; 8]) -> Self {
        Self {
            origin: Vec3x8::from_lanes(lanes.map(|ray| ray.origin)),
            dir: Vec3x8::from_lanes(lanes.map(|ray| ray.dir)),
            t_min: f32x8::new(lanes.map(|ray| ray.t_min)),
            t_max: f32x8::new(lanes.map(|ray| ray.t_max)),
        }
    }

    /// A packet of the first eight rays. If there are fewer, the other lanes are [`Ray::INACTIVE`].
    #[inline]
    pub fn from_slice(rays: &[Ray<f32>]) -> Self {
        let mut lanes = [Ray::INACTIVE; 8];
        for (lane, ray) in lanes.iter_mut().zip(rays) {
            *lane = *ray;
        }
        Self::from_lanes(&lanes)
    }

    /// The ray in lane `index`.
    ///
    /// # Panics
    /// If `index >= 8`.
    #[inline]
    pub fn lane(&self, index: usize) -> Ray<f32> {
        Ray {
            origin: self.origin.lane(index),
            dir: self.dir.lane(index),
            t_min: self.t_min.to_array()[index],
            t_max: self.t_max.to_array()[index],
        }
    }

    /// [`Ray::<f32>::is_valid`] in eight lanes.
    #[inline(always)]
    pub fn is_valid(&self) -> Mask8 {
        let (o, d) = (self.origin, self.dir);
        let zero = f32x8::ZERO;
        let residue = (o.x * zero + o.y * zero + o.z * zero) + (d.x * zero + d.y * zero + d.z * zero);
        eq8(residue, zero) & (ne8(d.x, zero) | ne8(d.y, zero) | ne8(d.z, zero))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn validity_is_the_same_in_both_twins() {
        let good = Ray::new(Vec3::ONE, Vec3::X);
        let mut rays = [good; 8];
        rays[1].origin.y = f32::NAN;
        rays[2].origin.z = f32::INFINITY;
        rays[3].dir = Vec3::new(0.0, -0.0, 0.0);
        rays[4].dir.x = f32::NEG_INFINITY;
        rays[5].dir.z = 1e-45;
        rays[6].dir.y = f32::NAN;
        rays[7].origin = Vec3::splat(f32::MAX);
        let expected = [true, false, false, false, false, true, false, true];
        assert_eq!(rays.map(|ray| ray.is_valid()), expected);
        assert_eq!(Ray::from_lanes(&rays).is_valid(), Mask8::from_lanes(expected));
    }

    #[test]
    fn partial_packets_are_filled_with_inactive_rays() {
        let packet = Ray::from_slice(&[Ray::new(Vec3::ZERO, Vec3::Z); 3]);
        assert_eq!(packet.lane(2).dir, Vec3::Z);
        assert_eq!(packet.lane(3), Ray::INACTIVE);
    }
}
