//! Errors in a scene file, with line and key.

use std::ops::Range;
use std::path::Path;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::error::{Error, quoted};

/// Why a scene file cannot be loaded.
pub(super) enum SceneError {
    /// Something in its text is not valid.
    InText(SpanError),
    /// Something else is wrong, for example with a mesh file that it names.
    Other(Error),
}

impl<E: Into<SpanError>> From<E> for SceneError {
    fn from(error: E) -> Self {
        Self::InText(error.into())
    }
}

impl SceneError {
    /// The error to print, for the scene file `file` with content `text`.
    pub(super) fn in_file(self, file: &Path, text: &str) -> Error {
        match self {
            Self::InText(error) => error.in_file(file, text),
            Self::Other(error) => error,
        }
    }
}

/// What is wrong with a range of bytes of a scene file.
#[derive(Debug)]
pub(super) struct SpanError {
    span: Range<usize>,
    message: String,
}

impl SpanError {
    pub(super) fn new(span: Range<usize>, message: impl Into<String>) -> Self {
        Self { span, message: message.into() }
    }

    /// An error of the parser. It has no place if a key has too many parts. Then this finds the line.
    pub(super) fn of_parser(error: &toml::de::Error, text: &str) -> Self {
        let span = error.span().unwrap_or_else(|| {
            let starts: Vec<_> =
                text.split_inclusive('\n').map(|line| line.as_ptr().addr() - text.as_ptr().addr()).collect();
            // The error is in the first line with which the file up to there has such an error.
            let has_it = |start: usize| {
                let end = text[start..].find('\n').map_or(text.len(), |length| start + length);
                DeTable::parse(&text[..end]).is_err_and(|error| error.span().is_none())
            };
            let start = starts.get(starts.partition_point(|&start| !has_it(start))).copied().unwrap_or(0);
            start..start
        });
        Self { span, message: error.message().to_owned() }
    }

    /// The error to print: `file:line: key: message`. A file that is not TOML has no keys; then it is
    /// `file:line: message: "the line"`.
    fn in_file(self, file: &Path, text: &str) -> Error {
        let start = self.span.start.min(text.len());
        let before = &text.as_bytes()[..start];
        let line = before.iter().filter(|&&byte| byte == b'\n').count() + 1;
        let message = shortened(&self.message);
        let message = match DeTable::parse(text) {
            Ok(table) => match key_at(table.get_ref(), start) {
                Some(key) => format!("{}: {message}", shortened(&key)),
                None => message,
            },
            Err(_) => {
                let text = text.lines().nth(line - 1).unwrap_or_default();
                format!("{message}: {}", quoted(text.trim().as_bytes()))
            }
        };
        Error::in_line(file, line, message)
    }
}

/// A name or path in quotes, for a message.
pub(super) fn quoted_name(name: impl AsRef<Path>) -> String {
    quoted(name.as_ref().to_string_lossy().as_bytes())
}

/// The path of keys to the innermost key whose text or value contains the byte at `offset`, such as `camera.eye`.
fn key_at(table: &DeTable<'_>, offset: usize) -> Option<String> {
    table.iter().find_map(|(key, value)| {
        let name = key.get_ref();
        match key_in_value(value, offset) {
            Some(inner) if inner.is_empty() => Some(name.to_string()),
            Some(inner) => Some(format!("{name}.{inner}")),
            None => key.span().contains(&offset).then(|| name.to_string()),
        }
    })
}

/// The path of keys inside a value, down to the byte at `offset`. It is empty if no inner key contains the byte, and
/// `None` if the value does not contain it. Items of an array have no keys of their own, but they can be tables.
fn key_in_value(value: &Spanned<DeValue<'_>>, offset: usize) -> Option<String> {
    let inner = match value.get_ref() {
        DeValue::Table(table) => key_at(table, offset),
        DeValue::Array(items) => items.iter().find_map(|item| key_in_value(item, offset)),
        _ => None,
    };
    inner.or_else(|| value.span().contains(&offset).then(String::new))
}

/// Messages of the parser quote the file, and a word of the file may be megabytes long.
fn shortened(message: &str) -> String {
    const MAX_CHARS: usize = 300;
    match message.char_indices().nth(MAX_CHARS) {
        Some((end, _)) => format!("{}…", &message[..end]),
        None => message.to_owned(),
    }
}
