//! Tests of the loaders of mesh files: what they read, which files they refuse with which message, and that they never
//! panic. Here OBJ and MTL files, in `formats` PLY and STL files.

mod faces;
mod files;
mod formats;

use std::fs;
use std::path::Path;

use glam::{Vec2, Vec3};
use raylanes::geom::Aabb;
use raylanes::tracer::{Error, Mesh, MeshReport, load_obj};

use faces::{faces, triangles_per_face};
use files::{Files, is_short_line, mutate};
use raylanes::conformance::Random;

const VERTICES: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n";

fn load_text(text: impl AsRef<[u8]>) -> Result<(Mesh, MeshReport), Error> {
    load_obj(&Files::new().write("x.obj", text))
}

/// The mesh of a file. The loader must have nothing to report.
fn mesh(text: impl AsRef<[u8]>) -> Mesh {
    let (mesh, report) = load_text(text).unwrap();
    assert_eq!((report.ignored_elements, report.warnings), (0, vec![]));
    mesh
}

fn error(text: impl AsRef<[u8]>) -> String {
    let files = Files::new();
    files.shorten(&load_obj(&files.write("x.obj", text)).unwrap_err().to_string())
}

fn vertices(mesh: &Mesh) -> Vec<[Vec3; 3]> {
    mesh.iter().map(|triangle| triangle.vertices()).collect()
}

const A: Vec3 = Vec3::ZERO;
const B: Vec3 = Vec3::X;
const C: Vec3 = Vec3::Y;
const D: Vec3 = Vec3::new(1.0, 1.0, 0.0);

#[test]
fn faces_become_fans_in_file_order() {
    let loaded = mesh(format!("{VERTICES}f 1 2 3\nf 1 2 4 3\nv 2 2 0\nv 0.5 -1 0\nf 5 3 1 6 2\n"));
    let (e, f) = (Vec3::new(2.0, 2.0, 0.0), Vec3::new(0.5, -1.0, 0.0));
    assert_eq!(vertices(&loaded), [[A, B, C], [A, B, D], [A, D, C], [e, C, A], [e, A, f], [e, f, B]]);
    assert_eq!(loaded.positions().len(), 6);
}

#[test]
fn vertices_keep_the_order_of_the_file() {
    // The first vertex is used last, the second never, and the others before the file defines them.
    let loaded = mesh("f 4 3 5\nv 0 0 0\nv 9 9 9\nv 1 0 0\nv 1 1 0\nv 0 2 0 2\nf 5 4 1\nf 1 3 4 5\n");
    assert_eq!(loaded.positions(), [A, B, D, C]);
    assert_eq!(loaded.triangles(), [[2, 1, 3], [3, 2, 0], [0, 1, 2], [0, 2, 3]]);
}

/// An OBJ file of one polygon.
fn polygon(corners: &[[f32; 2]]) -> String {
    let vertices: String = corners.iter().map(|[x, y]| format!("v {x} {y} 0\n")).collect();
    let face: String = (1..=corners.len()).map(|corner| format!(" {corner}")).collect();
    format!("{vertices}f{face}\n")
}

/// Twice the area of each triangle, positive if it is counter-clockwise.
fn double_areas(mesh: &Mesh) -> Vec<f32> {
    mesh.iter().map(|triangle| (triangle.v1 - triangle.v0).cross(triangle.v2 - triangle.v0).z).collect()
}

#[test]
fn concave_polygons_are_covered_exactly() {
    let cases: [(&str, &[[f32; 2]], usize, f32); 7] = [
        ("dart", &[[4.0, 0.0], [1.0, 1.0], [0.0, 4.0], [0.0, 0.0]], 2, 8.0),
        ("L", &[[3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0], [0.0, 0.0]], 4, 10.0),
        ("arrow", &[[0.0, 0.0], [4.0, 2.0], [0.0, 4.0], [1.0, 2.0]], 2, 12.0),
        // All ten corners of a square with a hole, which a cut joins to the outline.
        (
            "hole",
            &[
                [0.0, 0.0],
                [4.0, 0.0],
                [4.0, 4.0],
                [0.0, 4.0],
                [0.0, 0.0],
                [1.0, 1.0],
                [1.0, 2.0],
                [2.0, 2.0],
                [2.0, 1.0],
                [1.0, 1.0],
            ],
            8,
            30.0,
        ),
        ("two parts that touch", &[[0.0, 0.0], [2.0, 2.0], [4.0, 0.0], [4.0, 4.0], [2.0, 2.0], [0.0, 4.0]], 2, 16.0),
        ("a corner on an edge", &[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 0.0], [0.0, 4.0]], 2, 16.0),
        (
            "a spike without area",
            &[[4.0, 0.0], [1.0, 1.0], [0.0, 4.0], [0.0, 9.0], [0.0, 4.0], [0.0, 0.0], [0.0, 0.0]],
            2,
            8.0,
        ),
    ];
    for (name, corners, triangles, double_area) in cases {
        let loaded = mesh(polygon(corners));
        assert_eq!(loaded.len(), triangles, "{name}");
        let areas = double_areas(&loaded);
        assert!(areas.iter().all(|&area| area > 0.0), "{name}: {areas:?}");
        assert_eq!(areas.iter().sum::<f32>(), double_area, "{name}");
        // Seen from the other side.
        let reversed: Vec<_> = corners.iter().copied().rev().collect();
        assert_eq!(double_areas(&mesh(polygon(&reversed))).iter().sum::<f32>(), -double_area, "{name}");
    }
}

