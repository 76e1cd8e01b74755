//! Tests of transforms against exact arithmetic.
//!
//! Chains and inverses are compared with products of rational matrices, sines with their series, and normals in the
//! world with cross products of exactly transformed edges.

use dashu_ratio::RBig;
use glam::{Affine3, DAffine2, DAffine3, DMat3, Mat3, Mat4, Vec2, Vec3};
use raylanes::geom::{Axis, Transform2, Transform3, Triangle};
use raylanes::kernels::instance::Instance;

use raylanes::conformance::Random;

/// Half an ulp of a number between 1 and 2.
const HALF_ULP_32: f64 = 1.0 / (1u32 << 24) as f64;
const HALF_ULP_64: f64 = 1.0 / (1u64 << 53) as f64;

fn exact(value: impl Into<f64>) -> RBig {
    RBig::try_from(value.into()).expect("a finite number")
}

fn size(value: RBig) -> RBig {
    if value < RBig::ZERO { -value } else { value }
}

/// The rows of a homogeneous matrix without the last row, which is (0, …, 0, 1): two rows in the plane, three in space.
type Rows = Vec<Vec<RBig>>;

fn rows3(matrix: &DAffine3) -> Rows {
    let row = |axis| matrix.matrix3.row(axis).extend(matrix.translation[axis]).to_array().map(exact).to_vec();
    [0, 1, 2].map(row).to_vec()
}

fn rows2(matrix: &DAffine2) -> Rows {
    let row = |axis| matrix.matrix2.row(axis).extend(matrix.translation[axis]).to_array().map(exact).to_vec();
    [0, 1].map(row).to_vec()
}

fn product(a: &Rows, b: &Rows) -> Rows {
    let n = a.len();
    let entry = |row: usize, column: usize| {
        let sum = (0..n).map(|k| &a[row][k] * &b[k][column]).fold(RBig::ZERO, |sum, term| sum + term);
        if column == n { sum + &a[row][n] } else { sum }
    };
    (0..n).map(|row| (0..=n).map(|column| entry(row, column)).collect()).collect()
}

fn absolute(rows: &Rows) -> Rows {
    rows.iter().map(|row| row.iter().cloned().map(size).collect()).collect()
}

fn identity(n: usize) -> Rows {
    (0..n).map(|row| (0..=n).map(|column| exact(f64::from(u8::from(row == column)))).collect()).collect()
}

/// Random parameters. If `dyadic`: whole numbers, powers of two and right angles, whose products have few digits.
struct Parameters {
    random: Random,
    dyadic: bool,
}

impl Parameters {
    fn number(&mut self) -> f32 {
        if self.dyadic { self.random.below(9) as f32 - 4.0 } else { self.random.below(2001) as f32 * 0.003 - 3.0 }
    }

    fn factor(&mut self) -> f32 {
        let sign = if self.random.below(2) == 0 { 1.0 } else { -1.0 };
        sign * if self.dyadic { [0.25, 0.5, 1.0, 2.0][self.random.below(4)] } else { self.number().abs() + 0.1 }
    }

    fn degrees(&mut self) -> f32 {
        if self.dyadic { self.random.below(16) as f32 * 90.0 - 720.0 } else { self.number() * 400.0 }
    }

    /// An axis of any length. If `dyadic`, it is along x, y or z.
    fn axis(&mut self) -> Vec3 {
        if self.dyadic {
            return [Vec3::X, Vec3::Y, Vec3::Z][self.random.below(3)] * self.factor();
        }
        Vec3::from([(); 3].map(|()| self.factor())) * [1.0, 1e-30, 1e30][self.random.below(3)]
    }

    fn transform3(&mut self) -> Transform3 {
        match self.random.below(8) {
            0 => Transform3::Translate(Vec3::from([(); 3].map(|()| self.number() * 10.0))),
            1 => Transform3::Scale(Vec3::from([(); 3].map(|()| self.factor()))),
            2 => Transform3::RotateX(self.degrees()),
            3 => Transform3::RotateY(self.degrees()),
            4 => Transform3::RotateZ(self.degrees()),
            5 => Transform3::RotateAbout { axis: self.axis(), degrees: self.degrees() },
            6 => {
                let parts: Vec<_> = (0..3).map(|_| self.transform3()).collect();
                Transform3::Matrix(Transform3::chain(&parts))
            }
            _ => {
                let axes = [Axis::X, Axis::Y, Axis::Z];
                let axis = self.random.below(3);
                let by = (axis + 1 + self.random.below(2)) % 3;
                Transform3::Shear { axis: axes[axis], by: axes[by], factor: self.number() }
            }
        }
    }

