//! Tests of the loader of scene files: what it loads, which files it refuses with which message, and that it never
//! panics. In `written` those of the writer.

mod files;
mod written;

use std::fs;

use glam::{Affine2, Affine3, Mat2, Mat3, Vec2, Vec3};
use raylanes::geom::{Aabb, Hit, Quadric};
use raylanes::kernels::triangle::Woop;
use raylanes::tracer::{
    BuiltIn, Camera, Checker, Geometry, Light, LoadedScene, Mode, Paint, Placement, Scene, SceneSource, View, World,
    load_scene, trace,
};

use files::{Files, is_short_line, mutate};
use raylanes::conformance::Random;

/// A corner of a cube, as an OBJ file next to the scene files of the tests.
const CORNER: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n";

fn load(text: &str) -> LoadedScene {
    let files = Files::new();
    files.write("corner.obj", CORNER);
    load_scene(&files.write("x.toml", text)).unwrap()
}

/// The world of a file. The loader must have no remarks.
fn world(text: &str) -> World {
    let scene = load(text);
    assert_eq!(scene.remarks, Vec::<String>::new());
    scene.world
}

fn error(text: impl AsRef<[u8]>) -> String {
    let files = Files::new();
    files.write("corner.obj", CORNER);
    let message = load_scene(&files.write("x.toml", text)).unwrap_err().to_string();
    files.shorten(&message)
}

const BALL: &str = "[[quadric]]\nname = \"ball\"\nsphere = { radius = 2 }\n";

/// The only placement of the ball.
fn placed(instance: &str) -> Placement {
    let world = world(&format!("{BALL}[[instance]]\nof = \"ball\"\n{instance}\n"));
    let [placement] = world.instances() else { panic!("{instance}") };
    *placement
}

#[test]
fn geometries_and_instances_are_in_file_order_meshes_first() {
    let world = world(&format!(
        "{BALL}[[instance]]\nof = 'ball'\n[[mesh]]\nname = 'corner'\nfile = 'corner.obj'\n[[instance]]\nof = 'corner'\n\
         [[mesh]]\nname = 'round'\ngenerator = 'sphere:1e3'\n[[scatter]]\nof = 'round'\ncount = 2\n\
         area = {{ lo = [0, 0], hi = [1, 1] }}\n[[instance]]\nof = 'ball'\ncolor = [1, 0, 0.5]\n"
    ));
    let [Geometry::Mesh(corner), Geometry::Mesh(round), Geometry::Quadric(ball)] = world.geometries() else { panic!() };
    assert_eq!((corner.len(), round.len(), *ball), (3, 1_152, Quadric::sphere(2.0)));
    let order: Vec<_> = world.instances().iter().map(|placement| placement.geometry).collect();
    assert_eq!(order, [2, 0, 2, 1, 1]);
    assert_eq!(world.instances()[2].paint, Paint::Plain(Vec3::new(1.0, 0.0, 0.5)));
    assert_eq!(world.instances()[1].paint, Paint::Own);
    assert_eq!(world.instances()[1].object_to_world, Affine3::IDENTITY);
}

#[test]
fn every_kind_of_quadric_calls_its_constructor() {
    let abc = Vec3::new(1.0, 2.0, 3.0);
    for (text, expected) in [
        ("sphere = { radius = 0.5 }", Quadric::sphere(0.5)),
        ("ellipsoid = { semi_axes = [1, 2, 3] }", Quadric::ellipsoid(abc)),
        ("paraboloid = { radius = 2, height = 3 }", Quadric::paraboloid(2.0, 3.0)),
        (
            "elliptic_paraboloid = { semi_axes = [1, 2], height = 3 }",
            Quadric::elliptic_paraboloid(Vec2::new(1.0, 2.0), 3.0),
        ),
        (
            "hyperboloid_of_one_sheet = { semi_axes = [1, 2, 3], half_height = 4 }",
            Quadric::hyperboloid_of_one_sheet(abc, 4.0),
        ),
        (
            "hyperboloid_of_two_sheets = { semi_axes = [1, 2, 3], half_height = 4 }",
            Quadric::hyperboloid_of_two_sheets(abc, 4.0),
        ),
        ("cone = { radius = 2, height = 3 }", Quadric::cone(2.0, 3.0)),
        ("cylinder = { radius = 2, half_height = 3 }", Quadric::cylinder(2.0, 3.0)),
        ("plane = { half_size = [2, 3] }", Quadric::plane(Vec2::new(2.0, 3.0))),
        (
            "coefficients = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]\nclip = { lo = [-1, -2, -3], hi = [1, 2, 3] }",
            Quadric {
                squares: abc,
                products: Vec3::new(4.0, 5.0, 6.0),
                linear: Vec3::new(7.0, 8.0, 9.0),
                constant: 10.0,
                clip: Aabb { lo: -abc, hi: abc },
            },
        ),
    ] {
        let world = world(&format!("[[quadric]]\nname = 'it'\n{text}\n[[instance]]\nof = 'it'\n"));
        assert_eq!(world.geometries(), [Geometry::Quadric(expected)], "{text}");
    }
    for (text, expected) in [
        ("disc = { radius = 2 }", Geometry::disc(2.0)),
        ("cylinder = { radius = 2, half_height = 3, closed = true }", Geometry::closed_cylinder(2.0, 3.0)),
        ("cylinder = { radius = 2, half_height = 3, closed = false }", Quadric::cylinder(2.0, 3.0).into()),
        ("cone = { radius = 2, height = 3, closed = true }", Geometry::closed_cone(2.0, 3.0)),
        ("paraboloid = { radius = 2, height = 3, closed = true }", Geometry::closed_paraboloid(2.0, 3.0)),
    ] {
        let world = world(&format!("[[quadric]]\nname = 'it'\n{text}\n[[instance]]\nof = 'it'\n"));
        assert_eq!(world.geometries(), [expected], "{text}");
    }
}