#[test]
fn materials_keep_to_their_faces_where_polygons_have_fewer_triangles() {
    let files = Files::new();
    files.write("x.mtl", "newmtl red\nKd 1 0 0\nnewmtl green\nKd 0 1 0\n");
    // The first face has six corners, but only two triangles.
    let touching = polygon(&[[0.0, 0.0], [2.0, 2.0], [4.0, 0.0], [4.0, 4.0], [2.0, 2.0], [0.0, 4.0]]);
    let text =
        format!("mtllib x.mtl\nusemtl red\n{touching}usemtl green\nf 1 2 6\nusemtl red\nf 2 3 4\nusemtl green\n");
    let (mesh, report) = load_obj(&files.write("x.obj", text)).unwrap();
    let colors: Vec<_> = (0..mesh.len() as u32).map(|primitive| mesh.color(primitive)).collect();
    assert_eq!((colors, report.warnings), (vec![Vec3::X, Vec3::X, Vec3::Y, Vec3::X], vec![]));
}

#[test]
fn polygons_without_an_obvious_surface_are_reported_once() {
    let files = Files::new();
    let text = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 1\nv 1 1 0.001\n\
                f 1 2 3 4\nf 1 2 4 3\nf 1 2 3 5\nf 1 2 3 6\nf 2 4 1 3\n\nf 1 5 3 4\nf 1 2 1 2\nf 1 2 3 4 1 2 3 4\n";
    let (mesh, report) = load_obj(&files.write("x.obj", text)).unwrap();
    // A fan each.
    assert_eq!((mesh.len(), report.degenerate), (7 * 2 + 6, 4));
    let warnings: Vec<_> = report.warnings.iter().map(|warning| files.shorten(warning)).collect();
    assert_eq!(
        warnings,
        [
            "x.obj:8: polygon crosses itself, so its triangles may reach outside: 4 corners (and 2 more)",
            "x.obj:9: polygon is not flat, so its surface depends on how it is split: 4 corners (and 1 more)",
        ]
    );
}

#[test]
fn a_bent_polygon_keeps_all_of_its_surface() {
    // Its normal is (-0.25, -1, 0). Seen along it, the part in the plane z = 0 is only a line.
    let text = "v 1 1 0\nv 0 1 0\nv 0.25 0.25 0\nv 5 0 0\nv 0.5 0 0.25\nf 1 2 3 4 5\n";
    let (mesh, report) = load_text(text).unwrap();
    assert_eq!((mesh.len(), report.warnings.len()), (3, 2));
    // Seen along the normal of this one, the first vertex hides the third.
    let text = "v 0 1 0\nv 0.5 0 0.25\nv 1 1 0\nv 0.5 0.25 0\nv 0 0 0\nf 1 2 3 4 5\n";
    let (mesh, report) = load_text(text).unwrap();
    assert_eq!((mesh.len(), report.warnings.len()), (3, 2));
}

#[test]
fn polygons_of_many_corners_are_split() {
    const CORNERS: usize = 20_000;
    let angle = |corner: usize| (corner as f32 / CORNERS as f32 * std::f32::consts::TAU).sin_cos();
    let circle: Vec<_> = (0..CORNERS).map(angle).map(|(sin, cos)| [cos, sin]).collect();
    let star = |corner: usize| [1.0, 0.5][corner % 2];
    let star: Vec<_> = (0..CORNERS).map(|corner| circle[corner].map(|x| x * star(corner))).collect();
    let stretched: Vec<_> = star.iter().map(|[x, y]| [x * 0.75, y + x]).collect();
    let comb = (0..CORNERS - 2).map(|corner| [corner as f32, [0.0, 1000.0][corner % 2]]).rev();
    let comb: Vec<_> = [[0.0, -1.0], [CORNERS as f32, -1.0]].into_iter().chain(comb).collect();
    for corners in [circle, star, stretched, comb] {
        let loaded = mesh(polygon(&corners));
        assert_eq!(loaded.len(), CORNERS - 2);
        assert!(double_areas(&loaded).iter().all(|&area| area >= -1e-6));
    }
    let places: Vec<_> = (0..CORNERS).map(|corner| [(corner % 3) as f32, (corner % 3 / 2) as f32]).collect();
    assert_eq!(load_text(polygon(&places)).unwrap().1.warnings.len(), 1);
}

#[test]
fn indices_count_from_either_end() {
    for face in ["f -4 -3 -2", "f 1/ 2// 3", "f +1 2 3", "\t f  1\t2  3 \t"] {
        assert_eq!(vertices(&mesh(format!("{VERTICES}{face}\n"))), [[A, B, C]], "{face}");
    }
    assert_eq!(vertices(&mesh(format!("f 1 2 3\n{VERTICES}"))), [[A, B, C]], "vertices may follow");
    assert_eq!(vertices(&mesh(format!("{VERTICES}f -1 -2 -3\nv 5 5 5\nf -5 -4 -3\n"))), [[D, C, B], [A, B, C]]);
}

