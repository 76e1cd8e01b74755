//! Random meshes, and rays that meet their edges and vertices exactly.
//!
//! Every coordinate is a whole number of at most 24 bits, times one power of two. `f32` holds the points and their
//! differences without rounding, so it also holds the direction from one point to another. A ray aimed at a point of an
//! edge passes exactly through that point.
//!
//! All triangles of a mesh face a ray the same way. A silhouette would be different: there two neighbours face opposite
//! ways and lie on the same side of their shared edge. A ray that touches the edge may pass both, or enter through one
//! and leave through the other. Zero and two hits are correct there, so such rays would prove nothing.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use glam::Vec3;
use wide::f32x8;

use super::Options;
use super::counts::Counts;
use super::exact::decide;
use super::int3::{Int3, cross, dot, exactly, is_aimed, minus, plus};
use super::random::Random;
use super::triangles::describe;
use crate::geom::{Ray, Triangle};
use crate::kernels::{Claim, Intersect, Kernel};

/// Vertices are multiples of this: sixteenths of an edge are then whole numbers too.
const STEP: i64 = 16;
/// The greatest coordinate of a vertex: differences then have at most 24 bits.
const REACH: i64 = 1 << 23;
/// The least altitude of a triangle after splitting. Rounded coordinates move a ray by up to a few units. That could
/// flip a flatter triangle, or move a ray from a sixteenth of an edge to the end of the edge.
const LEAST_ALTITUDE: i64 = 64 * STEP;

/// The transform of a mesh to the world: its axes exchanged and mirrored, its unit a power of two.
#[derive(Clone, Copy, Debug)]
struct Frame {
    axes: [usize; 3],
    signs: Vec3,
    unit: f32,
}

impl Frame {
    fn random(random: &mut Random) -> Self {
        let mut axes = [0, 1, 2];
        axes.rotate_left(random.below(3));
        axes[..2].rotate_left(random.below(2));
        let signs = Vec3::from_array([(); 3].map(|()| if random.below(2) == 0 { 1.0 } else { -1.0 }));
        // Some kernels compute volumes, which are products of three coordinates. With these units the volumes and their
        // rounding errors are normal numbers.
        Self { axes, signs, unit: 2f32.powi(8 - random.below(37) as i32) }
    }

    fn vector(&self, vector: Vec3) -> Vec3 {
        Vec3::from_array(self.axes.map(|axis| vector[axis])) * self.signs * self.unit
    }
}

/// Where the rays at a mesh start.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Side {
    /// Above or below, never flatter than 45°: the mesh is a height field whose slopes are lower.
    Above,
    /// Near the centre: the mesh is closed and star-shaped.
    Inside,
}

/// What a ray is aimed at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Target {
    Edge,
    Vertex,
}

/// A ray, and what it can hit.
#[derive(Debug)]
pub(super) struct Shot {
    pub(super) ray: Ray<f32>,
    pub(super) target: Target,
    /// The triangles that the ray hits, all on their boundary, sorted; empty for a ray one ulp off its target.
    pub(super) around: Vec<u32>,
    /// Groups of eight consecutive triangles: the ray can hit no triangle outside of them.
    pub(super) groups: Vec<u32>,
}

#[derive(Debug)]
pub(super) struct Mesh {
    pub(super) name: String,
    pub(super) triangles: Vec<Triangle>,
    side: Side,
    frame: Frame,
    vertices: Vec<Int3>,
    faces: Vec<[usize; 3]>,
}

