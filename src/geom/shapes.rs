//! Shapes as plain data, before any kernel prepares them.

use glam::{Affine3, DMat3, DVec3, Vec2, Vec3};

/// A shape that kernels intersect.
pub trait Shape: Copy + core::fmt::Debug + PartialEq + Send + Sync + 'static {
    /// Name of its family of kernels: the first part of their IDs.
    const FAMILY: &'static str;
    /// A shape that every ray misses: it fills unused lanes of eight primitives.
    const MISSED: Self;
}

impl Shape for Aabb {
    const FAMILY: &'static str = "aabb";
    const MISSED: Self = Self::EMPTY;
}

impl Shape for Triangle {
    const FAMILY: &'static str = "triangle";
    const MISSED: Self = Self { v0: Vec3::NAN, v1: Vec3::NAN, v2: Vec3::NAN };
}

impl Shape for Quadric {
    const FAMILY: &'static str = "quadric";
    const MISSED: Self =
        Self { squares: Vec3::NAN, products: Vec3::NAN, linear: Vec3::NAN, constant: f32::NAN, clip: Aabb::EMPTY };
}

impl<S: Shape> Shape for Placed<S> {
    const FAMILY: &'static str = "instance";
    const MISSED: Self = Self { shape: S::MISSED, object_to_world: Affine3::IDENTITY };
}

/// A triangle. Seen from its front side, to which its normal points, the vertices are in counter-clockwise order.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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

    /// The geometric normal `(v1 - v0) × (v2 - v0)`, of unit length. Zero if the area is zero, not finite, or too
    /// small to have a direction in `f32`.
    #[inline]
    pub fn normal(&self) -> Vec3 {
        (self.v1 - self.v0).cross(self.v2 - self.v0).normalize_or_zero()
    }

    /// The point with barycentrics `u` and `v`.
    #[inline]
    pub fn point(&self, u: f32, v: f32) -> Vec3 {
        self.v0 + (self.v1 - self.v0) * u + (self.v2 - self.v0) * v
    }

    /// The smallest box around the vertices. [`Aabb::EMPTY`] if a coordinate is NaN.
    #[inline]
    pub fn bounds(&self) -> Aabb {
        if self.v0.is_nan() | self.v1.is_nan() | self.v2.is_nan() {
            return Aabb::EMPTY;
        }
        Aabb::EMPTY.including(self.v0).including(self.v1).including(self.v2)
    }
}

/// An axis-aligned box, closed on all sides. It may be flat. It is empty if `lo > hi` on some axis, or if it holds a
/// NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Aabb {
    /// Least corner.
    pub lo: Vec3,
    /// Greatest corner.
    pub hi: Vec3,
}

impl Aabb {
    /// The box that contains nothing. It grows to exactly the first point that it includes.
    pub const EMPTY: Self = Self { lo: Vec3::INFINITY, hi: Vec3::NEG_INFINITY };

    /// Whether the box contains no point, or holds a NaN.
    #[inline]
    pub fn is_empty(&self) -> bool {
        let (lo, hi) = (self.lo, self.hi);
        !((lo.x <= hi.x) & (lo.y <= hi.y) & (lo.z <= hi.z))
    }

    /// The smallest box around this box and `point`. A point that holds a NaN adds nothing.
    #[inline]
    #[must_use]
    pub fn including(&self, point: Vec3) -> Self {
        self.union(&Self { lo: point, hi: point })
    }

