//! Errors of hits as a renderer meets them: of the point, of its height off the surface, of the normal, and of the ray
//! that leaves it. Beside them the backward error of `t`.
//!
//! An error of `t` in ulp does not say how far off the point is. A ray from far away rounds even the best `t` to a step
//! of visible size, and a ray at a grazing angle may be off by many ulp and still meet the plane.
//!
//! **Reference:** the exact hit, in `f64` ([`ExactHit`]). Its own error is 2⁻⁵³ of the coordinates. The `f32` points
//! here have at least that of their own rounding, up to 2⁻²⁴ of the coordinates. The difference of two such points is
//! as exact as the reference. Heights do not subtract surfaces either: the exact point lies on the surface, so the
//! polynomial of a surface, developed there, has no constant that could cancel.
//!
//! **Backward error:** `|t - t*| / (2⁻²⁴ · Σ |∂t/∂x|·|x|)`, where `t*` is exact and the sum is over all numbers `x` of
//! ray and primitive (and of the transform, if there is one). The sum, relative to `t*`, is the componentwise condition
//! number. On a surface `F = 0` a change of any number moves `t` by `∂t/∂x = -∂F/∂x / (∇F·dir)`. For a triangle `F` is
//! the height above the plane. If the vertex `k` rises by one, the plane at the hit rises by the barycentric weight
//! `βₖ`. So with the normal `n` the sum is `Σᵢ |nᵢ|·(|oᵢ| + |t·dᵢ| + Σₖ βₖ·|vₖᵢ|) / |n·d|`. For a tangent ray it is
//! infinite, and the backward error is zero. Source: N. J. Higham, "Accuracy and Stability of Numerical Algorithms",
//! 2nd edition, 2002, sections 1.5 and 1.6.

use glam::{Affine3, DMat3, DVec3, Vec3};
use rand_pcg::Pcg64;

use super::tally::{per_million, quantile};
use crate::geom::{Aabb, Hit, Placed, Quadric, Ray};
use crate::oracle::{ExactHit, Truth};
use crate::study::record::HitErrors;
use crate::study::workload::{Primitive, Sample, Subject, direction};
use crate::tracer::{Leaving, SurfacePoint};

/// One ray in this many is measured: of sample `i` the rays `i`, `i + 8`, … modulo 8.
const STRIDE: usize = 8;

/// The two epsilons: relative to the largest coordinate, and to the length of the ray.
const EPSILON: f32 = 1e-4;

/// The largest relative error of rounding to `f32`.
const HALF_ULP: f64 = f32::EPSILON as f64 / 2.0;

/// An exact hit, and what its errors are measured by. All kernels share it.
#[derive(Clone, Debug)]
pub(super) struct Reference<S> {
    /// Number of the pair of ray and shape in the sample.
    pair: usize,
    shape: S,
    ray: Ray<f32>,
    exact: ExactHit,
    placed: Placed<Primitive>,
    /// Size of the primitive; see [`HitErrors::ray_point_size_p99`].
    size: f64,
    /// The largest absolute coordinate of the ray's origin and of the primitive.
    scene: f64,
    /// `None` for a box.
    surface: Option<Surface>,
}

/// The exact hits of the measured rays. `index` is the number of the sample. `rng` decides where rays leave to.
pub(super) fn references<S: Subject>(
    sample: &Sample<S>,
    truths: &[Truth],
    index: u64,
    rng: &mut Pcg64,
) -> Vec<Reference<S>> {
    let each = sample.shapes.len();
    let first = (index % STRIDE as u64) as usize;
    let pairs = (first..sample.rays.len()).step_by(STRIDE).flat_map(|ray| ray * each..(ray + 1) * each);
    let reference = |pair: usize| {
        let (ray, shape, truth) = (&sample.rays[pair / each], &sample.shapes[pair % each], &truths[pair]);
        // As for ulp, a `t` that is clipped to the start of the interval is left out.
        let is_measured = truth.hit && truth.t.is_finite() && truth.t.to_bits() != ray.t_min.to_bits();
        is_measured.then(|| Reference::of(pair, shape, ray, truth, rng))
    };
    pairs.filter_map(reference).collect()
}

