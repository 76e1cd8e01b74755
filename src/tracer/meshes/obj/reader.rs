//! A reader that gives `tobj` one checked line at a time, so that errors can name the line.

use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

use super::line::{Line, LineError};
use crate::error::{Error, quoted};
use crate::files::Input;

/// Largest size in bytes of a file. A pipe or a device may never end.
const MAX_BYTES: u64 = 1 << 33;

/// Largest length in bytes of a line, with the lines joined to it. It bounds the memory that a binary file can take. A
/// face with a million vertices fits.
const MAX_LINE_BYTES: usize = 1 << 24;

/// Some editors put this at the start of a file. It would make the first keyword an unknown one.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// Checks every line of a file before the parser reads it.
pub(super) trait LineChecker {
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
    /// Number of lines read.
    lines_read: usize,
    /// Number of the current line, counted from 1.
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
        let source = BufReader::new(Input::open(file, MAX_BYTES)?);
        let (text, checked) = (Vec::new(), Vec::new());
        Ok(Self { file, source, checker, lines_read: 0, number: 0, text, checked, consumed: 0, failure: None })
    }

    /// Ends the reading. `parsed` is what the parser returned.
    ///
    /// # Errors
    /// The error of the reader, the checker or the parser, with its line.
    pub(super) fn finish<T>(self, parsed: Result<T, tobj::LoadError>) -> Result<(T, C), Error> {
        match (self.failure, parsed) {
            (Some(failure), _) => Err(failure),
            (None, Err(error)) => {
                Err(Error::in_line(self.file, self.number, format!("{error}: {}", quoted(&self.text))))
            }
            (None, Ok(parsed)) => Ok((parsed, self.checker)),
        }
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
        self.number = self.lines_read + 1;
        loop {
            let start = self.text.len();
            let room = (MAX_LINE_BYTES + 1 - start) as u64;
            let read = self.source.by_ref().take(room).read_until(b'\n', &mut self.text);
            if read.map_err(Error::reading(self.file))? == 0 {
                return Ok(self.lines_read >= self.number);
            }
            if self.text.len() > MAX_LINE_BYTES {
                let message = format!("line is longer than {MAX_LINE_BYTES} bytes: {}", quoted(&self.text));
                return Err(Error::in_line(self.file, self.number, message));
            }
            self.lines_read += 1;
            if self.lines_read == 1 && self.text.starts_with(BYTE_ORDER_MARK) {
                self.text.drain(..BYTE_ORDER_MARK.len());
            }
            let added = self.text[start..].trim_ascii_end();
            // Not in a comment: it may end with a Windows path, which must not swallow the next line.
            let joins = added.ends_with(b"\\") && !added.contains(&b'#');
            let end = start + added.len();
            if !joins {
                self.text.truncate(end);
                return Ok(true);
            }
            self.text.truncate(end - 1);
            self.text.push(b' ');
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
