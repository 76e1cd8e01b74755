//! Inputs for slab tests: boxes, and rays at their faces, edges and corners.

use glam::{Mat3, Vec3};
use rand::RngExt;
use rand_pcg::Pcg64;

use super::{
    Axis, Counts, FailureMap, Primitive, Regime, Sample, Subject, Workload, direction, grazing_ray, in_cube, ray_at,
    ray_from, sign, unplaced, whole,
};
use crate::geom::{Aabb, Placed, Ray};

/// Distances of rays to an edge or a corner, relative to the size of the box.
const GAPS: &[f64] = &[1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 0.0];

impl Subject for Aabb {
    const MESH: bool = false;

    const REGIMES: &'static [Regime<Self>] = &[
        Regime {
            name: "box_edge",
            about: "Rays that cut off an edge of the box. They enter and leave within a short distance.",
            axis: "distance to the edge / size of the box",
            steps: GAPS,
            counts: Counts::Tests,
            sample: |gap, rng| Sample::of(generic_box(rng), rng, |shape, rng| cutting_ray(shape, 2, gap, rng)),
        },
        Regime {
            name: "box_corner",
            about: "Rays that cut off a corner of the box. They enter and leave within a short distance.",
            axis: "distance to the corner / size of the box",
            steps: GAPS,
            counts: Counts::Tests,
            sample: |gap, rng| Sample::of(generic_box(rng), rng, |shape, rng| cutting_ray(shape, 3, gap, rng)),
        },
        Regime {
            name: "parallel",
            about: "Rays that start in the plane of a face and run along it. Where the inverse of the slope overflows, \
                    the distance to that plane is 0 times infinity.",
            axis: "slope of the ray against the face",
            steps: &[1.0, 1e-5, 1e-10, 1e-15, 1e-20, 1e-25, 1e-30, 1e-35, 1e-40, 0.0],
            counts: Counts::Tests,
            sample: |slope, rng| Sample::of(generic_box(rng), rng, |shape, rng| parallel_ray(shape, slope, rng)),
        },
        Regime {
            name: "flat",
            about: "Ever thinner boxes, like those around an axis-parallel triangle. A quarter of the rays run inside \
                    them, parallel to the large faces.",
            axis: "thickness / size of the box",
            steps: &[1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 0.0],
            counts: Counts::Tests,
            sample: |thickness, rng| {
                let mut shape = generic_box(rng);
                let axis = rng.random_range(0..3);
                shape.hi[axis] = shape.lo[axis] + thickness * (shape.hi[axis] - shape.lo[axis]);
                Sample::of(shape, rng, |shape, rng| {
                    let target = inside(shape, rng);
                    let mut ray = ray_at(target, rng);
                    if rng.random_bool(0.25) {
                        (ray.origin[axis], ray.dir[axis]) = (target[axis].clamp(shape.lo[axis], shape.hi[axis]), 0.0);
                    }
                    ray
                })
            },
        },
        Regime {
            name: "inverted",
            about: "Empty boxes: on one axis the lower plane lies beyond the upper one. Every hit is false.",
            axis: "lower plane beyond the upper one / size of the box",
            steps: &[1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6],
            counts: Counts::Tests,
            sample: |depth, rng| {
                let mut shape = generic_box(rng);
                let axis = rng.random_range(0..3);
                shape.hi[axis] = shape.lo[axis] - depth * (shape.hi[axis] - shape.lo[axis]);
                Sample::of(shape, rng, |shape, rng| ray_at(inside(shape, rng), rng))
            },
        },
        Regime {
            name: "offset",
            about: "Box and ray together, ever farther from the world's origin.",
            axis: "distance to the world's origin / size of the box",
            steps: &[1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6],
            counts: Counts::Tests,
            sample: |offset, rng| {
                let shape = moved(generic_box(rng), direction(rng) * offset);
                Sample::of(shape, rng, |shape, rng| ray_at(inside_or_past(shape, rng), rng))
            },
        },
        Regime {
            name: "distance",
            about: "Rays that start ever farther away.",
            axis: "distance of the ray's origin / size of the box",
            steps: &[1.0, 1e1, 1e2, 1e3, 1e4, 1e5],
            counts: Counts::Tests,
            sample: |distance, rng| {
                Sample::of(generic_box(rng), rng, |shape, rng| {
                    let target = inside_or_past(shape, rng);
                    ray_from(target + direction(rng) * distance, target, rng)
                })
            },
        },
        Regime {
            name: "scale",
            about: "Box and ray together, from tiny to huge.",
            axis: "size of box and distance",
            steps: &[1e-15, 1e-12, 1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9, 1e12, 1e15],
            counts: Counts::Tests,
            sample: |scale, rng| {
                let mut sample = Self::sample(Workload::Generic, rng);
                for shape in &mut sample.shapes {
                    *shape = Aabb { lo: shape.lo * scale, hi: shape.hi * scale };
                }
                for ray in &mut sample.rays {
                    (ray.origin, ray.dir) = (ray.origin * scale, ray.dir * scale);
                }
                sample
            },
        },
    ];

    const MAPS: &'static [FailureMap<Self>] = &[
        FailureMap {
            name: "offset-aspect",
            x: Axis { title: "distance to the world's origin / size", start: 1.0, quarters: 24 },
            y: Axis { title: "size / thickness", start: 1.0, quarters: 24 },
            sample: |[offset, aspect], rng| {
                let mut shape = generic_box(rng);
                let axis = rng.random_range(0..3);
                shape.hi[axis] = shape.lo[axis] + (shape.hi[axis] - shape.lo[axis]) / aspect;
                let shape = moved(shape, direction(rng) * offset);
                Sample::of(shape, rng, |shape, rng| ray_at(inside(shape, rng), rng))
            },
        },
        FailureMap {
            name: "distance-angle",
            x: Axis { title: "distance of the ray's origin / size", start: 1.0, quarters: 20 },
            y: Axis { title: "angle to the face, rad", start: 1.0, quarters: -24 },
            sample: |[distance, angle], rng| {
                Sample::of(generic_box(rng), rng, |shape, rng| {
                    let axis = rng.random_range(0..3);
                    let mut target = inside(shape, rng);
                    target[axis] = plane(shape, axis, rng);
                    let units = [Vec3::X, Vec3::Y, Vec3::Z];
                    let plane = Mat3::from_cols(units[(axis + 1) % 3], units[(axis + 2) % 3], units[axis]);
                    grazing_ray(target, plane, angle, distance, rng)
                })
            },
        },
    ];

    fn primitive(&self) -> Placed<Primitive> {
        unplaced(Primitive::Box(*self))
    }

    fn sample(workload: Workload, rng: &mut Pcg64) -> Sample<Self> {
        match workload {
            Workload::Generic => {
                let (a, b) = (in_cube(rng, 1.0), in_cube(rng, 1.0));
                let shape = Aabb { lo: a.min(b), hi: a.max(b) };
                Sample::of(shape, rng, |shape, rng| ray_at(inside_or_past(shape, rng), rng))
            }
            Workload::Edge => {
                // Half of the boxes are on whole numbers: rays then meet edges and corners exactly.
                let exact = rng.random_bool(0.5);
                let lo = in_cube(rng, 8.0);
                let extent = in_cube(rng, 4.0).abs() + Vec3::splat(0.5);
                let shape = if exact {
                    Aabb { lo: lo.round(), hi: lo.round() + extent.ceil() }
                } else {
                    Aabb { lo, hi: lo + extent }
                };
                Sample::of(shape, rng, |shape, rng| edge_ray(shape, exact, rng))
            }
        }
    }

    fn easy(rng: &mut Pcg64) -> Sample<Self> {
        Sample::of(generic_box(rng), rng, |shape, rng| ray_at(inside_or_past(shape, rng), rng))
    }
}