#[test]
fn transforms_apply_from_left_to_right() {
    let turned = Mat3::from_cols(Vec3::NEG_Z, Vec3::Y, Vec3::X);
    let doubled = Mat3::from_cols_array(&[2., 0., 10., 4., 2., 12., 6., 8., 0.]);
    for (steps, matrix, translation) in [
        ("{ translate = [1, 2, 3] }, { scale = [2, 3, 4] }", Mat3::from_diagonal(Vec3::new(2., 3., 4.)), [2., 6., 12.]),
        ("{ scale = [2, 3, 4] }, { translate = [1, 2, 3] }", Mat3::from_diagonal(Vec3::new(2., 3., 4.)), [1., 2., 3.]),
        ("{ translate = [1, 2, 3] }, { rotate_y = 90 }", turned, [3., 2., -1.]),
        ("{ rotate_y = 90 }, { translate = [1, 2, 3] }", turned, [1., 2., 3.]),
        ("{ rotate_x = 90 }", Mat3::from_cols(Vec3::X, Vec3::Z, Vec3::NEG_Y), [0.; 3]),
        ("{ rotate_z = 90.0 }", Mat3::from_cols(Vec3::Y, Vec3::NEG_X, Vec3::Z), [0.; 3]),
        (
            "{ translate = [0, 1, 0] }, { shear = { axis = 'x', by = 'y', factor = 0.5 } }",
            Mat3::from_cols(Vec3::X, Vec3::new(0.5, 1.0, 0.0), Vec3::Z),
            [0.5, 1., 0.],
        ),
        ("{ translate = [1, 2, 3] }, { scale = 2 }", Mat3::from_diagonal(Vec3::splat(2.)), [2., 4., 6.]),
        ("{ scale = -0.5 }", Mat3::from_diagonal(Vec3::splat(-0.5)), [0.; 3]),
        ("{ rotate = { axis = [0, 3, 0], degrees = 90 } }, { translate = [1, 2, 3] }", turned, [1., 2., 3.]),
        ("{ rotate = { axis = [1, 1, 0], degrees = 180 } }", Mat3::from_cols(Vec3::Y, Vec3::X, Vec3::NEG_Z), [0.; 3]),
        ("{ matrix = [[1, 2, 3, 10], [0, 1, 4, 20], [5, 6, 0, 30]] }, { scale = 2 }", doubled, [20., 40., 60.]),
        (
            "{ scale = 2 }, { matrix = [[1, 2, 3, 10], [0, 1, 4, 20], [5, 6, 0, 30], [0, -0.0, 0, 1.0]] }",
            doubled,
            [10., 20., 30.],
        ),
    ] {
        let expected = Affine3 { matrix3: matrix, translation: Vec3::from_array(translation) };
        assert_eq!(placed(&format!("transform = [{steps}]")).object_to_world, expected, "{steps}");
    }
    assert_eq!(placed("transform = []").object_to_world, Affine3::IDENTITY);
}

#[test]
fn checkers_have_their_own_transforms() {
    let checker = |transform: &str| {
        let paint = placed(&format!("checker = {{ colors = [[1, 0, 0], [0, 0, 1]]{transform} }}")).paint;
        let Paint::Checker(checker) = paint else { panic!("{paint:?}") };
        checker
    };
    assert_eq!(checker(""), Checker { colors: [Vec3::X, Vec3::Z], uv_to_squares: Affine2::IDENTITY });
    let scaled = checker(", transform = [{ scale = [4, 2] }]");
    assert_eq!([0.1, 0.3, 0.6].map(|u| scaled.at(Vec2::new(u, 0.25))), [Vec3::X, Vec3::Z, Vec3::X]);
    assert_eq!(scaled.at(Vec2::new(0.1, 0.75)), Vec3::Z);
    for (steps, matrix, translation) in [
        ("{ translate = [1, 2] }, { rotate = 90 }", Mat2::from_cols(Vec2::Y, Vec2::NEG_X), Vec2::new(-2.0, 1.0)),
        ("{ rotate = 90 }, { translate = [1, 2] }", Mat2::from_cols(Vec2::Y, Vec2::NEG_X), Vec2::new(1.0, 2.0)),
        ("{ scale = 3 }", Mat2::from_diagonal(Vec2::splat(3.0)), Vec2::ZERO),
        ("{ shear_x = 2 }", Mat2::from_cols(Vec2::X, Vec2::new(2.0, 1.0)), Vec2::ZERO),
        ("{ shear_y = 2 }", Mat2::from_cols(Vec2::new(1.0, 2.0), Vec2::Y), Vec2::ZERO),
        (
            "{ matrix = [[1, 2, 5], [3, 4, 6]] }, { scale = 2 }",
            Mat2::from_cols_array(&[2.0, 6.0, 4.0, 8.0]),
            Vec2::new(10.0, 12.0),
        ),
    ] {
        let expected = Affine2 { matrix2: matrix, translation };
        assert_eq!(checker(&format!(", transform = [{steps}]")).uv_to_squares, expected, "{steps}");
    }
}

#[test]
fn camera_and_light_come_from_the_file_or_show_the_whole_scene() {
    let ball = format!("{BALL}[[instance]]\nof = 'ball'\ntransform = [{{ translate = [10, 0, 0] }}]\n");
    let around = load(&ball).view;
    // The box of a sphere is wider than the sphere by one part in 1024.
    let radius = 2.0 + 2.0 / 1024.0;
    let bounds = Aabb { lo: Vec3::new(10.0 - radius, -radius, -radius), hi: Vec3::new(10.0 + radius, radius, radius) };
    assert_eq!(around, View::around(&bounds));

    let given = "[camera]\neye = [1, 2, 3]\nlook_at = [0, 0, 0]\n[light]\npoint = [4, 5, 6]\n";
    let view = load(&format!("{given}{ball}")).view;
    let light = Light::Point(Vec3::new(4.0, 5.0, 6.0));
    let expected =
        View { eye: Vec3::new(1.0, 2.0, 3.0), look_at: Vec3::ZERO, vertical_fov: 45.0, transform: None, light };
    assert_eq!(view, expected);

    let given = "[camera]\neye = [0, 0, 5]\nlook_at = [0, 0, 0]\nfield_of_view = 30\ntransform = [{ rotate_y = 90 }, \
                 { translate = [0, 1, 0] }]\n[light]\ndirection = [0, 1, 0]\n";
    let view = load(&format!("{given}{ball}")).view;
    assert_eq!(view.light, Light::Directional(Vec3::Y));
    // After a quarter of a turn about y, the camera at z = 5 that looks along -z is at x = 5 and looks along -x.
    let moved = Camera::new(Vec3::new(5.0, 1.0, 0.0), Vec3::Y, 30.0, 8, 8).rays(8, 8);
    for (ray, expected) in view.camera(8, 8).rays(8, 8).iter().zip(&moved) {
        assert_eq!((ray.origin, ray.dir), (expected.origin, expected.dir));
    }
}

