//! The record: every row that a study writes to `results.json`, and that a comparison writes to `peers.json`.
//!
//! Rows are plain data and import nothing else of the study. Measurements fill them; figures, tables, charts and the
//! report read them. Other programs may read the files too, so `reports/FIELDS.md` lists every field. It is generated
//! from the comments in this folder: after a change, run `RAYLANES_BLESS=1 cargo test --lib fields`.

mod accuracy;
mod date;
mod disagreements;
pub(crate) mod folder;
mod hit_errors;
mod json;
mod kernels;
mod machine;
mod peers;
mod samples;
mod study;
mod tracer;

pub use accuracy::{AccuracyRow, ClaimRow, MapCells, MapRow, RegimeRow};
pub(crate) use date::{date, seconds_since_1970};
pub use disagreements::Disagreements;
pub use hit_errors::HitErrors;
pub(crate) use json::one_row_per_line;
pub use kernels::{AbsentRow, KernelRow, MethodRow, OperationCounts, RateRow, SpeedRow};
pub use machine::Machine;
pub use peers::{EMBREE, OURS, PeerRow, PeersRecord, TargetRow};
pub use samples::Samples;
pub use study::{Record, SCHEMA};
pub use tracer::{CoherenceRow, OnSceneRow, ScalingRow, SceneSpeedRow, TracerRow};
