//! Tables: a grid of cells that is written as Markdown, or as aligned columns for a terminal.

/// A cell, and how it is emphasised.
#[derive(Clone, Debug)]
pub(crate) struct Cell {
    text: String,
    emphasis: Emphasis,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Emphasis {
    None,
    Best,
    Bad,
}

impl<T: Into<String>> From<T> for Cell {
    fn from(text: T) -> Self {
        Self { text: text.into(), emphasis: Emphasis::None }
    }
}

impl Cell {
    /// Marks the cell as the best of its kind if `best` is set.
    pub(crate) fn best_if(self, best: bool) -> Self {
        if best { Self { emphasis: Emphasis::Best, ..self } } else { self }
    }

    /// Marks the cell as a failure if `bad` is set.
    pub(crate) fn bad_if(self, bad: bool) -> Self {
        if bad { Self { emphasis: Emphasis::Bad, ..self } } else { self }
    }
}

/// A table. The first `left` columns are text and aligned left; the others are numbers and aligned right.
#[derive(Debug)]
pub(crate) struct Grid {
    left: usize,
    /// Headers of the columns.
    pub(crate) header: Vec<Cell>,
    /// Rows. Each has as many cells as the header, or a single cell: a heading across all columns.
    pub(crate) rows: Vec<Vec<Cell>>,
}

impl Grid {
    /// A grid without rows.
    pub(crate) fn new<const N: usize>(left: usize, header: [&str; N]) -> Self {
        Self { left, header: header.map(Cell::from).to_vec(), rows: Vec::new() }
    }

    /// The table in Markdown. The best cells are bold.
    pub(crate) fn markdown(&self) -> String {
        let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let rule = |column| if column < self.left { "---" } else { "--:" }.to_owned();
        let text = |cell: &Cell| {
            let text = cell.text.replace('|', "\\|");
            if cell.emphasis == Emphasis::Best { format!("**{text}**") } else { text }
        };
        let mut out = line(self.header.iter().map(text).collect());
        out += &line((0..self.header.len()).map(rule).collect());
        out.extend(self.rows.iter().map(|row| line(row.iter().map(text).collect())));
        out
    }

    /// The table in aligned columns. With `color`, the best cells are green, failures are red, and headings are bold.
    pub(crate) fn terminal(&self, color: bool) -> String {
        let width = |cell: &Cell| cell.text.chars().count();
        let full_rows = || self.rows.iter().filter(|row| row.len() == self.header.len()).chain([&self.header]);
        let widths: Vec<usize> = (0..self.header.len())
            .map(|column| full_rows().map(|row| width(&row[column])).max().unwrap_or(0))
            .collect();
        let paint = |text: &str, code: &str| {
            if color { format!("\x1b[{code}m{text}\x1b[0m") } else { text.to_owned() }
        };
        let line = |row: &Vec<Cell>| {
            let cells = row.iter().enumerate().map(|(column, cell)| {
                // The padding is outside the colour codes, which have no width.
                let padding = " ".repeat(widths[column].saturating_sub(width(cell)));
                let text = match cell.emphasis {
                    Emphasis::None => cell.text.clone(),
                    Emphasis::Best => paint(&cell.text, "32"),
                    Emphasis::Bad => paint(&cell.text, "31"),
                };
                if column < self.left { text + &padding } else { padding + &text }
            });
            cells.collect::<Vec<_>>().join("  ").trim_end().to_owned()
        };
        let mut out = paint(&line(&self.header), "1") + "\n";
        for row in &self.rows {
            let heading = row.len() < self.header.len();
            out += &if heading { paint(&line(row), "1") } else { line(row) };
            out += "\n";
        }
        out
    }
}
