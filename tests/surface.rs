//! Tests points and normals of hits in the world against exact arithmetic, under translations, scales, shears,
//! rotations and mirrors.

mod worlds;

use dashu_int::IBig;
use glam::{Affine2, Affine3, DMat3, Mat3, Vec2, Vec3};
use raylanes::geom::{Hit, Quadric, Ray, Triangle};
use raylanes::kernels::triangle::MollerTrumbore;
use raylanes::tracer::{
    Camera, Checker, Geometry, Light, Mesh, Mode, Paint, Part, Picture, Placement, Scene, Shade, Shot, SurfacePoint,
    World, picture_hits, shade, trace,
};

use raylanes::conformance::Random;

/// The exact number `int · 2^exponent`. It can hold every sum and product of `f32` and `f64`.
#[derive(Clone, Debug)]
struct Exact {
    int: IBig,
    exponent: isize,
}

impl Exact {
    fn of(value: impl Into<f64>) -> Self {
        let value = value.into();
        let (bits, field) = (value.to_bits() & ((1 << 52) - 1), value.to_bits() >> 52 & 0x7ff);
        let magnitude = if field == 0 { bits } else { bits | 1 << 52 };
        let int = if value < 0.0 { -IBig::from(magnitude) } else { IBig::from(magnitude) };
        Self { int, exponent: field.max(1) as isize - 1075 }
    }

    fn plus(&self, other: &Self) -> Self {
        let exponent = self.exponent.min(other.exponent);
        let at = |number: &Self| &number.int << (number.exponent - exponent) as usize;
        Self { int: at(self) + at(other), exponent }
    }

    fn times(&self, other: &Self) -> Self {
        Self { int: &self.int * &other.int, exponent: self.exponent + other.exponent }
    }

    fn minus(&self, other: &Self) -> Self {
        self.plus(&other.times(&Self::of(-1.0)))
    }

    fn is_negative(&self) -> bool {
        self.int < IBig::ZERO
    }

    fn abs(&self) -> Self {
        if self.is_negative() { Self::of(0.0).minus(self) } else { self.clone() }
    }

    fn is_at_most(&self, other: &Self) -> bool {
        !other.minus(self).is_negative()
    }
}

type Exact3 = [Exact; 3];

fn exact(vector: Vec3) -> Exact3 {
    vector.to_array().map(Exact::of)
}

fn each(f: impl Fn(usize) -> Exact) -> Exact3 {
    [f(0), f(1), f(2)]
}

fn add(a: &Exact3, b: &Exact3) -> Exact3 {
    each(|i| a[i].plus(&b[i]))
}

fn sub(a: &Exact3, b: &Exact3) -> Exact3 {
    each(|i| a[i].minus(&b[i]))
}

fn scale(a: &Exact3, by: &Exact) -> Exact3 {
    each(|i| a[i].times(by))
}

fn product(a: &Exact3, b: &Exact3) -> Exact3 {
    each(|i| a[i].times(&b[i]))
}

fn dot(a: &Exact3, b: &Exact3) -> Exact {
    a[0].times(&b[0]).plus(&a[1].times(&b[1])).plus(&a[2].times(&b[2]))
}

fn cross(a: &Exact3, b: &Exact3) -> Exact3 {
    each(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j].times(&b[k]).minus(&a[k].times(&b[j]))
    })
}

/// `matrix · vector`, from the columns of the matrix.
fn apply(columns: &[Exact3; 3], vector: &Exact3) -> Exact3 {
    add(&add(&scale(&columns[0], &vector[0]), &scale(&columns[1], &vector[1])), &scale(&columns[2], &vector[2]))
}