    fn transform2(&mut self) -> Transform2 {
        match self.random.below(6) {
            0 => Transform2::Translate(Vec2::from([(); 2].map(|()| self.number() * 10.0))),
            1 => Transform2::Scale(Vec2::from([(); 2].map(|()| self.factor()))),
            2 => Transform2::Rotate(self.degrees()),
            3 => Transform2::ShearX(self.number()),
            4 => Transform2::ShearY(self.number()),
            _ => {
                let parts: Vec<_> = (0..3).map(|_| self.transform2()).collect();
                Transform2::Matrix(Transform2::chain(&parts))
            }
        }
    }
}

/// Compares the entries of a chain, with its last row, with the exact product of its factors. The factor that is
/// applied first is the last one. Returns whether every entry is correctly rounded.
///
/// An entry of a product of n + 1 factors is a sum of products. In space it goes through 3n multiplications and
/// additions, and one more per factor for the translation. Each of them rounds. Apart from terms of second order, the
/// error is at most 4n half ulps of the same sum of absolute values. Then the entry is rounded to `f32`.
fn assert_product(got: &[f32], factors: &[Rows], dyadic: bool) -> bool {
    let n = factors[0].len();
    let chain = factors.iter().skip(1).fold(factors[0].clone(), |chain, factor| product(&chain, factor));
    let sizes: Vec<Rows> = factors.iter().map(absolute).collect();
    let sizes = sizes.iter().skip(1).fold(sizes[0].clone(), |chain, factor| product(&chain, factor));
    let roundings = exact(4.0 * factors.len() as f64 * HALF_ULP_64);
    let mut rounded = true;
    for row in 0..=n {
        for column in 0..=n {
            let got = got[column * (n + 1) + row];
            let Some(expected) = chain.get(row).map(|row| &row[column]) else {
                assert_eq!(got, if column == n { 1.0 } else { 0.0 }, "the last row");
                continue;
            };
            let nearest = expected.to_f32().value();
            assert!(!dyadic || got == nearest, "{got} instead of {nearest}");
            let error = size(exact(got) - expected);
            let bound = size(expected.clone()) * exact(HALF_ULP_32) + &roundings * &sizes[row][column];
            assert!(error <= bound, "{got} instead of {nearest}, entry {row}, {column}");
            rounded &= got == nearest;
        }
    }
    rounded
}

#[test]
fn chains_are_products_of_their_factors() {
    for dyadic in [true, false] {
        let mut parameters = Parameters { random: Random::from_seed(11), dyadic };
        let mut correctly_rounded = 0;
        for case in 0..600 {
            let length = 1 + parameters.random.below(8);
            let chain: Vec<_> = (0..length).map(|_| parameters.transform3()).collect();
            // The transform that is applied first is the last factor.
            let factors: Vec<_> = chain.iter().rev().map(|one| rows3(&one.matrix())).collect();
            let got = Mat4::from(Transform3::chain(&chain)).to_cols_array();
            correctly_rounded += u32::from(assert_product(&got, &factors, dyadic));
            let factors: Vec<_> = chain.iter().map(|one| rows3(&one.inverse().unwrap())).collect();
            let got = Mat4::from(Transform3::chain_inverse(&chain).unwrap()).to_cols_array();
            assert_product(&got, &factors, dyadic);

            let chain: Vec<_> = (0..length).map(|_| parameters.transform2()).collect();
            let factors: Vec<_> = chain.iter().rev().map(|one| rows2(&one.matrix())).collect();
            let got = Mat3::from(Transform2::chain(&chain)).to_cols_array();
            assert_product(&got, &factors, dyadic);
            let factors: Vec<_> = chain.iter().map(|one| rows2(&one.inverse().unwrap())).collect();
            let got = Mat3::from(Transform2::chain_inverse(&chain).unwrap()).to_cols_array();
            assert_product(&got, &factors, dyadic);
            assert!(case > 0 || length > 1, "the first chain has several factors");
        }
        assert!(correctly_rounded >= 590, "{correctly_rounded} of 600");
    }
}