/// The normals and texture coordinates of all triangles.
type Corners = (Vec<Option<[Vec3; 3]>>, Vec<Option<[Vec2; 3]>>);

fn corners(mesh: &Mesh) -> Corners {
    let numbers = || 0..mesh.len() as u32;
    let normals = numbers().map(|primitive| mesh.normals(primitive)).collect();
    (normals, numbers().map(|primitive| mesh.texture_coordinates(primitive)).collect())
}

#[test]
fn corners_keep_their_normals_and_texture_coordinates() {
    // A concave polygon, whose triangles are no fan. The number of a corner is in both of its values.
    let outline = [[3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0], [0.0, 0.0f32]];
    let mut text = String::new();
    for (number, [x, y]) in outline.iter().enumerate() {
        text += &format!("v {x} {y} 0\nvt {number} 0.5\nvn 0 {number} 1\n");
    }
    // The values in another order than the vertices, and a quadrilateral with others before the polygon.
    let text =
        format!("{text}vn 7 7 7\nvt 9\nf 6/7/7 1/7/7 2/-1/-1 3/7/7\nf 1/1/1 2/2/2 3/3/3 4/-4/-4 5/-3/-3 6/6/6\n");
    let loaded = mesh(text);
    assert_eq!((loaded.len(), loaded.positions().len()), (6, 6));
    let (normals, coordinates) = corners(&loaded);
    assert_eq!(normals[..2], [Some([Vec3::splat(7.0); 3]); 2]);
    assert_eq!(coordinates[..2], [Some([Vec2::new(9.0, 0.0); 3]); 2]);
    for primitive in 2..6 {
        let numbers = loaded.triangle(primitive).vertices().map(|vertex| {
            outline.iter().position(|&corner| vertex == Vec3::new(corner[0], corner[1], 0.0)).unwrap() as f32
        });
        assert_eq!(normals[primitive as usize], Some(numbers.map(|number| Vec3::new(0.0, number, 1.0))));
        assert_eq!(coordinates[primitive as usize], Some(numbers.map(|number| Vec2::new(number, 0.5))));
    }
}

#[test]
fn triangles_without_all_three_values_have_none() {
    let x = Some([Vec3::X; 3]);
    let uv = Some([Vec2::new(0.5, 0.25); 3]);
    let values = "vn 1 0 0\nvt 0.5 0.25 x\n";
    for (faces, expected) in [
        ("f 1 2 3\nf 1//1 2//1 3//1\nf 1 2 4\n", (vec![None, x, None], vec![None; 3])),
        ("f 1 2 3\nf 1/1 2/1 3/1\nf 1/1/ 2/1/ 3/1/\n", (vec![None; 3], vec![None, uv, uv])),
        ("f 1/1/1 2/1/1 3//1\nf 1/1/1 2/1 3/1/1\n", (vec![x, None], vec![None, uv])),
        // Of the triangles 1 2 4 and 1 4 3, the second one lacks a normal.
        ("f 1//1 2//1 4//1 3\n", (vec![x, None], vec![None; 2])),
        // Nobody uses the values.
        ("f 1 2 3\n", (vec![None], vec![None])),
    ] {
        assert_eq!(corners(&mesh(format!("{VERTICES}{values}{faces}"))), expected, "{faces}");
    }
    // Values may follow.
    let (normals, _) = corners(&mesh(format!("{VERTICES}f 1//2 2//2 3//2\nvn 0 0 1\nvn 1 0 0\n")));
    assert_eq!(normals, [x]);
    let plain = mesh(format!("{VERTICES}f 1 2 3\n"));
    let unused = mesh(format!("{VERTICES}{values}vn nan nan nan\nvt x\nvn\nf 1 2 3\n"));
    assert_eq!((unused.bytes(), &unused), (plain.bytes(), &plain));
}

#[test]
fn errors_in_normals_and_texture_coordinates_name_the_line() {
    let good = format!("{VERTICES}vn 0 0 1\nvt 0 0\nf 1/1/1 2/1/1 3/1/1\n");
    mesh(&good);
    for (lines, message) in [
        ("f 1/2 2/1 3/1", "8: there is no texture coordinate 2, the file has 1: \"f 1/2 2/1 3/1\""),
        ("f 1//1 2//1 3//2\n", "8: there is no normal 2, the file has 1: \"f 1//1 2//1 3//2\""),
        ("\nf 1//1 2//99999999999 3//1\n", "9: there is no normal 99999999999, the file has 1: "),
        ("f 1//0 2//1 3//1", "8: normal index is 0, but the first normal is 1: \"f 1//0 2//1 3//1\""),
        ("f 1/1 2/-2 3/1", "8: texture coordinate index -2 counts back beyond the 1 texture coordinates so far: "),
        ("f 1//x 2//1 3//1", "8: normal index is not a whole number: "),
        ("f 1/1.5 2/1 3/1", "8: texture coordinate index is not a whole number: "),
        ("f 1//9223372036854775808 2//1 3//1", "8: normal index is out of range: "),
        ("vn 0 nan 1\nf 1//1 2//2 3//1", "8: normal is NaN: \"vn 0 nan 1\""),
        ("f 1//1 2//3 3//1\nvn 0 0 1\nvn 0 1e39 1", "10: normal is infinite or too large: \"vn 0 1e39 1\""),
        ("vn 0 1\nf 1//-1 2//1 3//1", "8: a normal needs 3 numbers: \"vn 0 1\""),
        ("vt\nf 1/1 2/1 3/2", "8: a texture coordinate needs 1 number: \"vt\""),
        ("vt 0.5 -inf\nf 1/1 2/1 3/2", "8: texture coordinate is infinite or too large: \"vt 0.5 -inf\""),
        ("vt 0.5 ?\nf 1/1 2/1 3/2", "8: texture coordinate cannot be read: \"vt 0.5 ?\""),
        // Of several, the first one that a face uses.
        ("vn x\nvn y\nvn z\nf 1//1 2//3 3//2\n", "9: normal cannot be read: \"vn y\""),
    ] {
        let found = error(format!("{good}{lines}\n"));
        assert!(found.starts_with(&format!("x.obj:{message}")) && is_short_line(&found), "{lines}: {found}");
    }
}

