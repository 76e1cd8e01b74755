//! Quadrics: surfaces of second degree. Along the ray, the surface's equation becomes a polynomial of second degree
//! in `t`. Its roots within the ray's interval and the surface's clip box are candidates. Both count: the ray may
//! pass the nearer root outside the box, where the surface is cut away, and hit the inner side at the other. Every
//! hit has `u = v = 0`. The normal is the gradient, [`Quadric::normal`].
//!
//! # Where the box cuts
//!
//! A root has a rounding error, and so has the interval of the box ([`Padded`](super::aabb::Padded)). From far away,
//! an ulp of `t` is longer than the gap between a sphere and its box. So a root counts within an interval that is
//! longer at both ends by the error bound. The reported `t` is then clamped to the entry as the slab test computes
//! it. No box around this one is entered later. So a tree of boxes can be culled by the slab test, and the closest
//! hit does not depend on the shape of the tree.
//!
//! # What kernels lose, and where
//!
//! The polynomial is `a·t² + 2b·t + c`, its discriminant `b² - a·c`. The discriminant is about the square of the
//! surface's size. Its terms are about the square of the distance of the point about which they are expanded. From a
//! thousand sizes away nothing is left of the difference. So `stable`, `mixed` and `f64` first move an origin outside
//! the box along the ray, to a point near the surface. `sphere` and `interval` compute the discriminant from the point
//! of the ray that is closest to the centre. In `-b ± √D` the root of the smaller magnitude is lost a second time where
//! b² is much larger than a·c: next to the surface, or where `a` is small. All of these kernels compute it from the
//! other root.

pub mod interval;
pub mod mixed;
pub mod naive;
// The file has the name of the kernel's ID. A module `f64` would hide the type `f64` in this file.
#[path = "f64.rs"]
pub mod quadric_f64;
pub mod sphere;
pub mod stable;

#[doc(inline)]
pub use interval::QuadricInterval;
#[doc(inline)]
pub use mixed::Mixed;
#[doc(inline)]
pub use naive::Naive;
#[doc(inline)]
pub use quadric_f64::QuadricF64;
#[doc(inline)]
pub use sphere::Sphere;
#[doc(inline)]
pub use stable::Stable;

use glam::{DVec3, Vec3};
use wide::{f32x8, f64x8};

use crate::geom::lanes::{
    DVec3x8, Lanes, Mask8, Vec3x8, dot_f64x8, double8, ge8, le8, lt8, max, max8, min, min8, power_of_two,
    power_of_two8, sign_bit, sign_bit8, sqrt, sqrt8, t_in_range, t_in_range8,
};
use crate::geom::{Aabb, Candidate, Quadric, Ray};
use crate::kernels::aabb::{InverseDirection, Slabs, pad, pad8, slab_interval, slab_interval8};
use crate::kernels::{Operations, power_of_two_below};

/// The part of a ray inside the clip box of a quadric.
#[derive(Clone, Copy, Debug)]
struct ClipInterval<L: Lanes> {
    /// Entry and exit of the whole line, without the ray's interval. The origin may be moved between them.
    line: [L; 2],
    /// Start of the ray's own interval.
    t_min: L,
    /// Entry, moved out by its error bound.
    earliest: L,
    /// Entry within the ray's interval, as every slab test computes it.
    entry: L,
    /// Exit, moved out by its error bound, within the ray's interval.
    exit: L,
}

impl ClipInterval<f32> {
    #[inline(always)]
    fn of(clip: &Slabs<f32>, origin: Vec3, setup: &InverseDirection<f32>) -> Self {
        // Intersect the whole line with the box.
        let line = InverseDirection { inv_dir: setup.inv_dir, t_min: f32::NEG_INFINITY, t_max: f32::INFINITY };
        let (entry, exit) = slab_interval(clip, origin, &line);

        // Cut it to the ray's interval, and move its ends out by their error bounds.
        Self {
            line: [entry, exit],
            t_min: setup.t_min,
            earliest: -pad(-entry, f32::INFINITY),
            entry: max(entry, setup.t_min),
            exit: pad(exit, setup.t_max),
        }
    }

