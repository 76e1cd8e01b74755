//! Writes files completely or not at all, even if the program is interrupted.
//!
//! Content goes to a temporary file or folder first. It gets its final name only when everything is written. A lock is
//! held as long as something temporary exists. A program that wants to exit takes that lock ([`hold_writes`]); it then
//! leaves nothing temporary behind. [`input`] opens files to read, and [`reserve`] locks a folder.

mod input;
#[cfg(feature = "study")]
mod reserve;
#[cfg(test)]
mod tests;

use std::fs::{self, File, OpenOptions, Permissions};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

#[cfg(feature = "study")]
use tempfile::TempDir;
use tempfile::{NamedTempFile, TempPath};

pub(crate) use self::input::Input;
#[cfg(feature = "study")]
pub use self::reserve::ReservedFolder;
use crate::error::{Error, printable_path};

/// Names of temporary files and folders begin with this.
const TEMPORARY_PREFIX: &str = ".raylanes-";

/// Paths below these are files that some process holds open. Replacing such a file would not reach that process, even
/// if it is a regular file (`raylanes … -o /dev/stdout >> log`). So these are written directly.
const OPEN_FILES: [&str; 4] = ["/dev/stdout", "/dev/stderr", "/dev/fd", "/proc"];

/// Paths written so far. Locked while a temporary file or folder exists, but never while waiting for a device, a pipe
/// or standard output.
static WRITTEN: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Waits until no temporary file or folder exists, and prevents new ones while the returned guard lives.
///
/// For a program that is about to exit while it may be writing. The guard holds the paths written so far, in the order
/// of writing. Writes to devices, pipes and standard output are not stopped. Empty folders that were made for a study
/// are removed.
pub fn hold_writes() -> MutexGuard<'static, Vec<PathBuf>> {
    let written = lock_writes();
    #[cfg(feature = "study")]
    reserve::remove_empty_folders();
    written
}

fn lock_writes() -> MutexGuard<'static, Vec<PathBuf>> {
    // A thread that panicked while holding the lock has removed its temporary files.
    WRITTEN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Writes a file through a temporary file beside it, which replaces the old file when everything is written. A failure
/// leaves neither half a file nor a damaged old one.
///
/// A new file gets ordinary permissions; a replaced file keeps its own. Through a symbolic link, the file that it
/// points to is replaced. Devices, pipes and standard output cannot be replaced, so they are written directly.
///
/// This protects against errors, but not against a power failure: nothing waits for the disk.
///
/// Only one file is written at a time: the lock is held meanwhile. So `write` must not call this function.
///
/// # Errors
/// If the file cannot be created or written, including the last flush, or if `write` fails.
pub fn write_atomically(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), Error> {
    let written = Target::of(path).and_then(|target| match target {
        Target::Open(file) => {
            // Recorded before writing: part of it may arrive while the rest still waits.
            lock_writes().push(path.into());
            write_buffered(file, write)
        }
        Target::Replaceable(target) => {
            let mut written = lock_writes();
            target.stage(write)?.move_into_place()?;
            written.push(path.into());
            Ok(())
        }
    });
    written.map_err(Error::writing(path))
}

/// Writes several files, each like [`write_atomically`]. No file is replaced before all are written. Then they are
/// replaced in this order. `name` stands for all of them in the list of [`hold_writes`].
///
/// # Errors
/// If one of them cannot be created or written.
pub(crate) fn write_together<W>(name: &Path, files: impl IntoIterator<Item = (PathBuf, W)>) -> Result<(), Error>
where
    W: FnOnce(&mut dyn Write) -> io::Result<()>,
{
    let mut replaceable = Vec::new();
    for (path, write) in files {
        match Target::of(&path) {
            Ok(Target::Replaceable(target)) => replaceable.push((path, target, write)),
            Ok(Target::Open(file)) => write_buffered(file, write).map_err(Error::writing(&path))?,
            Err(error) => return Err(Error::writing(&path)(error)),
        }
    }
    let mut written = lock_writes();
    let mut staged = Vec::new();
    for (path, target, write) in replaceable {
        let file = target.stage(write).map_err(Error::writing(&path))?;
        staged.push((path, file));
    }
    for (path, file) in staged {
        file.move_into_place().map_err(Error::writing(&path))?;
    }
    written.push(name.into());
    Ok(())
}

/// Writes files into a new folder, through a temporary folder beside it. The new folder appears with all files or not
/// at all. Its parent folders are created if they are missing.
///
/// # Errors
/// If something with this name exists, unless it is an empty folder, or if something cannot be written.
#[cfg(feature = "study")]
pub(crate) fn write_new_folder(folder: &Path, files: &[(String, Vec<u8>)]) -> Result<(), Error> {
    let mut written = lock_writes();
    let parent = directory_of(folder);
    let _created = create_folder(parent)?;
    let temporary = temporary_folder(parent).map_err(Error::writing(folder))?;
    for (name, content) in files {
        fs::write(temporary.path().join(name), content).map_err(Error::writing(&folder.join(name)))?;
    }
    match fs::rename(temporary.path(), folder) {
        Err(_) if folder.symlink_metadata().is_ok() => {
            let kept = temporary.keep();
            let message = format!("it exists by now; the new files are in {}", printable_path(&kept));
            Err(Error::writing(folder)(io::Error::new(ErrorKind::AlreadyExists, message)))
        }
        renamed => {
            renamed.map_err(Error::writing(folder))?;
            written.push(folder.into());
            Ok(())
        }
    }
}

