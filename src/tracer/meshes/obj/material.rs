//! Material libraries (MTL files). Only the diffuse colour of a material is used.

use std::cmp::Reverse;
use std::collections::HashMap;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use glam::Vec3;

use crate::error::{Error, quoted};
use crate::tracer::meshes::line::{Line, LineCount, LineError, decode};
use crate::tracer::meshes::mesh::DEFAULT_COLOR;
use crate::tracer::meshes::reader::{CheckedReader, LineChecker};

/// The libraries that a file names, in order. Some exporters name them again for every object.
#[derive(Debug, Default)]
pub(super) struct UsedLibraries {
    libraries: Vec<UsedLibrary>,
    /// The place of each name in `libraries`.
    places: HashMap<Vec<u8>, usize>,
    /// Number of lines that name libraries.
    lines: usize,
}

/// The rest of a line after `mtllib`: one name, or several.
#[derive(Debug)]
struct UsedLibrary {
    name: Vec<u8>,
    /// The first line with this text.
    line: usize,
    /// How many lines that name libraries come before the last one with this text.
    last: usize,
}

impl UsedLibraries {
    pub(super) fn add(&mut self, line: &Line<'_>) {
        let name = line.name();
        if name.is_empty() {
            return;
        }
        let place = *self.places.entry(name.to_owned()).or_insert_with(|| {
            self.libraries.push(UsedLibrary { name: name.to_owned(), line: line.number, last: 0 });
            self.libraries.len() - 1
        });
        self.libraries[place].last = self.lines;
        self.lines += 1;
    }

    /// Reads the libraries, which are beside the file `obj`. Returns the colour of each material by name. If several
    /// libraries define a material, the one that is named last counts. Libraries that do not exist are a warning.
    pub(super) fn load(&self, obj: &Path, warnings: &mut Vec<String>) -> Result<HashMap<String, Vec3>, Error> {
        let mut loader = Loader::default();
        // Last to first, so that each library is read only once.
        let mut last_first: Vec<_> = self.libraries.iter().collect();
        last_first.sort_unstable_by_key(|library| Reverse(library.last));
        for UsedLibrary { name, .. } in last_first {
            // If no file has this name, spaces in it may separate several names.
            if !loader.load(obj, name)? {
                words(name).rev().try_for_each(|word| loader.load(obj, word).map(drop))?;
            }
        }

        let mut missing = LineCount::default();
        for UsedLibrary { name, line, .. } in &self.libraries {
            if loader.exists.get(name) != Some(&true) {
                // Removed, so that it is counted once.
                let is_missing = |word: &&[u8]| loader.exists.remove(*word) == Some(false);
                words(name)
                    .filter(is_missing)
                    .for_each(|word| missing.add_with(*line, || quoted(decode(word).as_bytes())));
            }
        }
        warnings.extend(missing.warning(obj, "material library not found"));
        warnings.extend(loader.clamped.warning(&loader.clamped_in, "colour clamped to 0..1"));
        Ok(loader.colors)
    }
}

fn words(name: &[u8]) -> impl DoubleEndedIterator<Item = &[u8]> {
    name.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

/// Reads each library once.
#[derive(Default)]
struct Loader {
    /// Whether the names that were tried are those of files.
    exists: HashMap<Vec<u8>, bool>,
    colors: HashMap<String, Vec3>,
    /// Colours that were clamped, in all libraries.
    clamped: LineCount,
    /// The library of the first of them.
    clamped_in: PathBuf,
}

impl Loader {
    /// Adds the colours of one library, unless a library that was read before defines them. Returns false if there is
    /// no such file.
    fn load(&mut self, obj: &Path, name: &[u8]) -> Result<bool, Error> {
        if let Some(&exists) = self.exists.get(name) {
            return Ok(exists);
        }
        let mut exists = false;
        for file in library_paths(obj, name) {
            exists = self.load_file(&file)?;
            if exists {
                break;
            }
        }
        self.exists.insert(name.to_owned(), exists);
        Ok(exists)
    }

    fn load_file(&mut self, file: &Path) -> Result<bool, Error> {
        let mut reader = match CheckedReader::open(file, MtlLines::default()) {
            Err(Error::Io { source, .. }) if is_missing(source.kind()) => return Ok(false),
            reader => reader?,
        };
        let parsed = tobj::load_mtl_buf(&mut reader);
        let ((materials, numbers), lines) = reader.finish(parsed)?;
        for (name, number) in numbers {
            let color = materials[number].diffuse.map_or(DEFAULT_COLOR, Vec3::from_array);
            self.colors.entry(name).or_insert(color);
        }
        if lines.clamped.count() > 0 {
            self.clamped = lines.clamped.followed_by(&self.clamped);
            self.clamped_in = file.to_owned();
        }
        Ok(true)
    }
}

/// Where a library may be: first exactly the bytes of its name, because not every system has names in UTF-8.
fn library_paths(obj: &Path, name: &[u8]) -> impl Iterator<Item = PathBuf> {
    #[cfg(unix)]
    let exact = Some(obj.with_file_name(<std::ffi::OsStr as std::os::unix::ffi::OsStrExt>::from_bytes(name)));
    #[cfg(not(unix))]
    let exact = None;
    let decoded = decode(name);
    // Programs on Windows write backslashes between folders.
    let [decoded, with_slashes] = [obj.with_file_name(&*decoded), obj.with_file_name(decoded.replace('\\', "/"))];
    exact.into_iter().chain([decoded, with_slashes])
}

/// Also if no file can have this name: it is too long, or holds a zero. A line with several names may be both.
fn is_missing(kind: io::ErrorKind) -> bool {
    matches!(kind, io::ErrorKind::NotFound | io::ErrorKind::InvalidFilename | io::ErrorKind::InvalidInput)
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
                let name = decode(line.name());
                let name = name.trim();
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
        if clamped == color {
            // With the signs of its zeros.
            return Ok(color);
        }
        self.clamped.add(line);
        Ok(clamped)
    }
}
