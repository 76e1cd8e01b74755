//! Components of meshes that are tessellations of quadrics: the quadric takes their place.
//!
//! [`fit`](super::fit) proposes a surface. It is accepted if
//!
//! 1. every vertex lies on it, within rounding;
//! 2. the middles of edges and triangles are near it, so the triangles do follow it;
//! 3. the mesh ends only where the clip box of the quadric cuts the surface: it has no holes;
//! 4. seen along each axis, the triangles cover as much as the surface in the box does. So all of the surface is there,
//!    and only once.
//!
//! The quadric faces the side to which most of the triangles face. Shading normals of the mesh are left out, because
//! those of the quadric are exact.

use glam::{DAffine3, DVec3, Vec3};
use rayon::prelude::*;

use super::fit::{Surface, candidates};
use super::pieces::{Piece, Pieces, replaced};
use super::weld::{Component, Components, only_color, remaining};
use super::{Deviation, SimplerModel, in_place};
use crate::geom::{Aabb, Quadric};
use crate::tracer::{Geometry, Mesh, Paint, World};

pub(super) const NAME: &str = "quadrics instead of tessellations";

/// Fewer triangles are not worth a quadric.
const MIN_TRIANGLES: usize = 100;
/// Triangles of a component that are looked at before all of them are.
const SAMPLE: usize = 512;
/// Vertices may be so far from the surface, as a fraction of the component's diagonal.
const MAX_VERTEX_DISTANCE: f64 = 1e-5;
/// And the middles of edges and triangles so far.
const MAX_CHORD_ERROR: f64 = 0.01;
/// Covered areas may differ by this fraction.
const MAX_AREA_ERROR: f64 = 0.05;
/// Lines along each side of the grid that measures the area of a surface.
const GRID: u32 = 64;

/// Replaces tessellated quadrics.
pub(super) fn find(world: &World) -> Option<SimplerModel> {
    let (mut quadrics, mut replaced_triangles) = (0, 0);
    let pieces: Vec<_> = (0..)
        .zip(world.geometries())
        .map(|(number, geometry)| {
            let Geometry::Mesh(mesh) = geometry else { return None };
            let paints =
                || world.instances().iter().filter(|placement| placement.geometry == number).map(|shown| shown.paint);
            // A quadric has other texture coordinates than its tessellation, and only one colour.
            if paints().any(|paint| matches!(paint, Paint::Checker(_))) || paints().next().is_none() {
                return None;
            }
            let shows_colors = paints().any(|paint| paint == Paint::Own);
            let found = found(mesh, shows_colors);
            quadrics += found.len();
            replaced_triangles += found.iter().map(|(triangles, _)| triangles.len()).sum::<usize>();
            (!found.is_empty()).then(|| pieces(mesh, &found))
        })
        .collect();
    if quadrics == 0 {
        return None;
    }
    let (simpler, deviation) = replaced(world, &pieces)?;
    let about = format!(
        "{replaced_triangles} of {} triangles approximate {quadrics} {}, up to a distance of {deviation:.2e}",
        world.triangles(),
        if quadrics == 1 { "quadric" } else { "quadrics" },
    );
    Some(in_place(NAME, about, simpler, Deviation::Approximation(deviation)))
}

/// The components of a mesh that are quadrics: their triangles, and what takes their place.
fn found(mesh: &Mesh, shows_colors: bool) -> Vec<(Vec<u32>, Fitted)> {
    let all = Components::of(mesh, MIN_TRIANGLES);
    let fitted = |component: &Component| {
        let color = only_color(mesh, &component.triangles);
        if shows_colors && color.is_none() {
            return None;
        }
        let step = component.triangles.len().div_ceil(SAMPLE);
        let sample = component.triangles.iter().step_by(step).map(|&number| mesh.triangle(number).vertices());
        let points = sample.flatten().map(Vec3::as_dvec3).collect::<Vec<_>>();
        let corners = (0..points.len() as u32 / 3).map(|number| [3 * number, 3 * number + 1, 3 * number + 2]);
        Patch::new(points, corners.collect()).surfaces().next()?;
        let (points, corners) = all.shape(mesh, component);
        let fitted = Patch::new(points, corners).fitted(color)?;
        Some((component.triangles.clone(), fitted))
    };
    all.components.par_iter().filter_map(fitted).collect()
}