fn columns(matrix: Mat3) -> [Exact3; 3] {
    [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(exact)
}

/// Columns of the matrix of cofactors, and the determinant.
fn cofactors([x, y, z]: &[Exact3; 3]) -> ([Exact3; 3], Exact) {
    let cofactors = [cross(y, z), cross(z, x), cross(x, y)];
    let determinant = dot(x, &cofactors[0]);
    (cofactors, determinant)
}

fn transposed(columns: &[Exact3; 3]) -> [Exact3; 3] {
    [0, 1, 2].map(|row| each(|column| columns[column][row].clone()))
}

/// Asserts that the error of each coordinate is at most half an ulp plus 2⁻⁴⁷ of the largest term.
fn assert_point(what: &str, got: Vec3, expected: &Exact3, largest_term: f64) {
    for axis in 0..3 {
        let got = got[axis];
        let half_ulp = (f64::from(got.abs().next_up()) - f64::from(got.abs())) / 2.0;
        let bound = Exact::of(half_ulp + largest_term * 2f64.powi(-47));
        let error = Exact::of(got).minus(&expected[axis]).abs();
        assert!(error.is_at_most(&bound), "{what}: {got:?} on axis {axis} is off by more than {half_ulp:e}");
    }
}

/// Asserts that the length is 1 within 2⁻²³, and the sine of the angle to the exact direction is at most `bound`.
fn assert_normal(what: &str, got: Vec3, expected: &Exact3, bound: f64) {
    let length = got.as_dvec3().length();
    assert!((length - 1.0).abs() < 2f64.powi(-23), "{what}: {got} has length {length}");
    let got = exact(got);
    assert!(!dot(&got, expected).is_negative(), "{what}: {got:?} points to the wrong side");
    let sine = cross(&got, expected);
    let bound = dot(expected, expected).times(&Exact::of(bound * bound));
    assert!(dot(&sine, &sine).is_at_most(&bound), "{what}: {got:?} is off by too large an angle");
}

type Hits = Vec<(Ray<f32>, Hit<f32>)>;

/// A scene of one instance, and rays at it that hit.
fn hits(geometry: Geometry, object_to_world: Affine3, paint: Paint, seed: u64) -> (Scene<MollerTrumbore<f32>>, Hits) {
    let world = World::new(vec![geometry], vec![Placement::new(0, object_to_world).with_paint(paint)]).unwrap();
    let rays = worlds::rays(&world, seed, 64);
    let scene = Scene::new(world);
    let hits = trace(&scene, &rays, Mode::Scalar);
    (scene, rays.into_iter().zip(hits).filter(|(_, hit)| hit.mask).collect())
}

#[test]
fn points_and_normals_of_triangles_are_right() {
    let mut random = Random::from_seed(23);
    let mut seen = 0;
    for round in 0..400 {
        let size = worlds::pick(&mut random, &[1e-6, 1.0, 1.0, 1e6]);
        let [v0, v1, v2] = [(); 3].map(|()| worlds::vec3(&mut random) * size);
        let transform = worlds::transform(&mut random, 10.0);
        let mesh = worlds::mesh(vec![v0, v1, v2], vec![[0, 1, 2]]);
        let (scene, hits) = hits(Geometry::Mesh(mesh), transform, Paint::Own, round);
        let linear = columns(transform.matrix3);
        let [e0, e1, e2] = [v0, v1, v2].map(exact);
        let (e1, e2) = (sub(&e1, &e0), sub(&e2, &e0));
        let normal = cross(&apply(&linear, &e1), &apply(&linear, &e2));
        for (ray, hit) in hits {
            let surface = scene.surface(&ray, &hit);
            let object = add(&e0, &add(&scale(&e1, &Exact::of(hit.u)), &scale(&e2, &Exact::of(hit.v))));
            let point = add(&apply(&linear, &object), &exact(transform.translation));
            let greatest = transform.matrix3.to_cols_array().iter().fold(0.0f32, |most, entry| most.max(entry.abs()));
            let corner = v0.abs().max(v1.abs()).max(v2.abs()).max_element();
            let term =
                (f64::from(greatest) * f64::from(corner)).max(f64::from(transform.translation.abs().max_element()));
            let what = format!("{transform:?}, {v0}, {v1}, {v2}, {hit:?}");
            assert_point(&what, surface.point, &point, term);
            // In the world the triangle may be a sliver of ratio 1 to 1000.
            assert_normal(&what, surface.normal, &normal, 2f64.powi(-24) + 1e6 * 2f64.powi(-50));
            assert_eq!((surface.uv, surface.color), (Vec2::new(hit.u, hit.v), Vec3::ONE));
            assert_eq!(surface.shading_normal, surface.normal);
            seen += 1;
        }
    }
    assert!(seen > 5_000, "{seen}");
}

#[test]
fn points_and_normals_of_quadrics_are_right() {
    let mut random = Random::from_seed(29);
    let mut seen = 0;
    let geometries = worlds::geometries(&mut random);
    for (round, geometry) in (0..400).zip(geometries.iter().filter(|one| matches!(one, Geometry::Quadric(_))).cycle()) {
        let Geometry::Quadric(quadric) = geometry else { unreachable!("filtered") };
        let transform = worlds::transform(&mut random, 10.0);
        let (scene, hits) = hits(geometry.clone(), transform, Paint::Own, round);
        let linear = columns(transform.matrix3);
        let (cofactors, determinant) = cofactors(&linear);
        for (ray, hit) in hits {
            let surface = scene.surface(&ray, &hit);
            let along = scale(&exact(ray.dir), &Exact::of(hit.t));
            let point = add(&exact(ray.origin), &along);
            let term = f64::from(ray.origin.abs().max_element()).max(f64::from((ray.dir * hit.t).abs().max_element()));
            let what = format!("{quadric:?}, {transform:?}, {ray:?}, {hit:?}");
            assert_point(&what, surface.point, &point, term);
            // Everything is multiplied by the determinant, which avoids divisions.
            let object = apply(&transposed(&cofactors), &sub(&point, &exact(transform.translation)));
            let [yz, zx, xy] = exact(quadric.products);
            let [x, y, z] = &object;
            let mixed =
                [xy.times(y).plus(&zx.times(z)), xy.times(x).plus(&yz.times(z)), zx.times(x).plus(&yz.times(y))];
            let squares = scale(&product(&exact(quadric.squares), &object), &Exact::of(2.0));
            let gradient = add(&add(&squares, &mixed), &scale(&exact(quadric.linear), &determinant));
            // The inverse transpose is the cofactors divided by the determinant. The gradient was multiplied by the
            // determinant too, so its sign cancels.
            let normal = apply(&cofactors, &gradient);
            // The point in object space is off by 2⁻⁵⁰ of the distances that are subtracted. Near an apex that changes
            // the direction of the gradient.
            let (linear, translation) = (transform.matrix3.as_dmat3(), transform.translation.as_dvec3());
            let (origin, along) = (ray.origin.as_dvec3() - translation, ray.dir.as_dvec3() * f64::from(hit.t));
            let inverse = linear.inverse();
            let off = 2f64.powi(-50) * norm(inverse) * (origin.length() + along.length());
            let steepness = f64::from(quadric.squares.abs().max_element()) * 4.0 * off;
            let gradient = quadric.squares.as_dvec3() * (inverse * (origin + along)) * 2.0 + quadric.linear.as_dvec3();
            let condition = norm(linear) * norm(inverse);
            let bound = 2f64.powi(-24) + condition * (steepness / gradient.length() + 2f64.powi(-50));
            if normal.iter().all(|component| component.int.is_zero()) {
                assert_eq!(surface.normal, Vec3::ZERO, "{what}");
            } else if bound < 0.1 {
                assert_normal(&what, surface.normal, &normal, bound);
            }
            assert!(surface.uv.cmpge(Vec2::ZERO).all() && surface.uv.cmple(Vec2::ONE).all(), "{what}: {}", surface.uv);
            assert_eq!((surface.color, surface.shading_normal), (Vec3::ONE, surface.normal));
            seen += 1;
        }
    }
    assert!(seen > 2_000, "{seen}");
}

#[test]
fn shading_normals_and_texture_coordinates_are_interpolated() {
    let mut random = Random::from_seed(37);
    let (mut seen, mut turned) = (0, 0);
    for round in 0..400 {
        let vertices = [(); 3].map(|()| worlds::vec3(&mut random));
        let size = worlds::pick(&mut random, &[1e-20, 1.0, 1.0, 1e15]);
        // Within 60 degrees of the triangle's normal, or of its opposite.
        let side = Triangle { v0: vertices[0], v1: vertices[1], v2: vertices[2] }.normal()
            * worlds::pick(&mut random, &[1.0, -1.0]);
        let normals = [(); 3].map(|()| (side + worlds::vec3(&mut random) * 0.5) * size);
        let coordinates = [(); 3].map(|()| worlds::vec3(&mut random).truncate() * 100.0);
        let transform = worlds::transform(&mut random, 10.0);
        let mesh = worlds::mesh(vertices.to_vec(), vec![[0, 1, 2]])
            .with_normals(normals.to_vec(), vec![[0, 1, 2]])
            .and_then(|mesh| mesh.with_texture_coordinates(coordinates.to_vec(), vec![[0, 1, 2]]))
            .unwrap();
        let (scene, hits) = hits(Geometry::Mesh(mesh), transform, Paint::Own, 2000 + round);
        let (cofactors, determinant) = cofactors(&columns(transform.matrix3));
        let linear = transform.matrix3.as_dmat3();
        let condition = norm(linear) * norm(linear.inverse());
        for (ray, hit) in hits {
            let surface = scene.surface(&ray, &hit);
            let at_hit = |[v0, v1, v2]: [Vec3; 3]| {
                let [v0, v1, v2] = [v0, v1, v2].map(exact);
                add(&v0, &add(&scale(&sub(&v1, &v0), &Exact::of(hit.u)), &scale(&sub(&v2, &v0), &Exact::of(hit.v))))
            };
            // The inverse transpose, times the determinant.
            let mut expected = scale(&apply(&cofactors, &at_hit(normals)), &determinant);
            if dot(&expected, &exact(surface.normal)).is_negative() {
                expected = scale(&expected, &Exact::of(-1.0));
                turned += 1;
            }
            let what = format!("{transform:?}, {vertices:?}, {normals:?}, {hit:?}");
            assert_normal(&what, surface.shading_normal, &expected, 2f64.powi(-24) + condition * 2f64.powi(-48));
            let uv = at_hit(coordinates.map(|uv| uv.extend(0.0)));
            assert_point(&what, surface.uv.extend(0.0), &uv, 200.0);
            seen += 1;
        }
    }
    assert!(seen > 5_000 && turned > 1_000, "{seen}, {turned} of them turned");
}

/// Normals that cancel, or lie in the plane of the triangle, and a triangle without normals beside one that has some.
#[test]
fn without_a_usable_normal_the_shading_normal_is_the_geometric_one() {
    let square =
        || worlds::mesh(vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y], vec![[0, 1, 2], [0, 2, 3]]);
    let none = [Mesh::NO_VALUE; 3];
    for normals in [vec![Vec3::ZERO; 3], vec![Vec3::X, Vec3::Y, Vec3::X]] {
        let mesh = square().with_normals(normals.clone(), vec![[0, 1, 2], none]).unwrap();
        let scene = Scene::<MollerTrumbore<f32>>::from(mesh);
        for ray in
            [Ray::new(Vec3::new(0.75, 0.25, 9.0), Vec3::NEG_Z), Ray::new(Vec3::new(0.25, 0.75, 9.0), Vec3::NEG_Z)]
        {
            let hit = trace(&scene, &[ray], Mode::Scalar)[0];
            let surface = scene.surface(&ray, &hit);
            assert_eq!((surface.normal, surface.shading_normal), (Vec3::Z, Vec3::Z), "{normals:?}");
        }
    }
}

