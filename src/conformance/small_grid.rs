//! All edges and all fans on a grid of 3×3×3 points, and rays that meet them exactly.
//!
//! The answer of a kernel for one triangle does not depend on its neighbours. So each triangle is tested once, against
//! all rays. The sets of rays that hit are then combined for every mesh that contains the triangle.

use std::ops::{BitAnd, BitOr, Not};

use wide::f32x8;

use super::counts::Counts;
use super::int3::{Int3, cross, dot, exactly, is_aimed, minus, plus};
use super::triangles::describe;
use super::twins::hit8;
use super::{Options, threads};
use crate::geom::{Ray, Triangle};
use crate::kernels::{Claim, Kernel};

/// The planes of the grid along each axis, and the `t` at which a ray meets its target.
pub(super) struct Grid {
    planes: [[i64; 3]; 3],
    pub(super) distance: i64,
}

/// A grid of small numbers, whose products `f32` holds exactly, and one whose products are rounded. All numbers are
/// multiples of four: quarters of edges are then whole numbers too.
pub(super) const GRIDS: [Grid; 2] = [
    Grid { planes: [[0, 4, 8]; 3], distance: 2 },
    Grid {
        planes: [[-7_654_324, 1_357_908, 8_111_116], [-3_999_996, 246_812, 4_765_432], [-5_432_108, -9_876, 6_420_244]],
        distance: 700_001,
    },
];

/// Where rays meet an edge, in quarters of its length.
const QUARTERS: [i64; 3] = [1, 2, 3];

impl Grid {
    fn point(&self, [x, y, z]: [usize; 3]) -> Int3 {
        [self.planes[0][x], self.planes[1][y], self.planes[2][z]]
    }

    pub(super) fn points(&self) -> Vec<Int3> {
        (0..27).map(|index| self.point([index % 3, index / 3 % 3, index / 9])).collect()
    }

    fn ray(&self, target: Int3, dir: Int3) -> Ray<f32> {
        let origin = plus(target, dir, -self.distance);
        assert!(is_aimed(origin, dir, target));
        Ray::new(exactly(origin), exactly(dir))
    }
}

/// All directions with whole coordinates from -3 to 3. Multiples of another one are left out.
pub(super) fn directions() -> Vec<Int3> {
    let all = (0..343).map(|index| [index % 7 - 3, index / 7 % 7 - 3, index / 49 - 3]);
    all.filter(|d| ![2, 3].iter().any(|factor| d.iter().all(|x| x % factor == 0))).collect()
}

pub(super) fn triangle(corners: [Int3; 3]) -> Triangle {
    let [v0, v1, v2] = corners.map(exactly);
    Triangle { v0, v1, v2 }
}

fn turned(mut corners: [Int3; 3], turn: usize) -> [Int3; 3] {
    corners.rotate_left(turn);
    corners
}

fn normal([a, b, c]: [Int3; 3]) -> Int3 {
    cross(minus(b, a), minus(c, a))
}

/// A set of rays, one bit each: 290 directions through a vertex, or through each of three points on an edge.
#[derive(Clone, Copy)]
struct Rays<const N: usize>([u64; N]);

type ThroughEdge = Rays<14>;
type ThroughVertex = Rays<5>;

impl<const N: usize> Rays<N> {
    const NONE: Self = Self([0; N]);

    fn of(rays: impl Iterator<Item = bool>) -> Self {
        let mut set = Self::NONE;
        for (index, is_in) in rays.enumerate() {
            set.0[index / 64] |= u64::from(is_in) << (index % 64);
        }
        set
    }

    /// The rays that meet the front of the triangle, and those that meet its back.
    fn facing(corners: [Int3; 3], dirs: impl Iterator<Item = Int3> + Clone) -> [Self; 2] {
        let normal = normal(corners);
        [Self::of(dirs.clone().map(|dir| dot(normal, dir) < 0)), Self::of(dirs.map(|dir| dot(normal, dir) > 0))]
    }

    fn hitting<K: Kernel<Shape = Triangle>>(corners: [Int3; 3], rays: &[Ray<f32x8>]) -> Self {
        let primitive = K::prepare(&triangle(corners));
        let mut set = Self::NONE;
        for (index, ray) in rays.iter().enumerate() {
            let mask = hit8(&primitive, ray).mask.bits();
            set.0[index / 8] |= u64::from(mask) << (8 * (index % 8));
        }
        set
    }

    fn len(self) -> u64 {
        self.0.iter().map(|word| u64::from(word.count_ones())).sum()
    }

    fn first(self) -> Option<usize> {
        let word = self.0.iter().position(|word| *word != 0)?;
        Some(64 * word + self.0[word].trailing_zeros() as usize)
    }

    fn contains(self, ray: usize) -> bool {
        self.0[ray / 64] >> (ray % 64) & 1 == 1
    }
}

impl<const N: usize> BitAnd for Rays<N> {
    type Output = Self;
    fn bitand(self, other: Self) -> Self {
        Self(std::array::from_fn(|index| self.0[index] & other.0[index]))
    }
}

