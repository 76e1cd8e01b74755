//! Inputs for triangle tests: single triangles and small meshes, and rays at them.
//!
//! All triangles of a mesh face its rays the same way. At a silhouette, where a front meets a back, a ray may pass both
//! triangles, and a miss there is no leak.

use glam::{Mat3, Vec2, Vec3};
use rand::RngExt;
use rand_pcg::Pcg64;

use super::depth::fold;
use super::horizon::horizon;
use super::leaving::{next_to_lattice_plane, off_surface};
use super::orders::{ORDERS, ordered_hinge};
use super::silhouette::silhouette;
use super::t_junction::t_junction;
use super::thin::{flat, grazed_sliver};
use super::{
    Axis, Counts, FailureMap, Primitive, RAYS_PER_SAMPLE, Regime, Sample, Subject, Workload, direction, frame,
    grazing_ray, in_cube, in_square, ray_at, ray_from, sign, steep, unplaced, whole,
};
use crate::geom::{Aabb, Placed, Ray, Triangle};

/// Distances of rays to an edge, relative to the size of the triangle.
const GAPS: &[f64] = &[1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 0.0];

impl Subject for Triangle {
    const MESH: bool = true;

    const REGIMES: &'static [Regime<Self>] = &[
        Regime {
            name: "grazing",
            about: "Rays at an ever smaller angle to the triangle. The determinant is a small difference of large \
                    numbers.",
            axis: "angle between ray and triangle, rad",
            steps: &[1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6],
            counts: Counts::Tests,
            sample: |angle, rng| {
                let plane = frame(rng);
                Sample::of(regular(plane, 1.0, rng), rng, |shape, rng| {
                    let distance = rng.random_range(0.5..4.0);
                    grazing_ray(inside_or_past(shape, rng), plane, angle, distance, rng)
                })
            },
        },
        Regime {
            name: "sliver",
            about: "Ever thinner triangles. Normal and determinant cancel.",
            axis: "length / height of the triangle",
            steps: &[1e1, 1e2, 1e3, 1e4, 1e5, 1e6],
            counts: Counts::Tests,
            sample: |aspect, rng| {
                let plane = frame(rng);
                Sample::of(sliver(plane, aspect, rng), rng, |shape, rng| {
                    steep_ray(inside_or_past(shape, rng), plane, rng)
                })
            },
        },
        Regime {
            name: "offset",
            about: "Triangle and ray together, ever farther from the world's origin. Data prepared in world \
                    coordinates loses digits.",
            axis: "distance to the world's origin / size of the triangle",
            steps: &[1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6],
            counts: Counts::Tests,
            sample: |offset, rng| {
                let plane = frame(rng);
                let shape = moved(&regular(plane, 1.0, rng), direction(rng) * offset);
                Sample::of(shape, rng, |shape, rng| steep_ray(inside_or_past(shape, rng), plane, rng))
            },
        },
        Regime {
            name: "distance",
            about: "Rays that start ever farther away. In the difference of vertex and origin, the triangle is lost to \
                    rounding.",
            axis: "distance of the ray's origin / size of the triangle",
            steps: &[1.0, 1e1, 1e2, 1e3, 1e4, 1e5],
            counts: Counts::Tests,
            sample: |distance, rng| {
                let plane = frame(rng);
                Sample::of(regular(plane, 1.0, rng), rng, |shape, rng| {
                    let target = inside_or_past(shape, rng);
                    ray_from(target + steep(plane, rng) * distance, target, rng)
                })
            },
        },
        Regime {
            name: "ground",
            about: "Rays near the middle of an ever larger triangle. Figures computed from its far vertices lose the \
                    near hit.",
            axis: "size of the triangle / distance of the hit",
            steps: &[1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6],
            counts: Counts::Tests,
            sample: |size, rng| {
                let plane = frame(rng);
                let middle = in_cube(rng, 1.0);
                let shape = moved(&regular(plane, size, rng), middle);
                Sample::of(shape, rng, |_, rng| {
                    let Vec2 { x, y } = in_square(rng, 1.0);
                    steep_ray(middle + plane.x_axis * x + plane.y_axis * y, plane, rng)
                })
            },
        },
        Regime {
            name: "scale",
            about: "Triangle and ray together, from tiny to huge. Determinants underflow and overflow.",
            axis: "size of triangle and distance",
            steps: &[1e-15, 1e-12, 1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9, 1e12, 1e15],
            counts: Counts::Tests,
            sample: |scale, rng| {
                let plane = frame(rng);
                let shape = regular(plane, 1.0, rng);
                let rays = (0..RAYS_PER_SAMPLE).map(|_| {
                    let ray = steep_ray(inside_or_past(&shape, rng), plane, rng);
                    Ray::new(ray.origin * scale, ray.dir * scale)
                });
                Sample { rays: rays.collect(), shapes: vec![map(&shape, |vertex| vertex * scale)] }
            },
        },
        Regime {
            name: "shared_edge",
            about: "Rays aimed ever closer to an edge of two triangles. The last step hits it exactly (on a grid) or \
                    to the last bit.",
            axis: "distance to the edge / size of the triangle",
            steps: GAPS,
            counts: Counts::Mesh,
            sample: |gap, rng| if gap == 0.0 && rng.random() { grid_fan(Aim::Edges, rng) } else { hinge(gap, rng) },
        },
        Regime {
            name: "vertex_fan",
            about: "Rays through the middle vertex of a fan of ever more triangles. Some fans are on a grid, where \
                    rays meet the vertex exactly.",
            axis: "triangles around the vertex",
            steps: &[4.0, 8.0, 16.0, 32.0, 64.0, 128.0],
            counts: Counts::Mesh,
            sample: |triangles, rng| vertex_fan(triangles as usize, rng),
        },
        Regime {
            name: "closed_mesh",
            about: "Rays from inside a closed mesh through its edges and vertices. The mesh moves ever farther from \
                    the world's origin.",
            axis: "distance to the world's origin / size of the mesh",
            steps: &[1.0, 1e1, 1e2, 1e3, 1e4, 1e5],
            counts: Counts::Mesh,
            sample: closed_mesh,
        },
        Regime {
            name: "leaving",
            about: "Rays that start ever closer to a triangle and leave it. A wrong sign of t makes them hit it. Half \
                    of the last starts are so close that only exact numbers tell the side.",
            axis: "distance of the start from the triangle, ulp of its coordinates",
            steps: &[32.0, 16.0, 8.0, 4.0, 2.0, 1.0, 0.0],
            counts: Counts::Tests,
            sample: |ulps, rng| {
                if ulps == 0.0 && rng.random() { next_to_lattice_plane(rng) } else { off_surface(ulps, rng) }
            },
        },
        Regime {
            name: "vertex_order",
            about: "Rays that meet an edge of two triangles. Most kernels treat the edge v1v2 unlike the others, so \
                    leaks depend on the order of the vertices. The edge is, in the two triangles: 1 v1v2 and v1v2, \
                    3 v2v0 and v1v2, 5 v0v1 and v1v2, 7 v0v1 and v2v0, 9 v2v0 and v2v0, 11 v0v1 and v0v1. Even \
                    numbers are the same, seen from the back.",
            axis: "number of the vertex order",
            steps: &ORDERS,
            counts: Counts::Mesh,
            sample: |order, rng| ordered_hinge(order as usize, rng),
        },
        Regime {
            name: "t_junction",
            about: "Rays aimed ever closer to an edge on which a vertex of two other triangles lies. No two triangles \
                    share the whole edge. Only rays that exactly hit a triangle count, not those through the gap that \
                    rounding the vertex leaves.",
            axis: "distance to the edge / size of the triangle",
            steps: GAPS,
            counts: Counts::Mesh,
            sample: t_junction,
        },
        Regime {
            name: "horizon",
            about: "Rays at the edges, vertices and insides of a ground of many triangles, from one cell above it and \
                    ever farther away. The angle falls as the distance grows. What rounding does to a far vertex is \
                    magnified by the inverse of the angle.",
            axis: "distance of the hit / size of a cell",
            steps: &[1e1, 1e2, 3e2, 1e3, 3e3, 1e4],
            counts: Counts::Mesh,
            sample: horizon,
        },
        Regime {
            name: "silhouette",
            about: "Rays that pass ever closer to the silhouette of a closed mesh, on both sides. There a front meets \
                    a back. A ray that loses one of them seems to be inside the mesh from there on.",
            axis: "distance to the silhouette / size of the mesh",
            steps: &[1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 0.0],
            counts: Counts::Crossings,
            sample: silhouette,
        },
        Regime {
            name: "depth_order",
            about: "Rays near the edge of two triangles that are folded together ever more closely. They hit one \
                    triangle just behind the other. A picture shows the one with the lesser t.",
            axis: "angle of the fold, rad",
            steps: &[1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7],
            counts: Counts::Closest,
            sample: fold,
        },
        Regime {
            name: "inside_box",
            about: "Rays at an ever smaller angle to slivers, into them and past them. A hit outside the triangle's \
                    own box is found in one tree and not in another, unless the box rule rejects or clamps it.",
            axis: "angle between ray and triangle, rad",
            steps: &[1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6],
            counts: Counts::Boxes,
            sample: grazed_sliver,
        },
        Regime {
            name: "flat_box",
            about: "Triangles whose own boxes are ever flatter. At last the triangle is parallel to an axis. The \
                    distances of box and triangle are rounded separately, so even a correctly rounded t may lie \
                    outside the box.",
            axis: "thickness / size of the triangle's box",
            steps: &[1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 0.0],
            counts: Counts::Boxes,
            sample: flat,
        },
    ];

    const MAPS: &'static [FailureMap<Self>] = &[
        FailureMap {
            name: "offset-aspect",
            x: Axis { title: "distance to the world's origin / size", start: 1.0, quarters: 24 },
            y: Axis { title: "length / height", start: 1.0, quarters: 24 },
            sample: |[offset, aspect], rng| {
                let plane = frame(rng);
                let shape = moved(&sliver(plane, aspect, rng), direction(rng) * offset);
                Sample::of(shape, rng, |shape, rng| steep_ray(inside(shape, rng), plane, rng))
            },
        },
        FailureMap {
            name: "distance-angle",
            x: Axis { title: "distance of the ray's origin / size", start: 1.0, quarters: 20 },
            y: Axis { title: "angle to the triangle, rad", start: 1.0, quarters: -24 },
            sample: |[distance, angle], rng| {
                let plane = frame(rng);
                Sample::of(regular(plane, 1.0, rng), rng, |shape, rng| {
                    grazing_ray(inside(shape, rng), plane, angle, distance, rng)
                })
            },
        },
    ];

    fn primitive(&self) -> Placed<Primitive> {
        unplaced(Primitive::Triangle(*self))
    }

    fn own_box(&self) -> Option<Aabb> {
        Some(self.bounds())
    }

    fn sample(workload: Workload, rng: &mut Pcg64) -> Sample<Self> {
        match workload {
            Workload::Generic => Sample::of(free(rng), rng, |shape, rng| ray_at(inside_or_past(shape, rng), rng)),
            Workload::Edge => {
                if rng.random_bool(0.5) {
                    grid_fan(Aim::EdgesAndHub, rng)
                } else {
                    free_fan(rng)
                }
            }
        }
    }

    fn easy(rng: &mut Pcg64) -> Sample<Self> {
        let plane = frame(rng);
        Sample::of(regular(plane, 1.0, rng), rng, |shape, rng| steep_ray(inside_or_past(shape, rng), plane, rng))
    }
}

