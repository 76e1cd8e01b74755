//! Tests of the oracle: its fast filter against its exact arithmetic, and both against independent methods.
//!
//! The independent methods share no code with the oracle: an adaptive predicate, rational numbers of machine size, and
//! answers known by construction.

use core::cmp::Ordering;

use glam::{Affine3, Mat3, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use raylanes::geom::{Aabb, Placed, Quadric, Ray, Triangle};
use raylanes::oracle::{Exact, Truth};
use raylanes::study::workload::{in_cube, whole};
use robust::{Coord3D, orient3d};

const CASES: u32 = 200_000;
const INF: f32 = f32::INFINITY;

// ---------------------------------------------------------------------------------------------------------------------
// Inputs
// ---------------------------------------------------------------------------------------------------------------------

struct Inputs(Pcg64Mcg);

impl Inputs {
    fn new(seed: u64) -> Self {
        Self(Pcg64Mcg::seed_from_u64(seed))
    }

    /// A whole number in `range`.
    fn int(&mut self, range: core::ops::RangeInclusive<i32>) -> i32 {
        self.0.random_range(range)
    }

    fn pick<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.0.random_range(0..choices.len())]
    }

    /// A point with whole coordinates from `-reach` to `reach`. Such points are often equal, on a line or in a plane.
    fn grid(&mut self, reach: i32) -> Vec3 {
        Vec3::from_array([(); 3].map(|()| whole(&mut self.0, reach)))
    }

    /// A point with coordinates from -1 to 1 that use all 24 bits.
    fn float(&mut self) -> Vec3 {
        in_cube(&mut self.0, 1.0)
    }

    /// A small number that moves an exact target to a generic one.
    fn jitter(&mut self) -> f32 {
        self.0.random_range(-0.125..0.125)
    }

    fn power_of_two(&mut self, range: core::ops::RangeInclusive<i32>) -> f32 {
        2f32.powi(self.int(range))
    }

    /// A point of this kind.
    fn point(&mut self, kind: Kind) -> Vec3 {
        match kind {
            Kind::Grid => self.grid(4),
            Kind::Float => self.float(),
            Kind::Mixed => {
                let point = self.float();
                point * Vec3::from_array([(); 3].map(|()| self.power_of_two(-30..=30)))
            }
            Kind::Extreme => {
                let point = if self.int(0..=1) == 0 { self.float() } else { self.grid(4) };
                point * self.pick(&[1e-45, 1e-38, 1e-20, 1.0, 1e20, 8e37])
            }
        }
    }

    /// A ray towards `target`, its direction rounded to `f32`, with an interval.
    fn ray(&mut self, kind: Kind, target: Vec3) -> Ray<f32> {
        let origin = self.point(kind);
        let dir = (target - origin) * self.power_of_two(-3..=3);
        let (t_min, t_max) = self.pick(&[
            (0.0, INF),
            (0.0, INF),
            (0.0, INF),
            (-INF, INF),
            (-0.0, 1.0),
            (1.0, 1.0),
            (0.5, 2.0),
            (2.0, INF),
            (-INF, 0.25),
            (INF, INF),
            (1.0, 0.5),
        ]);
        Ray { origin, dir, t_min, t_max }
    }

    /// A triangle, and a ray at its inside, an edge or a vertex, or past it.
    fn triangle(&mut self, kind: Kind) -> (Triangle, Ray<f32>) {
        let [v0, v1, v2] = [(); 3].map(|()| self.point(kind));
        let triangle = Triangle { v0, v1, v2 };
        let (u, v) = self.pick(&[
            (0.25, 0.25),
            (0.125, 0.5),
            (0.5, 0.25),
            (0.0, 0.5),
            (0.25, 0.0),
            (0.5, 0.5),
            (0.0, 0.0),
            (1.0, 0.0),
            (1.25, 0.5),
            (-0.5, 0.25),
        ]);
        let target = if kind == Kind::Float {
            triangle.point(u + self.jitter(), v + self.jitter())
        } else {
            triangle.point(u, v)
        };
        (triangle, self.ray(kind, target))
    }

    /// A box, and a ray at its inside, a face, an edge or a corner, or past it. The ray may be parallel to an axis.
    fn aabb(&mut self, kind: Kind) -> (Aabb, Ray<f32>) {
        let (a, b) = (self.point(kind), self.point(kind));
        let mut shape = Aabb { lo: a.min(b), hi: a.max(b) };
        let mut weights = Vec3::from_array([(); 3].map(|()| self.pick(&[0.0, 0.25, 0.5, 0.75, 1.0, 1.25])));
        if kind == Kind::Float {
            weights += Vec3::from_array([(); 3].map(|()| self.jitter()));
        }
        let target = shape.lo + shape.extent() * weights;
        let mut ray = self.ray(kind, target);
        let axis = self.int(0..=2) as usize;
        match self.int(0..=19) {
            0..=2 => {
                ray.dir[axis] = self.pick(&[0.0, -0.0]);
                ray.origin[axis] = self.pick(&[target[axis], ray.origin[axis]]);
            }
            3 => shape.hi[axis] = shape.lo[axis],
            4 => shape.lo[axis] = -INF,
            5 => shape.hi[axis] = INF,
            6 => (shape.lo[axis], shape.hi[axis]) = (shape.hi[axis], shape.lo[axis]),
            _ => {}
        }
        (shape, ray)
    }

    /// A quadric through a point of its box, or past it, and a ray at that point. The point may be on a plane of the
    /// box. The ray may be tangent, run along the box, or have any direction.
    fn quadric(&mut self, kind: Kind) -> (Quadric, Ray<f32>) {
        let target = self.point(kind);
        let mut quadric = Quadric {
            squares: self.point(kind),
            products: if self.int(0..=1) == 0 { Vec3::ZERO } else { self.point(kind) },
            linear: if self.int(0..=1) == 0 { Vec3::ZERO } else { self.point(kind) },
            constant: 0.0,
            clip: Aabb { lo: target, hi: target },
        };
        quadric.constant = -quadric.value(target);
        match self.int(0..=9) {
            0 => quadric.constant += self.point(kind).x,
            1 => quadric.squares[self.int(0..=2) as usize] = 0.0,
            2 => quadric.squares = Vec3::ZERO,
            _ => {}
        }
        let sides = if kind == Kind::Float { [1.0, 0.5, 0.25, 0.25] } else { [0.0, 1.0, 2.0, 4.0] };
        for axis in 0..3 {
            quadric.clip.lo[axis] -= self.pick(&sides) + if kind == Kind::Float { self.jitter() } else { 0.0 };
            quadric.clip.hi[axis] += self.pick(&sides) + if kind == Kind::Float { self.jitter() } else { 0.0 };
        }
        let mut ray = self.ray(kind, target);
        let axis = self.int(0..=2) as usize;
        match self.int(0..=19) {
            0..=3 => {
                let Vec3 { x, y, z } = target;
                let Vec3 { x: yz, y: zx, z: xy } = quadric.products;
                let mixed = Vec3::new(xy * y + zx * z, xy * x + yz * z, zx * x + yz * y);
                let gradient = quadric.squares * target * 2.0 + mixed + quadric.linear;
                ray.dir = gradient.cross(self.point(kind));
                ray.origin = target - ray.dir * self.pick(&[1.0, 2.0, 0.5]);
            }
            4..=6 => {
                ray.dir[axis] = self.pick(&[0.0, -0.0]);
                ray.origin[axis] = self.pick(&[target[axis], ray.origin[axis], quadric.clip.lo[axis]]);
            }
            7 => quadric.clip.lo[axis] = -INF,
            8 => quadric.clip.hi[axis] = INF,
            9 => (quadric.clip.lo[axis], quadric.clip.hi[axis]) = (quadric.clip.hi[axis], quadric.clip.lo[axis]),
            10..=12 => quadric.clip = Aabb { lo: Vec3::NEG_INFINITY, hi: Vec3::INFINITY },
            _ => {}
        }
        (quadric, ray)
    }

    /// An affine transform; some are mirrors, some are singular.
    fn transform(&mut self, kind: Kind) -> Affine3 {
        let columns = [(); 3].map(|()| self.point(kind));
        Affine3::from_mat3_translation(Mat3::from_cols(columns[0], columns[1], columns[2]), self.point(kind))
    }

    /// A transform under which small whole numbers stay exact in `f32`: rotations, mirrors, powers of two, and shears
    /// and translations by whole numbers.
    fn exact_transform(&mut self) -> Affine3 {
        let mut axes = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| axis * self.pick(&[0.25, 0.5, 1.0, 2.0, -1.0, -4.0]));
        axes.rotate_left(self.int(0..=2) as usize);
        let shear = self.int(-3..=3) as f32;
        axes[1] += axes[0] * shear;
        Affine3::from_mat3_translation(Mat3::from_cols(axes[0], axes[1], axes[2]), self.grid(16))
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// Small whole numbers.
    Grid,
    /// One magnitude, all 24 bits in use.
    Float,
    /// Each coordinate of its own magnitude.
    Mixed,
    /// From subnormal numbers to nearly the greatest number.
    Extreme,
}