impl<S: Subject> Reference<S> {
    fn of(pair: usize, shape: &S, ray: &Ray<f32>, truth: &Truth, rng: &mut Pcg64) -> Self {
        let (exact, placed) = (shape.exact_hit(ray, truth), shape.primitive());
        let [size, reach] = size_and_reach(&placed);
        let scene = ray.origin.as_dvec3().abs().max_element().max(reach);
        let surface = Surface::of(&placed, ray, &exact, truth, rng);
        Self { pair, shape: *shape, ray: *ray, exact, placed, size, scene, surface }
    }
}

/// The length of the longest edge or side in the world, and the largest absolute coordinate.
fn size_and_reach(placed: &Placed<Primitive>) -> [f64; 2] {
    let Affine3 { matrix3, translation } = placed.object_to_world;
    let (linear, translation) = (matrix3.as_dmat3(), translation.as_dvec3());
    let of_box = |bounds: &Aabb| {
        let [lo, hi] = [bounds.lo, bounds.hi].map(Vec3::as_dvec3);
        let sides = linear * DMat3::from_diagonal(hi - lo);
        let size = [sides.x_axis, sides.y_axis, sides.z_axis].map(DVec3::length).into_iter().fold(0.0, f64::max);
        let middle = linear * ((lo + hi) * 0.5) + translation;
        [size, (middle.abs() + linear.abs() * ((hi - lo) * 0.5)).max_element()]
    };
    match &placed.shape {
        Primitive::Triangle(triangle) => {
            let [v0, v1, v2] = triangle.vertices().map(|vertex| linear * vertex.as_dvec3() + translation);
            let size = (v1 - v0).length().max((v2 - v1).length()).max((v0 - v2).length());
            [size, v0.abs().max(v1.abs()).max(v2.abs()).max_element()]
        }
        Primitive::Box(bounds) => of_box(bounds),
        Primitive::Quadric(quadric) => of_box(&quadric.clip),
    }
}

/// The surface around an exact hit: where `gradient·p + p·bend·p` is zero, for points `p` relative to the hit.
#[derive(Clone, Debug)]
struct Surface {
    leaving: Leaving,
    /// For a triangle the unit normal.
    gradient: DVec3,
    /// Zero for a triangle.
    bend: DMat3,
    /// How far `t` moves at most if each number of ray and primitive changes by this share of itself: `Σ |∂t/∂x|·|x|`.
    sensitivity: f64,
    /// Where a ray leaves to. `None` if it would come back to the quadric.
    away: Option<Vec3>,
}

impl Surface {
    fn of(
        placed: &Placed<Primitive>,
        ray: &Ray<f32>,
        exact: &ExactHit,
        truth: &Truth,
        rng: &mut Pcg64,
    ) -> Option<Self> {
        let Affine3 { matrix3, translation } = placed.object_to_world;
        let (linear, translation) = (matrix3.as_dmat3(), translation.as_dvec3());
        let to_object = linear.inverse();
        let in_object = to_object * (exact.point - translation);
        // `own` is the sum of |∂F/∂x|·|x| over the numbers of the shape.
        let (leaving, gradient, bend, own) = match placed.shape {
            Primitive::Box(_) => return None,
            Primitive::Triangle(triangle) => {
                let [u, v] = [truth.u, truth.v].map(f64::from);
                let [v0, v1, v2] = triangle.vertices().map(|vertex| vertex.as_dvec3().abs());
                let vertices = v0 * (1.0 - u - v) + v1 * u + v2 * v;
                let own = (linear.transpose() * exact.normal).abs().dot(vertices);
                (Leaving::Triangle(triangle), exact.normal, DMat3::ZERO, own)
            }
            Primitive::Quadric(quadric) => {
                let matrix = quadric.matrix();
                let gradient = to_object.transpose() * (matrix * in_object * 2.0 + quadric.linear.as_dvec3());
                let bend = to_object.transpose() * matrix * to_object;
                let own = sum_of_terms(&quadric, in_object);
                (Leaving::Quadric(quadric), exact.normal * gradient.length(), bend, own)
            }
        };
        let (origin, dir) = (ray.origin.as_dvec3(), ray.dir.as_dvec3());
        let mut terms = origin.abs() + dir.abs() * exact.t.abs();
        if placed.object_to_world != Affine3::IDENTITY {
            terms += translation.abs() + linear.abs() * in_object.abs();
        }
        let sensitivity = (gradient.abs().dot(terms) + own) / gradient.dot(dir).abs();
        let facing = exact.normal.as_vec3() * if gradient.dot(dir) > 0.0 { -1.0 } else { 1.0 };
        let away = (facing + direction(rng)).normalize_or(facing);
        // The other point of the quadric on the line is at -gradient·away / away·bend·away.
        let comes_back = gradient.dot(away.as_dvec3()) * away.as_dvec3().dot(bend * away.as_dvec3()) < 0.0;
        Some(Self { leaving, gradient, bend, sensitivity, away: (!comes_back).then_some(away) })
    }