fn map(shape: &Triangle, change: impl Fn(Vec3) -> Vec3) -> Triangle {
    let [v0, v1, v2] = shape.vertices().map(change);
    Triangle { v0, v1, v2 }
}

pub(super) fn moved(shape: &Triangle, by: Vec3) -> Triangle {
    map(shape, |vertex| vertex + by)
}

/// The same triangle, starting with vertex 0, 1 or 2.
pub(super) fn starting_with(vertex: usize, Triangle { v0, v1, v2 }: Triangle) -> Triangle {
    match vertex {
        0 => Triangle { v0, v1, v2 },
        1 => Triangle { v0: v1, v1: v2, v2: v0 },
        _ => Triangle { v0: v2, v1: v0, v2: v1 },
    }
}

/// The same triangle, starting with a random vertex: each edge can be the one between `v1` and `v2`.
pub(super) fn turned(shape: Triangle, rng: &mut Pcg64) -> Triangle {
    starting_with(rng.random_range(0..3), shape)
}

/// Any triangle of about unit size near the world's origin.
fn free(rng: &mut Pcg64) -> Triangle {
    let [v0, v1, v2] = [0; 3].map(|_| in_cube(rng, 1.0));
    Triangle { v0, v1, v2 }
}

/// A nearly equilateral triangle around the world's origin, in the plane of `x` and `y`.
pub(super) fn regular(plane: Mat3, size: f32, rng: &mut Pcg64) -> Triangle {
    let corner = |x: f32, y: f32, rng: &mut Pcg64| {
        let shift = in_square(rng, 0.25);
        (plane.x_axis * (x + shift.x) + plane.y_axis * (y + shift.y)) * size
    };
    let (v0, v1, v2) = (corner(1.0, 0.0, rng), corner(-0.5, 0.875, rng), corner(-0.5, -0.875, rng));
    Triangle { v0, v1, v2 }
}

