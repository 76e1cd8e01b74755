//! What every kernel must do, whatever its method: rays and primitives that make no sense miss, `t` is a number within
//! the interval, and the sharp cases of the literature come out as pinned here.

mod aim;

use glam::Vec3;
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::{Config, RngSeed, TestRunner};
use raylanes::geom::{Aabb, Hit, Ray, Triangle};
use raylanes::kernels::{Intersect, Kernel};
use raylanes::registry::{self, Visitor};

use aim::Aimed;

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

/// A named case with what each kernel makes of it, in registry order: `+` hit, `.` miss. The first letter is the truth.
struct Case<S> {
    name: &'static str,
    shape: S,
    ray: Ray<f32>,
    expected: &'static str,
}

struct Outcomes<'a, S> {
    case: &'a Case<S>,
    got: String,
}

impl<S: Aimed> Visitor<S> for Outcomes<'_, S> {
    fn visit<K: Kernel<Shape = S>>(&mut self) {
        let hit = Intersect::<f32>::hit(&K::prepare(&self.case.shape), &self.case.ray);
        self.got.push(if hit.mask { '+' } else { '.' });
    }
}

const fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

fn ray(origin: Vec3, dir: Vec3) -> Ray<f32> {
    Ray::new(origin, dir)
}

/// Slab cases of the literature. A wrong outcome is pinned too, so that an improvement shows.
fn box_cases() -> Vec<Case<Aabb>> {
    let unit = Aabb { lo: Vec3::ZERO, hi: Vec3::ONE };
    let flat = Aabb { lo: v(0.5, 0.0, 0.0), hi: v(0.5, 1.0, 1.0) };
    // Truth, then division, reciprocal, sign_selected, fused, padded.
    vec![
        Case { name: "on the lower plane", shape: unit, ray: ray(v(0.0, 0.5, -1.0), Vec3::Z), expected: "+..+++" },
        Case {
            name: "on the lower plane, negative zero",
            shape: unit,
            ray: ray(v(0.0, 0.5, -1.0), v(-0.0, -0.0, 1.0)),
            expected: "+..+++",
        },
        Case { name: "on the upper plane", shape: unit, ray: ray(v(1.0, 0.5, -1.0), Vec3::Z), expected: "+.++++" },
        Case {
            name: "on the upper plane, negative zero",
            shape: unit,
            ray: ray(v(1.0, 0.5, -1.0), v(-0.0, 0.0, 1.0)),
            expected: "+.++++",
        },
        Case {
            name: "inside, negative zero",
            shape: unit,
            ray: ray(v(0.5, 0.5, -1.0), v(-0.0, -0.0, 1.0)),
            expected: "+.++++",
        },
        Case { name: "on a lower plane in y", shape: unit, ray: ray(v(0.5, 0.0, -1.0), Vec3::Z), expected: "+..+++" },
        Case { name: "past the edge", shape: unit, ray: ray(v(-5.0, 1.0, -1.0), v(1.0, 0.0, 1.0)), expected: "......" },
        Case { name: "starts on the exit", shape: unit, ray: ray(v(0.5, 0.5, 1.0), Vec3::Z), expected: "++++++" },
        Case { name: "empty", shape: Aabb::EMPTY, ray: ray(v(0.5, 0.5, -1.0), Vec3::Z), expected: "......" },
        Case { name: "flat, within its plane", shape: flat, ray: ray(v(0.5, 0.5, -1.0), Vec3::Z), expected: "+.++++" },
    ]
}

