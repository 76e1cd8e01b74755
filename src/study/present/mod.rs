//! The record as people read it: charts, the report, and tables for a terminal.

pub(crate) mod chart;
mod grid;
pub(crate) mod peers;
pub(crate) mod report;
pub(crate) mod terminal;
pub(crate) mod verdict;