/// A triangle in the plane of `x` and `y`, about one unit long. `aspect` is its length by its height.
pub(super) fn sliver(plane: Mat3, aspect: f32, rng: &mut Pcg64) -> Triangle {
    let length = rng.random_range(0.5..2.0);
    let v0 = in_cube(rng, 1.0);
    let v1 = v0 + plane.x_axis * length;
    let v2 = v0 + plane.x_axis * (length * rng.random_range(0.0..1.0)) + plane.y_axis * (length / aspect);
    turned(Triangle { v0, v1, v2 }, rng)
}

pub(super) fn inside(shape: &Triangle, rng: &mut Pcg64) -> Vec3 {
    let [u, v]: [f32; 2] = [0; 2].map(|_| rng.random());
    if u + v > 1.0 { shape.point(1.0 - u, 1.0 - v) } else { shape.point(u, v) }
}

pub(super) fn inside_or_past(shape: &Triangle, rng: &mut Pcg64) -> Vec3 {
    if rng.random_bool(0.6) {
        return inside(shape, rng);
    }
    let [u, v]: [f32; 2] = [0; 2].map(|_| rng.random_range(-1.0..2.0));
    shape.point(u, v)
}

/// The triangles between `hub` and the points of `rim`, in the order of `rim`.
fn fan(hub: Vec3, rim: &[Vec3], rng: &mut Pcg64) -> Vec<Triangle> {
    let next = |index: usize| rim[(index + 1) % rim.len()];
    (0..rim.len()).map(|index| turned(Triangle { v0: hub, v1: rim[index], v2: next(index) }, rng)).collect()
}