impl Mesh {
    /// A lattice of `columns` by `rows` cells. Vertices and heights are moved at random, and each cell is cut along a
    /// random diagonal. Then random triangles are split in three until there are `total`. Cells are `cell` wide; 0
    /// means the greatest width that fits.
    pub(super) fn lattice(columns: i64, rows: i64, total: usize, cell: i64, seed: u64) -> Self {
        let mut random = Random::from_seed(seed);
        let most = REACH * 3 / 2 / columns.max(rows);
        let cell = if cell == 0 { most } else { cell * STEP };
        let mut about = |range: i64| (random.below(2 * range as usize + 1) as i64 - range).div_euclid(STEP) * STEP;
        let mut vertices = Vec::new();
        for row in 0..=rows {
            for column in 0..=columns {
                let corner = [(2 * column - columns) * cell / 2, (2 * row - rows) * cell / 2].map(|x| x / STEP * STEP);
                vertices.push([corner[0] + about(cell / 8), corner[1] + about(cell / 8), about(cell / 32)]);
            }
        }
        let mut faces = Vec::new();
        for row in 0..rows {
            for column in 0..columns {
                let index = |x: i64, y: i64| ((row + y) * (columns + 1) + column + x) as usize;
                let (a, b, c, d) = (index(0, 0), index(1, 0), index(1, 1), index(0, 1));
                faces.extend(if random.below(2) == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
            }
        }
        while faces.len() < total {
            split(&mut vertices, &mut faces, &mut random);
        }
        Self::new(
            format!("lattice {columns}x{rows}, {total} triangles, seed {seed}"),
            Side::Above,
            vertices,
            faces,
            random,
        )
    }

    /// `count` triangles around one vertex.
    pub(super) fn fan(count: usize, seed: u64) -> Self {
        let mut random = Random::from_seed(seed);
        let slope = (random.below(9) as f64 - 4.0) / 16.0;
        let mut fraction = || random.below(1 << 20) as f64 / f64::from(1 << 20);
        let round = |x: f64| x as i64 / STEP * STEP;
        let mut vertices = vec![[0, 0, 0]];
        for index in 0..count {
            let angle = TAU * (index as f64 + fraction() / 4.0) / count as f64;
            let radius = REACH as f64 * (0.75 + fraction() / 4.0);
            let height = radius * (slope + (fraction() - 0.5) / count as f64);
            vertices.push([radius * angle.cos(), radius * angle.sin(), height].map(round));
        }
        let faces = (1..=count).map(|index| [0, index, index % count + 1]).collect();
        Self::new(format!("fan of {count} triangles, seed {seed}"), Side::Above, vertices, faces, random)
    }

    /// A closed mesh: an octahedron, each triangle cut in four `levels` times, with vertices at about the same
    /// distance.
    pub(super) fn star(levels: u32, seed: u64) -> Self {
        let mut random = Random::from_seed(seed);
        let radius = REACH / 2;
        let mut vertices = Vec::new();
        for axis in 0..3 {
            for sign in [1, -1] {
                let mut vertex = [0; 3];
                vertex[axis] = sign * (radius - random.below(radius as usize / 4) as i64) / STEP * STEP;
                vertices.push(vertex);
            }
        }
        let mut faces = vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
        for level in 1..=levels {
            let mut middles = BTreeMap::new();
            let mut middle = |a: usize, b: usize| {
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    let sum = plus(vertices[a], vertices[b], 1).map(|x| x as f64);
                    let length = sum.iter().map(|x| x * x).sum::<f64>().sqrt();
                    let room = radius >> (level + 3);
                    let wanted = (radius * 7 / 8 + random.below(room as usize) as i64) as f64;
                    vertices.push(sum.map(|x| (x / length * wanted) as i64 / STEP * STEP));
                    vertices.len() - 1
                })
            };
            faces = faces
                .iter()
                .flat_map(|&[a, b, c]| {
                    let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
                })
                .collect();
        }
        Self::new(format!("star of {} triangles, seed {seed}", faces.len()), Side::Inside, vertices, faces, random)
    }

    fn new(name: String, side: Side, vertices: Vec<Int3>, mut faces: Vec<[usize; 3]>, mut random: Random) -> Self {
        // Sorts neighbours next to each other: a ray then needs few groups of eight.
        faces.sort_by_cached_key(|face| along_a_curve(vertices[face[0]]));
        for face in &mut faces {
            face.rotate_left(random.below(3));
        }
        let frame = Frame::random(&mut random);
        let at = |index: usize| frame.vector(exactly(vertices[index]));
        let triangles = faces.iter().map(|&[a, b, c]| Triangle { v0: at(a), v1: at(b), v2: at(c) }).collect();
        let mesh = Self { name, triangles, side, frame, vertices, faces };
        if side == Side::Above {
            mesh.assert_facing_all_from_above();
        }
        mesh
    }

    fn corners(&self, face: usize) -> [Int3; 3] {
        self.faces[face].map(|index| self.vertices[index])
    }

    fn normal(&self, face: usize) -> Int3 {
        let [a, b, c] = self.corners(face);
        cross(minus(b, a), minus(c, a))
    }

    /// Checks the four corner directions. The cosine is linear up to a positive factor, so a triangle that faces these
    /// four faces all directions between them.
    fn assert_facing_all_from_above(&self) {
        for face in 0..self.faces.len() {
            for corner in [[1, 1, 1], [1, -1, 1], [-1, 1, 1], [-1, -1, 1]] {
                assert!(dot(self.normal(face), corner) > 0, "{}: triangle {face} is too steep", self.name);
            }
        }
    }

    fn assert_facing(&self, origin: Int3, dir: Int3) {
        match self.side {
            Side::Above => {
                assert!(dir[2] != 0 && dir[0].abs().max(dir[1].abs()) <= dir[2].abs(), "{dir:?} is too flat");
            }
            // An origin behind every triangle: every ray from there meets the back of each triangle that it hits.
            Side::Inside => {
                for face in 0..self.faces.len() {
                    let way = minus(self.vertices[self.faces[face][0]], origin);
                    assert!(dot(way, self.normal(face)) > 0, "{}: {origin:?} is before triangle {face}", self.name);
                }
            }
        }
    }

    /// Origin and direction of a ray through `target`.
    fn aim(&self, target: Int3, random: &mut Random) -> (Int3, Int3) {
        let mut within = |range: i64| random.below(2 * range as usize + 1) as i64 - range;
        if self.side == Side::Inside {
            let origin = [(); 3].map(|()| if within(4) == 0 { 0 } else { within(REACH / 64) });
            let way = minus(target, origin);
            let divisor = 1 << way.iter().fold(0, |bits, x| bits | x).trailing_zeros();
            let stretch = within(1).abs() * 2 + 1;
            return (origin, way.map(|x| x / divisor * stretch));
        }
        // A step downwards, the number of steps to the target, and the length of the direction in steps.
        let (step, count, stretch) = match within(2) {
            -2 => ([0, 0, -1], within(REACH).abs() + 1, 1 << within(8).abs()),
            -1 => ([within(1), within(1), -1], within(REACH).abs() + 1, 1 << within(8).abs()),
            0 => {
                let steep = within(4).abs() + 5;
                ([within(steep), within(steep), -steep], within(REACH / 16).abs() + 1, 3)
            }
            1 => {
                let steep = within(REACH - 1).abs() + 1;
                ([within(steep), within(steep), -steep], 1, 1)
            }
            _ => {
                let steep = within(REACH / 2).abs() + 1;
                ([within(steep), within(steep), -steep], 1, 3)
            }
        };
        let step = if within(1) == 0 { step.map(|x| -x) } else { step };
        let stretch = if step.iter().any(|x| x * stretch >= 1 << 24) { 1 } else { stretch };
        (plus(target, step, -count), step.map(|x| x * stretch))
    }

    /// `count` rays: half are aimed at edges, half at vertices, none at the border of the mesh. One in four is then
    /// moved one ulp off its target.
    pub(super) fn shots(&self, count: usize, seed: u64) -> Vec<Shot> {
        let mut edges = BTreeMap::<_, Vec<u32>>::new();
        let mut fans = vec![Vec::new(); self.vertices.len()];
        for (face, &corners) in (0..).zip(&self.faces) {
            for side in 0..3 {
                let (a, b) = (corners[side], corners[(side + 1) % 3]);
                edges.entry((a.min(b), a.max(b))).or_default().push(face);
                fans[a].push(face);
            }
        }
        for (&(a, b), _) in edges.iter().filter(|(_, faces)| faces.len() == 1) {
            (fans[a], fans[b]) = (Vec::new(), Vec::new());
        }
        let edges: Vec<_> = edges.into_iter().filter(|(_, faces)| faces.len() == 2).collect();
        let fans: Vec<_> = fans.into_iter().enumerate().filter(|(_, faces)| !faces.is_empty()).collect();
        assert!(!edges.is_empty() && !fans.is_empty(), "{}: no inner edge or vertex", self.name);

        let (boxes, reach) = (self.boxes(), self.reach());
        let mut random = Random::from_seed(seed);
        let mut shots = Vec::new();
        for index in 0..count {
            let (point, target, around) = if index % 2 == 0 {
                let ((a, b), around) = &edges[random.below(edges.len())];
                let (a, b) = (self.vertices[*a], self.vertices[*b]);
                let sixteenths = 1 + random.below(15) as i64;
                (plus(a, minus(b, a).map(|x| x / STEP), sixteenths), Target::Edge, around)
            } else {
                let (vertex, around) = &fans[random.below(fans.len())];
                (self.vertices[*vertex], Target::Vertex, around)
            };
            let (origin, dir) = self.aim(point, &mut random);
            assert!(is_aimed(origin, dir, point), "{origin:?} + t {dir:?} does not meet {point:?}");
            self.assert_facing(origin, dir);

            let zeros = [(); 3].map(|()| if random.below(2) == 0 { 0.0 } else { -0.0 });
            let signed = Vec3::select(exactly(dir).cmpeq(Vec3::ZERO), Vec3::from(zeros), exactly(dir));
            let mut ray = Ray::new(self.frame.vector(exactly(origin)), self.frame.vector(signed));
            let mut around = around.clone();
            if random.below(4) == 0 {
                around.clear();
                self.move_off(&mut ray, &mut random);
            }
            let groups = self.groups(point, &boxes, reach);
            let shot = Shot { ray, target, around, groups };
            self.confirm(&shot);
            shots.push(shot);
        }
        shots
    }

    /// Moves the origin by one ulp, across the direction.
    fn move_off(&self, ray: &mut Ray<f32>, random: &mut Random) {
        let steepest = ray.dir.abs().max_position();
        let axis = (steepest + 1 + random.below(2)) % 3;
        let x = ray.origin[axis];
        // The neighbours of zero are subnormal, and kernels promise nothing for subnormal numbers.
        let step = self.frame.unit / 1024.0;
        ray.origin[axis] = match (x == 0.0, random.below(2) == 0) {
            (false, true) => x.next_up(),
            (false, false) => x.next_down(),
            (true, true) => step,
            (true, false) => -step,
        };
    }

    /// Least and greatest x and y of each group of eight triangles.
    fn boxes(&self) -> Vec<[[i64; 2]; 2]> {
        assert!(self.faces.len().is_multiple_of(8));
        let group = |faces: &[[usize; 3]]| {
            [0, 1].map(|axis| {
                let all = || faces.as_flattened().iter().map(|&index| self.vertices[index][axis]);
                [all().min().unwrap(), all().max().unwrap()]
            })
        };
        self.faces.chunks(8).map(group).collect()
    }

    /// The greatest distance from the target, along x or y, at which a ray can hit a triangle.
    ///
    /// A height field lies between two heights. A ray that is never flatter than 45° moves sideways by at most their
    /// difference. Rounding moves a hit by at most an ulp or two of the greatest coordinate; the margin is greater.
    fn reach(&self) -> i64 {
        let heights = || self.vertices.iter().map(|vertex| vertex[2]);
        heights().max().unwrap() - heights().min().unwrap() + 4 * STEP
    }

    /// The groups that a ray through `point` can hit. From inside these are all groups.
    fn groups(&self, point: Int3, boxes: &[[[i64; 2]; 2]], reach: i64) -> Vec<u32> {
        let near = |group: &[[i64; 2]; 2]| {
            [0, 1].iter().all(|&axis| {
                let [least, greatest] = group[axis];
                least - reach <= point[axis] && point[axis] <= greatest + reach
            })
        };
        let inside = self.side == Side::Inside;
        (0..).zip(boxes).filter(|(_, group)| inside || near(group)).map(|(index, _)| index).collect()
    }

    /// Asks for the exact answers: of the triangles in reach the ray hits those around the target, on their boundary,
    /// and no others. A ray one ulp off its target hits at least one.
    fn confirm(&self, shot: &Shot) {
        let mut hits = 0;
        for triangle in shot.groups.iter().flat_map(|group| 8 * group..8 * group + 8) {
            let truth = decide(&shot.ray, &self.triangles[triangle as usize]).expect("coordinates have few digits");
            hits += usize::from(truth.hit);
            if truth.hit && !shot.around.is_empty() {
                let expected = truth.boundary && shot.around.binary_search(&triangle).is_ok();
                assert!(expected, "{}: {:?} hits triangle {triangle}", self.name, shot.ray);
            }
        }
        let enough = if shot.around.is_empty() { hits > 0 } else { hits == shot.around.len() };
        assert!(enough, "{}: {:?} hits {hits} triangles, not {:?}", self.name, shot.ray, shot.around);
    }

    /// Counts how many of these rays break the claims of a kernel.
    pub(super) fn count<K: Kernel<Shape = Triangle>>(&self, shots: &[Shot]) -> Counts {
        let prepared: Vec<K> = self.triangles.iter().map(K::prepare).collect();
        let packets: Vec<K::Packet> = prepared.as_chunks().0.iter().map(K::gather).collect();
        let mut counts = Counts::default();
        for shot in shots {
            let ray = Ray::splat(&shot.ray);
            let setup = <K as Intersect<f32x8>>::setup(&ray);
            let mut hits = Vec::new();
            for &group in &shot.groups {
                let mask = packets[group as usize].closest_hit(&ray, &setup).mask.bits();
                hits.extend((0..8).filter(|lane| mask >> lane & 1 == 1).map(|lane| 8 * group + lane));
            }
            // One ulp off the target, a hit of any triangle is enough.
            let accepted = |hit: &u32| shot.around.is_empty() || shot.around.binary_search(hit).is_ok();
            let leaks = !hits.iter().any(accepted);
            let watertight = match shot.target {
                Target::Edge => Claim::EdgeWatertight,
                Target::Vertex => Claim::VertexWatertight,
            };
            for (claim, broken) in [(watertight, leaks), (Claim::SingleHit, hits.len() != 1)] {
                counts.add(claim, 1, broken.into(), || self.describe(shot, &hits));
            }
        }
        counts
    }

    /// The triangles that the ray hits, and those that a kernel reports.
    fn describe(&self, shot: &Shot, hits: &[u32]) -> String {
        let in_reach = shot.groups.iter().flat_map(|group| 8 * group..8 * group + 8);
        let involved = in_reach.filter_map(|index| {
            let (triangle, reported) = (self.triangles[index as usize], hits.binary_search(&index).is_ok());
            let is_hit = decide(&shot.ray, &triangle).is_some_and(|truth| truth.hit);
            (reported || is_hit).then_some((index, triangle, reported))
        });
        format!("{}\n{}", self.name, describe(&shot.ray, &involved.collect::<Vec<_>>()))
    }
}

