//! Inputs for quadrics: surfaces of second degree, and rays at them.

use glam::{Mat3, Vec2, Vec3};
use rand::RngExt;
use rand_pcg::Pcg64;

use super::{
    Axis, Counts, FailureMap, Primitive, RAYS_PER_SAMPLE, Regime, Sample, Subject, Workload, direction, frame, in_cube,
    in_disc, ray_from, sign, steep, unplaced, whole,
};
use crate::geom::{Aabb, Placed, Quadric, Ray};

/// Radius of the huge sphere. Its square is exact in `f32`, so the coefficients are not rounded.
const HUGE: f32 = 8192.0;

impl Subject for Quadric {
    const MESH: bool = false;

    const REGIMES: &'static [Regime<Self>] = &[
        Regime {
            name: "afar",
            about: "Spheres seen from ever farther away. The discriminant is a small difference: the square of the \
                    distance cancels.",
            axis: "distance of the ray's origin / radius",
            steps: &[1e1, 1e2, 1e3, 1e4, 1e5, 1e6],
            counts: Counts::Tests,
            sample: |distance, rng| {
                let radius = rng.random_range(0.5..2.0);
                Sample::of(Quadric::sphere(radius), rng, |_, rng| {
                    let target = direction(rng) * (radius * rng.random_range(0.0..1.5));
                    ray_from(direction(rng) * (radius * distance), target, rng)
                })
            },
        },
        Regime {
            name: "near_huge",
            about: "Rays that start ever closer above a sphere of radius 8192, and hit it nearby or leave it. The \
                    constant cancels.",
            axis: "height of the ray's origin",
            steps: &[1e2, 1e1, 1.0, 1e-1, 1e-2, 1e-3, 1e-4],
            counts: Counts::Tests,
            sample: |height, rng| {
                Sample::of(Quadric::sphere(HUGE), rng, |_, rng| {
                    let (origin, plane) = above(HUGE, height, rng);
                    let side = if rng.random_bool(0.75) { -height } else { height };
                    Ray::new(origin, steep(plane, rng) * (side / rng.random_range(0.5..8.0)))
                })
            },
        },
        Regime {
            name: "inside",
            about: "Rays from inside a sphere in all directions, from its centre to just below its surface. Hits at \
                    nearly zero distance must be told from hits behind the ray.",
            axis: "depth of the ray's origin / radius",
            steps: &[1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6],
            counts: Counts::Tests,
            sample: |depth, rng| {
                let radius = rng.random_range(0.5..2.0);
                Sample::of(Quadric::sphere(radius), rng, |_, rng| {
                    let origin = direction(rng) * (radius * (1.0 - depth));
                    Ray::new(origin, direction(rng) * rng.random_range(0.25..2.0))
                })
            },
        },
        Regime {
            name: "tangent",
            about: "Rays that pass ever closer to the silhouette of a sphere, on both sides. The discriminant is \
                    nearly zero.",
            axis: "distance of the ray from the silhouette / radius",
            steps: &[1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7],
            counts: Counts::Tests,
            sample: |gap, rng| {
                let radius = rng.random_range(0.5..2.0);
                Sample::of(Quadric::sphere(radius), rng, |_, rng| {
                    let side = sign(rng) * gap;
                    let distance = rng.random_range(0.5..4.0);
                    passing_ray(radius, 1.0 + side * rng.random_range(0.1..1.0), distance, rng)
                })
            },
        },
        Regime {
            name: "parabolic",
            about: "Rays at the inside or the outside of a paraboloid, ever closer to parallel to its axis, in the \
                    last step exactly parallel. The coefficient of t² goes to zero, and one root goes to infinity.",
            axis: "angle between ray and axis, rad",
            steps: &[1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 0.0],
            counts: Counts::Tests,
            sample: |angle, rng| {
                let (radius, height) = (rng.random_range(0.5..1.5), rng.random_range(0.5..1.5));
                Sample::of(Quadric::paraboloid(radius, height), rng, |_, rng| {
                    let distance = rng.random_range(0.5..4.0);
                    parabolic_ray([radius, height], angle, distance, rng)
                })
            },
        },
        Regime {
            name: "generatrix",
            about: "Rays through a cone, ever closer to parallel to a generatrix on the other side (a straight line of \
                    the surface). The coefficient of t² cancels to zero.",
            axis: "angle between ray and generatrix, rad",
            steps: &[1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7],
            counts: Counts::Tests,
            sample: |angle, rng| {
                let (radius, height) = (rng.random_range(0.5..1.5), rng.random_range(0.5..1.5));
                let on_cone = |around: Vec2, share: f32| (around * radius).extend(height) * share;
                Sample::of(Quadric::cone(radius, height), rng, |_, rng| {
                    let (along, at) = loop {
                        let (along, at) = (on_circle(rng), on_circle(rng));
                        if along.dot(at) < 0.5 {
                            break (along, at);
                        }
                    };
                    let dir = on_cone(along, 1.0).normalize() * sign(rng) + direction(rng) * angle;
                    Ray::new(on_cone(at, rng.random_range(0.1..0.9)) - dir * rng.random_range(0.5..4.0), dir)
                })
            },
        },
        Regime {
            name: "rim",
            about: "Rays from inside a cylinder, a cone or a paraboloid. They leave ever closer to the rim, where the \
                    box clips the surface, below it or above it.",
            axis: "distance of the ray from the rim / height",
            steps: &[1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7],
            counts: Counts::Tests,
            sample: |gap, rng| {
                let (radius, height) = (rng.random_range(0.5..1.5), rng.random_range(0.5..1.5));
                let shape = match rng.random_range(0..3) {
                    0 => Quadric::cylinder(radius, height),
                    1 => Quadric::cone(radius, height),
                    _ => Quadric::paraboloid(radius, height),
                };
                Sample::of(shape, rng, |_, rng| {
                    let side = sign(rng) * gap;
                    let target = (on_circle(rng) * radius).extend(height * (1.0 + side * rng.random_range(0.1..1.0)));
                    let origin = (in_cube(rng, 0.125) * radius).with_z(height * rng.random_range(0.5..0.875));
                    ray_from(origin, target, rng)
                })
            },
        },
        Regime {
            name: "offset",
            about: "Spheres moved by their coefficients instead of a transform, ever farther from the origin. The \
                    radius is lost in the constant.",
            axis: "distance of the sphere to the origin of its coordinates / radius",
            // It ends before 1e5, where an ulp of the centre's coordinates is a hundredth of the sphere.
            steps: &[1.0, 3.0, 1e1, 3e1, 1e2, 3e2, 1e3, 3e3, 1e4],
            counts: Counts::Tests,
            sample: |offset, rng| {
                let (shape, center, radius) = moved_sphere(offset, rng);
                Sample::of(shape, rng, |_, rng| {
                    let target = center + direction(rng) * (radius * rng.random_range(0.0..1.5));
                    ray_from(target + direction(rng) * rng.random_range(0.5..4.0), target, rng)
                })
            },
        },
        Regime {
            name: "scale",
            about: "Quadric and ray together, from tiny to huge. The discriminant has degree four: it underflows and \
                    overflows.",
            axis: "size of quadric and distance",
            steps: &[1e-15, 1e-12, 1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9, 1e12, 1e15],
            counts: Counts::Tests,
            sample: generic,
        },
    ];

    const MAPS: &'static [FailureMap<Self>] = &[
        FailureMap {
            name: "distance-silhouette",
            x: Axis { title: "distance of the ray's origin from a sphere / radius", start: 1.0, quarters: 20 },
            y: Axis { title: "distance of the ray from the silhouette / radius", start: 1.0, quarters: -24 },
            sample: |[distance, gap], rng| {
                let radius = rng.random_range(0.5..2.0);
                Sample::of(Quadric::sphere(radius), rng, |_, rng| {
                    let share = 1.0 - gap * rng.random_range(0.5..1.0);
                    passing_ray(radius, share, (1.0 + distance) * radius, rng)
                })
            },
        },
        FailureMap {
            name: "distance-axis",
            x: Axis { title: "distance of the ray's origin from a paraboloid / size", start: 1.0, quarters: 20 },
            y: Axis { title: "angle between ray and axis, rad", start: 1.0, quarters: -24 },
            sample: |[distance, angle], rng| {
                let (radius, height) = (rng.random_range(0.5..1.5), rng.random_range(0.5..1.5));
                Sample::of(Quadric::paraboloid(radius, height), rng, |_, rng| {
                    parabolic_ray([radius, height], angle, distance, rng)
                })
            },
        },
    ];

    fn primitive(&self) -> Placed<Primitive> {
        unplaced(Primitive::Quadric(*self))
    }

    fn sample(workload: Workload, rng: &mut Pcg64) -> Sample<Self> {
        match workload {
            Workload::Generic => generic(1.0, rng),
            Workload::Edge => {
                if rng.random_bool(0.5) {
                    exact_boundary(rng)
                } else {
                    free_boundary(rng)
                }
            }
        }
    }

    fn easy(rng: &mut Pcg64) -> Sample<Self> {
        let radius = rng.random_range(0.5..1.5);
        Sample::of(Quadric::sphere(radius), rng, |_, rng| {
            let share = if rng.random_bool(0.7) { rng.random_range(0.0..0.9) } else { rng.random_range(1.1..1.5) };
            passing_ray(radius, share, radius * rng.random_range(1.5..4.0), rng)
        })
    }
}