/// Checks, before long work, that [`write_atomically`] will be able to write this file, and that it is none that this
/// process has read. Changes nothing.
///
/// # Errors
/// If the file cannot be written, as far as that can be known, or if it was read.
pub fn check_output(path: &Path) -> Result<(), Error> {
    let check = || {
        if input::was_read(path) {
            return Err(io::Error::new(ErrorKind::InvalidInput, "it is also an input"));
        }
        // Opening a pipe would wait for its reader, and closing it again would be the end of the file for that reader.
        if fs::metadata(path).is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir()) {
            return Ok(());
        }
        match Target::of(path)? {
            Target::Open(_) => Ok(()),
            Target::Replaceable(target) => {
                let _held = lock_writes();
                target.create_temporary().map(drop)
            }
        }
    };
    check().map_err(Error::writing(path))
}

/// Folders that were created. When dropped, it removes those that are still empty.
#[cfg(feature = "study")]
#[derive(Debug)]
struct CreatedFolders(Vec<PathBuf>);

#[cfg(feature = "study")]
impl Drop for CreatedFolders {
    fn drop(&mut self) {
        // Innermost first. The system refuses to remove a folder that is not empty.
        self.0.iter().for_each(|folder| drop(fs::remove_dir(folder)));
    }
}

/// Creates a folder and its parents where they are missing.
#[cfg(feature = "study")]
fn create_folder(folder: &Path) -> Result<CreatedFolders, Error> {
    let missing = folder.ancestors().filter(|ancestor| !ancestor.exists());
    let created = CreatedFolders(missing.map(Path::to_owned).collect());
    fs::create_dir_all(folder).map_err(Error::creating(folder))?;
    Ok(created)
}

/// `tempfile` gives folders ordinary permissions, unlike files.
#[cfg(feature = "study")]
fn temporary_folder(parent: &Path) -> io::Result<TempDir> {
    // Only the kind of the error: the temporary name is of no use in a message.
    tempfile::Builder::new().prefix(TEMPORARY_PREFIX).tempdir_in(parent).map_err(|error| error.kind().into())
}

fn directory_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if parent != "" => parent,
        _ => Path::new("."),
    }
}

/// What is found at a path that is about to be written.
enum Target {
    /// A device, a pipe, or a file that a process holds open.
    Open(File),
    /// A regular file, or nothing yet.
    Replaceable(Replaceable),
}

impl Target {
    fn of(path: &Path) -> io::Result<Self> {
        // Opening for appending changes nothing, and the system checks whether the file may be written.
        match OpenOptions::new().append(true).open(path) {
            Ok(file) => {
                let metadata = file.metadata()?;
                if metadata.is_file() && !OPEN_FILES.iter().any(|open| path.starts_with(open)) {
                    let permissions = Some(metadata.permissions());
                    Ok(Self::Replaceable(Replaceable { destination: destination(path)?, permissions }))
                } else {
                    Ok(Self::Open(file))
                }
            }
            Err(error) if error.kind() == ErrorKind::NotFound => {
                Ok(Self::Replaceable(Replaceable { destination: destination(path)?, permissions: None }))
            }
            Err(error) => Err(error),
        }
    }
}

/// Follows symbolic links, also to a file that does not exist yet.
fn destination(path: &Path) -> io::Result<PathBuf> {
    match fs::canonicalize(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => match fs::read_link(path) {
            // This ends: a circle of links is another kind of error.
            Ok(target) => destination(&path.parent().unwrap_or(Path::new("")).join(target)),
            Err(_) => Ok(path.to_owned()),
        },
        resolved => resolved,
    }
}

struct Replaceable {
    destination: PathBuf,
    /// Permissions of the old file, if there is one.
    permissions: Option<Permissions>,
}

impl Replaceable {
    fn create_temporary(&self) -> io::Result<NamedTempFile> {
        let directory = directory_of(&self.destination);
        if !directory.is_dir() {
            let message = format!("there is no directory {}", printable_path(directory));
            return Err(io::Error::new(ErrorKind::NotFound, message));
        }
        // Opened here, since `tempfile` would make it readable by its owner only and name it in error messages.
        tempfile::Builder::new()
            .prefix(TEMPORARY_PREFIX)
            .make_in(directory, |name| OpenOptions::new().write(true).create_new(true).open(name))
    }

    fn stage(self, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<Staged> {
        let mut file = self.create_temporary()?;
        if let Some(permissions) = self.permissions {
            file.as_file().set_permissions(permissions)?;
        }
        write_buffered(file.as_file_mut(), write)?;
        Ok(Staged { file: file.into_temp_path(), destination: self.destination })
    }
}

/// A complete temporary file beside its destination. It is deleted unless it is moved there.
struct Staged {
    file: TempPath,
    destination: PathBuf,
}

impl Staged {
    fn move_into_place(self) -> io::Result<()> {
        self.file.persist(self.destination).map_err(|error| error.error)
    }
}

fn write_buffered(file: impl Write, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut buffered = BufWriter::new(file);
    write(&mut buffered)?;
    buffered.flush()
}
