//! STL files, binary and text. `stl_io` parses them.
//!
//! `stl_io` alone is not enough. It takes some binary files whose header begins with `solid` for text, and reads a line
//! of any length to find out. It names no line and no triangle in errors, accepts NaN in binary files, and reads only
//! the first solid of a text. So the format is decided here, and text is given to it one checked line at a time.
//!
//! A file is text if it begins with `solid`, in upper or lower case, and has no zero byte near its start. A text may
//! hold several solids; they become one mesh.
//!
//! Vertices with the same bits become one. Normals and attribute bytes of triangles, names and colours are not read.

use std::collections::HashMap;
use std::io::{self, BufRead, BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::path::Path;

use glam::Vec3;

use super::line::{Line, LineError, not_finite};
use super::mesh::{DEFAULT_COLOR, Mesh, Part};
use super::reader::{CheckedReader, LineChecker, MAX_BYTES};
use super::report::MeshReport;
use crate::error::Error;
use crate::files::Input;

/// Bytes before the first triangle of a binary file: a text, and the number of triangles.
const HEADER_BYTES: usize = 84;

/// Bytes of a triangle in a binary file.
const TRIANGLE_BYTES: u64 = 50;

/// Loads an STL file, binary or text. Triangles are in the order of the file.
///
/// Vertices with the same bits become one vertex. The normals of the file are not read.
///
/// # Errors
/// If the file cannot be read, ends early, holds a coordinate that is not finite, or has no triangles. The error names
/// the line of a text, or the triangle of a binary file, counted from 0.
pub fn load_stl(path: &Path) -> Result<(Mesh, MeshReport), Error> {
    let mut source = BufReader::new(Input::open(path, MAX_BYTES)?);
    let mut surface = Surface::default();
    let mut warnings = Vec::new();
    if is_text(source.fill_buf().map_err(Error::reading(path))?) {
        let mut lines = CheckedReader::new(path, source, StlLines)?;
        let parsed = surface.add_text(&mut lines);
        lines.finish(parsed)?;
    } else {
        surface.add_binary(path, &mut source)?;
        if !source.fill_buf().map_err(Error::reading(path))?.is_empty() {
            let message =
                format!("bytes after the last triangle, ignored: the header says {}", surface.triangles.len());
            warnings.push(Error::in_file(path, message).to_string());
        }
    }
    let Surface { positions, triangles, .. } = surface;
    let vertices = 3 * triangles.len();
    let mesh = Mesh::new(positions, triangles, vec![Part { first_triangle: 0, color: DEFAULT_COLOR }])
        .map_err(|error| Error::in_file(path, error.to_string()))?;
    let report = MeshReport { vertices, degenerate: mesh.degenerate_triangles(), ignored_elements: 0, warnings };
    Ok((mesh, report))
}

/// Whether a file that starts like this is a text.
fn is_text(start: &[u8]) -> bool {
    let first = start.trim_ascii_start().get(..5);
    first.is_some_and(|word| word.eq_ignore_ascii_case(b"solid")) && !start.contains(&0)
}

/// Triangles that share vertices with the same bits.
#[derive(Default)]
struct Surface {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    /// The number of each vertex, by its bits.
    numbers: HashMap<[u32; 3], u32>,
}

impl Surface {
    /// Adds the triangles of all solids of a text.
    fn add_text(&mut self, lines: &mut CheckedReader<'_, StlLines>) -> io::Result<()> {
        // stl_io stops at the end of a solid. Each line is read when it needs it, so the next solid is still there.
        while !lines.fill_buf()?.is_empty() {
            for triangle in stl_io::create_stl_reader(&mut Probed { answer: b"solid \n", source: lines })? {
                self.add(triangle?.vertices);
            }
        }
        Ok(())
    }

    /// Adds the triangles of a binary file.
    fn add_binary(&mut self, path: &Path, source: &mut impl Read) -> Result<(), Error> {
        let mut header = [0; HEADER_BYTES];
        source.read_exact(&mut header).map_err(|error| match error.kind() {
            ErrorKind::UnexpectedEof => {
                let message = "no STL file: a text begins with \"solid\", and a binary file has at least";
                Error::in_file(path, format!("{message} {HEADER_BYTES} bytes"))
            }
            _ => Error::reading(path)(error),
        })?;
        let count = u32::from_le_bytes(*header.last_chunk().expect("the header is longer"));
        let mut content = header.chain(source.take(TRIANGLE_BYTES * u64::from(count)));
        let mut probed = Probed { answer: b"\n", source: &mut content };
        let triangles = stl_io::create_stl_reader(&mut probed).map_err(Error::reading(path))?;
        for (number, triangle) in triangles.enumerate() {
            let vertices = triangle.map_err(|error| match error.kind() {
                ErrorKind::UnexpectedEof => {
                    Error::in_file(path, format!("the file ends in triangle {number}, its header says {count}"))
                }
                _ => Error::reading(path)(error),
            })?;
            let vertices = vertices.vertices;
            if let Some(reason) = vertices.iter().flat_map(|vertex| vertex.0).find_map(not_finite) {
                return Err(Error::in_file(path, format!("triangle {number}: vertex coordinate {reason}")));
            }
            self.add(vertices);
        }
        Ok(())
    }

    fn add(&mut self, vertices: [stl_io::Vertex; 3]) {
        let numbers = vertices.map(|vertex| {
            *self.numbers.entry(vertex.0.map(f32::to_bits)).or_insert_with(|| {
                self.positions.push(Vec3::from_array(vertex.0));
                // The largest file holds fewer vertices than u32 counts.
                self.positions.len() as u32 - 1
            })
        });
        self.triangles.push(numbers);
    }
}

/// What `stl_io` reads. It first reads a line to find out the format, and then seeks back to the start. Instead of the
/// file, it gets a line that gives the answer.
struct Probed<'a> {
    answer: &'static [u8],
    source: &'a mut dyn Read,
}

impl Read for Probed<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.answer.is_empty() { self.source.read(buffer) } else { self.answer.read(buffer) }
    }
}

impl Seek for Probed<'_> {
    fn seek(&mut self, _: SeekFrom) -> io::Result<u64> {
        self.answer = b"";
        Ok(0)
    }
}

/// Checks the vertices of a text, and passes all lines on in lower case, without names and normals.
struct StlLines;

impl LineChecker for StlLines {
    const JOINS_LINES: bool = false;

    fn check(&mut self, line: &Line<'_>, checked: &mut Vec<u8>) -> Result<(), LineError> {
        let text = line.text.to_ascii_lowercase();
        if text.is_empty() {
            return Ok(());
        }
        match line.keyword().to_ascii_lowercase().as_slice() {
            // stl_io wants a space also where there is no name.
            b"solid" => checked.extend(b"solid "),
            b"endsolid" => checked.extend(b"endsolid"),
            // Triangles without area often have the normal NaN, which stl_io refuses.
            b"facet" => checked.extend(b"facet normal 0 0 0"),
            b"vertex" => {
                for word in line.arguments() {
                    line.finite("vertex coordinate", word)?;
                }
                if line.arguments().count() != 3 {
                    return Err(line.error("a vertex needs 3 coordinates"));
                }
                checked.extend(text);
            }
            _ => checked.extend(text),
        }
        checked.push(b'\n');
        Ok(())
    }
}
