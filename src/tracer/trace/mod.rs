//! Tracing many rays: the modes, threads, and files of rays and hits.

mod incoherent;
mod mode;
mod ray_file;
mod run;

pub use mode::Mode;
pub use ray_file::{read_rays, write_hits, write_rays};
pub use run::{checksum, count, thread_pool, trace, trace_into};
