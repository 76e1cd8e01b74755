//! The inputs of the study: named, seeded sets of primitives and rays.
//!
//! All rays are aimed, since uniformly random rays show almost no difference between kernels. Two workloads are simple:
//! `generic` and `edge`. The others are regimes: they get harder along an axis, in steps, until the weaker methods
//! fail.
//!
//! Inputs are the same bits on every machine and in every build. They are made with sums, products, divisions and
//! square roots only, and without sines, whose last digit varies between machines.

mod aabb;
mod depth;
mod horizon;
mod leaving;
mod orders;
mod placed;
mod quadric;
mod random;
mod silhouette;
mod t_junction;
mod thin;
mod triangle;

use glam::{Affine3, Mat3, Vec2, Vec3};
use rand::RngExt;
use rand_pcg::Pcg64;

pub(super) use self::random::direction;
use self::random::{frame, in_disc, in_square, sign};
pub use self::random::{in_cube, rng, whole};

use crate::geom::{Aabb, Placed, Quadric, Ray, Triangle};
use crate::oracle::Exact;
use crate::registry::Registered;

/// A workload without an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Workload {
    /// One primitive of about unit size, and rays aimed into it or past it from a few units away.
    Generic,
    /// Rays aimed at edges, vertices, corners and planes.
    ///
    /// For triangles: a fan of eight that all face the rays, in random positions or on a grid, where rays meet edges
    /// exactly. For quadrics: tangent rays, and rays at the rim (where the box clips), at an apex, or with an end of
    /// their interval on the surface.
    Edge,
}

impl Workload {
    /// Every workload.
    pub const ALL: [Self; 2] = [Self::Generic, Self::Edge];

    /// The name used in records.
    pub fn name(self) -> &'static str {
        match self {
            Self::Generic => "generic",
            Self::Edge => "edge",
        }
    }
}

/// Rays per sample. All of them are tested against the same primitives.
pub const RAYS_PER_SAMPLE: usize = 16;

/// One primitive or a small mesh, and rays aimed at it.
#[derive(Clone, Debug)]
pub struct Sample<S> {
    /// One primitive, or the triangles of a mesh.
    pub shapes: Vec<S>,
    /// [`RAYS_PER_SAMPLE`] rays.
    pub rays: Vec<Ray<f32>>,
}

impl<S> Sample<S> {
    /// One shape, and a call of `ray` for each ray.
    fn of(shape: S, rng: &mut Pcg64, ray: impl Fn(&S, &mut Pcg64) -> Ray<f32>) -> Self {
        let rays = (0..RAYS_PER_SAMPLE).map(|_| ray(&shape, rng)).collect();
        Self { shapes: vec![shape], rays }
    }
}

/// What is counted in a workload, besides wrong answers of single tests and errors of `t`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Counts {
    /// Nothing else.
    Tests,
    /// Leaks and double hits. The shapes of a sample form a mesh, and all of them face the rays in the same way.
    Mesh,
    /// Odd numbers of hits. The shapes of a sample form a closed mesh, and the rays start outside of it.
    Crossings,
    /// Rays whose closest hit is on the wrong shape. The shapes of a sample lie one behind the other.
    Closest,
    /// Hits outside the shape's own box.
    Boxes,
}

impl Counts {
    /// The name used in records.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tests => "tests",
            Self::Mesh => "mesh",
            Self::Crossings => "crossings",
            Self::Closest => "closest",
            Self::Boxes => "boxes",
        }
    }
}

/// A workload that gets harder along an axis.
#[derive(Clone, Copy, Debug)]
pub struct Regime<S> {
    /// Name, unique for the shape.
    pub name: &'static str,
    /// What the rays are, and why they are hard: two or three sentences for charts and reports.
    pub about: &'static str,
    /// What a severity measures.
    pub axis: &'static str,
    /// Severities, from easy to hard. All are positive, except that the last may be zero.
    pub steps: &'static [f64],
    /// What is counted besides wrong answers of single tests.
    pub counts: Counts,
    /// Makes a sample of a severity.
    pub sample: fn(f32, &mut Pcg64) -> Sample<S>,
}

