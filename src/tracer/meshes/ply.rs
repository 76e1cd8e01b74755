//! PLY files: text, and binary of both byte orders. `ply-rs-bw` parses them, but what it gets is checked first.
//!
//! It alone is not enough. It takes the second of two properties of one name for both, ignores numbers beyond the last
//! property of a line, and runs as long as a header wants that announces many elements without properties. So
//! [`CheckedReader`] gives it one checked line at a time, and it reads one element at a time.
//!
//! | in the file | what becomes of it |
//! | --- | --- |
//! | `x`, `y`, `z` of `vertex`, of any type | a vertex, rounded to `f32` |
//! | `nx`, `ny`, `nz` of `vertex` | its normal; see [`Mesh::normals`] |
//! | `s`, `t`, or else `u`, `v`, of `vertex` | its texture coordinates |
//! | the list `vertex_indices` or `vertex_index` of `face` | triangles; polygons are split as those of an OBJ file |
//! | any other property or element | ignored with a warning |
//! | `comment`, `obj_info` | ignored |
//!
//! Elements are counted from 0, as the indices in the file are. Numbers in a text have digits on both sides of a point.

use std::collections::HashSet;
use std::io::{BufRead, ErrorKind};
use std::path::Path;

use glam::{Vec2, Vec3};
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    DefaultElement, ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType,
    ScalarType,
};

use super::line::{Line, LineCount, LineError, not_finite};
use super::mesh::{DEFAULT_COLOR, Mesh, Part};
use super::polygon::OddPolygons;
use super::reader::{CheckedReader, LineChecker};
use super::report::MeshReport;
use crate::error::{Error, quoted};

/// Largest length in bytes of a line of the header, and largest number of its elements and properties. `ply-rs-bw`
/// takes time in proportion to their product.
const MAX_HEADER_LINE: usize = 1 << 10;
const MAX_DECLARATIONS: usize = 1 << 12;

/// Largest number of corners of a face. It bounds the time to split one.
const MAX_CORNERS: usize = 1 << 23;

/// Loads a PLY file. Triangles are in the order of the file's faces.
///
/// # Errors
/// If the file cannot be read, ends early or is not valid, or if there are no triangles. The error names the line of a
/// text, or the element of a binary file, counted from 0.
pub fn load_ply(path: &Path) -> Result<(Mesh, MeshReport), Error> {
    let mut lines = CheckedReader::open(path, PlyLines::default())?;
    let header = Parser::<DefaultElement>::new().read_header(&mut Reader::new(&mut lines));
    let header = header.map_err(|error| lines.error(summary(&error)))?;
    let uses = Uses::of(&header).map_err(|message| Error::in_file(path, message))?;
    let mut elements = Elements { path, encoding: header.encoding, lines };
    let mut surface = Surface::default();
    for element in header.elements.values() {
        match element.name.as_str() {
            "vertex" => elements.read(element, |vertex, _| surface.add_vertex(&vertex, &uses))?,
            "face" => elements.read(element, |face: Face, place| surface.add_face(face, place))?,
            _ => elements.read(element, |_: Ignored, _| Ok(()))?,
        }
    }

    let mut warnings: Vec<_> = surface.odd_polygons.warnings(path).collect();
    warnings.extend(uses.ignored_properties.warning(path, "property ignored"));
    warnings.extend(uses.ignored_elements.warning(path, "element ignored"));
    if elements.has_more()? {
        warnings.push(Error::in_file(path, "data after the last element, ignored").to_string());
    }
    let Surface { positions, normals, texture_coordinates, triangles, .. } = surface;
    let vertices = positions.len();
    let has_values = uses.normals || uses.texture_coordinates.is_some();
    let corners = if has_values { triangles.clone() } else { Vec::new() };
    let mesh = Mesh::new(positions, triangles, vec![Part { first_triangle: 0, color: DEFAULT_COLOR }])
        .and_then(|mut mesh| {
            if uses.normals {
                mesh = mesh.with_normals(normals, corners.clone())?;
            }
            if uses.texture_coordinates.is_some() {
                mesh = mesh.with_texture_coordinates(texture_coordinates, corners)?;
            }
            Ok(mesh)
        })
        .map_err(|error| Error::in_file(path, error.to_string()))?;
    let report = MeshReport { vertices, degenerate: mesh.degenerate_triangles(), ignored_elements: 0, warnings };
    Ok((mesh, report))
}

