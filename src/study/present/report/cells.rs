//! Cells that several tables have.

use crate::study::figures::number;
use crate::study::present::grid::Cell;

/// A kernel ID, set as code.
pub(super) fn code(id: &str) -> Cell {
    Cell::from(format!("`{id}`"))
}

/// A median ± the median absolute deviation.
pub(super) fn with_mad(value: f64, mad: f64) -> String {
    format!("{} ± {}", number(value, 3), number(mad, 1))
}
