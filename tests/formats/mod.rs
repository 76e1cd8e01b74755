//! Tests of the loaders of PLY and STL files. What they read is compared with the same mesh from an OBJ file.

use std::fs;
use std::path::Path;

use glam::{Vec2, Vec3};
use raylanes::conformance::Random;
use raylanes::tracer::{Error, Mesh, MeshReport, SceneSource, load_mesh, load_obj, load_ply, load_stl};

use super::files::{Files, is_short_line, mutate};

/// Two sides of a tetrahedron, one of them a concave polygon, and a polygon that is not flat.
const CORNERS: [[i8; 3]; 5] = [[0, 0, 0], [4, 0, 0], [1, 1, 0], [0, 4, 0], [0, 0, 3]];
const FACES: [&[u8]; 3] = [&[0, 1, 4], &[1, 2, 3, 0], &[4, 1, 2, 3]];
/// The normal and the texture coordinates of each vertex.
const ATTRIBUTES: [[i8; 5]; 5] = [[0, 0, 1, 0, 5], [0, 2, 0, 1, 4], [-1, 0, 0, 2, 3], [0, 0, 0, 3, 2], [1, 1, 1, 4, 1]];

fn obj() -> String {
    let lines = CORNERS
        .iter()
        .zip(ATTRIBUTES)
        .map(|([x, y, z], [nx, ny, nz, s, t])| format!("v {x} {y} {z}\nvn {nx} {ny} {nz}\nvt {s} {t}\n"));
    let corner = |index: &u8| format!(" {0}/{0}/{0}", index + 1);
    let faces = FACES.iter().map(|face| format!("f{}\n", face.iter().map(corner).collect::<String>()));
    lines.chain(faces).collect()
}

/// Numbers as a file of one of the formats holds them.
struct Numbers {
    format: &'static str,
    bytes: Vec<u8>,
}

impl Numbers {
    fn push(&mut self, scalar: &str, number: i8) {
        if self.format == "ascii" {
            return self.bytes.extend(format!("{number} ").bytes());
        }
        let number = i16::from(number);
        let mut bytes = match scalar {
            "char" | "int8" | "uchar" | "uint8" => vec![number as u8],
            "short" | "int16" | "ushort" | "uint16" => number.to_le_bytes().to_vec(),
            "int" | "int32" | "uint" | "uint32" => i32::from(number).to_le_bytes().to_vec(),
            "float" | "float32" => f32::from(number).to_le_bytes().to_vec(),
            "double" | "float64" => f64::from(number).to_le_bytes().to_vec(),
            _ => panic!("{scalar}"),
        };
        if self.format == "binary_big_endian" {
            bytes.reverse();
        }
        self.bytes.extend(bytes);
    }

    fn end_element(&mut self) {
        if self.format == "ascii" {
            self.bytes.push(b'\n');
        }
    }
}

const FORMATS: [&str; 3] = ["ascii", "binary_little_endian", "binary_big_endian"];

/// The mesh as a PLY file. `scalars` are the types of coordinates, counts and indices, `names` those of the list and of
/// the texture coordinates.
fn ply(format: &'static str, [coordinate, count, index]: [&str; 3], [list, s, t]: [&str; 3]) -> Vec<u8> {
    let properties: String =
        ["x", "y", "z", "nx", "ny", "nz", s, t].map(|name| format!("property {coordinate} {name}\n")).concat();
    let header = format!(
        "ply\nformat {format} 1.0\nobj_info \u{e9}\ncomment C:\\meshes\\\nelement vertex {}\n{properties}\
         element face {}\nproperty list {count} {index} {list}\nend_header\n",
        CORNERS.len(),
        FACES.len()
    );
    let mut numbers = Numbers { format, bytes: header.into() };
    for (corner, attributes) in CORNERS.iter().zip(&ATTRIBUTES) {
        corner.iter().chain(attributes).for_each(|&number| numbers.push(coordinate, number));
        numbers.end_element();
    }
    for face in FACES {
        numbers.push(count, face.len() as i8);
        face.iter().for_each(|&corner| numbers.push(index, corner as i8));
        numbers.end_element();
    }
    numbers.bytes
}

