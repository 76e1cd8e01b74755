//! The root of `results.json`: one field for each list of rows.

use serde::{Deserialize, Serialize};

use super::accuracy::{AccuracyRow, ClaimRow, MapCells, MapRow, RegimeRow};
use super::kernels::{AbsentRow, KernelRow, MethodRow, RateRow, SpeedRow};
use super::machine::Machine;
use super::peers::PeerRow;
use super::tracer::{CoherenceRow, OnSceneRow, ScalingRow, SceneSpeedRow, TracerRow};

/// Version of the layout. It rises when a field is removed or changes its meaning, not when one is added.
pub const SCHEMA: u32 = 5;

/// One study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Record {
    /// Version of this layout: [`SCHEMA`].
    pub schema: u32,
    /// Start of the study, in seconds since 1970-01-01 UTC.
    pub started_unix: u64,
    /// Duration of the study in seconds.
    pub seconds: f64,
    /// Whether the study ran with `--quick`: fewer rays and samples.
    pub quick: bool,
    /// The seed of all random inputs.
    pub seed: u64,
    /// The machine and the build.
    pub machine: Machine,
    /// Kernel × width, one thread: the most important figures. All of them follow from the lists below.
    pub kernels: Vec<KernelRow>,
    /// Every registered kernel, as it describes itself.
    pub methods: Vec<MethodRow>,
    /// Kernels that this build does not contain.
    pub absent: Vec<AbsentRow>,
    /// Kernel × width × threads: throughput.
    pub speed: Vec<SpeedRow>,
    /// Width × threads: the same timed loop, with a test that is one comparison and never holds. So much of each time
    /// in `speed` is the loop itself. `id` is `loop`.
    pub loops: Vec<SpeedRow>,
    /// Measured throughput of eight-lane operations.
    pub rates: Vec<RateRow>,
    /// The regimes: workloads that get harder step by step.
    pub regimes: Vec<RegimeRow>,
    /// Kernel × workload, and kernel × regime × severity: errors against the oracle. Both twins of a kernel give the
    /// same bits, so one row describes both.
    pub accuracy: Vec<AccuracyRow>,
    /// Kernel × claim of its family: how often the claim was violated.
    pub claims: Vec<ClaimRow>,
    /// The failure maps: workloads with two severities.
    pub maps: Vec<MapRow>,
    /// Kernel × failure map: errors.
    pub map_cells: Vec<MapCells>,
    /// Scene × rays × kernel: wrong answers on the rays of a picture.
    pub on_scenes: Vec<OnSceneRow>,
    /// Scene × rays × kernel: throughput of the tracer with each kernel.
    pub scene_speed: Vec<SceneSpeedRow>,
    /// The processors for which the other build of the program was made, such as `x86-64-v3`. `null` unless the study
    /// ran with `--build`.
    #[serde(default)]
    pub other_build: Option<String>,
    /// Like `speed`, of the other build. Its processes took turns with those of this build, so groups of samples at the
    /// same place were taken one after the other. Kernels that it lacks have no rows. Hits are equal, else the study
    /// fails.
    #[serde(default)]
    pub other_speed: Vec<SpeedRow>,
    /// Like `scene_speed`, of the other build.
    #[serde(default)]
    pub other_scene_speed: Vec<SceneSpeedRow>,
    /// Scene × rays × mode × threads: throughput of the tracer.
    pub tracer: Vec<TracerRow>,
    /// Scene × jitter × mode: the tracer on less and less coherent rays.
    pub coherence: Vec<CoherenceRow>,
    /// Scene × rays: the tracer on more and more triangles.
    pub scaling: Vec<ScalingRow>,
    /// Scene × rays × tracer configuration × threads, for this crate and its peers. Empty unless the study ran with
    /// `--peers`.
    #[serde(default)]
    pub peers: Vec<PeerRow>,
}
