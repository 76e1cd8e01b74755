//! Named, seeded inputs. Uniformly random rays show next to nothing of what separates kernels, so every workload aims.
//!
//! Two workloads are simple: `generic` and `edge`. The others are regimes: they get harder along an axis, in steps, until
//! the methods fail that are going to. Everything is made with sums, products, divisions and square roots, which give the
//! same bits on every machine and in every build; there are no sines, whose last digit is anyone's guess.

mod aabb;
mod placed;
mod quadric;
mod triangle;

use glam::{Mat3, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::geom::Ray;
use crate::oracle::Exact;
use crate::registry::Registered;

/// A named set of inputs without an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Workload {
    /// One primitive of about unit size and a ray aimed into it or past it, from a few units away.
    Generic,
    /// Rays aimed at edges, vertices, corners and planes. For triangles: a fan of eight that all face the rays, in random
    /// positions or on a grid, where rays meet edges exactly. For quadrics: tangent rays and rays at the rim where the box
    /// cuts, at an apex, or with an end of their interval on the surface.
    Edge,
}

impl Workload {
    /// Every workload.
    pub const ALL: [Self; 2] = [Self::Generic, Self::Edge];

    /// As used in records.
    pub fn name(self) -> &'static str {
        match self {
            Self::Generic => "generic",
            Self::Edge => "edge",
        }
    }
}

/// Rays of a sample, all against the same primitives.
pub const RAYS_PER_SAMPLE: usize = 16;

/// One primitive, or a small mesh, and the rays aimed at it.
#[derive(Clone, Debug)]
pub struct Sample<S> {
    /// One, or the triangles of a mesh.
    pub shapes: Vec<S>,
    /// [`RAYS_PER_SAMPLE`] rays.
    pub rays: Vec<Ray<f32>>,
}

impl<S> Sample<S> {
    /// One shape, and rays that are made one by one.
    fn of(shape: S, rng: &mut Pcg64, ray: impl Fn(&S, &mut Pcg64) -> Ray<f32>) -> Self {
        let rays = (0..RAYS_PER_SAMPLE).map(|_| ray(&shape, rng)).collect();
        Self { shapes: vec![shape], rays }
    }
}

/// A workload that gets harder along an axis.
#[derive(Clone, Copy, Debug)]
pub struct Regime<S> {
    /// Name, unique for the shape.
    pub name: &'static str,
    /// What the rays are and what to look for.
    pub about: &'static str,
    /// What a severity measures.
    pub axis: &'static str,
    /// Severities, from easy to hard: positive, but for a zero that may come last.
    pub steps: &'static [f64],
    /// Whether the shapes of a sample form a mesh, in which rays can leak.
    pub mesh: bool,
    /// A sample of a severity.
    pub sample: fn(f32, &mut Pcg64) -> Sample<S>,
}

/// One axis of a [`FailureMap`].
#[derive(Clone, Copy, Debug)]
pub struct Axis {
    /// What a severity measures.
    pub title: &'static str,
    /// The easiest severity.
    pub start: f64,
    /// How many quarters of a decade there are up, or down, to the hardest.
    pub quarters: i32,
}

impl Axis {
    /// The severities, four to a decade.
    pub fn steps(&self) -> Vec<f64> {
        let power = |quarters: i32| {
            // By multiplication, which gives the same bits everywhere.
            let within = [1.0, 1.778_279_410_038_922_8, 3.162_277_660_168_379_5, 5.623_413_251_903_491];
            (0..quarters / 4).fold(within[(quarters % 4) as usize], |value, _| value * 10.0)
        };
        let step =
            |quarters: i32| if self.quarters < 0 { self.start / power(quarters) } else { self.start * power(quarters) };
        (0..=self.quarters.abs()).map(step).collect()
    }
}

/// A workload with two severities at once, all of whose rays are meant to hit.
#[derive(Clone, Copy, Debug)]
pub struct FailureMap<S> {
    /// Name, unique for the shape.
    pub name: &'static str,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// A sample of two severities.
    pub sample: fn([f32; 2], &mut Pcg64) -> Sample<S>,
}

