//! What every kernel must do, whatever its method: rays and primitives that make no sense miss, and `t` is a number within
//! the interval. Instances keep `t`, `u` and `v` under every transform, and normals turn the right way. Sharp cases are in
//! `cases.rs`.

mod aim;
mod random;

use glam::Vec3;
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::{Config, RngSeed, TestRunner};
use raylanes::geom::{Hit, Ray, Triangle};
use raylanes::kernels::{Intersect, Kernel};
use raylanes::registry::{self, Visitor};

use aim::Aimed;
use random::Random;

/// Corrupts rays and shapes that do hit, one place at a time.
#[derive(Default)]
struct Nonsense {
    hits: u64,
}

impl<S: Aimed> Visitor<S> for Nonsense {
    fn visit<K: Kernel<Shape = S>>(&mut self) {
        let mut runner = TestRunner::new(Config { rng_seed: RngSeed::Fixed(5), ..Config::default() });
        let strategy = aim::cases::<S>();
        let hit = |shape: &S, ray: &Ray<f32>| Intersect::<f32>::hit(&K::prepare(shape), ray);
        let mut hits = 0;
        for _ in 0..400 {
            let case = strategy.new_tree(&mut runner).unwrap().current();
            let shape = case.shapes[0];
            for ray in case.rays.iter().filter(|ray| hit(&shape, ray).mask) {
                hits += 1;
                let expect_miss = |what: &str, shape: &S, ray: &Ray<f32>| {
                    assert_eq!(
                        hit(shape, ray).to_bits(),
                        Hit::MISS.to_bits(),
                        "{}: {what} {ray:?} {shape:?}",
                        K::INFO.id
                    );
                };
                for axis in 0..3 {
                    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
                        let mut bad = *ray;
                        bad.origin[axis] = value;
                        expect_miss("origin", &shape, &bad);
                        let mut bad = *ray;
                        bad.dir[axis] = value;
                        expect_miss("direction", &shape, &bad);
                    }
                }
                expect_miss("zero direction", &shape, &Ray { dir: Vec3::ZERO, ..*ray });
                expect_miss("negative zero direction", &shape, &Ray { dir: -Vec3::ZERO, ..*ray });
                expect_miss("NaN t_min", &shape, &Ray { t_min: f32::NAN, ..*ray });
                expect_miss("NaN t_max", &shape, &Ray { t_max: f32::NAN, ..*ray });
                expect_miss("empty interval", &shape, &Ray { t_min: 2.0, t_max: 1.0, ..*ray });
                expect_miss("inactive", &shape, &Ray { origin: ray.origin, dir: ray.dir, ..Ray::INACTIVE });
                for coordinate in 0..9 {
                    expect_miss("NaN coordinate", &shape.with_coordinate(coordinate, f32::NAN), ray);
                }
            }
        }
        println!("{}: {hits} hits corrupted", K::INFO.id);
        assert!(hits > 200, "{}: only {hits} hits to corrupt", K::INFO.id);
        self.hits += hits;
    }
}

#[test]
fn what_makes_no_sense_misses() {
    let mut nonsense = Nonsense::default();
    registry::all(&mut nonsense);
    assert!(nonsense.hits > 0);
}

const fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

fn ray(origin: Vec3, dir: Vec3) -> Ray<f32> {
    Ray::new(origin, dir)
}

mod instances {
    use super::*;
    use glam::{Affine3, DVec3, Mat3, Quat};
    use raylanes::geom::Placed;
    use raylanes::kernels::instance::{Baked, Instance, SubtractFirstF64};
    use raylanes::kernels::triangle::MollerTrumbore;

    const TRIANGLE: Triangle = Triangle { v0: Vec3::ZERO, v1: v(1.0, 0.0, 0.0), v2: v(0.0, 1.0, 0.0) };

    /// Rotation, shear, non-uniform scale and translation, and the same with a mirror.
    fn transforms() -> [Affine3; 2] {
        let shear = Mat3::from_cols(v(1.0, 0.0, 0.0), v(0.5, 1.0, 0.0), v(0.0, 0.25, 1.0));
        let linear = Mat3::from_quat(Quat::from_rotation_y(0.7)) * shear * Mat3::from_diagonal(v(2.0, 0.5, 3.0));
        let translation = v(10.0, -20.0, 30.0);
        [linear, linear * Mat3::from_diagonal(v(1.0, 1.0, -1.0))].map(|matrix3| Affine3 { matrix3, translation })
    }

    #[test]
    fn t_and_point_are_those_of_the_baked_triangle() {
        for transform in transforms() {
            let baked = Triangle {
                v0: transform.transform_point3(TRIANGLE.v0),
                v1: transform.transform_point3(TRIANGLE.v1),
                v2: transform.transform_point3(TRIANGLE.v2),
            };
            let instance = Instance::new(MollerTrumbore::prepare(&TRIANGLE), transform).unwrap();
            let dir = v(0.3, -1.7, 0.9);
            let ray = ray(baked.point(0.25, 0.5) - dir * 2.0, dir);
            let hit = Intersect::<f32>::hit(&instance, &ray);
            assert!(hit.mask && (hit.t - 2.0).abs() < 1e-5, "{hit:?}");
            assert!((hit.u - 0.25).abs() < 1e-5 && (hit.v - 0.5).abs() < 1e-5, "{hit:?}");
            assert!(ray.at(hit.t).abs_diff_eq(baked.point(hit.u, hit.v), 1e-4));
        }
    }