/// The pieces of a mesh: the triangles that are left, and the quadrics.
fn pieces(mesh: &Mesh, found: &[(Vec<u32>, Fitted)]) -> Pieces {
    let (mut geometries, mut placed) = (Vec::new(), Vec::new());
    let rest = remaining(mesh, found.iter().map(|(triangles, _)| &triangles[..]));
    if !rest.is_empty() {
        geometries.push(Geometry::Mesh(mesh.subset(&rest)));
        placed.push(Piece { geometry: 0, to_whole: DAffine3::IDENTITY, color: None });
    }
    for (_, fitted) in found {
        placed.push(Piece { geometry: geometries.len(), to_whole: fitted.to_mesh, color: fitted.color });
        geometries.push(Geometry::Quadric(fitted.quadric));
    }
    let deviation = found.iter().map(|(_, fitted)| fitted.deviation).fold(0.0, f64::max);
    Pieces { geometries, placed, deviation }
}

/// A quadric in the place of triangles.
struct Fitted {
    quadric: Quadric,
    /// From the quadric's coordinates to those of the mesh: a rotation and a translation.
    to_mesh: DAffine3,
    color: Option<Vec3>,
    /// The greatest distance between the surfaces that was found.
    deviation: f64,
}

/// Triangles, scaled to a diagonal of 1 around 0.
struct Patch {
    points: Vec<DVec3>,
    corners: Vec<[u32; 3]>,
    /// The middle of its box, in the coordinates of the mesh.
    center: DVec3,
    /// The diagonal of its box.
    size: f64,
}

impl Patch {
    fn new(mut points: Vec<DVec3>, corners: Vec<[u32; 3]>) -> Self {
        let [lo, hi] = bounds(points.iter().copied());
        let (center, size) = ((lo + hi) / 2.0, (hi - lo).length().max(f64::MIN_POSITIVE));
        for point in &mut points {
            *point = (*point - center) / size;
        }
        Self { points, corners, center, size }
    }

    fn vertices(&self, corners: [u32; 3]) -> [DVec3; 3] {
        corners.map(|corner| self.points[corner as usize])
    }

    /// The normals, with twice the area as length.
    fn normals(&self) -> Vec<DVec3> {
        let normal = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a);
        self.corners.iter().map(|&corners| normal(self.vertices(corners))).collect()
    }

    /// The surfaces on which all vertices lie, and which the triangles follow. Each with the greatest distance of a
    /// triangle.
    fn surfaces(&self) -> impl Iterator<Item = (Surface, f64)> {
        candidates(&self.points, &self.normals()).filter_map(|surface| {
            let distance = |point: DVec3| surface.distance(surface.in_frame(point));
            let chord_error = |&corners: &[u32; 3]| {
                let [a, b, c] = self.vertices(corners);
                [(a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0, (a + b + c) / 3.0]
                    .map(distance)
                    .into_iter()
                    .fold(0.0, f64::max)
            };
            if !self.points.iter().all(|&point| distance(point) <= MAX_VERTEX_DISTANCE) {
                return None;
            }
            let deviation = self.corners.iter().map(chord_error).fold(0.0, f64::max);
            (deviation <= MAX_CHORD_ERROR).then_some((surface, deviation))
        })
    }

    /// The quadric in the place of these triangles.
    fn fitted(&self, color: Option<Vec3>) -> Option<Fitted> {
        self.surfaces().find_map(|(mut surface, deviation)| {
            let points: Vec<_> = self.points.iter().map(|&point| surface.in_frame(point)).collect();
            let clip = Clip::around(&surface, &points, deviation);
            if !(self.ends_at(&clip, &points) && self.covers(&surface, &clip, &points)) {
                return None;
            }
            let faces = |(corners, normal): (&[u32; 3], DVec3)| {
                let [a, b, c] = corners.map(|corner| points[corner as usize]);
                (surface.axes.transpose() * normal).dot(surface.gradient((a + b + c) / 3.0)).signum()
            };
            if self.corners.iter().zip(self.normals()).map(faces).sum::<f64>() < 0.0 {
                (surface.squares, surface.linear, surface.constant) =
                    (-surface.squares, -surface.linear, -surface.constant);
            }
            let quadric = Quadric {
                squares: surface.squares.as_vec3(),
                products: Vec3::ZERO,
                linear: (surface.linear * self.size).as_vec3(),
                constant: (surface.constant * self.size * self.size) as f32,
                clip: Aabb { lo: (clip.lo * self.size).as_vec3(), hi: (clip.hi * self.size).as_vec3() },
            };
            let to_mesh = DAffine3 { matrix3: surface.axes, translation: self.center + surface.origin * self.size };
            let is_valid = Geometry::Quadric(quadric).is_valid();
            is_valid.then_some(Fitted { quadric, to_mesh, color, deviation: deviation * self.size })
        })
    }

    /// Whether each edge that belongs to an odd number of triangles lies in a side of the box that cuts the surface.
    fn ends_at(&self, clip: &Clip, points: &[DVec3]) -> bool {
        let mut edges: Vec<_> = self
            .corners
            .iter()
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
            .map(|[from, to]| [from.min(to), from.max(to)])
            .filter(|[from, to]| from != to)
            .collect();
        edges.par_sort_unstable();
        let mut odd = edges.chunk_by(|a, b| a == b).filter(|same| same.len() % 2 == 1);
        odd.all(|same| clip.cuts_at(same[0].map(|vertex| points[vertex as usize])))
    }

    /// Whether the triangles cover the surface in the box once.
    fn covers(&self, surface: &Surface, clip: &Clip, points: &[DVec3]) -> bool {
        let mut of_mesh = DVec3::ZERO;
        for corners in &self.corners {
            let [a, b, c] = corners.map(|corner| points[corner as usize]);
            of_mesh += (b - a).cross(c - a).abs() / 2.0;
        }
        let of_surface = clip.covered_areas(surface);
        (of_mesh - of_surface).abs().max_element() <= MAX_AREA_ERROR * of_surface.max_element()
    }
}