impl<const N: usize> BitOr for Rays<N> {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        Self(std::array::from_fn(|index| self.0[index] | other.0[index]))
    }
}

impl<const N: usize> Not for Rays<N> {
    type Output = Self;
    fn not(self) -> Self {
        Self(self.0.map(|word| !word))
    }
}

/// Counts how many of `rays` hit no triangle and how many hit more than one.
fn judge<const N: usize>(
    counts: &mut Counts,
    watertight: Claim,
    [rays, none, many]: [Rays<N>; 3],
    example: impl Fn(usize) -> String,
) {
    for (claim, broken) in [(watertight, rays & none), (Claim::SingleHit, rays & (none | many))] {
        let first = || example(broken.first().expect("only called if a ray breaks the claim"));
        counts.add(claim, rays.len(), broken.len(), first);
    }
}

/// Counts how often a kernel breaks each claim, on edges and fans. Exhaustive: on all edges; otherwise on every sixth.
pub(super) fn count<K: Kernel<Shape = Triangle>>(grid: &Grid, options: &Options) -> Counts {
    edges::<K>(grid, if options.exhaustive { 1 } else { 6 }).plus(fans::<K>(grid))
}

/// The triangle of an edge whose third vertex is `point`.
struct Apex {
    point: Int3,
    /// Rays that meet its front and its back, with the edge running forwards.
    facing: [ThroughEdge; 2],
    /// Rays that hit: with the edge running forwards and backwards, for each rotation of the vertices.
    hitting: [[ThroughEdge; 3]; 2],
}

/// Every pair of triangles with a common edge, with every rotation of their vertices. Only every `step`th edge.
fn edges<K: Kernel<Shape = Triangle>>(grid: &Grid, step: usize) -> Counts {
    let (points, dirs) = (grid.points(), directions());
    let pairs: Vec<_> = (0..27).flat_map(|b| (0..b).map(move |a| (a, b))).step_by(step).collect();
    let on_edge = |&(a, b): &(usize, usize)| {
        let (a, b) = (points[a], points[b]);
        let shots = edge_rays(grid, a, b, &dirs);
        let packets: Vec<_> = shots.chunks(8).map(Ray::from_slice).collect();
        let targeted = || QUARTERS.iter().flat_map(|_| dirs.iter().copied());
        let apexes = points.iter().filter(|point| **point != a && **point != b).map(|&point| Apex {
            point,
            facing: ThroughEdge::facing([a, b, point], targeted()),
            hitting: [[a, b, point], [b, a, point]]
                .map(|corners| [0, 1, 2].map(|turn| ThroughEdge::hitting::<K>(turned(corners, turn), &packets))),
        });
        let apexes: Vec<_> = apexes.collect();
        let mut counts = Counts::default();
        for left in &apexes {
            for right in &apexes {
                // The edge runs backwards in the second triangle: its front is where the first one has its back.
                let rays = (left.facing[0] & right.facing[1]) | (left.facing[1] & right.facing[0]);
                if rays.len() == 0 {
                    continue;
                }
                for (turn, first) in left.hitting[0].into_iter().enumerate() {
                    for (other_turn, second) in right.hitting[1].into_iter().enumerate() {
                        let outcome = [rays, !(first | second), first & second];
                        judge(&mut counts, Claim::EdgeWatertight, outcome, |ray| {
                            let corners = [turned([a, b, left.point], turn), turned([b, a, right.point], other_turn)];
                            let [first, second] = [first, second].map(|hits| hits.contains(ray));
                            let [one, two] = corners.map(triangle);
                            describe(&shots[ray], &[(0, one, first), (1, two, second)])
                        });
                    }
                }
            }
        }
        counts
    };
    threads::sum(&pairs, on_edge)
}

fn edge_rays(grid: &Grid, a: Int3, b: Int3, dirs: &[Int3]) -> Vec<Ray<f32>> {
    let quarter = minus(b, a).map(|x| x / 4);
    QUARTERS.iter().flat_map(|&n| dirs.iter().map(move |&dir| grid.ray(plus(a, quarter, n), dir))).collect()
}

/// The points around the middle of the grid, counter-clockwise.
const RING: [[usize; 2]; 8] = [[0, 0], [1, 0], [2, 0], [2, 1], [2, 2], [1, 2], [0, 2], [0, 1]];

/// A triangle of a fan, between two points of the ring.
#[derive(Clone, Copy)]
struct Sector {
    corners: [Int3; 3],
    facing: [ThroughVertex; 2],
    hitting: ThroughVertex,
}

/// All fans around one vertex.
struct Fans<'a> {
    shots: &'a [Ray<f32>],
    /// By first point on the ring, number of steps to the second point minus one, and both heights.
    sectors: Vec<[[[Sector; 3]; 3]; 3]>,
}