/// A picture shows the normals of the corners: as if the square were tilted. Normals along the geometric one change
/// nothing.
#[test]
fn diffuse_reflection_uses_the_shading_normal() {
    let square =
        || worlds::mesh(vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y], vec![[0, 1, 2], [0, 2, 3]]);
    let picture = |mesh: Mesh| {
        let scene = Scene::<MollerTrumbore<f32>>::from(mesh);
        let camera = Camera::new(Vec3::new(0.5, 0.5, 3.0), Vec3::new(0.5, 0.5, 0.0), 30.0, 8, 8);
        let light = Light::Directional(Vec3::new(0.0, 1.0, 1.0));
        let shot = Shot { camera, light, mode: Mode::Scalar, width: 8, height: 8 };
        let hits = picture_hits(&scene, &shot);
        shade(&scene, &shot, &hits, Shade::Lambert)
    };
    let with_normals = |normals: [Vec3; 4]| {
        let corners = vec![[0, 1, 2], [0, 2, 3]];
        picture(square().with_normals(normals.to_vec(), corners).unwrap())
    };
    let plain = picture(square());
    assert_eq!(with_normals([Vec3::Z * 3.0; 4]), plain);
    assert_eq!(with_normals([Vec3::NEG_Z; 4]), plain, "turned to the geometric side");
    let middle = |picture: &Picture| picture.pixels()[8 * 4 + 4].x;
    let towards_light = with_normals([Vec3::new(0.0, 1.0, 1.0); 4]);
    // The light meets the square at 45 degrees, and the tilted one at 90. The ambient light is a quarter.
    assert!(middle(&plain) > 0.25 + 0.75 * 0.70 && middle(&plain) < 0.25 + 0.75 * 0.71, "{}", middle(&plain));
    assert!(middle(&towards_light) > 0.95, "{}", middle(&towards_light));
    let bent = with_normals([Vec3::Z, Vec3::Z, Vec3::new(0.0, 1.0, 1.0), Vec3::new(0.0, 1.0, 1.0)]);
    let column: Vec<_> = (0..8).map(|row| bent.pixels()[8 * row + 4].x).filter(|&x| x != 0.53).collect();
    assert!(column.len() >= 4 && column.is_sorted_by(|above, below| above > below), "{column:?}");
}

