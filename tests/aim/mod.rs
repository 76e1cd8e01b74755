//! Random shapes, and rays aimed at them, as proptest strategies, which can shrink a failing case.
//!
//! Uniformly random rays miss nearly everything. They never meet an edge or a corner exactly, never run along a plane,
//! and never contain a number at the end of the range. These rays do.

use glam::{Affine3, DVec3, Mat3, Vec3};
use proptest::prelude::*;
use raylanes::geom::{Aabb, Placed, Quadric, Ray, Triangle};
use raylanes::kernels::Shape;

/// Eight rays and eight shapes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Case<S> {
    pub shapes: [S; 8],
    pub rays: [Ray<f32>; 8],
}

/// A shape that rays can be aimed at.
pub(crate) trait Aimed: Shape {
    /// A shape of about unit size around the origin, or a sharp one.
    fn any() -> BoxedStrategy<Self>;

    /// The point with these weights. Weights of 0 and 1 are on the boundary.
    fn target(&self, weights: Vec3) -> Vec3;

    /// A tangent and a normal of the surface at a point, both about as long as the shape.
    fn tangent_and_normal(&self, target: Vec3) -> (Vec3, Vec3);

    /// Everything multiplied by `factor`.
    fn scaled(&self, factor: f32) -> Self;

    /// Replaces one coordinate; `index` counts modulo the number of coordinates.
    fn with_coordinate(&self, index: usize, value: f32) -> Self;
}

/// Special numbers: zeros and infinities of both signs, NaN, subnormals, the ends of the range.
const SHARP: [f32; 14] = [
    0.0,
    -0.0,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
    1e-45,
    -1e-40,
    f32::MIN_POSITIVE,
    -1e-38,
    1e38,
    -1e38,
    f32::MAX,
    f32::MIN,
    1e-20,
];

/// Small whole numbers, whose products are exact, and other numbers.
fn coordinate() -> impl Strategy<Value = f32> {
    prop_oneof![2 => (-4i8..=4).prop_map(f32::from), 3 => -4.0f32..4.0, 1 => Just(-0.0f32)]
}

fn point() -> impl Strategy<Value = Vec3> {
    [coordinate(), coordinate(), coordinate()].prop_map(Vec3::from)
}

/// 1, or a power of ten from the whole range.
fn scale() -> impl Strategy<Value = f32> {
    prop_oneof![6 => Just(1.0f32), 1 => (-38i32..=37).prop_map(|exponent| 10f32.powi(exponent))]
}

fn weight() -> impl Strategy<Value = f32> {
    prop_oneof![2 => Just(0.0f32), 2 => Just(1.0f32), 1 => Just(0.5f32), 5 => 0.0f32..1.0, 1 => -0.5f32..1.5]
}

/// How one ray is aimed at its shape.
#[derive(Clone, Debug)]
struct Aim {
    weights: Vec3,
    dir: Vec3,
    /// The direction is a tangent, turned towards the normal by this angle.
    grazing: Option<f32>,
    distance: f32,
    dir_scale: f32,
    interval: Interval,
    corrupted: Option<(usize, f32)>,
}

#[derive(Clone, Debug)]
enum Interval {
    Ahead,
    Line,
    EndsAtTarget,
    StartsAtTarget,
    OnlyTarget,
    Empty,
    Between(f32, f32),
}

fn aim() -> impl Strategy<Value = Aim> {
    let dir_component =
        prop_oneof![2 => Just(0.0f32), 1 => Just(-0.0f32), 1 => Just(1.0f32), 1 => Just(-1.0f32), 4 => -1.0f32..1.0];
    let grazing = (-7i32..=-1).prop_map(|exponent| 10f32.powi(exponent));
    let distance = prop_oneof![
        3 => 0.0f32..10.0,
        2 => (1u8..=8).prop_map(f32::from),
        1 => Just(0.0f32),
        1 => -3.0f32..0.0,
        1 => (2i32..=6).prop_map(|exponent| 10f32.powi(exponent)),
    ];
    let interval = prop_oneof![
        6 => Just(Interval::Ahead),
        2 => Just(Interval::Line),
        1 => Just(Interval::EndsAtTarget),
        1 => Just(Interval::StartsAtTarget),
        1 => Just(Interval::OnlyTarget),
        1 => Just(Interval::Empty),
        1 => (-5.0f32..5.0, -5.0f32..20.0).prop_map(|(a, b)| Interval::Between(a, b)),
    ];
    (
        [weight(), weight(), weight()].prop_map(Vec3::from),
        [dir_component.clone(), dir_component.clone(), dir_component].prop_map(Vec3::from),
        prop_oneof![4 => Just(None), 1 => grazing.prop_map(Some)],
        distance,
        scale(),
        interval,
        prop_oneof![12 => Just(None), 1 => (0..8usize, prop::sample::select(&SHARP[..])).prop_map(Some)],
    )
        .prop_map(|(weights, dir, grazing, distance, dir_scale, interval, corrupted)| Aim {
            weights,
            dir,
            grazing,
            distance,
            dir_scale,
            interval,
            corrupted,
        })
}

