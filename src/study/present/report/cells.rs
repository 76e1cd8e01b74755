//! Cells that several tables have.

use crate::study::figures::number;
use crate::study::present::grid::Cell;

/// A kernel ID, set as code.
pub(super) fn code(id: &str) -> Cell {
    Cell::from(format!("`{id}`"))
}

/// A median with its 95 % interval.
pub(super) fn with_interval(value: f64, low: f64, high: f64) -> String {
    format!("{} ({} to {})", number(value, 3), number(low, 3), number(high, 3))
}

/// A median ± the median absolute deviation.
pub(super) fn with_mad(value: f64, mad: f64) -> String {
    format!("{} ± {}", number(value, 3), number(mad, 1))
}
