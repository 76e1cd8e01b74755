//! The crate's error type: a file or an argument that cannot be used. Every error prints as one line.
//!
//! It depends on nothing else in the crate, so that every floor from `files` up can return it. Users know it as
//! `tracer::Error`.

use std::io;
use std::path::{Path, PathBuf};

/// A file or an argument that cannot be used. It always prints as one line: control characters are escaped, and text
/// quoted from a file is shortened.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system refused, or the disk is full.
    #[error("cannot {action} {}: {}", display(.file), escaped(&reason(.source)))]
    Io {
        /// `read`, `write` or `create`.
        action: &'static str,
        /// The file.
        file: PathBuf,
        /// The reason.
        source: io::Error,
    },
    /// The content of a file is not valid.
    #[error("{}{}: {}", display(.file), .line.map_or_else(String::new, |line| format!(":{line}")), escaped(.message))]
    Input {
        /// The file.
        file: PathBuf,
        /// The line, counted from 1, if it is known.
        line: Option<usize>,
        /// What was found, with the wrong value, and what was expected.
        message: String,
    },
    /// Two sets of hits must be identical and are not. This is a bug in this crate; comparing checksums found it.
    #[error("hits differ: {}", escaped(.0))]
    Disagreement(String),
    /// An argument is not valid.
    #[error("{}: {}", escaped(.argument), escaped(.message))]
    Argument {
        /// The argument, as it was given.
        argument: String,
        /// What is wrong with it, and what was expected.
        message: String,
    },
}

impl Error {
    /// Error of reading `file`, for `map_err`.
    pub(crate) fn reading(file: &Path) -> impl FnOnce(io::Error) -> Self {
        Self::io("read", file)
    }

    /// Error of writing `file`, for `map_err`.
    pub(crate) fn writing(file: &Path) -> impl FnOnce(io::Error) -> Self {
        Self::io("write", file)
    }

    /// Error of creating a folder, for `map_err`.
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

/// Quotes text of a file for a message: escaped, and shortened to about 60 characters.
pub(crate) fn quoted(text: &[u8]) -> String {
    const MAX_CHARS: usize = 60;
    // A line may have megabytes. A character has at most four bytes, so this many bytes are enough.
    let text = &text[..text.len().min(4 * (MAX_CHARS + 1))];
    let text = escaped(&String::from_utf8_lossy(text));
    match text.char_indices().nth(MAX_CHARS) {
        Some((end, _)) => format!("\"{}…\"", &text[..end]),
        None => format!("\"{text}\""),
    }
}

fn display(file: &Path) -> String {
    escaped(&file.to_string_lossy())
}

fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        // U+2028 and U+2029 are not control characters, but a terminal may break the line at them too.
        if c.is_control() || matches!(c, '\u{2028}' | '\u{2029}') {
            escaped.extend(c.escape_default());
        } else {
            escaped.push(c);
        }
    }
    escaped
}

/// The system's message without its error number, which adds nothing.
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