/// The clip box of a surface, in its frame.
struct Clip {
    lo: DVec3,
    hi: DVec3,
    /// Whether the sides at `lo` and `hi` cut the surface. Elsewhere it turns back before it meets the side.
    cuts: [[bool; 2]; 3],
}

impl Clip {
    /// The box around the points. Where the surface turns back, it is wider, because the triangles are inside of the
    /// surface or outside by the deviation; and because a box should not touch the surface.
    fn around(surface: &Surface, points: &[DVec3], deviation: f64) -> Self {
        let [lo, hi] = bounds(points.iter().copied());
        let extent = hi - lo;
        let mut clip = Self { lo, hi, cuts: [[false; 2]; 3] };
        for axis in 0..3 {
            // A surface that goes on would reach a plane well behind the side.
            let behind = extent[axis] * 0.1;
            clip.cuts[axis] = [lo[axis] - behind, hi[axis] + behind].map(|height| {
                let mut signs = [false; 2];
                for mut point in grid(axis, lo, hi) {
                    point[axis] = height;
                    signs[usize::from(surface.value(point) > 0.0)] = true;
                }
                signs == [true; 2]
            });
        }
        let wider = 2.0 * deviation + 1.0 / 1024.0;
        for axis in 0..3 {
            let [low, high] = clip.cuts[axis];
            clip.lo[axis] -= if low { 0.0 } else { wider };
            clip.hi[axis] += if high { 0.0 } else { wider };
        }
        clip
    }

    /// Whether both points lie in one side that cuts the surface.
    fn cuts_at(&self, points: [DVec3; 2]) -> bool {
        (0..3).any(|axis| {
            let lies_at = |side: f64| points.iter().all(|point| (point[axis] - side).abs() <= MAX_VERTEX_DISTANCE);
            let [low, high] = self.cuts[axis];
            low && lies_at(self.lo[axis]) || high && lies_at(self.hi[axis])
        })
    }

    /// For each axis, the area of the surface in the box as seen along the axis. What is seen twice counts twice.
    fn covered_areas(&self, surface: &Surface) -> DVec3 {
        let extent = self.hi - self.lo;
        DVec3::from_array([0, 1, 2].map(|axis| {
            let (square, linear) = (surface.squares[axis], surface.linear[axis]);
            let in_box = |root: &f64| (self.lo[axis]..=self.hi[axis]).contains(root);
            let crossings = |point| roots(square, linear, surface.value(point)).into_iter().filter(in_box).count();
            let crossings: usize = grid(axis, self.lo, self.hi).map(crossings).sum();
            let area = extent[(axis + 1) % 3] * extent[(axis + 2) % 3];
            crossings as f64 * area / f64::from(GRID * GRID)
        }))
    }
}

