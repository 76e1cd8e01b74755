//! Material libraries (MTL files). Only the diffuse colour of a material is used.

use std::collections::HashMap;
use std::io::{self, Write as _};
use std::path::Path;

use glam::Vec3;

use super::line::{Line, LineCount, LineError};
use super::reader::{CheckedReader, LineChecker};
use crate::error::{Error, quoted};

/// Colour of faces without a defined material: light grey.
pub(super) const DEFAULT_COLOR: Vec3 = Vec3::splat(0.8);

/// Name of a material or library, and the number of the line that uses it.
#[derive(Debug)]
pub(super) struct UsedName {
    pub(super) name: String,
    pub(super) line: usize,
}

/// Loads the libraries that the file `obj` names. Returns the colour of each material by name. If several libraries
/// define a material, the last one counts. A library that does not exist is a warning.
pub(super) fn load_libraries(
    obj: &Path,
    libraries: &[UsedName],
    warnings: &mut Vec<String>,
) -> Result<HashMap<String, Vec3>, Error> {
    let mut colors = HashMap::new();
    for UsedName { name, line } in libraries {
        if load_if_present(obj, name, &mut colors, warnings)? {
            continue;
        }
        // No file has this name. If there are spaces in it, they may separate several names.
        for word in name.split_whitespace() {
            if word == name || !load_if_present(obj, word, &mut colors, warnings)? {
                let message = format!("material library not found: {}", quoted(word.as_bytes()));
                warnings.push(Error::in_line(obj, *line, message).to_string());
            }
        }
    }
    Ok(colors)
}

/// Adds the colours of one library. Returns false if there is no such file beside the OBJ file.
fn load_if_present(
    obj: &Path,
    name: &str,
    colors: &mut HashMap<String, Vec3>,
    warnings: &mut Vec<String>,
) -> Result<bool, Error> {
    if name.is_empty() {
        return Ok(true);
    }
    let file = obj.with_file_name(name);
    let mut reader = match CheckedReader::open(&file, MtlLines::default()) {
        Err(Error::Io { source, .. }) if source.kind() == io::ErrorKind::NotFound => return Ok(false),
        reader => reader?,
    };
    let parsed = tobj::load_mtl_buf(&mut reader);
    let ((materials, numbers), lines) = reader.finish(parsed)?;
    for (name, number) in numbers {
        let color = materials[number].diffuse.map_or(DEFAULT_COLOR, Vec3::from_array);
        colors.insert(name, color);
    }
    warnings.extend(lines.clamped.warning(&file, "colour clamped to 0..1"));
    Ok(true)
}

/// Checks the lines of an MTL file and passes names and diffuse colours on.
#[derive(Debug, Default)]
struct MtlLines {
    has_material: bool,
    clamped: LineCount,
}

impl LineChecker for MtlLines {
    fn check(&mut self, line: &Line<'_>, checked: &mut Vec<u8>) -> Result<(), LineError> {
        match line.keyword() {
            b"newmtl" => {
                let name = line.name();
                if name.is_empty() {
                    return Err(line.error("a material needs a name"));
                }
                self.has_material = true;
                checked.extend(b"newmtl ");
                checked.extend(name.as_bytes());
                checked.push(b'\n');
                Ok(())
            }
            b"Kd" if !self.has_material => Err(line.error("colour comes before the first newmtl")),
            b"Kd" => {
                let [r, g, b] = self.color(line)?.to_array();
                writeln!(checked, "Kd {r} {g} {b}").expect("writing to a Vec never fails");
                Ok(())
            }
            _ => Ok(()),
        }
    }
}

impl MtlLines {
    /// The diffuse colour, clamped to the range from 0 to 1. Counts the lines that were clamped.
    fn color(&mut self, line: &Line<'_>) -> Result<Vec3, LineError> {
        let numbers: Vec<f32> = line.arguments().map(|word| line.finite("colour", word)).collect::<Result<_, _>>()?;
        let color = match *numbers {
            [grey] => Vec3::splat(grey),
            [r, g, b] => Vec3::new(r, g, b),
            _ => return Err(line.error("a colour needs 3 numbers, or 1 for a grey")),
        };
        let clamped = color.clamp(Vec3::ZERO, Vec3::ONE);
        if clamped != color {
            self.clamped.add(line);
        }
        Ok(clamped)
    }
}
