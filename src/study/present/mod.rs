//! The record as people read it: charts, the report, and tables for the terminal. Everything here is made from the
//! record alone.

pub(crate) mod advice;
pub(crate) mod chart;
mod grid;
pub(crate) mod peers;
pub(crate) mod report;
pub(crate) mod terminal;
pub(crate) mod verdict;