/// The least and the greatest coordinates.
fn bounds(points: impl Iterator<Item = DVec3>) -> [DVec3; 2] {
    points.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[lo, hi], point| [lo.min(point), hi.max(point)])
}

/// The middles of the cells of a grid over a box, as seen along an axis. On the axis the coordinate is 0.
fn grid(axis: usize, lo: DVec3, hi: DVec3) -> impl Iterator<Item = DVec3> {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let at = move |axis: usize, step: u32| lo[axis] + (hi[axis] - lo[axis]) * (f64::from(step) + 0.5) / f64::from(GRID);
    (0..GRID * GRID).map(move |cell| {
        let mut point = DVec3::ZERO;
        (point[u], point[v]) = (at(u, cell / GRID), at(v, cell % GRID));
        point
    })
}

/// The real roots of `square·t² + linear·t + constant`. A double root counts twice; NaN stands for none.
fn roots(square: f64, linear: f64, constant: f64) -> [f64; 2] {
    if square == 0.0 {
        return [if linear == 0.0 { f64::NAN } else { -constant / linear }, f64::NAN];
    }
    let (middle, reach) =
        (-linear / (2.0 * square), (linear * linear - 4.0 * square * constant).sqrt() / (2.0 * square));
    [middle - reach, middle + reach]
}

#[cfg(test)]
mod tests {
    use std::f32::consts::TAU;

    use glam::Affine3;

    use super::super::tests::{
        BLUE, IntoGeometry, RED, assert_similar_picture, built_in, colored, mesh, moved, rotation, variants, world,
    };
    use super::*;
    use crate::tracer::{Checker, Part, Placement};

    /// A surface of revolution about z: `n` vertices on a ring for each radius and height. A radius of 0 is a point.
    fn revolved(n: u32, outline: &[(f32, f32)]) -> Mesh {
        let ring = |&(radius, height): &(f32, f32)| {
            let at = move |step: u32| {
                let (sin, cos) = (TAU * (step as f32 + 0.3) / n as f32).sin_cos();
                Vec3::new(radius * cos, radius * sin, height)
            };
            (0..n).map(at)
        };
        let positions = outline.iter().flat_map(ring).collect();
        let square = |ring: u32, step: u32| {
            let [a, b] = [step, (step + 1) % n].map(|step| ring * n + step);
            [[a, b, b + n], [a, b + n, a + n]]
        };
        let squares = (0..outline.len() as u32 - 1).flat_map(|ring| (0..n).flat_map(move |step| square(ring, step)));
        let mesh = colored(positions, squares.collect(), RED);
        let has_area = |&number: &u32| !crate::tracer::has_zero_area(&mesh.triangle(number));
        mesh.subset(&(0..mesh.len() as u32).filter(has_area).collect::<Vec<_>>())
    }

    /// The outline of a surface, at 24 heights from `lo` to `hi`.
    fn outline(lo: f32, hi: f32, radius: impl Fn(f32) -> f32) -> Vec<(f32, f32)> {
        (0..=24).map(|step| lo + (hi - lo) * step as f32 / 24.0).map(|height| (radius(height), height)).collect()
    }

    fn hemisphere() -> Mesh {
        let angles = (0..=16).map(|step| (TAU / 4.0 * step as f32 / 16.0).sin_cos());
        revolved(64, &angles.map(|(sin, cos)| (if cos < 1e-6 { 0.0 } else { cos }, sin)).collect::<Vec<_>>())
    }

    fn only_mesh(mesh: Mesh) -> World {
        world(vec![(mesh.into_geometry(), Affine3::IDENTITY)])
    }