    /// The point nearest to `t` between entry and exit of the whole line.
    #[inline(always)]
    fn clamp(&self, t: f32) -> f32 {
        let [entry, exit] = self.line;
        min(max(t, entry), exit)
    }

    /// The `t` to which a kernel moves the origin if it loses nothing between there and the surface. From inside the
    /// box it is 0, and short distances keep their digits. From outside it is a point of the box: the one where the
    /// ray is closest to the coordinates' origin.
    #[inline(always)]
    fn start(&self, origin: Vec3, to_closest: Vec3) -> f32 {
        let [entry, exit] = self.line;
        let inside = (entry <= 0.0) & (exit >= 0.0);
        // A mask instead of a branch, which cannot be predicted.
        let kept = u32::from(inside).wrapping_sub(1);
        f32::from_bits(self.clamp(origin.dot(to_closest)).to_bits() & kept)
    }

    /// Whether a hit at `t` lies in the box and in the ray's interval, within the error bounds. False for infinities
    /// and NaN.
    #[inline(always)]
    fn contains(&self, t: f32) -> bool {
        t_in_range(self.t_min, t, self.exit) & (t >= self.earliest) & (self.entry <= self.exit)
    }

    /// The nearer of the two roots, given in any order, among those that count.
    #[inline(always)]
    fn hit(&self, [t0, t1]: [f32; 2]) -> Candidate<f32> {
        let (first, second) = (self.contains(t0), self.contains(t1));
        let t = if first & (!second | (t0 < t1)) { t0 } else { t1 };
        Candidate::<f32>::new(first | second, self.report(t), 0.0, 0.0)
    }

    /// Clamps a `t` that counts. No box around this one is entered later.
    #[inline(always)]
    fn report(&self, t: f32) -> f32 {
        min(max(t, self.entry), self.exit)
    }
}

impl ClipInterval<f32x8> {
    /// [`ClipInterval::<f32>::of`] in eight lanes.
    #[inline(always)]
    fn of(clip: &Slabs<f32x8>, origin: Vec3x8, setup: &InverseDirection<f32x8>) -> Self {
        // Intersect the whole line with the box.
        let line = InverseDirection {
            inv_dir: setup.inv_dir,
            t_min: f32x8::splat(f32::NEG_INFINITY),
            t_max: f32x8::splat(f32::INFINITY),
        };
        let (entry, exit) = slab_interval8(clip, origin, &line);

        // Cut it to the ray's interval, and move its ends out by their error bounds.
        Self {
            line: [entry, exit],
            t_min: setup.t_min,
            earliest: -pad8(-entry, f32x8::splat(f32::INFINITY)),
            entry: max8(entry, setup.t_min),
            exit: pad8(exit, setup.t_max),
        }
    }

    /// [`ClipInterval::<f32>::clamp`] in eight lanes.
    #[inline(always)]
    fn clamp(&self, t: f32x8) -> f32x8 {
        let [entry, exit] = self.line;
        min8(max8(t, entry), exit)
    }

    /// [`ClipInterval::<f32>::start`] in eight lanes.
    #[inline(always)]
    fn start(&self, origin: Vec3x8, to_closest: Vec3x8) -> f32x8 {
        let ([entry, exit], zero) = (self.line, f32x8::ZERO);
        (le8(entry, zero) & ge8(exit, zero)).select(zero, self.clamp(origin.dot(to_closest)))
    }

    /// [`ClipInterval::<f32>::contains`] in eight lanes.
    #[inline(always)]
    fn contains(&self, t: f32x8) -> Mask8 {
        t_in_range8(self.t_min, t, self.exit) & ge8(t, self.earliest) & le8(self.entry, self.exit)
    }

    /// [`ClipInterval::<f32>::hit`] in eight lanes.
    #[inline(always)]
    fn hit(&self, [t0, t1]: [f32x8; 2]) -> Candidate<f32x8> {
        let (first, second) = (self.contains(t0), self.contains(t1));
        let t = (first & (!second | lt8(t0, t1))).select(t0, t1);
        Candidate::<f32x8>::new(first | second, self.report(t), f32x8::ZERO, f32x8::ZERO)
    }