impl Aim {
    fn at(&self, shape: &impl Aimed) -> Ray<f32> {
        let target = shape.target(self.weights);
        let (tangent, normal) = shape.tangent_and_normal(target);
        let dir = match self.grazing {
            Some(angle) => tangent + normal * angle,
            // In proportion to the shape: the distance is then in proportion too.
            None => self.dir * (tangent.abs().max_element() + normal.abs().max_element()),
        } * self.dir_scale;
        let distance = self.distance / self.dir_scale;
        let (t_min, t_max) = match self.interval {
            Interval::Ahead => (0.0, f32::INFINITY),
            Interval::Line => (f32::NEG_INFINITY, f32::INFINITY),
            Interval::EndsAtTarget => (0.0, distance),
            Interval::StartsAtTarget => (distance, f32::MAX),
            Interval::OnlyTarget => (distance, distance),
            Interval::Empty => (1.0, 0.5),
            Interval::Between(t_min, t_max) => (t_min, t_max),
        };
        let mut ray = Ray { origin: target - dir * distance, dir, t_min, t_max };
        if let Some((field, value)) = self.corrupted {
            match field {
                0..3 => ray.origin[field] = value,
                3..6 => ray.dir[field - 3] = value,
                6 => ray.t_min = value,
                _ => ray.t_max = value,
            }
        }
        ray
    }
}

/// Packets of rays aimed at packets of shapes.
pub(crate) fn cases<S: Aimed>() -> impl Strategy<Value = Case<S>> {
    // Some shapes are copies of the first: rays aimed at the first hit them too.
    let variant = prop_oneof![1 => Just(None), 1 => S::any().prop_map(Some)];
    let corrupted = prop_oneof![12 => Just(None), 1 => (0..9usize, prop::sample::select(&SHARP[..])).prop_map(Some)];
    (
        S::any(),
        prop::array::uniform7(variant),
        scale(),
        prop::array::uniform8(aim()),
        any::<[bool; 8]>(),
        prop::array::uniform8(corrupted),
    )
        .prop_map(|(first, others, scale, aims, at_first, corrupted)| {
            let clean: [S; 8] = std::array::from_fn(|index| match index {
                0 => first.scaled(scale),
                _ => others[index - 1].unwrap_or(first).scaled(scale),
            });
            Case {
                rays: std::array::from_fn(|lane| aims[lane].at(&clean[if at_first[lane] { 0 } else { lane }])),
                shapes: std::array::from_fn(|index| match corrupted[index] {
                    Some((coordinate, value)) => clean[index].with_coordinate(coordinate, value),
                    None => clean[index],
                }),
            }
        })
}

impl Aimed for Triangle {
    fn any() -> BoxedStrategy<Self> {
        let free = (point(), point(), point()).prop_map(|(v0, v1, v2)| Triangle { v0, v1, v2 });
        let sliver = (point(), point(), 0.0f32..1.0, point(), -7i32..=-1).prop_map(|(v0, v1, along, off, exponent)| {
            Triangle { v0, v1, v2: v0 + (v1 - v0) * along + off * 10f32.powi(exponent) }
        });
        let degenerate =
            (point(), point(), 0.0f32..2.0).prop_map(|(v0, v1, along)| Triangle { v0, v1, v2: v0 + (v1 - v0) * along });
        prop_oneof![8 => free, 2 => sliver, 1 => degenerate].boxed()
    }

    fn target(&self, weights: Vec3) -> Vec3 {
        let [u, v] = [weights.x, weights.y * (1.0 - weights.x)];
        if weights.z == 1.0 { self.v1 + (self.v2 - self.v1) * v } else { self.point(u, v) }
    }

    fn tangent_and_normal(&self, _: Vec3) -> (Vec3, Vec3) {
        let (e1, e2) = (self.v1 - self.v0, self.v2 - self.v0);
        (e1, e1.cross(e2).normalize_or_zero() * e1.abs().max_element())
    }

    fn scaled(&self, factor: f32) -> Self {
        Triangle { v0: self.v0 * factor, v1: self.v1 * factor, v2: self.v2 * factor }
    }