const KINDS: [Kind; 4] = [Kind::Grid, Kind::Float, Kind::Mixed, Kind::Extreme];

/// The bits of an answer.
fn bits(truth: &Truth) -> (bool, bool, [u32; 3]) {
    (truth.hit, truth.boundary, [truth.t, truth.u, truth.v].map(f32::to_bits))
}

#[track_caller]
fn assert_same(left: Truth, right: Truth, case: &dyn core::fmt::Debug) {
    assert_eq!(bits(&left), bits(&right), "{left:?} differs from {right:?}: {case:?}");
}

#[track_caller]
fn assert_hit(truth: Truth, t: f32, boundary: bool) {
    assert_eq!((truth.hit, truth.boundary, truth.t), (true, boundary, t), "{truth:?}");
}

/// Counts cases by their outcome. No test may pass on misses alone.
#[derive(Debug, Default)]
struct Count {
    cases: u32,
    sure: u32,
    hits: u32,
    boundaries: u32,
}

impl Count {
    fn add(&mut self, truth: &Truth, sure: bool) {
        self.cases += 1;
        self.sure += u32::from(sure);
        self.hits += u32::from(truth.hit);
        self.boundaries += u32::from(truth.boundary);
    }

    #[track_caller]
    fn assert_shares(&self, what: &dyn core::fmt::Debug, sure: f32, hits: f32, boundaries: f32) {
        let share = |count: u32| count as f32 / self.cases as f32;
        let enough = share(self.sure) >= sure && share(self.hits) >= hits && share(self.boundaries) >= boundaries;
        assert!(enough && share(self.hits) < 0.95, "{what:?}: {self:?}");
    }
}

// ---------------------------------------------------------------------------------------------------------------------
// Filter against exact arithmetic
// ---------------------------------------------------------------------------------------------------------------------

/// Compares filter and exact arithmetic for every kind of input.
fn filter_agrees<S: Exact>(seed: u64, case: fn(&mut Inputs, Kind) -> (S, Ray<f32>)) {
    for kind in KINDS {
        let (mut inputs, mut count) = (Inputs::new(seed), Count::default());
        for _ in 0..CASES / 4 {
            let (shape, ray) = case(&mut inputs, kind);
            let exact = shape.truth_exact(&ray);
            let filtered = shape.truth_filtered(&ray);
            if let Some(filtered) = filtered {
                assert_same(filtered, exact, &(kind, shape, ray));
            }
            assert_same(shape.truth(&ray), exact, &(kind, shape, ray));
            assert!(exact.hit || bits(&exact) == bits(&Truth::MISS), "a miss has one content: {exact:?}");
            count.add(&exact, filtered.is_some());
        }
        match kind {
            Kind::Grid => count.assert_shares(&kind, 0.0, 0.2, 0.1),
            Kind::Float => count.assert_shares(&kind, 0.9, 0.2, 0.0),
            Kind::Mixed => count.assert_shares(&kind, 0.4, 0.05, 0.0),
            Kind::Extreme => count.assert_shares(&kind, 0.1, 0.02, 0.0),
        }
    }
}

#[test]
fn filter_agrees_on_triangles() {
    filter_agrees(1, Inputs::triangle);
}

#[test]
fn filter_agrees_on_boxes() {
    filter_agrees(2, Inputs::aabb);
}

#[test]
fn filter_agrees_on_placed_triangles() {
    filter_agrees(3, |inputs, kind| {
        let (shape, ray) = inputs.triangle(kind);
        placed(shape, inputs.transform(kind), ray)
    });
}

#[test]
fn filter_agrees_on_placed_boxes() {
    filter_agrees(4, |inputs, kind| {
        let (shape, ray) = inputs.aabb(kind);
        placed(shape, inputs.transform(kind), ray)
    });
}

#[test]
fn filter_agrees_on_quadrics() {
    filter_agrees(5, Inputs::quadric);
}

#[test]
fn filter_agrees_on_placed_quadrics() {
    filter_agrees(6, |inputs, kind| {
        let (shape, ray) = inputs.quadric(kind);
        placed(shape, inputs.transform(kind), ray)
    });
}

/// Transforms shape and ray to the world. The ray still meets its target, up to rounding.
fn placed<S>(shape: S, object_to_world: Affine3, ray: Ray<f32>) -> (Placed<S>, Ray<f32>) {
    let Ray { origin, dir, t_min, t_max } = ray;
    let origin = object_to_world.transform_point3(origin);
    let dir = object_to_world.transform_vector3(dir);
    (Placed { shape, object_to_world }, Ray { origin, dir, t_min, t_max })
}

// ---------------------------------------------------------------------------------------------------------------------
// Triangles against an adaptive predicate
// ---------------------------------------------------------------------------------------------------------------------

/// The sign of the volume that four points span.
fn side(points: [Vec3; 4]) -> i32 {
    let [a, b, c, d] = points.map(|p| Coord3D { x: f64::from(p.x), y: f64::from(p.y), z: f64::from(p.z) });
    let volume = orient3d(a, b, c, d);
    i32::from(volume > 0.0) - i32::from(volume < 0.0)
}

