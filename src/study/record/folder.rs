//! The folders that records are written to, and the name of a dated one.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::date::{date, seconds_since_1970};
use crate::files::try_folder;
use crate::tracer::Error;

/// Makes a folder and its parents if they do not exist.
///
/// # Errors
/// If the folder cannot be made.
pub fn make_folder(folder: &Path) -> Result<(), Error> {
    std::fs::create_dir_all(folder).map_err(Error::creating(folder))
}

/// Checks whether a record could be written into a folder, so that a long study does not fail at its end. Leaves
/// nothing behind.
///
/// # Errors
/// If the folder cannot be made or written to.
pub fn try_write(folder: &Path) -> Result<(), Error> {
    try_folder(folder)
}

/// The folder of a new record: `reports/<date>-<name>` in the current folder, with today's date in UTC. The folder is
/// not made yet.
///
/// # Errors
/// If it exists, because records are never edited, or if it could not be written to.
pub fn new_record(name: &str) -> Result<PathBuf, Error> {
    let folder = Path::new("reports").join(format!("{}-{name}", date(seconds_since_1970(SystemTime::now()))));
    match folder.symlink_metadata() {
        Err(error) if error.kind() == ErrorKind::NotFound => try_folder(&folder).map(|()| folder),
        Err(error) => Err(Error::writing(&folder)(error)),
        Ok(_) => Err(Error::Argument {
            argument: folder.display().to_string(),
            message: "it exists, and records are never edited: choose another name".into(),
        }),
    }
}
