//! What a study writes: `results.json`, field by field, and `peers.json`.
//!
//! Rows are plain data that imports nothing of the study: measurements fill them, and figures, tables, charts and the
//! report read them. Other programs read the files too. `reports/FIELDS.md` is made of the comments in this folder:
//! after a change, `RAYLANES_BLESS=1 cargo test --lib fields` rewrites it.

mod accuracy;
mod date;
mod disagreements;
pub(crate) mod folder;
mod json;
mod kernels;
mod machine;
mod peers;
mod study;
mod tracer;

pub use accuracy::{AccuracyRow, ClaimRow, MapCells, MapRow, RegimeRow};
pub(crate) use date::{date, seconds_since_1970};
pub use disagreements::Disagreements;
pub(crate) use json::one_row_per_line;
pub use kernels::{AbsentRow, KernelRow, MethodRow, OperationCounts, RateRow, SpeedRow};
pub use machine::Machine;
pub use peers::{EMBREE, OURS, PeerRow, PeersRecord, TargetRow};
pub use study::{Record, SCHEMA};
pub use tracer::{CoherenceRow, ScalingRow, TracerRow};