/// The rays after the first triangles of a fan: which face all of them, hit at least one, hit at least two.
#[derive(Clone, Copy)]
struct Outcome {
    facing: [ThroughVertex; 2],
    once: ThroughVertex,
    twice: ThroughVertex,
}

impl Outcome {
    fn after(&self, sector: &Sector) -> Self {
        Self {
            facing: [self.facing[0] & sector.facing[0], self.facing[1] & sector.facing[1]],
            once: self.once | sector.hitting,
            twice: self.twice | (self.once & sector.hitting),
        }
    }
}

/// Every fan of three to eight triangles around a point in the middle of the grid.
fn fans<K: Kernel<Shape = Triangle>>(grid: &Grid) -> Counts {
    let dirs = directions();
    let around_hub = |&height: &usize| {
        let hub = grid.point([1, 1, height]);
        let shots: Vec<_> = dirs.iter().map(|&dir| grid.ray(hub, dir)).collect();
        let packets: Vec<_> = shots.chunks(8).map(Ray::from_slice).collect();
        let on_ring = |place: usize, height: usize| grid.point([RING[place % 8][0], RING[place % 8][1], height]);
        let sector = |from: usize, gap: usize, heights: [usize; 2]| {
            let corners = [hub, on_ring(from, heights[0]), on_ring(from + gap, heights[1])];
            let corners = turned(corners, (from + gap + heights[0] + heights[1]) % 3);
            Sector {
                corners,
                facing: ThroughVertex::facing(corners, dirs.iter().copied()),
                hitting: ThroughVertex::hitting::<K>(corners, &packets),
            }
        };
        let at = |from| [1, 2, 3].map(|gap| [0, 1, 2].map(|h| [0, 1, 2].map(|k| sector(from, gap, [h, k]))));
        let fans = Fans { shots: &shots, sectors: (0..8).map(at).collect() };
        let mut counts = Counts::default();
        // No step is longer than three, so every fan uses one of the first three points.
        for start in 0..3 {
            for height in 0..3 {
                let every = [!ThroughVertex::NONE; 2];
                let outcome = Outcome { facing: every, once: Rays::NONE, twice: Rays::NONE };
                fans.extend([start, height], [start, height], outcome, &mut Vec::new(), &mut counts);
            }
        }
        counts
    };
    threads::sum(&[0, 1, 2], around_hub)
}

impl Fans<'_> {
    /// Extends `fan`, which runs from `start` to `end` (point on the ring and height), in all ways that close it, and
    /// counts the closed fans.
    fn extend(&self, start: [usize; 2], end: [usize; 2], outcome: Outcome, fan: &mut Vec<Sector>, counts: &mut Counts) {
        for gap in 1..=3 {
            let place = end[0] + gap;
            for height in 0..3 {
                let closes = [place, height] == [start[0] + 8, start[1]];
                if place >= 8 && !closes {
                    continue;
                }
                let sector = self.sectors[end[0]][gap - 1][end[1]][height];
                let outcome = outcome.after(&sector);
                fan.push(sector);
                if closes {
                    let rays = outcome.facing[0] | outcome.facing[1];
                    judge(counts, Claim::VertexWatertight, [rays, !outcome.once, outcome.twice], |ray| {
                        let triangles = (0..).zip(fan.iter());
                        let triangles = triangles
                            .map(|(index, sector)| (index, triangle(sector.corners), sector.hitting.contains(ray)));
                        describe(&self.shots[ray], &triangles.collect::<Vec<_>>())
                    });
                } else if outcome.facing.iter().any(|rays| rays.len() > 0) {
                    self.extend(start, [place, height], outcome, fan, counts);
                }
                fan.pop();
            }
        }
    }
}

#[cfg(all(test, feature = "study"))]
mod tests {
    use super::*;
    use crate::oracle::Exact;

    /// Asks the oracle about the rays: each hits every triangle that it is not parallel to, on its boundary.
    #[test]
    fn rays_meet_their_targets_exactly() {
        let dirs = directions();
        for grid in &GRIDS {
            let points = grid.points();
            let hits = (0..27usize).map(|a| {
                let mut hits = 0;
                for b in (0..27).filter(|b| *b != a) {
                    let (a, b, c) = (points[a], points[b], points[(5 * a + 7 * b + 3) % 27]);
                    let normal = normal([a, b, c]);
                    let through_vertex = dirs.iter().map(|&dir| grid.ray(a, dir));
                    let rays = edge_rays(grid, a, b, &dirs).into_iter().chain(through_vertex);
                    for (ray, &dir) in rays.zip(dirs.iter().cycle()) {
                        let truth = triangle([a, b, c]).truth(&ray);
                        assert_eq!(
                            (truth.hit, truth.boundary),
                            (dot(normal, dir) != 0, truth.hit),
                            "{ray:?} {a:?} {b:?} {c:?}"
                        );
                        hits += u32::from(truth.hit);
                    }
                }
                hits
            });
            assert!(hits.sum::<u32>() > 500_000);
        }
    }
}
