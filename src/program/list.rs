//! `raylanes list`: a table of all kernels, and of those that this build lacks.

use std::fmt::Write as _;

use raylanes::kernels::{Intersect, Kernel, Shape};
use raylanes::registry::{self, Visitor};

pub(super) fn run() -> String {
    let header = ["kernel", "mul/add/div", "prepared", "setup", "claims", "idea"].map(String::from);
    let mut rows = Rows(vec![header]);
    registry::all(&mut rows);
    let width = |column: usize| rows.0.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: [usize; 5] = std::array::from_fn(width);
    let mut text = String::new();
    for row in &rows.0 {
        for (cell, width) in row.iter().zip(widths) {
            write!(text, "{cell:width$}  ").expect("strings grow");
        }
        writeln!(text, "{}", row[5]).expect("strings grow");
    }
    for absent in registry::absent() {
        writeln!(text, "{}  absent: {}", absent.id, absent.reason).expect("strings grow");
    }
    text.push_str("\nmul/add/div: operations of one test; prepared: bytes per primitive; setup: bytes per ray.\n");
    text
}

/// One row for each kernel, after the header.
struct Rows(Vec<[String; 6]>);

impl<S: Shape> Visitor<S> for Rows {
    fn visit<K: Kernel<Shape = S>>(&mut self) {
        let info = K::INFO;
        let operations = info.operations;
        let claims: Vec<_> = info.claims.iter().map(|claim| claim.name()).collect();
        self.0.push([
            info.id.to_string(),
            format!("{}/{}/{}", operations.mul, operations.add, operations.div),
            size_of::<K>().to_string(),
            size_of::<<K as Intersect<f32>>::Setup>().to_string(),
            if claims.is_empty() { "-".into() } else { claims.join(" ") },
            info.idea.into(),
        ]);
    }
}