/// Directions to the rim of a fan of eight triangles, in whole numbers.
const COMPASS: [[f32; 2]; 8] =
    [[4.0, 0.0], [3.0, 3.0], [0.0, 4.0], [-3.0, 3.0], [-4.0, 0.0], [-3.0, -3.0], [0.0, -4.0], [3.0, -3.0]];

/// A ray at `target` from a few units away, at more than 0.3 rad to the plane of `x` and `y`.
pub(super) fn steep_ray(target: Vec3, plane: Mat3, rng: &mut Pcg64) -> Ray<f32> {
    ray_from(target + steep(plane, rng) * rng.random_range(0.5..4.0), target, rng)
}

/// A ray at `target` from a few units away, off `z` by at most half a unit in `x` and in `y`. It is steeper than every
/// triangle of the meshes.
pub(super) fn upright_ray(target: Vec3, plane: Mat3, rng: &mut Pcg64) -> Ray<f32> {
    let Vec2 { x, y } = in_square(rng, 0.5);
    let away = plane.x_axis * x + plane.y_axis * y + plane.z_axis;
    ray_from(target + away * rng.random_range(0.5..4.0), target, rng)
}

/// A fan of eight triangles in general position. They are less steep than the rays.
fn free_fan(rng: &mut Pcg64) -> Sample<Triangle> {
    let jitter = |[x, y]: [f32; 2], rng: &mut Pcg64| Vec3::new(x * 0.25, y * 0.25, 0.0) + in_cube(rng, 0.1);
    let hub = in_cube(rng, 0.1);
    let rim = COMPASS.map(|at| jitter(at, rng));
    let rays = (0..RAYS_PER_SAMPLE).map(|_| {
        let spoke = rim[rng.random_range(0..8)];
        let along = if rng.random_bool(0.2) { 0.0 } else { rng.random_range(0.0..0.9) };
        upright_ray(hub + (spoke - hub) * along, Mat3::IDENTITY, rng)
    });
    Sample { rays: rays.collect(), shapes: fan(hub, &rim, rng) }
}