    /// The smallest box around both boxes. An empty box adds nothing.
    #[inline]
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        self.or_empty().around(&other.or_empty())
    }

    /// [`Aabb::union`] for boxes that are [`Aabb::EMPTY`] if they are empty.
    #[inline]
    pub(crate) fn around(&self, other: &Self) -> Self {
        Self { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    /// This box, or [`Aabb::EMPTY`] if it contains no point or holds a NaN. Kernels store only this form.
    #[inline]
    #[must_use]
    pub fn or_empty(&self) -> Self {
        if self.is_empty() { Self::EMPTY } else { *self }
    }

    /// `hi - lo`. Zero if the box is empty.
    #[inline]
    pub fn extent(&self) -> Vec3 {
        if self.is_empty() { Vec3::ZERO } else { self.hi - self.lo }
    }

    /// Length of the diagonal. In `f64` it neither overflows nor vanishes. Zero if the box is empty.
    #[inline]
    pub fn diagonal(&self) -> f64 {
        if self.is_empty() { 0.0 } else { (self.hi.as_dvec3() - self.lo.as_dvec3()).length() }
    }

    /// The middle. Zero if the box is empty.
    #[inline]
    pub fn center(&self) -> Vec3 {
        if self.is_empty() { Vec3::ZERO } else { self.lo * 0.5 + self.hi * 0.5 }
    }
}

/// The part of the surface `f(p) = 0` inside a box, where `f` is a polynomial of second degree in x, y and z. Its
/// normal points to the outside, where `f` is positive.
///
/// The constructors make the named kinds, about the z axis. To rotate, shear or move one, use [`Placed`]. Some
/// surfaces close inside their box: all of a sphere, or the round sides of a cylinder. There the box is wider than
/// the surface by one part in 1024. A box that touched the surface would leave it to rounding whether the points of
/// contact belong to it.
///
/// A quadric with an empty box, or with a coefficient that is NaN or infinite, misses every ray.
///
/// Source: P. Shirley, S. Marschner et al., "Fundamentals of Computer Graphics", implicit surfaces. The kinds are
/// those of any textbook on analytic geometry.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Quadric {
    /// Coefficients of x², y² and z².
    pub squares: Vec3,
    /// Coefficients of yz, zx and xy.
    pub products: Vec3,
    /// Coefficients of x, y and z.
    pub linear: Vec3,
    /// The constant.
    pub constant: f32,
    /// The surface outside this box is cut away. The box is closed.
    pub clip: Aabb,
}

impl Quadric {
    /// How much wider a box is than the surface, where it must not touch it.
    const SLACK: f32 = 1.0 + 1.0 / 1024.0;

    /// A quadric without products and linear terms, in the box from `-half` to `half`.
    fn central(squares: Vec3, constant: f32, half: Vec3) -> Self {
        let clip = Aabb { lo: -half, hi: half };
        Self { squares, products: Vec3::ZERO, linear: Vec3::ZERO, constant, clip }
    }

    /// `x² + y² + z² = radius²`.
    pub fn sphere(radius: f32) -> Self {
        Self::central(Vec3::ONE, -(radius * radius), Vec3::splat(radius * Self::SLACK))
    }

    /// `x²/a² + y²/b² + z²/c² = 1`, with the semi-axes a, b and c.
    pub fn ellipsoid(semi_axes: Vec3) -> Self {
        Self::central((semi_axes * semi_axes).recip(), -1.0, semi_axes * Self::SLACK)
    }

    /// `x² + y² = radius²`, `|z| <= half_height`, without caps.
    pub fn cylinder(radius: f32, half_height: f32) -> Self {
        let round = radius * Self::SLACK;
        Self::central(Vec3::new(1.0, 1.0, 0.0), -(radius * radius), Vec3::new(round, round, half_height))
    }

    /// `x² + y² = (radius/height)²·z²`, `0 <= z <= height`. The apex is the origin. The base has this radius and is
    /// open.
    pub fn cone(radius: f32, height: f32) -> Self {
        let (slope, round) = (radius / height, radius * Self::SLACK);
        let mut cone = Self::central(Vec3::new(1.0, 1.0, -(slope * slope)), 0.0, Vec3::new(round, round, height));
        cone.clip.lo.z = 0.0;
        cone
    }

    /// `x² + y² = radius²·z/height`, `z <= height`: a bowl with this radius at the rim.
    pub fn paraboloid(radius: f32, height: f32) -> Self {
        let round = radius * Self::SLACK;
        Self {
            linear: Vec3::new(0.0, 0.0, -(radius * radius / height)),
            clip: Aabb {
                lo: Vec3::new(-round, -round, height * (1.0 - Self::SLACK)),
                hi: Vec3::new(round, round, height),
            },
            ..Self::central(Vec3::new(1.0, 1.0, 0.0), 0.0, Vec3::ZERO)
        }
    }

