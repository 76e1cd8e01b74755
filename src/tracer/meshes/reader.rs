//! A reader that gives a parser one checked line at a time, so that errors can name the line.

use std::fmt::Display;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

use super::line::{Line, LineError};
use crate::error::{Error, quoted};
use crate::files::Input;

/// Largest size in bytes of a file. A pipe or a device may never end.
pub(super) const MAX_BYTES: u64 = 1 << 33;

/// Largest length in bytes of a line, with the lines joined to it. It bounds the memory that a binary file can take. A
/// face with a million vertices fits.
const MAX_LINE_BYTES: usize = 1 << 24;

/// Some editors put this at the start of a file, and joining files puts it at the start of other lines. It would make
/// the keyword an unknown one.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

const FORM_FEED: u8 = b'\x0c';
const VERTICAL_TAB: u8 = b'\x0b';

/// Checks every line of a file before the parser reads it.
pub(super) trait LineChecker {
    /// Whether a backslash at the end of a line joins it with the next one.
    const JOINS_LINES: bool = true;

    /// Checks a line and appends to `checked` what the parser shall read: nothing, or one line with its line break.
    ///
    /// # Errors
    /// What is wrong with the line.
    fn check(&mut self, line: &Line<'_>, checked: &mut Vec<u8>) -> Result<(), LineError>;

    /// Checks at the end of the file what depends on the whole file.
    ///
    /// # Errors
    /// What is wrong, and with which line.
    fn check_end(&mut self) -> Result<(), LineError> {
        Ok(())
    }
}

/// A file as the parser reads it: only checked lines. The next line is read when the parser has used up the current
/// one. So an error, here or in the parser, always belongs to the current line.
pub(super) struct CheckedReader<'a, C> {
    file: &'a Path,
    source: BufReader<Input>,
    checker: C,
    /// Number of the next line in the file, counted from 1.
    next_number: usize,
    /// Number of the current line. It is the first one of lines that a backslash joins.
    number: usize,
    /// Text of the current line.
    text: Vec<u8>,
    /// What the parser reads of the current line.
    checked: Vec<u8>,
    /// How many bytes of `checked` the parser has read.
    consumed: usize,
    /// Why the reader stopped. The parser only learns that it stopped.
    failure: Option<Error>,
}

impl<'a, C: LineChecker> CheckedReader<'a, C> {
    pub(super) fn open(file: &'a Path, checker: C) -> Result<Self, Error> {
        Self::new(file, BufReader::new(Input::open(file, MAX_BYTES)?), checker)
    }

    /// Reads an open file.
    pub(super) fn new(file: &'a Path, mut source: BufReader<Input>, checker: C) -> Result<Self, Error> {
        if let Some(encoding) = wide_encoding(source.fill_buf().map_err(Error::reading(file))?) {
            let message = format!("the text is {encoding}, expected UTF-8; iconv -f {encoding} -t UTF-8 converts it");
            return Err(Error::in_line(file, 1, message));
        }
        let (text, checked) = (Vec::new(), Vec::new());
        Ok(Self { file, source, checker, next_number: 1, number: 0, text, checked, consumed: 0, failure: None })
    }

    /// Ends the reading. `parsed` is what the parser returned.
    ///
    /// # Errors
    /// The error of the reader, the checker or the parser, with its line.
    pub(super) fn finish<T>(mut self, parsed: Result<T, impl Display>) -> Result<(T, C), Error> {
        match (self.failure.take(), parsed) {
            (Some(failure), _) => Err(failure),
            (None, Err(error)) => Err(self.error(error)),
            (None, Ok(parsed)) => Ok((parsed, self.checker)),
        }
    }

    /// The error of the reader or the checker, or else `message` about the current line, or about the file at its end.
    pub(super) fn error(&mut self, message: impl Display) -> Error {
        self.failure.take().unwrap_or_else(|| match &self.text[..] {
            [] => Error::in_file(self.file, message.to_string()),
            text => Error::in_line(self.file, self.number, format!("{message}: {}", quoted(text))),
        })
    }

    /// Number of the current line.
    pub(super) fn line(&self) -> usize {
        self.number
    }

    /// What follows the current line.
    pub(super) fn rest(&mut self) -> &mut BufReader<Input> {
        &mut self.source
    }

    /// Reads and checks lines until there is something for the parser, or the file ends.
    fn refill(&mut self) -> Result<(), Error> {
        self.checked.clear();
        self.consumed = 0;
        while self.checked.is_empty() {
            let checked = if self.next_line()? {
                let line = Line { number: self.number, text: self.text.trim_ascii() };
                self.checker.check(&line, &mut self.checked)
            } else {
                return self.checker.check_end().map_err(|error| self.in_file(error));
            };
            checked.map_err(|error| self.in_file(error))?;
        }
        Ok(())
    }

