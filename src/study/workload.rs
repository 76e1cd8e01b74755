//! Named, seeded inputs. Uniformly random rays show next to nothing of what separates kernels, so every workload aims.

use glam::{Affine3, Mat3, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::geom::{Aabb, Placed, Ray, Triangle};
use crate::oracle::Exact;

/// A named set of inputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Workload {
    /// One primitive of about unit size and a ray aimed into it or past it, from a few units away.
    Generic,
    /// Rays aimed at edges, vertices, corners and planes. For triangles: a fan of eight that all face the rays, in random
    /// positions or on a grid of whole numbers, where rays meet edges exactly.
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

/// A shape that workloads exist for.
pub trait Subject: Exact {
    /// Whether the shapes of an [`Workload::Edge`] sample form a mesh, in which rays can leak.
    const MESH: bool;

    /// A sample of a workload.
    fn sample(workload: Workload, rng: &mut Pcg64) -> Sample<Self>;
}

/// The generator of one sample: it depends on nothing but these, so samples can be made in any order and on any thread.
pub fn rng(seed: u64, family: &str, workload: Workload, index: u64) -> Pcg64 {
    let stream = family
        .bytes()
        .chain(workload.name().bytes())
        .fold(seed, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3));
    Pcg64::seed_from_u64(stream.wrapping_add(index.wrapping_mul(0x9e37_79b9_7f4a_7c15)))
}

fn in_cube(rng: &mut Pcg64, half: f32) -> Vec3 {
    Vec3::from([0; 3].map(|_| rng.random_range(-half..half)))
}

/// A ray through `target` (as nearly as rounding allows) from 0.5 to 4 units away, whose `t` there is from 0.5 to 8.
fn ray_at(target: Vec3, rng: &mut Pcg64) -> Ray<f32> {
    let away = loop {
        let away = in_cube(rng, 1.0);
        if (0.01..1.0).contains(&away.length_squared()) {
            break away.normalize();
        }
    };
    let origin = target + away * rng.random_range(0.5..4.0);
    Ray::new(origin, (target - origin) / rng.random_range(0.5..8.0))
}

impl Subject for Triangle {
    const MESH: bool = true;

    fn sample(workload: Workload, rng: &mut Pcg64) -> Sample<Self> {
        match workload {
            Workload::Generic => {
                let [v0, v1, v2] = [0; 3].map(|_| in_cube(rng, 1.0));
                let triangle = Triangle { v0, v1, v2 };
                let rays = (0..RAYS_PER_SAMPLE).map(|_| {
                    let inside = rng.random_bool(0.6);
                    let [mut u, mut v]: [f32; 2] = [0; 2].map(|_| rng.random());
                    if inside && u + v > 1.0 {
                        (u, v) = (1.0 - u, 1.0 - v);
                    } else if !inside {
                        (u, v) = (3.0 * u - 1.0, 3.0 * v - 1.0);
                    }
                    ray_at(triangle.point(u, v), rng)
                });
                Sample { rays: rays.collect(), shapes: vec![triangle] }
            }
            Workload::Edge => {
                if rng.random_bool(0.5) {
                    grid_fan(rng)
                } else {
                    free_fan(rng)
                }
            }
        }
    }
}

/// Eight triangles around the hub `rim[8]`, counter-clockwise seen from +z.
fn fan(hub: Vec3, rim: [Vec3; 8]) -> Vec<Triangle> {
    (0..8).map(|index| Triangle { v0: hub, v1: rim[index], v2: rim[(index + 1) % 8] }).collect()
}

/// Directions of the rim, in units that keep whole numbers whole.
const COMPASS: [[f32; 2]; 8] =
    [[4.0, 0.0], [3.0, 3.0], [0.0, 4.0], [-3.0, 3.0], [-4.0, 0.0], [-3.0, -3.0], [0.0, -4.0], [3.0, -3.0]];

/// A fan in general position. The slopes stay below those of the rays, so that all triangles face the rays the same way:
/// at a silhouette a ray may pass a mesh without a leak.
fn free_fan(rng: &mut Pcg64) -> Sample<Triangle> {
    let jitter = |[x, y]: [f32; 2], rng: &mut Pcg64| Vec3::new(x * 0.25, y * 0.25, 0.0) + in_cube(rng, 0.1);
    let hub = in_cube(rng, 0.1);
    let rim = COMPASS.map(|at| jitter(at, rng));
    let rays = (0..RAYS_PER_SAMPLE).map(|_| {
        let spoke = rim[rng.random_range(0..8)];
        let along = if rng.random_bool(0.2) { 0.0 } else { rng.random_range(0.0..0.9) };
        let target = hub + (spoke - hub) * along;
        let origin = target
            + Vec3::new(rng.random_range(-0.5..0.5), rng.random_range(-0.5..0.5), 1.0) * rng.random_range(0.5..4.0);
        Ray::new(origin, (target - origin) / rng.random_range(0.5..8.0))
    });
    Sample { rays: rays.collect(), shapes: fan(hub, rim) }
}