/// Whether the segment from `o` to `p` hits, and whether on a boundary: by signs of volumes alone.
fn segment_hits(Triangle { v0, v1, v2 }: Triangle, o: Vec3, p: Vec3) -> (bool, bool) {
    let edges = [(v0, v1), (v1, v2), (v2, v0)].map(|(a, b)| side([o, p, a, b]));
    let (starts, ends) = (side([v0, v1, v2, o]), side([v0, v1, v2, p]));
    let inside = !(edges.contains(&1) && edges.contains(&-1)) && edges != [0; 3];
    let hit = inside && starts * ends <= 0;
    (hit, hit && (edges.contains(&0) || starts * ends == 0))
}

#[test]
fn triangles_agree_with_an_independent_predicate() {
    for (seed, reach) in [(10, 3), (11, 40), (12, 1 << 20)] {
        let (mut inputs, mut count) = (Inputs::new(seed), Count::default());
        for _ in 0..CASES / 3 + 1 {
            // Even coordinates: midpoints of edges are then exact too.
            let [v0, v1, v2, mut p, mut o] = [(); 5].map(|()| inputs.grid(reach) * 2.0);
            let triangle = Triangle { v0, v1, v2 };
            if inputs.int(0..=3) > 0 {
                p = inputs.pick(&[v0, v1, (v0 + v1) / 2.0, (v1 + v2) / 2.0, (v0 + v1) / 4.0 + v2 / 2.0]).round();
                if inputs.int(0..=2) > 0 {
                    // The segment passes through the target and ends on the other side.
                    o = p + ((o - p) / 4.0).round();
                    p -= o - p;
                }
            }
            let scale = inputs.power_of_two(-40..=40);
            let triangle = Triangle { v0: triangle.v0 * scale, v1: triangle.v1 * scale, v2: triangle.v2 * scale };
            let (o, p) = (o * scale, p * scale);
            let ray = Ray { origin: o, dir: p - o, t_min: 0.0, t_max: 1.0 };
            assert_eq!(o + ray.dir, p, "the test needs an exact direction");

            let truth = triangle.truth_exact(&ray);
            assert_eq!((truth.hit, truth.boundary), segment_hits(triangle, o, p), "{triangle:?} {ray:?}");
            assert_same(triangle.truth(&ray), truth, &(triangle, ray));
            count.add(&truth, true);
        }
        count.assert_shares(&reach, 1.0, 0.2, 0.1);
    }
}

// ---------------------------------------------------------------------------------------------------------------------
// Boxes against a search in rational numbers
// ---------------------------------------------------------------------------------------------------------------------

/// `num / den`, `den > 0`.
#[derive(Clone, Copy, Debug)]
struct Ratio {
    num: i128,
    den: i128,
}

impl Ratio {
    fn new(num: i128, den: i128) -> Self {
        Self { num: num * den.signum(), den: den.abs() }
    }

    /// A number with at most eight binary places.
    fn of(value: f32) -> Self {
        assert_eq!(value * 256.0, (value * 256.0).round());
        Self { num: (value * 256.0) as i128, den: 256 }
    }

    fn below(self, other: Self) -> bool {
        self.num * other.den < other.num * self.den
    }

    fn mean(self, other: Self) -> Self {
        Self::new(self.num * other.den + other.num * self.den, 2 * self.den * other.den)
    }
}

/// Whether the point at `t` is in the box, and whether it is strictly inside.
fn contains(shape: &Aabb, ray: &Ray<f32>, t: Ratio) -> (bool, bool) {
    let (mut closed, mut open) = (true, true);
    for axis in 0..3 {
        let [o, d] = [ray.origin[axis], ray.dir[axis]].map(|x| Ratio::of(x).num);
        let point = Ratio::new(o * t.den + d * t.num, 256 * t.den);
        for (plane, sign) in [(shape.lo[axis], 1), (shape.hi[axis], -1)] {
            if plane.is_finite() {
                let plane = Ratio::of(plane);
                closed &= !Ratio::new(sign * point.num, point.den).below(Ratio::new(sign * plane.num, plane.den));
                open &= Ratio::new(sign * plane.num, plane.den).below(Ratio::new(sign * point.num, point.den));
            } else {
                let everything_is_inside = plane == -INF * sign as f32;
                closed &= everything_is_inside;
                open &= everything_is_inside;
            }
        }
    }
    (closed, open)
}

/// The answer found by trying every `t` at which the ray could enter or leave. Coordinates must have few binary places.
fn search(shape: &Aabb, ray: &Ray<f32>) -> Truth {
    let mut candidates = vec![Ratio::of(0.0)];
    candidates.extend([ray.t_min, ray.t_max].iter().filter(|t| t.is_finite()).map(|t| Ratio::of(*t)));
    for axis in 0..3 {
        for plane in [shape.lo[axis], shape.hi[axis]] {
            if plane.is_finite() && ray.dir[axis] != 0.0 {
                let (plane, o, d) = (Ratio::of(plane), Ratio::of(ray.origin[axis]), Ratio::of(ray.dir[axis]));
                candidates.push(Ratio::new(plane.num - o.num, d.num));
            }
        }
    }
    // Beyond all others on both sides: they remain only where the ray never enters or never leaves.
    let farthest = 1 << 40;
    candidates.extend([-farthest, farthest].map(|t| Ratio::new(t, 1)));

    let after_start = |t: Ratio| ray.t_min == -INF || (ray.t_min != INF && !t.below(Ratio::of(ray.t_min)));
    let before_end = |t: Ratio| ray.t_max == INF || (ray.t_max != -INF && !Ratio::of(ray.t_max).below(t));
    candidates.retain(|t| after_start(*t) && before_end(*t) && contains(shape, ray, *t).0);
    let by_order = |a: &Ratio, b: &Ratio| (a.num * b.den).cmp(&(b.num * a.den));
    let (Some(entry), Some(exit)) =
        (candidates.iter().copied().min_by(by_order), candidates.iter().copied().max_by(by_order))
    else {
        return Truth::MISS;
    };
    let strictly_inside = contains(shape, ray, entry.mean(exit)).1;
    let rounded = |t: Ratio| match t.num / t.den {
        t if t == farthest => INF,
        t if t == -farthest => -INF,
        // At most 53 bits on either side, and too few for a tie: rounding through f64 gives the same f32.
        _ => (t.num as f64 / t.den as f64) as f32,
    };
    Truth { hit: true, boundary: !strictly_inside, t: rounded(entry), u: rounded(exit), v: 0.0 }
}

#[test]
fn boxes_agree_with_a_search() {
    let (mut inputs, mut count) = (Inputs::new(20), Count::default());
    for _ in 0..CASES {
        let (shape, ray) = inputs.aabb(Kind::Grid);
        let truth = shape.truth_exact(&ray);
        let expected = if ray.is_valid() { search(&shape, &ray) } else { Truth::MISS };
        // Compared by value: a bound of -0 equals an entry at 0.
        assert_eq!(truth, expected, "{shape:?} {ray:?}");
        assert_same(shape.truth(&ray), truth, &(shape, ray));
        count.add(&truth, true);
    }
    count.assert_shares(&"boxes", 1.0, 0.3, 0.1);
}

// ---------------------------------------------------------------------------------------------------------------------
// Quadrics against square roots compared by squaring
// ---------------------------------------------------------------------------------------------------------------------

/// `a·t² + b·t + c` in whole numbers, and its discriminant.
#[derive(Clone, Copy, Debug)]
struct Whole {
    a: i128,
    b: i128,
    c: i128,
    discriminant: i128,
}