type Load = fn(&Path) -> Result<(Mesh, MeshReport), Error>;

fn load(load: Load, content: impl AsRef<[u8]>) -> (Mesh, MeshReport) {
    load(&Files::new().write("x", content)).unwrap()
}

/// The mesh of a file. The loader must have nothing to report.
fn mesh(loader: Load, content: impl AsRef<[u8]>) -> Mesh {
    let (mesh, report) = load(loader, content);
    assert_eq!(report.warnings, [""; 0]);
    mesh
}

fn warnings(load: Load, content: impl AsRef<[u8]>) -> Vec<String> {
    let files = Files::new();
    let (_, report) = load(&files.write("x", content)).unwrap();
    report.warnings.iter().map(|warning| files.shorten(warning)).collect()
}

fn error(load: Load, content: impl AsRef<[u8]>) -> String {
    let files = Files::new();
    let message = load(&files.write("x", content)).unwrap_err().to_string();
    assert!(is_short_line(&message), "{message}");
    files.shorten(&message)
}

/// Vertices, normals and texture coordinates of each triangle.
type Corners = ([Vec3; 3], Option<[Vec3; 3]>, Option<[Vec2; 3]>);

fn corners(mesh: &Mesh) -> Vec<Corners> {
    let of = |(triangle, primitive): (raylanes::geom::Triangle, u32)| {
        (triangle.vertices(), mesh.normals(primitive), mesh.texture_coordinates(primitive))
    };
    mesh.iter().zip(0..).map(of).collect()
}

#[test]
fn a_ply_file_gives_the_mesh_of_the_obj_file() {
    let (expected, report) = load(load_obj, obj());
    assert_eq!((expected.len(), report.warnings.len()), (5, 1));
    for format in FORMATS {
        for scalars in [
            ["float", "uchar", "int"],
            ["double", "int", "uint"],
            ["char", "char", "uchar"],
            ["short", "short", "ushort"],
            ["int", "ushort", "short"],
            ["float32", "uint8", "int32"],
            ["float64", "uint32", "int8"],
            ["int16", "int16", "uint16"],
        ] {
            for names in [["vertex_indices", "s", "t"], ["vertex_index", "u", "v"]] {
                let (found, report) = load(load_ply, ply(format, scalars, names));
                assert_eq!(corners(&found), corners(&expected), "{format} {scalars:?} {names:?}");
                assert_eq!((found.positions().len(), report.vertices), (5, 5));
                assert_eq!(found.color(0), expected.color(0));
                // The same warning as for the OBJ file.
                let [warning] = &report.warnings[..] else { panic!("{report:?}") };
                assert!(warning.contains("polygon is not flat") && warning.ends_with("face 2, 4 corners"), "{warning}");
                assert_eq!(warning.contains(":24:"), format == "ascii", "{warning}");
            }
        }
    }
}

const HEADER: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                      element face 1\nproperty list uchar int vertex_indices\nend_header\n";
const VERTICES: &str = "0 0 0\n1 0 0\n0 1 0\n";

#[test]
fn what_a_ply_file_has_besides_is_reported_once() {
    assert_eq!(mesh(load_ply, format!("{HEADER}{VERTICES}3 0 1 2\n")).len(), 1);
    // Line breaks of three kinds, empty lines, white space.
    for line_break in ["\r\n", "\r", " \n\n\t"] {
        let text = format!("{HEADER}{VERTICES}3 0 1 2").replace('\n', line_break);
        assert_eq!(mesh(load_ply, text).len(), 1, "{line_break:?}");
    }
    let header = HEADER
        .replace(
            "element face",
            "property uchar red\nproperty list int float nx\nproperty float s\nelement edge 2\n\
                  property int vertex1\nproperty list int int more\nelement none 0\nelement face",
        )
        .replace("end_header", "property uchar blue\nend_header");
    let vertices = "0 0 0 9 2 1 1 5\n1 0 0 9 0 5\n0 1 0 9 0 5\n";
    let text = format!("{header}{vertices}7 1 0\n7 2 0 0\n3 0 1 2 9\n\n4 5 6\n");
    assert_eq!(
        warnings(load_ply, text),
        [
            "x: property ignored: \"red\" (and 3 more)",
            "x: element ignored: \"edge\" (and 1 more)",
            "x: data after the last element, ignored",
        ]
    );
    for format in &FORMATS[1..] {
        let mut bytes = ply(format, ["float", "uchar", "int"], ["vertex_index", "s", "t"]);
        bytes.push(0);
        assert_eq!(warnings(load_ply, bytes)[1..], ["x: data after the last element, ignored"]);
    }
}