/// A direction in the plane, of unit length.
fn on_circle(rng: &mut Pcg64) -> Vec2 {
    in_disc(rng).normalize()
}

/// Any of the named kinds, or an ellipsoid rotated by its coefficients, of about this size.
fn any_kind(size: f32, rng: &mut Pcg64) -> Quadric {
    let axes = Vec3::from([0; 3].map(|_| size * rng.random_range(0.5..1.5)));
    match rng.random_range(0..9) {
        0 => Quadric::sphere(axes.x),
        1 => Quadric::ellipsoid(axes),
        2 => Quadric::cylinder(axes.x, axes.z),
        3 => Quadric::cone(axes.x, axes.z),
        4 => Quadric::paraboloid(axes.x, axes.z),
        5 => Quadric::elliptic_paraboloid(axes.truncate(), axes.z),
        6 => Quadric::hyperboloid_of_one_sheet(axes, axes.z * 1.5),
        7 => Quadric::hyperboloid_of_two_sheets(axes, axes.z * 2.0),
        _ => {
            let own = Quadric::ellipsoid(axes);
            let turn = frame(rng);
            let Mat3 { x_axis: x, y_axis: y, z_axis: z } = turn * Mat3::from_diagonal(own.squares) * turn.transpose();
            let half = Vec3::splat(own.clip.hi.max_element());
            Quadric {
                squares: Vec3::new(x.x, y.y, z.z),
                products: Vec3::new(y.z + z.y, z.x + x.z, x.y + y.x),
                clip: Aabb { lo: -half, hi: half },
                ..own
            }
        }
    }
}