    #[test]
    fn tessellations_become_quadrics() {
        let sphere = mesh("sphere:1e4");
        for (name, mesh) in [
            ("ellipsoid", moved(&sphere, Affine3::from_scale(Vec3::new(1.0, 2.0, 3.0)))),
            ("spheroid", moved(&sphere, Affine3::from_scale(Vec3::new(2.0, 2.0, 1.0)))),
            ("sphere", sphere),
            ("cylinder", revolved(64, &[(1.0, -1.5), (1.0, 2.0)])),
            ("tube of several rings", revolved(40, &outline(-1.0, 3.0, |_| 0.7))),
            ("cone", revolved(100, &[(0.0, 0.0), (1.0, 2.0)])),
            (
                "elliptic cone",
                moved(
                    &revolved(64, &outline(0.0, 2.0, |height| height)),
                    Affine3::from_scale(Vec3::new(1.0, 2.0, 1.0)),
                ),
            ),
            ("flat cone", revolved(100, &[(0.0, 0.0), (3.0, 0.5)])),
            ("frustum", revolved(64, &[(0.5, 1.0), (1.0, 2.0)])),
            ("paraboloid", revolved(64, &outline(0.0, 2.0, f32::sqrt))),
            ("hyperboloid of one sheet", revolved(64, &outline(-1.0, 1.5, |height| (1.0 + height * height).sqrt()))),
            ("hyperboloid of two sheets", revolved(64, &outline(1.0, 3.0, |height| (height * height - 1.0).sqrt()))),
        ] {
            for (variant, mesh) in variants(&mesh) {
                let world = only_mesh(mesh);
                let simpler = find(&world).unwrap_or_else(|| panic!("{name} {variant}"));
                let counts = (simpler.world.triangles(), simpler.world.quadrics(), simpler.world.instances().len());
                assert_eq!(counts, (0, 1, 1), "{name} {variant}");
                let share = simpler.deviation.distance() / world.bounds().diagonal();
                assert!(share > 1e-5 && share < MAX_CHORD_ERROR, "{name} {variant}: {share}");
                assert_similar_picture(&world, &simpler);
            }
        }
    }

    #[test]
    fn the_box_cuts_what_the_mesh_leaves_out() {
        let hemisphere = hemisphere();
        for (name, transform) in [
            ("upright", Affine3::IDENTITY),
            ("on its side", Affine3::from_rotation_y(TAU / 4.0)),
            ("far away", Affine3::from_translation(Vec3::new(40.0, 0.0, -30.0))),
        ] {
            let world = only_mesh(moved(&hemisphere, transform));
            assert_similar_picture(&world, &find(&world).unwrap_or_else(|| panic!("{name}")));
        }
    }

    #[test]
    fn the_simplest_description_is_found() {
        let shown = |mesh: Mesh| {
            let (geometries, instances) = find(&only_mesh(mesh)).unwrap().world.into_parts();
            let [Geometry::Quadric(quadric)] = geometries[..] else { panic!("{geometries:?}") };
            (quadric, instances[0].object_to_world)
        };
        let center = Vec3::new(3.0, -2.0, 5.0);
        let (ball, placed) = shown(moved(&mesh("sphere:1e4"), Affine3::from_translation(center)));
        assert_eq!((ball.squares, ball.products, ball.linear), (Vec3::ONE, Vec3::ZERO, Vec3::ZERO));
        assert!((ball.constant + 1.0).abs() < 1e-6, "{ball:?}");
        assert_eq!(placed.matrix3, glam::Mat3::IDENTITY);
        assert!(placed.translation.abs_diff_eq(center, 1e-6), "{placed}");
        let (cone, placed) = shown(revolved(100, &[(0.0, 1.0), (1.0, 3.0)]));
        assert_eq!((cone.squares.truncate(), cone.linear, cone.constant), (glam::Vec2::ONE, Vec3::ZERO, 0.0));
        assert!((cone.squares.z + 0.25).abs() < 1e-6 && placed.translation.abs_diff_eq(Vec3::Z, 1e-6), "{placed}");
        // No vertex is where a coarse tube is widest. The box is wide enough for the quadric.
        let (tube, _) = shown(revolved(20, &outline(0.0, 1.0, |_| 1.0)));
        let reach = tube.clip.hi.truncate().min(-tube.clip.lo.truncate());
        assert!(reach.min_element() > 1.0 && reach.max_element() < 1.05, "{tube:?}");
        assert!((tube.clip.extent().z - 1.0).abs() < 1e-6, "{tube:?}");
    }