/// A fan on whole numbers, and rays that meet its spokes and its hub exactly.
fn grid_fan(rng: &mut Pcg64) -> Sample<Triangle> {
    let whole = |rng: &mut Pcg64, range: i32| rng.random_range(-range..=range) as f32;
    let offset = Vec3::new(whole(rng, 16), whole(rng, 16), whole(rng, 16));
    let hub = offset + Vec3::new(0.0, 0.0, whole(rng, 1));
    let rim = COMPASS.map(|[x, y]| offset + Vec3::new(4.0 * x, 4.0 * y, 2.0 * whole(rng, 1)));
    let rays = (0..RAYS_PER_SAMPLE).map(|_| {
        let spoke = rim[rng.random_range(0..8)];
        // Eighths of whole numbers: exact in f32, as is the ray built on them.
        let along = if rng.random_bool(0.2) { 0.0 } else { rng.random_range(1..8) as f32 / 8.0 };
        let target = hub + (spoke - hub) * along;
        let dir = Vec3::new(whole(rng, 8) / 16.0, whole(rng, 8) / 16.0, -1.0);
        let steps = rng.random_range(1..=64) as f32;
        Ray::new(target - dir * steps, dir)
    });
    Sample { rays: rays.collect(), shapes: fan(hub, rim) }
}

impl Subject for Aabb {
    const MESH: bool = false;

    fn sample(workload: Workload, rng: &mut Pcg64) -> Sample<Self> {
        match workload {
            Workload::Generic => {
                let (a, b) = (in_cube(rng, 1.0), in_cube(rng, 1.0));
                let bounds = Aabb { lo: a.min(b), hi: a.max(b) };
                let rays = (0..RAYS_PER_SAMPLE).map(|_| {
                    let reach = if rng.random_bool(0.6) { 0.5 } else { 1.5 };
                    let target = bounds.center() + bounds.extent() * in_cube(rng, reach);
                    ray_at(target, rng)
                });
                Sample { rays: rays.collect(), shapes: vec![bounds] }
            }
            Workload::Edge => {
                // On whole numbers half of the time, so that rays meet edges and corners exactly.
                let exact = rng.random_bool(0.5);
                let lo = in_cube(rng, 8.0);
                let extent = in_cube(rng, 4.0).abs() + Vec3::splat(0.5);
                let bounds = if exact {
                    Aabb { lo: lo.round(), hi: lo.round() + extent.ceil() }
                } else {
                    Aabb { lo, hi: lo + extent }
                };
                let rays = (0..RAYS_PER_SAMPLE).map(|_| box_edge_ray(&bounds, exact, rng));
                Sample { rays: rays.collect(), shapes: vec![bounds] }
            }
        }
    }
}

/// A ray at an edge, at a corner, or along a face or an edge of a box.
fn box_edge_ray(bounds: &Aabb, exact: bool, rng: &mut Pcg64) -> Ray<f32> {
    let eighth = |rng: &mut Pcg64| rng.random_range(-16..=16) as f32 / 8.0;
    let fixed = rng.random_range(1..=3);
    let first = rng.random_range(0..3);
    let mut target = bounds.center();
    for step in 0..3 {
        let axis = (first + step) % 3;
        target[axis] = if step < fixed {
            if rng.random() { bounds.lo[axis] } else { bounds.hi[axis] }
        } else {
            let along = if exact { rng.random_range(1..8) as f32 / 8.0 } else { rng.random() };
            bounds.lo[axis] + (bounds.hi[axis] - bounds.lo[axis]) * along
        };
    }
    let mut dir = if exact { Vec3::new(eighth(rng), eighth(rng), eighth(rng)) } else { in_cube(rng, 2.0) };
    // In a plane of the box the ray stays there; zeros have both signs.
    if fixed == 1 || rng.random_bool(0.25) {
        dir[first] = if rng.random() { 0.0 } else { -0.0 };
    }
    if dir == Vec3::ZERO {
        dir[(first + 1) % 3] = 1.0;
    }
    let steps = if exact { rng.random_range(1..=16) as f32 } else { rng.random_range(1.0..16.0) };
    Ray::new(target - dir * steps, dir)
}

impl<S: Subject> Subject for Placed<S>
where
    Placed<S>: Exact,
{
    const MESH: bool = S::MESH;

    /// The inner shape's sample, stretched, sheared, turned and moved by up to 100 units; the rays are moved along, so
    /// that they meet what they were aimed at but for rounding. Half of the edge-aimed ones are moved by whole numbers,
    /// where what met an edge exactly still does.
    fn sample(workload: Workload, rng: &mut Pcg64) -> Sample<Self> {
        let inner = S::sample(workload, rng);
        let exact = workload == Workload::Edge && rng.random_bool(0.5);
        let object_to_world = loop {
            let columns = [0; 3].map(|_| in_cube(rng, if exact { 2.5 } else { 1.0 }));
            let matrix3 = Mat3::from_cols(columns[0], columns[1], columns[2]) + Mat3::IDENTITY;
            let transform = Affine3 { matrix3, translation: in_cube(rng, 100.0) };
            let transform = if exact { rounded(transform) } else { transform };
            // Not nearly singular: that regime has a study of its own.
            if transform.matrix3.determinant().abs() > 0.1 {
                break transform;
            }
        };
        let place = |ray: &Ray<f32>| Ray {
            origin: object_to_world.transform_point3(ray.origin),
            dir: object_to_world.transform_vector3(ray.dir),
            t_min: ray.t_min,
            t_max: ray.t_max,
        };
        Sample {
            rays: inner.rays.iter().map(place).collect(),
            shapes: inner.shapes.into_iter().map(|shape| Placed { shape, object_to_world }).collect(),
        }
    }
}

fn rounded(Affine3 { matrix3, translation }: Affine3) -> Affine3 {
    let Mat3 { x_axis, y_axis, z_axis } = matrix3;
    Affine3 {
        matrix3: Mat3::from_cols(x_axis.round(), y_axis.round(), z_axis.round()),
        translation: translation.round(),
    }
}
