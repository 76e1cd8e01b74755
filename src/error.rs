//! The crate's error type: a file or an argument that cannot be used. Every error prints as one line.
//!
//! It depends on nothing else in the crate, so that every floor from `files` up can return it. Users know it as
//! `tracer::Error`.

use std::io;
use std::path::{Path, PathBuf};

/// A file or an argument that cannot be used. It always prints as one line: names and text quoted from a file are
/// shortened, and characters that a terminal does not show as they are, are escaped.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system refused, or the disk is full.
    #[error("cannot {action} {}: {}", printable_path(.file), explanation(&reason(.source)))]
    Io {
        /// `read`, `write`, `create`, `start` or `find`.
        action: &'static str,
        /// The file.
        file: PathBuf,
        /// The reason.
        source: io::Error,
    },
    /// The content of a file is not valid.
    #[error("{}{}: {}", printable_path(.file), line_suffix(*.line), explanation(.message))]
    Input {
        /// The file.
        file: PathBuf,
        /// The line, counted from 1, if it is known.
        line: Option<usize>,
        /// What was found, with the wrong value, and what was expected.
        message: String,
    },
    /// Two sets of hits must be identical and are not. This is a bug in this crate; comparing checksums found it.
    #[error("hits differ: {}", explanation(.0))]
    Disagreement(String),
    /// An argument is not valid.
    #[error("{}: {}", printable(.argument), explanation(.message))]
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

/// A name for a message, a table or a page: escaped, and if it is long, shortened in the middle.
pub fn printable(name: &str) -> String {
    const MAX_CHARS: usize = 120;
    shortened_to(MAX_CHARS, &escaped(name))
}

/// A path for a message; see [`printable`].
pub fn printable_path(path: &Path) -> String {
    printable(&path.to_string_lossy())
}

/// Says how many things of a kind there are beside the one that is named.
pub(crate) fn and_more(others: usize) -> String {
    if others > 0 { format!(" (and {others} more)") } else { String::new() }
}

fn line_suffix(line: Option<usize>) -> String {
    line.map_or_else(String::new, |line| format!(":{line}"))
}

/// The names in a message are short already; this keeps any other text from filling the terminal.
fn explanation(text: &str) -> String {
    const MAX_CHARS: usize = 600;
    shortened_to(MAX_CHARS, &escaped(text))
}

/// Replaces the middle of a longer text by an ellipsis.
fn shortened_to(max_chars: usize, text: &str) -> String {
    let chars = text.chars().count();
    if chars <= max_chars {
        return text.to_owned();
    }
    let start: String = text.chars().take(max_chars / 2).collect();
    let end: String = text.chars().skip(chars - (max_chars - max_chars / 2 - 1)).collect();
    format!("{start}…{end}")
}

fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        if is_shown(c) {
            escaped.push(c);
        } else {
            escaped.extend(c.escape_default());
        }
    }
    escaped
}

/// Whether a terminal shows a character as it is. Control characters and separators break the line or move the cursor,
/// bidirectional controls reorder the text around them, and others are invisible.
fn is_shown(c: char) -> bool {
    let separator = '\u{2028}'..='\u{2029}';
    let bidirectional =
        ['\u{202a}'..='\u{202e}', '\u{2066}'..='\u{2069}', '\u{200e}'..='\u{200f}', '\u{61c}'..='\u{61c}'];
    let invisible = [
        '\u{ad}'..='\u{ad}',
        '\u{180e}'..='\u{180e}',
        '\u{200b}'..='\u{200d}',
        '\u{2060}'..='\u{2064}',
        '\u{206a}'..='\u{206f}',
        '\u{feff}'..='\u{feff}',
        '\u{fff9}'..='\u{fffb}',
        '\u{e0000}'..='\u{e007f}',
    ];
    let mut hidden = [separator].into_iter().chain(bidirectional).chain(invisible);
    !c.is_control() && !hidden.any(|range| range.contains(&c))
}

/// The system's message without its error number, which adds nothing.
pub(crate) fn reason(error: &dyn std::error::Error) -> String {
    let text = error.to_string();
    match text.strip_suffix(')').and_then(|text| text.rsplit_once(" (os error ")) {
        Some((words, number)) if number.parse::<i32>().is_ok() => words.to_owned(),
        _ => text,
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
        let hostile = "a\nb\r\u{1b}[2J\u{85}\u{2028}\u{202e}\u{2066}\u{200f}\u{61c}\u{200b}\u{feff}";
        let file = Path::new(hostile);
        let errors = [
            Error::in_line(file, 1, hostile),
            Error::writing(file)(io::Error::other(hostile)),
            Error::Argument { argument: hostile.into(), message: hostile.into() },
        ];
        for error in errors {
            let text = error.to_string();
            assert!(text.chars().all(is_shown), "{text:?}");
            assert!(text.contains(r"a\nb\r\u{1b}"), "{text:?}");
        }
        assert_eq!(quoted(&[b'x'; 60]).chars().count(), 62);
        assert_eq!(quoted(&[b'x'; 61]).chars().count(), 63);
        assert_eq!(quoted(&[b'\n'; 1_000_000]).chars().count(), 63);
        assert_eq!(quoted(&[0xff, b'a']), "\"\u{fffd}a\"");
    }

    #[test]
    fn a_long_name_keeps_its_start_and_its_end() {
        let long = format!("start{}end.obj", "x".repeat(1000));
        assert_eq!(printable(&long), format!("start{}…{}end.obj", "x".repeat(55), "x".repeat(52)));
        assert_eq!(printable(&long[..120]), &long[..120]);
        let errors = [
            Error::in_file(Path::new(&long), "no triangles"),
            Error::in_file(Path::new("a.obj"), long.repeat(10)),
            Error::writing(Path::new(&long))(io::Error::other(long.repeat(10))),
            Error::Argument { argument: long.clone(), message: long.repeat(10) },
        ];
        for error in errors {
            assert!(error.to_string().chars().count() < 800, "{error}");
        }
    }
}