/// Random meshes, and rays that meet their edges and vertices. Exhaustive: of 8 to 65,536 triangles; otherwise up to
/// 512.
pub(super) fn all(options: &Options) -> Vec<(Mesh, Vec<Shot>)> {
    type Plan = (Box<dyn Fn(u64) -> Mesh>, u64, usize);
    let mut plans: Vec<Plan> = Vec::new();
    // Triangles, columns and rows of a whole lattice, columns and rows of a lattice to split, seeds.
    let sizes: [(usize, [i64; 2], i64, u64); 5] = [
        (8, [2, 2], 1, 64),
        (64, [4, 8], 1, 32),
        (512, [16, 16], 4, 8),
        (4096, [32, 64], 8, 4),
        (65_536, [128, 256], 32, 2),
    ];
    let (sizes, stars, thinned) = if options.exhaustive {
        (&sizes[..], &[(0, 64), (1, 32), (2, 16), (4, 2)][..], 1)
    } else {
        (&sizes[..3], &[(0, 64), (1, 32)][..], 4)
    };
    for &(total, [columns, rows], coarse, seeds) in sizes {
        let shots = 8_192 / seeds as usize / thinned;
        plans.push((Box::new(move |seed| Mesh::lattice(columns, rows, total, 0, seed)), seeds, shots));
        plans.push((Box::new(move |seed| Mesh::lattice(columns, rows, total, 64, seed)), seeds, shots));
        plans.push((Box::new(move |seed| Mesh::lattice(coarse, coarse, total, 0, seed)), seeds, shots));
        // Each ray meets all triangles of a fan, so large fans get fewer rays.
        plans.push((Box::new(move |seed| Mesh::fan(total, seed)), seeds, shots.min(1 << 21 >> total.ilog2())));
    }
    for &(levels, seeds) in stars {
        plans.push((Box::new(move |seed| Mesh::star(levels, seed)), seeds, 2_048 / seeds as usize / thinned));
    }
    let seeded = plans.iter().enumerate().flat_map(|(index, (make, seeds, shots))| {
        (0..*seeds).map(move |seed| {
            let seed = options.seed_of(1_000 * index as u64 + seed);
            let mesh = make(seed);
            let shots = mesh.shots(*shots, !seed);
            (mesh, shots)
        })
    });
    seeded.collect()
}