#[test]
fn errors_in_a_ply_text_name_the_line() {
    for (lines, message) in [
        ("0 0 x\n", "10: a number cannot be read, or does not fit its type: \"0 0 x\""),
        ("0 nan 0\n", "10: a number cannot be read, or does not fit its type: \"0 nan 0\""),
        ("0 inf 0\n", "10: a number cannot be read, or does not fit its type: \"0 inf 0\""),
        ("0 0 0\n\n0 1e39 0\n", "12: y is infinite or too large: \"0 1e39 0\""),
        ("0 0\n", "10: the line ends before the property z: \"0 0\""),
        ("0 0 0 0\n", "10: the line has more numbers than the element has properties: \"0 0 0 0\""),
        ("0 0 0\n1 0 0\n", " the file ends before vertex 2, its header says 3"),
        ("", " the file ends before vertex 0, its header says 3"),
    ] {
        assert_eq!(error(load_ply, format!("{HEADER}{lines}")), format!("x:{message}"));
    }
    for (face, message) in [
        ("3 0 1 3", "13: there is no vertex 3, the file has 3: \"3 0 1 3\""),
        ("3 0 -1 2", "13: there is no vertex -1, the file has 3: \"3 0 -1 2\""),
        ("2 0 1", "13: a face needs 3 vertices, this one has 2: \"2 0 1\""),
        ("0", "13: a face needs 3 vertices, this one has 0: \"0\""),
        ("3 0 1 1.5", "13: a number cannot be read, or does not fit its type: \"3 0 1 1.5\""),
        ("3 0 1 2147483648", "13: a number cannot be read, or does not fit its type: \"3 0 1 2147483648\""),
        ("-3 0 1 2", "13: the line has more numbers than the element has properties: \"-3 0 1 2\""),
        (
            "18446744073709551615 0 1 2",
            "13: the line ends before the property vertex_indices: \"18446744073709551615 0 1 2\"",
        ),
        ("4 0 1 2", "13: the line ends before the property vertex_indices: \"4 0 1 2\""),
        ("3 0 1 2 0", "13: the line has more numbers than the element has properties: \"3 0 1 2 0\""),
        ("3 0 1 \u{e9}", "13: a number cannot be read, or does not fit its type: \"3 0 1 \u{e9}\""),
        ("", " the file ends before face 0, its header says 1"),
    ] {
        assert_eq!(error(load_ply, format!("{HEADER}{VERTICES}{face}\n")), format!("x:{message}"));
    }
}