/// What `ply-rs-bw` says, without the line, which messages here begin with, and without its text, which they end with.
fn summary(error: &ParseError) -> String {
    let text = error.to_string();
    let line = text.lines().next().unwrap_or_default();
    let line = line.strip_prefix("Line ").and_then(|rest| rest.split_once(": ")).map_or(line, |(_, message)| message);
    line.trim_end_matches(['.', ':']).to_owned()
}

/// Which properties of the file are used.
struct Uses {
    normals: bool,
    /// The place in [`Vertex::NAMES`] of the first one.
    texture_coordinates: Option<usize>,
    ignored_properties: LineCount,
    ignored_elements: LineCount,
}

impl Uses {
    /// Checks that the header announces vertices and faces as they are read here.
    fn of(header: &Header) -> Result<Self, String> {
        let place = |name| header.elements.get_index_of(name).ok_or_else(|| format!("there is no element {name}"));
        if place("face")? < place("vertex")? {
            return Err("the faces come before the vertices".into());
        }
        if let Some(empty) = header.elements.values().find(|element| element.count > 0 && element.properties.is_empty())
        {
            return Err(format!("element {} has no properties", empty.name));
        }
        let (vertex, face) = (&header.elements["vertex"], &header.elements["face"]);
        let is_number = |name: &&str| {
            vertex.properties.get(*name).is_some_and(|property| matches!(property.data_type, PropertyType::Scalar(_)))
        };
        let have = |names: &[&str]| names.iter().all(is_number);
        if let Some(missing) = Vertex::NAMES[..3].iter().find(|name| !is_number(name)) {
            return Err(format!("element vertex has no property {missing} that is a number"));
        }
        let lists: Vec<_> = Face::NAMES.iter().filter_map(|name| face.properties.get(*name)).collect();
        let is_list = match *lists {
            [list] => match &list.data_type {
                PropertyType::List(count, index) => is_whole(count) && is_whole(index),
                PropertyType::Scalar(_) => false,
            },
            _ => false,
        };
        if !is_list {
            let [one, other] = Face::NAMES;
            return Err(format!("element face needs one list of whole numbers named {one} or {other}"));
        }

        let normals = have(&Vertex::NAMES[3..6]);
        let texture_coordinates = [6, 8].into_iter().find(|&first| have(&Vertex::NAMES[first..first + 2]));
        let (mut ignored_properties, mut ignored_elements) = (LineCount::default(), LineCount::default());
        for name in vertex.properties.keys() {
            let is_used = match Vertex::NAMES.iter().position(|known| known == name) {
                None => false,
                Some(number @ 0..6) => number < 3 || normals,
                Some(number) => texture_coordinates.is_some_and(|first| (first..first + 2).contains(&number)),
            };
            if !is_used {
                ignored_properties.add_with(None, || quoted(name.as_bytes()));
            }
        }
        for name in face.properties.keys().filter(|name| !Face::NAMES.contains(&name.as_str())) {
            ignored_properties.add_with(None, || quoted(name.as_bytes()));
        }
        for element in header.elements.values().filter(|element| !["vertex", "face"].contains(&element.name.as_str())) {
            ignored_elements.add_with(None, || quoted(element.name.as_bytes()));
        }
        Ok(Self { normals, texture_coordinates, ignored_properties, ignored_elements })
    }
}

fn is_whole(scalar: &ScalarType) -> bool {
    !matches!(scalar, ScalarType::Float | ScalarType::Double)
}

/// Reads the elements of a file, in the order of its header.
struct Elements<'a> {
    path: &'a Path,
    encoding: Encoding,
    lines: CheckedReader<'a, PlyLines>,
}

/// Where an element is.
struct Place {
    number: usize,
    /// Its line in a text.
    line: Option<usize>,
}

