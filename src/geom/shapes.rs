//! Plain data: what is intersected, before any kernel prepares it.

use glam::{Affine3, Vec3};

/// A shape that kernels intersect, and the name of its family of kernels.
pub trait Shape: Copy + core::fmt::Debug + PartialEq + Send + Sync + 'static {
    /// First part of the IDs of its kernels.
    const FAMILY: &'static str;
}

impl Shape for Aabb {
    const FAMILY: &'static str = "aabb";
}

impl Shape for Triangle {
    const FAMILY: &'static str = "triangle";
}

impl<S: Shape> Shape for Placed<S> {
    const FAMILY: &'static str = "instance";
}

/// A triangle. Its front side, and its normal, point to where the vertices appear counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// Vertex with `u = v = 0`.
    pub v0: Vec3,
    /// Vertex with `u = 1`.
    pub v1: Vec3,
    /// Vertex with `v = 1`.
    pub v2: Vec3,
}

impl Triangle {
    /// The vertices in order.
    #[inline]
    pub fn vertices(&self) -> [Vec3; 3] {
        [self.v0, self.v1, self.v2]
    }

    /// Geometric normal `(v1 - v0) × (v2 - v0)`, of unit length; zero where the area is zero, not finite, or too small
    /// to have a direction in `f32`.
    #[inline]
    pub fn normal(&self) -> Vec3 {
        (self.v1 - self.v0).cross(self.v2 - self.v0).normalize_or_zero()
    }

    /// The point with barycentrics `u` and `v`.
    #[inline]
    pub fn point(&self, u: f32, v: f32) -> Vec3 {
        self.v0 + (self.v1 - self.v0) * u + (self.v2 - self.v0) * v
    }

    /// The smallest box around the vertices; [`Aabb::EMPTY`] where a coordinate is NaN.
    #[inline]
    pub fn bounds(&self) -> Aabb {
        if self.v0.is_nan() | self.v1.is_nan() | self.v2.is_nan() {
            return Aabb::EMPTY;
        }
        Aabb::EMPTY.including(self.v0).including(self.v1).including(self.v2)
    }
}

/// An axis-aligned box, closed on all sides. It may be flat; a box with `lo > hi` on some axis, or with a NaN, is
/// empty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Least corner.
    pub lo: Vec3,
    /// Greatest corner.
    pub hi: Vec3,
}

impl Aabb {
    /// The box that contains nothing and grows to whatever it first includes.
    pub const EMPTY: Self = Self { lo: Vec3::INFINITY, hi: Vec3::NEG_INFINITY };

    /// The smallest box around this one and `point`, which must not be NaN.
    #[inline]
    #[must_use]
    pub fn including(&self, point: Vec3) -> Self {
        Self { lo: self.lo.min(point), hi: self.hi.max(point) }
    }

    /// The smallest box around both.
    #[inline]
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    /// This box, or [`Aabb::EMPTY`] if it contains no point or has a NaN: the one form kernels store.
    #[inline]
    #[must_use]
    pub fn or_empty(&self) -> Self {
        let (lo, hi) = (self.lo, self.hi);
        if (lo.x <= hi.x) & (lo.y <= hi.y) & (lo.z <= hi.z) { *self } else { Self::EMPTY }
    }

    /// `hi - lo`.
    #[inline]
    pub fn extent(&self) -> Vec3 {
        self.hi - self.lo
    }

    /// The middle.
    #[inline]
    pub fn center(&self) -> Vec3 {
        self.lo * 0.5 + self.hi * 0.5
    }
}

/// A shape put into the world by an affine transform: what an instance is, before it is prepared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed<S> {
    /// The shape in its own coordinates.
    pub shape: S,
    /// From the shape's coordinates to the world's.
    pub object_to_world: Affine3,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_are_counter_clockwise() {
        let triangle = Triangle { v0: Vec3::ZERO, v1: Vec3::X, v2: Vec3::Y };
        assert_eq!(triangle.normal(), Vec3::Z);
        assert_eq!(Triangle { v1: Vec3::Y, v2: Vec3::X, ..triangle }.normal(), -Vec3::Z);
        assert_eq!(Triangle { v2: Vec3::X, ..triangle }.normal(), Vec3::ZERO);
    }

    #[test]
    fn boxes_with_nan_or_inverted_sides_are_empty() {
        let triangle = Triangle { v0: Vec3::ZERO, v1: Vec3::new(1.0, f32::NAN, 0.0), v2: Vec3::Y };
        for rotation in 0..3 {
            let [a, b, c] = triangle.vertices();
            let turned = [(a, b, c), (b, c, a), (c, a, b)][rotation];
            assert_eq!(Triangle { v0: turned.0, v1: turned.1, v2: turned.2 }.bounds(), Aabb::EMPTY);
        }
        assert_eq!(Aabb { lo: Vec3::ONE, hi: Vec3::new(2.0, 0.5, 2.0) }.or_empty(), Aabb::EMPTY);
        let flat = Aabb { lo: Vec3::ZERO, hi: Vec3::new(1.0, 0.0, 1.0) };
        assert_eq!(flat.or_empty(), flat);
    }
}