#[test]
fn every_form_of_line_is_read() {
    let expected = [[A, B, C]];
    let forms: [&[u8]; 8] = [
        b"v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3\r\n",
        b"\xef\xbb\xbfv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3",
        b"v 0 0 0 2\nv 2 0 0 2\nv 0 -1 0 -1\nf 1 2 3\n",
        b"v 0 0 0 # origin\nv 1. 0 0#\nv 0 1e0 .0\nf 1 2 3 # face\n",
        b"v 0 \\\n0 0\nv 1 0 0\nv \\ \r\n\\\n 0 1 0\nf 1 2\\\n 3\\",
        b"# \xff\xfe C:\\models\\\nv 0 0 0\no \xff\nv 1 0 0\ng \xe9 \nv 0 1 0\nusemtl\nmtllib\nf 1 2 3\n",
        b"vn nan\nvt x\nvp\nv 0 0 0\nv 1 0 0\nv 0 1 0\ns off\ng\no\nvn 1\nf 1 2 3\n",
        b"\n\n   \n#\n#v 9\nv 0 0 0\n\tv 1 0 0\nv 0 1 0\nf 1 2 3\n\n",
    ];
    for form in forms {
        assert_eq!(vertices(&mesh(form)), expected, "{}", String::from_utf8_lossy(form));
    }
}

#[test]
fn every_line_break_ends_a_line() {
    let lines = ["# head", "v 0 0 5", "v 1 0 5", "v 0 1 5", "v 1 1 5", "f 1 2 3", "f 1 2 x"];
    for (line_break, counts) in [("\n", true), ("\r", true), ("\r\n", true), ("\x0c", false), ("\x0b", false)] {
        let loaded = mesh(lines[..6].join(line_break));
        let z = Vec3::Z * 5.0;
        assert_eq!(vertices(&loaded), [[A + z, B + z, C + z]], "{line_break:?}");
        // An error names the line that an editor shows.
        let line = if counts { 7 } else { 1 };
        let message = format!("x.obj:{line}: face index is not a whole number: \"f 1 2 x\"");
        assert_eq!(error(lines.join(line_break)), message, "{line_break:?}");
    }
    // Mixed, with a backslash before each kind, and a break at the end of each read of 8 KiB.
    let mixed = "# head\rv 0 0 0\r\nv 1 0 \\\r0\nv 0 \\\r\n1 0\r\r\n\x0c\nf 1 \\\n2 3\r\r\nf 1 2 x";
    assert_eq!(error(mixed), "x.obj:12: face index is not a whole number: \"f 1 2 x\"");
    for comment in 8180..8200 {
        let text = format!("#{}\r\nv 0 0 0\rv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 x\r\n", "-".repeat(comment));
        assert_eq!(error(text), "x.obj:6: face index is not a whole number: \"f 1 2 x\"", "{comment}");
    }
}

#[test]
fn text_in_wide_characters_is_refused_by_name() {
    let text = format!("\u{feff}{VERTICES}f 1 2 3\n");
    let utf_16 = |to_bytes: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(to_bytes).collect::<Vec<_>>();
    let utf_32 = |to_bytes: fn(u32) -> [u8; 4]| text.chars().flat_map(|c| to_bytes(c.into())).collect::<Vec<_>>();
    let (little, big) = (utf_16(u16::to_le_bytes), utf_16(u16::to_be_bytes));
    let (long_little, long_big) = (utf_32(u32::to_le_bytes), utf_32(u32::to_be_bytes));
    for (bytes, name) in [
        (&little[..], "UTF-16LE"),
        (&little[2..], "UTF-16LE"),
        (&big[..], "UTF-16BE"),
        (&big[2..], "UTF-16BE"),
        (&long_little[..], "UTF-32LE"),
        (&long_big[..], "UTF-32BE"),
    ] {
        let message = format!("x.obj:1: the text is {name}, expected UTF-8; iconv -f {name} -t UTF-8 converts it");
        assert_eq!(error(bytes), message);
    }
    // Joined files may have a byte order mark in the middle.
    assert_eq!(vertices(&mesh(text.replace("v 0 1 0", "\u{feff}v 0 1 0"))), [[A, B, C]]);
}

