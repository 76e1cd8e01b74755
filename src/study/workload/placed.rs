//! Transformed shapes.

use glam::{Affine3, Mat3};
use rand::RngExt;
use rand_pcg::Pcg64;

use super::{FailureMap, Regime, Sample, Subject, Workload, in_cube};
use crate::geom::{Placed, Ray};
use crate::oracle::Exact;
use crate::registry::Registered;

impl<S: Subject> Subject for Placed<S>
where
    Placed<S>: Exact + Registered,
{
    const MESH: bool = S::MESH;
    const REGIMES: &'static [Regime<Self>] = &[];
    const MAPS: &'static [FailureMap<Self>] = &[];

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
}

fn rounded(Affine3 { matrix3, translation }: Affine3) -> Affine3 {
    let Mat3 { x_axis, y_axis, z_axis } = matrix3;
    Affine3 {
        matrix3: Mat3::from_cols(x_axis.round(), y_axis.round(), z_axis.round()),
        translation: translation.round(),
    }
}
