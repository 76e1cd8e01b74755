//! Figures that follow from the rows of a record: rates, groups of kernels, failures, limits, ratios of the tracer. Two
//! files also derive rows of the record from other rows: `summary` and `claims`.

mod binomial;
pub(crate) mod choice;
pub mod claims;
pub(crate) mod failures;
mod format;
mod group;
mod kernel;
mod limit;
pub(crate) mod on_scenes;
pub(crate) mod peers;
mod rate;
mod scaling;
pub(crate) mod summary;
pub(crate) mod tracer;

pub(crate) use format::{MISSING, count, number, optional, percent, severity, si, times};
pub(crate) use group::{Group, Loss, groups};
pub(crate) use kernel::{Failures, KernelFigures, thread_counts, tied};
pub(crate) use rate::Rate;
pub(crate) use scaling::Scaling;