    /// `x²/a² + y²/b² = z/height`, `z <= height`: a bowl whose rim is an ellipse with the semi-axes a and b.
    pub fn elliptic_paraboloid(semi_axes: Vec2, height: f32) -> Self {
        let (round, squares) = (semi_axes * Self::SLACK, (semi_axes * semi_axes).recip());
        Self {
            linear: Vec3::new(0.0, 0.0, -height.recip()),
            clip: Aabb {
                lo: Vec3::new(-round.x, -round.y, height * (1.0 - Self::SLACK)),
                hi: Vec3::new(round.x, round.y, height),
            },
            ..Self::central(squares.extend(0.0), 0.0, Vec3::ZERO)
        }
    }

    /// `x²/a² + y²/b² - z²/c² = 1`, `|z| <= half_height`: one piece. Its waist is an ellipse with the semi-axes a and
    /// b.
    pub fn hyperboloid_of_one_sheet(semi_axes: Vec3, half_height: f32) -> Self {
        let squares = (semi_axes * semi_axes).recip();
        let rim = semi_axes.truncate() * Vec2::new(1.0, half_height / semi_axes.z).length() * Self::SLACK;
        Self::central(squares * Vec3::new(1.0, 1.0, -1.0), -1.0, rim.extend(half_height))
    }

    /// `z²/c² - x²/a² - y²/b² = 1`, `|z| <= half_height`: two pieces, from `|z| = c` on. The outside is between them.
    /// Nothing is left if `half_height` is below c.
    pub fn hyperboloid_of_two_sheets(semi_axes: Vec3, half_height: f32) -> Self {
        let squares = (semi_axes * semi_axes).recip();
        // The ellipse at the rim is smaller than that of the asymptotic cone.
        let rim = semi_axes.truncate() * (half_height / semi_axes.z);
        Self::central(squares * Vec3::new(1.0, 1.0, -1.0), 1.0, rim.extend(half_height))
    }

    /// `z = 0`, `|x| <= half_size.x`, `|y| <= half_size.y`: a flat rectangle. Its normal is +z. A ray in the plane
    /// misses.
    pub fn plane(half_size: Vec2) -> Self {
        // The box is not flat, so that rounding cannot cut the surface away.
        let half = half_size.extend(half_size.max_element() * (Self::SLACK - 1.0));
        Self { linear: Vec3::Z, ..Self::central(Vec3::ZERO, 0.0, half) }
    }

    /// `f(point)`.
    #[inline]
    pub fn value(&self, point: Vec3) -> f32 {
        let Vec3 { x, y, z } = point;
        self.squares.dot(point * point)
            + self.products.dot(Vec3::new(y * z, z * x, x * y))
            + self.linear.dot(point)
            + self.constant
    }

    /// M of `f(p) = p·Mp + …`. Nothing is rounded.
    pub(crate) fn matrix(&self) -> DMat3 {
        let (squares, DVec3 { x: yz, y: zx, z: xy }) = (self.squares.as_dvec3(), self.products.as_dvec3() * 0.5);
        DMat3::from_cols(DVec3::new(squares.x, xy, zx), DVec3::new(xy, squares.y, yz), DVec3::new(zx, yz, squares.z))
    }

    /// The normal at a point of the surface: the gradient of `f`, of unit length. Zero where the gradient vanishes,
    /// as at the apex of a cone.
    #[inline]
    pub fn normal(&self, point: Vec3) -> Vec3 {
        let (Vec3 { x, y, z }, Vec3 { x: yz, y: zx, z: xy }) = (point, self.products);
        let mixed = Vec3::new(xy * y + zx * z, xy * x + yz * z, zx * x + yz * y);
        (self.squares * point * 2.0 + mixed + self.linear).normalize_or_zero()
    }

    /// A box around the quadric: its clip box, or [`Aabb::EMPTY`] if it misses every ray.
    #[inline]
    pub fn bounds(&self) -> Aabb {
        if self.is_finite() { self.clip.or_empty() } else { Aabb::EMPTY }
    }

    /// Whether every coefficient is finite.
    #[inline]
    pub fn is_finite(&self) -> bool {
        self.squares.is_finite() & self.products.is_finite() & self.linear.is_finite() & self.constant.is_finite()
    }
}