/// A shape that workloads exist for.
pub trait Subject: Exact + Registered {
    /// Whether the shapes of an [`Workload::Edge`] sample form a mesh, in which rays can leak.
    const MESH: bool;
    /// Its regimes.
    const REGIMES: &'static [Regime<Self>];
    /// Its failure maps.
    const MAPS: &'static [FailureMap<Self>];

    /// What its regimes and maps are listed under: the title of the group of kernels that they are for.
    fn title() -> String {
        Self::FAMILY.into()
    }

    /// A sample of a workload.
    fn sample(workload: Workload, rng: &mut Pcg64) -> Sample<Self>;

    /// One shape of about unit size and rays into it or past it from a few units away, none of which is hard for any
    /// kernel: what goes wrong with it [`Placed`](crate::geom::Placed) is then due to the transform.
    fn easy(rng: &mut Pcg64) -> Sample<Self> {
        Self::sample(Workload::Generic, rng)
    }
}

/// The generator of one sample: it depends on nothing but these, so samples can be made in any order and on any thread.
/// `severities` are those of a regime or a map.
pub fn rng(seed: u64, family: &str, workload: &str, severities: &[f32], index: u64) -> Pcg64 {
    let severities = severities.iter().flat_map(|severity| severity.to_bits().to_le_bytes());
    let stream = family
        .bytes()
        .chain(workload.bytes())
        .chain(severities)
        .fold(seed, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3));
    Pcg64::seed_from_u64(stream.wrapping_add(index.wrapping_mul(0x9e37_79b9_7f4a_7c15)))
}

fn in_cube(rng: &mut Pcg64, half: f32) -> Vec3 {
    Vec3::from([0; 3].map(|_| rng.random_range(-half..half)))
}

/// A random direction, of unit length.
pub(super) fn direction(rng: &mut Pcg64) -> Vec3 {
    loop {
        let inside = in_cube(rng, 1.0);
        if (0.01..1.0).contains(&inside.length_squared()) {
            return inside.normalize();
        }
    }
}

/// Three random directions at right angles, as columns.
fn frame(rng: &mut Pcg64) -> Mat3 {
    let z = direction(rng);
    let x = loop {
        let across = z.cross(direction(rng));
        if across.length_squared() > 0.01 {
            break across.normalize();
        }
    };
    Mat3::from_cols(x, z.cross(x), z)
}

/// A ray through `target` (as nearly as rounding allows) from 0.5 to 4 units away, whose `t` there is from 0.5 to 8.
fn ray_at(target: Vec3, rng: &mut Pcg64) -> Ray<f32> {
    let away = direction(rng) * rng.random_range(0.5..4.0);
    ray_from(target + away, target, rng)
}

/// A ray from `origin` through `target`, as nearly as rounding allows, whose `t` there is from 0.5 to 8.
fn ray_from(origin: Vec3, target: Vec3, rng: &mut Pcg64) -> Ray<f32> {
    Ray::new(origin, (target - origin) / rng.random_range(0.5..8.0))
}

/// A direction on the side of `z` that makes an angle of more than 0.3 rad with the plane of `x` and
/// `y`.
fn steep(plane: Mat3, rng: &mut Pcg64) -> Vec3 {
    loop {
        let away = direction(rng);
        if away.z > 0.3 {
            return plane * away;
        }
    }
}

/// A ray at `target` that makes `angle` with the plane of `x` and `y`, from `distance` away: in radians, for small angles.
/// The three are of unit length and at right angles.
fn grazing_ray(target: Vec3, plane: Mat3, angle: f32, distance: f32, rng: &mut Pcg64) -> Ray<f32> {
    let around = loop {
        let [x, y]: [f32; 2] = [0; 2].map(|_| rng.random_range(-1.0..1.0));
        if (0.01..1.0).contains(&(x * x + y * y)) {
            break plane.x_axis * x + plane.y_axis * y;
        }
    };
    let side = if rng.random() { angle } else { -angle };
    let away = (around.normalize() + plane.z_axis * side).normalize();
    ray_from(target + away * distance, target, rng)
}
