//! Scene files: what they make, what is refused and with which words, and that nothing makes the loader panic.

mod files;
mod random;

use std::fs;

use glam::{Affine2, Affine3, Mat2, Mat3, Vec2, Vec3};
use raylanes::geom::{Aabb, Quadric, Ray, Triangle};
use raylanes::kernels::Intersect;
use raylanes::kernels::triangle::Woop;
use raylanes::tracer::{
    BuiltIn, Camera, Checker, Geometry, Light, LoadedScene, Mode, Paint, Placement, Scene, SceneSource, View, World,
    load_scene, trace,
};

use files::{Files, is_short_line, mutate};
use random::Random;

/// A corner of a cube, beside the scene files of the tests.
const CORNER: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n";

fn load(text: &str) -> LoadedScene {
    let files = Files::new();
    files.write("corner.obj", CORNER);
    load_scene(&files.write("x.toml", text)).unwrap()
}

/// The world of a file that nothing is to be said about.
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
         [[mesh]]\nname = 'round'\ngenerator = 'sphere:1e3'\n[[scatter]]\nof = 'round'\ncount = 2\narea = {{ lo = [0, 0], \
         hi = [1, 1] }}\n[[instance]]\nof = 'ball'\ncolor = [1, 0, 0.5]\n"
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
fn every_kind_of_quadric_is_its_constructor() {
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
}

#[test]
fn transforms_apply_from_left_to_right() {
    let turned = Mat3::from_cols(Vec3::NEG_Z, Vec3::Y, Vec3::X);
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
    ] {
        let expected = Affine3 { matrix3: matrix, translation: Vec3::from_array(translation) };
        assert_eq!(placed(&format!("transform = [{steps}]")).object_to_world, expected, "{steps}");
    }
    assert_eq!(placed("transform = []").object_to_world, Affine3::IDENTITY);
}

#[test]
fn checkers_have_their_own_transforms_of_the_plane() {
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
        ("{ shear_x = 2 }", Mat2::from_cols(Vec2::X, Vec2::new(2.0, 1.0)), Vec2::ZERO),
        ("{ shear_y = 2 }", Mat2::from_cols(Vec2::new(1.0, 2.0), Vec2::Y), Vec2::ZERO),
    ] {
        let expected = Affine2 { matrix2: matrix, translation };
        assert_eq!(checker(&format!(", transform = [{steps}]")).uv_to_squares, expected, "{steps}");
    }
}

#[test]
fn camera_and_light_are_those_of_the_file_or_show_all_of_it() {
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
    // Turned about y by a quarter, what looked along -z from z = 5 looks along -x from x = 5.
    let moved = Camera::new(Vec3::new(5.0, 1.0, 0.0), Vec3::Y, 30.0, 8, 8).rays(8, 8);
    for (ray, expected) in view.camera(8, 8).rays(8, 8).iter().zip(&moved) {
        assert_eq!((ray.origin, ray.dir), (expected.origin, expected.dir));
    }
}