    #[test]
    fn a_quadric_faces_as_its_triangles_do() {
        let sphere = mesh("sphere:1e3");
        let inwards = sphere.triangles().iter().map(|&[a, b, c]| [a, c, b]).collect();
        let inwards = colored(sphere.positions().to_vec(), inwards, RED);
        for (mesh, sign) in [(sphere, 1.0), (inwards, -1.0)] {
            let simpler = find(&only_mesh(mesh)).unwrap();
            let [Geometry::Quadric(quadric)] = simpler.world.geometries() else { panic!("{}", simpler.about) };
            assert_eq!(quadric.squares, Vec3::splat(sign));
        }
    }

    #[test]
    fn every_instance_shows_the_quadrics_and_the_rest_in_its_colours() {
        let at = |x: f32| Affine3::from_translation(Vec3::X * x);
        let [sphere, terrain] = ["sphere:1e4", "terrain:1e3"].map(mesh);
        let parts =
            [moved(&sphere, at(-2.5)).in_color(BLUE), moved(&terrain, Affine3::from_scale(Vec3::splat(0.02))), sphere];
        let above = Affine3 { translation: Vec3::Y * 4.0, ..rotation() };
        let instances =
            vec![Placement::new(0, at(0.0)), Placement::new(0, above).with_paint(Paint::Plain(RED)).with_mask(2)];
        let world = World::new(vec![Mesh::joined(&parts).unwrap().into_geometry()], instances).unwrap();
        let simpler = find(&world).unwrap();
        assert_eq!((simpler.world.triangles(), simpler.world.quadrics()), (terrain.len(), 2));
        let masks: Vec<_> = simpler.world.instances().iter().map(|placement| placement.mask).collect();
        assert_eq!(masks, [u32::MAX, u32::MAX, u32::MAX, 2, 2, 2]);
        assert_similar_picture(&world, &simpler);
        // The larger an instance, the larger the distance between the surfaces.
        let (geometries, mut instances) = world.into_parts();
        instances[1].object_to_world = rotation() * Affine3::from_scale(Vec3::new(1.0, 3.0, 1.0));
        let larger = find(&World::new(geometries, instances).unwrap()).unwrap();
        let times = larger.deviation.distance() / simpler.deviation.distance();
        assert!((times - 3.0).abs() < 1e-3, "{times}");
    }

    #[test]
    fn what_only_resembles_a_quadric_stays() {
        let found = |mesh: Mesh| find(&only_mesh(mesh)).is_some();
        let sphere = mesh("sphere:1e4");
        let all: Vec<u32> = (0..sphere.len() as u32).collect();
        assert!(found(sphere.clone()));
        assert!(!found(sphere.subset(&all[1..])), "a hole");
        assert!(!found(sphere.subset(&all[..sphere.len() / 3])), "a part that no box cuts out");
        assert!(!found(moved(&hemisphere(), rotation())), "a hemisphere that no box cuts out");
        assert!(!found(sphere.subset(&[&all[..], &all[..]].concat())), "covered twice");
        assert!(!found(moved(&sphere, Affine3::from_translation(Vec3::splat(1e4)))), "coarse coordinates");
        let mut positions = sphere.positions().to_vec();
        positions[1234] *= 1.0001;
        assert!(!found(colored(positions, sphere.triangles().to_vec(), RED)), "a bump");
        assert!(!found(revolved(4, &outline(0.0, 9.0, |_| 1.0))), "a prism");
        assert!(!found(revolved(12, &outline(0.0, 1.0, |_| 1.0))), "a coarse cylinder");
        assert!(!found(revolved(64, &outline(-1.0, 1.0, |height| 2.0 + height.powi(3)))), "no quadric");
        let spots = [(0, RED), (40, BLUE)].map(|(first_triangle, color)| Part { first_triangle, color });
        let spotted = Mesh::new(sphere.positions().to_vec(), sphere.triangles().to_vec(), spots.to_vec()).unwrap();
        assert!(!found(spotted.clone()), "two colours");
        let paint = |paint| {
            let instances = vec![Placement::new(0, Affine3::IDENTITY).with_paint(paint)];
            find(&World::new(vec![spotted.clone().into_geometry()], instances).unwrap()).is_some()
        };
        assert!(paint(Paint::Plain(RED)), "painted in one colour");
        let checker = Checker { colors: [RED, BLUE], uv_to_squares: glam::Affine2::IDENTITY };
        assert!(!paint(Paint::Checker(checker)), "a pattern");
        for name in ["room:small", "terrain:1e3", "forest:1000"] {
            assert!(find(&built_in(name)).is_none(), "{name}");
        }
    }
}
