//! Files that are read: opened with a limit on their size, and remembered, so that the program does not write over
//! them.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use same_file::is_same_file;

use crate::error::Error;

/// The regular files opened so far.
static READ: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// A file that is read, up to a limit.
#[derive(Debug)]
pub(crate) struct Input {
    file: File,
    /// The size, if it is a regular file.
    size: Option<u64>,
    max_bytes: u64,
    /// How many more bytes may be read.
    left: u64,
}

impl Input {
    /// Opens a file. A regular file that is longer than `max_bytes` is refused before it is read.
    ///
    /// # Errors
    /// If the file cannot be opened, or is longer.
    pub(crate) fn open(path: &Path, max_bytes: u64) -> Result<Self, Error> {
        let file = File::open(path).map_err(Error::reading(path))?;
        let metadata = file.metadata().map_err(Error::reading(path))?;
        let size = metadata.is_file().then_some(metadata.len());
        if size.is_some_and(|size| size > max_bytes) {
            return Err(Error::reading(path)(too_long(max_bytes)));
        }
        if let (Some(_), Ok(path)) = (size, std::path::absolute(path)) {
            READ.lock().unwrap_or_else(PoisonError::into_inner).insert(path);
        }
        Ok(Self { file, size, max_bytes, left: max_bytes })
    }

    /// The size in bytes. `None` for a device or a pipe, which may never end.
    pub(crate) fn size(&self) -> Option<u64> {
        self.size
    }
}

impl Read for Input {
    /// Fails when more than the limit has been read: a device has no size, and a file may grow.
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.file.read(buffer)?;
        self.left = self.left.checked_sub(read as u64).ok_or_else(|| too_long(self.max_bytes))?;
        Ok(read)
    }
}

fn too_long(max_bytes: u64) -> io::Error {
    io::Error::new(io::ErrorKind::FileTooLarge, format!("longer than {max_bytes} bytes"))
}

/// Whether the regular file at `path` was opened by [`Input::open`], under this name or another.
pub(super) fn was_read(path: &Path) -> bool {
    if !path.is_file() {
        return false;
    }
    // Files are compared as they are now: the number of a deleted file may be used again.
    let read = READ.lock().unwrap_or_else(PoisonError::into_inner);
    read.iter().any(|read| is_same_file(read, path).unwrap_or(false))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn a_longer_file_is_refused_before_it_is_read() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("long");
        // A hole: the file is longer than any disk that would be read in this test's time.
        File::create(&path).unwrap().set_len(1 << 42).unwrap();
        let error = Input::open(&path, 1 << 41).unwrap_err().to_string();
        assert_eq!(error, format!("cannot read {}: longer than {} bytes", path.display(), 1u64 << 41));
        assert_eq!(Input::open(&path, 1 << 42).unwrap().size(), Some(1 << 42));
    }

    #[test]
    fn exactly_the_limit_may_be_read() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("file");
        fs::write(&path, "12345").unwrap();
        let mut text = String::new();
        Input::open(&path, 5).unwrap().read_to_string(&mut text).unwrap();
        assert_eq!(text, "12345");
    }

    #[cfg(unix)]
    #[test]
    fn a_device_that_never_ends_is_refused_at_the_limit() {
        let mut input = Input::open(Path::new("/dev/zero"), 1 << 16).unwrap();
        assert_eq!(input.size(), None);
        let error = input.read_to_end(&mut Vec::new()).unwrap_err();
        assert_eq!(error.to_string(), "longer than 65536 bytes");
    }

    #[cfg(unix)]
    #[test]
    fn every_name_of_a_file_that_was_read_is_known() {
        let directory = tempfile::tempdir().unwrap();
        let [file, soft, hard, other] = ["file", "soft", "hard", "other"].map(|name| directory.path().join(name));
        fs::write(&file, "").unwrap();
        fs::write(&other, "").unwrap();
        std::os::unix::fs::symlink("file", &soft).unwrap();
        fs::hard_link(&file, &hard).unwrap();
        assert!(!was_read(&file));
        Input::open(&soft, 0).unwrap();
        assert!([&file, &soft, &hard].into_iter().all(|name| was_read(name)) && !was_read(&other));
        assert!(!was_read(&directory.path().join("missing")));
    }
}