    /// The distance of a point from the surface. `from` is the point, relative to the exact hit. For a quadric it is
    /// the value of the polynomial over its slope (G. Taubin, "Estimation of planar curves, surfaces, and nonplanar
    /// space curves", 1991), right to first order, and never more than the distance to the hit.
    fn height(&self, from: DVec3) -> f64 {
        let slope = self.gradient + self.bend * from * 2.0;
        ((self.gradient + self.bend * from).dot(from) / slope.length()).abs().min(from.length())
    }
}

/// The terms of the quadric's polynomial, without their signs.
fn sum_of_terms(quadric: &Quadric, point: DVec3) -> f64 {
    let DVec3 { x, y, z } = point;
    let Quadric { squares, products, linear, constant, .. } = quadric;
    let [squares, products, linear] = [squares, products, linear].map(|coefficients| coefficients.as_dvec3().abs());
    squares.dot(point * point)
        + products.dot(DVec3::new(y * z, z * x, x * y).abs())
        + linear.dot(point.abs())
        + f64::from(constant.abs())
}

/// The errors of one hit of a kernel. Lengths are in the units of the scene.
#[derive(Clone, Copy, Debug)]
struct HitError {
    size: f64,
    scene: f64,
    ray_point: f64,
    uv_point: Option<f64>,
    ray_height: Option<f64>,
    uv_height: Option<f64>,
    normal: Option<f64>,
    t_backward: Option<f64>,
    /// Whether a leaving ray hits the primitive again: with the tracer's offset, with the two epsilons, with none.
    own_hits: Option<[bool; 4]>,
}

impl HitError {
    /// `trace` gives the kernel's hits of a sample.
    fn of<S: Copy>(reference: &Reference<S>, hit: &Hit<f32>, trace: fn(&Sample<S>) -> Vec<Hit<f32>>) -> Self {
        let Reference { ray, exact, placed, surface, .. } = reference;
        let off = |point: Vec3| point.as_dvec3() - exact.point;
        let at = ray.at(hit.t);
        let uv_point = match &placed.shape {
            Primitive::Triangle(triangle) => {
                let in_object = triangle.v0 * (1.0 - hit.u - hit.v) + triangle.v1 * hit.u + triangle.v2 * hit.v;
                Some(off(placed.object_to_world.transform_point3(in_object)))
            }
            Primitive::Box(_) | Primitive::Quadric(_) => None,
        };
        let surface = surface.as_ref();
        let found = surface.map(|surface| SurfacePoint::of_shape(&surface.leaving, &placed.object_to_world, ray, hit));
        let own_hits = surface.zip(found).and_then(|(surface, found)| {
            let away = surface.away?;
            let with_t_min = |t_min| Ray { t_min, ..Ray::new(at, away) };
            let rays = vec![
                found.spawn(away),
                with_t_min(EPSILON * reference.scene as f32),
                with_t_min(EPSILON * hit.t * ray.dir.length()),
                with_t_min(0.0),
            ];
            let hits = trace(&Sample { shapes: vec![reference.shape], rays });
            Some([0, 1, 2, 3].map(|way| hits[way].mask))
        });
        Self {
            size: reference.size,
            scene: reference.scene,
            ray_point: off(at).length(),
            uv_point: uv_point.map(DVec3::length),
            ray_height: surface.map(|surface| surface.height(off(at))),
            uv_height: surface.zip(uv_point).map(|(surface, off)| surface.height(off)),
            normal: found.map(|found| angle(found.normal.as_dvec3(), exact.normal)),
            t_backward: surface.map(|surface| (f64::from(hit.t) - exact.t).abs() / (HALF_ULP * surface.sensitivity)),
            own_hits,
        }
    }
}

