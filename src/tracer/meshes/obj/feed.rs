//! Feeds a text file to `tobj` one checked line at a time, so that the line at fault is known.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

use crate::error::{Error, quoted};

/// Longest line, joined lines included: it bounds the memory that a file which is no text can take. A face of a
/// million vertices fits.
const LONGEST_LINE: usize = 1 << 24;

/// Looks at every line of a file before the parser does.
pub(super) trait Check {
    /// Refuses a line, or writes to `checked` what the parser shall see of it: nothing, or one line with its end.
    fn line(&mut self, line: &Line<'_>, checked: &mut Vec<u8>) -> Result<(), Fault>;

    /// What can only be judged when the whole file is known.
    fn end(&mut self) -> Result<(), Fault> {
        Ok(())
    }
}

/// What is wrong with a line.
pub(super) struct Fault {
    pub(super) line: usize,
    pub(super) message: String,
}

/// A line, together with those that a backslash joins to it.
pub(super) struct Line<'a> {
    /// Number of the (first) line in the file, counted from 1.
    pub(super) number: usize,
    /// Without the space around it.
    pub(super) text: &'a [u8],
}

impl<'a> Line<'a> {
    /// The first word; empty for an empty line or a comment.
    pub(super) fn keyword(&self) -> &'a [u8] {
        self.words().next().unwrap_or_default()
    }

    /// The words after the keyword, up to a comment.
    pub(super) fn arguments(&self) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        self.words().skip(1)
    }

    /// All that follows the keyword: a name may hold spaces and `#`.
    pub(super) fn name(&self) -> String {
        let rest = self.text.strip_prefix(self.keyword()).unwrap_or_default();
        String::from_utf8_lossy(rest).trim().to_owned()
    }

    /// Reads a finite number; `what` says in the message what it is.
    pub(super) fn finite(&self, what: &str, word: &[u8]) -> Result<f32, Fault> {
        match str::from_utf8(word).ok().and_then(|word| word.parse::<f32>().ok()) {
            None => Err(self.fault(&format!("{what} cannot be read"))),
            Some(number) if number.is_nan() => Err(self.fault(&format!("{what} is NaN"))),
            Some(number) if number.is_infinite() => Err(self.fault(&format!("{what} is infinite or too large"))),
            Some(number) => Ok(number),
        }
    }

    /// What is wrong, with the text of this line.
    pub(super) fn fault(&self, what: &str) -> Fault {
        Fault { line: self.number, message: format!("{what}: {}", quoted(self.text)) }
    }

    fn words(&self) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        let end = self.text.iter().position(|&byte| byte == b'#').unwrap_or(self.text.len());
        self.text[..end].split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
    }
}

/// Counts lines of one kind and remembers the first, so that a million of them make one warning.
#[derive(Debug, Default)]
pub(super) struct LineCount {
    count: usize,
    first: Option<(usize, String)>,
}

impl LineCount {
    pub(super) fn note(&mut self, line: &Line<'_>) {
        self.note_text(line.number, line.text);
    }

    pub(super) fn note_text(&mut self, line: usize, text: &[u8]) {
        self.count += 1;
        self.first.get_or_insert_with(|| (line, quoted(text)));
    }

    /// The warning, if there is something to warn about.
    pub(super) fn warning(&self, file: &Path, what: &str) -> Option<String> {
        let (line, text) = self.first.as_ref()?;
        let more = if self.count > 1 { format!(" (and {} more)", self.count - 1) } else { String::new() };
        Some(Error::in_line(file, *line, format!("{what}: {text}{more}")).to_string())
    }
}

/// A file as its parser sees it: the checked lines, each handed out only when the one before is used up. So whatever
/// fails, here or in the parser, failed at the current line.
pub(super) struct Feed<'a, C> {
    file: &'a Path,
    source: BufReader<File>,
    check: C,
    /// Lines read so far.
    lines: usize,
    /// Number of the current line.
    number: usize,
    text: Vec<u8>,
    checked: Vec<u8>,
    consumed: usize,
    /// Why the feed stopped. The parser only learns that it did.
    failure: Option<Error>,
}

impl<'a, C: Check> Feed<'a, C> {
    pub(super) fn open(file: &'a Path, check: C) -> Result<Self, Error> {
        let source = BufReader::new(File::open(file).map_err(Error::reading(file))?);
        let (text, checked) = (Vec::new(), Vec::new());
        Ok(Self { file, source, check, lines: 0, number: 0, text, checked, consumed: 0, failure: None })
    }

    /// The parser's result and the checker, or what went wrong at which line.
    pub(super) fn finish<T>(self, parsed: Result<T, tobj::LoadError>) -> Result<(T, C), Error> {
        match (self.failure, parsed) {
            (Some(failure), _) => Err(failure),
            (None, Err(error)) => {
                Err(Error::in_line(self.file, self.number, format!("{error}: {}", quoted(&self.text))))
            }
            (None, Ok(parsed)) => Ok((parsed, self.check)),
        }
    }

    /// Reads and checks lines until the parser has something to see or the file ends.
    fn refill(&mut self) -> Result<(), Error> {
        self.checked.clear();
        self.consumed = 0;
        while self.checked.is_empty() {
            let checked = if self.next_line()? {
                let line = Line { number: self.number, text: self.text.trim_ascii() };
                self.check.line(&line, &mut self.checked)
            } else {
                return self.check.end().map_err(|fault| self.error(fault));
            };
            checked.map_err(|fault| self.error(fault))?;
        }
        Ok(())
    }

    /// Reads a line and those joined to it; false at the end of the file.
    fn next_line(&mut self) -> Result<bool, Error> {
        self.text.clear();
        self.number = self.lines + 1;
        loop {
            let start = self.text.len();
            let room = (LONGEST_LINE + 1 - start) as u64;
            let read = self.source.by_ref().take(room).read_until(b'\n', &mut self.text);
            if read.map_err(Error::reading(self.file))? == 0 {
                return Ok(self.lines >= self.number);
            }
            if self.text.len() > LONGEST_LINE {
                let message = format!("line is longer than {LONGEST_LINE} bytes: {}", quoted(&self.text));
                return Err(Error::in_line(self.file, self.number, message));
            }
            self.lines += 1;
            if self.lines == 1 && self.text.starts_with(BYTE_ORDER_MARK) {
                self.text.drain(..BYTE_ORDER_MARK.len());
            }
            let added = self.text[start..].trim_ascii_end();
            // A comment that ends with a Windows path must not swallow the next line.
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

    fn error(&self, fault: Fault) -> Error {
        Error::in_line(self.file, fault.line, fault.message)
    }
}

/// Some editors begin a file with it. `tobj` would take the first vertex for an unknown line.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

impl<C: Check> BufRead for Feed<'_, C> {
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

impl<C: Check> Read for Feed<'_, C> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let mut line = self.fill_buf()?;
        let read = line.read(buffer)?;
        self.consume(read);
        Ok(read)
    }
}