impl Whole {
    /// Scaled to whole numbers. Coordinates must have few binary places.
    fn of(quadric: &Quadric, ray: &Ray<f32>) -> Self {
        let units = |v: Vec3| v.to_array().map(|x| Ratio::of(x).num);
        let [s, p, l] = [quadric.squares, quadric.products, quadric.linear].map(units);
        let k = Ratio::of(quadric.constant).num;
        let (o, d) = (units(ray.origin), units(ray.dir));
        let (mut a, mut b, mut c) = (0, 0, k * 256 * 256);
        for i in 0..3 {
            let (j, m) = ((i + 1) % 3, (i + 2) % 3);
            a += s[i] * d[i] * d[i] + p[i] * d[j] * d[m];
            b += 2 * s[i] * o[i] * d[i] + p[i] * (o[j] * d[m] + o[m] * d[j]) + 256 * l[i] * d[i];
            c += s[i] * o[i] * o[i] + p[i] * o[j] * o[m] + 256 * l[i] * o[i];
        }
        // Divided by their common power of two: then their squares fit.
        let [a, b, c] = [a, b, c].map(|coefficient| coefficient >> (a | b | c | 1 << 60).trailing_zeros());
        Self { a, b, c, discriminant: b * b - 4 * a * c }
    }

    /// Compares the root `(-b + sign·√discriminant) / 2a`, or `-c / b` of a linear equation, with `t`.
    fn compare(&self, sign: i128, t: Ratio) -> Ordering {
        let Self { a, b, c, discriminant } = *self;
        if a == 0 {
            return (-c * t.den * b.signum()).cmp(&(t.num * b.abs()));
        }
        // The sign of x + y·√discriminant.
        let (x, y) = (a.signum() * (-b * t.den - 2 * a * t.num), a.signum() * sign * t.den);
        let squares = (x * x).cmp(&(y * y * discriminant));
        match (x.signum(), y.signum() * discriminant.signum()) {
            (1, -1) => squares,
            (-1, 1) => squares.reverse(),
            (x, y) => (x + y).cmp(&0),
        }
    }
}

/// The equation of the ray, the sign of the square root in the nearest root within box and interval, and whether that
/// root is on a boundary. `None` for a miss.
fn nearest_root(quadric: &Quadric, ray: &Ray<f32>) -> Option<(Whole, i128, bool)> {
    let Aabb { lo, hi } = quadric.clip;
    let whole = Whole::of(quadric, ray);
    let empty = !(lo.cmple(hi).all() && ray.is_valid() && ray.t_min <= ray.t_max);
    if empty || whole.discriminant < 0 || (whole.a == 0 && whole.b == 0) {
        return None;
    }
    let signs = if whole.a == 0 { vec![0] } else { vec![-whole.a.signum(), whole.a.signum()] };
    'roots: for sign in signs {
        let mut boundary = whole.a != 0 && whole.discriminant == 0;
        let mut orders = Vec::new();
        for (end, sign_of_side) in [(ray.t_min, 1), (ray.t_max, -1)] {
            orders.push((
                sign_of_side,
                if end.is_finite() { whole.compare(sign, Ratio::of(end)) } else { 0.0.partial_cmp(&end).unwrap() },
            ));
        }
        for axis in 0..3 {
            let [o, d] = [ray.origin[axis], ray.dir[axis]].map(|x| Ratio::of(x).num);
            for (plane, side) in [(lo[axis], 1), (hi[axis], -1)].into_iter().filter(|(plane, _)| plane.is_finite()) {
                let plane = Ratio::of(plane).num;
                orders.push(if d == 0 {
                    (side, o.cmp(&plane))
                } else {
                    (side * d.signum() as i32, whole.compare(sign, Ratio::new(plane - o, d)))
                });
            }
        }
        for (side, order) in orders {
            match order as i32 * side {
                -1 => continue 'roots,
                touching => boundary |= touching == 0,
            }
        }
        return Some((whole, sign, boundary));
    }
    None
}

#[test]
fn quadrics_agree_with_roots_compared_by_squaring() {
    let (mut inputs, mut count) = (Inputs::new(25), Count::default());
    let (mut rational, mut irrational, mut tangent, mut linear) = (0, 0, 0, 0);
    for _ in 0..CASES {
        let (mut quadric, mut ray) = inputs.quadric(Kind::Grid);
        if inputs.int(0..=3) == 0 {
            // Right triangles in whole numbers: a ray along z meets a sphere at a rational height.
            let (short, other, long) = inputs.pick(&[(3, 4, 5), (5, 12, 13), (8, 15, 17), (7, 24, 25), (20, 21, 29)]);
            let high = inputs.pick(&[other, other / 2, 0]) as f32;
            let clip = Aabb { lo: Vec3::splat(-64.0), hi: Vec3::splat(64.0) };
            quadric = Quadric { clip, ..Quadric::sphere(long as f32) };
            quadric.clip.hi.z = inputs.pick(&[other as f32, -1.0, long as f32, INF]);
            ray.origin = xyz(short as f32, 0.0, high - 2.0 * long as f32);
            ray.dir = xyz(0.0, 0.0, inputs.pick(&[1.0, 3.0, 0.5, -7.0, -0.0]));
        }
        let expected = nearest_root(&quadric, &ray);
        let truth = quadric.truth_exact(&ray);
        assert_same(quadric.truth(&ray), truth, &(quadric, ray));
        let decision = expected.map(|(.., boundary)| boundary);
        assert_eq!(truth.hit.then_some(truth.boundary), decision, "{quadric:?} {ray:?}: {expected:?}");
        count.add(&truth, true);
        let Some((whole, sign, _)) = expected else { continue };
        let Whole { a, b, c, discriminant } = whole;
        let root = discriminant.isqrt();
        if a == 0 || root * root == discriminant {
            let (num, den) = if a == 0 { (-c, b) } else { (-b + sign * root, 2 * a) };
            let expected = if num == 0 { 0.0 } else { nearest(num * den.signum(), den.abs(), 0) };
            assert_eq!(truth.t, expected, "{quadric:?} {ray:?}: {num} / {den}");
            linear += u32::from(a == 0);
            rational += u32::from(a != 0 && root > 0);
            tangent += u32::from(a != 0 && root == 0);
        } else {
            // Strictly between the midpoints to both neighbours: the root is irrational, the midpoints are rational.
            let midpoint = |other: f32| {
                let (mean, places) = ((f64::from(truth.t) + f64::from(other)) / 2.0, 60);
                let num = (mean * 2f64.powi(places)) as i128;
                assert_eq!(num as f64, mean * 2f64.powi(places), "{quadric:?} {ray:?}: t is too small for this test");
                let shift = num.trailing_zeros().min(places as u32);
                Ratio::new(num >> shift, 1 << (places as u32 - shift))
            };
            let (below, above) = (midpoint(truth.t.next_down()), midpoint(truth.t.next_up()));
            assert_eq!(whole.compare(sign, below), Ordering::Greater, "{quadric:?} {ray:?}: {}", truth.t);
            assert_eq!(whole.compare(sign, above), Ordering::Less, "{quadric:?} {ray:?}: {}", truth.t);
            irrational += 1;
        }
    }
    count.assert_shares(&"quadrics", 1.0, 0.3, 0.1);
    let least = rational.min(irrational).min(tangent).min(linear);
    assert!(least > 1000, "{rational} {irrational} {tangent} {linear}");
}