impl Elements<'_> {
    /// Gives all elements of one kind to `take`, which may refuse one with a message.
    fn read<E: PropertyAccess>(
        &mut self,
        kind: &ElementDef,
        mut take: impl FnMut(E, &Place) -> Result<(), String>,
    ) -> Result<(), Error> {
        let parser = Parser::new();
        for number in 0..kind.count {
            let parsed = match self.encoding {
                Encoding::Ascii => self.parse_line(&parser, kind, number)?,
                Encoding::BinaryBigEndian => parser.read_big_endian_element(self.lines.rest(), kind),
                Encoding::BinaryLittleEndian => parser.read_little_endian_element(self.lines.rest(), kind),
            };
            let line = (self.encoding == Encoding::Ascii).then(|| self.lines.line());
            let taken = match parsed {
                Ok(element) => take(element, &Place { number, line }),
                Err(_) if line.is_some() => Err("a number cannot be read, or does not fit its type".into()),
                Err(error) => match error.kind() {
                    ErrorKind::UnexpectedEof => return Err(self.ends_early(kind, number)),
                    ErrorKind::InvalidInput | ErrorKind::InvalidData => Err(summary(&error)),
                    _ => return Err(Error::reading(self.path)(error.into())),
                },
            };
            taken.map_err(|message| match line {
                Some(_) => self.lines.error(message),
                None => Error::in_file(self.path, format!("{} {number}: {message}", kind.name)),
            })?;
        }
        Ok(())
    }

    /// Parses the next line. The outer error is one of the file, or of the number of words in the line.
    fn parse_line<E: PropertyAccess>(
        &mut self,
        parser: &Parser<E>,
        kind: &ElementDef,
        number: usize,
    ) -> Result<Result<E, ParseError>, Error> {
        let mut text = String::new();
        match self.lines.read_line(&mut text) {
            Ok(0) => return Err(self.ends_early(kind, number)),
            Ok(_) => {}
            Err(error) => return Err(self.lines.error(error)),
        }
        let mut words = text.split_ascii_whitespace();
        for property in kind.properties.values() {
            let word = words.next();
            let last = match property.data_type {
                PropertyType::Scalar(_) => word,
                // A count that cannot be read is left to the parser.
                PropertyType::List(..) => match word.map_or(Ok(0), str::parse::<usize>) {
                    Ok(count @ 1..) => words.nth(count - 1),
                    _ => word,
                },
            };
            if last.is_none() {
                return Err(self.lines.error(format!("the line ends before the property {}", property.name)));
            }
        }
        if words.next().is_some() {
            return Err(self.lines.error("the line has more numbers than the element has properties"));
        }
        Ok(parser.read_ascii_element(&text, kind))
    }

    fn ends_early(&self, kind: &ElementDef, number: usize) -> Error {
        let message = format!("the file ends before {} {number}, its header says {}", kind.name, kind.count);
        Error::in_file(self.path, message)
    }

    /// Whether anything follows the last element.
    fn has_more(&mut self) -> Result<bool, Error> {
        let rest = match self.encoding {
            Encoding::Ascii => self.lines.fill_buf().map(<[u8]>::is_empty),
            _ => self.lines.rest().fill_buf().map(<[u8]>::is_empty),
        };
        match rest {
            Ok(is_empty) => Ok(!is_empty),
            Err(error) => Err(self.lines.error(error)),
        }
    }
}

/// Vertices and triangles, in the order of the file.
#[derive(Default)]
struct Surface {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    texture_coordinates: Vec<Vec2>,
    triangles: Vec<[u32; 3]>,
    odd_polygons: OddPolygons,
}

impl Surface {
    fn add_vertex(&mut self, vertex: &Vertex, uses: &Uses) -> Result<(), String> {
        let values = &vertex.values;
        let mut reasons = values.iter().zip(Vertex::NAMES);
        if let Some((name, reason)) = reasons.find_map(|(&value, name)| Some((name, not_finite(value)?))) {
            return Err(format!("{name} {reason}"));
        }
        self.positions.push(Vec3::from_slice(values));
        if uses.normals {
            self.normals.push(Vec3::from_slice(&values[3..]));
        }
        if let Some(first) = uses.texture_coordinates {
            self.texture_coordinates.push(Vec2::from_slice(&values[first..]));
        }
        Ok(())
    }