/// Splits a random triangle in three, unless one of them would be too flat.
fn split(vertices: &mut Vec<Int3>, faces: &mut Vec<[usize; 3]>, random: &mut Random) {
    let chosen = random.below(faces.len());
    let [a, b, c] = faces[chosen];
    let (u, v) = (4 + random.below(5) as i64, 4 + random.below(5) as i64);
    let weighted = |axis: usize| {
        let [a, b, c] = [a, b, c].map(|index| vertices[index][axis]);
        (a * (16 - u - v) + b * u + c * v) / 16 / STEP * STEP
    };
    let inner = [weighted(0), weighted(1), weighted(2)];
    let altitude = |[p, q, r]: [Int3; 3]| {
        let flat = |[x, y, _]: Int3| [x, y, 0];
        let edges = [minus(q, p), minus(r, q), minus(p, r)].map(flat);
        let longest = edges.iter().map(|&edge| (dot(edge, edge) as f64).sqrt()).fold(0.0, f64::max);
        (cross(edges[0], edges[1])[2] as f64 / longest) as i64
    };
    let lowest = [[a, b], [b, c], [c, a]].map(|edge| altitude([vertices[edge[0]], vertices[edge[1]], inner]));
    let lowest = lowest.into_iter().min().unwrap();
    if lowest >= LEAST_ALTITUDE {
        let range = lowest / 64 / STEP;
        let height = (random.below(2 * range as usize + 1) as i64 - range) * STEP;
        vertices.push(plus(inner, [0, 0, 1], height));
        let inner = vertices.len() - 1;
        faces[chosen] = [a, b, inner];
        faces.extend([[b, c, inner], [c, a, inner]]);
    }
}

