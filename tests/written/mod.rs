//! Tests of the writer of scene files: what it writes loads again, bit for bit, and what it cannot write changes no
//! file.

use std::fs;
use std::path::{Path, PathBuf};

use glam::{Affine2, Affine3, Mat2, Mat3, Vec2, Vec3};
use raylanes::geom::{Aabb, Quadric};
use raylanes::tracer::{
    Checker, Face, Geometry, Light, LoadedScene, Mesh, Paint, Part, Placement, SceneSource, View, World, load_scene,
    write_scene,
};

use crate::files::Files;

/// A number of each kind: zeros of both signs, the smallest and the largest, a tie between two `f32` if it is read as
/// `f64`, and numbers that need every digit.
const ODD: [f32; 14] = [
    0.0,
    -0.0,
    1e-45,
    -1e-45,
    f32::MIN_POSITIVE,
    f32::MAX,
    f32::MIN,
    7.038_531e-26,
    -7.038_531e-26,
    0.1,
    16_777_217.0,
    1e16,
    -1.000_000_1,
    0.333_333_34,
];

/// As text, with every bit: `==` does not tell -0 from 0.
fn bits(world: &World, view: &View) -> String {
    format!("{world:#?}\n{view:#?}")
}

/// Checks that two texts are equal, and shows the first line that is not.
fn assert_same(found: &str, expected: &str, what: &str) {
    let differs = found.lines().zip(expected.lines()).find(|(found, expected)| found != expected);
    assert!(found == expected, "{what}: {differs:?}");
}

/// The names in a folder.
fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Writes a scene, loads it, and checks that it is the same. Returns the names of the files and their contents.
fn round_trip(world: &World, view: &View, what: &str) -> Vec<(String, String)> {
    let files = Files::new();
    let path = files.path("out.toml");
    let written = write_scene(world, view, &path).unwrap();
    let contents: Vec<_> = names(&files.path(""))
        .into_iter()
        .map(|name| (name.clone(), fs::read_to_string(files.path(&name)).unwrap()))
        .collect();
    let mut paths = written.clone();
    paths.sort();
    assert_eq!(paths, contents.iter().map(|(name, _)| files.path(name)).collect::<Vec<_>>(), "{what}");
    assert_eq!(written.last(), Some(&path));
    let LoadedScene { world: found, view: seen, remarks } = load_scene(&path).unwrap();
    let remarks: Vec<_> = remarks.iter().filter(|remark| !remark.contains("zero area")).collect();
    assert!(remarks.is_empty(), "{what}: {remarks:?}");
    assert_same(&bits(&found, &seen), &bits(world, view), what);
    contents
}

fn view() -> View {
    View {
        eye: Vec3::new(1.0, -0.0, 1e-45),
        look_at: Vec3::new(0.1, 2e30, -3.0),
        vertical_fov: 33.3,
        transform: None,
        light: Light::Point(Vec3::new(-0.0, 7.038_531e-26, f32::MIN)),
    }
}

fn world(geometries: Vec<Geometry>) -> World {
    let instances = (0..geometries.len() as u32).map(|number| Placement::new(number, Affine3::IDENTITY)).collect();
    World::new(geometries, instances).unwrap()
}

fn part(first_triangle: u32, color: [f32; 3]) -> Part {
    Part { first_triangle, color: color.into() }
}

/// A mesh whose triangles do not use its vertices in order, and share some.
fn mesh(parts: Vec<Part>) -> Mesh {
    let positions = (0..8).map(|first| Vec3::from_array([0, 1, 2].map(|axis| ODD[(first * 3 + axis) % ODD.len()])));
    let triangles = vec![[7, 2, 0], [1, 0, 3], [6, 5, 4], [2, 2, 2], [0, 1, 2]];
    Mesh::new(positions.collect(), triangles, parts).unwrap()
}

const GREY: [f32; 3] = [0.8; 3];

#[test]
fn built_in_scenes_are_read_back_bit_for_bit() {
    for (name, expected) in [
        ("room:1e3", &["out-mesh-1.obj", "out.mtl", "out.toml"][..]),
        ("terrain:1e3", &["out-mesh-1.obj", "out.mtl", "out.toml"]),
        ("sphere:1e3", &["out-mesh-1.obj", "out.mtl", "out.toml"]),
        ("forest:1e3", &["out-mesh-1.obj", "out-mesh-2.obj", "out.mtl", "out.toml"]),
        ("gallery", &["out-mesh-1.obj", "out.toml"]),
    ] {
        let LoadedScene { world, view, .. } = SceneSource::parse(name).unwrap().load().unwrap();
        let contents = round_trip(&world, &view, name);
        let names: Vec<_> = contents.iter().map(|(name, _)| name).collect();
        assert_eq!(names, expected, "{name}");
    }
}

