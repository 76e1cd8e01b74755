//! Traits of the hits of the given rays: distances against sizes, angles, determinants.
//!
//! The closest hits are those of the exact kernel, also for rays that ask for any hit.

use glam::{DAffine3, DVec3, Vec3};
use rayon::prelude::*;

use super::{HIGH, LOW, Trait, percent_of, quantile};
use crate::geom::{Hit, Quadric, Ray, Triangle};
use crate::study::figures::number;
use crate::study::measure::built_scene::TracerKernel;
use crate::study::measure::ray_sets::RaySet;
use crate::tracer::{Leaving, Mode, Scene, trace};

/// The limit of the distance of a hit, in longest edges of its triangle. Regimes: triangle, distance, and triangle,
/// horizon. In the latter only kernels with watertight edges count: the others fail from the first step on.
const MAX_DISTANCE: f64 = 1e3;

/// The same from below. Regime: triangle, ground.
const MIN_DISTANCE: f64 = 1e-3;

/// The limit of the cosine between ray and normal of a triangle. Regime: triangle, grazing.
const MIN_COSINE: f64 = 1e-3;

/// The limit of the determinant, `n·d` with the cross product `n` of two edges and the ray's direction `d`. It is the
/// epsilon of `triangle/moller_trumbore_epsilon`, and explains the regime triangle, scale.
const MIN_DETERMINANT: f64 = 1e-6;

/// The limit of the distance of a ray's origin to the middle of a quadric's box, in the shortest half axes of the box.
/// Regime: quadric, afar.
const MAX_QUADRIC_DISTANCE: f64 = 1e1;

/// The limit of the distance of a hit, in the longest half axes of a quadric's box. Regime: quadric, near huge, where
/// kernels fail from a height of 0.001 on, above a radius of 8192.
const MIN_QUADRIC_DISTANCE: f64 = 0.01 / 8192.0;

/// The limit of the coefficient of t², `d·Md` for unit `d`, by the norm of `M`. Regime: quadric, parabolic, where it is
/// the square of the angle by √2, and the last harmless angle is 0.01. In the regime quadric, generatrix, it is about
/// the angle, and the last harmless one is 1e-4.
const MIN_SQUARE: f64 = 1e-4 / std::f64::consts::SQRT_2;

/// A hit in the coordinates of its geometry.
enum Measured {
    Triangle {
        /// Distance of the hit by the longest edge.
        distance: f64,
        /// Cosine between ray and normal: not negative.
        cosine: f64,
        /// Size of the determinant.
        determinant: f64,
    },
    Quadric {
        /// Distance of the origin by the shortest half axis of the box.
        far: f64,
        /// Distance of the hit by the longest half axis of the box.
        near: f64,
        /// See [`MIN_SQUARE`].
        square: f64,
    },
}

impl Measured {
    fn triangle(triangle: &Triangle, dir: DVec3, t: f64) -> Self {
        let [v0, v1, v2] = triangle.vertices().map(Vec3::as_dvec3);
        let normal = (v1 - v0).cross(v2 - v0);
        let longest = (v1 - v0).length().max((v2 - v0).length()).max((v2 - v1).length());
        let determinant = normal.dot(dir).abs();
        Self::Triangle {
            distance: t * dir.length() / longest,
            cosine: determinant / (normal.length() * dir.length()),
            determinant,
        }
    }

    /// None for planes, which have no t².
    fn quadric(quadric: &Quadric, [origin, dir]: [DVec3; 2], t: f64) -> Option<Self> {
        let matrix = quadric.matrix();
        let norm = matrix.to_cols_array().map(|entry| entry * entry).iter().sum::<f64>().sqrt();
        let half = quadric.clip.extent().as_dvec3() / 2.0;
        (norm > 0.0).then(|| Self::Quadric {
            far: origin.distance(quadric.clip.center().as_dvec3()) / half.min_element(),
            near: t * dir.length() / half.max_element(),
            square: dir.dot(matrix * dir).abs() / (norm * dir.length_squared()),
        })
    }
}