/// What the rays of [`grid_fan`] are aimed at.
#[derive(Clone, Copy, PartialEq)]
enum Aim {
    Edges,
    EdgesAndHub,
}

/// A grid on which the coordinates of a mesh and the directions of its rays have few digits. A ray can then meet a
/// point of the mesh exactly.
#[derive(Clone, Copy)]
pub(super) struct Grid {
    /// Steps per unit of length.
    steps: i32,
    /// Steps per unit of a ray's slope.
    slopes: i32,
}

impl Grid {
    /// Whole numbers. Most arithmetic on them is exact.
    pub(super) const COARSE: Self = Self { steps: 1, slopes: 16 };
    /// As many digits as possible with an exact ray. Even `f64` must round a product of three.
    const FINE: Self = Self { steps: 4096, slopes: 131_072 };

    pub(super) fn any(rng: &mut Pcg64) -> Self {
        if rng.random() { Self::COARSE } else { Self::FINE }
    }

    /// A point of the grid with coordinates up to `range` units.
    pub(super) fn point(self, range: i32, rng: &mut Pcg64) -> Vec3 {
        Vec3::from([0; 3].map(|_| whole(rng, range * self.steps))) / self.steps as f32
    }

    /// A ray that meets `target` exactly, from the side of positive `z`.
    pub(super) fn ray(self, target: Vec3, rng: &mut Pcg64) -> Ray<f32> {
        self.ray_from(1, target, rng)
    }

    /// The same, from at least this height above `target`.
    pub(super) fn ray_from(self, height: i32, target: Vec3, rng: &mut Pcg64) -> Ray<f32> {
        let slope = |rng: &mut Pcg64| whole(rng, self.slopes / 2) / self.slopes as f32;
        let dir = Vec3::new(slope(rng), slope(rng), -1.0);
        Ray::new(target - dir * rng.random_range(height..=64) as f32, dir)
    }
}

/// The sample with its axes exchanged and mirrored, which is exact: each axis can be the steep one.
pub(super) fn shuffled(sample: Sample<Triangle>, rng: &mut Pcg64) -> Sample<Triangle> {
    let first = rng.random_range(0..3);
    let signs = [0; 3].map(|_| sign(rng));
    let change = |v: Vec3| Vec3::from([0, 1, 2].map(|axis| v[(first + axis) % 3] * signs[axis]));
    Sample {
        shapes: sample.shapes.iter().map(|shape| map(shape, change)).collect(),
        rays: sample.rays.iter().map(|ray| Ray::new(change(ray.origin), change(ray.dir))).collect(),
    }
}