/// A box of about unit size near the world's origin.
fn generic_box(rng: &mut Pcg64) -> Aabb {
    let lo = in_cube(rng, 1.0);
    Aabb { lo, hi: lo + Vec3::from([0; 3].map(|_| rng.random_range(0.25..1.0))) }
}

fn moved(shape: Aabb, by: Vec3) -> Aabb {
    Aabb { lo: shape.lo + by, hi: shape.hi + by }
}

/// One of the two planes of the box across this axis.
fn plane(shape: &Aabb, axis: usize, rng: &mut Pcg64) -> f32 {
    if rng.random() { shape.lo[axis] } else { shape.hi[axis] }
}

fn inside(shape: &Aabb, rng: &mut Pcg64) -> Vec3 {
    shape.center() + shape.extent() * in_cube(rng, 0.5)
}

fn inside_or_past(shape: &Aabb, rng: &mut Pcg64) -> Vec3 {
    let reach = if rng.random_bool(0.6) { 0.5 } else { 1.5 };
    shape.center() + shape.extent() * in_cube(rng, reach)
}

/// A ray that is inside the box for a length of about `gap`, near an edge (`fixed = 2`) or a corner (`fixed = 3`).
fn cutting_ray(shape: &Aabb, fixed: usize, gap: f32, rng: &mut Pcg64) -> Ray<f32> {
    let first = rng.random_range(0..3);
    let mut target = inside(shape, rng);
    let mut outward = Vec3::ZERO;
    for step in 0..fixed {
        let axis = (first + step) % 3;
        let inset = gap * shape.extent()[axis] * rng.random_range(0.1..1.0);
        (target[axis], outward[axis]) =
            if rng.random() { (shape.lo[axis] + inset, -1.0) } else { (shape.hi[axis] - inset, 1.0) };
    }
    // It enters through one of the planes that meet there, and leaves through another one or through the far side.
    let dir = loop {
        let dir = direction(rng);
        let slopes: Vec<f32> =
            (0..3).filter(|&axis| outward[axis] != 0.0).map(|axis| dir[axis] * outward[axis]).collect();
        if slopes.iter().any(|&slope| slope > 0.1) && slopes.iter().any(|&slope| slope < -0.1) {
            break dir;
        }
    };
    ray_from(target - dir * rng.random_range(0.5..4.0), target, rng)
}