// ---------------------------------------------------------------------------------------------------------------------
// Rounding
// ---------------------------------------------------------------------------------------------------------------------

/// `num / den · 2^exponent`, rounded to the nearest `f32`, ties to even: a whole number of the spacing of `f32` there.
fn nearest(num: i128, den: i128, exponent: i32) -> f32 {
    let magnitude = num.unsigned_abs().ilog2() as i32 - den.ilog2() as i32 + exponent;
    // The quotient may be one power of two lower than the bits of its parts suggest. Then the first spacing is too
    // coarse.
    for candidate in [magnitude, magnitude - 1] {
        let spacing = (candidate - 23).max(-149);
        let (size, den) = match exponent - spacing {
            shift @ 0.. => (num.abs() << shift, den),
            shift => (num.abs(), den.checked_shl(shift.unsigned_abs().min(127)).expect("few bits")),
        };
        let (whole, rest) = (size / den, size % den);
        let up = 2 * rest > den || (2 * rest == den && whole % 2 == 1);
        let steps = whole + i128::from(up);
        if whole >= 1 << 23 || spacing == -149 || candidate < magnitude {
            let rounded = (steps as f64 * 2f64.powi(spacing)) as f32;
            return if num.signum() < 0 { -rounded } else { rounded };
        }
    }
    unreachable!("the second candidate always returns")
}

#[test]
fn the_reference_rounding_is_correct() {
    for (num, den, exponent, expected) in [
        (1, 3, 0, 1.0 / 3.0),
        (-1, 3, 0, -1.0 / 3.0),
        ((1 << 24) + 1, 1, 0, 16_777_216.0),
        ((1 << 24) + 3, 1, 0, 16_777_220.0),
        (1, 1, -149, f32::from_bits(1)),
        (1, 2, -149, 0.0),
        (3, 2, -149, f32::from_bits(2)),
        (5, 3, -150, f32::from_bits(1)),
        ((1 << 25) - 1, 1, 103, INF),
        ((1 << 24) - 1, 1, 104, f32::MAX),
    ] {
        assert_eq!(nearest(num, den, exponent), expected, "{num} / {den} · 2^{exponent}");
        let quotient = (num as f64 / den as f64 * 2f64.powi(exponent)) as f32;
        assert_eq!(quotient, expected, "{num} / {den} · 2^{exponent}");
    }
}

/// The oracle's `t` where exactly `t = (near + back) / speed`, in four ways. A ray along z meets a triangle in the
/// plane z = `near`, and enters (or for a negative speed leaves) a box that begins there; both once plain and once
/// placed.
fn head_on(near: f32, back: f32, speed: f32) -> [f32; 4] {
    let ray = Ray { origin: xyz(0.25, 0.25, -back), dir: xyz(0.0, 0.0, speed), t_min: -INF, t_max: INF };
    let triangle = Triangle { v0: xyz(0.0, 0.0, near), v1: xyz(1.0, 0.0, near), v2: xyz(0.0, 1.0, near) };
    let half_column = Aabb { lo: xyz(0.0, 0.0, near), hi: xyz(1.0, 1.0, INF) };
    let object_to_world = Affine3::IDENTITY;
    let on_triangle = [triangle.truth_exact(&ray), Placed { shape: triangle, object_to_world }.truth_exact(&ray)];
    let in_box = [half_column.truth_exact(&ray), Placed { shape: half_column, object_to_world }.truth_exact(&ray)];
    assert!(on_triangle.iter().chain(&in_box).all(|truth| truth.hit));
    let [first, second] = on_triangle.map(|truth| truth.t);
    let [third, fourth] = in_box.map(|truth| if speed > 0.0 { truth.t } else { truth.u });
    [first, second, third, fourth]
}

#[test]
fn t_is_correctly_rounded() {
    let mut inputs = Inputs::new(30);
    let (mut subnormal, mut infinite, mut zero, mut ties) = (0, 0, 0, 0);
    for _ in 0..CASES / 4 {
        // A numerator of up to 48 bits: the sum of two f32.
        let (high, low) = (inputs.int(0..=0xff_ffff), inputs.int(1..=0xff_ffff));
        let (high, low, split) = match inputs.int(0..=2) {
            0 => (high, low, 24),
            // Few bits more than 24: ties.
            1 => (high, low % 3 + 1, 2),
            _ => (0, low, 0),
        };
        let divisor = match inputs.int(0..=1) {
            0 => 1 << inputs.int(0..=20),
            _ => inputs.int(1..=0xff_ffff),
        };
        let (up, down) = match inputs.int(0..=2) {
            0 => (0, 0),
            1 => (inputs.int(-100..=-60), inputs.int(50..=80)),
            _ => (inputs.int(50..=75), inputs.int(-100..=-20)),
        };
        let (near, back) = (high as f32 * 2f32.powi(up + split), low as f32 * 2f32.powi(up));
        let speed = divisor as f32 * 2f32.powi(down) * inputs.pick(&[1.0, -1.0]);
        let num = (i128::from(high) << split) + i128::from(low);
        let expected = nearest(num, divisor.into(), up - down).copysign(speed);
        for t in head_on(near, back, speed) {
            assert_eq!(
                t.to_bits(),
                expected.to_bits(),
                "{t:?} instead of {expected:?} = ({near:?} + {back:?}) / {speed:?}"
            );
        }
        subnormal += u32::from(expected.is_subnormal());
        infinite += u32::from(expected.is_infinite());
        zero += u32::from(expected == 0.0);
        ties += u32::from(divisor & (divisor - 1) == 0 && num % 4 != 0 && num.ilog2() == 24);
    }
    assert!(subnormal > 500 && infinite > 500 && zero > 100 && ties > 100, "{subnormal} {infinite} {zero} {ties}");
}

/// Roots with `t² = m² + sign·tiny²`, where `m` is halfway between two neighbours in `f32`.
#[test]
fn roots_next_to_a_tie_are_correctly_rounded() {
    let mut inputs = Inputs::new(32);
    let clip = Aabb { lo: Vec3::NEG_INFINITY, hi: Vec3::INFINITY };
    for _ in 0..CASES / 40 {
        let (below, half) = (inputs.int(0x80_0000..=0xff_fffe) as f32, 0.5);
        let even = if below % 2.0 == 0.0 { below } else { below.next_up() };
        for (sign, expected) in [(-1.0, below), (0.0, even), (1.0, below.next_up())] {
            let tiny = inputs.power_of_two(-100..=-40);
            // x² - ((below + half)² + sign·tiny²), where y is `below` and z is `tiny`.
            let quadric = Quadric {
                squares: xyz(1.0, -1.0, -sign),
                products: Vec3::ZERO,
                linear: xyz(0.0, -2.0 * half, 0.0),
                constant: -half * half,
                clip,
            };
            let ray = Ray { t_min: -INF, ..Ray::new(xyz(0.0, below, tiny), Vec3::X) };
            assert_hit(quadric.truth(&ray), -expected, false);
            assert_hit(quadric.truth(&Ray { t_min: 0.0, ..ray }), expected, false);
            assert_eq!(quadric.truth_filtered(&ray), None, "the filter cannot be sure in f64");
        }
    }
}