/// A shape placed in the world by an affine transform: an instance before it is prepared.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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
    fn named_quadrics_pass_through_their_points() {
        let abc = Vec3::new(2.0, 3.0, 4.0);
        let cases = [
            (Quadric::sphere(2.0), Vec3::new(0.0, 2.0, 0.0), Vec3::Y),
            (Quadric::ellipsoid(abc), Vec3::new(0.0, -3.0, 0.0), Vec3::NEG_Y),
            (Quadric::cylinder(2.0, 5.0), Vec3::new(-2.0, 0.0, 5.0), Vec3::NEG_X),
            (Quadric::cone(2.0, 4.0), Vec3::new(0.0, 2.0, 4.0), Vec3::new(0.0, 2.0, -1.0).normalize()),
            (Quadric::paraboloid(2.0, 4.0), Vec3::new(2.0, 0.0, 4.0), Vec3::new(4.0, 0.0, -1.0).normalize()),
            (
                Quadric::elliptic_paraboloid(Vec2::new(2.0, 3.0), 4.0),
                Vec3::new(0.0, 3.0, 4.0),
                Vec3::new(0.0, 2.0 / 3.0, -0.25).normalize(),
            ),
            (Quadric::hyperboloid_of_one_sheet(abc, 8.0), Vec3::new(2.0, 0.0, 0.0), Vec3::X),
            (Quadric::hyperboloid_of_two_sheets(abc, 8.0), Vec3::new(0.0, 0.0, 4.0), Vec3::NEG_Z),
            (Quadric::plane(Vec2::new(2.0, 3.0)), Vec3::new(-2.0, 3.0, 0.0), Vec3::Z),
        ];
        for (quadric, point, normal) in cases {
            assert!(quadric.value(point).abs() < 1e-6, "{quadric:?} at {point}: {}", quadric.value(point));
            assert!(quadric.normal(point).abs_diff_eq(normal, 1e-6), "{quadric:?}: {}", quadric.normal(point));
            let Aabb { lo, hi } = quadric.bounds();
            assert!(point.cmpge(lo).all() && point.cmple(hi).all(), "{quadric:?}: {point}");
        }
        // The saddle xy = z has the gradient (2, 1, -1) at (1, 2, 2).
        let saddle = Quadric {
            products: Vec3::new(0.0, 0.0, 1.0),
            linear: Vec3::NEG_Z,
            ..Quadric::central(Vec3::ZERO, 0.0, Vec3::splat(9.0))
        };
        assert_eq!(saddle.value(Vec3::new(1.0, 2.0, 2.0)), 0.0);
        let normal = saddle.normal(Vec3::new(1.0, 2.0, 2.0));
        assert!(normal.abs_diff_eq(Vec3::new(2.0, 1.0, -1.0).normalize(), 1e-6), "{normal}");
    }

    #[test]
    fn boxes_with_nan_or_lo_above_hi_are_empty() {
        let triangle = Triangle { v0: Vec3::ZERO, v1: Vec3::new(1.0, f32::NAN, 0.0), v2: Vec3::Y };
        for rotation in 0..3 {
            let [a, b, c] = triangle.vertices();
            let turned = [(a, b, c), (b, c, a), (c, a, b)][rotation];
            assert_eq!(Triangle { v0: turned.0, v1: turned.1, v2: turned.2 }.bounds(), Aabb::EMPTY);
        }
        let upside_down = Aabb { lo: Vec3::ONE, hi: Vec3::new(2.0, 0.5, 2.0) };
        let holding_nan = Aabb { lo: Vec3::ZERO, hi: Vec3::new(1.0, f32::NAN, 1.0) };
        let unit = Aabb { lo: Vec3::ZERO, hi: Vec3::ONE };
        for empty in [upside_down, holding_nan, Aabb::EMPTY] {
            assert_eq!(empty.or_empty(), Aabb::EMPTY);
            assert_eq!((empty.extent(), empty.diagonal(), empty.center()), (Vec3::ZERO, 0.0, Vec3::ZERO));
            assert_eq!((empty.union(&unit), unit.union(&empty)), (unit, unit));
            assert_eq!(empty.including(Vec3::X), Aabb { lo: Vec3::X, hi: Vec3::X });
            assert_eq!(empty.union(&empty), Aabb::EMPTY);
        }
        assert_eq!(unit.including(Vec3::new(2.0, f32::NAN, 0.0)), unit);
        assert_eq!((unit.center(), unit.extent()), (Vec3::splat(0.5), Vec3::ONE));
        let flat = Aabb { lo: Vec3::ZERO, hi: Vec3::new(1.0, 0.0, 1.0) };
        assert_eq!(flat.or_empty(), flat);
    }
}