/// A mirror flips the winding of triangles. The outside of a quadric stays the outside.
#[test]
fn mirrors_flip_the_normals_of_triangles_but_not_of_quadrics() {
    let mirror = Affine3::from_scale(Vec3::new(-2.0, 2.0, 2.0));
    let geometries = || vec![Geometry::Mesh(worlds::cuboid(Vec3::ONE)), Geometry::Quadric(Quadric::cylinder(1.0, 1.0))];
    let ray = Ray::new(Vec3::new(-8.0, 0.25, 0.5), Vec3::X);
    let normal = |placement| {
        let scene = Scene::<MollerTrumbore<f32>>::new(World::new(geometries(), vec![placement]).unwrap());
        let hit = trace(&scene, &[ray], Mode::Packet)[0];
        scene.surface(&ray, &hit).normal
    };
    assert_eq!(normal(worlds::place(0, Affine3::IDENTITY)), Vec3::NEG_X);
    assert_eq!(normal(worlds::place(0, mirror)), Vec3::X);
    for transform in [Affine3::IDENTITY, mirror] {
        assert!(normal(worlds::place(1, transform)).x < -0.95);
    }
}

#[test]
fn colors_come_from_the_paint() {
    let [red, green] = [Vec3::X, Vec3::Y];
    let parts = [red, green].into_iter().zip([0, 1]).map(|(color, first_triangle)| Part { first_triangle, color });
    let square = vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
    let mesh = Mesh::new(square, vec![[0, 1, 2], [0, 2, 3]], parts.collect()).unwrap();
    let checker = Checker { colors: [Vec3::ONE, Vec3::ZERO], uv_to_squares: Affine2::from_scale(Vec2::new(8.0, 2.0)) };
    let at =
        |x: f32, geometry, paint| Placement::new(geometry, Affine3::from_translation(Vec3::X * x)).with_paint(paint);
    let instances = vec![
        at(0.0, 0, Paint::Own),
        at(2.0, 0, Paint::Plain(Vec3::splat(0.5))),
        at(6.0, 1, Paint::Own),
        at(9.0, 1, Paint::Checker(checker)),
    ];
    let geometries = vec![Geometry::Mesh(mesh), Geometry::Quadric(Quadric::cylinder(1.0, 2.0))];
    let scene = Scene::<MollerTrumbore<f32>>::new(World::new(geometries, instances).unwrap());
    let surface = |ray: Ray<f32>| -> SurfacePoint {
        let hit = trace(&scene, &[ray], Mode::Scalar)[0];
        scene.surface(&ray, &hit)
    };
    let from_above = |x: f32, y: f32| surface(Ray::new(Vec3::new(x, y, 9.0), Vec3::NEG_Z));
    assert_eq!([from_above(0.75, 0.25).color, from_above(0.25, 0.75).color], [red, green]);
    assert_eq!([from_above(2.75, 0.25).color, from_above(2.25, 0.75).color], [Vec3::splat(0.5); 2]);
    // The cylinder from four sides (u = 0, 1/4, 1/2, 3/4), at a quarter of its height, just off the lines of the
    // checker.
    let sides = [(Vec3::X, 0.0), (Vec3::Y, 0.25), (Vec3::NEG_X, 0.5), (Vec3::NEG_Y, 0.75)];
    for (number, (side, turn)) in sides.into_iter().enumerate() {
        let eye = |x: f32| Vec3::new(x, 0.0, -1.0) + side * 1.5 + side.cross(Vec3::Z) * -0.01;
        let plain = surface(Ray::new(eye(6.0), -side));
        assert!(plain.uv.abs_diff_eq(Vec2::new(turn, 0.25), 0.01), "{plain:?}");
        assert!(plain.normal.abs_diff_eq(side, 0.02) && plain.color == Vec3::ONE, "{plain:?}");
        // Eight squares around: a quarter of a turn is two squares, so all four sides have the first colour.
        assert_eq!(surface(Ray::new(eye(9.0), -side)).color, Vec3::ONE, "side {number}");
        let upper = Vec3::Z * 2.0;
        assert_eq!(surface(Ray::new(eye(9.0) + upper, -side)).color, Vec3::ZERO, "side {number}");
    }
}

