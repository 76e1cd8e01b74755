//! The machine and the build that a record comes from.

use serde::{Deserialize, Serialize};

/// The machine and the build.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Machine {
    /// Processor model.
    pub cpu: String,
    /// Bytes of the first-level data cache of a core. `null` if the system does not say.
    pub first_level_cache_bytes: Option<u64>,
    /// Number of logical processors that the program could use.
    pub processors: usize,
    /// Operating system.
    pub os: String,
    /// Target triple of the build.
    pub target: String,
    /// Target features that were enabled at compile time, sorted.
    pub target_features: Vec<String>,
    /// Compiler version.
    pub rustc: String,
    /// Versions of this crate and of the crates whose code is measured, as `name version`.
    pub versions: Vec<String>,
}