/// The angle between two vectors, in rad. The arcus tangent of the platform would differ from machine to machine.
fn angle(a: DVec3, b: DVec3) -> f64 {
    libm::atan2(a.cross(b).length(), a.dot(b))
}

/// The errors of the measured hits of one kernel.
#[derive(Default)]
pub(super) struct HitErrorTally(Vec<HitError>);

impl HitErrorTally {
    /// Adds the hits of a sample, in the order of its pairs. `trace` gives the kernel's hits of any sample.
    pub(super) fn sample<S: Copy>(
        &mut self,
        references: &[Reference<S>],
        hits: &[Hit<f32>],
        trace: fn(&Sample<S>) -> Vec<Hit<f32>>,
    ) {
        let agreed = references.iter().map(|reference| (reference, &hits[reference.pair])).filter(|(_, hit)| hit.mask);
        self.0.extend(agreed.map(|(reference, hit)| HitError::of(reference, hit, trace)));
    }

    pub(super) fn merge(&mut self, other: Self) {
        self.0.extend(other.0);
    }

    pub(super) fn row(&self) -> HitErrors {
        let ray_point_size_p99 = self.p99(|hit| Some(hit.ray_point / hit.size));
        let ray_point_scene_p99 = self.p99(|hit| Some(hit.ray_point / hit.scene));
        let uv_point_size_p99 = self.p99(|hit| Some(hit.uv_point? / hit.size));
        let uv_point_scene_p99 = self.p99(|hit| Some(hit.uv_point? / hit.scene));
        let ray_height_size_p99 = self.p99(|hit| Some(hit.ray_height? / hit.size));
        let ray_height_scene_p99 = self.p99(|hit| Some(hit.ray_height? / hit.scene));
        let uv_height_size_p99 = self.p99(|hit| Some(hit.uv_height? / hit.size));
        let uv_height_scene_p99 = self.p99(|hit| Some(hit.uv_height? / hit.scene));
        let normal_error_p99 = self.p99(|hit| hit.normal);
        let t_backward_p99 = self.p99(|hit| hit.t_backward);
        let left = || self.0.iter().filter_map(|hit| hit.own_hits);
        let leaving_rays = left().count() as u64;
        let own = |way: usize| per_million(left().filter(|own| own[way]).count() as u64, leaving_rays);
        HitErrors {
            measured_hits: self.0.len() as u64,
            ray_point_size_p99,
            ray_point_scene_p99,
            uv_point_size_p99,
            uv_point_scene_p99,
            ray_height_size_p99,
            ray_height_scene_p99,
            uv_height_size_p99,
            uv_height_scene_p99,
            normal_error_p99,
            t_backward_p99,
            leaving_rays,
            own_hit_offset_per_million: own(0),
            own_hit_scene_epsilon_per_million: own(1),
            own_hit_t_epsilon_per_million: own(2),
            own_hit_no_epsilon_per_million: own(3),
        }
    }