#[test]
fn meshes_are_read_back_with_parts_normals_and_texture_coordinates() {
    let none = [Mesh::NO_VALUE; 3];
    let normals = vec![Vec3::new(-0.0, 1e-45, f32::MAX), Vec3::new(0.1, -0.2, 0.3), Vec3::ZERO];
    let coordinates = vec![Vec2::new(-0.0, 7.038_531e-26), Vec2::new(3.0, -1e30)];
    let one_part = [vec![part(0, GREY)], vec![part(0, [0.1, -0.0, 1.0])]];
    let several = [
        // Colours that are used again, the default among others, and two parts of one colour.
        vec![part(0, [0.1, 0.2, 0.3]), part(1, GREY), part(2, [0.1, 0.2, 0.3]), part(4, [0.1, 0.2, 0.3])],
        vec![part(0, GREY), part(3, GREY)],
    ];
    for parts in one_part.into_iter().chain(several) {
        let plain = mesh(parts.clone());
        let shaded = || plain.clone().with_normals(normals.clone(), vec![none, [2, 0, 0], none, [1; 3], [0, 1, 2]]);
        let texture = vec![[0, 1, 0], none, none, [1, 1, 0], none];
        let textured = |mesh: Mesh| mesh.with_texture_coordinates(coordinates.clone(), texture.clone());
        let meshes =
            [plain.clone(), shaded().unwrap(), textured(plain.clone()).unwrap(), textured(shaded().unwrap()).unwrap()];
        round_trip(&world(meshes.map(Geometry::Mesh).into()), &view(), &format!("{parts:?}"));
    }
}

#[test]
fn a_mesh_in_the_default_colour_needs_no_materials() {
    let contents = round_trip(&world(vec![Geometry::Mesh(mesh(vec![part(0, GREY)]))]), &view(), "grey");
    let [(obj, text), (toml, _)] = &contents[..] else { panic!("{contents:?}") };
    assert_eq!((&obj[..], &toml[..]), ("out-mesh-1.obj", "out.toml"));
    assert!(!text.contains("mtl"), "{text}");
}

#[test]
fn vertices_that_no_triangle_uses_are_left_out() {
    let positions = vec![Vec3::ONE, Vec3::ZERO, Vec3::X, Vec3::ONE * 2.0, Vec3::Y];
    let all = Mesh::new(positions.clone(), vec![[4, 2, 1]], vec![part(0, GREY)]).unwrap();
    let used = Mesh::new(vec![Vec3::ZERO, Vec3::X, Vec3::Y], vec![[2, 1, 0]], vec![part(0, GREY)]).unwrap();
    let values = all.clone().with_normals(vec![Vec3::X], vec![[Mesh::NO_VALUE; 3]]).unwrap();
    let files = Files::new();
    let path = files.path("out.toml");
    for mesh in [all, values] {
        write_scene(&mesh.into(), &view(), &path).unwrap();
        let found = load_scene(&path).unwrap().world;
        assert_eq!(found, used.clone().into());
        fs::remove_file(&path).unwrap();
        fs::remove_file(files.path("out-mesh-1.obj")).unwrap();
    }
}

/// A quadric with all sixteen numbers odd, and clip box planes of zero with both signs.
fn odd_quadric() -> Quadric {
    Quadric {
        squares: Vec3::new(-0.0, 1e-45, f32::MIN),
        products: Vec3::new(7.038_531e-26, -0.0, 0.1),
        linear: Vec3::new(1e-20, 1e20, -1.0),
        constant: -0.0,
        clip: Aabb { lo: Vec3::new(-0.0, -1e30, f32::MIN), hi: Vec3::new(0.0, 1e-45, f32::MAX) },
    }
}

