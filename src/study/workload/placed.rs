//! Inputs for instances: the easy samples of a shape, under transforms that get harder.

use glam::{Affine3, DMat3, Mat3, Vec3};
use rand::RngExt;
use rand_pcg::Pcg64;

use super::{Axis, Counts, FailureMap, Primitive, Regime, Sample, Subject, Workload, direction, frame, in_cube};
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
            about: "Shape and ray, rotated and moved ever farther from the world's origin. Code that rounds \
                    coordinates before it subtracts the translation loses digits.",
            axis: "distance of the shape to the world's origin / its size",
            steps: &[1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6],
            counts: Counts::Tests,
            sample: |offset, rng| placed(frame(rng), direction(rng) * offset, rng),
        },
        Regime {
            name: "scale_ratio",
            about: "Shapes scaled by ever more different factors along their axes, and then rotated. The inverse \
                    enlarges the rounding error of the ray's origin.",
            axis: "greatest / least scale",
            steps: &[1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6],
            counts: Counts::Tests,
            sample: |ratio, rng| {
                let scales = [1.0, 1.0 / ratio.sqrt(), 1.0 / ratio];
                let first = rng.random_range(0..3);
                let scales = Vec3::from([0, 1, 2].map(|axis| scales[(first + axis) % 3]));
                placed(frame(rng) * Mat3::from_diagonal(scales), in_cube(rng, 1.0), rng)
            },
        },
        Regime {
            name: "shear",
            about: "Shapes rotated, ever more sheared, and rotated again. The rounding of the inverse turns the ray, \
                    and it turns the ray more where the inverse is computed in f32.",
            axis: "condition number of the transform",
            steps: &[1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6],
            counts: Counts::Tests,
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

    fn primitive(&self) -> Placed<Primitive> {
        Placed { object_to_world: self.object_to_world, ..self.shape.primitive() }
    }

    /// The sample of the inner shape, scaled, sheared, rotated and moved by up to 100 units. The rays move with the
    /// shape, so they meet their targets up to rounding. Half of the edge-aimed samples use transforms of whole
    /// numbers: a ray that meets an edge exactly then still does.
    fn sample(workload: Workload, rng: &mut Pcg64) -> Sample<Self> {
        let inner = S::sample(workload, rng);
        let exact = workload == Workload::Edge && rng.random_bool(0.5);
        let object_to_world = loop {
            let columns = [0; 3].map(|_| in_cube(rng, if exact { 2.5 } else { 1.0 }));
            let matrix3 = Mat3::from_cols(columns[0], columns[1], columns[2]) + Mat3::IDENTITY;
            let transform = Affine3 { matrix3, translation: in_cube(rng, 100.0) };
            let transform = if exact { rounded(transform) } else { transform };
            // Nearly singular transforms have regimes of their own.
            if transform.matrix3.determinant().abs() > 0.1 {
                break transform;
            }
        };
        moved(inner, object_to_world)
    }
}

/// Shape and rays of a sample, transformed to the world. The rays are rounded to `f32`, so they meet their targets up
/// to rounding.
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

/// An easy sample under this transform.
fn placed<S: Subject>(matrix3: Mat3, translation: Vec3, rng: &mut Pcg64) -> Sample<Placed<S>> {
    moved(S::easy(rng), Affine3 { matrix3, translation })
}

/// A shear of this condition number between two rotations: the shear is along no axis of either space.
fn sheared(condition: f32, rng: &mut Pcg64) -> Mat3 {
    let mut shear = DMat3::IDENTITY;
    // The singular values are 1, s and 1/s, if the factor of the shear is s - 1/s.
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