/// A ray that starts exactly in the plane of a face and runs towards the face, with this slope up or down.
fn parallel_ray(shape: &Aabb, slope: f32, rng: &mut Pcg64) -> Ray<f32> {
    let axis = rng.random_range(0..3);
    let mut ray = ray_at(inside(shape, rng), rng);
    ray.origin[axis] = plane(shape, axis, rng);
    ray.dir[axis] = sign(rng) * slope;
    ray
}

/// A ray at an edge, at a corner, or along a face or an edge of a box.
fn edge_ray(shape: &Aabb, exact: bool, rng: &mut Pcg64) -> Ray<f32> {
    let eighth = |rng: &mut Pcg64| whole(rng, 16) / 8.0;
    let fixed = rng.random_range(1..=3);
    let first = rng.random_range(0..3);
    let mut target = shape.center();
    for step in 0..3 {
        let axis = (first + step) % 3;
        target[axis] = if step < fixed {
            plane(shape, axis, rng)
        } else {
            let along = if exact { rng.random_range(1..8) as f32 / 8.0 } else { rng.random() };
            shape.lo[axis] + (shape.hi[axis] - shape.lo[axis]) * along
        };
    }
    let mut dir = if exact { Vec3::new(eighth(rng), eighth(rng), eighth(rng)) } else { in_cube(rng, 2.0) };
    // A ray in a plane of the box stays in it. Zeros have both signs.
    if fixed == 1 || rng.random_bool(0.25) {
        dir[first] = sign(rng) * 0.0;
    }
    if dir == Vec3::ZERO {
        dir[(first + 1) % 3] = 1.0;
    }
    let steps = if exact { rng.random_range(1..=16) as f32 } else { rng.random_range(1.0..16.0) };
    Ray::new(target - dir * steps, dir)
}