/// Triangle cases of the literature.
fn triangle_cases() -> Vec<Case<Triangle>> {
    let corner = |s: f32| Triangle { v0: Vec3::ZERO, v1: v(s, 0.0, 0.0), v2: v(0.0, s, 0.0) };
    let legs = |s: f32| ray(v(s / 4.0, s / 4.0, -s), v(0.0, 0.0, s));
    let thin = |y: f32| v(-1_113.454_6, y, -56.243_19);
    let fma = ray(v(-6.75, -9.75, 8.0), v(0.875, 1.25, -1.0));
    // Truth, then cramer, moller_trumbore, kensler_shirley, baldwin_weber, pluecker, woop, woop_half_open, woop_dop,
    // moller_trumbore_f64.
    vec![
        Case {
            name: "epsilons lose small triangles",
            shape: corner(2e-4),
            ray: ray(v(2e-4 / 3.0, 2e-4 / 3.0, -1.0), Vec3::Z),
            expected: "++++++++++",
        },
        Case {
            name: "zero area",
            shape: Triangle { v0: thin(-79.049_614), v1: thin(-87.092_27), v2: thin(-79.209_015) },
            ray: ray(v(-1_081.479_2, 99.999_954, 87.770_11), v(-32.107_3, -183.355_87, -144.607_64)),
            expected: "..........",
        },
        Case {
            name: "exactly on a shared edge, lower right",
            shape: Triangle { v0: v(-5.0, -5.0, 0.0), v1: v(5.0, -5.0, 0.0), v2: v(5.0, 5.0, 0.0) },
            ray: fma,
            expected: "++++++...+",
        },
        Case {
            name: "exactly on a shared edge, upper left",
            shape: Triangle { v0: v(-5.0, -5.0, 0.0), v1: v(5.0, 5.0, 0.0), v2: v(-5.0, 5.0, 0.0) },
            ray: fma,
            expected: "++++++++++",
        },
        Case {
            name: "leg 1e-13: the reciprocal of the determinant overflows",
            shape: corner(1e-13),
            ray: legs(1e-13),
            expected: "++..+.++++",
        },
        Case { name: "leg 1e15: determinants overflow", shape: corner(1e15), ray: legs(1e15), expected: "+...+.++++" },
    ]
}

/// Where in the lists the kernels stand that need fused multiply-add, and are absent without it.
const FUSED_BOX: usize = 3;
const FUSED_TRIANGLE: usize = 7;

fn expected<S>(case: &Case<S>, fused: usize) -> String {
    let outcomes = case.expected[1..].char_indices();
    outcomes.filter(|&(index, _)| cfg!(fused) || index != fused).map(|(_, outcome)| outcome).collect()
}

#[test]
fn sharp_boxes() {
    let mut wrong = Vec::new();
    for case in &box_cases() {
        let mut outcomes = Outcomes { case, got: String::new() };
        registry::boxes(&mut outcomes);
        if outcomes.got != expected(case, FUSED_BOX) {
            wrong.push(format!("{}: {} instead of {}", case.name, outcomes.got, expected(case, FUSED_BOX)));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn sharp_triangles() {
    let mut wrong = Vec::new();
    for case in &triangle_cases() {
        let mut outcomes = Outcomes { case, got: String::new() };
        registry::triangles(&mut outcomes);
        if outcomes.got != expected(case, FUSED_TRIANGLE) {
            wrong.push(format!("{}: {} instead of {}", case.name, outcomes.got, expected(case, FUSED_TRIANGLE)));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// The first letter of each case is what the oracle says.
#[cfg(feature = "study")]
mod truth {
    use super::*;
    use raylanes::oracle::Exact;

    fn check<S: Aimed + Exact>(cases: &[Case<S>]) {
        for case in cases {
            let truth = if case.shape.truth(&case.ray).hit { "+" } else { "." };
            assert_eq!(truth, &case.expected[..1], "{}", case.name);
        }
    }

    #[test]
    fn sharp_cases_state_the_truth() {
        check(&box_cases());
        check(&triangle_cases());
    }

    #[test]
    fn the_edge_case_is_exactly_on_the_edge() {
        let edges: Vec<_> = triangle_cases().into_iter().filter(|case| case.name.contains("shared edge")).collect();
        assert_eq!(edges.len(), 2);
        for Case { shape, ray, .. } in edges {
            let truth = shape.truth(&ray);
            assert!(truth.hit && truth.boundary && truth.t == 8.0, "{truth:?}");
        }
    }
}

mod instances {
    use super::*;
    use glam::{Affine3, Mat3, Quat};
    use raylanes::geom::Placed;
    use raylanes::kernels::instance::Instance;
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
            let prepared = Instance::<MollerTrumbore<f32>>::prepare(&Placed { shape: TRIANGLE, object_to_world });
            assert!(!Intersect::<f32>::hit(&prepared, &ray(v(0.25, 0.25, -1.0), Vec3::Z)).mask);
        }
    }
}