#[test]
fn u_and_v_are_correctly_rounded() {
    let mut inputs = Inputs::new(31);
    for _ in 0..CASES / 4 {
        let size = inputs.int(2..=0xff_ffff);
        let (x, y) = (inputs.int(1..=size), inputs.int(1..=size));
        let scale = inputs.power_of_two(-60..=60);
        let [size_f32, x_f32, y_f32] = [size, x, y].map(|n| n as f32 * scale);
        let triangle = Triangle { v0: Vec3::ZERO, v1: Vec3::X * size_f32, v2: Vec3::Y * size_f32 };
        let truth = triangle.truth(&Ray::new(Vec3::new(x_f32, y_f32, -scale), Vec3::Z));
        assert_eq!(truth.hit, x + y <= size);
        assert_eq!(truth.boundary, x + y == size);
        if truth.hit {
            let expected = [x, y].map(|n| nearest(n.into(), size.into(), 0));
            assert_eq!([truth.u, truth.v], expected, "{x} {y} / {size}");
        }
    }
}

// ---------------------------------------------------------------------------------------------------------------------
// Transforms
// ---------------------------------------------------------------------------------------------------------------------

#[test]
fn a_placed_triangle_is_hit_like_the_transformed_triangle() {
    let (mut inputs, mut count) = (Inputs::new(40), Count::default());
    for _ in 0..CASES / 4 {
        let (shape, ray) = inputs.triangle(Kind::Grid);
        let identity = Placed { shape, object_to_world: Affine3::IDENTITY };
        assert_same(identity.truth(&ray), shape.truth(&ray), &(shape, ray));

        let object_to_world = inputs.exact_transform();
        let [v0, v1, v2] = shape.vertices().map(|vertex| object_to_world.transform_point3(vertex));
        let ray = placed(shape, object_to_world, ray).1;
        let truth = Triangle { v0, v1, v2 }.truth_exact(&ray);
        let placed = Placed { shape, object_to_world };
        assert_same(placed.truth_exact(&ray), truth, &(placed, ray));
        assert_same(placed.truth(&ray), truth, &(placed, ray));
        count.add(&truth, true);
    }
    count.assert_shares(&"placed triangles", 1.0, 0.3, 0.1);
}

fn hits_like_the_untransformed_shape<S>(seed: u64, name: &str, input: fn(&mut Inputs, Kind) -> (S, Ray<f32>))
where
    S: Exact,
    Placed<S>: Exact,
{
    let (mut inputs, mut count) = (Inputs::new(seed), Count::default());
    for _ in 0..CASES / 4 {
        let (shape, ray) = input(&mut inputs, Kind::Grid);
        let truth = shape.truth_exact(&ray);
        let identity = Placed { shape, object_to_world: Affine3::IDENTITY };
        assert_same(identity.truth(&ray), truth, &(shape, ray));

        // The transform moves shape and ray exactly, so the answer must stay the same, with its t.
        let (placed, moved) = placed(shape, inputs.exact_transform(), ray);
        assert_same(placed.truth_exact(&moved), truth, &(placed, moved));
        assert_same(placed.truth(&moved), truth, &(placed, moved));
        count.add(&truth, true);
    }
    count.assert_shares(&name, 1.0, 0.3, 0.1);
}

#[test]
fn a_placed_box_is_hit_like_the_box() {
    hits_like_the_untransformed_shape(41, "placed boxes", Inputs::aabb);
}

#[test]
fn a_placed_quadric_is_hit_like_the_quadric() {
    hits_like_the_untransformed_shape(42, "placed quadrics", Inputs::quadric);
}

#[test]
fn transforms_without_inverse_miss() {
    let triangle = Triangle { v0: Vec3::ZERO, v1: Vec3::X, v2: Vec3::Y };
    let unit = Aabb { lo: Vec3::ZERO, hi: Vec3::ONE };
    let sphere = Quadric::sphere(1.0);
    let ray = Ray::new(Vec3::new(0.25, 0.25, -1.0), Vec3::Z);
    let mut not_finite = Affine3::IDENTITY;
    not_finite.translation.x = INF;
    // Flattened along z the triangle itself stays the same, but a transform without inverse has no hits.
    for object_to_world in [Affine3::from_scale(Vec3::new(1.0, 1.0, 0.0)), not_finite] {
        assert_eq!(Placed { shape: triangle, object_to_world }.truth(&ray), Truth::MISS);
        assert_eq!(Placed { shape: unit, object_to_world }.truth(&ray), Truth::MISS);
        assert_eq!(Placed { shape: sphere, object_to_world }.truth(&ray), Truth::MISS);
    }
    // A determinant of about 3e-135 is not zero.
    let object_to_world = Affine3::from_scale(Vec3::splat(1e-45));
    let ray = Ray::new(Vec3::new(0.0, 0.0, -1.0), Vec3::Z);
    assert_hit(Placed { shape: triangle, object_to_world }.truth(&ray), 1.0, true);
    assert_hit(Placed { shape: unit, object_to_world }.truth(&ray), 1.0, true);
    assert_hit(Placed { shape: sphere, object_to_world }.truth(&ray), 1.0, false);
}

// ---------------------------------------------------------------------------------------------------------------------
// Sharp cases
// ---------------------------------------------------------------------------------------------------------------------