    /// 99th percentile, to four digits. `None` if no hit has the error, or if it is infinite.
    fn p99(&self, error: impl Fn(&HitError) -> Option<f64>) -> Option<f64> {
        // The point of an infinite `t` is not a number.
        let or_infinite = |error: f64| if error.is_nan() { f64::INFINITY } else { error };
        let mut errors: Vec<f64> = self.0.iter().filter_map(error).map(or_infinite).collect();
        if errors.is_empty() {
            return None;
        }
        let index = quantile(0.99, errors.len());
        let (_, &mut p99, _) = errors.select_nth_unstable_by(index, f64::total_cmp);
        p99.is_finite().then(|| format!("{p99:.3e}").parse().expect("digits are a number"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Triangle;
    use crate::kernels::triangle::MollerTrumboreF64;
    use crate::kernels::{Intersect, Kernel};
    use crate::oracle::Exact;
    use crate::study::measure::accuracy::Kernels;
    use crate::study::measure::stats::ulps_between;
    use crate::study::workload::rng;

    const UNIT: Triangle = Triangle { v0: Vec3::ZERO, v1: Vec3::X, v2: Vec3::Y };

    fn reference<S: Subject>(shape: &S, ray: &Ray<f32>) -> Reference<S> {
        let sample = Sample { shapes: vec![*shape], rays: vec![*ray] };
        references(&sample, &[shape.truth(ray)], 8, &mut rng(1, "", "", &[], 0)).pop().expect("the ray hits")
    }

    fn trace(sample: &Sample<Triangle>) -> Vec<Hit<f32>> {
        let kernel = MollerTrumboreF64::prepare(&sample.shapes[0]);
        sample.rays.iter().map(|ray| Intersect::<f32>::hit(&kernel, ray)).collect()
    }

    /// The errors of a hit with these numbers.
    fn errors(shape: &Triangle, ray: &Ray<f32>, [t, u, v]: [f32; 3]) -> HitError {
        HitError::of(&reference(shape, ray), &Hit::<f32>::new(true, t, u, v), trace)
    }

    #[test]
    fn a_hit_with_a_known_error_has_the_known_metrics() {
        let ray = Ray::new(Vec3::new(0.25, 0.25, 1.0), -Vec3::Z);
        let exact = errors(&UNIT, &ray, [1.0, 0.25, 0.25]);
        assert_eq!((exact.size, exact.scene), (2f64.sqrt(), 1.0));
        assert_eq!((exact.ray_point, exact.uv_point, exact.normal), (0.0, Some(0.0), Some(0.0)));
        assert_eq!((exact.ray_height, exact.uv_height, exact.t_backward), (Some(0.0), Some(0.0), Some(0.0)));
        let off = errors(&UNIT, &ray, [1.5, 0.75, 0.25]);
        assert_eq!((off.ray_point, off.ray_height), (0.5, Some(0.5)));
        assert_eq!((off.uv_point, off.uv_height), (Some(0.5), Some(0.0)));
        // Only the heights of origin and step matter: a half over the roundings of 1 and 1.
        assert_eq!(off.t_backward, Some(0.25 / HALF_ULP));
        // A transform is an input too. Here it is twice as large, and all lengths are.
        let placed = Placed { shape: UNIT, object_to_world: Affine3::from_scale(Vec3::splat(2.0)) };
        let hit = Hit::<f32>::new(true, 2.5, 0.25, 0.25);
        let placed = HitError::of(&reference(&placed, &Ray::new(Vec3::new(0.5, 0.5, 2.0), -Vec3::Z)), &hit, |sample| {
            vec![Hit::MISS; sample.rays.len()]
        });
        assert_eq!((placed.size, placed.scene), (8f64.sqrt(), 2.0));
        assert_eq!((placed.ray_point, placed.uv_point, placed.ray_height), (0.5, Some(0.0), Some(0.5)));
        // A half over the roundings of the origin's 2, the step's 1 and the translation's 1.
        let moved = Placed { shape: UNIT, object_to_world: Affine3::from_translation(Vec3::Z) };
        let hit = Hit::<f32>::new(true, 1.5, 0.25, 0.25);
        let moved = HitError::of(&reference(&moved, &Ray::new(Vec3::new(0.25, 0.25, 2.0), -Vec3::Z)), &hit, |sample| {
            vec![Hit::MISS; sample.rays.len()]
        });
        assert_eq!(moved.t_backward, Some(0.5 / 4.0 / HALF_ULP));
    }

    #[test]
    fn the_size_is_the_longest_edge_or_side_and_the_reach_the_largest_coordinate() {
        let corners = [Vec3::X * 4.0, Vec3::ZERO, Vec3::Y * 3.0];
        for turn in 0..3 {
            let [v0, v1, v2] = [0, 1, 2].map(|vertex| corners[(vertex + turn) % 3]);
            assert_eq!(size_and_reach(&Triangle { v0, v1, v2 }.primitive()), [5.0, 4.0], "{turn}");
        }
        let bounds = Aabb { lo: Vec3::new(-1.0, 0.0, 0.0), hi: Vec3::new(5.0, 2.0, 1.0) };
        assert_eq!(size_and_reach(&bounds.primitive()), [6.0, 5.0]);
    }

    #[test]
    fn each_sample_gives_another_eighth_of_its_rays_and_none_that_is_clipped() {
        let ray = Ray::new(Vec3::new(0.25, 0.25, 1.0), -Vec3::Z);
        let pairs = |ray: Ray<f32>, index| {
            let sample = Sample { shapes: vec![UNIT], rays: vec![ray; 20] };
            let found = references(&sample, &[UNIT.truth(&ray); 20], index, &mut rng(1, "", "", &[], 0));
            found.iter().map(|found| found.pair).collect::<Vec<_>>()
        };
        assert_eq!([0, 11].map(|index| pairs(ray, index)), [[0, 8, 16], [3, 11, 19]]);
        let starting_at_the_hit = Ray { t_min: 1.0, ..ray };
        assert!(UNIT.truth(&starting_at_the_hit).hit && pairs(starting_at_the_hit, 0).is_empty());
    }

    #[test]
    fn a_tilted_triangle_has_the_condition_of_all_its_vertices() {
        // The plane x + y + z = 1, hit at a third of each. The sum is |o| + |t·d| + |p| in each coordinate, over |n·d|.
        let triangle = Triangle { v0: Vec3::X, v1: Vec3::Y, v2: Vec3::Z };
        let ray = Ray::new(Vec3::splat(1.0), Vec3::splat(-1.0));
        let found = errors(&triangle, &ray, [1.0, 1.0 / 3.0, 1.0 / 3.0]);
        let sensitivity = 3.0 * (1.0 + 2.0 / 3.0 + 1.0 / 3.0) / 3.0;
        let expected = (1.0 / 3.0) / (HALF_ULP * sensitivity);
        assert!((found.t_backward.unwrap() / expected - 1.0).abs() < 1e-6, "{found:?}");
    }

    #[test]
    fn a_leaving_ray_is_asked_whether_it_hits_again() {
        let mut reference = reference(&UNIT, &Ray::new(Vec3::new(0.25, 0.25, 1.0), -Vec3::Z));
        reference.surface.as_mut().unwrap().away = Some(Vec3::Z);
        let own_hits = |t| HitError::of(&reference, &Hit::<f32>::new(true, t, 0.25, 0.25), trace).own_hits.unwrap();
        assert_eq!(own_hits(1f32.next_down()), [false; 4]);
        // Below the surface: by less than the epsilons, and by more.
        assert_eq!(own_hits(1f32.next_up()), [false, false, false, true]);
        assert_eq!(own_hits(1.5), [false, true, true, true]);
    }

    #[test]
    fn epsilons_grow_with_the_scene_and_with_the_length_of_the_ray() {
        let far = Ray::new(Vec3::new(0.25, 0.25, 1000.0), Vec3::NEG_Z * 500.0);
        let mut reference = reference(&UNIT, &far);
        reference.surface.as_mut().unwrap().away = Some(Vec3::Z);
        // 0.01 below the surface. Both epsilons are 0.1.
        let hit = Hit::<f32>::new(true, 2.000_02, 0.25, 0.25);
        assert_eq!(HitError::of(&reference, &hit, trace).own_hits, Some([false, false, false, true]));
    }

    #[test]
    fn a_sphere_bends_under_an_error() {
        let sphere = Quadric::sphere(1.0);
        let ray = Ray::new(Vec3::new(-3.0, 0.6, 0.0), Vec3::X);
        let found = reference(&sphere, &ray);
        let hit = Hit::<f32>::new(true, 2.201, 0.0, 0.0);
        let error = HitError::of(&found, &hit, |sample| vec![Hit::MISS; sample.rays.len()]);
        let at = ray.at(hit.t).as_dvec3();
        let expected = (at.length() - 1.0).abs();
        assert!((error.ray_height.unwrap() / expected - 1.0).abs() < 1e-3, "{error:?} {expected}");
        assert!((error.normal.unwrap() - angle(at, found.exact.normal)).abs() < 1e-6, "{error:?}");
        assert!((error.ray_point - 1e-3).abs() < 1e-6 && (error.size - 2.0 * (1.0 + 1.0 / 1024.0)).abs() < 1e-6);
        // Half a radius off, the polynomial is 1.5² - 1, and its slope 2 · 1.5.
        let middle = reference(&sphere, &Ray::new(Vec3::new(-3.0, 0.0, 0.0), Vec3::X)).surface.unwrap();
        assert!((middle.height(DVec3::new(-0.5, 0.0, 0.0)) - 1.25 / 3.0).abs() < 1e-12);
        // Outside no ray comes back. Inside each does.
        assert!(found.surface.unwrap().away.is_some());
        let inside = reference(&sphere, &Ray::new(Vec3::ZERO, Vec3::X));
        assert!(inside.surface.unwrap().away.is_none());
    }

    #[test]
    fn ulp_and_distance_disagree() {
        // Grazing: 1,373 ulp, and yet 2.6e-7 off the plane, and an error that rounding the input can cause.
        let triangle = Triangle { v0: Vec3::X, v1: Vec3::Y, v2: Vec3::Z };
        let dir = Vec3::new(1.0, -1.0, 0.0).normalize() - triangle.normal() * 1.6e-3;
        let ray = Ray::new(triangle.point(0.25, 0.5) - dir * 1.5, dir);
        let truth = triangle.truth(&ray);
        let t = f32::from_bits(truth.t.to_bits() + 1_373);
        assert_eq!((truth.hit, ulps_between(truth.t, t)), (true, 1_373));
        let grazing = errors(&triangle, &ray, [t, truth.u, truth.v]);
        assert!((2.1e-7..3.1e-7).contains(&grazing.ray_height.unwrap()), "{grazing:?}");
        assert!(grazing.uv_point.unwrap() < 1e-7 && grazing.t_backward.unwrap() < 3.0, "{grazing:?}");
        // From afar: 0 ulp, and yet up to 0.56 % of the triangle beside the exact point.
        let mut worst = 0f64;
        for step in 0..100 {
            let origin = Vec3::new(7e4, 6e4, 5e4) + Vec3::new(100.37, 37.7, 17.3) * step as f32;
            let ray = Ray::new(origin, (Vec3::new(0.25, 0.25, 0.0) - origin) / 4.5);
            let truth = UNIT.truth(&ray);
            if truth.hit {
                let far = errors(&UNIT, &ray, [truth.t, truth.u, truth.v]);
                worst = worst.max(far.ray_point / far.size);
                assert!(far.uv_point.unwrap() < 1e-7 && far.t_backward.unwrap() <= 1.0, "{far:?}");
            }
        }
        assert!((0.005..0.006).contains(&worst), "{worst}");
    }

    #[test]
    fn every_eighth_ray_is_measured_and_a_miss_is_not() {
        let kernels = Kernels::<Triangle>::registered();
        for row in kernels.on_workload(crate::study::workload::Workload::Generic, 16_000, 1) {
            let HitErrors { measured_hits, leaving_rays, .. } = row.hit_errors;
            assert!(measured_hits.abs_diff(row.agreed_hits / 8) < row.agreed_hits / 80, "{row:?}");
            assert_eq!(leaving_rays, measured_hits, "{row:?}");
        }
    }

    #[test]
    fn percentiles_skip_missing_errors_and_hide_infinite_ones() {
        let exact = errors(&UNIT, &Ray::new(Vec3::new(0.25, 0.25, 1.0), -Vec3::Z), [1.0, 0.25, 0.25]);
        let hits = (0..200).map(|index| HitError {
            normal: Some(f64::from(index) + 0.123_456),
            t_backward: (index < 2).then_some(f64::from(index)),
            ray_point: if index < 5 { f64::NAN } else { 1.0 },
            uv_point: None,
            own_hits: Some([false, true, index % 4 == 0, index % 2 == 0]),
            ..exact
        });
        let row = HitErrorTally(hits.collect()).row();
        assert_eq!(row.normal_error_p99, Some(198.1));
        assert_eq!((row.t_backward_p99, row.uv_point_size_p99), (Some(1.0), None));
        assert_eq!(row.ray_point_scene_p99, None);
        assert_eq!((row.leaving_rays, row.own_hit_offset_per_million), (200, 0.0));
        assert_eq!((row.own_hit_scene_epsilon_per_million, row.own_hit_t_epsilon_per_million), (1e6, 2.5e5));
        assert_eq!(row.own_hit_no_epsilon_per_million, 5e5);
        assert_eq!(HitErrorTally::default().row(), HitErrors::default());
    }
}
