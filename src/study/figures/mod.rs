//! What the record's rows say when they are read together: rates, groups of kernels, what fails where, and the rows that
//! follow from others.

pub mod claims;
pub(crate) mod failures;
mod format;
mod group;
mod kernel;
mod limit;
pub(crate) mod peers;
mod rate;
pub(crate) mod summary;
pub(crate) mod tracer;

pub(crate) use format::{MISSING, count, number, optional, percent, severity, si, times};
pub(crate) use group::{Group, Loss, groups, groups_of_methods};
pub(crate) use kernel::{Figures, fastest_of, thread_counts, tied};
pub(crate) use rate::Rate;
