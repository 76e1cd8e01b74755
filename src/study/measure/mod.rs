//! Measurements: errors and speed of kernels, speed of the tracer. Each file fills rows of the [record](super::record).

pub mod accuracy;
pub(crate) mod built_scene;
pub mod coherence;
mod hit_errors;
pub(crate) mod machine;
pub(crate) mod operation_rates;
pub mod ray_sets;
pub(crate) mod scaling;
pub mod speed;
pub(crate) mod stats;
pub(crate) mod survey;
mod tally;
pub(crate) mod timing;
pub(crate) mod tracer;
