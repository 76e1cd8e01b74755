//! Measurements: errors and speed of kernels, speed of the tracer. Each file fills rows of the [record](super::record).

pub mod accuracy;
pub(crate) mod built_scene;
pub mod coherence;
mod empty_kernel;
mod hit_errors;
pub(crate) mod machine;
pub(crate) mod on_scenes;
pub(crate) mod operation_rates;
mod per_ray;
pub(crate) mod processes;
pub mod ray_sets;
pub(crate) mod rounds;
pub(crate) mod scaling;
pub(crate) mod scene_speed;
pub(crate) mod scene_truth;
pub mod speed;
pub(crate) mod stats;
pub(crate) mod survey;
mod tally;
pub(crate) mod timing;
pub(crate) mod tracer;