/// On a plane, u and v run along x and y. Its front is that of +z.
#[test]
fn a_plane_has_its_own_surface_parameters() {
    let turned = Affine3::from_mat3(Mat3::from_cols(Vec3::Y, Vec3::Z, Vec3::X));
    let plane = Geometry::Quadric(Quadric::plane(Vec2::new(2.0, 4.0)));
    let scene = Scene::<MollerTrumbore<f32>>::new(World::new(vec![plane], vec![worlds::place(0, turned)]).unwrap());
    // The plane is x = 0 in the world, its x runs along y, and its y along z.
    for (y, z, uv) in
        [(-2.0, -4.0, [0.0, 0.0]), (2.0, 4.0, [1.0, 1.0]), (1.0, 0.0, [0.75, 0.5]), (0.0, 1.0, [0.5, 0.625])]
    {
        for side in [-1.0, 1.0] {
            let ray = Ray::new(Vec3::new(side * 3.0, y, z), Vec3::NEG_X * side);
            let hit = trace(&scene, &[ray], Mode::Packet)[0];
            let surface = scene.surface(&ray, &hit);
            assert_eq!((hit.t, surface.normal, surface.uv.to_array()), (3.0, Vec3::X, uv), "{y} {z}");
        }
    }
    for (y, z) in [(2.001, 0.0), (0.0, -4.001)] {
        assert!(!trace(&scene, &[Ray::new(Vec3::new(3.0, y, z), Vec3::NEG_X)], Mode::Scalar)[0].mask);
    }
    assert!(!trace(&scene, &[Ray::new(Vec3::new(0.0, -9.0, 0.0), Vec3::Y)], Mode::Scalar)[0].mask, "in the plane");
}