#[test]
fn quadrics_discs_and_closed_solids_are_read_back() {
    let open = [odd_quadric(), Quadric::sphere(3.0), Quadric::cone(0.1, 0.3), Quadric::plane(Vec2::new(2.0, 0.7))];
    let mut geometries: Vec<_> = open.into_iter().map(Geometry::Quadric).collect();
    for (radius, height) in [(1e-15, 1e-7), (1e-15, 7.0), (0.1, 0.3), (3.0, 0.1), (7e14, 1e10), (1e15, 1e15)] {
        geometries.extend([
            Geometry::disc(radius),
            Geometry::closed_cylinder(radius, height),
            Geometry::closed_cone(radius, height),
            Geometry::closed_paraboloid(radius, height),
        ]);
    }
    let contents = round_trip(&world(geometries), &view(), "quadrics");
    let [(_, toml)] = &contents[..] else { panic!("{contents:?}") };
    for line in [
        "disc = { radius = 0.1 }",
        "cylinder = { radius = 3, half_height = 0.1, closed = true }",
        "cone = { radius = 0.1, height = 0.3, closed = true }",
        "paraboloid = { radius = 1e-15, height = 1e-7, closed = true }",
        "coefficients = [1, 1, 1, 0, 0, 0, 0, 0, 0, -9]",
    ] {
        assert!(toml.lines().any(|found| found == line), "{line}");
    }
}

#[test]
fn instances_keep_their_matrices_and_paints() {
    let matrices = [
        Affine3::IDENTITY,
        // The identity but for the sign of zeros.
        Affine3 { translation: Vec3::new(0.0, -0.0, 0.0), ..Affine3::IDENTITY },
        Affine3 {
            matrix3: Mat3::from_cols_array(&[1.0, -0.0, 0.1, 0.0, -1.0, -0.0, 7.038_531e-26, -0.0, 2.0]),
            translation: Vec3::new(f32::MAX, 1e-45, -0.0),
        },
        Affine3::from_scale(Vec3::new(1e-10, 1e10, -0.333_333_34)),
    ];
    let squares = [
        Affine2::IDENTITY,
        Affine2 { translation: Vec2::new(-0.0, 0.0), ..Affine2::IDENTITY },
        Affine2 {
            matrix2: Mat2::from_cols_array(&[-0.0, 1e-30, 0.1, -0.0]),
            translation: Vec2::new(f32::MIN, 7.038_531e-26),
        },
        Affine2::from_cols_array(&[0.707_106_77, 0.707_106_77, -0.707_106_77, 0.707_106_77, 16_777_217.0, 1e16]),
    ];
    let colors = [Vec3::new(-0.0, 1.0, 0.333_333_34), Vec3::new(1e-45, 0.0, 0.999_999_94)];
    let paints = squares.map(|uv_to_squares| Paint::Checker(Checker { colors, uv_to_squares }));
    let paints: Vec<_> = [Paint::Own, Paint::Plain(colors[0])].into_iter().chain(paints).collect();
    let instances = matrices.iter().flat_map(|&matrix| {
        paints.iter().zip(0..).map(move |(&paint, number)| Placement::new(number % 2, matrix).with_paint(paint))
    });
    let geometries = vec![Geometry::Mesh(mesh(vec![part(0, GREY)])), Quadric::sphere(2.0).into()];
    let world = World::new(geometries, instances.collect()).unwrap();
    let contents = round_trip(&world, &view(), "instances");
    let toml = &contents[1].1;
    // Exactly the identity is left out, in space and in the plane.
    assert!(toml.contains("\n[[instance]]\nof = \"mesh 1\"\n\n[[instance]]\nof = \"quadric 1\"\ncolor = "), "{toml}");
    assert_eq!(toml.lines().filter(|line| line.starts_with("checker = ") && line.ends_with("]] }")).count(), 4);
}

#[test]
fn views_are_read_back() {
    let world = world(vec![Geometry::disc(1.0)]);
    let turned = Affine3 { translation: Vec3::new(-0.0, 1.0, 0.1), ..Affine3::from_rotation_y(0.3) };
    for transform in [None, Some(Affine3::IDENTITY), Some(turned)] {
        for light in [Light::Point(Vec3::ZERO), Light::Directional(Vec3::new(-0.0, 1e-45, 1e38))] {
            for vertical_fov in [1.0, 0.1 * 333.0, 170.0] {
                let view = View { vertical_fov, transform, light, ..view() };
                round_trip(&world, &view, &format!("{view:?}"));
            }
        }
    }
}

#[test]
fn meshes_come_first_and_each_kind_keeps_its_order() {
    let small = |x: f32| {
        let positions = vec![Vec3::X * x, Vec3::Y, Vec3::Z];
        Geometry::Mesh(Mesh::new(positions, vec![[0, 1, 2]], vec![part(0, GREY)]).unwrap())
    };
    let (ball, disc) = (Geometry::from(Quadric::sphere(2.0)), Geometry::disc(3.0));
    let place = |numbers: [u32; 5]| numbers.map(|number| Placement::new(number, Affine3::IDENTITY)).to_vec();
    let mixed = World::new(vec![ball.clone(), small(1.0), disc.clone(), small(2.0)], place([3, 0, 1, 2, 0])).unwrap();
    let files = Files::new();
    let path = files.path("out.toml");
    write_scene(&mixed, &view(), &path).unwrap();
    let found = load_scene(&path).unwrap().world;
    let expected = World::new(vec![small(1.0), small(2.0), ball, disc], place([1, 2, 0, 3, 2])).unwrap();
    assert_same(&bits(&found, &view()), &bits(&expected, &view()), "order");
}

