//! Tests of what the kernels of one family have in common.
//!
//! Instances keep `t`, `u` and `v` under every transform, and their normals point the right way. Quadrics are hit at
//! known points, inside their box. Sharp cases are in `cases.rs`. `twins.rs` tests that invalid rays and primitives
//! miss.

use glam::Vec3;
use raylanes::conformance::{Case, Random};
use raylanes::geom::{Hit, Placed, Quadric, Ray, Triangle};
use raylanes::kernels::{Intersect, Kernel};
use raylanes::registry::{self, Visitor};

const fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

fn ray(origin: Vec3, dir: Vec3) -> Ray<f32> {
    Ray::new(origin, dir)
}

mod instances {
    use super::*;
    use glam::{Affine3, DVec3, Mat3, Quat};
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
    fn an_instance_has_the_hit_of_the_transformed_triangle() {
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
    fn normals_use_the_inverse_transpose_and_the_sign_of_the_determinant() {
        for transform in transforms() {
            let instance = Instance::new(MollerTrumbore::prepare(&TRIANGLE), transform).unwrap();
            let [v0, v1, v2] = TRIANGLE.vertices().map(|vertex| transform.transform_point3(vertex));
            let expected = Triangle { v0, v1, v2 }.normal();
            let got = instance.normal_to_world(TRIANGLE.normal());
            assert!(got.abs_diff_eq(expected, 1e-6), "{got} instead of {expected}");
        }
    }

    /// A matrix whose third column is exactly the sum of the others. The entries have 23 bits: `f64` rounds the
    /// determinant.
    fn exactly_singular(random: &mut Random) -> Affine3 {
        let mut column = || Vec3::from([(); 3].map(|()| (random.below(1 << 23) as f32 + 1.0) / (1 << 25) as f32));
        let (x, y) = (column(), column());
        let z = x + y;
        assert!(z - x == y && z - y == x, "the sum of {x} and {y} is rounded");
        Affine3 { matrix3: Mat3::from_cols(x, y, z), translation: v(1.0, 2.0, 3.0) }
    }

    #[test]
    fn exactly_singular_transforms_are_refused_also_where_the_determinant_is_not_zero() {
        let mut random = Random::from_seed(1);
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
        assert!(rounded > 100, "only {rounded} determinants are not zero in f64");
    }

    #[test]
    fn nearly_singular_transforms_have_an_inverse() {
        let scale = |factor: f32| Affine3::from_scale(Vec3::splat(factor));
        // The inverse of a scale below 2⁻¹²⁸ is beyond f32, but not beyond f64.
        let (tiny, least) = (scale(2f32.powi(-129)), scale(2f32.powi(-126)));
        let error = Instance::new((), tiny).unwrap_err().to_string();
        assert!(error.starts_with("transform has no inverse: columns [[1.4"), "{error}");
        assert!(Instance::new((), least).is_ok() && Instance::new((), scale(f32::MAX)).is_ok());
        let placed = Placed { shape: TRIANGLE, object_to_world: tiny };
        let ray = ray(v(0.25, 0.25, -1.0) * 2f32.powi(-129), v(0.0, 0.0, 2f32.powi(-129)));
        let double = <Instance<MollerTrumbore<f32>, SubtractFirstF64<DVec3>>>::prepare(&placed);
        assert_eq!(Intersect::<f32>::hit(&double, &ray).t, 1.0);
        assert!(!Intersect::<f32>::hit(&<Instance<MollerTrumbore<f32>>>::prepare(&placed), &ray).mask);
        // Columns of about unit size cannot be closer to singular: one ulp of angle.
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

mod quadrics {
    use super::*;
    use glam::Vec2;
    use raylanes::geom::Aabb;
    use raylanes::kernels::aabb::Padded;

    /// A surface, a ray, and where it hits, if it does.
    type Known = (Quadric, Ray<f32>, Option<f32>);

    /// The eight kinds: from outside, from inside, and where the box clips the surface. Distances are whole numbers.
    fn known() -> Vec<Known> {
        let abc = v(2.0, 3.0, 4.0);
        let bowl = Quadric { clip: Aabb { lo: Vec3::splat(-3.0), hi: v(3.0, 3.0, 0.0) }, ..Quadric::sphere(2.0) };
        let nothing = Quadric { squares: Vec3::ZERO, constant: 0.0, ..Quadric::sphere(2.0) };
        let plane = Quadric { linear: Vec3::Z, ..nothing };
        let saddle = Quadric { products: Vec3::Z, linear: Vec3::NEG_Z, ..nothing };
        let unclipped = Aabb { lo: Vec3::NEG_INFINITY, hi: Vec3::INFINITY };
        let mut known = Vec::new();
        let mut add = |quadric, origin, dir, t| known.push((quadric, ray(origin, dir), t));

        add(Quadric::sphere(2.0), v(-5.0, 0.0, 0.0), Vec3::X, Some(3.0));
        add(Quadric::sphere(2.0), Vec3::ZERO, v(0.0, 0.0, -2.0), Some(1.0));
        add(Quadric::ellipsoid(abc), v(0.0, -9.0, 0.0), Vec3::Y, Some(6.0));
        add(Quadric::ellipsoid(abc), Vec3::ZERO, Vec3::Z, Some(4.0));
        add(Quadric::cylinder(2.0, 5.0), v(5.0, 0.0, 5.0), Vec3::NEG_X, Some(3.0));
        add(Quadric::cylinder(2.0, 5.0), v(0.0, 0.0, 4.0), Vec3::Y, Some(2.0));
        add(Quadric::cone(2.0, 4.0), v(5.0, 0.0, 2.0), Vec3::NEG_X, Some(4.0));
        add(Quadric::cone(2.0, 4.0), v(0.0, 0.0, 2.0), Vec3::NEG_Y, Some(1.0));
        add(Quadric::cone(2.0, 4.0), v(0.0, 0.0, 3.0), Vec3::NEG_Z, Some(3.0));
        add(Quadric::paraboloid(2.0, 4.0), v(5.0, 0.0, 1.0), Vec3::NEG_X, Some(4.0));
        add(Quadric::paraboloid(2.0, 4.0), v(1.0, 0.0, 9.0), Vec3::NEG_Z, Some(8.0));
        add(Quadric::paraboloid(2.0, 4.0), v(1.0, 0.0, -2.0), Vec3::Z, Some(3.0));
        add(Quadric::elliptic_paraboloid(Vec2::new(2.0, 3.0), 4.0), v(5.0, 0.0, 1.0), Vec3::NEG_X, Some(4.0));
        add(Quadric::elliptic_paraboloid(Vec2::new(2.0, 3.0), 4.0), v(0.0, 0.0, 4.0), Vec3::NEG_Z, Some(4.0));
        add(Quadric::hyperboloid_of_one_sheet(abc, 8.0), v(9.0, 0.0, 0.0), Vec3::NEG_X, Some(7.0));
        add(Quadric::hyperboloid_of_one_sheet(abc, 8.0), Vec3::ZERO, Vec3::Y, Some(3.0));
        add(Quadric::hyperboloid_of_two_sheets(abc, 8.0), Vec3::ZERO, Vec3::Z, Some(4.0));
        add(Quadric::hyperboloid_of_two_sheets(abc, 8.0), v(0.0, 0.0, 20.0), Vec3::NEG_Z, Some(16.0));
        add(saddle, v(1.5, 2.0, 9.0), Vec3::NEG_Z, None);
        add(Quadric { clip: unclipped, ..saddle }, v(1.5, 2.0, 9.0), Vec3::NEG_Z, Some(6.0));

        // A rectangle: from both sides, at its corner, on a slant, from a large distance, beside it and within it.
        let rectangle = Quadric::plane(Vec2::new(2.0, 3.0));
        add(rectangle, v(1.0, 2.0, 9.0), Vec3::NEG_Z, Some(9.0));
        add(rectangle, v(-1.0, 0.5, -4.0), v(0.0, 0.0, 2.0), Some(2.0));
        add(rectangle, v(2.0, -3.0, 5.0), Vec3::NEG_Z, Some(5.0));
        add(rectangle, v(-3.0, 0.0, 4.0), v(1.0, 0.0, -1.0), Some(4.0));
        add(rectangle, v(1.0, -1.0, 1e6), Vec3::NEG_Z, Some(1e6));
        add(rectangle, v(2.001, 0.0, 9.0), Vec3::NEG_Z, None);
        add(rectangle, v(0.0, -3.001, 9.0), Vec3::NEG_Z, None);
        add(rectangle, v(0.0, 0.0, 9.0), Vec3::Z, None);
        add(rectangle, v(0.0, -9.0, 0.0), Vec3::Y, None);

        // The near root is clipped away; the far one is not, or is clipped away too.
        add(bowl, v(0.0, 0.0, 9.0), Vec3::NEG_Z, Some(11.0));
        add(bowl, v(0.0, 0.0, -9.0), Vec3::Z, Some(7.0));
        add(bowl, v(-9.0, 0.0, 1.0), Vec3::X, None);
        add(Quadric::cylinder(2.0, 2.0), v(-4.0, 0.0, -6.0), v(1.0, 0.0, 1.0), Some(6.0));
        add(Quadric::cylinder(2.0, 2.0), v(0.0, 0.0, -6.0), v(1.0, 0.0, 5.0), None);
        // A double cone has two halves. The box keeps one.
        add(Quadric::cone(2.0, 4.0), v(5.0, 0.0, -2.0), Vec3::NEG_X, None);

        // Within a plane, along a cylinder, and without any surface.
        add(plane, v(-9.0, 0.0, 0.0), Vec3::X, None);
        add(plane, v(0.0, 0.0, -9.0), Vec3::Z, Some(9.0));
        add(Quadric::cylinder(2.0, 5.0), v(0.5, 0.0, -9.0), Vec3::Z, None);
        add(Quadric::cylinder(2.0, 5.0), v(2.0, 0.0, -9.0), Vec3::Z, None);
        add(nothing, v(0.0, 0.0, -9.0), Vec3::Z, None);
        add(Quadric { constant: 1.0, ..nothing }, v(0.0, 0.0, -9.0), Vec3::Z, None);
        add(Quadric { clip: Aabb::EMPTY, ..Quadric::sphere(2.0) }, v(-5.0, 0.0, 0.0), Vec3::X, None);
        add(Quadric { constant: f32::NEG_INFINITY, ..Quadric::sphere(2.0) }, v(-5.0, 0.0, 0.0), Vec3::X, None);

        // Intervals are closed, and may be behind the origin.
        let sphere = |origin, t_min, t_max, t| (Quadric::sphere(2.0), Ray { t_min, t_max, ..ray(origin, Vec3::X) }, t);
        let origin = v(-5.0, 0.0, 0.0);
        known.extend([
            sphere(origin, 0.0, 3.0, Some(3.0)),
            sphere(origin, 3.0, 3.0, Some(3.0)),
            sphere(origin, 0.0, 2.999_999_8, None),
            sphere(origin, 3.000_000_2, 9.0, Some(7.0)),
            sphere(origin, 7.0, 7.0, Some(7.0)),
            sphere(origin, 7.000_000_5, f32::INFINITY, None),
            sphere(-origin, f32::NEG_INFINITY, f32::INFINITY, Some(-7.0)),
            sphere(-origin, -6.0, 9.0, Some(-3.0)),
            sphere(-origin, 0.0, 9.0, None),
        ]);
        known
    }

    struct AtKnownPoints;
    impl Visitor<Quadric> for AtKnownPoints {
        fn visit<K: Kernel<Shape = Quadric>>(&mut self) {
            for (quadric, ray, expected) in known() {
                let hit: Hit<f32> = K::prepare(&quadric).hit(&ray);
                let case = format!("{}: {quadric:?} {ray:?}: {hit:?}, not {expected:?}", K::INFO.id);
                assert_eq!(hit.mask, expected.is_some(), "{case}");
                assert!(hit.u == 0.0 && hit.v == 0.0, "{case}");
                if let Some(t) = expected {
                    assert!((hit.t - t).abs() <= t.abs() * f32::EPSILON, "{case}");
                    assert!(quadric.value(ray.at(hit.t)).abs() <= 4.0 * f32::EPSILON, "{case}");
                }
            }
        }
    }

    #[test]
    fn every_kind_of_quadric_is_hit_at_known_points() {
        registry::quadrics(&mut AtKnownPoints);
    }

    /// Rays that enter the unit sphere near a point where it touches its box, from `distance` radii away.
    fn from_afar(distance: f32) -> impl Iterator<Item = Ray<f32>> {
        let steps = || (-8i8..=8).map(|step| f32::from(step) / 1024.0);
        let near = steps().flat_map(move |y| steps().map(move |z| v((1.0 - y * y - z * z).sqrt(), y, z)));
        let sides =
            [v(1.0, 1.0, 1.0), v(-1.0, 1.0, 1.0)].into_iter().flat_map(|signs| [(signs, 0), (signs, 1), (signs, 2)]);
        near.flat_map(move |point| sides.clone().map(move |side| (point, side))).flat_map(
            move |(point, (signs, turn))| {
                [v(-1.0, 0.0, 0.0), v(-0.9, 0.3, 0.2), v(-0.7, -0.5, 0.4)].map(|dir| {
                    let turned = |p: Vec3| [p, Vec3::new(p.z, p.x, p.y), Vec3::new(p.y, p.z, p.x)][turn];
                    let [target, dir] = [point, dir].map(|p| turned(p * signs));
                    ray(target - dir * distance, dir)
                })
            },
        )
    }

    struct FromAfar;
    impl Visitor<Quadric> for FromAfar {
        fn visit<K: Kernel<Shape = Quadric>>(&mut self) {
            // The errors of its roots exceed the padding of the box.
            if K::INFO.id.method == "quadric/naive" {
                return;
            }
            let sphere = K::prepare(&Quadric::sphere(1.0));
            for distance in [1e1, 1e3, 1e5] {
                for ray in from_afar(distance) {
                    // If the box clipped this root away, the hit would be on the far side.
                    let hit: Hit<f32> = sphere.hit(&ray);
                    let near = (hit.t - distance).abs() <= 4.0 * f32::EPSILON * distance;
                    assert!(hit.mask && near, "{}: {hit:?}, not {distance} {ray:?}", K::INFO.id);
                }
            }
        }
    }

    #[test]
    fn a_box_does_not_clip_the_surface_that_touches_it() {
        registry::quadrics(&mut FromAfar);
    }

    struct WithinBoxes {
        clamped: u64,
    }
    impl Visitor<Quadric> for WithinBoxes {
        fn visit<K: Kernel<Shape = Quadric>>(&mut self) {
            let mut check = |quadric: &Quadric, ray: &Ray<f32>| {
                let hit: Hit<f32> = K::prepare(quadric).hit(ray);
                if hit.mask {
                    let padded: Hit<f32> = Padded::prepare(&quadric.bounds()).hit(ray);
                    assert!(padded.mask, "{}: a hit outside of the box, {quadric:?} {ray:?}", K::INFO.id);
                    let (entry, exit) = (padded.t, padded.u);
                    let id = K::INFO.id;
                    assert!(entry <= hit.t && hit.t <= exit, "{id}: {hit:?}, box {padded:?} {quadric:?} {ray:?}");
                    // These may have been clamped.
                    self.clamped += u64::from(hit.t == entry && entry > ray.t_min);
                }
            };
            let mut random = Random::from_seed(9);
            for _ in 0..2_000 {
                let case = Case::<Quadric>::random(&mut random);
                case.rays.iter().for_each(|ray| check(&case.shapes[0], ray));
            }
            for distance in [1e4, 1e5] {
                from_afar(distance).for_each(|ray| check(&Quadric::sphere(1.0), &ray));
            }
        }
    }

    #[test]
    fn hits_are_between_entry_and_exit_of_the_box() {
        let mut within = WithinBoxes { clamped: 0 };
        registry::quadrics(&mut within);
        println!("{} hits are at the entry of their box", within.clamped);
        assert!(within.clamped > 100, "only {} hits are at the entry of their box", within.clamped);
    }
}
