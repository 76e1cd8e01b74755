//! The folders that records are written to, and the name of a dated one.

use std::fs;
use std::io::ErrorKind;
use std::path::Path;
use std::time::SystemTime;

use super::date::{date, seconds_since_1970};
use crate::files::ReservedFolder;
use crate::tracer::Error;

/// Makes a folder and its parents if they do not exist.
///
/// # Errors
/// If the folder cannot be made.
pub fn make_folder(folder: &Path) -> Result<(), Error> {
    fs::create_dir_all(folder).map_err(Error::creating(folder))
}

/// Reserves a folder for a record: makes it, and checks that files can be written there, so that a long study does not
/// fail at its end.
///
/// # Errors
/// If the folder cannot be made or written to, or if another study writes to it.
pub fn reserve(folder: &Path) -> Result<ReservedFolder, Error> {
    ReservedFolder::new(folder)
}

/// Reserves the folder of a new record: `reports/<date>-<name>` in the current folder, with today's date in UTC.
///
/// # Errors
/// If it exists, because records are never edited, or if it could not be written to.
pub fn new_record(name: &str) -> Result<ReservedFolder, Error> {
    let folder = Path::new("reports").join(format!("{}-{name}", date(seconds_since_1970(SystemTime::now()))));
    check_untouched(&folder)?;
    let reserved = reserve(&folder)?;
    // Another study may have finished meanwhile.
    check_untouched(&folder)?;
    Ok(reserved)
}

/// Refuses anything but a missing or an empty folder. An empty one is reserved, or left over from a killed study.
fn check_untouched(folder: &Path) -> Result<(), Error> {
    let is_untouched = match folder.symlink_metadata() {
        Err(error) if error.kind() == ErrorKind::NotFound => true,
        Err(error) => return Err(Error::writing(folder)(error)),
        Ok(metadata) => metadata.is_dir() && fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_none()),
    };
    if is_untouched {
        return Ok(());
    }
    Err(Error::Argument {
        argument: folder.to_string_lossy().into_owned(),
        message: "it exists, and records are never edited: choose another name".into(),
    })
}