    fn add_face(&mut self, Face { indices }: Face, place: &Place) -> Result<(), String> {
        if indices.len() < 3 {
            return Err(format!("a face needs 3 vertices, this one has {}", indices.len()));
        }
        if indices.len() > MAX_CORNERS {
            return Err(format!("{} corners, but at most {MAX_CORNERS} are possible", indices.len()));
        }
        let known = self.positions.len();
        let exists = |index: &&i64| usize::try_from(**index).is_ok_and(|index| index < known);
        if let Some(missing) = indices.iter().find(|index| !exists(index)) {
            return Err(format!("there is no vertex {missing}, the file has {known}"));
        }
        // The largest file holds fewer vertices than u32 counts.
        let corner = |number: usize| indices[number] as u32;
        if indices.len() == 3 {
            self.triangles.push([0, 1, 2].map(corner));
            return Ok(());
        }
        let corners: Vec<_> = indices.iter().map(|&index| self.positions[index as usize]).collect();
        let text = || format!("face {}, {} corners", place.number, indices.len());
        let triangles = self.odd_polygons.split(&corners, place.line, text);
        self.triangles.extend(triangles.into_iter().map(|triangle| triangle.map(corner)));
        Ok(())
    }
}

/// A vertex as the parser fills it. Properties that the file does not have are 0.
struct Vertex {
    values: [f32; 10],
}

impl Vertex {
    const NAMES: [&str; 10] = ["x", "y", "z", "nx", "ny", "nz", "s", "t", "u", "v"];
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self { values: [0.0; 10] }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let Some(number) = Self::NAMES.iter().position(|known| *known == name) else {
            return PropertyAccessResult::Ignored;
        };
        let Some(value) = property.to_f32_lossy() else { return PropertyAccessResult::Ignored };
        self.values[number] = value;
        PropertyAccessResult::Set
    }
}

/// A face as the parser fills it.
struct Face {
    indices: Vec<i64>,
}

impl Face {
    const NAMES: [&str; 2] = ["vertex_indices", "vertex_index"];
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self { indices: Vec::new() }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !Self::NAMES.contains(&name) {
            return PropertyAccessResult::Ignored;
        }
        self.indices = match property {
            Property::ListChar(indices) => widened(indices),
            Property::ListUChar(indices) => widened(indices),
            Property::ListShort(indices) => widened(indices),
            Property::ListUShort(indices) => widened(indices),
            Property::ListInt(indices) => widened(indices),
            Property::ListUInt(indices) => widened(indices),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

fn widened<T: Into<i64>>(indices: Vec<T>) -> Vec<i64> {
    indices.into_iter().map(T::into).collect()
}

/// An element of another kind.
struct Ignored;

impl PropertyAccess for Ignored {
    fn new() -> Self {
        Self
    }
}

/// Checks the lines of a header, and passes them on without comments. Passes the lines of a text on as they are.
#[derive(Default)]
struct PlyLines {
    after_header: bool,
    declarations: usize,
    elements: HashSet<Vec<u8>>,
    /// Those of the last element.
    properties: HashSet<Vec<u8>>,
}

impl LineChecker for PlyLines {
    const JOINS_LINES: bool = false;

    fn check(&mut self, line: &Line<'_>, checked: &mut Vec<u8>) -> Result<(), LineError> {
        if !self.after_header && self.is_comment(line)? || line.text.is_empty() {
            return Ok(());
        }
        checked.extend(line.text);
        checked.push(b'\n');
        Ok(())
    }
}

impl PlyLines {
    /// Checks a line of the header. Returns whether it is a comment.
    fn is_comment(&mut self, line: &Line<'_>) -> Result<bool, LineError> {
        let is_new = match line.keyword() {
            b"comment" | b"obj_info" => return Ok(true),
            b"end_header" => {
                self.after_header = true;
                true
            }
            b"element" => {
                self.declarations += 1;
                self.properties.clear();
                self.elements.insert(line.arguments().next().unwrap_or_default().to_vec())
            }
            b"property" => {
                self.declarations += 1;
                self.properties.insert(line.arguments().last().unwrap_or_default().to_vec())
            }
            _ => true,
        };
        if !is_new {
            return Err(line.error("declared twice"));
        }
        if line.text.len() > MAX_HEADER_LINE {
            return Err(line.error(&format!("a line of the header is longer than {MAX_HEADER_LINE} bytes")));
        }
        if self.declarations > MAX_DECLARATIONS {
            return Err(line.error(&format!("more than {MAX_DECLARATIONS} elements and properties")));
        }
        Ok(false)
    }
}