#[test]
fn errors_in_a_ply_header_name_the_line() {
    for (old, new, message) in [
        ("ply\n", "plx\n", "1: Expected magic number 'ply': \"plx\""),
        ("format ascii 1.0\n", "", "8: No format line found: \"end_header\""),
        ("ascii", "utf8", "2: Couldn't parse line: \"format utf8 1.0\""),
        ("vertex 3", "vertex -3", "3: Couldn't parse line: \"element vertex -3\""),
        ("vertex 3", "vertex 3e0", "3: Couldn't parse line: \"element vertex 3e0\""),
        ("vertex 3", "vertex 99999999999999999999", "3: Invalid element: \"element vertex 99999999999999999999\""),
        ("float y", "real y", "5: Couldn't parse line: \"property real y\""),
        ("float y", "float x", "5: declared twice: \"property float x\""),
        ("element face", "element vertex", "7: declared twice: \"element vertex 1\""),
        ("float y", "list int int y", " element vertex has no property y that is a number"),
        ("float y", "float w", " element vertex has no property y that is a number"),
        ("element vertex", "element point", " there is no element vertex"),
        ("element face", "element triangle", " there is no element face"),
        (
            "vertex_indices",
            "corners",
            " element face needs one list of whole numbers named vertex_indices or vertex_index",
        ),
        ("list uchar int", "int", " element face needs one list of whole numbers named vertex_indices or vertex_index"),
        (
            "uchar int",
            "uchar float",
            " element face needs one list of whole numbers named vertex_indices or vertex_index",
        ),
        (
            "uchar int",
            "float int",
            " element face needs one list of whole numbers named vertex_indices or vertex_index",
        ),
        ("element face", "element edge 7\nelement face", " element edge has no properties"),
        ("end_header\n0", "0", "9: Couldn't parse line: \"0 0 0\""),
    ] {
        let text = format!("{HEADER}{VERTICES}3 0 1 2\n");
        assert!(text.contains(old), "{old}");
        assert_eq!(error(load_ply, text.replacen(old, new, 1)), format!("x:{message}"));
    }
    let faces_first = "ply\nformat ascii 1.0\nelement face 1\nproperty list int int vertex_index\nelement vertex 1\n\
                       property float x\nproperty float y\nproperty float z\nend_header\n";
    assert_eq!(error(load_ply, faces_first), "x: the faces come before the vertices");
    assert_eq!(
        error(load_ply, HEADER.replace("end_header\n", "")),
        "x: Unexpected end of file while reading header (missing 'end_header')"
    );
    assert_eq!(error(load_ply, ""), "x: Unexpected end of file while reading magic number");
    let no_faces = HEADER.replace("face 1", "face 0");
    assert_eq!(error(load_ply, format!("{no_faces}{VERTICES}")), "x: no triangles");
    assert!(error(load_ply, b"\xff\xfep\0l\0y\0").starts_with("x:1: the text is UTF-16LE"));
}

/// Work that no file of this size can need must not be done.
#[test]
fn a_header_that_announces_too_much_is_refused_at_once() {
    let begin = std::time::Instant::now();
    let many = "1000000000000000000";
    let huge = HEADER.replace("vertex 3", &format!("vertex {many}"));
    assert_eq!(error(load_ply, &huge), format!("x: the file ends before vertex 0, its header says {many}"));
    for format in &FORMATS[1..] {
        let mut bytes = huge.replace("ascii", format).into_bytes();
        bytes.extend([0; 30]);
        assert_eq!(error(load_ply, bytes), format!("x: the file ends before vertex 2, its header says {many}"));
        // A list of four billion indices.
        let header = HEADER.replace("ascii", format).replace("uchar", "uint");
        let bytes = [header.as_bytes(), &[0; 36], &[255; 400]].concat();
        assert_eq!(error(load_ply, bytes), "x: the file ends before face 0, its header says 1");
        let empty =
            HEADER.replace("ascii", format).replace("element face", &format!("element nothing {many}\nelement face"));
        assert_eq!(error(load_ply, empty), "x: element nothing has no properties");
    }
    let property = format!("property float {}\n", "a".repeat(2000));
    let long = HEADER.replace("end_header", &format!("{property}end_header"));
    assert!(error(load_ply, long).starts_with("x:9: a line of the header is longer than 1024 bytes: "));
    let properties: String = (0..5000).map(|number| format!("property float a{number}\n")).collect();
    let long = HEADER.replace("end_header", &format!("{properties}end_header"));
    assert!(error(load_ply, long).contains(": more than 4096 elements and properties: "));
    let mut stl = [0; 184];
    stl[80..84].fill(255);
    assert_eq!(error(load_stl, stl), "x: the file ends in triangle 2, its header says 4294967295");
    assert!(begin.elapsed().as_secs() < 10);
}

