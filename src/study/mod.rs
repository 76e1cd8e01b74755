//! The study: measures how fast and how accurate every kernel is, and writes tables, charts and a report.
//!
//! Data flows through these rooms from top to bottom:
//!
//! | room | what it does |
//! | --- | --- |
//! | [`workload`] | makes seeded rays and shapes |
//! | `measure` | times kernels and the tracer, counts errors, and fills the rows of the record |
//! | [`record`] | the rows as plain data, and `results.json` |
//! | `figures` | derives figures from the rows: rates, groups of kernels, failures, claims, targets |
//! | [`advice`] | says which kernel and mode one scene needs |
//! | `present` | draws charts, and writes the report and the tables |
//! | [`peers`] | compares the tracer with other tracers, by means of the rooms above |
//!
//! A room imports only rooms above it, and never one below. `record` is the exception: it is plain data, imports no
//! other room, and `measure` imports it.
//!
//! `run.rs` runs the whole study, `write.rs` writes its files, and `progress.rs` shows how far it has come. `tests/` is
//! compiled for tests only.

pub mod advice;
mod figures;
mod measure;
pub mod peers;
mod present;
mod progress;
pub mod record;
mod run;
#[cfg(test)]
mod tests;
pub mod workload;
mod write;

pub use crate::files::ReservedFolder;
pub use figures::claims;
pub use measure::built_scene::TracerKernel;
pub use measure::machine::{build_warning, describe};
pub use measure::processes::{TIME_KERNELS, Timed, stop_processes, time_kernels};
pub use measure::stats::median;
pub use measure::{accuracy, coherence, ray_sets, speed};
pub use present::advice::{advice_page, advice_text};
pub use present::terminal::terminal_table;
pub use progress::Progress;
pub use record::folder::{make_folder, new_record, reserve};
pub use run::{Options, OtherBuild, run};
pub use write::{RESULT_EXTENSIONS, write, write_new};