fn xyz(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

#[test]
fn a_ray_exactly_on_a_shared_edge_hits_both_triangles() {
    let ray = Ray::new(xyz(-6.75, -9.75, 8.0), xyz(0.875, 1.25, -1.0));
    let (a, b, c, d) = (xyz(-5.0, -5.0, 0.0), xyz(5.0, -5.0, 0.0), xyz(5.0, 5.0, 0.0), xyz(-5.0, 5.0, 0.0));
    assert_hit(Triangle { v0: a, v1: b, v2: c }.truth(&ray), 8.0, true);
    assert_hit(Triangle { v0: a, v1: c, v2: d }.truth(&ray), 8.0, true);
}

#[test]
fn triangles_of_every_size_are_hit() {
    let s = 2e-4;
    let triangle = Triangle { v0: Vec3::ZERO, v1: Vec3::X * s, v2: Vec3::Y * s };
    assert_hit(triangle.truth(&Ray::new(xyz(s / 3.0, s / 3.0, -1.0), Vec3::Z)), 1.0, false);
    for s in [1e-13, 1e15] {
        let triangle = Triangle { v0: Vec3::ZERO, v1: Vec3::X * s, v2: Vec3::Y * s };
        let truth = triangle.truth(&Ray::new(xyz(s / 4.0, s / 4.0, -s), Vec3::Z * s));
        assert_eq!(truth, Truth { hit: true, boundary: false, t: 1.0, u: 0.25, v: 0.25 });
    }
}

#[test]
fn degenerate_triangles_miss() {
    let vertex = |y| xyz(-1_113.454_6, y, -56.243_19);
    let triangle = Triangle { v0: vertex(-79.049_614), v1: vertex(-87.092_27), v2: vertex(-79.209_015) };
    let ray = Ray::new(xyz(-1_081.479_3, 99.999_954, 87.770_11), xyz(-32.107_3, -183.355_87, -144.607_64));
    assert_eq!(triangle.truth(&ray), Truth::MISS);
    let point = Triangle { v0: Vec3::ZERO, v1: Vec3::ZERO, v2: Vec3::ZERO };
    assert_eq!(point.truth(&Ray::new(Vec3::NEG_Z, Vec3::Z)), Truth::MISS);
    for bad in [f32::NAN, INF, -INF] {
        let triangle = Triangle { v0: Vec3::ZERO, v1: xyz(1.0, bad, 0.0), v2: Vec3::Y };
        assert_eq!(triangle.truth(&Ray::new(xyz(0.25, 0.25, -1.0), Vec3::Z)), Truth::MISS);
    }
}

#[test]
fn triangles_are_closed_and_hit_from_both_sides() {
    let triangle = Triangle { v0: Vec3::ZERO, v1: Vec3::X, v2: Vec3::Y };
    let towards = |x, y, t_min, t_max| Ray { t_min, t_max, ..Ray::new(xyz(x, y, -1.0), Vec3::Z) };
    for (x, y) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.5, 0.5), (0.5, 0.0), (0.0, 0.5)] {
        assert_hit(triangle.truth(&towards(x, y, 0.0, INF)), 1.0, true);
        assert_hit(triangle.truth(&Ray::new(xyz(x, y, 1.0), Vec3::NEG_Z)), 1.0, true);
    }
    let least = f32::from_bits(1);
    for (x, y) in [(-least, 0.5), (0.5, -least), (1.0, least), (0.5, 0.5 + f32::EPSILON / 2.0)] {
        assert_eq!(triangle.truth(&towards(x, y, 0.0, INF)), Truth::MISS);
    }
    let (before, after) = (1f32.next_down(), 1f32.next_up());
    assert_hit(triangle.truth(&towards(0.25, 0.25, before, after)), 1.0, false);
    assert_hit(triangle.truth(&towards(0.25, 0.25, 1.0, after)), 1.0, true);
    assert_hit(triangle.truth(&towards(0.25, 0.25, before, 1.0)), 1.0, true);
    assert_eq!(triangle.truth(&towards(0.25, 0.25, after, INF)), Truth::MISS);
    assert_eq!(triangle.truth(&towards(0.25, 0.25, -INF, before)), Truth::MISS);
    // Within the plane.
    assert_eq!(triangle.truth(&Ray::new(xyz(-1.0, 0.25, 0.0), Vec3::X)), Truth::MISS);
}

#[test]
fn boxes_are_closed() {
    let unit = Aabb { lo: Vec3::ZERO, hi: Vec3::ONE };
    for zero in [0.0, -0.0] {
        for x in [0.0, 1.0] {
            assert_hit(unit.truth(&Ray::new(xyz(x, 0.5, -1.0), xyz(zero, 0.0, 1.0))), 1.0, true);
        }
    }
    assert_hit(unit.truth(&Ray::new(xyz(0.5, 0.0, -1.0), Vec3::Z)), 1.0, true);
    assert_eq!(unit.truth(&Ray::new(xyz(-5.0, 1.0, -1.0), Vec3::X)), Truth::MISS);
    // The origin is on the surface, and the ray leaves.
    let leaving = unit.truth(&Ray::new(xyz(0.5, 0.5, 1.0), Vec3::Z));
    assert_eq!(leaving, Truth { hit: true, boundary: true, t: 0.0, u: 0.0, v: 0.0 });
    // The origin is on the surface, and the ray enters.
    let entering = unit.truth(&Ray::new(xyz(0.5, 0.5, 0.0), Vec3::Z));
    assert_eq!(entering, Truth { hit: true, boundary: false, t: 0.0, u: 1.0, v: 0.0 });

    let flat = Aabb { lo: xyz(0.5, 0.0, 0.0), hi: xyz(0.5, 1.0, 1.0) };
    assert_hit(flat.truth(&Ray::new(xyz(0.5, 0.5, -1.0), Vec3::Z)), 1.0, true);
    assert_hit(flat.truth(&Ray::new(xyz(0.0, 0.5, 0.5), Vec3::X)), 0.5, true);
    assert_eq!(flat.truth(&Ray::new(xyz(0.5f32.next_up(), 0.5, -1.0), Vec3::Z)), Truth::MISS);

    // An edge, touched from outside, and a corner through which the ray enters.
    assert_hit(unit.truth(&Ray::new(xyz(-1.0, 1.0, 0.5), xyz(1.0, -1.0, 0.0))), 1.0, true);
    assert_hit(unit.truth(&Ray::new(xyz(-1.0, -1.0, -1.0), Vec3::ONE)), 1.0, false);
}

#[test]
fn spheres_are_hit_at_known_points() {
    let unit = Quadric::sphere(1.0);
    assert_hit(unit.truth(&Ray::new(xyz(0.5, 0.0, -1e4), Vec3::Z)), 9_999.134, false);
    assert_eq!(unit.truth(&Ray::new(xyz(1.001, 0.0, -4096.0), Vec3::Z)), Truth::MISS);
    assert_hit(unit.truth(&Ray::new(xyz(1.0, 0.0, -3.0), Vec3::Z)), 3.0, true);
    assert_eq!(unit.truth(&Ray::new(xyz(1f32.next_up(), 0.0, -3.0), Vec3::Z)), Truth::MISS);
    assert_hit(unit.truth(&Ray::new(xyz(1f32.next_down(), 0.0, -3.0), Vec3::Z)), 2.999_654_8, false);
    // From inside, from the surface, and at the ends of the interval.
    assert_hit(unit.truth(&Ray::new(Vec3::ZERO, Vec3::Z)), 1.0, false);
    let within = |t_min, t_max| unit.truth(&Ray { t_min, t_max, ..Ray::new(xyz(0.0, 0.0, -1.0), Vec3::Z) });
    assert_hit(within(0.0, INF), 0.0, true);
    assert_hit(within(f32::from_bits(1), INF), 2.0, false);
    assert_hit(within(1.0, 2.0), 2.0, true);
    assert_hit(within(-INF, INF), 0.0, false);
    assert_eq!(within(0.5, 1.5), Truth::MISS);
    assert_eq!(within(2f32.next_up(), INF), Truth::MISS);
    // Clipped above the equator, or exactly at the pole that the ray meets.
    let clipped = |hi: f32| Quadric { clip: Aabb { hi: xyz(9.0, 9.0, hi), ..unit.clip }, ..unit };
    assert_hit(clipped(0.0).truth(&Ray::new(xyz(0.0, 0.0, 2.0), Vec3::NEG_Z)), 3.0, false);
    assert_hit(clipped(1.0).truth(&Ray::new(xyz(0.0, 0.0, 2.0), Vec3::NEG_Z)), 1.0, true);
    assert_eq!(clipped(0.0).truth(&Ray::new(Vec3::ZERO, Vec3::Z)), Truth::MISS);
    // Within a clip plane.
    assert_hit(clipped(0.0).truth(&Ray::new(xyz(-3.0, 0.0, 0.0), Vec3::X)), 2.0, true);
}

