//! Writes JSON with one line per row of a list. A record of thousands of rows stays short, and a diff shows changed
//! rows.

use std::io::{self, Write};

use serde::Serialize;
use serde_json::ser::{Formatter, Serializer};

/// An object as JSON, with a final newline. Each field is on a line of its own. If a field is a list, so is each of its
/// elements. Anything nested deeper stays on that line. Fields keep the order of their declaration.
pub(crate) fn one_row_per_line(value: &impl Serialize) -> serde_json::Result<Vec<u8>> {
    let mut json = Vec::new();
    value.serialize(&mut Serializer::with_formatter(&mut json, RowPerLine::default()))?;
    json.push(b'\n');
    Ok(json)
}

#[derive(Default)]
struct RowPerLine {
    /// For each enclosing list or object, from the outermost in: whether each of its elements is on its own line.
    open: Vec<bool>,
    /// Whether the list or object that ends next has any elements.
    filled: bool,
}

impl RowPerLine {
    fn begin<W: Write + ?Sized>(&mut self, bracket: &[u8], lines: bool, writer: &mut W) -> io::Result<()> {
        self.open.push(lines);
        self.filled = false;
        writer.write_all(bracket)
    }

    fn element<W: Write + ?Sized>(&mut self, first: bool, writer: &mut W) -> io::Result<()> {
        match (self.open.last() == Some(&true), first) {
            (true, true) => self.indent(b"\n", writer),
            (true, false) => self.indent(b",\n", writer),
            (false, true) => Ok(()),
            (false, false) => writer.write_all(b", "),
        }
    }

    fn indent<W: Write + ?Sized>(&self, before: &[u8], writer: &mut W) -> io::Result<()> {
        writer.write_all(before)?;
        self.open.iter().try_for_each(|_| writer.write_all(b"  "))
    }

    fn end<W: Write + ?Sized>(&mut self, bracket: &[u8], writer: &mut W) -> io::Result<()> {
        let lines = self.open.pop() == Some(true);
        if lines && self.filled {
            self.indent(b"\n", writer)?;
        }
        self.filled = true;
        writer.write_all(bracket)
    }
}

impl Formatter for RowPerLine {
    fn begin_array<W: Write + ?Sized>(&mut self, writer: &mut W) -> io::Result<()> {
        let lines = self.open.len() == 1;
        self.begin(b"[", lines, writer)
    }

    fn end_array<W: Write + ?Sized>(&mut self, writer: &mut W) -> io::Result<()> {
        self.end(b"]", writer)
    }

    fn begin_array_value<W: Write + ?Sized>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        self.element(first, writer)
    }

    fn end_array_value<W: Write + ?Sized>(&mut self, _: &mut W) -> io::Result<()> {
        self.filled = true;
        Ok(())
    }

    fn begin_object<W: Write + ?Sized>(&mut self, writer: &mut W) -> io::Result<()> {
        let lines = self.open.is_empty();
        self.begin(b"{", lines, writer)
    }

    fn end_object<W: Write + ?Sized>(&mut self, writer: &mut W) -> io::Result<()> {
        self.end(b"}", writer)
    }

    fn begin_object_key<W: Write + ?Sized>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        self.element(first, writer)
    }

    fn begin_object_value<W: Write + ?Sized>(&mut self, writer: &mut W) -> io::Result<()> {
        writer.write_all(b": ")
    }

    fn end_object_value<W: Write + ?Sized>(&mut self, _: &mut W) -> io::Result<()> {
        self.filled = true;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::record::Record;
    use crate::study::tests::fixture::{all_ids, record_of};

    #[test]
    fn a_record_is_written_with_one_row_per_line_and_reads_back_equal() {
        let mut record = record_of(&all_ids());
        record.peers.clear();
        let text = String::from_utf8(one_row_per_line(&record).unwrap()).unwrap();
        assert!(serde_json::from_str::<Record>(&text).unwrap() == record);
        assert!(text.contains("\n  \"peers\": []\n}\n"), "an empty list stays on one line");
        for row in &record.accuracy {
            let start = format!("\n    {{\"id\": \"{}\", \"workload\": \"{}\", ", row.id, row.workload);
            assert!(text.contains(&start), "{start}");
        }
        let rows = |list: &str| {
            let lines = text.lines().skip_while(|line| *line != format!("  \"{list}\": ["));
            lines.skip(1).take_while(|line| line.starts_with("    ")).count()
        };
        assert_eq!(rows("accuracy"), record.accuracy.len());
        assert_eq!(rows("map_cells"), record.map_cells.len());
        assert_eq!(rows("coherence"), record.coherence.len());
        assert!(text.starts_with(&format!("{{\n  \"schema\": {},\n", record.schema)));
    }
}