    /// [`ClipInterval::<f32>::report`] in eight lanes.
    #[inline(always)]
    fn report(&self, t: f32x8) -> f32x8 {
        min8(max8(t, self.entry), self.exit)
    }
}

/// The per-ray data of the kernels that move the ray's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach<L: Lanes> {
    slabs: InverseDirection<L>,
    /// `-dir / |dir|²`. Its dot product with the ray's origin is the `t` of the closest approach to 0.
    to_closest: L::Vec3,
    /// `dir / unit`.
    dir: L::Vec3,
    /// A power of two near the magnitude of `dir`. Dividing by it rounds nothing, and squares do not overflow or
    /// underflow.
    unit: L,
    /// `1 / unit`.
    inv_unit: L,
}

/// The largest power of two whose inverse is not subnormal.
const MAX_UNIT: f32 = 1.0 / f32::MIN_POSITIVE;

impl Approach<f32> {
    /// Operations of [`Approach::of`].
    const OPERATIONS: Operations =
        InverseDirection::OPERATIONS.and(Operations { mul: 10, add: 2, compare: 4, div: 2, ..Operations::NONE });

    /// The data of `ray`. Costs five divisions and the validity check.
    #[inline(always)]
    pub fn of(ray: &Ray<f32>) -> Self {
        // Divide the direction by a power of two near its size.
        let size = ray.dir.abs();
        let unit = power_of_two(max(max(size.x, size.y), size.z));
        let unit = min(max(unit, f32::MIN_POSITIVE), MAX_UNIT);
        let inv_unit = 1.0 / unit;
        let d = ray.dir * inv_unit;
        Self {
            slabs: InverseDirection::<f32>::of(ray),
            to_closest: d * (-1.0 / d.dot(d) * inv_unit),
            dir: d,
            unit,
            inv_unit,
        }
    }
}

impl Approach<f32x8> {
    /// [`Approach::<f32>::of`] in eight lanes.
    #[inline(always)]
    pub fn of(ray: &Ray<f32x8>) -> Self {
        // Divide the direction by a power of two near its size.
        let size = Vec3x8 { x: ray.dir.x.abs(), y: ray.dir.y.abs(), z: ray.dir.z.abs() };
        let unit = power_of_two8(max8(max8(size.x, size.y), size.z));
        let unit = min8(max8(unit, f32x8::splat(f32::MIN_POSITIVE)), f32x8::splat(MAX_UNIT));
        let inv_unit = f32x8::ONE / unit;
        let d = ray.dir * inv_unit;
        Self {
            slabs: InverseDirection::<f32x8>::of(ray),
            to_closest: d * (-f32x8::ONE / d.dot(d) * inv_unit),
            dir: d,
            unit,
            inv_unit,
        }
    }
}

prepared! {
    /// `p·Mp + 2h·p + k`: the polynomial about some point, with all coefficients multiplied by one power of two.
    struct Form<P: Lanes> {
        /// Diagonal of M.
        squares: P::Vec3,
        /// yz, zx and xy of M: half the coefficients of the products.
        products: P::Vec3,
        /// h: half the coefficients of x, y and z.
        linear: P::Vec3,
        /// k.
        constant: P,
    }
}

/// 2¹²⁶. Twice as much is still an `f32`.
const LARGE_POWER_OF_TWO: f64 = 1.0 / (f32::MIN_POSITIVE as f64);

