//! Tracing many rays: the modes, threads, and files of rays and hits.

mod incoherent;
mod mode;
mod ray_file;
mod run;
mod threads;

pub use mode::Mode;
pub use ray_file::{read_rays, write_hits, write_rays, write_wide_hits};
#[cfg(feature = "study")]
pub(crate) use run::trace_set_into;
pub use run::{Traceable, checksum, occluded, occluded_into, trace, trace_into, traversal_stats};
#[cfg(feature = "study")]
pub(crate) use threads::refused as threads_refused;
pub use threads::{start_global_pool, thread_pool};
