//! Material libraries (MTL files): of all their properties, the diffuse colour.

use std::collections::HashMap;
use std::io::{self, Write as _};
use std::path::Path;

use glam::Vec3;

use super::feed::{Check, Fault, Feed, Line, LineCount};
use crate::error::{Error, quoted};

/// Colour of faces without a material: light grey.
pub(super) const DEFAULT_COLOR: Vec3 = Vec3::splat(0.8);

/// A name, and the line that uses it.
#[derive(Debug)]
pub(super) struct Named {
    pub(super) name: String,
    pub(super) line: usize,
}

/// The colours of all materials in the libraries that `obj` names, by material. A library that does not exist is a
/// warning; where several define a material, the last one counts.
pub(super) fn load_libraries(
    obj: &Path,
    libraries: &[Named],
    warnings: &mut Vec<String>,
) -> Result<HashMap<String, Vec3>, Error> {
    let mut colors = HashMap::new();
    for Named { name, line } in libraries {
        if load_if_present(obj, name, &mut colors, warnings)? {
            continue;
        }
        // Not one name with spaces, so perhaps several names.
        for word in name.split_whitespace() {
            if word == name || !load_if_present(obj, word, &mut colors, warnings)? {
                let message = format!("material library not found: {}", quoted(word.as_bytes()));
                warnings.push(Error::in_line(obj, *line, message).to_string());
            }
        }
    }
    Ok(colors)
}

/// Adds the colours of one library, or returns false if there is no such file beside the OBJ file.
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
    let mut feed = match Feed::open(&file, MtlLines::default()) {
        Err(Error::Io { source, .. }) if source.kind() == io::ErrorKind::NotFound => return Ok(false),
        feed => feed?,
    };
    let parsed = tobj::load_mtl_buf(&mut feed);
    let ((materials, numbers), lines) = feed.finish(parsed)?;
    for (name, number) in numbers {
        let color = materials[number].diffuse.map_or(DEFAULT_COLOR, Vec3::from_array);
        colors.insert(name, color);
    }
    warnings.extend(lines.clamped.warning(&file, "colour clamped to 0..1"));
    Ok(true)
}

/// Checks the lines of an MTL file, and lets names and diffuse colours through.
#[derive(Debug, Default)]
struct MtlLines {
    has_material: bool,
    clamped: LineCount,
}

impl Check for MtlLines {
    fn line(&mut self, line: &Line<'_>, checked: &mut Vec<u8>) -> Result<(), Fault> {
        match line.keyword() {
            b"newmtl" => {
                let name = line.name();
                if name.is_empty() {
                    return Err(line.fault("a material needs a name"));
                }
                self.has_material = true;
                checked.extend(b"newmtl ");
                checked.extend(name.as_bytes());
                checked.push(b'\n');
                Ok(())
            }
            b"Kd" if !self.has_material => Err(line.fault("colour comes before the first newmtl")),
            b"Kd" => {
                let [r, g, b] = self.color(line)?.to_array();
                writeln!(checked, "Kd {r} {g} {b}").expect("a Vec takes everything");
                Ok(())
            }
            _ => Ok(()),
        }
    }
}

impl MtlLines {
    fn color(&mut self, line: &Line<'_>) -> Result<Vec3, Fault> {
        let numbers: Vec<f32> = line.arguments().map(|word| line.finite("colour", word)).collect::<Result<_, _>>()?;
        let color = match *numbers {
            [grey] => Vec3::splat(grey),
            [r, g, b] => Vec3::new(r, g, b),
            _ => return Err(line.fault("a colour needs 3 numbers, or 1 for a grey")),
        };
        let clamped = color.clamp(Vec3::ZERO, Vec3::ONE);
        if clamped != color {
            self.clamped.note(line);
        }
        Ok(clamped)
    }
}