/// The traits of the hits of all rays. Those of triangles, or of quadrics, are left out if none is hit.
pub(super) fn traits(scene: &Scene<TracerKernel>, sets: &[RaySet]) -> Vec<Trait> {
    let to_object: Vec<_> =
        scene.world().instances().iter().map(|placement| placement.object_to_world.as_daffine3().inverse()).collect();
    let mut measured = Vec::new();
    for set in sets {
        let hits = trace(scene, &set.rays, Mode::Auto);
        let hits = set.rays.par_iter().zip(&hits).filter(|(_, hit)| hit.mask);
        measured.par_extend(hits.filter_map(|(ray, hit)| measure(scene, &to_object, ray, hit)));
    }
    let mut triangles = [const { Vec::new() }; 3];
    let mut quadrics = [const { Vec::new() }; 3];
    for hit in measured {
        let (columns, values) = match hit {
            Measured::Triangle { distance, cosine, determinant } => (&mut triangles, [distance, cosine, determinant]),
            Measured::Quadric { far, near, square } => (&mut quadrics, [far, near, square]),
        };
        columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
    }
    let mut traits = Vec::new();
    let [distances, cosines, determinants] = triangles;
    if !distances.is_empty() {
        traits.extend(of_distances(distances));
        traits.push(grazing(cosines));
        traits.push(determinant(determinants));
    }
    let [far, near, squares] = quadrics;
    if !far.is_empty() {
        traits.extend(of_quadrics(far, near, squares));
    }
    traits
}

fn measure(scene: &Scene<TracerKernel>, to_object: &[DAffine3], ray: &Ray<f32>, hit: &Hit<f32>) -> Option<Measured> {
    let transform = &to_object[hit.instance as usize];
    let dir = transform.transform_vector3(ray.dir.as_dvec3());
    match scene.shape_of(hit) {
        Leaving::Triangle(triangle) => Some(Measured::triangle(&triangle, dir, hit.t.into())),
        Leaving::Quadric(quadric) => {
            let origin = transform.transform_point3(ray.origin.as_dvec3());
            Measured::quadric(&quadric, [origin, dir], hit.t.into())
        }
    }
}

fn of_distances(mut distances: Vec<f64>) -> [Trait; 2] {
    let [low, median, high] = [LOW, 0.5, HIGH].map(|share| quantile(&mut distances, share));
    [
        Trait::above(
            MAX_DISTANCE,
            "small triangles far away",
            high,
            format!(
                "hits are {} longest edges of their triangle away in the median, {} at 99.9 %",
                number(median, 2),
                number(high, 2)
            ),
            "in the difference of vertex and ray origin, the triangle is lost to rounding",
        ),
        Trait::below(
            MIN_DISTANCE,
            "large triangles nearby",
            low,
            format!("one hit in 1,000 is less than {} longest edges of its triangle away", number(low, 2)),
            "figures computed from far vertices lose a near hit; prepared planes keep it",
        ),
    ]
}

fn grazing(mut cosines: Vec<f64>) -> Trait {
    let [few, fewer] = [1e-2, 1e-4].map(|limit| percent_of(&cosines, |cosine| cosine < limit));
    let low = quantile(&mut cosines, LOW);
    Trait::below(
        MIN_COSINE,
        "grazing rays",
        low,
        format!(
            "|cos| between ray and normal: {few} of the hits are below 0.01, {fewer} below 0.0001, and one in 1,000 \
             below {}",
            number(low, 2)
        ),
        "the determinant is a small difference of large numbers",
    )
}

fn determinant(mut determinants: Vec<f64>) -> Trait {
    let low = quantile(&mut determinants, LOW);
    Trait::below(
        MIN_DETERMINANT,
        "small determinants",
        low,
        format!("one hit in 1,000 has a determinant below {}", number(low, 2)),
        "a kernel with an absolute epsilon takes the ray for parallel and loses the hit",
    )
}

fn of_quadrics(mut far: Vec<f64>, mut near: Vec<f64>, mut squares: Vec<f64>) -> [Trait; 3] {
    let (high, low, square) = (quantile(&mut far, HIGH), quantile(&mut near, LOW), quantile(&mut squares, LOW));
    [
        Trait::above(
            MAX_QUADRIC_DISTANCE,
            "small quadrics far away",
            high,
            format!("rays at quadrics start up to {} half axes away at 99.9 %", number(high, 2)),
            "the discriminant cancels: the square of the distance hides that of the size",
        ),
        Trait::below(
            MIN_QUADRIC_DISTANCE,
            "large quadrics nearby",
            low,
            format!("one hit in 1,000 on quadrics is less than {} half axes away", number(low, 2)),
            "the constant cancels, so a ray next to the surface is put on its other side",
        ),
        Trait::below(
            MIN_SQUARE,
            "rays along the axis of quadrics",
            square,
            format!("one hit in 1,000 on quadrics has a relative coefficient of t² below {}", number(square, 2)),
            "the coefficient of t² is nearly zero, and one root goes to infinity",
        ),
    ]
}