#[test]
fn errors_in_a_binary_ply_file_name_the_element() {
    for format in &FORMATS[1..] {
        let is_big = *format == "binary_big_endian";
        let start = HEADER.replace("ascii", format).replace("uchar", "char");
        let float = |number: f32| if is_big { number.to_be_bytes() } else { number.to_le_bytes() };
        let int = |number: i32| if is_big { number.to_be_bytes() } else { number.to_le_bytes() };
        let file = |z: f32, count: i8, indices: &[i32]| {
            let coordinates = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, z].map(float).concat();
            [start.as_bytes(), &coordinates, &[count as u8], &indices.iter().copied().flat_map(int).collect::<Vec<_>>()]
                .concat()
        };
        assert_eq!(mesh(load_ply, file(0.0, 3, &[0, 1, 2])).len(), 1);
        for (content, message) in [
            (file(f32::NAN, 3, &[0, 1, 2]), "vertex 2: z is NaN"),
            (file(f32::INFINITY, 3, &[0, 1, 2]), "vertex 2: z is infinite or too large"),
            (file(f32::NEG_INFINITY, 3, &[0, 1, 2]), "vertex 2: z is infinite or too large"),
            (file(0.0, 3, &[0, 1, 3]), "face 0: there is no vertex 3, the file has 3"),
            (file(0.0, 3, &[0, 1, -1]), "face 0: there is no vertex -1, the file has 3"),
            (file(0.0, 2, &[0, 1]), "face 0: a face needs 3 vertices, this one has 2"),
            (file(0.0, -1, &[]), "face 0: List length cannot be negative (i8)"),
            (file(0.0, 3, &[0, 1]), "the file ends before face 0, its header says 1"),
        ] {
            assert_eq!(error(load_ply, content), format!("x: {message}"), "{format}");
        }
        let whole = file(0.0, 3, &[0, 1, 2]);
        for length in 0..whole.len() {
            error(load_ply, &whole[..length]);
        }
    }
}

/// A tetrahedron, closed.
const TETRAHEDRON: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 4 3\nf 1 2 4\nf 2 3 4\n";

fn stl_text(mesh: &Mesh) -> String {
    let facets: String = mesh
        .iter()
        .map(|triangle| {
            let vertices = triangle.vertices().map(|Vec3 { x, y, z }| format!("      vertex {x:e} {y} {z}\n")).concat();
            format!("  facet normal 0 0 1\n    outer loop\n{vertices}    endloop\n  endfacet\n")
        })
        .collect();
    format!("solid some name\n{facets}endsolid some name\n")
}

fn stl_binary(header: &[u8], mesh: &Mesh) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, b' ');
    bytes.extend((mesh.len() as u32).to_le_bytes());
    for triangle in mesh.iter() {
        bytes.extend([0; 12]);
        bytes.extend(triangle.vertices().iter().flat_map(Vec3::to_array).flat_map(f32::to_le_bytes));
        bytes.extend(b"\x07\n");
    }
    bytes
}

#[test]
fn an_stl_file_gives_the_mesh_of_the_obj_file() {
    for obj in [TETRAHEDRON.to_owned(), obj()] {
        let (expected, _) = load(load_obj, &obj);
        let text = stl_text(&expected);
        let files = [
            text.clone().into_bytes(),
            text.to_uppercase().into(),
            text.replace('\n', "\r\n").into(),
            text.replace(" some name", "").into(),
            text.replace("normal 0 0 1", "normal nan nan nan").into(),
            // A backslash joins no lines, and a name in Latin-1 is no error.
            text.replacen("some name", "C:\\stl\\", 1).into(),
            [b"\n\tsolid \xe9", &text.as_bytes()[5..]].concat(),
            // Two solids.
            text.replacen("endfacet\n", "endfacet\nendsolid\n\nsolid next\n", 1).into(),
            stl_binary(b"", &expected),
            stl_binary(b"solid", &expected),
            // With a line break and no byte that could not be text. stl_io takes it for a text.
            stl_binary(b"solid name\n", &expected),
        ];
        for (number, file) in files.iter().enumerate() {
            let (found, report) = load(load_stl, file);
            let vertices = |mesh: &Mesh| mesh.iter().map(|triangle| triangle.vertices()).collect::<Vec<_>>();
            assert_eq!(vertices(&found), vertices(&expected), "{number}");
            // Vertices are shared as in the OBJ file.
            assert_eq!(found.positions().len(), expected.positions().len());
            assert_eq!(found.is_closed(), expected.is_closed());
            assert_eq!((found.normals(0), found.color(0)), (None, expected.color(0)));
            assert_eq!((report.vertices, report.warnings), (3 * found.len(), vec![]));
        }
    }
}