#[test]
fn a_name_in_shift_jis_does_not_swallow_the_next_line() {
    // The second byte of the second letter is a backslash.
    let text = [VERTICES.as_bytes(), b"g \x88\xca\x95\x5c\nf 1 2 3\n# \x95\x5c\nf 1 2 4\n"].concat();
    assert_eq!(vertices(&mesh(text)), [[A, B, C], [A, B, D]]);
}

#[test]
fn ignored_lines_are_reported() {
    let files = Files::new();
    let text = "v 0 0 0 1 0 0\nv 1 0 0 1 0 0 1\nv 0 1 0\nv 9 9 9\n\
                f 1 2 3\nf 1 2 2\nf 1 2 3 3\nl 1 2 3\np 1\ncurv 0 1 1 2\nF 1 2 3\nfo 1 2 3\nV 0 0 0\n";
    let (mesh, report) = load_obj(&files.write("x.obj", text)).unwrap();
    assert_eq!(mesh.len(), 4);
    assert_eq!(mesh.positions().len(), 3);
    assert_eq!((report.vertices, report.degenerate, report.ignored_elements), (4, 2, 3));
    let warnings: Vec<_> = report.warnings.iter().map(|warning| files.shorten(warning)).collect();
    assert_eq!(
        warnings,
        [
            "x.obj:1: vertex colour ignored: \"v 0 0 0 1 0 0\" (and 1 more)",
            "x.obj:11: unknown keyword, line ignored: \"F 1 2 3\" (and 2 more)",
        ]
    );
}

#[test]
fn errors_name_the_line_and_its_text() {
    for (line, message) in [
        ("v 1 nan 3", "vertex coordinate is NaN"),
        ("v 1 2 -inf", "vertex coordinate is infinite or too large"),
        ("v 1e39 2 3", "vertex coordinate is infinite or too large"),
        ("v 1 2,5 3", "vertex coordinate cannot be read"),
        ("v 1 2", "a vertex needs 3 coordinates"),
        ("v", "a vertex needs 3 coordinates"),
        ("v 1 2 3 4 5", "a vertex has 3, 4, 6 or 7 numbers"),
        ("v 1 2 3 4 5 6 7 8", "a vertex has 3, 4, 6 or 7 numbers"),
        ("v 1 2 3 0", "vertex weight is zero or too small"),
        ("v 1e30 2 3 1e-30", "vertex weight is zero or too small"),
        ("v 1 2 3 x", "vertex weight cannot be read"),
        ("f", "a face needs 3 vertices"),
        ("f 1", "a face needs 3 vertices"),
        ("f 1/1 2/2", "a face needs 3 vertices"),
        ("f 1 2 0", "face index is 0, but the first vertex is 1"),
        ("f 1 2 -5", "face index -5 counts back beyond the 4 vertices so far"),
        ("f 1 2 x", "face index is not a whole number"),
        ("f 1 2 1.5", "face index is not a whole number"),
        ("f //1 //2 //3", "face index is missing"),
        ("f 1 2 9223372036854775808", "face index is out of range"),
        ("f 1 2 -9223372036854775809", "face index is out of range"),
        ("f 1 2 -9223372036854775808", "face index -9223372036854775808 counts back beyond the 4 vertices so far"),
        ("f 1 2 9223372036854775807", "there is no vertex 9223372036854775807, the file has 4"),
        ("f 1 2 5", "there is no vertex 5, the file has 4"),
    ] {
        let text = format!("# comment \\\n\\\n\n{VERTICES}{line}\nf 1 2 3\n");
        assert_eq!(error(text), format!("x.obj:8: {message}: \"{line}\""));
    }
    assert_eq!(
        error(b"\nv 1 \xff\x1b[2J 2"),
        "x.obj:2: vertex coordinate cannot be read: \"v 1 \u{fffd}\\u{1b}[2J 2\""
    );
    assert_eq!(error(format!("{VERTICES}f 1 \\\n2 \\\n\nf 1 2 3")), "x.obj:5: a face needs 3 vertices: \"f 1  2\"");
    assert_eq!(
        error(format!("{VERTICES}f 1 2 7\nf 1 2 3\nf 9 1 2\nf 8 1 2\nf 1 2 3\n")),
        "x.obj:7: there is no vertex 9, the file has 4: \"f 9 1 2\""
    );
}

#[test]
fn files_without_triangles_are_refused() {
    for text in ["", "\n", VERTICES, "# only\\\n", "l 1 2 3\n", "\0\0\0", "mtllib none.mtl\nusemtl none\n"] {
        assert_eq!(error(text), "x.obj: no triangles", "{text:?}");
    }
    let files = Files::new();
    let message = |path: &Path| files.shorten(&load_obj(path).unwrap_err().to_string());
    assert_eq!(message(&files.path("none.obj")), "cannot read none.obj: No such file or directory");
    fs::create_dir(files.path("directory.obj")).unwrap();
    assert_eq!(message(&files.path("directory.obj")), "cannot read directory.obj: Is a directory");
    // An endless line must not fill the memory.
    if Path::new("/dev/zero").exists() {
        assert!(message(Path::new("/dev/zero")).starts_with("/dev/zero:1: line is longer than 16777216 bytes: "));
    }
}