/// A fan on a grid, and rays that meet its spokes, and its hub if `aim` says so, exactly.
fn grid_fan(aim: Aim, rng: &mut Pcg64) -> Sample<Triangle> {
    let grid = Grid::any(rng);
    let offset = Grid::COARSE.point(16, rng);
    let hub = offset + grid.point(1, rng);
    let rim = COMPASS.map(|[x, y]| offset + Vec3::new(4.0 * x, 4.0 * y, 0.0) + grid.point(2, rng));
    let rays = (0..RAYS_PER_SAMPLE).map(|_| {
        let spoke = rim[rng.random_range(0..8)];
        // Eighths need three more digits, which f32 holds, also for the ray.
        let at_hub = aim == Aim::EdgesAndHub && rng.random_bool(0.2);
        let along = if at_hub { 0.0 } else { rng.random_range(1..8) as f32 / 8.0 };
        grid.ray(hub + (spoke - hub) * along, rng)
    });
    let sample = Sample { rays: rays.collect(), shapes: fan(hub, &rim, rng) };
    shuffled(sample, rng)
}

/// Two triangles that share an edge, and rays at the relative distance `gap` to the edge.
fn hinge(gap: f32, rng: &mut Pcg64) -> Sample<Triangle> {
    let mut sample = unturned_hinge(gap, rng);
    sample.shapes = sample.shapes.into_iter().map(|shape| turned(shape, rng)).collect();
    sample
}

/// [`hinge`] with the shared edge between `v0` and `v1` of both triangles.
pub(super) fn unturned_hinge(gap: f32, rng: &mut Pcg64) -> Sample<Triangle> {
    let plane = frame(rng);
    let corner = |x: f32, y: f32, rng: &mut Pcg64| plane * (Vec3::new(x, y, 0.0) + in_cube(rng, 0.2));
    let (a, b) = (corner(0.0, -1.0, rng), corner(0.0, 1.0, rng));
    let (left, right) = (corner(-1.0, 0.0, rng), corner(1.0, 0.0, rng));
    let rays = (0..RAYS_PER_SAMPLE).map(|_| {
        let on_edge = a + (b - a) * rng.random_range(0.1..0.9);
        let apex = if rng.random() { left } else { right };
        upright_ray(on_edge + (apex - on_edge) * gap, plane, rng)
    });
    let rays = rays.collect();
    Sample { rays, shapes: vec![Triangle { v0: a, v1: b, v2: left }, Triangle { v0: b, v1: a, v2: right }] }
}

/// A fan of `triangles` triangles, and rays through its middle vertex.
fn vertex_fan(triangles: usize, rng: &mut Pcg64) -> Sample<Triangle> {
    // Around a square: no sine is needed.
    let half = triangles as f32 / 8.0;
    let on_square = |index: usize| {
        let (side, along) = (index * 4 / triangles, (index * 4 % triangles) as f32 / 4.0);
        match side {
            0 => [half, along - half],
            1 => [half - along, half],
            2 => [-half, half - along],
            _ => [along - half, -half],
        }
    };
    // Fewer for many triangles: such a ray meets each of them exactly, and the oracle's filter cannot decide that.
    if rng.random_bool((8.0 / triangles as f64).min(0.5)) {
        let grid = Grid::any(rng);
        let offset = Grid::COARSE.point(16, rng);
        let hub = offset + grid.point(1, rng);
        let rim: Vec<Vec3> = (0..triangles)
            .map(|index| on_square(index).map(|x| 32.0 * x))
            .map(|[x, y]| offset + Vec3::new(x, y, 0.0) + grid.point(1, rng))
            .collect();
        let rays = (0..RAYS_PER_SAMPLE).map(|_| grid.ray(hub, rng)).collect();
        let sample = Sample { rays, shapes: fan(hub, &rim, rng) };
        return shuffled(sample, rng);
    }
    let plane = frame(rng);
    // Less than the spacing of the rim; more would make triangles steeper than the rays.
    let jitter = 1.0 / triangles as f32;
    let hub = plane * in_cube(rng, 0.1);
    let rim: Vec<Vec3> = (0..triangles)
        .map(|index| on_square(index).map(|x| x / half))
        .map(|[x, y]| plane * (Vec3::new(x, y, 0.0) + in_cube(rng, jitter)))
        .collect();
    let rays = (0..RAYS_PER_SAMPLE).map(|_| upright_ray(hub, plane, rng)).collect();
    Sample { rays, shapes: fan(hub, &rim, rng) }
}