#[test]
fn other_quadrics_are_hit_at_known_points() {
    let bowl = Quadric::paraboloid(2.0, 4.0);
    assert_hit(bowl.truth(&Ray::new(xyz(0.5, 0.25, -2.0), xyz(1e-4, 0.0, 1.0))), 2.312_731_3, false);
    assert_hit(bowl.truth(&Ray::new(xyz(0.5, 0.25, -2.0), Vec3::Z)), 2.312_5, false);
    assert_hit(bowl.truth(&Ray::new(xyz(0.0, 0.0, -2.0), Vec3::Z)), 2.0, false);
    let tube = Quadric::cylinder(1.0, 2.0);
    assert_eq!(tube.truth(&Ray::new(xyz(0.5, 0.0, 0.0), Vec3::Z)), Truth::MISS);
    assert_eq!(tube.truth(&Ray::new(xyz(1.0, 0.0, 0.0), Vec3::Z)), Truth::MISS, "a ray within the surface");
    assert_hit(tube.truth(&Ray::new(xyz(-3.0, 0.0, 2.0), Vec3::X)), 2.0, true);
    assert_hit(tube.truth(&Ray::new(xyz(-3.0, 0.0, 3.0), xyz(1.0, 0.0, -0.5))), 2.0, true);
    // The near wall is clipped away, the far one is not.
    assert_hit(tube.truth(&Ray::new(xyz(-3.0, 0.0, 3.5), xyz(1.0, 0.0, -0.5))), 4.0, false);
    let cone = Quadric::cone(1.0, 1.0);
    assert_hit(cone.truth(&Ray::new(xyz(-1.0, 0.0, 0.0), Vec3::X)), 1.0, true);
    assert_hit(cone.truth(&Ray::new(xyz(-1.0, 0.0, 0.5), Vec3::X)), 0.5, false);
    // Parallel to a generatrix: one root, the other is infinite. Within a generatrix: none.
    assert_hit(cone.truth(&Ray::new(xyz(-1.0, 0.0, -0.5), xyz(1.0, 0.0, 1.0))), 0.75, false);
    assert_eq!(cone.truth(&Ray::new(xyz(-1.0, 0.0, -1.0), xyz(1.0, 0.0, 1.0))), Truth::MISS);
}

#[test]
fn quadrics_that_miss_everything() {
    let (ray, unit) = (Ray::new(xyz(0.0, 0.0, -2.0), Vec3::Z), Quadric::sphere(1.0));
    let misses = |quadric: Quadric| {
        let placed = Placed { shape: quadric, object_to_world: Affine3::IDENTITY };
        [quadric.truth(&ray), placed.truth(&ray)].map(|truth| truth == Truth::MISS)
    };
    assert_eq!(misses(unit), [false; 2]);
    let space = Aabb { lo: Vec3::NEG_INFINITY, hi: Vec3::INFINITY };
    assert_eq!(misses(Quadric { clip: space, ..unit }), [false; 2]);
    for bad in [f32::NAN, INF, -INF] {
        assert_eq!(misses(Quadric { constant: bad, ..unit }), [true; 2]);
        assert_eq!(misses(Quadric { linear: xyz(bad, 0.0, 0.0), ..unit }), [true; 2]);
        assert_eq!(misses(Quadric { products: xyz(0.0, bad, 0.0), ..unit }), [true; 2]);
        assert_eq!(misses(Quadric { squares: xyz(1.0, 1.0, bad), ..unit }), [true; 2]);
    }
    assert_eq!(misses(Quadric { clip: Aabb::EMPTY, ..unit }), [true; 2]);
    assert_eq!(misses(Quadric { clip: Aabb { lo: xyz(f32::NAN, -2.0, -2.0), ..unit.clip }, ..unit }), [true; 2]);
    assert_eq!(misses(Quadric { squares: Vec3::ZERO, constant: 0.0, ..unit }), [true; 2], "0 = 0 is no surface");
}

#[test]
fn empty_boxes_miss_and_infinite_boxes_are_hit() {
    let ray = Ray::new(xyz(0.5, 0.5, -1.0), Vec3::Z);
    let anything = Ray { t_min: -INF, ..ray };
    let nan = Aabb { lo: xyz(0.0, f32::NAN, 0.0), hi: Vec3::ONE };
    let nowhere = Aabb { lo: xyz(0.0, 0.0, INF), hi: xyz(1.0, 1.0, INF) };
    for empty in [Aabb::EMPTY, nan, nowhere, Aabb { lo: Vec3::ONE, hi: Vec3::ZERO }] {
        assert_eq!(empty.truth(&ray), Truth::MISS);
        assert_eq!(empty.truth(&anything), Truth::MISS);
    }
    let space = Aabb { lo: Vec3::NEG_INFINITY, hi: Vec3::INFINITY };
    assert_eq!(space.truth(&ray), Truth { hit: true, boundary: false, t: 0.0, u: INF, v: 0.0 });
    assert_eq!(space.truth(&anything), Truth { hit: true, boundary: false, t: -INF, u: INF, v: 0.0 });
    let half_space = Aabb { hi: xyz(INF, INF, 3.0), ..space };
    assert_eq!(half_space.truth(&anything), Truth { hit: true, boundary: false, t: -INF, u: 4.0, v: 0.0 });
}

#[test]
fn rays_that_miss_everything() {
    let triangle = Triangle { v0: xyz(-9.0, -9.0, 0.0), v1: xyz(9.0, -9.0, 0.0), v2: xyz(0.0, 9.0, 0.0) };
    let space = Aabb { lo: Vec3::NEG_INFINITY, hi: Vec3::INFINITY };
    let sphere = Quadric::sphere(1e9);
    let object_to_world = Affine3::IDENTITY;
    let good = Ray::new(xyz(0.0, 0.0, -1.0), Vec3::Z);
    let misses = |ray: &Ray<f32>| {
        [
            triangle.truth(ray),
            space.truth(ray),
            sphere.truth(ray),
            Placed { shape: triangle, object_to_world }.truth(ray),
            Placed { shape: space, object_to_world }.truth(ray),
            Placed { shape: sphere, object_to_world }.truth(ray),
        ]
        .map(|truth| truth == Truth::MISS)
    };
    assert_eq!(misses(&good), [false; 6]);
    for bad in [f32::NAN, INF, -INF] {
        for axis in 0..3 {
            let (mut origin, mut dir) = (good, good);
            origin.origin[axis] = bad;
            dir.dir[axis] = bad;
            assert_eq!((misses(&origin), misses(&dir)), ([true; 6], [true; 6]), "{bad} on axis {axis}");
        }
    }
    assert_eq!(misses(&Ray { dir: xyz(0.0, -0.0, 0.0), ..good }), [true; 6]);
    assert_eq!(misses(&Ray { t_min: f32::NAN, ..good }), [true; 6]);
    assert_eq!(misses(&Ray { t_max: f32::NAN, ..good }), [true; 6]);
    assert_eq!(misses(&Ray { t_min: 2.0, t_max: 0.5, ..good }), [true; 6]);
    assert_eq!(misses(&Ray { t_min: INF, ..good }), [true; 6], "no finite t is inf");
    assert_eq!(misses(&Ray { t_min: -INF, t_max: -INF, ..good }), [true; 6], "no finite t is -inf");
    assert_eq!(misses(&Ray::INACTIVE), [true; 6]);
}