const GREY: Vec3 = Vec3::splat(0.8);

#[test]
fn materials_color_the_triangles() {
    let files = Files::new();
    files.write(
        "one library.mtl",
        "newmtl red one\nKa x\nKd 1 0 0\nmap_Kd\n\nnewmtl #2\r\n  Kd 0.5 # grey\r\nnewmtl plain\n",
    );
    files.write("two.mtl", b"# \xff\nnewmtl \xe9t\xe9\nillum x\nKd 0 .25 1e-1");
    let obj = format!(
        "mtllib one library.mtl\nmtllib two.mtl none.mtl\nmtllib two.mtl none.mtl\n{VERTICES}f 1 2 3\n\
         usemtl unused\nusemtl red one\nf 1 2 4 3\nusemtl #2\nf 1 2 3\nusemtl plain\nf 1 2 3\n\
         usemtl undefined\nf 1 2 3\n\
         usemtl \u{e9}\nf 1 2 3\nusemtl\nf 1 2 3\nusemtl red one\n"
    );
    let (mesh, report) = load_obj(&files.write("x.obj", obj)).unwrap();
    let colors: Vec<_> = (0..mesh.len() as u32).map(|primitive| mesh.color(primitive)).collect();
    let half = Vec3::splat(0.5);
    assert_eq!(colors, [GREY, Vec3::X, Vec3::X, half, GREY, GREY, GREY, GREY]);
    // Two triangles on the same vertices stay connected across materials.
    assert_eq!(mesh.positions().len(), 4);
    let warnings: Vec<_> = report.warnings.iter().map(|warning| files.shorten(warning)).collect();
    assert_eq!(
        warnings,
        [
            "x.obj:2: material library not found: \"none.mtl\"",
            "x.obj:16: unknown material, default colour used: \"undefined\" (and 1 more)",
        ]
    );
    // Names need not be UTF-8 to be found.
    let (mesh, report) = load_obj(
        &files.write("x.obj", [b"mtllib two.mtl\nusemtl \xe9t\xe9\n", VERTICES.as_bytes(), b"f 1 2 3"].concat()),
    )
    .unwrap();
    assert_eq!((mesh.color(0), report.warnings), (Vec3::new(0.0, 0.25, 0.1), vec![]));
}

#[test]
fn names_in_latin_1_stay_apart_and_match_utf_8() {
    let files = Files::new();
    files.write("x.mtl", b"newmtl \xe8\nKd 1 0 0\nnewmtl \xe9\nKd 0 1 0\n");
    let text = [b"mtllib x.mtl\n", VERTICES.as_bytes(), b"usemtl \xe8\nf 1 2 3\nusemtl \xc3\xa9\nf 1 2 4\n"].concat();
    let (mesh, report) = load_obj(&files.write("x.obj", text)).unwrap();
    assert_eq!(([mesh.color(0), mesh.color(1)], report.warnings), ([Vec3::X, Vec3::Y], vec![]));
}

#[test]
fn libraries_are_found_under_their_name_in_either_encoding() {
    let load = |library: &[u8], name: &[u8]| {
        let files = Files::new();
        #[cfg(unix)]
        let file = <std::ffi::OsStr as std::os::unix::ffi::OsStrExt>::from_bytes(library);
        #[cfg(not(unix))]
        let file = String::from_utf8_lossy(library).into_owned();
        fs::create_dir(files.path("in")).unwrap();
        fs::write(files.path("").join(file), "newmtl a\nKd 1 0 0\n").unwrap();
        let text = [b"mtllib ", name, b"\nusemtl a\n", VERTICES.as_bytes(), b"f 1 2 3\n"].concat();
        load_obj(&files.write("x.obj", text)).unwrap().0.color(0)
    };
    assert_eq!(load(b"in/a b.mtl", b"in\\a b.mtl"), Vec3::X);
    assert_eq!(load(b"\xc3\xa9.mtl", b"\xc3\xa9.mtl"), Vec3::X);
    assert_eq!(load(b"\xc3\xa9.mtl", b"\xe9.mtl"), Vec3::X);
    if cfg!(target_os = "linux") {
        assert_eq!(load(b"\xe9.mtl", b"\xe9.mtl"), Vec3::X);
    }
}

