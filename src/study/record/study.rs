//! `results.json` as a whole. Tables, charts and the report are generated from it alone.

use serde::{Deserialize, Serialize};

use super::accuracy::{AccuracyRow, ClaimRow, MapCells, MapRow, RegimeRow};
use super::kernels::{AbsentRow, KernelRow, MethodRow, RateRow, SpeedRow};
use super::machine::Machine;
use super::peers::PeerRow;
use super::tracer::{CoherenceRow, ScalingRow, TracerRow};

/// Version of the layout below; raised when a field changes its meaning or goes away, not when one is added.
pub const SCHEMA: u32 = 4;

/// One study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Record {
    /// Version of this layout: [`SCHEMA`].
    pub schema: u32,
    /// When the study began, in seconds since 1970-01-01 UTC.
    pub started_unix: u64,
    /// How long it took, in seconds.
    pub seconds: f64,
    /// Whether it was run with `--quick`: fewer rays and samples.
    pub quick: bool,
    /// What all random inputs derive from.
    pub seed: u64,
    /// Where it ran, and how it was built.
    pub machine: Machine,
    /// Kernel × face, in one thread: the figures that matter most, all of which follow from the lists below.
    pub kernels: Vec<KernelRow>,
    /// Every registered kernel, as it describes itself.
    pub methods: Vec<MethodRow>,
    /// Kernels that exist, but not in this build.
    pub absent: Vec<AbsentRow>,
    /// Kernel × face × threads: throughput.
    pub speed: Vec<SpeedRow>,
    /// What operations on eight lanes take at least.
    pub rates: Vec<RateRow>,
    /// The regimes: what is made harder, and in which steps.
    pub regimes: Vec<RegimeRow>,
    /// Kernel × workload, and kernel × regime × severity: errors against the oracle. Both twins give the same bits, so
    /// there is one row for both.
    pub accuracy: Vec<AccuracyRow>,
    /// Kernel × claim of its family: whether it was seen to be broken.
    pub claims: Vec<ClaimRow>,
    /// The failure maps: two severities at once.
    pub maps: Vec<MapRow>,
    /// Kernel × map: the errors.
    pub map_cells: Vec<MapCells>,
    /// Scene × rays × mode × threads.
    pub tracer: Vec<TracerRow>,
    /// Scene × jitter × mode: the tracer on rays that have ever less in common.
    pub coherence: Vec<CoherenceRow>,
    /// Scene × rays: the tracer on ever more triangles.
    pub scaling: Vec<ScalingRow>,
    /// Scene × rays × configuration of a tracer, ours or a peer, × threads; empty unless peers were asked for.
    #[serde(default)]
    pub peers: Vec<PeerRow>,
}
