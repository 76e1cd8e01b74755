//! Tracing many rays: the modes, threads, and files of rays and hits.

mod incoherent;
mod mode;
mod ray_file;
mod run;
mod threads;

pub use mode::Mode;
pub use ray_file::{read_rays, write_hits, write_rays, write_wide_hits};
pub use run::{checksum, count, trace, trace_into};
#[cfg(feature = "study")]
pub(crate) use threads::refused as threads_refused;
pub use threads::{start_global_pool, thread_pool};