#[test]
fn libraries_are_read_once_and_the_missing_ones_are_one_note() {
    let files = Files::new();
    files.write("a.mtl", "newmtl a\nKd 9 0 0\nnewmtl both\nKd 9 0 0\n");
    files.write("b.mtl", "newmtl b\nKd 0 0 9\nnewmtl both\nKd 0 0 9\n");
    let load = |libraries: &str| {
        let text = format!("{libraries}{VERTICES}usemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\nusemtl both\nf 1 2 3\n");
        let (mesh, report) = load_obj(&files.write("x.obj", text)).unwrap();
        let warnings: Vec<_> = report.warnings.iter().map(|warning| files.shorten(warning)).collect();
        ([mesh.color(0), mesh.color(1), mesh.color(2)], warnings)
    };
    // Each library has two colours to clamp. So the count of clamped colours tells how often they were read.
    let clamped = |library| format!("{library}.mtl:2: colour clamped to 0..1: \"Kd 9 0 0\" (and 3 more)");
    let expected = ([Vec3::X, Vec3::Z, Vec3::Z], vec![clamped("a")]);
    for libraries in [
        "mtllib a.mtl\nmtllib b.mtl\n".repeat(10_000),
        "mtllib a.mtl b.mtl\n".into(),
        "mtllib b.mtl \\\n a.mtl \\\n b.mtl\nmtllib\n".into(),
        "mtllib a.mtl b.mtl\nmtllib b.mtl a.mtl\nmtllib b.mtl\n".into(),
        // Longer than any file name.
        format!("mtllib{}\n", " a.mtl b.mtl".repeat(1000)),
    ] {
        assert_eq!(load(&libraries), expected, "{libraries:.60}");
    }
    assert_eq!(load("mtllib b.mtl a.mtl\n").0, [Vec3::X, Vec3::Z, Vec3::X]);

    let many: String = (0..20_000).map(|library| format!("mtllib {library}.mtl a.mtl\nmtllib b.mtl\n")).collect();
    let missing = "x.obj:1: material library not found: \"0.mtl\" (and 19999 more)".to_owned();
    assert_eq!(load(&many), (expected.0, vec![missing, clamped("a")]));
    let name = "x".repeat(5000);
    let (_, warnings) = load(&format!("mtllib {name}\nmtllib a.mtl\0\n"));
    assert!(warnings[0].contains("not found") && warnings[0].ends_with(" (and 1 more)"), "{warnings:?}");
    assert!(is_short_line(&warnings[0]));
}

#[test]
fn colors_outside_0_to_1_are_clamped_with_a_warning() {
    let files = Files::new();
    files.write("x.mtl", "newmtl a\nKd 2 -1 0.5\n");
    let (mesh, report) = load_obj(&files.write("x.obj", format!("mtllib x.mtl\nusemtl a\n{VERTICES}f 1 2 3"))).unwrap();
    assert_eq!(mesh.color(0), Vec3::new(1.0, 0.0, 0.5));
    assert_eq!(files.shorten(&report.warnings[0]), "x.mtl:2: colour clamped to 0..1: \"Kd 2 -1 0.5\"");
}

#[test]
fn broken_material_files_are_refused() {
    let files = Files::new();
    let obj = files.write("x.obj", format!("mtllib x.mtl\n{VERTICES}f 1 2 3\n"));
    for (line, message) in [
        ("Kd", "a colour needs 3 numbers, or 1 for a grey"),
        ("Kd 1 0", "a colour needs 3 numbers, or 1 for a grey"),
        ("Kd 1 0 0 0", "a colour needs 3 numbers, or 1 for a grey"),
        ("Kd 1 nan 0", "colour is NaN"),
        ("Kd 1 inf 0", "colour is infinite or too large"),
        ("Kd spectral a.rfl", "colour cannot be read"),
        ("newmtl", "a material needs a name"),
        ("newmtl \u{a0}", "a material needs a name"),
    ] {
        files.write("x.mtl", format!("# materials\nnewmtl a\n{line}\nKd 1 1 1\n"));
        let error = files.shorten(&load_obj(&obj).unwrap_err().to_string());
        assert_eq!(error, format!("x.mtl:3: {message}: \"{line}\""));
    }
    files.write("x.mtl", b"n\0e\0w\0");
    let error = files.shorten(&load_obj(&obj).unwrap_err().to_string());
    assert!(error.starts_with("x.mtl:1: the text is UTF-16LE"), "{error}");
    files.write("x.mtl", "Kd 1 1 1\n");
    let error = load_obj(&obj).unwrap_err().to_string();
    assert_eq!(files.shorten(&error), "x.mtl:1: colour comes before the first newmtl: \"Kd 1 1 1\"");
    fs::remove_file(files.path("x.mtl")).unwrap();
    fs::create_dir(files.path("x.mtl")).unwrap();
    assert_eq!(files.shorten(&load_obj(&obj).unwrap_err().to_string()), "cannot read x.mtl: Is a directory");
    let obj = files.write("y.obj", "mtllib y.obj/y.mtl\n");
    assert_eq!(files.shorten(&load_obj(&obj).unwrap_err().to_string()), "cannot read y.obj/y.mtl: Not a directory");
}

/// Pieces of text with a meaning in OBJ and MTL files.
const PIECES: [&str; 30] = [
    "\n",
    "\x0b",
    "\x0c",
    "\\",
    "1 2 3 4 ",
    "f 1 2 4 3 5\n",
    "v 0.5 0.25 0\n",
    " ",
    "\\\n",
    "#",
    "/",
    "-",
    "0",
    "9",
    "e9",
    ".",
    "nan",
    "inf",
    "\r",
    "\0",
    "\u{e9}",
    "v ",
    "f ",
    "l ",
    "usemtl ",
    "mtllib ",
    "newmtl ",
    "Kd ",
    "99999999999999999999",
    "\u{feff}",
];

