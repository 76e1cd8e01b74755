//! Splits a polygon in space into triangles.
//!
//! The polygon is seen along its normal (Newell's, which is also defined where the polygon is bent or concave). There:
//!
//! 1. If the fan around the first corner covers the polygon exactly once, it is kept. That holds for every convex
//!    polygon, and takes linear time.
//! 2. Otherwise `spade` makes a constrained Delaunay triangulation, whose predicates are exact. The polygon winds once
//!    around the triangles inside. That also holds for polygons that touch themselves, as a hole does that is joined
//!    to the outline by a cut. `n` corners take about `n log n` steps.
//! 3. If edges cross, or the polygon winds otherwise, there is no right answer. It stays a fan, and is reported.
//!
//! Every triangle has three corners of the polygon, and turns as the polygon does.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::Path;

use glam::{DVec3, Vec3};
use spade::handles::{DirectedEdgeHandle, FixedVertexHandle};
use spade::{
    ConstrainedDelaunayTriangulation, HasPosition, HierarchyHintGenerator, Intersection, LineIntersectionIterator,
    Point2, Triangulation,
};

use super::line::LineCount;
use crate::kernels::power_of_two_below;
use crate::tracer::meshes::generator::hash;

/// A polygon is flat if its corners lie between two planes. This is the largest distance of the planes, relative to
/// the distance from the first corner to the farthest. Rounded coordinates stay far below it.
const MAX_THICKNESS: f64 = 0.01;

/// `spade` refuses numbers that are closer to 0 than about 2e-43. The largest coordinate is between 1 and 2.
const SMALLEST: f64 = 1e-40;

/// What is odd about a polygon.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Flaws {
    /// Edges cross, or parts overlap.
    crossing: bool,
    /// The corners are not in one plane.
    bent: bool,
}

/// The polygons of a file that have no obvious surface.
#[derive(Debug, Default)]
pub(super) struct OddPolygons {
    crossing: LineCount,
    bent: LineCount,
}

impl OddPolygons {
    /// The triangles of a polygon with at least three corners. There is at least one. They hold numbers of corners,
    /// counted from 0. `line` and `text` show the polygon in warnings.
    pub(super) fn split(
        &mut self,
        corners: &[Vec3],
        line: impl Into<Option<usize>>,
        text: impl Fn() -> String,
    ) -> Vec<[usize; 3]> {
        let (triangles, Flaws { crossing, bent }) = split(corners);
        let line = line.into();
        for (has_flaw, count) in [(crossing, &mut self.crossing), (bent, &mut self.bent)] {
            if has_flaw {
                count.add_with(line, &text);
            }
        }
        triangles
    }

    pub(super) fn warnings(&self, file: &Path) -> impl Iterator<Item = String> {
        let crossing = self.crossing.warning(file, "polygon crosses itself, so its triangles may reach outside");
        let bent = self.bent.warning(file, "polygon is not flat, so its surface depends on how it is split");
        crossing.into_iter().chain(bent)
    }
}

/// See [`OddPolygons::split`].
fn split(corners: &[Vec3]) -> (Vec<[usize; 3]>, Flaws) {
    let fan = || (2..corners.len()).map(|corner| [0, corner - 1, corner]).collect();
    let spokes = spokes(corners);
    let newell: DVec3 = spokes.windows(2).map(|pair| pair[0].cross(pair[1])).sum();
    let Some(normal) = newell.try_normalize() else {
        // Without area, all corners are on one line, or parts of the polygon cancel each other.
        let crossing = spokes.windows(2).any(|pair| pair[0].cross(pair[1]) != DVec3::ZERO);
        return (fan(), Flaws { crossing, bent: false });
    };
    let bent = is_bent(&spokes, normal);
    if fan_covers_once(&spokes, normal) {
        return (fan(), Flaws { crossing: false, bent });
    }
    match delaunay(&spokes, normal) {
        Some(inside) if has_area(&inside, &spokes, newell) => (inside, Flaws { crossing: false, bent }),
        _ => (fan(), Flaws { crossing: true, bent }),
    }
}

/// Whether the triangles have the area of the polygon, in every direction. Parts of a bent polygon may be hidden when
/// it is seen along its normal.
fn has_area(triangles: &[[usize; 3]], spokes: &[DVec3], newell: DVec3) -> bool {
    let corners = triangles.iter().map(|triangle| triangle.map(|corner| spokes[corner]));
    let area: DVec3 = corners.map(|[a, b, c]| (b - a).cross(c - a)).sum();
    (area - newell).length() <= MAX_THICKNESS * newell.length()
}

/// The corners relative to the first one, in units of the largest coordinate. The difference is exact in `f64` unless
/// magnitudes differ greatly. The unit is a power of two, so the division is exact.
fn spokes(corners: &[Vec3]) -> Vec<DVec3> {
    let first = corners[0].as_dvec3();
    let extent = corners.iter().map(|corner| (corner.as_dvec3() - first).abs().max_element()).fold(0.0, f64::max);
    let unit = if extent > 0.0 { power_of_two_below(extent) } else { 1.0 };
    corners.iter().map(|corner| (corner.as_dvec3() - first) / unit).collect()
}

