//! Reserves a folder for a long study, so that a second one does not write into it.

use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use same_file::Handle;

use super::{CreatedFolders, create_folder, lock_writes, temporary_folder};
use crate::error::Error;

/// Folders that reservations have made and that may still be empty.
static MADE: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// A folder that nobody else can reserve while this value lives. If it is still empty then, it is removed, together
/// with parents that were made for it.
#[derive(Debug)]
pub struct ReservedFolder {
    path: PathBuf,
    /// Dropped before the lock.
    _created: CreatedFolders,
    /// The system unlocks it at the end of the process, whatever ends it. So no lock can be left over.
    _lock: Option<Handle>,
}

impl ReservedFolder {
    /// Makes the folder if it is missing, checks that files can be created in it, and locks it.
    ///
    /// # Errors
    /// If no file can be created there, or if the folder is reserved.
    pub(crate) fn new(path: &Path) -> Result<Self, Error> {
        let _held = lock_writes();
        loop {
            let created = create_folder(path)?;
            let lock = lock(path).map_err(Error::writing(path))?;
            temporary_folder(path).map_err(Error::writing(path))?;
            // Whoever reserved it before may have removed it meanwhile. Then this is the lock of a removed folder.
            if lock.as_ref().is_none_or(|lock| Handle::from_path(path).is_ok_and(|there| there == *lock)) {
                MADE.lock().unwrap_or_else(PoisonError::into_inner).extend_from_slice(&created.0);
                return Ok(Self { path: path.to_owned(), _created: created, _lock: lock });
            }
        }
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

/// Removes the folders that reservations have made and that are empty. For a program that exits without dropping them.
pub(super) fn remove_empty_folders() {
    drop(CreatedFolders(std::mem::take(&mut MADE.lock().unwrap_or_else(PoisonError::into_inner))));
}

/// Locks a folder. `None` where the system cannot lock one.
fn lock(folder: &Path) -> io::Result<Option<Handle>> {
    let Ok(file) = File::open(folder) else { return Ok(None) };
    match file.try_lock() {
        Ok(()) => Handle::from_file(file).map(Some),
        Err(fs::TryLockError::WouldBlock) => {
            Err(io::Error::new(ErrorKind::ResourceBusy, "another study is writing to this folder"))
        }
        Err(fs::TryLockError::Error(_)) => Ok(None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reserved_folder_is_locked_and_leaves_nothing_behind() {
        let directory = tempfile::tempdir().unwrap();
        let folder = directory.path().join("some/where");
        let reserved = ReservedFolder::new(&folder).unwrap();
        assert!(folder.is_dir() && reserved.path() == folder);
        if cfg!(unix) {
            let error = ReservedFolder::new(&folder).unwrap_err().to_string();
            let expected = format!("cannot write {}: another study is writing to this folder", folder.display());
            assert_eq!(error, expected);
        }
        drop(reserved);
        assert!(!directory.path().join("some").exists());
        // A folder that was there before, or that has got a file, stays.
        fs::create_dir_all(&folder).unwrap();
        drop(ReservedFolder::new(&folder).unwrap());
        assert!(folder.is_dir() && fs::read_dir(&folder).unwrap().next().is_none());
        let below = ReservedFolder::new(&folder.join("below")).unwrap();
        fs::write(below.path().join("file"), "").unwrap();
        drop(below);
        assert!(folder.join("below/file").exists());
        let error = ReservedFolder::new(&folder.join("below/file/deeper")).unwrap_err().to_string();
        assert!(error.starts_with("cannot create ") && error.contains("file/deeper"), "{error}");
    }
}