#[test]
fn unused_and_ignored_parts_are_remarked() {
    let scene = load(&format!("{BALL}[[mesh]]\nname = 'spare\\n'\nfile = 'corner.obj'\n[[instance]]\nof = 'ball'\n"));
    assert_eq!(scene.remarks, ["never placed: \"spare\\n\""]);
    let files = Files::new();
    files.write("flat.obj", format!("{CORNER}f 1 1 2\nl 1 2\n"));
    let text = "[[mesh]]\nname = 'corner'\nfile = 'flat.obj'\n[[instance]]\nof = 'corner'\n";
    assert_eq!(
        load_scene(&files.write("x.toml", text)).unwrap().remarks,
        ["corner: triangles of zero area, which no ray hits: 1", "corner: points, lines and curves, ignored: 1"]
    );
}

#[test]
fn paths_are_relative_to_the_scene_file() {
    let files = Files::new();
    fs::create_dir_all(files.path("scenes/models")).unwrap();
    files.write("scenes/models/corner.OBJ", CORNER);
    files.write("up.obj", CORNER);
    for path in ["models/corner.OBJ", "../up.obj", "./models/../../up.obj", files.path("up.obj").to_str().unwrap()] {
        let text = format!("[[mesh]]\nname = 'it'\nfile = '{path}'\n[[instance]]\nof = 'it'\n");
        assert_eq!(load_scene(&files.write("scenes/x.toml", text)).unwrap().world.geometries()[0].primitives(), 3);
    }
    // An error in an OBJ file names the OBJ file.
    files.write("scenes/bad.obj", format!("{CORNER}v 1 nan 3\n"));
    let message = |file: &str| {
        let text = format!("[[mesh]]\nname = 'it'\nfile = '{file}'\n[[instance]]\nof = 'it'\n");
        files.shorten(&load_scene(&files.write("scenes/x.toml", text)).unwrap_err().to_string())
    };
    assert_eq!(message("bad.obj"), "scenes/bad.obj:8: vertex coordinate is NaN: \"v 1 nan 3\"");
    assert_eq!(message("none.obj"), "cannot read scenes/none.obj: No such file or directory");
}