    #[test]
    fn normals_go_by_the_inverse_transpose_and_the_sign_of_the_determinant() {
        for transform in transforms() {
            let instance = Instance::new(MollerTrumbore::prepare(&TRIANGLE), transform).unwrap();
            let [v0, v1, v2] = TRIANGLE.vertices().map(|vertex| transform.transform_point3(vertex));
            let expected = Triangle { v0, v1, v2 }.normal();
            let got = instance.normal_to_world(TRIANGLE.normal());
            assert!(got.abs_diff_eq(expected, 1e-6), "{got} instead of {expected}");
        }
    }

    /// The third column is the sum of the others, exactly; of 23 bits each, so that their determinant has to be rounded.
    fn exactly_singular(random: &mut Random) -> Affine3 {
        let mut column = || Vec3::from([(); 3].map(|()| (random.below(1 << 23) as f32 + 1.0) / (1 << 25) as f32));
        let (x, y) = (column(), column());
        let z = x + y;
        assert!(z - x == y && z - y == x, "a sum that is rounded: {x} {y}");
        Affine3 { matrix3: Mat3::from_cols(x, y, z), translation: v(1.0, 2.0, 3.0) }
    }

    #[test]
    fn exactly_singular_transforms_are_refused_whatever_rounding_makes_of_their_determinant() {
        let mut random = Random(1);
        let mut rounded = 0;
        for _ in 0..2000 {
            let transform = exactly_singular(&mut random);
            rounded += u32::from(transform.matrix3.as_dmat3().determinant() != 0.0);
            let error = Instance::new((), transform).unwrap_err();
            assert_eq!(error.transform, transform);
            let placed = Placed { shape: TRIANGLE, object_to_world: transform };
            let ray = ray(transform.transform_point3(v(0.25, 0.25, 0.0)) - Vec3::Z, Vec3::Z);
            assert!(!Intersect::<f32>::hit(&<Baked<MollerTrumbore<f32>>>::prepare(&placed), &ray).mask);
            assert!(!Intersect::<f32>::hit(&<Instance<MollerTrumbore<f32>>>::prepare(&placed), &ray).mask);
        }
        assert!(rounded > 100, "only {rounded} determinants are not zero");
    }

    #[test]
    fn transforms_at_the_edge_of_having_an_inverse() {
        let scale = |factor: f32| Affine3::from_scale(Vec3::splat(factor));
        // The inverse of a scale below 2⁻¹²⁸ is no f32, but an f64.
        let (tiny, least) = (scale(2f32.powi(-129)), scale(2f32.powi(-126)));
        let error = Instance::new((), tiny).unwrap_err().to_string();
        assert!(error.starts_with("transform has no inverse: columns [[1.4"), "{error}");
        assert!(Instance::new((), least).is_ok() && Instance::new((), scale(f32::MAX)).is_ok());
        let placed = Placed { shape: TRIANGLE, object_to_world: tiny };
        let ray = ray(v(0.25, 0.25, -1.0) * 2f32.powi(-129), v(0.0, 0.0, 2f32.powi(-129)));
        let double = <Instance<MollerTrumbore<f32>, SubtractFirstF64<DVec3>>>::prepare(&placed);
        assert_eq!(Intersect::<f32>::hit(&double, &ray).t, 1.0);
        assert!(!Intersect::<f32>::hit(&<Instance<MollerTrumbore<f32>>>::prepare(&placed), &ray).mask);
        // As nearly singular as columns of about unit size can be: an angle of one unit in the last place.
        let nearly = Mat3::from_cols(v(1.0, 1.0, 0.0), v(1.0, 1f32.next_up(), 0.0), Vec3::Z);
        let instance = Instance::new((), Affine3 { matrix3: nearly, ..Affine3::IDENTITY }).unwrap();
        assert_eq!(
            instance.ray_to_object(&super::ray(v(1.0, 1.0, 1.0), v(0.0, f32::EPSILON, 0.0))).origin,
            v(1.0, 0.0, 1.0)
        );
    }

    #[test]
    fn transforms_without_inverse_are_refused() {
        let identity = Affine3::IDENTITY;
        let flat = Affine3 { matrix3: Mat3::from_diagonal(v(1.0, 0.0, 1.0)), ..identity };
        let dependent = Affine3 { matrix3: Mat3::from_cols(Vec3::X, Vec3::X, Vec3::Z), ..identity };
        let infinite = Affine3 { matrix3: Mat3::from_diagonal(v(f32::INFINITY, 1.0, 1.0)), ..identity };
        let nan = Affine3 { translation: v(0.0, f32::NAN, 0.0), ..identity };
        for object_to_world in [flat, dependent, infinite, nan] {
            let error = Instance::new(MollerTrumbore::prepare(&TRIANGLE), object_to_world).unwrap_err();
            assert!(error.to_string().starts_with("transform has no inverse"), "{error}");
            let prepared = <Instance<MollerTrumbore<f32>>>::prepare(&Placed { shape: TRIANGLE, object_to_world });
            assert!(!Intersect::<f32>::hit(&prepared, &ray(v(0.25, 0.25, -1.0), Vec3::Z)).mask);
        }
    }
}