impl Form<f32> {
    /// The polynomial about `center`, computed in `f64` and rounded once. Coordinates in the box are then at most
    /// about `size`. The power of two brings the discriminant to about 1, far from both ends of the range.
    fn about(shape: &Quadric, center: Vec3) -> Self {
        let (squares, products) = (shape.squares.as_dvec3(), shape.products.as_dvec3() * 0.5);
        let m = shape.matrix();
        let (at, h) = (center.as_dvec3(), shape.linear.as_dvec3() * 0.5);
        let linear = m * at + h;
        let constant = (linear + h).dot(at) + f64::from(shape.constant);

        let size = size(&shape.clip, center);
        let greatest = |v: DVec3| v.abs().max_element();
        let magnitude = [greatest(squares) * size, greatest(products) * size, greatest(linear), constant.abs() / size];
        let magnitude = magnitude.into_iter().fold(f64::MIN_POSITIVE, f64::max);
        Self::scaled([squares, products, linear], constant, 1.0 / power_of_two_below(magnitude))
    }

    /// The polynomial about 0, for kernels whose discriminant has the whole range of `f64`. The largest coefficient
    /// is scaled to near the end of the range of `f32`. Then no coefficient is lost, however small it is beside the
    /// largest. Those below 2⁻²⁵² of the largest may lose the last two bits.
    fn of(shape: &Quadric) -> Self {
        let (squares, constant) = (shape.squares.as_dvec3(), f64::from(shape.constant));
        let (products, linear) = (shape.products.as_dvec3() * 0.5, shape.linear.as_dvec3() * 0.5);
        let greatest = squares.abs().max(products.abs()).max(linear.abs()).max_element().max(constant.abs());
        let scale = LARGE_POWER_OF_TWO / power_of_two_below(greatest.max(f64::from(f32::MIN_POSITIVE)));
        Self::scaled([squares, products, linear], constant, scale)
    }

    /// Everything times `scale`, rounded once.
    fn scaled([squares, products, linear]: [DVec3; 3], constant: f64, scale: f64) -> Self {
        Self {
            squares: (squares * scale).as_vec3(),
            products: (products * scale).as_vec3(),
            linear: (linear * scale).as_vec3(),
            constant: (constant * scale) as f32,
        }
    }

    /// `Mp + h`: half the gradient.
    #[inline(always)]
    fn half_gradient(&self, p: Vec3) -> Vec3 {
        let (s, m) = (self.squares, self.products);
        Vec3::new(
            s.x * p.x + m.z * p.y + m.y * p.z + self.linear.x,
            m.z * p.x + s.y * p.y + m.x * p.z + self.linear.y,
            m.y * p.x + m.x * p.y + s.z * p.z + self.linear.z,
        )
    }

    /// [`Form::half_gradient`] in `f64`.
    #[inline(always)]
    fn half_gradient_f64(&self, p: DVec3) -> DVec3 {
        let (s, m, h) = (self.squares.as_dvec3(), self.products.as_dvec3(), self.linear.as_dvec3());
        DVec3::new(
            s.x * p.x + m.z * p.y + m.y * p.z + h.x,
            m.z * p.x + s.y * p.y + m.x * p.z + h.y,
            m.y * p.x + m.x * p.y + s.z * p.z + h.z,
        )
    }

    /// `d·Md`: the coefficient of t².
    #[inline(always)]
    fn curvature(&self, d: Vec3) -> f32 {
        self.squares.dot(d * d) + self.products.dot(Vec3::new(d.y * d.z, d.z * d.x, d.x * d.y)) * 2.0
    }

    /// [`Form::curvature`] in `f64`.
    #[inline(always)]
    fn curvature_f64(&self, d: DVec3) -> f64 {
        let (squares, products) = (self.squares.as_dvec3(), self.products.as_dvec3());
        squares.dot(d * d) + products.dot(DVec3::new(d.y * d.z, d.z * d.x, d.x * d.y)) * 2.0
    }
}

impl Form<f32x8> {
    /// [`Form::<f32>::half_gradient`] in eight lanes.
    #[inline(always)]
    fn half_gradient(&self, p: Vec3x8) -> Vec3x8 {
        let (s, m) = (self.squares, self.products);
        Vec3x8 {
            x: s.x * p.x + m.z * p.y + m.y * p.z + self.linear.x,
            y: m.z * p.x + s.y * p.y + m.x * p.z + self.linear.y,
            z: m.y * p.x + m.x * p.y + s.z * p.z + self.linear.z,
        }
    }