#[test]
fn errors_in_an_stl_text_name_the_line() {
    let text = stl_text(&load(load_obj, TETRAHEDRON).0);
    for (old, new, message) in [
        ("vertex 0e0 0 0", "vertex 0 nan 0", "4: vertex coordinate is NaN: \"vertex 0 nan 0\""),
        ("vertex 0e0 0 0", "vertex 0 0 1e39", "4: vertex coordinate is infinite or too large: \"vertex 0 0 1e39\""),
        ("vertex 0e0 0 0", "vertex 0 x 0", "4: vertex coordinate cannot be read: \"vertex 0 x 0\""),
        ("vertex 0e0 0 0", "vertex 0 0", "4: a vertex needs 3 coordinates: \"vertex 0 0\""),
        ("vertex 0e0 0 0", "vertex 0 0 0 0", "4: a vertex needs 3 coordinates: \"vertex 0 0 0 0\""),
        ("vertex 0e0 0 0\n", "", "6: vertex f32 f32 f32, got [\"endloop\"]: \"    endloop\""),
        ("outer loop", "outer", "3: expected [\"outer\", \"loop\"], got [\"outer\"]: \"    outer\""),
        (
            "facet",
            "facets",
            "2: invalid facet header: [\"facets\", \"normal\", \"0\", \"0\", \"1\"]: \"  facets normal 0 0 1\"",
        ),
        ("endfacet\n", "endfacet\n#\n", "9: invalid facet header: [\"#\"]: \"#\""),
        ("endsolid some name", "", " EOF while expecting facet or endsolid."),
        ("endsolid some name", "endsolid\nmore", "31: ascii STL does not start with \"solid \": \"more\""),
    ] {
        assert!(text.contains(old), "{old}");
        assert_eq!(error(load_stl, text.replacen(old, new, 1)), format!("x:{message}"));
    }
    assert_eq!(error(load_stl, "solid\nendsolid\n"), "x: no triangles");
    for length in 5..text.trim_end().len() - "endsolid some name".len() {
        error(load_stl, &text[..length]);
    }
}

#[test]
fn errors_in_a_binary_stl_file_name_the_triangle() {
    let tetrahedron = load(load_obj, TETRAHEDRON).0;
    let whole = stl_binary(b"solid", &tetrahedron);
    for length in 0..whole.len() {
        let message = match length.checked_sub(84) {
            // Without a zero byte, the header is a text.
            None if (5..=81).contains(&length) => "x: EOF while expecting facet or endsolid.".to_owned(),
            None => "x: no STL file: a text begins with \"solid\", and a binary file has at least 84 bytes".to_owned(),
            Some(rest) => format!("x: the file ends in triangle {}, its header says 4", rest / 50),
        };
        let found = error(load_stl, &whole[..length]);
        assert_eq!(found, message, "{length}");
    }
    for (number, reason) in [
        (f32::NAN, "is NaN"),
        (f32::INFINITY, "is infinite or too large"),
        (-f32::INFINITY, "is infinite or too large"),
    ] {
        let mut bytes = whole.clone();
        bytes[84 + 2 * 50 + 12 + 32..][..4].copy_from_slice(&number.to_le_bytes());
        assert_eq!(error(load_stl, bytes), format!("x: triangle 2: vertex coordinate {reason}"));
    }
    // A normal may be NaN.
    let mut bytes = whole.clone();
    bytes[84..88].fill(255);
    assert_eq!(mesh(load_stl, bytes).len(), 4);
    let mut longer = whole;
    longer[80] = 3;
    assert_eq!(warnings(load_stl, &longer), ["x: bytes after the last triangle, ignored: the header says 3"]);
    longer[80] = 0;
    assert_eq!(error(load_stl, &longer), "x: no triangles");
}