/// One axis of a [`FailureMap`].
#[derive(Clone, Copy, Debug)]
pub struct Axis {
    /// What a severity measures.
    pub title: &'static str,
    /// The easiest severity.
    pub start: f64,
    /// Quarters of a decade from the easiest to the hardest severity; negative if severities decrease.
    pub quarters: i32,
}

impl Axis {
    /// The severities from easy to hard, four per decade.
    pub fn steps(&self) -> Vec<f64> {
        let power = |quarters: i32| {
            // Multiplication gives the same bits everywhere; a power function does not.
            let within = [1.0, 1.778_279_410_038_922_8, 3.162_277_660_168_379_5, 5.623_413_251_903_491];
            (0..quarters / 4).fold(within[(quarters % 4) as usize], |value, _| value * 10.0)
        };
        let step =
            |quarters: i32| if self.quarters < 0 { self.start / power(quarters) } else { self.start * power(quarters) };
        (0..=self.quarters.abs()).map(step).collect()
    }
}

/// A workload with two severities at once. All rays are meant to hit.
#[derive(Clone, Copy, Debug)]
pub struct FailureMap<S> {
    /// Name, unique for the shape.
    pub name: &'static str,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// Makes a sample of two severities, horizontal and vertical.
    pub sample: fn([f32; 2], &mut Pcg64) -> Sample<S>,
}

/// A shape of any kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Primitive {
    /// A box.
    Box(Aabb),
    /// A triangle.
    Triangle(Triangle),
    /// A quadric.
    Quadric(Quadric),
}

/// A shape that workloads exist for.
pub trait Subject: Exact + Registered {
    /// Whether the shapes of an [`Workload::Edge`] sample form a mesh, where rays can leak.
    const MESH: bool;
    /// Its regimes.
    const REGIMES: &'static [Regime<Self>];
    /// Its failure maps.
    const MAPS: &'static [FailureMap<Self>];

    /// The title under which its regimes and maps are listed: that of its group of kernels.
    fn title() -> String {
        Self::FAMILY.into()
    }

    /// The kind of shape, and the transform that places it: the identity if none does.
    fn primitive(&self) -> Placed<Primitive>;

    /// The box that the tracer's box rule holds the shape's hits to. `None` if the rule does not apply to the shape.
    fn own_box(&self) -> Option<Aabb> {
        None
    }

    /// Makes a sample of a workload.
    fn sample(workload: Workload, rng: &mut Pcg64) -> Sample<Self>;

    /// One shape of about unit size, and rays into it or past it from a few units away. None is hard for any kernel. If
    /// the shape is then [`Placed`], an error is due to the transform.
    fn easy(rng: &mut Pcg64) -> Sample<Self> {
        Self::sample(Workload::Generic, rng)
    }
}

/// A shape that no transform places.
fn unplaced(shape: Primitive) -> Placed<Primitive> {
    Placed { shape, object_to_world: Affine3::IDENTITY }
}

/// A ray through `target`, up to rounding, from 0.5 to 4 units away. Its `t` there is from 0.5 to 8.
fn ray_at(target: Vec3, rng: &mut Pcg64) -> Ray<f32> {
    let away = direction(rng) * rng.random_range(0.5..4.0);
    ray_from(target + away, target, rng)
}

/// A ray from `origin` through `target`, up to rounding. Its `t` there is from 0.5 to 8.
fn ray_from(origin: Vec3, target: Vec3, rng: &mut Pcg64) -> Ray<f32> {
    Ray::new(origin, (target - origin) / rng.random_range(0.5..8.0))
}

/// A direction on the side of `z`, at more than 0.3 rad to the plane of `x` and `y` (the columns of `plane`).
fn steep(plane: Mat3, rng: &mut Pcg64) -> Vec3 {
    loop {
        let away = direction(rng);
        if away.z > 0.3 {
            return plane * away;
        }
    }
}

/// A ray at `target` from `distance` away, at `angle` to the plane of `x` and `y` (the columns of `plane`, at right
/// angles and of unit length). A small angle is in radians.
fn grazing_ray(target: Vec3, plane: Mat3, angle: f32, distance: f32, rng: &mut Pcg64) -> Ray<f32> {
    let Vec2 { x, y } = in_disc(rng);
    let around = plane.x_axis * x + plane.y_axis * y;
    let away = (around.normalize() + plane.z_axis * (sign(rng) * angle)).normalize();
    ray_from(target + away * distance, target, rng)
}