    /// Reads a line and the lines joined to it. Returns false at the end of the file.
    fn next_line(&mut self) -> Result<bool, Error> {
        self.text.clear();
        self.number = self.next_number;
        let mut is_line = false;
        loop {
            let start = self.text.len();
            let Some(line_break) = self.read_to_line_break()? else { return Ok(is_line) };
            is_line = true;
            // The other two break a line too, so that a comment does not swallow what follows. But they do not count:
            // editors show one line.
            if !matches!(line_break, FORM_FEED | VERTICAL_TAB) {
                self.next_number += 1;
            }
            if start == 0 && self.text.starts_with(BYTE_ORDER_MARK) {
                self.text.drain(..BYTE_ORDER_MARK.len());
            }
            let end = start + self.text[start..].trim_ascii_end().len();
            self.text.truncate(end);
            if !C::JOINS_LINES || !joins_next_line(&self.text[start..]) {
                return Ok(true);
            }
            self.text.truncate(end - 1);
            self.text.push(b' ');
        }
    }

    /// Appends the text up to the next line break to the current line. Returns the line break, or `None` if nothing is
    /// left. The file need not end with a line break.
    fn read_to_line_break(&mut self) -> Result<Option<u8>, Error> {
        let mut found_text = false;
        loop {
            let buffer = self.source.fill_buf().map_err(Error::reading(self.file))?;
            if buffer.is_empty() {
                return Ok(found_text.then_some(b'\n'));
            }
            found_text = true;
            let line_break = buffer.iter().position(|byte| matches!(byte, b'\n' | b'\r' | &FORM_FEED | &VERTICAL_TAB));
            let text = &buffer[..line_break.unwrap_or(buffer.len())];
            if self.text.len() + text.len() > MAX_LINE_BYTES {
                self.text.extend(text);
                let message = format!("line is longer than {MAX_LINE_BYTES} bytes: {}", quoted(&self.text));
                return Err(Error::in_line(self.file, self.number, message));
            }
            self.text.extend(text);
            let Some(end) = line_break else {
                let read = buffer.len();
                self.source.consume(read);
                continue;
            };
            let byte = buffer[end];
            self.source.consume(end + 1);
            if byte == b'\r' && self.source.fill_buf().map_err(Error::reading(self.file))?.first() == Some(&b'\n') {
                self.source.consume(1);
            }
            return Ok(Some(byte));
        }
    }

    fn in_file(&self, error: LineError) -> Error {
        Error::in_line(self.file, error.line, error.message)
    }
}

impl<C: LineChecker> BufRead for CheckedReader<'_, C> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.consumed == self.checked.len() {
            self.refill().map_err(|failure| {
                self.failure = Some(failure);
                io::ErrorKind::InvalidData
            })?;
        }
        Ok(&self.checked[self.consumed..])
    }

    fn consume(&mut self, amount: usize) {
        self.consumed += amount;
    }
}

impl<C: LineChecker> Read for CheckedReader<'_, C> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let mut line = self.fill_buf()?;
        let read = line.read(buffer)?;
        self.consume(read);
        Ok(read)
    }
}

/// Whether a line ends with a backslash that joins it with the next one.
fn joins_next_line(line: &[u8]) -> bool {
    match line {
        // In a comment, it may end a Windows path. After another byte than ASCII it may belong to a letter: in
        // Shift-JIS, the second byte of some is a backslash. Neither may swallow the next line.
        [before @ .., b'\\'] => !before.contains(&b'#') && before.last().is_none_or(u8::is_ascii),
        _ => false,
    }
}

/// The encoding of a text whose characters have two or four bytes. Text that begins with ASCII shows it by its zeros,
/// even without a byte order mark.
fn wide_encoding(start: &[u8]) -> Option<&'static str> {
    match *start {
        [0xff, 0xfe, 0, 0, ..] => Some("UTF-32LE"),
        [0, 0, 0xfe, 0xff, ..] => Some("UTF-32BE"),
        [0xff, 0xfe, ..] => Some("UTF-16LE"),
        [0xfe, 0xff, ..] => Some("UTF-16BE"),
        [a, 0, b, 0, ..] if a != 0 && b != 0 => Some("UTF-16LE"),
        [0, a, 0, b, ..] if a != 0 && b != 0 => Some("UTF-16BE"),
        _ => None,
    }
}