#[test]
fn files_are_loaded_by_their_extension() {
    let files = Files::new();
    let tetrahedron = load(load_obj, TETRAHEDRON).0;
    let ply = ply("ascii", ["float", "uchar", "int"], ["vertex_index", "s", "t"]);
    let contents = [("x.obj", obj().into_bytes()), ("x.PLY", ply), ("x.stl", stl_binary(b"", &tetrahedron))];
    for (name, content) in contents {
        let path = files.write(name, content);
        let (mesh, report) = load_mesh(&path).unwrap();
        let scene = SceneSource::parse(path.to_str().unwrap()).unwrap();
        scene.check().unwrap();
        assert_eq!(scene.name(), name);
        assert_eq!(scene.load().unwrap().remarks, report.warnings);
        let text = format!("[[mesh]]\nname = 'm'\nfile = '{name}'\n[[instance]]\nof = 'm'\n");
        let toml = files.write("x.toml", text);
        let scene = SceneSource::parse(toml.to_str().unwrap()).unwrap().load().unwrap();
        assert_eq!(scene.remarks.len(), report.warnings.len());
        let (geometries, _) = scene.world.into_parts();
        let [raylanes::tracer::Geometry::Mesh(found)] = &geometries[..] else { panic!("{name}") };
        assert_eq!(*found, mesh, "{name}");
        fs::remove_file(&path).unwrap();
        let message = files.shorten(&load_mesh(&path).unwrap_err().to_string());
        assert_eq!(message, format!("cannot read {name}: No such file or directory"));
    }
    let message = files.shorten(&load_mesh(&files.path("x.off")).unwrap_err().to_string());
    assert_eq!(message, "x.off: expected an OBJ, PLY or STL file (*.obj, *.ply, *.stl)");
    // A file that never ends.
    if Path::new("/dev/zero").exists() {
        assert!(load_ply(Path::new("/dev/zero")).is_err() && load_stl(Path::new("/dev/zero")).is_err());
    }
}

/// Pieces of text with a meaning in PLY and STL files.
const PIECES: [&str; 22] = [
    "\n",
    "\r",
    " ",
    "\0",
    "\u{e9}",
    "\u{ff}",
    "-",
    ".",
    "e9",
    "nan",
    "99999999999999999999",
    "3 0 1 2\n",
    "element ",
    "element face 7\n",
    "property float x\n",
    "property list uint int vertex_index\n",
    "list ",
    "double ",
    "end_header\n",
    "solid \n",
    "endsolid\n",
    "vertex 0 1 2\n",
];

#[test]
fn corrupted_files_neither_panic_nor_make_broken_meshes() {
    let tetrahedron = load(load_obj, TETRAHEDRON).0;
    let (scalars, names) = (["char", "char", "char"], ["vertex_index", "s", "t"]);
    // Binary files of bytes that are text, because the damage is made to text.
    let originals: [(Load, Vec<u8>); 5] = [
        (load_ply, ply("ascii", ["double", "uchar", "int"], names)),
        (load_ply, ply("binary_little_endian", ["short", "int", "uchar"], names)),
        (load_ply, ply("binary_big_endian", scalars, names)),
        (load_stl, stl_text(&tetrahedron).into()),
        (load_stl, stl_binary(b"solid", &tetrahedron)),
    ];
    let files = Files::new();
    let mut random = Random::from_seed(1);
    for (number, (load, original)) in originals.iter().enumerate() {
        let (mut loaded, mut refused) = (0, 0);
        for _ in 0..4_000 {
            let text: String = original.iter().copied().map(char::from).collect();
            let damaged = mutate(&text, &PIECES, &mut random);
            // Back to one byte per character, as far as it is still text.
            let damaged = match str::from_utf8(&damaged) {
                Ok(text) => text.chars().map(|c| c as u8).collect(),
                Err(_) => damaged,
            };
            let path = files.write("x", damaged);
            match load(&path) {
                Ok((mesh, report)) => {
                    loaded += 1;
                    assert!(mesh.iter().flat_map(|triangle| triangle.vertices()).all(Vec3::is_finite));
                    assert!(report.warnings.iter().all(|warning| is_short_line(warning)), "{report:?}");
                }
                Err(error) => {
                    refused += 1;
                    assert!(is_short_line(&error.to_string()), "{error}");
                }
            }
            fs::remove_file(path).unwrap();
        }
        assert!(loaded > 100 && refused > 100, "{number}: {loaded} loaded, {refused} refused");
    }
}