/// The error, without the folder of the files.
fn refused(files: &Files, world: &World, view: &View, name: &str) -> String {
    files.shorten(&write_scene(world, view, &files.path(name)).unwrap_err().to_string())
}

#[test]
fn what_a_scene_file_cannot_hold_is_refused_before_a_file_is_written() {
    let files = Files::new();
    let ball = Geometry::from(Quadric::sphere(1.0));
    let one = |geometry: &Geometry| world(vec![ball.clone(), geometry.clone()]);
    let with = |placement: Placement| {
        let first = Placement::new(0, Affine3::IDENTITY);
        World::new(vec![Geometry::Mesh(mesh(vec![part(0, [0.5; 3])]))], vec![first, placement]).unwrap()
    };
    let first = Placement::new(0, Affine3::IDENTITY);
    let checker = |entries: [f32; 6]| {
        let uv_to_squares = Affine2::from_cols_array(&entries);
        with(first.with_paint(Paint::Checker(Checker { colors: [Vec3::ONE; 2], uv_to_squares })))
    };
    let Geometry::Faces(cylinder) = Geometry::closed_cylinder(1.0, 2.0) else { panic!() };
    let Geometry::Faces(cone) = Geometry::closed_cone(1.0, 2.0) else { panic!() };
    let negative_zero = Face::Quadric(Quadric { constant: -0.0, ..Quadric::cone(1.0, 2.0) });
    let unknown = "geometry 1: its faces are no disc, and no closed cylinder, cone or paraboloid";
    for (world, message) in [
        (
            with(first.with_mask(0x10)),
            "instance 1: the mask 0x10 cannot be written: instances of a file are in every group",
        ),
        (one(&Geometry::Faces(vec![cylinder[1], cylinder[0], cylinder[2]])), unknown),
        (one(&Geometry::Faces(cylinder[..2].to_vec())), unknown),
        (one(&Geometry::Faces(vec![cylinder[0], cone[1]])), unknown),
        (one(&Geometry::Faces(vec![cone[0]])), unknown),
        (one(&Geometry::Faces(vec![negative_zero, cone[1]])), unknown),
        (
            one(&Geometry::closed_cone(1e-16, 1.0)),
            "geometry 1: the radius is 1e-16, expected a number from 1e-15 to 1e15",
        ),
        (
            one(&Geometry::closed_cylinder(1.0, 1e16)),
            "geometry 1: the height is 1e16, expected a number from 1e-15 to 1e15",
        ),
        (
            checker([1.0, 0.0, 0.0, 0.0, 5.0, 6.0]),
            "instance 1: checker: matrix of the rows [1, 0, 5], [0, 0, 6]: its determinant is zero, or too near to \
             zero, so it has no inverse",
        ),
        (
            checker([1.0, 0.0, f32::NAN, 1.0, 0.0, 0.0]),
            "instance 1: checker: matrix of the rows [1, NaN, 0], [0, 1, 0]: not a finite number",
        ),
    ] {
        assert_eq!(refused(&files, &world, &view(), "out.toml"), format!("cannot write out.toml: {message}"));
    }
    let world = World::from(mesh(vec![part(0, [0.5; 3])]));
    let good = view();
    let singular = Affine3::from_cols_array(&[1., 2., 3., 2., 4., 6., 0., 0., 1., 0., 0., 0.]);
    for (view, message) in [
        (View { eye: Vec3::NAN, ..good }, "camera.eye is NaN, expected a finite number"),
        (View { look_at: Vec3::INFINITY, ..good }, "camera.look_at is inf, expected a finite number"),
        (
            View { eye: Vec3::X, look_at: Vec3::X, ..good },
            "camera.eye and camera.look_at give no direction: [1, 0, 0] and [1, 0, 0]",
        ),
        (View { vertical_fov: 170.1, ..good }, "camera.field_of_view is 170.1, expected degrees from 1 to 170"),
        (View { vertical_fov: f32::NAN, ..good }, "camera.field_of_view is NaN, expected degrees from 1 to 170"),
        (View { transform: Some(singular), ..good }, "camera.transform has no inverse: "),
        (View { light: Light::Point(-Vec3::INFINITY), ..good }, "light.point is -inf, expected a finite number"),
        (View { light: Light::Directional(-Vec3::ZERO), ..good }, "light.direction is zero"),
        (View { light: Light::Directional(Vec3::NAN), ..good }, "light.direction is NaN, expected a finite number"),
    ] {
        let found = refused(&files, &world, &view, "out.toml");
        assert!(found.starts_with(&format!("cannot write out.toml: {message}")), "{found}");
    }
    for (name, message) in [
        ("out.obj", "cannot write out.obj: expected a scene file (*.toml)"),
        ("out", "cannot write out: expected a scene file (*.toml)"),
        (" a.toml", "cannot write  a.toml: a mesh file cannot be named after \" a\""),
        ("a\nb.toml", "cannot write a\\nb.toml: a mesh file cannot be named after \"a\\nb\""),
    ] {
        assert_eq!(refused(&files, &world, &good, name), message);
    }
    let far = Affine3 { translation: Vec3::splat(0.123_456_79), ..Affine3::IDENTITY };
    let many = World::new(vec![ball], vec![Placement::new(0, far); 300_000]).unwrap();
    let message = refused(&files, &many, &good, "out.toml");
    assert!(message.starts_with("cannot write out.toml: 300000 instances take "), "{message}");
    assert!(message.ends_with(" bytes, but a scene file has at most 33554432"), "{message}");
    assert_eq!(names(&files.path("")), Vec::<String>::new());
}

