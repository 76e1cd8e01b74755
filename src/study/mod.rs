//! The study: how fast and how right each kernel is, measured, charted and written down.
//!
//! Data flows through the rooms in this order, and imports run one way, back along it:
//!
//! | room | what it does |
//! | --- | --- |
//! | [`workload`] | makes the seeded rays and shapes |
//! | `measure` | times kernels and the tracer, counts errors; fills the rows of the record |
//! | [`record`] | the rows, as plain data: `results.json` |
//! | `figures` | reads the rows together: rates, groups of kernels, failures, claims, targets |
//! | `present` | charts, report, tables |
//! | [`peers`] | other tracers on the same rays: a study of its own over the same rooms |
//!
//! `record` imports nothing of the study, so that those who fill it and those who read it can share it. `run.rs` runs
//! all of it, `write.rs` writes it. `tests/` holds what only tests use.

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

pub use figures::claims;
pub use measure::built_scene::TracerKernel;
pub use measure::machine::build_warning;
pub use measure::stats::median;
pub use measure::{accuracy, coherence, ray_sets, speed};
pub use present::terminal::terminal_table;
pub use progress::Progress;
pub use record::folder::{make_folder, new_record, try_write};
pub use run::{Options, run};
pub use write::{write, write_new};
