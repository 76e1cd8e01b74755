//! Transformed shapes.

use glam::{Affine3, DMat3, Mat3, Vec3};
use rand::RngExt;
use rand_pcg::Pcg64;

use super::{Axis, FailureMap, Regime, Sample, Subject, Workload, direction, frame, in_cube};
use crate::geom::{Placed, Ray};
use crate::oracle::Exact;
use crate::registry::Registered;

impl<S: Subject> Subject for Placed<S>
where
    Placed<S>: Exact + Registered,
{
    const MESH: bool = S::MESH;

    const REGIMES: &'static [Regime<Self>] = &[
        Regime {
            name: "translation",
            about: "Shape and ray, turned and moved ever farther from the world's origin: what is rounded there before it is \
                    subtracted loses its digits.",
            axis: "distance of the shape to the world's origin / its size",
            steps: &[1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6],
            mesh: false,
            sample: |offset, rng| placed(frame(rng), direction(rng) * offset, rng),
        },
        Regime {
            name: "scale_ratio",
            about: "Shapes made ever flatter by different scales along their axes, and then turned: the inverse stretches the \
                    rounding of the ray's origin.",
            axis: "greatest / least scale",
            steps: &[1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6],
            mesh: false,
            sample: |ratio, rng| {
                let scales = [1.0, 1.0 / ratio.sqrt(), 1.0 / ratio];
                let first = rng.random_range(0..3);
                let scales = Vec3::from([0, 1, 2].map(|axis| scales[(first + axis) % 3]));
                placed(frame(rng) * Mat3::from_diagonal(scales), in_cube(rng, 1.0), rng)
            },
        },
        Regime {
            name: "shear",
            about: "Shapes turned, ever more sheared, and turned again: the rounding of the inverse itself turns the ray, even more \
                    where it is inverted in f32.",
            axis: "condition number of the transform",
            steps: &[1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6],
            mesh: false,
            sample: |condition, rng| placed(sheared(condition, rng), in_cube(rng, 1.0), rng),
        },
    ];

    const MAPS: &'static [FailureMap<Self>] = &[FailureMap {
        name: "translation-shear",
        x: Axis { title: "distance to the world's origin / size", start: 1.0, quarters: 24 },
        y: Axis { title: "condition number", start: 1.0, quarters: 24 },
        sample: |[offset, condition], rng| placed(sheared(condition, rng), direction(rng) * offset, rng),
    }];

    fn title() -> String {
        format!("instance of {}", S::FAMILY)
    }

    /// The inner shape's sample, stretched, sheared, turned and moved by up to 100 units; the rays are moved along, so
    /// that they meet what they were aimed at but for rounding. Half of the edge-aimed ones are moved by whole numbers,
    /// where what met an edge exactly still does.
    fn sample(workload: Workload, rng: &mut Pcg64) -> Sample<Self> {
        let inner = S::sample(workload, rng);
        let exact = workload == Workload::Edge && rng.random_bool(0.5);
        let object_to_world = loop {
            let columns = [0; 3].map(|_| in_cube(rng, if exact { 2.5 } else { 1.0 }));
            let matrix3 = Mat3::from_cols(columns[0], columns[1], columns[2]) + Mat3::IDENTITY;
            let transform = Affine3 { matrix3, translation: in_cube(rng, 100.0) };
            let transform = if exact { rounded(transform) } else { transform };
            // Not nearly singular: that regime has a study of its own.
            if transform.matrix3.determinant().abs() > 0.1 {
                break transform;
            }
        };
        moved(inner, object_to_world)
    }
}

/// Shape and rays of a sample, taken to the world: the rays to `f32`, so that they meet what they were aimed at but for
/// rounding.
fn moved<S>(inner: Sample<S>, object_to_world: Affine3) -> Sample<Placed<S>> {
    let place = |ray: &Ray<f32>| Ray {
        origin: object_to_world.transform_point3(ray.origin),
        dir: object_to_world.transform_vector3(ray.dir),
        t_min: ray.t_min,
        t_max: ray.t_max,
    };
    Sample {
        rays: inner.rays.iter().map(place).collect(),
        shapes: inner.shapes.into_iter().map(|shape| Placed { shape, object_to_world }).collect(),
    }
}

/// An easy sample, transformed.
fn placed<S: Subject>(matrix3: Mat3, translation: Vec3, rng: &mut Pcg64) -> Sample<Placed<S>> {
    moved(S::easy(rng), Affine3 { matrix3, translation })
}

/// A shear of this condition number between two rotations, so that no axis of either space is that of the shear.
fn sheared(condition: f32, rng: &mut Pcg64) -> Mat3 {
    let mut shear = DMat3::IDENTITY;
    // The singular values are 1, and those of a shear in the plane: s and 1/s where the factor is s - 1/s.
    let greatest = f64::from(condition).sqrt();
    shear.y_axis.x = greatest - 1.0 / greatest;
    (frame(rng).as_dmat3() * shear * frame(rng).as_dmat3()).as_mat3()
}

fn rounded(Affine3 { matrix3, translation }: Affine3) -> Affine3 {
    let Mat3 { x_axis, y_axis, z_axis } = matrix3;
    Affine3 {
        matrix3: Mat3::from_cols(x_axis.round(), y_axis.round(), z_axis.round()),
        translation: translation.round(),
    }
}