#[test]
fn files_that_cannot_be_written_leave_all_others_as_they_were() {
    let files = Files::new();
    let old = |name: &str| fs::read_to_string(files.path(name)).unwrap();
    let world = World::from(mesh(vec![part(0, [0.5; 3])]));
    files.write("out-mesh-1.obj", "old mesh");
    files.write("out.toml", "old scene");
    fs::create_dir(files.path("out.mtl")).unwrap();
    let message = refused(&files, &world, &view(), "out.toml");
    assert!(message.starts_with("cannot write out.mtl: "), "{message}");
    assert_eq!((old("out-mesh-1.obj"), old("out.toml")), ("old mesh".into(), "old scene".into()));
    let message = refused(&files, &world, &view(), "no/out.toml");
    assert!(message.contains("there is no directory no"), "{message}");
    assert_eq!(names(&files.path("")), ["out-mesh-1.obj", "out.mtl", "out.toml"]);
    // What was there is replaced.
    fs::remove_dir(files.path("out.mtl")).unwrap();
    write_scene(&world, &view(), &files.path("out.toml")).unwrap();
    assert!(old("out-mesh-1.obj").starts_with("mtllib out.mtl\nv "));
}

#[test]
fn files_of_the_loaded_scene_are_not_written_over() {
    for taken in ["out.toml", "out-mesh-1.obj", "out.mtl"] {
        let files = Files::new();
        let (scene, mesh, library) = match taken {
            "out.toml" => (taken, "m.obj", "m.mtl"),
            "out-mesh-1.obj" => ("scene.toml", taken, "m.mtl"),
            _ => ("scene.toml", "m.obj", taken),
        };
        files.write(library, "newmtl red\nKd 1 0 0\n");
        files.write(mesh, format!("mtllib {library}\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
        let text = format!("[[mesh]]\nname = 'm'\nfile = '{mesh}'\n[[instance]]\nof = 'm'\n");
        let LoadedScene { world, view, .. } = load_scene(&files.write(scene, &text)).unwrap();
        let before = names(&files.path(""));
        assert_eq!(
            refused(&files, &world, &view, "out.toml"),
            format!("cannot write {taken}: it is also an input"),
            "{taken}"
        );
        assert_eq!((names(&files.path("")), fs::read_to_string(files.path(scene)).unwrap()), (before, text));
    }
}

#[test]
fn files_may_have_names_that_need_quotes() {
    for name in ["a b # c.toml", "it's \"so\".TOML", "back\\slash.toml", "\u{e9}\u{4e2d}.toml", "a.b.toml"] {
        let files = Files::new();
        let world = World::from(mesh(vec![part(0, [0.5; 3])]));
        let path: PathBuf = files.path(name);
        write_scene(&world, &view(), &path).unwrap();
        let found = load_scene(&path).unwrap();
        assert_same(&bits(&found.world, &found.view), &bits(&world, &view()), name);
    }
}
