//! Temporary files for tests of loaders, and random damage to their content.

use std::fs;
use std::path::PathBuf;

use tempfile::TempDir;

use raylanes::conformance::Random;

/// A directory for one test's files.
pub(crate) struct Files(TempDir);

impl Files {
    pub(crate) fn new() -> Self {
        Self(TempDir::new().unwrap())
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        fs::write(&path, content).unwrap();
        path
    }

    /// Removes the directory from a message, since it differs from run to run.
    pub(crate) fn shorten(&self, message: &str) -> String {
        message.replace(&format!("{}/", self.0.path().display()), "")
    }
}

/// Replaces, inserts, removes or repeats a few bytes at random. Inserts are taken from `pieces`.
pub(crate) fn mutate(text: &str, pieces: &[&str], random: &mut Random) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    for _ in 0..=random.below(4) {
        let start = random.below(bytes.len() + 1);
        let end = (start + random.below(6)).min(bytes.len());
        match random.below(4) {
            0 => drop(bytes.drain(start..end)),
            1 => drop(bytes.splice(start..start, pieces[random.below(pieces.len())].bytes())),
            2 => drop(bytes.splice(start..end, [random.below(256) as u8])),
            _ => {
                let copy = bytes[start..end].to_vec();
                let to = random.below(bytes.len() + 1);
                drop(bytes.splice(to..to, copy));
            }
        }
    }
    bytes
}

/// Whether a message is one line for a terminal, of less than 400 characters.
pub(crate) fn is_short_line(text: &str) -> bool {
    !text.contains(char::is_control) && text.chars().count() < 400
}
