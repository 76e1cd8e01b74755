//! One line of a text file: its words, its numbers, and errors and warnings that name it.

use std::borrow::Cow;
use std::path::Path;

use crate::error::{Error, and_more, quoted};

/// A line, together with the lines that a backslash joins to it.
pub(super) struct Line<'a> {
    /// Number of the (first) line in the file, counted from 1.
    pub(super) number: usize,
    /// The text, without white space at both ends.
    pub(super) text: &'a [u8],
}

/// What is wrong with a line.
#[derive(Debug)]
pub(super) struct LineError {
    /// Number of the line, counted from 1.
    pub(super) line: usize,
    pub(super) message: String,
}

impl<'a> Line<'a> {
    /// The first word. Empty for an empty line or a comment.
    pub(super) fn keyword(&self) -> &'a [u8] {
        self.words().next().unwrap_or_default()
    }

    /// The words after the keyword, without a comment.
    pub(super) fn arguments(&self) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        self.words().skip(1)
    }

    /// Everything after the keyword, because a name may contain spaces and `#`.
    pub(super) fn name(&self) -> &'a [u8] {
        self.text.strip_prefix(self.keyword()).unwrap_or_default().trim_ascii()
    }

    /// Parses a finite number. `what` names the number in error messages.
    pub(super) fn finite(&self, what: &str, word: &[u8]) -> Result<f32, LineError> {
        let number = str::from_utf8(word).ok().and_then(|word| word.parse::<f32>().ok());
        let number = number.ok_or_else(|| self.error(&format!("{what} cannot be read")))?;
        match not_finite(number) {
            Some(reason) => Err(self.error(&format!("{what} {reason}"))),
            None => Ok(number),
        }
    }

    /// An error about this line. The message gets the text of the line.
    pub(super) fn error(&self, message: &str) -> LineError {
        LineError { line: self.number, message: format!("{message}: {}", quoted(self.text)) }
    }

    fn words(&self) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        let end = self.text.iter().position(|&byte| byte == b'#').unwrap_or(self.text.len());
        self.text[..end].split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
    }
}

/// What is wrong with a number that is not finite.
pub(super) fn not_finite(number: f32) -> Option<&'static str> {
    match number {
        _ if number.is_nan() => Some("is NaN"),
        _ if number.is_infinite() => Some("is infinite or too large"),
        _ => None,
    }
}

/// Decodes a name. Older programs write Latin-1, which is hardly ever valid UTF-8.
pub(super) fn decode(name: &[u8]) -> Cow<'_, str> {
    match str::from_utf8(name) {
        Ok(name) => Cow::Borrowed(name),
        Err(_) => Cow::Owned(name.iter().copied().map(char::from).collect()),
    }
}

/// Counts lines of one kind and keeps the first, so that a million of them give one warning.
#[derive(Debug, Default)]
pub(super) struct LineCount {
    count: usize,
    /// Its line, if there are lines, and its text.
    first: Option<(Option<usize>, String)>,
}

impl LineCount {
    pub(super) fn add(&mut self, line: &Line<'_>) {
        self.add_with(line.number, || quoted(line.text));
    }

    /// Like [`LineCount::add`], but the warning shows `text` instead of the line.
    pub(super) fn add_with(&mut self, line: impl Into<Option<usize>>, text: impl FnOnce() -> String) {
        self.count += 1;
        self.first.get_or_insert_with(|| (line.into(), text()));
    }

    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Adds the lines of a file that is named later.
    pub(super) fn followed_by(self, later: &Self) -> Self {
        Self { count: self.count + later.count, ..self }
    }

    /// The warning, or `None` if no line was counted.
    pub(super) fn warning(&self, file: &Path, message: &str) -> Option<String> {
        let (line, text) = self.first.as_ref()?;
        let message = format!("{message}: {text}{}", and_more(self.count - 1));
        Some(Error::Input { file: file.to_owned(), line: *line, message }.to_string())
    }
}