/// Each wrong line is added to a file that is otherwise right.
#[test]
fn errors_name_line_and_key() {
    let good = format!("# A comment.\n\n\n{BALL}\n[[instance]]\nof = \"ball\"\n");
    load(&good);
    let mut wrong = Vec::new();
    for (lines, message) in [
        ("of = 'ball'", "10: duplicate key: \"of = 'ball'\""),
        ("color = [0, 1]", "10: instance.color: invalid length 2, expected an array of length 3"),
        ("color = [0, 1.5, 0]", "10: instance.color: invalid value: `1.5`, expected a number from 0 to 1"),
        ("\n\ncolor = [\n0,\n-1,\n0]", "14: instance.color: invalid value: `-1`, expected a number from 0 to 1"),
        ("color = 'red'", "10: instance.color: invalid type: string \"red\", expected an array of length 3"),
        (
            "colour = [1, 1, 1]",
            "10: instance.colour: unknown field `colour`, expected one of `of`, `transform`, `color`, `checker`",
        ),
        (
            "color = [0, 0, 0]\nchecker = { colors = [[0, 0, 0], [1, 1, 1]] }",
            "8: instance: either color or checker, not both",
        ),
        ("checker = { }", "10: instance.checker: missing field `colors`"),
        (
            "checker = { colors = [[0, 0, 0], [0, 0, 2]] }",
            "10: instance.checker.colors: invalid value: `2`, expected a number from 0 to 1",
        ),
        (
            "checker = { colors = [[0, 0, 0], [1, 1, 1]], transform = [{ scale = [0, 1] }] }",
            "10: instance.checker.transform: scaling by [0, 1]: a factor of zero has no inverse",
        ),
        (
            "checker = { colors = [[0, 0, 0], [1, 1, 1]], transform = [{ scale = [1e30, 1] }, { scale = [1e30, 1] }] }",
            "10: instance.checker.transform: too large: ",
        ),
        (
            "checker = { colors = [[0, 0, 0], [1, 1, 1]], transform = [{ matrix = [[1, 2, 3]] }] }",
            "10: instance.checker.transform.matrix: invalid length 1, expected an array of length 2",
        ),
        (
            "checker = { colors = [[0, 0, 0], [1, 1, 1]], transform = [{ matrix = [[1, 2, 3], [2, 4, 6]] }] }",
            "10: instance.checker.transform: matrix of the rows [1, 2, 3], [2, 4, 6]: its determinant is zero, or too \
             near to zero, so it has no inverse",
        ),
        ("transform = { scale = [1, 1, 1] }", "10: instance.transform: invalid type: map, expected a sequence"),
        (
            "transform = [{ scale = [1, 1] }]",
            "10: instance.transform.scale: invalid length 2, expected an array of length 3",
        ),
        (
            "transform = [\n{ scale = [1, 1, 1] },\n{ scale = [1, 0, 1] },\n]",
            "12: instance.transform: scaling by [1, 0, 1]: a factor of zero has no inverse",
        ),
        (
            "transform = [{ shear = { axis = 'x', by = 'x', factor = 1 } }]",
            "10: instance.transform: shear of x by x with factor 1: an axis cannot be sheared by itself",
        ),
        (
            "transform = [{ shear = { axis = 'w', by = 'x', factor = 1 } }]",
            "10: instance.transform.shear.axis: unknown variant `w`, expected one of `x`, `y`, `z`",
        ),
        ("transform = [{ shear = { axis = 'x', by = 'y' } }]", "10: instance.transform.shear: missing field `factor`"),
        (
            "transform = [{ shear = { axis = 'x', by = 'y', factor = 1, of = 2 } }]",
            "10: instance.transform.shear.of: unexpected keys in table: of, available keys: axis, by, factor",
        ),
        (
            "transform = [{ turn = 1 }]",
            "10: instance.transform.turn: unknown variant `turn`, expected one of `translate`, `scale`, \
             `rotate_x`, `rotate_y`, `rotate_z`, `rotate`, `shear`, `matrix`",
        ),
        (
            "transform = [{ scale = 0 }]",
            "10: instance.transform: scaling by [0, 0, 0]: a factor of zero has no inverse",
        ),
        (
            "transform = [{ scale = inf }]",
            "10: instance.transform.scale: invalid value: `inf`, expected a finite number",
        ),
        (
            "transform = [{ scale = '2' }]",
            "10: instance.transform.scale: invalid type: string \"2\", expected a finite number or an array \
             of length 3",
        ),
        (
            "checker = { colors = [[0, 0, 0], [1, 1, 1]], transform = [{ scale = [1, 2, 3] }] }",
            "10: instance.checker.transform.scale: invalid length 3, expected an array of length 2",
        ),
        (
            "transform = [{ translate = [1, 2, 3, 4] }]",
            "10: instance.transform.translate: invalid length 4, expected an array of length 3",
        ),
        (
            "checker = { colors = [[0, 0, 0], [1, 1, 1], [0, 1, 0]] }",
            "10: instance.checker.colors: invalid length 3, expected an array of length 2",
        ),
        (
            "transform = [{ matrix = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0, 0]] }]",
            "10: instance.transform.matrix: invalid length 5, expected an array of length 4",
        ),
        (
            "transform = [\n{ rotate_x = 3 },\n{ rotate = { axis = [0, 0, -0.0], degrees = 30 } }]",
            "12: instance.transform: rotation about [0, 0, -0] by 30 degrees: an axis of length zero has no direction",
        ),
        (
            "transform = [{ rotate = { axis = [0, nan, 1], degrees = 30 } }]",
            "10: instance.transform.rotate.axis: invalid value: `NaN`, expected a finite number",
        ),
        ("transform = [{ rotate = { axis = [0, 0, 1] } }]", "10: instance.transform.rotate: missing field `degrees`"),
        (
            "transform = [{ rotate = 1 }]",
            "10: instance.transform.rotate: invalid type: integer `1`, expected a table of axis and degrees",
        ),
        (
            "transform = [{ matrix = [[1, 0, 0, 0],\n[0, 1, 0, 0]] }]",
            "10: instance.transform.matrix: invalid length 2, expected 3 or 4 rows",
        ),
        (
            "transform = [{ matrix = [[1, 0, 0],\n[0, 1, 0], [0, 0, 1]] }]",
            "10: instance.transform.matrix: invalid length 3, expected an array of length 4",
        ),
        (
            "transform = [{ matrix = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [4, 5, 6, 1]] }]",
            "10: instance.transform.matrix: the last of four rows must be [0, 0, 0, 1]; a translation is the last \
             column: [4, 5, 6, 1]",
        ),
        (
            "transform = [{ matrix = [[1, 0, 0, 0], [0, 1, 0, nan], [0, 0, 1, 0]] }]",
            "10: instance.transform.matrix: invalid value: `NaN`, expected a finite number",
        ),
        (
            "transform = [{ matrix = [[1, 2, 3, 0], [2, 4, 6, 0], [0, 0, 1, 0]] }]",
            "10: instance.transform: matrix of the rows [1, 2, 3, 0], [2, 4, 6, 0], [0, 0, 1, 0]: its determinant is \
             zero, or too near to zero, so it has no inverse",
        ),
        (
            "transform = [{ rotate_x = nan }]",
            "10: instance.transform.rotate_x: invalid value: `NaN`, expected a finite number",
        ),
        (
            "transform = [{ translate = [0, -inf, 0] }]",
            "10: instance.transform.translate: invalid value: `-inf`, expected a finite number",
        ),
        (
            "transform = [{ translate = [0, 1e39, 0] }]",
            "10: instance.transform.translate: invalid value: `1e39`, expected a finite number",
        ),
        (
            "transform = [{ scale = [1, 1, 1], rotate_x = 3 }]",
            "10: instance.transform: wanted exactly 1 element, more than 1 element",
        ),
        (
            "transform = [{ scale = [1e30, 1, 1] }, { scale = [1e30, 1, 1] }]",
            "10: instance.transform: too large, or has no inverse: ",
        ),
        (
            "transform = [{ scale = [1e-30, 1, 1] }, { scale = [1e-30, 1, 1] }]",
            "10: instance.transform: too large, or has no inverse: ",
        ),
        ("[[instance]]", "10: instance: missing field `of`"),
        ("[[instance]]\nof = 'bell'", "11: instance.of: no mesh or quadric has this name: \"bell\""),
        ("[instance]", "10: duplicate key: \"[instance]\""),
        (
            "[[instances]]",
            "10: instances: unknown field `instances`, expected one of `camera`, `light`, `mesh`, `quadric`, \
             `instance`, `scatter`",
        ),
        (
            "[[mesh]]\nname = 'ball'\nfile = 'corner.obj'\n",
            "5: quadric.name: another mesh or quadric has this name: \"ball\"",
        ),
        ("[[mesh]]\nname = 'm'", "10: mesh: a mesh needs either file or generator"),
        (
            "[[mesh]]\nname = 'm'\nfile = 'corner.obj'\ngenerator = 'room'",
            "10: mesh: a mesh needs either file or generator",
        ),
        (
            "[[mesh]]\nname = 'm'\nfile = 'x.toml'",
            "12: mesh.file: expected an OBJ, PLY or STL file (*.obj, *.ply, *.stl): \"x.toml\"",
        ),
        ("[[mesh]]\nfile = 'corner.obj'", "10: mesh: missing field `name`"),
        (
            "[[mesh]]\nname = 'm'\ngenerator = 'forest'",
            "12: mesh.generator: no such generator, expected one of room, terrain, sphere, tree, square: \"forest\"",
        ),
        (
            "[[mesh]]\nname = 'm'\ngenerator = 'room:1'",
            "12: mesh.generator: the size must be one of small, medium, large or a number of triangles from 1000 to \
             10000000: \"room:1\"",
        ),
        (
            "[[quadric]]\nname = 'q'",
            "10: quadric: a quadric needs its kind, such as sphere, or coefficients with a clip box",
        ),
        (
            "[[quadric]]\nname = 'q'\nsphere = { radius = 1 }\ncone = { radius = 1, height = 1 }",
            "10: quadric: a quadric is of one kind only",
        ),
        (
            "[[quadric]]\nname = 'q'\nsphere = { radius = 1 }\nclip = { lo = [0, 0, 0], hi = [1, 1, 1] }",
            "10: quadric: a quadric is of one kind only",
        ),
        (
            "[[quadric]]\nname = 'q'\nclip = { lo = [0, 0, 0], hi = [1, 1, 1] }",
            "10: quadric: coefficients and clip need each other",
        ),
        (
            "[[quadric]]\nname = 'q'\nsphere = { radius = -1 }",
            "12: quadric.sphere.radius: invalid value: `-1`, expected a number from 1e-15 to 1e15",
        ),
        (
            "[[quadric]]\nname = 'q'\n[quadric.sphere]\n\nradius = 1e20",
            "14: quadric.sphere.radius: invalid value: `1e20`, expected a number from 1e-15 to 1e15",
        ),
        ("[[quadric]]\nname = 'q'\nsphere = { }", "12: quadric.sphere: missing field `radius`"),
        (
            "[[quadric]]\nname = 'q'\ncone = { radius = 1, height = '1' }",
            "12: quadric.cone.height: invalid type: string \"1\", expected a number from 1e-15 to 1e15",
        ),
        (
            "[[quadric]]\nname = 'q'\ncoefficients = [1, 2, 3]",
            "12: quadric.coefficients: invalid length 3, expected an array of length 10",
        ),
        (
            "[[quadric]]\nname = 'q'\nhyperboloid_of_two_sheets = { semi_axes = [1, 1, 2], half_height = 1.5 }",
            "10: quadric: half_height must be greater than the third semi-axis, where the two sheets begin",
        ),
        (
            "[[quadric]]\nname = 'q'\ncoefficients = [0, 0, 0, 0, 0, 0, 0, 0, 0, 1]\n\
             clip = { lo = [0, 0, 0], hi = [1, 1, 1] }",
            "11: quadric.name: no ray hits it: the coefficients are too large or all zero, or the box is empty: \"q\"",
        ),
        (
            "[[quadric]]\nname = 'q'\ncoefficients = [1, 0, 0, 0, 0, 0, 0, 0, 0, 1]\n\
             clip = { lo = [0, 0, 1], hi = [1, 1, 0] }",
            "11: quadric.name: no ray hits it: the coefficients are too large or all zero, or the box is empty: \"q\"",
        ),
        (
            "[[quadric]]\nname = 'q'\nplane = { half_size = [1, 0] }",
            "12: quadric.plane.half_size: invalid value: `0`, expected a number from 1e-15 to 1e15",
        ),
        ("[camera]\neye = [0, 0, 0]", "10: camera: missing field `look_at`"),
        (
            "[camera]\neye = [1, 2, 3]\nlook_at = [1, 2, 3]",
            "10: camera: eye and look_at give no direction: [1, 2, 3] and [1, 2, 3]",
        ),
        (
            "[camera]\neye = [0, 0, 1]\nlook_at = [0, 0, 0]\nfield_of_view = 180",
            "13: camera.field_of_view: invalid value: `180`, expected degrees from 1 to 170",
        ),
        (
            "[camera]\neye = [0, 0, 1]\nlook_at = [0, 0, 0]\nup = [0, 1, 0]",
            "13: camera.up: unknown field `up`, expected one of `eye`, `look_at`, `field_of_view`, `transform`",
        ),
        (
            "[camera]\neye = [0, 0, 1]\nlook_at = [0, 0, 0]\ntransform = [{ scale = [1, 1, 0] }]",
            "13: camera.transform: scaling by [1, 1, 0]: a factor of zero has no inverse",
        ),
        ("[light]", "10: light: a light needs either point or direction"),
        ("[light]\npoint = [0, 0, 0]\ndirection = [0, 1, 0]", "10: light: a light needs either point or direction"),
        ("[light]\ndirection = [0, 0, 0]", "11: light.direction: no direction: [0, 0, 0]"),
        ("[scatter]\nof = 'ball'", "10: scatter: invalid type: map, expected a sequence"),
        ("[[scatter]]\nof = 'ball'", "10: scatter: missing field `count`"),
        ("[[scatter]]\nof = 'ball'\ncount = 1", "10: scatter: a scatter needs on or area"),
        (
            "[[scatter]]\nof = 'ball'\ncount = 0",
            "12: scatter.count: invalid value: `0`, expected a whole number from 1 to 10000000",
        ),
        (
            "[[scatter]]\nof = 'ball'\ncount = 1.5",
            "12: scatter.count: invalid value: `1.5`, expected a whole number from 1 to 10000000",
        ),
        ("[[scatter]]\nof = 'ball'\ncount = 1e7\non = 'ball'", "12: scatter.count: more than 10000000 instances"),
        (
            "[[scatter]]\nof = 'ball'\ncount = 1\nseed = -1",
            "13: scatter.seed: invalid value: `-1`, expected a whole number from 0 to 4294967295",
        ),
        (
            "[[scatter]]\nof = 'ball'\ncount = 1\non = 'floor'",
            "13: scatter.on: no mesh or quadric has this name: \"floor\"",
        ),
        (
            "[[scatter]]\nof = 'ball'\ncount = 1\non = 'm'\n[[mesh]]\nname = 'm'\nfile = 'corner.obj'",
            "13: scatter.on: there is no instance of this to stand on: \"m\"",
        ),
        (
            "[[scatter]]\nof = 'ball'\ncount = 1\non = 'ball'\narea = { lo = [9, 9], hi = [10, 10] }",
            "10: scatter: found no ground at 64 random places in the area",
        ),
        (
            "[[scatter]]\nof = 'ball'\ncount = 1\narea = { lo = [0, 1], hi = [1, 0] }",
            "13: scatter.area: empty: from [0, 1] to [1, 0]",
        ),
        (
            "[[scatter]]\nof = 'ball'\ncount = 1\narea = { lo = [0, 0], hi = [1, 1] }\nscale = [2, 1]",
            "14: scatter.scale: the least scale comes first: [2, 1]",
        ),
        (
            "[[scatter]]\nof = 'ball'\ncount = 1\nlean = 2",
            "13: scatter.lean: invalid value: `2`, expected a number from 0 to 1",
        ),
        (
            "[[scatter]]\nof = 'ball'\ncount = 1\narea = { lo = [0, 0], hi = [1, 1] }\nscale = [1e15, 1e15]\n\
             transform = [{ scale = [1e30, 1, 1] }]",
            "10: scatter: instance 0 has no inverse: ",
        ),
        (
            "camera = 3",
            "10: instance.camera: unknown field `camera`, expected one of `of`, `transform`, `color`, `checker`",
        ),
        ("of", "10: "),
        ("transform = [{ scale = [1, 1, 1] }", "10: "),
        ("= 3", "10: "),
        ("a.b.c = \u{7}", "10: "),
    ] {
        let found = error(format!("{good}{lines}\n"));
        let expected = format!("x.toml:{message}");
        // If the end of the message comes from the parser or prints a matrix, only its beginning is compared.
        let is_right = if message.ends_with(": ") { found.starts_with(&expected) } else { found == expected };
        if !is_right || !is_short_line(&found) {
            wrong.push(format!("{lines}\nexpected {expected}\ngot      {found}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

#[test]
fn files_that_are_no_scenes_are_refused() {
    for text in ["", "\n", "# nothing\n", "[camera]\neye = [0, 0, 1]\nlook_at = [0, 0, 0]\n", BALL] {
        assert_eq!(error(text), "x.toml: no instances", "{text:?}");
    }
    assert_eq!(error(b"# \xc3\xa9\n\nname = '\xff\xfe'\n"), "x.toml:3: not UTF-8: \"\u{fffd}\u{fffd}'\"");
    assert_eq!(error(vec![b'#'; (1 << 25) + 1]), "cannot read x.toml: longer than 33554432 bytes");
    // Too deep nesting, and words of megabytes.
    for text in ["[".repeat(100_000), "a = ".to_owned() + &"[".repeat(100_000), "a.".repeat(100_000) + "a = 1"] {
        let message = error(&text);
        assert!(message.starts_with("x.toml:1: ") && is_short_line(&message), "{message}");
    }
    let long = "x".repeat(1_000_000);
    for text in
        [format!("{long} = 1"), format!("[camera]\neye = '{long}'"), format!("{BALL}[[instance]]\nof = '{long}'")]
    {
        let message = error(&text);
        assert!(message.starts_with("x.toml:") && message.chars().count() < 700, "{message}");
    }
    let files = Files::new();
    let message = |name: &str| files.shorten(&load_scene(&files.path(name)).unwrap_err().to_string());
    assert_eq!(message("none.toml"), "cannot read none.toml: No such file or directory");
    fs::create_dir(files.path("directory.toml")).unwrap();
    assert_eq!(message("directory.toml"), "cannot read directory.toml: Is a directory");
}

/// A tilted square of ten by ten.
const FLOOR: &str = "[[mesh]]\nname = 'floor'\ngenerator = 'square'\n[[instance]]\nof = 'floor'\n\
                     transform = [{ translate = [-0.5, 0, -0.5] }, { scale = [10, 1, 10] }, { rotate_z = 30 }, \
                     { translate = [0, 100, 0] }]\n";

#[test]
fn scattered_instances_stand_on_the_ground_in_the_area() {
    let on = format!("{FLOOR}{BALL}[[scatter]]\nof = 'ball'\non = 'floor'\ncount = 1000\n");
    let feet = |text: &str| -> Vec<Vec3> {
        world(text).instances()[1..].iter().map(|placement| placement.object_to_world.translation).collect()
    };
    let all = feet(&on);
    assert_eq!(all.len(), 1000);
    let slope = 1.0 / 3f32.sqrt();
    for &Vec3 { x, y, z } in &all {
        // An ulp of 100 is 7.6e-6.
        assert!((y - (100.0 + x * slope)).abs() < 3e-5, "{x} {y}");
        assert!(x.abs() <= 5.0 && z.abs() <= 5.0, "{x} {z}");
    }
    let spread = |x: fn(&Vec3) -> f32| all.iter().map(x).fold(0.0, f32::max) - all.iter().map(x).fold(0.0, f32::min);
    assert!(spread(|foot| foot.x) > 8.4 && spread(|foot| foot.z) > 9.8);

    // Half of this area has no ground.
    let part = feet(&format!("{on}area = {{ lo = [4, 1], hi = [5, 2] }}\n"));
    assert!(part.iter().all(|&Vec3 { x, z, .. }| (4.0..=4.3302).contains(&x) && (1.0..=2.0).contains(&z)));

    assert_eq!(feet(&on), all);
    assert_ne!(feet(&format!("{on}seed = 1\n")), all);
    let flat = feet(&format!(
        "{BALL}[[instance]]\nof = 'ball'\n[[scatter]]\nof = 'ball'\ncount = 9\narea = {{ lo = [4, 1], hi = [5, 2] }}\n"
    ));
    assert!(flat.iter().all(|foot| foot.y == 0.0) && flat.len() == 9);
}

#[test]
fn scattered_instances_are_rotated_scaled_and_sheared() {
    let scattered = |more: &str| -> Vec<Affine3> {
        let text =
            format!("{BALL}[[scatter]]\nof = 'ball'\ncount = 500\narea = {{ lo = [0, 0], hi = [0, 0] }}\n{more}");
        world(&text).instances().iter().map(|placement| placement.object_to_world).collect()
    };
    for transform in scattered("") {
        let Mat3 { x_axis, y_axis, z_axis } = transform.matrix3;
        assert_eq!((y_axis, transform.translation), (Vec3::Y, Vec3::ZERO));
        assert!(x_axis.cross(z_axis).abs_diff_eq(Vec3::NEG_Y, 1e-6) && x_axis.is_normalized());
    }
    // Rotated in every direction: each eighth of the circle gets its share.
    let eighths = scattered("").iter().fold([0; 8], |mut eighths, transform| {
        let Vec3 { x, z, .. } = transform.matrix3.x_axis;
        eighths[usize::from(x > 0.0) + 2 * usize::from(z > 0.0) + 4 * usize::from(x.abs() > z.abs())] += 1;
        eighths
    });
    assert!(eighths.iter().all(|&count| (30..100).contains(&count)), "{eighths:?}");

    let heights: Vec<_> = scattered("scale = [0.5, 2]\n").iter().map(|transform| transform.matrix3.y_axis.y).collect();
    assert!(heights.iter().all(|height| (0.5..=2.0).contains(height)));
    assert!(heights.iter().any(|&height| height < 0.6) && heights.iter().any(|&height| height > 1.9));

    let tops: Vec<_> = scattered("lean = 0.25\n").iter().map(|transform| transform.matrix3.y_axis).collect();
    assert!(tops.iter().all(|top| top.y == 1.0 && Vec2::new(top.x, top.z).length() <= 0.25));
    assert!(tops.iter().any(|top| top.x > 0.15) && tops.iter().any(|top| top.z < -0.15));

    // The instance's own transform comes first: here it lifts the ball, which is then scaled.
    for transform in scattered("scale = [2, 2]\ntransform = [{ translate = [0, 3, 0] }]\n") {
        assert_eq!(transform.translation, Vec3::new(0.0, 6.0, 0.0));
    }
}

fn built_in(argument: &str) -> LoadedScene {
    let scene = SceneSource::parse(argument).unwrap().load().unwrap();
    assert_eq!(scene.remarks, Vec::<String>::new());
    scene
}

#[test]
fn built_in_scenes_are_files_that_load() {
    for name in BuiltIn::NAMES {
        let LoadedScene { world, view, .. } = built_in(name);
        // The camera must see something.
        let rays = view.camera(32, 32).rays(32, 32);
        let hits = trace(&Scene::<Woop<f32>>::new(world), &rays, Mode::Packet);
        assert!(hits.iter().filter(|hit| hit.mask).count() > 300, "{name}");
    }
    let forest = built_in("forest:5e3").world;
    assert_eq!(forest.instances().len(), 1 + 5_000 + 3_000);
    let gallery = built_in("gallery").world;
    let quadrics = gallery.geometries().iter().filter(|geometry| matches!(geometry, Geometry::Quadric(_)));
    assert_eq!(quadrics.count(), 8);
    // Each is more than translated.
    for placement in &gallery.instances()[1..] {
        let Mat3 { x_axis, y_axis, z_axis } = placement.object_to_world.matrix3;
        let is_sheared =
            [x_axis.dot(y_axis), y_axis.dot(z_axis), z_axis.dot(x_axis)].iter().any(|dot| dot.abs() > 0.01);
        let lengths = [x_axis, y_axis, z_axis].map(Vec3::length);
        assert!(is_sheared || (0..3).any(|axis| (lengths[axis] - 1.0).abs() > 0.01), "{placement:?}");
        assert!(x_axis.with_x(0.0) != Vec3::ZERO || y_axis.with_y(0.0) != Vec3::ZERO, "{placement:?}");
    }
    for argument in ["gallery:1e4", "forest:1", "room:tiny"] {
        let message = SceneSource::parse(argument).unwrap_err().to_string();
        assert!(message.starts_with(&format!("{argument}: the ")), "{message}");
    }
}

/// If the sum changes, the scene has changed, and old measurements can no longer be compared.
#[test]
fn the_forest_is_the_same_on_every_machine() {
    let forest = built_in("forest:1000").world;
    let sum = forest
        .instances()
        .iter()
        .flat_map(|placement| placement.object_to_world.to_cols_array().map(f32::to_bits))
        .fold(0xcbf2_9ce4_8422_2325u64, |sum, word| (sum ^ u64::from(word)).wrapping_mul(0x0000_0100_0000_01b3));
    assert_eq!(format!("{sum:016x}"), "2612121470b5bf69");
}

/// The example in the README, with the file that it names.
#[test]
fn the_example_of_the_readme_loads() {
    let readme = include_str!("../README.md");
    let section = readme.split("\n## ").find(|section| section.starts_with("Scenes\n")).unwrap();
    let example = section.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let files = Files::new();
    fs::create_dir(files.path("models")).unwrap();
    files.write("models/hill.obj", "v -9 0 -9\nv 9 0 -9\nv 0 0 9\nv 0 2 0\nf 1 4 2\nf 2 4 3\nf 3 4 1\n");
    let scene = load_scene(&files.write("scene.toml", example)).unwrap();
    assert_eq!(scene.remarks, Vec::<String>::new());
    assert_eq!((scene.world.geometries().len(), scene.world.instances().len()), (4, 3 + 5000));
    // The alternatives in its comments work too.
    for (instead, of) in
        [("point = [1, 2, 1]", "direction = [1, 2, 1]"), ("area = { lo = [-20, -20], hi = [20, 20] }", "on = \"hill\"")]
    {
        assert!(example.contains(of));
        load_scene(&files.write("scene.toml", example.replace(of, instead))).unwrap();
    }
}

/// Replaces a digit by another number or a part of one. The text mostly stays well-formed.
fn with_another_number(text: &str, random: &mut Random) -> Vec<u8> {
    const NUMBERS: [&str; 12] = ["0", "1", "7", "-1", "0.5", "1.", "1e9", "1e-20", "1e38", "1e39", "nan", "inf"];
    let digits: Vec<_> = text.bytes().enumerate().filter(|(_, byte)| byte.is_ascii_digit()).map(|(at, _)| at).collect();
    let at = digits[random.below(digits.len())];
    let mut bytes = text.as_bytes().to_vec();
    bytes.splice(at..=at, NUMBERS[random.below(NUMBERS.len())].bytes());
    bytes
}

#[test]
fn corrupted_files_neither_panic_nor_make_invalid_worlds() {
    const PIECES: [&str; 30] = [
        "\n",
        " ",
        "=",
        "[",
        "]",
        "{",
        "}",
        ",",
        ".",
        "\"",
        "'",
        "#",
        "-",
        "0",
        "9",
        "e9",
        "nan",
        "inf",
        "true",
        "\r",
        "\0",
        "\u{e9}",
        "[[",
        "]]",
        "[[instance]]\n",
        "of = \"a\"\n",
        "name = \"b\"\n",
        "{ scale = [0, 1, 1] }, ",
        "1979-05-27",
        "\u{feff}",
    ];
    const SCENE: &str = "[camera]\neye = [0, 2, 8]\nlook_at = [0, 1, 0]\nfield_of_view = 45\n\
        transform = [{ rotate_y = 20 }]\n[light]\npoint = [1, 2, 1]\n[[mesh]]\nname = \"a\"\ngenerator = \"square\"\n\
        [[mesh]]\nname = \"c\"\nfile = \"corner.obj\"\n[[quadric]]\nname = \"q\"\ncone = { radius = 1, height = 2 }\n\
        [[quadric]]\nname = \"s\"\ncoefficients = [1, -1, 0, 0, 0, 0, 0, 0, -1, 0]\n\
        clip = { lo = [-1, -1, -1], hi = [1, 1, 1] }\n[[instance]]\nof = \"a\"\n[[instance]]\nof = \"s\"\n\
        transform = [{ scale = [1, 2, 1] }, { shear = { axis = \"x\", by = \"y\", factor = 0.5 } }]\n\
        color = [0.8, 0.3, 0.2]\n[[instance]]\nof = \"s\"\ntransform = [{ scale = 2 }, \
        { rotate = { axis = [1, 2, 3], degrees = 30 } }, { matrix = [[1, 0, 0, 4], [2, 1, 0, 5], [0, 3, 1, 6]] }]\n\
        [[instance]]\nof = \"q\"\nchecker = { colors = [[0, 0, 0], [1, 1, 1]], \
        transform = [{ rotate = 30 }] }\n[[scatter]]\nof = \"c\"\non = \"a\"\ncount = 3\nseed = 1\n\
        scale = [0.5, 2]\nlean = 0.1\n";
    let files = Files::new();
    files.write("corner.obj", CORNER);
    load_scene(&files.write("x.toml", SCENE)).unwrap();
    let mut random = Random::from_seed(1);
    let (mut loaded, mut refused, mut with_line) = (0, 0, 0);
    for round in 0..20_000 {
        let text =
            if round % 2 == 0 { mutate(SCENE, &PIECES, &mut random) } else { with_another_number(SCENE, &mut random) };
        let file = files.write("x.toml", text);
        match load_scene(&file) {
            Ok(LoadedScene { world, view, remarks }) => {
                loaded += 1;
                assert!(world.instances().iter().all(|placement| placement.object_to_world.is_finite()));
                assert!(view.eye.is_finite() && (1.0..=170.0).contains(&view.vertical_fov));
                assert!(remarks.iter().all(|remark| is_short_line(remark)), "{remarks:?}");
                if loaded % 100 == 0 {
                    let scene = Scene::<Woop<f32>>::new(world);
                    let rays = view.camera(4, 4).rays(4, 4);
                    let scalar = trace(&scene, &rays, Mode::Scalar);
                    assert_eq!(scalar, trace(&scene, &rays, Mode::Packet));
                }
            }
            Err(error) => {
                refused += 1;
                let message = files.shorten(&error.to_string());
                assert!(is_short_line(&message), "{message}");
                with_line += usize::from(message.starts_with("x.toml:"));
            }
        }
        // Removed first: some file systems wait for the disk when a file is overwritten.
        fs::remove_file(file).unwrap();
    }
    // Both branches above must have run often.
    assert!(loaded > 2_000 && refused > 2_000, "{loaded} loaded, {refused} refused");
    assert!(with_line * 100 > refused * 95, "only {with_line} of {refused} errors name a line");
}

/// Scalar code, packets and brute force hit the same instances of the forest.
#[test]
fn the_forest_has_identical_hits() {
    let LoadedScene { world, view, .. } = built_in("forest:1000");
    let scene = Scene::<Woop<f32>>::new(world);
    let rays = view.camera(64, 64).rays(64, 64);
    let scalar = trace(&scene, &rays, Mode::Scalar);
    let bits = |hits: &[Hit<f32>]| hits.iter().map(Hit::to_bits).collect::<Vec<_>>();
    assert_eq!(bits(&scalar), bits(&trace(&scene, &rays, Mode::Packet)));
    for (ray, hit) in rays.iter().zip(&scalar).step_by(1021) {
        assert_eq!(scene.closest_hit_brute_force(ray).to_bits(), hit.to_bits());
    }
    let trees = scalar.iter().filter(|hit| hit.mask && (1..=1000).contains(&hit.instance)).count();
    assert!(trees > 40, "only {trees} rays hit trees");
}