/// Checks that a mesh is that of the text, where a face without a known material is grey.
fn assert_is_mesh_of(text: &[u8], mesh: &Mesh, report: &MeshReport, color: impl Fn(&str) -> Vec3) {
    let faces = faces(text);
    let triangles: Vec<_> = mesh.iter().collect();
    let overlap = report.warnings.iter().any(|warning| warning.contains("crosses itself"));
    let counts = triangles_per_face(&triangles, &faces, overlap);
    let counts = counts.unwrap_or_else(|| panic!("{:?}: {triangles:?} {report:?}", String::from_utf8_lossy(text)));
    let materials = faces.iter().zip(counts).flat_map(|(face, count)| std::iter::repeat_n(&face.material, count));
    for (material, primitive) in materials.zip(0..) {
        let found = mesh.color(primitive);
        assert!(found == color(material) || found == GREY, "{material:?}: {:?}", String::from_utf8_lossy(text));
    }
}

#[test]
fn corrupted_files_neither_panic_nor_make_wrong_meshes() {
    const OBJ: &str = "mtllib x.mtl\no a\nv 0 0 0\nv 1 0 0.5 2\nv 0 1e0 0 1 1 1\nv 1 1 0\nvn 0 0 1\nvt 0.5 1\n\
                       usemtl red\nf 1/1/1 2//1 3/1/1\nf 1//1 3//1 4//1\nusemtl blue\n\
                       f -4 -3 -1 \\\n-2\nl 1 2\nv 0.25 0.25 0\nusemtl red\n\
                       f 4 3 5 1 2\nf 3 5 2 4 \n";
    const MTL: &str = "# colours\nnewmtl red\nKd 1 0 0.25\nillum 2\nnewmtl blue\nKd .5\n";
    let files = Files::new();
    let mut random = Random::from_seed(1);
    let (mut loaded, mut refused, mut with_normals) = (0, 0, 0);
    for _ in 0..20_000 {
        let text = mutate(OBJ, &PIECES, &mut random);
        let obj = files.write("x.obj", &text);
        let is_intact = random.below(2) == 0;
        let mtl = files.write("x.mtl", if is_intact { MTL.into() } else { mutate(MTL, &PIECES, &mut random) });
        match load_obj(&obj) {
            Ok((mesh, report)) => {
                loaded += 1;
                assert!(mesh.iter().flat_map(|triangle| triangle.vertices()).all(Vec3::is_finite));
                assert!((0..mesh.len() as u32).all(|primitive| mesh.color(primitive).max_element() <= 1.0));
                let (normals, coordinates) = corners(&mesh);
                assert!(normals.iter().flatten().flatten().all(|normal| normal.is_finite()));
                assert!(coordinates.iter().flatten().flatten().all(|uv| uv.is_finite()));
                with_normals += u32::from(normals.iter().any(Option::is_some));
                assert!(report.warnings.iter().all(|warning| is_short_line(warning)), "{report:?}");
                if is_intact {
                    assert_is_mesh_of(&text, &mesh, &report, |material| match material {
                        "red" => Vec3::new(1.0, 0.0, 0.25),
                        "blue" => Vec3::splat(0.5),
                        _ => GREY,
                    });
                }
            }
            Err(error) => {
                refused += 1;
                assert!(is_short_line(&error.to_string()), "{error}");
            }
        }
        // Removed first: some file systems wait for the disk when a file is overwritten.
        fs::remove_file(obj).unwrap();
        fs::remove_file(mtl).unwrap();
    }
    // Both branches above must have run often.
    assert!(loaded > 2_000 && refused > 2_000, "{loaded} loaded, {refused} refused");
    assert!(with_normals > 1_000, "{with_normals} with normals");
}

/// A scene used for measurements. It is not part of the project; `None` if it is not there.
fn load_scene(name: &str) -> Option<(Mesh, MeshReport)> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes").join(name);
    if !path.exists() {
        eprintln!("skipped: {} does not exist", path.display());
        return None;
    }
    Some(load_obj(&path).unwrap())
}

fn assert_bounds(bounds: Aabb, lo: [f32; 3], hi: [f32; 3]) {
    for (found, expected) in [(bounds.lo, lo), (bounds.hi, hi)] {
        assert!((found - Vec3::from_array(expected)).abs().max_element() <= 0.000_501, "{bounds:?}");
    }
}

#[test]
fn the_bunny_is_complete() {
    let Some((mesh, report)) = load_scene("bunny.obj") else { return };
    assert_eq!((mesh.len(), report.vertices), (69_451, 35_947));
    // The other vertices belong to no triangle.
    assert_eq!(mesh.positions().len(), 34_834);
    assert_eq!((report.degenerate, report.ignored_elements, report.warnings), (0, 0, vec![]));
    assert_bounds(mesh.bounds(), [-0.095, 0.033, -0.062], [0.061, 0.187, 0.059]);
}

#[test]
fn the_sponza_is_complete() {
    let Some((mesh, report)) = load_scene("sponza.obj") else { return };
    assert_eq!((mesh.len(), report.vertices, mesh.positions().len()), (66_454, 39_999, 39_999));
    assert_eq!((report.degenerate, report.ignored_elements, report.warnings), (1, 0, vec![]));
    assert_bounds(mesh.bounds(), [-17.403, -0.907, -7.799], [17.417, 15.653, 7.801]);
}