fn is_bent(spokes: &[DVec3], normal: DVec3) -> bool {
    let (mut lowest, mut highest, mut extent) = (0.0, 0.0, 0.0);
    for spoke in spokes {
        let height = spoke.dot(normal);
        lowest = f64::min(lowest, height);
        highest = f64::max(highest, height);
        extent = f64::max(extent, spoke.length());
    }
    highest - lowest > MAX_THICKNESS * extent
}

/// Whether the fan around the first corner covers each point at most once: its spokes turn one way, by less than a
/// full turn.
fn fan_covers_once(spokes: &[DVec3], normal: DVec3) -> bool {
    // Corners that repeat the first one add only triangles of zero area.
    let is_corner = |spoke: &DVec3| *spoke != DVec3::ZERO;
    let (Some(first), Some(last)) = (spokes.iter().position(is_corner), spokes.iter().rposition(is_corner)) else {
        return true;
    };
    let spokes = &spokes[first..=last];
    let turn = |from: DVec3, to: DVec3| from.cross(to).dot(normal);
    let mut beyond_half_turn = false;
    spokes.windows(2).all(|pair| {
        let step = turn(pair[0], pair[1]);
        let from_first = turn(spokes[0], pair[1]);
        let full_turn = beyond_half_turn && from_first >= 0.0;
        beyond_half_turn |= from_first < 0.0;
        (step > 0.0 || step == 0.0 && pair[0].dot(pair[1]) > 0.0) && !full_turn
    })
}

/// With a hierarchy, the place of a corner is found in logarithmic time.
type Delaunay = ConstrainedDelaunayTriangulation<Corner, (), (), (), HierarchyHintGenerator<f64>>;

/// A corner as `spade` sees it.
struct Corner {
    number: usize,
    position: Point2<f64>,
}

impl HasPosition for Corner {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.position
    }
}

/// The triangles inside a polygon, seen along its normal. They turn as the polygon does. `None` if it crosses itself or
/// winds around some point other than once.
fn delaunay(polygon: &[DVec3], normal: DVec3) -> Option<Vec<[usize; 3]>> {
    let (x, y) = normal.any_orthonormal_pair();
    let position = |corner: DVec3| {
        let [x, y] =
            [x, y].map(|axis| corner.dot(axis)).map(|number| if number.abs() < SMALLEST { 0.0 } else { number });
        Point2::new(x, y)
    };
    // Corners and edges in the order of the outline would take quadratic time on some polygons, and so do the bulk
    // loads of spade. The order must not differ from run to run, since it decides between equal diagonals.
    let mut order: Vec<_> = (0..polygon.len()).collect();
    order.sort_unstable_by_key(|&number| hash(number as u32, 0, 0));
    let mut mesh = Delaunay::new();
    // Corners at the same place share a vertex.
    let mut places = HashMap::new();
    let mut vertices = vec![FixedVertexHandle::from_index(0); polygon.len()];
    for &number in &order {
        vertices[number] = match places.entry((polygon[number] + 0.0).to_array().map(f64::to_bits)) {
            Entry::Occupied(vertex) => *vertex.get(),
            Entry::Vacant(place) => {
                let position = position(polygon[number]);
                *place.insert(mesh.insert(Corner { number, position }).ok()?)
            }
        };
    }
    if mesh.num_vertices() < places.len() {
        // One corner hides another.
        return None;
    }
    let edge = |&number: &usize| [vertices[number], vertices[(number + 1) % polygon.len()]];
    let edges = || order.iter().map(edge).filter(|[from, to]| from != to);
    for [from, to] in edges() {
        if !mesh.can_add_constraint(from, to) {
            return None;
        }
        mesh.add_constraint(from, to);
    }

    // How often the polygon takes each edge, less how often it takes the edge backwards.
    let mut passes = vec![0; mesh.num_directed_edges()];
    for [from, to] in edges() {
        for intersection in LineIntersectionIterator::new_from_handles(&mesh, from, to) {
            if let Intersection::EdgeOverlap(edge) = intersection {
                passes[edge.fix().index()] += 1;
                passes[edge.rev().fix().index()] -= 1;
            }
        }
    }

    // From the outer face inwards: how often the polygon winds around each face.
    let mut windings = vec![None; mesh.num_all_faces()];
    windings[mesh.outer_face().fix().index()] = Some(0);
    let mut inside = Vec::new();
    let mut border: Vec<_> = mesh.directed_edges().filter(DirectedEdgeHandle::is_outer_edge).collect();
    while let Some(edge) = border.pop() {
        let inwards = edge.rev();
        let Some(face) = inwards.face().as_inner() else { continue };
        if windings[face.fix().index()].is_some() {
            continue;
        }
        let winding = windings[edge.face().fix().index()]? + passes[inwards.fix().index()];
        windings[face.fix().index()] = Some(winding);
        match winding {
            0 => {}
            1 => inside.push(face.vertices().map(|vertex| vertex.data().number)),
            _ => return None,
        }
        border.extend(face.adjacent_edges());
    }
    Some(inside)
}