/// The apex of a cone has no normal. A hit there contains no NaN.
#[test]
fn the_normal_at_an_apex_is_zero() {
    let placement = worlds::place(0, Affine3::from_scale(Vec3::splat(3.0)));
    let world = World::new(vec![Geometry::Quadric(Quadric::cone(1.0, 2.0))], vec![placement]).unwrap();
    let scene = Scene::<MollerTrumbore<f32>>::new(world);
    let hit = Hit::<f32>::new(true, 4.0, 0.0, 0.0);
    let surface = scene.surface(&Ray::new(Vec3::new(-4.0, 0.0, 0.0), Vec3::X), &hit);
    assert_eq!((surface.point, surface.normal), (Vec3::ZERO, Vec3::ZERO));
    assert!(!surface.uv.is_nan());
}

/// The kernel adds its own error: the distance to the point where the exact ray meets the exact triangle. For rays that
/// do not graze the triangle, in the world or in object space, the bound is 2⁻²⁰ of the distances involved, times the
/// condition number of the transform.
#[test]
fn points_are_near_the_exact_intersection() {
    use raylanes::geom::Placed;
    use raylanes::oracle::Exact as _;

    let mut random = Random::from_seed(31);
    let mut seen = 0;
    for round in 0..400 {
        let [v0, v1, v2] = [(); 3].map(|()| worlds::vec3(&mut random));
        let shape = Triangle { v0, v1, v2 };
        let object_to_world = worlds::transform(&mut random, 10.0);
        let mesh = worlds::mesh(vec![v0, v1, v2], vec![[0, 1, 2]]);
        let (scene, hits) = hits(Geometry::Mesh(mesh), object_to_world, Paint::Own, 1000 + round);
        let inverse = object_to_world.matrix3.as_dmat3().inverse();
        for (ray, hit) in hits {
            let truth = Placed { shape, object_to_world }.truth(&ray);
            let surface = scene.surface(&ray, &hit);
            let in_object = (inverse * ray.dir.as_dvec3()).normalize().as_vec3();
            let cosine = surface.normal.dot(ray.dir.normalize()).abs().min(shape.normal().dot(in_object).abs());
            if !truth.hit || cosine < 0.3 {
                continue;
            }
            let along = ray.dir.as_dvec3() * f64::from(truth.t);
            let from_object = (ray.origin - object_to_world.translation).length();
            let distances = f64::from(from_object) + along.length() + f64::from(surface.point.length());
            let condition = norm(object_to_world.matrix3.as_dmat3()) * norm(inverse);
            let error = (surface.point.as_dvec3() - (ray.origin.as_dvec3() + along)).length() / (distances * condition);
            assert!(error < 2f64.powi(-20), "{object_to_world:?}, {shape:?}, {ray:?}, {hit:?}: {error:e}");
            seen += 1;
        }
    }
    assert!(seen > 1_000, "{seen}");
}

fn norm(matrix: DMat3) -> f64 {
    matrix.to_cols_array().iter().map(|entry| entry * entry).sum::<f64>().sqrt()
}