fn norm(matrix: &[f64]) -> f64 {
    matrix.iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[test]
fn inverses_undo_their_transforms() {
    let mut parameters = Parameters { random: Random::from_seed(12), dyadic: false };
    // The squares of sine and cosine have a relative error below 2⁻⁵⁰; an inverted factor is rounded.
    let rounded = 8.0 * HALF_ULP_64 * 2.5;
    let check = |matrix: Rows, inverse: Rows, bound: f64, what: &dyn std::fmt::Display| {
        let identity = identity(matrix.len());
        for product in [product(&matrix, &inverse), product(&inverse, &matrix)] {
            for (got, expected) in product.iter().flatten().zip(identity.iter().flatten()) {
                assert!(size(got - expected) <= exact(bound), "{what}");
            }
        }
    };
    for _ in 0..2000 {
        let one = parameters.transform3();
        let bound = match one {
            Transform3::Translate(_) | Transform3::Shear { .. } => 0.0,
            // Three entries of 2⁻⁴⁸, in rows whose sum of sizes is at most 3^½.
            Transform3::RotateAbout { .. } => 2.0 * 3.0 * 32.0 * HALF_ULP_64,
            Transform3::Matrix(affine) => {
                let linear = affine.matrix3.as_dmat3();
                8.0 * HALF_ULP_64
                    * norm(&linear.to_cols_array())
                    * norm(&linear.inverse().to_cols_array())
                    * (1.0 + f64::from(affine.translation.length()))
            }
            _ => rounded,
        };
        check(rows3(&one.matrix()), rows3(&one.inverse().unwrap()), bound, &one);
        let one = parameters.transform2();
        let bound = match one {
            Transform2::Translate(_) | Transform2::ShearX(_) | Transform2::ShearY(_) => 0.0,
            Transform2::Matrix(affine) => {
                let linear = affine.matrix2.as_dmat2();
                8.0 * HALF_ULP_64
                    * norm(&linear.to_cols_array())
                    * norm(&linear.inverse().to_cols_array())
                    * (1.0 + f64::from(affine.translation.length()))
            }
            _ => rounded,
        };
        check(rows2(&one.matrix()), rows2(&one.inverse().unwrap()), bound, &one);
    }
}

/// Sine and cosine by their series, to 150 binary places.
fn series(degrees: f32) -> [RBig; 2] {
    let places = exact(2f64.powi(160));
    let fixed = |value: RBig| RBig::from((value * &places).round()) / &places;
    let pi: RBig = "31415926535897932384626433832795028841971693993751058209749445923\
                    /10000000000000000000000000000000000000000000000000000000000000000"
        .parse()
        .unwrap();
    let turns = exact((f64::from(degrees) / 360.0).round());
    let x = fixed((exact(degrees) - turns * exact(360.0)) * pi / exact(180.0));
    let square = fixed(&x * &x);
    [x, exact(1.0)].map(|first| {
        let mut n = if first == exact(1.0) { 0.0 } else { 1.0 };
        let (mut term, mut sum) = (first.clone(), first);
        while term != RBig::ZERO {
            term = fixed(-term * &square / exact((n + 1.0) * (n + 2.0)));
            sum += &term;
            n += 2.0;
        }
        sum
    })
}

#[test]
fn sines_and_cosines_keep_their_documented_error() {
    let mut parameters = Parameters { random: Random::from_seed(13), dyadic: false };
    for case in 0..500 {
        let degrees = match case {
            0..400 => parameters.degrees(),
            // Near the zeros of sine and cosine, and tiny angles.
            400..450 => (90.0 * (case - 425) as f32).next_up(),
            _ => 1e-3 * parameters.number(),
        };
        let matrix = Transform3::RotateZ(degrees).matrix().matrix3;
        for (got, expected) in [matrix.x_axis.y, matrix.x_axis.x].into_iter().zip(series(degrees)) {
            let error = size(exact(got) - &expected);
            // At a zero, the series is zero up to its own rounding.
            let bound = size(expected.clone()) * exact(8.0 * HALF_ULP_64) + exact(2f64.powi(-150));
            assert!(error <= bound, "{degrees}: {got} instead of {}", expected.to_f64().value());
        }
    }
}

/// A square root to more than 150 binary places, by Newton's method.
fn square_root(square: &RBig) -> RBig {
    let start = exact(square.to_f64().value().sqrt());
    (0..2).fold(start, |root, _| (square / &root + root) / exact(2.0))
}

#[test]
fn rotations_about_any_axis_keep_their_documented_error() {
    let mut parameters = Parameters { random: Random::from_seed(15), dyadic: false };
    let (bound, mut worst) = (exact(2f64.powi(-48)), 0f64);
    for case in 0..500 {
        let degrees = if case < 400 { parameters.degrees() } else { 1e-3 * parameters.number() };
        let axis = parameters.axis();
        let [sin, cos] = series(degrees);
        let along = exact3(axis);
        let length_squared = dot(&along, &along);
        let length = square_root(&length_squared);
        let got = Transform3::RotateAbout { axis, degrees }.matrix().matrix3;
        for row in 0..3 {
            for column in 0..3 {
                // Rodrigues' formula; the cross product has two entries in each column.
                let mut expected = &along[row] * &along[column] / &length_squared * (exact(1.0) - &cos);
                if row == column {
                    expected += &cos;
                } else {
                    let other = &along[3 - row - column] / &length * &sin;
                    if (row + 1) % 3 == column { expected -= other } else { expected += other }
                }
                let error = size(exact(got.col(column)[row]) - expected);
                assert!(error <= bound, "{axis}, {degrees}: entry {row}, {column}");
                worst = worst.max(error.to_f64().value());
            }
        }
        let back = Transform3::RotateAbout { axis, degrees }.inverse().unwrap().matrix3;
        assert_eq!(back, got.transpose(), "{axis}, {degrees}");
    }
    assert!(worst > 2f64.powi(-53), "the worst error is {worst:e}");
}

#[test]
fn a_rotation_about_a_coordinate_axis_has_the_bits_of_its_own_variant() {
    let mut parameters = Parameters { random: Random::from_seed(16), dyadic: false };
    let bits = |one: Transform3| one.matrix().to_cols_array().map(f64::to_bits);
    for _ in 0..500 {
        let (degrees, length) = (parameters.degrees(), parameters.axis().x.abs());
        let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z];
        for (axis, variant) in
            [(x, Transform3::RotateX as fn(f32) -> Transform3), (y, Transform3::RotateY), (z, Transform3::RotateZ)]
        {
            let about = |axis: Vec3| bits(Transform3::RotateAbout { axis, degrees });
            assert_eq!(about(axis * length), bits(variant(degrees)), "{axis} {degrees}");
            // Components of -0 change nothing.
            assert_eq!(about(axis * -length), bits(variant(-degrees)), "-{axis} {degrees}");
        }
    }
}

