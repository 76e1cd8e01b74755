//! The comparison with other tracers on the same rays: the peers, how all of them are timed, and how many of their hits
//! differ from ours.
//!
//! The crates obvhs, bvh and parry3d need the feature `peers`. The bench of that name adds Embree.

mod compare;
mod contender;
#[cfg(feature = "peers")]
mod crates;
mod machine;
mod write;

pub(crate) use compare::compare;
pub use compare::{available, measure};
pub use contender::{Contender, Tracer, in_chunks, ours, plain_mesh};
#[cfg(feature = "peers")]
pub use crates::rust_peers;
pub use machine::{cache_bytes, machine};
pub use write::write;

pub use super::figures::peers::{judge, ratio};
pub use super::present::peers::terminal;
pub use super::record::{Disagreements, EMBREE, OURS};
