//! The shapes that the kit can make, aim at and damage.

use std::fmt::Debug;

use glam::{Affine3, DVec3, Mat3, Vec3};

use super::counts::Counts;
use super::numbers::Numbers;
use super::rust::{affine, float, vec3};
use super::{Options, boxes, triangles};
use crate::geom::{Aabb, Placed, Quadric, Ray, Shape, Triangle};
use crate::kernels::Kernel;

/// A shape whose kernels can be checked. It can be made, aimed at and damaged.
pub trait Aimed: Shape {
    /// What the kit cannot check for this shape, each with the reason.
    const NOT_CHECKED: &'static [&'static str];

    /// A shape of about unit size around the origin, or a sharp one.
    fn any(numbers: &mut Numbers) -> Self;

    /// The point with these weights. Weights of 0 and 1 are on the boundary.
    fn target(&self, weights: Vec3) -> Vec3;

    /// A tangent and a normal of the surface at a point, both about as long as the shape.
    fn tangent_and_normal(&self, target: Vec3) -> (Vec3, Vec3);

    /// Everything multiplied by `factor`.
    #[must_use]
    fn scaled(&self, factor: f32) -> Self;

    /// Replaces one coordinate; `index` counts modulo the number of coordinates.
    #[must_use]
    fn with_coordinate(&self, index: usize, value: f32) -> Self;

    /// Degenerate shapes near this one. Every ray misses them.
    fn degenerate(&self) -> Vec<Self>;

    /// The box that [`Kernel::bounds`] has to return, if it returns one. `None` if it may not return any.
    fn exact_bounds(&self) -> Option<Aabb>;

    /// Counts how many rays break each claim that concerns this shape, whether the kernel makes it or not.
    fn claims<K: Kernel<Shape = Self>>(options: &Options) -> Counts;

    /// An expression in Rust that makes this shape, if `glam::*` and `raylanes::geom::*` are imported.
    fn to_rust(&self) -> String;
}

impl Aimed for Triangle {
    const NOT_CHECKED: &'static [&'static str] = &[
        "right-decision of rays whose exact answer needs more than 128 bits: needs the oracle (feature `study`)",
        "the errors of t, u and v: need the oracle",
    ];

    fn any(numbers: &mut Numbers) -> Self {
        let kind = numbers.choose([8, 2, 1]);
        let (v0, v1) = (numbers.point(), numbers.point());
        let v2 = match kind {
            0 => numbers.point(),
            1 => v0 + (v1 - v0) * numbers.between(0.0, 1.0) + numbers.point() * numbers.power_of_ten(-7, 0),
            _ => v0 + (v1 - v0) * numbers.between(0.0, 2.0),
        };
        Self { v0, v1, v2 }
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
        Self { v0: self.v0 * factor, v1: self.v1 * factor, v2: self.v2 * factor }
    }

    fn with_coordinate(&self, index: usize, value: f32) -> Self {
        let mut vertices = self.vertices();
        vertices[index / 3 % 3][index % 3] = value;
        let [v0, v1, v2] = vertices;
        Self { v0, v1, v2 }
    }

    fn degenerate(&self) -> Vec<Self> {
        let Self { v0, v1, v2 } = *self;
        // On one line, exactly, because two coordinates are equal.
        let along_x = |vertex: Vec3| Vec3 { x: vertex.x, ..v0 };
        vec![
            Self { v0, v1: v0, v2 },
            Self { v0, v1, v2: v0 },
            Self { v0, v1, v2: v1 },
            Self { v0, v1: v0, v2: v0 },
            Self { v0, v1: along_x(v1), v2: along_x(v2) },
        ]
    }

    fn exact_bounds(&self) -> Option<Aabb> {
        Some(self.bounds())
    }

    fn claims<K: Kernel<Shape = Self>>(options: &Options) -> Counts {
        triangles::Inputs::new(options).count::<K>()
    }

    fn to_rust(&self) -> String {
        let [v0, v1, v2] = self.vertices().map(vec3);
        format!("Triangle {{ v0: {v0}, v1: {v1}, v2: {v2} }}")
    }
}

impl Aimed for Aabb {
    const NOT_CHECKED: &'static [&'static str] = &["the errors of entry and exit: need the oracle (feature `study`)"];

    fn any(numbers: &mut Numbers) -> Self {
        let is_inverted = numbers.choose([8, 1]) == 1;
        let lo = numbers.point();
        if is_inverted {
            return Self { lo, hi: numbers.point() };
        }
        let extent = [(); 3].map(|()| match numbers.choose([2, 4, 1]) {
            0 => numbers.small_whole(),
            1 => numbers.between(0.0, 4.0),
            _ => 0.0,
        });
        Self { lo, hi: lo + Vec3::from(extent) }
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
        Self { lo: self.lo * factor, hi: self.hi * factor }
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

    fn degenerate(&self) -> Vec<Self> {
        // With `lo` above `hi` on one axis. A flat box is not degenerate: rays can hit it.
        let inverted = |axis| {
            let mut inverted = *self;
            (inverted.lo[axis], inverted.hi[axis]) = (self.hi[axis], self.lo[axis]);
            (inverted.lo[axis] > inverted.hi[axis]).then_some(inverted)
        };
        [0, 1, 2].into_iter().filter_map(inverted).chain([Self::EMPTY]).collect()
    }

    fn exact_bounds(&self) -> Option<Aabb> {
        Some(self.or_empty())
    }

    fn claims<K: Kernel<Shape = Self>>(options: &Options) -> Counts {
        boxes::count::<K>(options)
    }

    fn to_rust(&self) -> String {
        format!("Aabb {{ lo: {}, hi: {} }}", vec3(self.lo), vec3(self.hi))
    }
}

