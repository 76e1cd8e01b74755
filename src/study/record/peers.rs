//! Rows about the comparison with other tracers, and `peers.json` as a whole.

use serde::{Deserialize, Serialize};

use super::disagreements::Disagreements;
use super::machine::Machine;

/// [`Contender::tracer`] of this crate.
pub const OURS: &str = "raylanes";
/// [`Contender::tracer`] of Embree.
pub const EMBREE: &str = "Embree";

/// A comparison with peers: `peers.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct PeersRecord {
    /// Version of this layout: [`SCHEMA`].
    pub schema: u32,
    /// When it began, in seconds since 1970-01-01 UTC.
    pub started_unix: u64,
    /// How long it took, in seconds.
    pub seconds: f64,
    /// Where it ran, how it was built, and versions of all that took part.
    pub machine: Machine,
    /// Width and height of the picture whose rays were traced.
    pub size: u32,
    /// Rounds, after a warm-up.
    pub rounds: usize,
    /// What bounce and occlusion rays derive from.
    pub seed: u64,
    /// Our triangle kernel.
    pub kernel: String,
    /// Scene × rays × configuration × threads.
    pub peers: Vec<PeerRow>,
    /// The targets, judged.
    pub targets: Vec<TargetRow>,
}

/// Throughput of one configuration of one tracer, ours or a peer, on a scene of triangles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct PeerRow {
    /// Scene name.
    pub scene: String,
    /// Triangles in it.
    pub triangles: usize,
    /// `primary`, `shadow`, `bounce` or `ambient occlusion`, as made by [`ray_sets`](crate::study::ray_sets::ray_sets).
    pub rays: String,
    /// Number of rays.
    pub ray_count: usize,
    /// Rays that it reports to hit.
    pub hits: usize,
    /// `raylanes`, or the name of a crate or library.
    pub tracer: String,
    /// Ours: the mode. Others: tree, build and calls.
    pub configuration: String,
    /// Whether it promises that no ray slips through between triangles that share an edge.
    pub watertight: bool,
    /// Threads.
    pub threads: usize,
    /// Million rays per second: median of the rounds.
    pub mrays_per_second: f64,
    /// Median absolute deviation of the rounds.
    pub mrays_per_second_mad: f64,
    /// Million rays per second in each round. In a round every configuration had its turn: ratios are formed within it.
    pub mrays_of_rounds: Vec<f64>,
    /// Rays about which it disagrees with the scalar mode of ours, which is the first.
    pub disagreements: Disagreements,
    /// Seconds to build its tree, with as many threads as it can use.
    pub build_seconds: f64,
    /// Bytes per triangle of all that it keeps, the mesh included where it needs that; `null` where it cannot be told.
    pub bytes_per_triangle: Option<f64>,
    /// Hash over the bits of every hit.
    pub checksum: String,
}

/// A ratio to reach or to keep below, and what was measured: of rays per second of our automatic mode over those of a peer, or,
/// with `most`, of time per ray.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct TargetRow {
    /// Scene name.
    pub scene: String,
    /// `primary`, `shadow`, `bounce` or `ambient occlusion`.
    pub rays: String,
    /// What ours is compared with.
    pub against: String,
    /// The one of these that was the fastest; `null` if none took part.
    pub peer: Option<String>,
    /// The ratio must not be less.
    pub least: Option<f64>,
    /// The ratio must not be greater.
    pub most: Option<f64>,
    /// What is aimed at beyond that.
    pub aim: Option<f64>,
    /// Median of the ratios of all rounds; `null` if no peer took part.
    pub ratio: Option<f64>,
    /// Their median absolute deviation.
    pub ratio_mad: Option<f64>,
    /// Whether the ratio keeps to its bound; `null` where it does not apply.
    pub met: Option<bool>,
}