/// A quadric of about this size, and rays into its box or past it, from a few sizes away.
fn generic(size: f32, rng: &mut Pcg64) -> Sample<Quadric> {
    Sample::of(any_kind(size, rng), rng, |shape, rng| {
        let reach = if rng.random_bool(0.6) { 0.5 } else { 1.0 };
        let target = shape.clip.center() + shape.clip.extent() * in_cube(rng, reach);
        ray_from(target + direction(rng) * (size * rng.random_range(0.5..4.0)), target, rng)
    })
}

/// A point at this height above a sphere, and the tangent plane below it. Rounding may change the height by up to a
/// factor of two, and by more if 64 attempts find no better point.
fn above(radius: f32, height: f32, rng: &mut Pcg64) -> (Vec3, Mat3) {
    let mut attempts = 0;
    loop {
        let plane = frame(rng);
        let origin = plane.z_axis * (radius + height);
        let actual = (origin.as_dvec3().length() - f64::from(radius)) / f64::from(height);
        attempts += 1;
        if (0.5..2.0).contains(&actual) || attempts == 64 {
            return (origin, plane);
        }
    }
}

/// A ray that passes the centre of a sphere at `share` of its radius. It starts `distance` before its closest point.
fn passing_ray(radius: f32, share: f32, distance: f32, rng: &mut Pcg64) -> Ray<f32> {
    let plane = frame(rng);
    let dir = plane.x_axis;
    let closest = plane.z_axis * (radius * share);
    Ray::new(closest - dir * distance, dir * (distance / rng.random_range(0.5..8.0)))
}