    fn with_coordinate(&self, index: usize, value: f32) -> Self {
        let mut vertices = self.vertices();
        vertices[index / 3 % 3][index % 3] = value;
        let [v0, v1, v2] = vertices;
        Triangle { v0, v1, v2 }
    }
}

impl Aimed for Aabb {
    fn any() -> BoxedStrategy<Self> {
        let extent = || prop_oneof![4 => 0.0f32..4.0, 2 => (1u8..=4).prop_map(f32::from), 1 => Just(0.0f32)];
        let proper = (point(), [extent(), extent(), extent()].prop_map(Vec3::from))
            .prop_map(|(lo, extent)| Aabb { lo, hi: lo + extent });
        let inverted = (point(), point()).prop_map(|(lo, hi)| Aabb { lo, hi });
        prop_oneof![8 => proper, 1 => inverted].boxed()
    }

    fn target(&self, weights: Vec3) -> Vec3 {
        Vec3::from([0, 1, 2].map(|axis| match weights[axis] {
            0.0 => self.lo[axis],
            1.0 => self.hi[axis],
            weight => self.lo[axis] + (self.hi[axis] - self.lo[axis]) * weight,
        }))
    }

    fn tangent_and_normal(&self, _: Vec3) -> (Vec3, Vec3) {
        let extent = self.hi - self.lo;
        (Vec3::new(0.0, extent.y, extent.z), Vec3::X * extent.max_element())
    }

    fn scaled(&self, factor: f32) -> Self {
        Aabb { lo: self.lo * factor, hi: self.hi * factor }
    }

    fn with_coordinate(&self, index: usize, value: f32) -> Self {
        let mut changed = *self;
        if index.is_multiple_of(2) {
            changed.lo[index / 2 % 3] = value;
        } else {
            changed.hi[index / 2 % 3] = value;
        }
        changed
    }
}

/// One of the named kinds, with sizes from 0.1 to 4.
fn named() -> impl Strategy<Value = Quadric> {
    let size = || prop_oneof![2 => 0.1f32..4.0, 3 => (1u8..=4).prop_map(f32::from)];
    (0..8u8, [size(), size(), size()].prop_map(Vec3::from), size()).prop_map(|(kind, axes, height)| match kind {
        0 => Quadric::sphere(axes.x),
        1 => Quadric::ellipsoid(axes),
        2 => Quadric::cylinder(axes.x, height),
        3 => Quadric::cone(axes.x, height),
        4 => Quadric::paraboloid(axes.x, height),
        5 => Quadric::elliptic_paraboloid(axes.truncate(), height),
        6 => Quadric::hyperboloid_of_one_sheet(axes, height),
        _ => Quadric::hyperboloid_of_two_sheets(axes, axes.z + height),
    })
}

/// Any coefficients and any box. Some polynomials are nearly or exactly linear.
fn general() -> impl Strategy<Value = Quadric> {
    let flatness = prop_oneof![
        3 => Just(1.0f32),
        2 => (1i32..=30).prop_map(|exponent| 10f32.powi(-exponent)),
        1 => Just(0.0f32),
        1 => Just(-0.0f32),
    ];
    let extent = prop_oneof![1 => (1u8..=4).prop_map(f32::from), 2 => 0.5f32..6.0];
    (point(), point(), point(), coordinate(), flatness.clone(), flatness, point(), extent).prop_map(
        |(squares, products, linear, constant, square, product, lo, extent)| Quadric {
            squares: squares * square,
            products: products * product,
            linear,
            constant,
            clip: Aabb { lo, hi: lo + extent },
        },
    )
}

impl Aimed for Quadric {
    fn any() -> BoxedStrategy<Self> {
        let unclipped = named().prop_map(|quadric| {
            let clip = Aabb { lo: Vec3::NEG_INFINITY, hi: Vec3::INFINITY };
            Quadric { clip, ..quadric }
        });
        let inverted =
            (named(), point(), point()).prop_map(|(quadric, lo, hi)| Quadric { clip: Aabb { lo, hi }, ..quadric });
        prop_oneof![15 => named(), 4 => general(), 1 => unclipped, 1 => inverted].boxed()
    }

