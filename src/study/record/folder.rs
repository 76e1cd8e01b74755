//! The folders that records are written to.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::date::{date, seconds_since_1970};
use crate::files::try_folder;
use crate::tracer::Error;

/// Makes a folder to write into, if it is not there.
///
/// # Errors
/// If it cannot be made.
pub fn make_folder(folder: &Path) -> Result<(), Error> {
    std::fs::create_dir_all(folder).map_err(Error::creating(folder))
}

/// Whether [`write`](fn@crate::study::write) could write into a folder, as far as that can be told before. Nothing is left behind.
///
/// # Errors
/// If it cannot be made or written.
pub fn try_write(folder: &Path) -> Result<(), Error> {
    try_folder(folder)
}

/// The folder of a new record: `reports/<date>-<name>` below the current one, with today's date in UTC.
///
/// # Errors
/// If it exists, since records are never edited, or if it could not be written.
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