/// A ray at a point of a paraboloid, from below or from above, at this angle to the axis.
fn parabolic_ray([radius, height]: [f32; 2], angle: f32, distance: f32, rng: &mut Pcg64) -> Ray<f32> {
    let share = rng.random_range(0.1..0.9);
    let target = (on_circle(rng) * (radius * share)).extend(height * share * share);
    let dir = (on_circle(rng) * angle).extend(sign(rng));
    Ray::new(target - dir * distance, dir * (distance / rng.random_range(0.5..8.0)))
}

/// A sphere of about unit size at this distance from the origin, moved by its coefficients; its centre; its radius.
///
/// Rounded coefficients describe a sphere too, often of another size. The function tries again until the radius is
/// about 1.
fn moved_sphere(offset: f32, rng: &mut Pcg64) -> (Quadric, Vec3, f32) {
    loop {
        let center = direction(rng) * offset;
        let squared = center.as_dvec3().length_squared();
        let wanted: f64 = rng.random_range(0.5..2.0);
        let constant = (squared - wanted * wanted) as f32;
        let squared_radius = (squared - f64::from(constant)) as f32;
        if (0.25..4.0).contains(&squared_radius) {
            let radius = squared_radius.sqrt();
            let half = Vec3::splat(radius * 1.25);
            let clip = Aabb { lo: center - half, hi: center + half };
            let quadric = Quadric { squares: Vec3::ONE, products: Vec3::ZERO, linear: center * -2.0, constant, clip };
            return (quadric, center, radius);
        }
    }
}

/// Sides of right triangles in whole numbers, the longest last.
const TRIPLES: [[i32; 3]; 4] = [[3, 4, 5], [5, 12, 13], [8, 15, 17], [7, 24, 25]];

/// A quadric through a point with whole coordinates, and rays that meet a boundary exactly there: they are tangent, or
/// meet a plane of the box, an apex, or an end of their interval.
fn exact_boundary(rng: &mut Pcg64) -> Sample<Quadric> {
    let [short, other, long] = TRIPLES[rng.random_range(0..TRIPLES.len())].map(|side| side as f32);
    let on_rim = Vec2::new(short * sign(rng), other * sign(rng));
    let height = [1.0, 2.0, 4.0, 8.0][rng.random_range(0..4)];
    let kind = rng.random_range(0..6);
    let (shape, target) = match kind {
        0 | 1 => (Quadric::sphere(long), on_rim.extend(0.0)),
        2 => (Quadric::cylinder(long, height), on_rim.extend(height * sign(rng))),
        3 => (Quadric::cone(long, long), on_rim.extend(long)),
        4 => (Quadric::cone(long, long), Vec3::ZERO),
        _ => (Quadric::paraboloid(long, height), on_rim.extend(height)),
    };
    Sample::of(shape, rng, |_, rng| {
        let dir = loop {
            let dir = if kind == 0 {
                on_rim.perp().extend(whole(rng, 16))
            } else {
                Vec3::from([0; 3].map(|_| whole(rng, 16) / 8.0))
            };
            if dir != Vec3::ZERO {
                break dir;
            }
        };
        let steps = rng.random_range(1..=16) as f32;
        let mut ray = Ray::new(target - dir * steps, dir);
        if kind == 1 {
            (ray.t_min, ray.t_max) = if rng.random() { (0.0, steps) } else { (steps, f32::INFINITY) };
        }
        ray
    })
}

/// The same in any position: rays that meet a boundary up to rounding.
fn free_boundary(rng: &mut Pcg64) -> Sample<Quadric> {
    let (radius, height) = (rng.random_range(0.5..1.5), rng.random_range(0.5..1.5));
    let kind = rng.random_range(0..5);
    let shape = match kind {
        0 => Quadric::sphere(radius),
        1 => Quadric::cylinder(radius, height),
        2 | 3 => Quadric::cone(radius, height),
        _ => Quadric::paraboloid(radius, height),
    };
    let rays = (0..RAYS_PER_SAMPLE).map(|_| {
        let distance = rng.random_range(0.5..4.0);
        if kind == 0 {
            return passing_ray(radius, 1.0 + rng.random_range(-1e-6..1e-6), distance, rng);
        }
        let target = if kind == 3 { Vec3::ZERO } else { (on_circle(rng) * radius).extend(height) };
        ray_from(target + direction(rng) * distance, target, rng)
    });
    Sample { rays: rays.collect(), shapes: vec![shape] }
}