/// One of the named kinds, with sizes from 0.1 to 4.
fn named(numbers: &mut Numbers) -> Quadric {
    let kind = numbers.below(8);
    let mut size = || if numbers.choose([3, 2]) == 0 { numbers.small_whole() } else { numbers.between(0.1, 4.0) };
    let (axes, height) = (Vec3::from([(); 3].map(|()| size())), size());
    match kind {
        0 => Quadric::sphere(axes.x),
        1 => Quadric::ellipsoid(axes),
        2 => Quadric::cylinder(axes.x, height),
        3 => Quadric::cone(axes.x, height),
        4 => Quadric::paraboloid(axes.x, height),
        5 => Quadric::elliptic_paraboloid(axes.truncate(), height),
        6 => Quadric::hyperboloid_of_one_sheet(axes, height),
        _ => Quadric::hyperboloid_of_two_sheets(axes, axes.z + height),
    }
}

/// Any coefficients and any box. Some polynomials are nearly or exactly linear.
fn general(numbers: &mut Numbers) -> Quadric {
    let [square, product] = [(); 2].map(|()| match numbers.choose([3, 2, 1, 1]) {
        0 => 1.0,
        1 => numbers.power_of_ten(-30, 0),
        2 => 0.0,
        _ => -0.0,
    });
    let (squares, products, linear) = (numbers.point() * square, numbers.point() * product, numbers.point());
    let (constant, lo) = (numbers.coordinate(), numbers.point());
    let extent = if numbers.choose([1, 2]) == 0 { numbers.small_whole() } else { numbers.between(0.5, 6.0) };
    Quadric { squares, products, linear, constant, clip: Aabb { lo, hi: lo + extent } }
}

impl Aimed for Quadric {
    const NOT_CHECKED: &'static [&'static str] =
        &["right-decision and no-gross-error: need the oracle (feature `study`)", "the errors of t: need the oracle"];

    fn any(numbers: &mut Numbers) -> Self {
        match numbers.choose([15, 4, 1, 1]) {
            0 => named(numbers),
            1 => general(numbers),
            2 => Self { clip: Aabb { lo: Vec3::NEG_INFINITY, hi: Vec3::INFINITY }, ..named(numbers) },
            _ => Self { clip: Aabb { lo: numbers.point(), hi: numbers.point() }, ..named(numbers) },
        }
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
        Self {
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

    fn degenerate(&self) -> Vec<Self> {
        let boxes = self.clip.degenerate().into_iter().map(|clip| Self { clip, ..*self });
        boxes.chain([Self { constant: f32::INFINITY, ..*self }]).collect()
    }

    fn exact_bounds(&self) -> Option<Aabb> {
        Some(self.bounds())
    }

    fn claims<K: Kernel<Shape = Self>>(_: &Options) -> Counts {
        Counts::default()
    }

    fn to_rust(&self) -> String {
        let [squares, products, linear] = [self.squares, self.products, self.linear].map(vec3);
        let (constant, clip) = (float(self.constant), self.clip.to_rust());
        format!(
            "Quadric {{ squares: {squares}, products: {products}, linear: {linear}, constant: {constant}, \
             clip: {clip} }}"
        )
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
    const NOT_CHECKED: &'static [&'static str] = &["the errors of hits: need the oracle (feature `study`)"];

    fn any(numbers: &mut Numbers) -> Self {
        let matrix3 = match numbers.choose([3, 4, 1]) {
            0 => Mat3::IDENTITY,
            1 => Mat3::from_cols(numbers.point(), numbers.point(), numbers.point()),
            _ => Mat3::from_diagonal(numbers.point()),
        };
        let translation = numbers.point() * numbers.power_of_ten(0, 4);
        Self { shape: S::any(numbers), object_to_world: Affine3 { matrix3, translation } }
    }

    fn target(&self, weights: Vec3) -> Vec3 {
        self.object_to_world.transform_point3(self.shape.target(weights))
    }

    fn tangent_and_normal(&self, target: Vec3) -> (Vec3, Vec3) {
        let (tangent, normal) = self.shape.tangent_and_normal(self.object_to_world.inverse().transform_point3(target));
        (self.object_to_world.transform_vector3(tangent), self.object_to_world.transform_vector3(normal))
    }

    fn scaled(&self, factor: f32) -> Self {
        Self { shape: self.shape.scaled(factor), ..*self }
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

    fn degenerate(&self) -> Vec<Self> {
        let mut flat = *self;
        flat.object_to_world.matrix3.z_axis = Vec3::ZERO;
        let shapes = self.shape.degenerate().into_iter().map(|shape| Self { shape, ..*self });
        shapes.chain([flat]).collect()
    }

    fn exact_bounds(&self) -> Option<Aabb> {
        None
    }

    fn claims<K: Kernel<Shape = Self>>(_: &Options) -> Counts {
        Counts::default()
    }

    fn to_rust(&self) -> String {
        format!("Placed {{ shape: {}, object_to_world: {} }}", self.shape.to_rust(), affine(&self.object_to_world))
    }
}

/// The lines that make a ray and a shape in Rust.
pub(super) fn pair_to_rust<S: Aimed + Debug>(ray: &Ray<f32>, shape: &S) -> String {
    format!("let ray = {};\nlet shape = {};\n", super::rust::ray(ray), shape.to_rust())
}