    /// [`Form::<f32>::half_gradient_f64`] in eight lanes.
    #[inline(always)]
    fn half_gradient_f64(&self, p: DVec3x8) -> DVec3x8 {
        let [sx, sy, sz] = double8(self.squares);
        let [mx, my, mz] = double8(self.products);
        let [hx, hy, hz] = double8(self.linear);
        [
            sx * p[0] + mz * p[1] + my * p[2] + hx,
            mz * p[0] + sy * p[1] + mx * p[2] + hy,
            my * p[0] + mx * p[1] + sz * p[2] + hz,
        ]
    }

    /// [`Form::<f32>::curvature`] in eight lanes.
    #[inline(always)]
    fn curvature(&self, Vec3x8 { x, y, z }: Vec3x8) -> f32x8 {
        let squares = self.squares.dot(Vec3x8 { x: x * x, y: y * y, z: z * z });
        squares + self.products.dot(Vec3x8 { x: y * z, y: z * x, z: x * y }) * f32x8::splat(2.0)
    }

    /// [`Form::<f32>::curvature_f64`] in eight lanes.
    #[inline(always)]
    fn curvature_f64(&self, [x, y, z]: DVec3x8) -> f64x8 {
        let (squares, products) = (double8(self.squares), double8(self.products));
        dot_f64x8(squares, [x * x, y * y, z * z]) + dot_f64x8(products, [y * z, z * x, x * y]) * f64x8::splat(2.0)
    }
}

/// The roots of `a·t² + 2b·t + c` with the discriminant `b² - a·c`, in any order. An infinite or NaN result is not a
/// root.
///
/// The sum in `q` never cancels. Where `a` is zero, `c/q` is the only root, without a special case. Where `b` is zero
/// too, there is none.
#[inline(always)]
fn roots(discriminant: f32, a: f32, b: f32, c: f32) -> [f32; 2] {
    // Take the root of the discriminant. An infinite q would make c/q a root at 0.
    let root = if discriminant < f32::INFINITY { sqrt(discriminant) } else { f32::NAN };

    // Add numbers of one sign only.
    let q = -(b + if sign_bit(b) { -root } else { root });
    [q / a, c / q]
}

/// [`roots`] in eight lanes.
#[inline(always)]
fn roots8(discriminant: f32x8, a: f32x8, b: f32x8, c: f32x8) -> [f32x8; 2] {
    // Take the root of the discriminant. An infinite q would make c/q a root at 0.
    let finite = lt8(discriminant, f32x8::splat(f32::INFINITY));
    let root = finite.select(sqrt8(discriminant), f32x8::splat(f32::NAN));

    // Add numbers of one sign only.
    let q = -(b + sign_bit8(b).select(-root, root));
    [q / a, c / q]
}

/// The point about which to expand. On each axis it is 0 where the box contains 0, and else the middle of the box.
/// The named kinds contain their own centre or apex, 0, and their coefficients are given about it. These coefficients
/// are then not rounded.
fn center(clip: &Aabb) -> Vec3 {
    Vec3::from([0, 1, 2].map(|axis| {
        let (lo, hi) = (clip.lo[axis], clip.hi[axis]);
        let middle = lo * 0.5 + hi * 0.5;
        if (lo <= 0.0) & (hi >= 0.0) {
            0.0
        } else if middle.is_finite() {
            middle
        } else {
            // The box is infinite on one side. Take the other.
            if lo > 0.0 { lo } else { hi }
        }
    }))
}

/// The largest distance, along an axis, from `center` to a finite side of the box. 1 if there is none.
fn size(clip: &Aabb, center: Vec3) -> f64 {
    let distances = [clip.lo, clip.hi].map(|corner| (corner.as_dvec3() - center.as_dvec3()).abs().to_array());
    let finite = distances.as_flattened().iter().filter(|distance| distance.is_finite());
    let size = finite.fold(0.0, |size: f64, &distance| size.max(distance));
    if size > 0.0 { size } else { 1.0 }
}