    /// The weights give two coordinates within the box. The third is on the surface, if the surface has a point there.
    fn target(&self, weights: Vec3) -> Vec3 {
        let frame = frame(self);
        let within = frame.target(weights);
        // A coordinate on a plane of the box stays there.
        let on_side = |axis: &usize| weights[*axis] == 0.0 || weights[*axis] == 1.0;
        let mut axes = [2, 1, 0];
        axes.sort_by_key(on_side);
        for axis in axes {
            let mut direction = DVec3::ZERO;
            direction[axis] = 1.0;
            let mut target = within.as_dvec3();
            target[axis] = 0.0;
            // Along an axis, three values determine the polynomial.
            let [f0, f1, f2] = [0.0, 1.0, -1.0].map(|t| value(self, target + direction * t));
            let (a, b, c) = ((f1 + f2) * 0.5 - f0, (f1 - f2) * 0.5, f0);
            let root = (b * b - 4.0 * a * c).sqrt() * if weights[axis] < 0.5 { -1.0 } else { 1.0 };
            let t = if a == 0.0 { -c / b } else { (root - b) / (2.0 * a) };
            if t >= f64::from(frame.lo[axis]) && t <= f64::from(frame.hi[axis]) {
                target[axis] = t;
                return target.as_vec3();
            }
        }
        within
    }

    fn tangent_and_normal(&self, target: Vec3) -> (Vec3, Vec3) {
        let size = frame(self).extent().max_element();
        let normal = self.normal(target);
        // For a surface of revolution about z: around the axis, or along a generatrix.
        let across = normal.cross(Vec3::new(0.01, 0.02, 1.0)).normalize_or_zero();
        let round = normal.cross(Vec3::Z).normalize_or_zero();
        let tangent = if target.x > target.y { across } else { round.cross(normal) };
        (tangent * size, normal * size)
    }

    fn scaled(&self, factor: f32) -> Self {
        Quadric {
            squares: self.squares / factor,
            products: self.products / factor,
            linear: self.linear,
            constant: self.constant * factor,
            clip: self.clip.scaled(factor),
        }
    }

    fn with_coordinate(&self, index: usize, value: f32) -> Self {
        let mut changed = *self;
        *match index % 9 {
            0 => &mut changed.squares.x,
            1 => &mut changed.squares.z,
            2 => &mut changed.products.y,
            3 => &mut changed.products.z,
            4 => &mut changed.linear.x,
            5 => &mut changed.linear.y,
            6 => &mut changed.constant,
            7 => &mut changed.clip.lo.z,
            _ => &mut changed.clip.hi.x,
        } = value;
        changed
    }
}

/// The clip box, or a finite one in place of an infinite box.
fn frame(quadric: &Quadric) -> Aabb {
    let clip = quadric.clip;
    if clip.lo.is_finite() && clip.hi.is_finite() { clip } else { Aabb { lo: Vec3::splat(-4.0), hi: Vec3::splat(4.0) } }
}

/// [`Quadric::value`] in `f64`.
fn value(quadric: &Quadric, point: DVec3) -> f64 {
    let DVec3 { x, y, z } = point;
    quadric.squares.as_dvec3().dot(point * point)
        + quadric.products.as_dvec3().dot(DVec3::new(y * z, z * x, x * y))
        + quadric.linear.as_dvec3().dot(point)
        + f64::from(quadric.constant)
}

impl<S: Aimed> Aimed for Placed<S> {
    fn any() -> BoxedStrategy<Self> {
        let free = (point(), point(), point()).prop_map(|(x, y, z)| Mat3::from_cols(x, y, z));
        let diagonal = point().prop_map(Mat3::from_diagonal);
        let linear = prop_oneof![3 => Just(Mat3::IDENTITY), 4 => free, 1 => diagonal];
        let translation = (point(), 0i32..=3).prop_map(|(p, exponent)| p * 10f32.powi(exponent));
        (S::any(), linear, translation)
            .prop_map(|(shape, matrix3, translation)| Placed {
                shape,
                object_to_world: Affine3 { matrix3, translation },
            })
            .boxed()
    }

    fn target(&self, weights: Vec3) -> Vec3 {
        self.object_to_world.transform_point3(self.shape.target(weights))
    }

    fn tangent_and_normal(&self, target: Vec3) -> (Vec3, Vec3) {
        let (tangent, normal) = self.shape.tangent_and_normal(self.object_to_world.inverse().transform_point3(target));
        (self.object_to_world.transform_vector3(tangent), self.object_to_world.transform_vector3(normal))
    }

    fn scaled(&self, factor: f32) -> Self {
        Placed { shape: self.shape.scaled(factor), ..*self }
    }

    fn with_coordinate(&self, index: usize, value: f32) -> Self {
        let mut changed = *self;
        if index.is_multiple_of(3) {
            changed.object_to_world.matrix3.x_axis[index / 3 % 3] = value;
        } else {
            changed.shape = self.shape.with_coordinate(index, value);
        }
        changed
    }
}
