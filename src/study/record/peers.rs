//! Rows about the comparison with other tracers, and the root of `peers.json`.

use serde::{Deserialize, Serialize};

use super::disagreements::Disagreements;
use super::machine::Machine;

/// [`PeerRow::tracer`] of this crate.
pub const OURS: &str = "raylanes";
/// [`PeerRow::tracer`] of Embree.
pub const EMBREE: &str = "Embree";

/// A comparison with peers: the root of `peers.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct PeersRecord {
    /// Version of this layout: [`SCHEMA`](super::SCHEMA).
    pub schema: u32,
    /// Start of the comparison, in seconds since 1970-01-01 UTC.
    pub started_unix: u64,
    /// Duration of the comparison in seconds.
    pub seconds: f64,
    /// The machine, the build, and the versions of all tracers that took part.
    pub machine: Machine,
    /// Width and height, in pixels, of the picture whose rays were traced.
    pub size: u32,
    /// Number of rounds, without the warm-up.
    pub rounds: usize,
    /// The seed of bounce and occlusion rays.
    pub seed: u64,
    /// ID of the triangle kernel of this crate.
    pub kernel: String,
    /// Scene × rays × configuration × threads.
    pub peers: Vec<PeerRow>,
    /// The targets, and whether they are met.
    pub targets: Vec<TargetRow>,
}

/// Throughput of one configuration of one tracer, this crate or a peer, on a scene of triangles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct PeerRow {
    /// Scene name.
    pub scene: String,
    /// Number of triangles.
    pub triangles: usize,
    /// `primary`, `shadow`, `bounce` or `ambient occlusion`, as made by [`ray_sets`](crate::study::ray_sets::ray_sets).
    pub rays: String,
    /// Number of rays.
    pub ray_count: usize,
    /// Number of rays that the tracer reports as hits.
    pub hits: usize,
    /// `raylanes`, or the name of a crate or library.
    pub tracer: String,
    /// For raylanes, the mode. For others: tree, build and calls.
    pub configuration: String,
    /// Whether the tracer promises that no ray passes between two triangles that share an edge.
    pub watertight: bool,
    /// Number of threads.
    pub threads: usize,
    /// Million rays per second: median of the rounds.
    pub mrays_per_second: f64,
    /// Median absolute deviation of the rounds.
    pub mrays_per_second_mad: f64,
    /// Million rays per second in each round. Every configuration has one turn in each round, and ratios are formed
    /// within a round.
    pub mrays_of_rounds: Vec<f64>,
    /// Rays on which the tracer disagrees with the first one, which is raylanes in scalar mode.
    pub disagreements: Disagreements,
    /// Seconds to build its tree, with as many threads as the tracer can use.
    pub build_seconds: f64,
    /// Bytes per triangle of everything that the tracer keeps. The mesh is included if the tracer needs it. `null`
    /// where this is unknown.
    pub bytes_per_triangle: Option<f64>,
    /// Hash of the bits of every hit.
    pub checksum: String,
}

/// A target, and the measured ratio.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct TargetRow {
    /// Scene name.
    pub scene: String,
    /// `primary`, `shadow`, `bounce` or `ambient occlusion`.
    pub rays: String,
    /// What raylanes is compared with.
    pub against: String,
    /// The fastest configuration among those; `null` if none took part.
    pub peer: Option<String>,
    /// The ratio must be at least this.
    pub least: Option<f64>,
    /// The ratio must be at most this.
    pub most: Option<f64>,
    /// A more ambitious ratio, not required.
    pub aim: Option<f64>,
    /// The measured ratio. With `least`, it is rays per second of raylanes in mode auto over those of `peer`: the
    /// median of the ratios of all rounds. With `most`, it is the growth of the time per ray. `null` if no peer took
    /// part.
    pub ratio: Option<f64>,
    /// Median absolute deviation of the ratios.
    pub ratio_mad: Option<f64>,
    /// Whether the ratio keeps its bound; `null` where the bound does not apply.
    pub met: Option<bool>,
}
