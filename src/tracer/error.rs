//! What can go wrong with files and arguments, each told in one line.

use std::io;
use std::path::{Path, PathBuf};

/// A file or an argument that cannot be used. It prints as one line whatever the file held: control characters are
/// escaped, long text is shortened.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system refused, or the disk is full.
    #[error("cannot {action} {}: {}", shown(.file), escaped(&reason(.source)))]
    Io {
        /// `read`, `write` or `create`.
        action: &'static str,
        /// Which file.
        file: PathBuf,
        /// Why not.
        source: io::Error,
    },
    /// The content of a file makes no sense.
    #[error("{}{}: {}", shown(.file), .line.map_or_else(String::new, |line| format!(":{line}")), escaped(.message))]
    Input {
        /// Which file.
        file: PathBuf,
        /// In which of its lines, counted from 1, where that is known.
        line: Option<usize>,
        /// What is wrong, with the value at fault.
        message: String,
    },
    /// Hits that must be identical are not: a bug in this crate, found by comparing checksums.
    #[error("hits differ: {}", escaped(.0))]
    Disagreement(String),
    /// An argument that names no file makes no sense.
    #[error("{}: {}", escaped(.argument), escaped(.message))]
    Argument {
        /// As it was given.
        argument: String,
        /// What is wrong with it, and what would be right.
        message: String,
    },
}

impl Error {
    /// For `map_err` after trying to read `file`.
    pub(crate) fn reading(file: &Path) -> impl FnOnce(io::Error) -> Self {
        Self::io("read", file)
    }

    /// For `map_err` after trying to write `file`.
    pub(crate) fn writing(file: &Path) -> impl FnOnce(io::Error) -> Self {
        Self::io("write", file)
    }

    /// For `map_err` after trying to make a folder.
    #[cfg(feature = "study")]
    pub(crate) fn creating(folder: &Path) -> impl FnOnce(io::Error) -> Self {
        Self::io("create", folder)
    }

    /// An [`Error::Input`] about the file as a whole.
    pub(crate) fn in_file(file: &Path, message: impl Into<String>) -> Self {
        Self::Input { file: file.to_owned(), line: None, message: message.into() }
    }

    /// An [`Error::Input`] about one line.
    pub(crate) fn in_line(file: &Path, line: usize, message: impl Into<String>) -> Self {
        Self::Input { file: file.to_owned(), line: Some(line), message: message.into() }
    }

    fn io(action: &'static str, file: &Path) -> impl FnOnce(io::Error) -> Self {
        let file = file.to_owned();
        move |source| Self::Io { action, file, source }
    }
}

/// Text of a file in quotes, for a message: escaped and shortened to about 60 characters.
pub(crate) fn quoted(text: &[u8]) -> String {
    const LONGEST: usize = 60;
    // A character has at most four bytes, so this much is enough; the rest of a line of megabytes is not looked at.
    let text = &text[..text.len().min(4 * (LONGEST + 1))];
    let text = escaped(&String::from_utf8_lossy(text));
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("\"{}…\"", &text[..end]),
        None => format!("\"{text}\""),
    }
}

fn shown(file: &Path) -> String {
    escaped(&file.to_string_lossy())
}

fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        // Not all are control characters by name, but a terminal may break the line at any of them.
        if c.is_control() || matches!(c, '\u{2028}' | '\u{2029}') {
            escaped.extend(c.escape_default());
        } else {
            escaped.push(c);
        }
    }
    escaped
}

/// The system's words without its error number, which says nothing more.
fn reason(error: &io::Error) -> String {
    let text = error.to_string();
    match error.raw_os_error().and_then(|code| text.strip_suffix(&format!(" (os error {code})"))) {
        Some(words) => words.to_owned(),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_name_file_line_and_value() {
        let file = Path::new("bunny.obj");
        let message = format!("vertex coordinate is NaN: {}", quoted(b"v 1 nan 3"));
        assert_eq!(
            Error::in_line(file, 12, message).to_string(),
            "bunny.obj:12: vertex coordinate is NaN: \"v 1 nan 3\""
        );
        assert_eq!(Error::in_file(file, "no triangles").to_string(), "bunny.obj: no triangles");
        let missing = Error::reading(Path::new("x.obj"))(io::Error::from_raw_os_error(2)).to_string();
        assert!(missing.starts_with("cannot read x.obj: ") && !missing.contains("os error"), "{missing}");
    }

    #[test]
    fn errors_stay_on_one_short_line() {
        let hostile = "a\nb\r\u{1b}[2J\u{85}\u{2028}";
        let file = Path::new(hostile);
        let errors = [
            Error::in_line(file, 1, hostile),
            Error::writing(file)(io::Error::other(hostile)),
            Error::Argument { argument: hostile.into(), message: hostile.into() },
        ];
        for error in errors {
            let text = error.to_string();
            assert!(!text.contains(['\n', '\r', '\u{1b}', '\u{85}', '\u{2028}']), "{text:?}");
            assert!(text.contains(r"a\nb\r\u{1b}"), "{text:?}");
        }
        assert_eq!(quoted(&[b'x'; 60]).chars().count(), 62);
        assert_eq!(quoted(&[b'x'; 61]).chars().count(), 63);
        assert_eq!(quoted(&[b'\n'; 1_000_000]).chars().count(), 63);
        assert_eq!(quoted(&[0xff, b'a']), "\"\u{fffd}a\"");
    }
}