/// Position along a Z-order curve through the plane.
fn along_a_curve([x, y, _]: Int3) -> u64 {
    let [x, y] = [x, y].map(|x| (x + 2 * REACH) as u64);
    (0..26).map(|bit| (x >> bit & 1) << (2 * bit) | (y >> bit & 1) << (2 * bit + 1)).sum()
}

#[cfg(all(test, feature = "study"))]
mod tests {
    use super::*;
    use crate::conformance::Options;
    use crate::oracle::Exact;

    /// The oracle confirms what [`Mesh::confirm`] found out, for other seeds too.
    #[test]
    fn rays_meet_their_targets_exactly() {
        let mut confirmed = 0;
        for (mesh, shots) in [0, 1, 2, u64::MAX].into_iter().flat_map(|seed| all(&Options::new().with_seed(seed))) {
            for shot in &shots {
                let reached = shot.groups.iter().flat_map(|group| 8 * group..8 * group + 8);
                let truths = reached.map(|index| (index, mesh.triangles[index as usize].truth(&shot.ray)));
                let hits: Vec<_> = truths.filter(|(_, truth)| truth.hit).collect();
                if shot.around.is_empty() {
                    assert!(!hits.is_empty(), "{}: {:?}", mesh.name, shot.ray);
                } else {
                    let found: Vec<_> = hits.iter().map(|(index, _)| *index).collect();
                    assert_eq!(found, shot.around, "{}: {:?}", mesh.name, shot.ray);
                    assert!(hits.iter().all(|(_, truth)| truth.boundary), "{}: {:?}", mesh.name, shot.ray);
                }
                confirmed += 1;
            }
        }
        assert!(confirmed > 80_000, "{confirmed} rays");
    }
}