#[test]
fn what_is_never_placed_is_told() {
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
fn paths_start_at_the_scene_file() {
    let files = Files::new();
    fs::create_dir_all(files.path("scenes/models")).unwrap();
    files.write("scenes/models/corner.OBJ", CORNER);
    files.write("up.obj", CORNER);
    for path in ["models/corner.OBJ", "../up.obj", "./models/../../up.obj", files.path("up.obj").to_str().unwrap()] {
        let text = format!("[[mesh]]\nname = 'it'\nfile = '{path}'\n[[instance]]\nof = 'it'\n");
        assert_eq!(load_scene(&files.write("scenes/x.toml", text)).unwrap().world.geometries()[0].primitives(), 3);
    }
    // An OBJ file's error is its own.
    files.write("scenes/bad.obj", format!("{CORNER}v 1 nan 3\n"));
    let message = |file: &str| {
        let text = format!("[[mesh]]\nname = 'it'\nfile = '{file}'\n[[instance]]\nof = 'it'\n");
        files.shorten(&load_scene(&files.write("scenes/x.toml", text)).unwrap_err().to_string())
    };
    assert_eq!(message("bad.obj"), "scenes/bad.obj:8: vertex coordinate is NaN: \"v 1 nan 3\"");
    assert_eq!(message("none.obj"), "cannot read scenes/none.obj: No such file or directory");
}

/// Every line of what may be wrong, put into a file that is right but for it.
#[test]
fn errors_name_line_and_key() {
    let good = format!("# A comment.\n\n{BALL}\n[[instance]]\nof = \"ball\"\n");
    load(&good);
    let instance_error = |lines: &str| error(format!("{good}{lines}\n"));
    for (lines, message) in [
        ("of = 'ball'", "10: duplicate key: \"of = 'ball'\""),
        ("color = [0, 1]", "10: instance.color: invalid length 2, expected an array of length 3"),
        (
            "color = [0, 1.5, 0]",
            "10: instance.color: invalid value: floating point `1.5`, expected a number from 0 to 1",
        ),
        (
            "\n\ncolor = [\n0,\n-1,\n0]",
            "14: instance.color: invalid value: integer `-1`, expected a number from 0 to 1",
        ),
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
            "10: instance.checker.colors: invalid value: integer `2`, expected a number from 0 to 1",
        ),
        (
            "checker = { colors = [[0, 0, 0], [1, 1, 1]], transform = [{ scale = [0, 1] }] }",
            "10: instance.checker.transform: scaling by [0, 1]: a factor of zero has no inverse",
        ),
        (
            "checker = { colors = [[0, 0, 0], [1, 1, 1]], transform = [{ scale = [1e30, 1] }, { scale = [1e30, 1] }] }",
            "10: instance.checker.transform: too large: ",
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
            "10: instance.transform.shear.of: unknown field `of`, expected one of `axis`, `by`, `factor`",
        ),
        (
            "transform = [{ rotate = 1 }]",
            "10: instance.transform.rotate: unknown variant `rotate`, expected one of `translate`, `scale`, `rotate_x`, `rotate_y`, `rotate_z`, `shear`",
        ),
        (
            "transform = [{ rotate_x = nan }]",
            "10: instance.transform.rotate_x: invalid value: floating point `NaN`, expected a finite number",
        ),
        (
            "transform = [{ translate = [0, -inf, 0] }]",
            "10: instance.transform.translate: invalid value: floating point `-inf`, expected a finite number",
        ),
        (
            "transform = [{ translate = [0, 1e39, 0] }]",
            "10: instance.transform.translate: invalid value: floating point `1e+39`, expected a finite number",
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
            "10: instances: unknown field `instances`, expected one of `camera`, `light`, `mesh`, `quadric`, `instance`, `scatter`",
        ),
        ("[[mesh]]\nname = 'ball'\nfile = 'corner.obj'\n", "3: quadric.name: another one has this name: \"ball\""),
        ("[[mesh]]\nname = 'm'", "10: mesh: a mesh needs either file or generator"),
        (
            "[[mesh]]\nname = 'm'\nfile = 'corner.obj'\ngenerator = 'room'",
            "10: mesh: a mesh needs either file or generator",
        ),
        ("[[mesh]]\nname = 'm'\nfile = 'x.toml'", "12: mesh.file: expected an OBJ file (*.obj): \"x.toml\""),
        ("[[mesh]]\nfile = 'corner.obj'", "10: mesh: missing field `name`"),
        (
            "[[mesh]]\nname = 'm'\ngenerator = 'forest'",
            "12: mesh.generator: no such generator, expected one of room, terrain, sphere, tree, square: \"forest\"",
        ),
        (
            "[[mesh]]\nname = 'm'\ngenerator = 'room:1'",
            "12: mesh.generator: the size must be one of small, medium, large or a number of triangles from 1000 to 10000000: \"room:1\"",
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
            "12: quadric.sphere.radius: invalid value: integer `-1`, expected a number from 1e-15 to 1e15",
        ),
        (
            "[[quadric]]\nname = 'q'\n[quadric.sphere]\n\nradius = 1e20",
            "14: quadric.sphere.radius: invalid value: floating point `1e+20`, expected a number from 1e-15 to 1e15",
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
        ("[[quadric]]\nname = 'q'\nhyperboloid_of_two_sheets = { semi_axes = [1, 1, 1e15], half_height = 1e-15 }", ""),
        (
            "[[quadric]]\nname = 'q'\ncoefficients = [0, 0, 0, 0, 0, 0, 0, 0, 0, 1]\nclip = { lo = [0, 0, 0], hi = [1, 1, 1] }",
            "11: quadric.name: no ray hits it: the coefficients are too large or all zero, or the box is empty: \"q\"",
        ),
        (
            "[[quadric]]\nname = 'q'\ncoefficients = [1, 0, 0, 0, 0, 0, 0, 0, 0, 1]\nclip = { lo = [0, 0, 1], hi = [1, 1, 0] }",
            "11: quadric.name: no ray hits it: the coefficients are too large or all zero, or the box is empty: \"q\"",
        ),
        ("[camera]\neye = [0, 0, 0]", "10: camera: missing field `look_at`"),
        (
            "[camera]\neye = [1, 2, 3]\nlook_at = [1, 2, 3]",
            "10: camera: eye and look_at give no direction: [1, 2, 3] and [1, 2, 3]",
        ),
        (
            "[camera]\neye = [0, 0, 1]\nlook_at = [0, 0, 0]\nfield_of_view = 180",
            "13: camera.field_of_view: invalid value: integer `180`, expected degrees from 1 to 170",
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
            "12: scatter.count: invalid value: integer `0`, expected a whole number from 1 to 10000000",
        ),
        (
            "[[scatter]]\nof = 'ball'\ncount = 1.5",
            "12: scatter.count: invalid value: floating point `1.5`, expected a whole number from 1 to 10000000",
        ),
        ("[[scatter]]\nof = 'ball'\ncount = 1e7\non = 'ball'", "12: scatter.count: more than 10000000 instances"),
        (
            "[[scatter]]\nof = 'ball'\ncount = 1\nseed = -1",
            "13: scatter.seed: invalid value: integer `-1`, expected u32",
        ),
        (
            "[[scatter]]\nof = 'ball'\ncount = 1\non = 'floor'",
            "13: scatter.on: no mesh or quadric has this name: \"floor\"",
        ),
        (
            "[[scatter]]\nof = 'ball'\ncount = 1\non = 'm'\n[[mesh]]\nname = 'm'\nfile = 'corner.obj'",
            "13: scatter.on: has no instance to stand on: \"m\"",
        ),
        (
            "[[scatter]]\nof = 'ball'\ncount = 1\non = 'ball'\narea = { lo = [9, 9], hi = [10, 10] }",
            "10: scatter: hardly any ground in the area",
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
            "13: scatter.lean: invalid value: integer `2`, expected a number from 0 to 1",
        ),
        (
            "[[scatter]]\nof = 'ball'\ncount = 1\narea = { lo = [0, 0], hi = [1, 1] }\nscale = [1e15, 1e15]\ntransform = [{ scale = [1e30, 1, 1] }]",
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
        let found = instance_error(lines);
        assert!(is_short_line(&found), "{found}");
        let matches = match message.ends_with(": ") {
            true => found.starts_with(&format!("x.toml:{message}")),
            false => found == format!("x.toml:{message}"),
        };
        assert!(matches, "{lines}\nexpected x.toml:{message}\ngot      {found}");
    }
}
