//! Where in a file something is wrong: its line, and the key.

use std::ops::Range;
use std::path::Path;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::error::{Error, quoted};

/// What is wrong with the bytes `span` of a file.
#[derive(Debug)]
pub(super) struct Fault {
    pub(super) span: Range<usize>,
    pub(super) message: String,
}

impl From<toml::de::Error> for Fault {
    fn from(error: toml::de::Error) -> Self {
        Self { span: error.span().unwrap_or(0..0), message: error.message().to_owned() }
    }
}

impl Fault {
    /// The error to print: `file:line: key: message`, or, where the file is no TOML and so has no keys, `file:line: message:
    /// "the line"`.
    pub(super) fn in_file(self, file: &Path, text: &str) -> Error {
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

/// The innermost key that holds the byte at `place`, in itself or in its value, after all those that lead to it.
fn key_at(table: &DeTable<'_>, place: usize) -> Option<String> {
    table.iter().find_map(|(key, value)| {
        let name = key.get_ref();
        match within(value, place) {
            Some(inner) if inner.is_empty() => Some(name.to_string()),
            Some(inner) => Some(format!("{name}.{inner}")),
            None => key.span().contains(&place).then(|| name.to_string()),
        }
    })
}

/// The keys within a value that holds `place`. The items of an array have none of their own, but may each have a header.
fn within(value: &Spanned<DeValue<'_>>, place: usize) -> Option<String> {
    let inner = match value.get_ref() {
        DeValue::Table(table) => key_at(table, place),
        DeValue::Array(items) => items.iter().find_map(|item| within(item, place)),
        _ => None,
    };
    inner.or_else(|| value.span().contains(&place).then(String::new))
}

/// Messages of the parser quote the file, which may hold words of megabytes.
fn shortened(message: &str) -> String {
    const LONGEST: usize = 300;
    match message.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}…", &message[..end]),
        None => message.to_owned(),
    }
}