/// A triangle with whole coordinates. `f32` holds its normal exactly.
fn whole_triangle(random: &mut Random) -> Triangle {
    loop {
        let [v0, v1, v2] = [(); 3].map(|()| Vec3::from([(); 3].map(|()| random.below(201) as f32 - 100.0)));
        if (v1 - v0).cross(v2 - v0) != Vec3::ZERO {
            return Triangle { v0, v1, v2 };
        }
    }
}

fn exact3(v: Vec3) -> [RBig; 3] {
    v.to_array().map(exact)
}

fn cross(a: &[RBig; 3], b: &[RBig; 3]) -> [RBig; 3] {
    [(1, 2), (2, 0), (0, 1)].map(|(j, k)| &a[j] * &b[k] - &a[k] * &b[j])
}

fn dot(a: &[RBig; 3], b: &[RBig; 3]) -> RBig {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

/// The normal of the exactly transformed triangle, not normalised.
fn world_normal(transform: &Affine3, triangle: &Triangle) -> [RBig; 3] {
    let columns = [transform.matrix3.x_axis, transform.matrix3.y_axis, transform.matrix3.z_axis].map(exact3);
    let translation = exact3(transform.translation);
    let [v0, v1, v2] = triangle.vertices().map(|vertex| {
        let vertex = exact3(vertex);
        let row = |axis: usize| {
            (0..3).map(|k| &columns[k][axis] * &vertex[k]).fold(translation[axis].clone(), |sum, term| sum + term)
        };
        [row(0), row(1), row(2)]
    });
    let edge = |to: &[RBig; 3]| [0, 1, 2].map(|axis| &to[axis] - &v0[axis]);
    cross(&edge(&v1), &edge(&v2))
}

/// The angle in radians; more than 1 if it is obtuse.
fn angle(got: Vec3, expected: &[RBig; 3]) -> f64 {
    let got = exact3(got);
    if dot(&got, expected) <= RBig::ZERO {
        return f64::INFINITY;
    }
    let across = cross(&got, expected);
    let sine_squared = dot(&across, &across) / (dot(&got, &got) * dot(expected, expected));
    sine_squared.to_f64().value().sqrt().asin()
}

/// A random chain of transforms, then one of: different scales along the axes, a tiny or huge scale, a shear up to
/// condition numbers of 10⁴, a long translation, a mirror.
fn transform(parameters: &mut Parameters) -> Affine3 {
    let power = |random: &mut Random, range: usize| 10f32.powi(random.below(2 * range + 1) as i32 - range as i32);
    let mut chain = Vec::new();
    for _ in 0..1 + parameters.random.below(4) {
        chain.push(parameters.transform3());
    }
    match parameters.random.below(5) {
        0 => {
            let factors = Vec3::from([(); 3].map(|()| parameters.factor() * power(&mut parameters.random, 2)));
            chain.insert(0, Transform3::Scale(factors));
        }
        1 => chain.push(Transform3::Scale(Vec3::splat(power(&mut parameters.random, 15)))),
        2 => {
            let factor = parameters.number() * 30.0;
            chain.insert(0, Transform3::Shear { axis: Axis::Z, by: Axis::X, factor });
        }
        3 => chain.push(Transform3::Translate(Vec3::new(1e6, -3e7, 0.1))),
        _ => chain.push(Transform3::Scale(Vec3::new(1.0, -1.0, 1.0))),
    }
    Transform3::chain(&chain)
}

#[test]
fn normals_are_near_those_of_exactly_transformed_triangles() {
    let mut parameters = Parameters { random: Random::from_seed(14), dyadic: false };
    let (mut mirrors, mut worst, mut conditions) = (0, 0f64, [0; 3]);
    for _ in 0..3000 {
        let transform = transform(&mut parameters);
        let linear: DMat3 = transform.matrix3.as_dmat3();
        let condition = norm(&linear.to_cols_array()) * norm(&linear.inverse().to_cols_array());
        mirrors += u32::from(linear.determinant() < 0.0);
        conditions[usize::from(condition > 1e2) + usize::from(condition > 1e4)] += 1;

        let triangle = whole_triangle(&mut parameters.random);
        let instance = Instance::new((), transform).unwrap();
        let expected = world_normal(&transform, &triangle);
        // Each coordinate of a unit vector is rounded to f32 once, after roundings in f64.
        let normal = (triangle.v1 - triangle.v0).cross(triangle.v2 - triangle.v0);
        let error = angle(instance.normal_to_world(normal), &expected);
        assert!(error <= HALF_ULP_32 + 16.0 * HALF_ULP_64 * condition, "{error} rad, {transform:?} {triangle:?}");
        worst = worst.max(error);
        // From a rounded normal the error may grow by the condition number.
        let error = angle(instance.normal_to_world(triangle.normal()), &expected);
        assert!(error <= HALF_ULP_32 * (1.0 + 4.0 * condition), "{error} rad, {transform:?} {triangle:?}");
    }
    println!("worst angle: {:.3} half ulps; {mirrors} mirrors; conditions {conditions:?}", worst / HALF_ULP_32);
    assert!(mirrors > 900 && conditions.iter().all(|&count| count > 30), "{mirrors} {conditions:?}");
    assert!(worst > 0.5 * HALF_ULP_32, "the bound is too loose: the worst error is {worst} rad");
}

#[test]
fn normals_without_direction_are_zero() {
    let instance = Instance::new((), Transform3::chain(&[Transform3::RotateX(30.0)])).unwrap();
    assert_eq!(instance.normal_to_world(Vec3::ZERO), Vec3::ZERO);
    assert_eq!(instance.normal_to_world(Vec3::new(0.0, f32::NAN, 1.0)), Vec3::ZERO);
}