/// A closed mesh of twenty triangles around the origins of the rays: an icosahedron with its vertices moved in and out.
fn closed_mesh(offset: f32, rng: &mut Pcg64) -> Sample<Triangle> {
    let plane = frame(rng);
    let middle = direction(rng) * offset;
    let vertices: Vec<Vec3> = ICOSAHEDRON
        .iter()
        .map(|&vertex| middle + plane * (Vec3::from(vertex) * (0.5 * rng.random_range(0.9..1.1))))
        .collect();
    let shapes: Vec<Triangle> = FACES
        .iter()
        .map(|&[a, b, c]| turned(Triangle { v0: vertices[a], v1: vertices[b], v2: vertices[c] }, rng))
        .collect();
    let rays = (0..RAYS_PER_SAMPLE).map(|_| {
        let Triangle { v0, v1, .. } = shapes[rng.random_range(0..shapes.len())];
        let along = if rng.random() { 0.0 } else { rng.random_range(0.1..0.9) };
        ray_from(middle + in_cube(rng, 0.1), v0 + (v1 - v0) * along, rng)
    });
    Sample { rays: rays.collect(), shapes }
}

/// The golden ratio.
const PHI: f32 = 1.618_034;

const ICOSAHEDRON: [[f32; 3]; 12] = [
    [0.0, 1.0, PHI],
    [0.0, -1.0, PHI],
    [PHI, 0.0, 1.0],
    [-PHI, 0.0, 1.0],
    [1.0, PHI, 0.0],
    [-1.0, PHI, 0.0],
    [1.0, -PHI, 0.0],
    [-1.0, -PHI, 0.0],
    [PHI, 0.0, -1.0],
    [-PHI, 0.0, -1.0],
    [0.0, 1.0, -PHI],
    [0.0, -1.0, -PHI],
];

/// The triangles of [`ICOSAHEDRON`], counter-clockwise as seen from outside.
const FACES: [[usize; 3]; 20] = [
    [0, 1, 2],
    [0, 2, 4],
    [0, 4, 5],
    [0, 5, 3],
    [0, 3, 1],
    [1, 6, 2],
    [2, 6, 8],
    [2, 8, 4],
    [4, 8, 10],
    [4, 10, 5],
    [5, 10, 9],
    [5, 9, 3],
    [3, 9, 7],
    [3, 7, 1],
    [1, 7, 6],
    [11, 8, 6],
    [11, 10, 8],
    [11, 9, 10],
    [11, 7, 9],
    [11, 6, 7],
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::workload::rng;

    /// Computed in `f64`, which is precise enough for such coarse meshes.
    #[test]
    fn meshes_face_their_rays_the_same_way() {
        let mut checked = 0;
        for regime in Triangle::REGIMES.iter().filter(|regime| regime.counts == Counts::Mesh) {
            for &severity in regime.steps {
                for index in 0..200 {
                    let mut rng = rng(1, "facing", regime.name, &[], index);
                    let sample = (regime.sample)(severity as f32, &mut rng);
                    assert_eq!(sample.rays.len(), RAYS_PER_SAMPLE);
                    for ray in &sample.rays {
                        let side = |shape: &Triangle| {
                            let [v0, v1, v2] = shape.vertices().map(Vec3::as_dvec3);
                            // Rays that start inside the mesh: the side of the origin counts.
                            let normal = (v1 - v0).cross(v2 - v0);
                            let sight = if regime.name == "closed_mesh" {
                                v0 - ray.origin.as_dvec3()
                            } else {
                                ray.dir.as_dvec3()
                            };
                            normal.dot(sight) > 0.0
                        };
                        let first = side(&sample.shapes[0]);
                        assert!(sample.shapes.iter().all(|shape| side(shape) == first), "{} {severity}", regime.name);
                        checked += 1;
                    }
                }
            }
        }
        assert!(checked > 10_000);
    }
}
