//! What a study writes: `results.json`, field by field. Tables, charts and the report are generated from it alone.
//!
//! Other programs read it too. `reports/FIELDS.md` is made of the comments below: after a change,
//! `RAYLANES_BLESS=1 cargo test --lib fields` rewrites it.

use serde::{Deserialize, Serialize};

use super::peers::Disagreements;
use crate::kernels::Operations;

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

/// The machine and the build.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Machine {
    /// Processor model.
    pub cpu: String,
    /// Logical processors that the program could use.
    pub processors: usize,
    /// Operating system.
    pub os: String,
    /// Target triple of the build.
    pub target: String,
    /// Target features that were enabled at compile time, sorted.
    pub target_features: Vec<String>,
    /// Compiler version.
    pub rustc: String,
    /// Versions of this crate and of those whose code is measured, as `name version`.
    pub versions: Vec<String>,
}

/// One face of a kernel in one thread, at a glance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct KernelRow {
    /// Kernel ID.
    pub id: String,
    /// What is hit in the end: `aabb`, `triangle` or `quadric`.
    pub shape: String,
    /// `1x1` (scalar), `8x1` (eight rays, one primitive) or `1x8` (one ray, eight primitives).
    pub face: String,
    /// Tests at once: 1 or 8.
    pub width: usize,
    /// Nanoseconds per test of one ray against one primitive, median.
    pub ns_per_test: f64,
    /// Median absolute deviation of the samples.
    pub ns_per_test_mad: f64,
    /// `1e9 / ns_per_test`.
    pub tests_per_second: f64,
    /// Bytes prepared per primitive.
    pub prepared_bytes: usize,
    /// Nanoseconds per ray for its setup, in this width.
    pub setup_ns: f64,
    /// Strict hits reported as misses, per million strict hits, of generic rays.
    pub false_miss_per_million: Option<f64>,
    /// Misses reported as hits, per million misses, of generic rays.
    pub false_hit_per_million: Option<f64>,
    /// Rays that exactly hit a mesh and are reported to hit nothing of it, per million, where that is worst; `null` where
    /// there are no meshes.
    pub leak_per_million: Option<f64>,
    /// Rays that exactly hit one triangle strictly inside and no other, reported to hit several, per million, where that is
    /// worst; `null` where there are no meshes.
    pub double_per_million: Option<f64>,
    /// Error of `t` of generic rays, in ulp: median.
    pub t_ulp_p50: Option<u64>,
    /// 99th percentile.
    pub t_ulp_p99: Option<u64>,
    /// Greatest.
    pub t_ulp_max: Option<u64>,
    /// What the kernel promises.
    pub claims: Vec<String>,
    /// Nanoseconds per test that the busiest class of its operations takes at least; `null` for `1x1`.
    pub limit_ns: Option<f64>,
    /// That class: `multiply`, `add`, `divide`, `load`, or `multiply and add` for all arithmetic together.
    pub limit_by: Option<String>,
    /// `limit_ns / ns_per_test`.
    pub limit_share: Option<f64>,
    /// Hash over the bits of every hit; the same for all faces.
    pub checksum: String,
}

/// A kernel, as it describes itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct MethodRow {
    /// Its ID.
    pub id: String,
    /// Family of its shape: `aabb`, `triangle`, `quadric` or `instance`.
    pub family: String,
    /// The idea in one line.
    pub idea: String,
    /// Authors, title, year.
    pub source: String,
    /// Operations of one test that is computed to its end.
    pub operations: OperationCounts,
    /// Bytes prepared per primitive.
    pub prepared_bytes: usize,
    /// Bytes of per-ray setup, scalar.
    pub setup_bytes: usize,
    /// Nanoseconds per ray for the setup, scalar.
    pub setup_ns: f64,
    /// Nanoseconds per ray for the setup, in a packet of eight.
    pub setup_ns_packet: f64,
    /// What it promises.
    pub claims: Vec<String>,
}

/// Operations; selections, logic and conversions are not counted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct OperationCounts {
    /// Multiplications, of `f32` and `f64` together, as in the next fields.
    pub mul: u32,
    /// Additions and subtractions.
    pub add: u32,
    /// Comparisons, minima and maxima.
    pub compare: u32,
    /// Divisions and square roots.
    pub div: u32,
    /// Multiplications that are fused with an addition; both are counted above.
    pub fused: u32,
    /// Numbers of the prepared primitive that are read.
    pub reads: u32,
    /// Multiplications in `f64`.
    pub mul_f64: u32,
    /// Additions and subtractions in `f64`.
    pub add_f64: u32,
    /// Comparisons, minima and maxima in `f64`.
    pub compare_f64: u32,
    /// Divisions and square roots in `f64`.
    pub div_f64: u32,
}

impl From<Operations> for OperationCounts {
    fn from(Operations { mul, add, compare, div, fused, reads, double }: Operations) -> Self {
        Self {
            mul,
            add,
            compare,
            div,
            fused,
            reads,
            mul_f64: double.mul,
            add_f64: double.add,
            compare_f64: double.compare,
            div_f64: double.div,
        }
    }
}

/// What an operation on eight lanes takes where it waits for no other, in one thread.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct RateRow {
    /// `multiply`, `add` (additions and maxima in turn), `fused`, `divide`, `multiply and add` (in turn, two operations) or
    /// `load`.
    pub operation: String,
    /// `f32` or `f64`.
    pub precision: String,
    /// Nanoseconds for one operation on eight lanes: median of the samples.
    pub ns_per_operation: f64,
    /// Median absolute deviation of the samples.
    pub ns_per_operation_mad: f64,
    /// `1e9 / ns_per_operation`.
    pub operations_per_second: f64,
    /// Number of samples.
    pub samples: usize,
}

/// A kernel that this build has not.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct AbsentRow {
    /// Its ID.
    pub id: String,
    /// What it lacks.
    pub reason: String,
}

/// A workload that gets harder step by step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct RegimeRow {
    /// The kernels that it is for: of a family, `triangle`, or instances, `instance of triangle`.
    pub family: String,
    /// Name, unique within the family: `grazing`.
    pub name: String,
    /// What the rays are and what to look for, in one sentence.
    pub about: String,
    /// What the severities measure, with its unit, as the title of an axis.
    pub axis: String,
    /// The severities, from easy to hard. They are positive, but for a zero that may come last.
    pub steps: Vec<f64>,
    /// Whether its rays are aimed at meshes, in which they can leak.
    pub mesh: bool,
}

/// Whether a kernel keeps, or would keep, a promise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ClaimRow {
    /// Kernel ID.
    pub id: String,
    /// Name of the claim.
    pub claim: String,
    /// Whether the kernel makes it.
    pub claimed: bool,
    /// Rays (pairs of ray and box) that broke it.
    pub violations: u64,
    /// Rays (pairs) that could have.
    pub of: u64,
}

/// A failure map: a workload with two severities.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct MapRow {
    /// The kernels that it is for, as in [`RegimeRow::family`].
    pub family: String,
    /// Name, unique within the family: `offset-aspect`.
    pub name: String,
    /// Title of the horizontal axis, with its unit.
    pub x_axis: String,
    /// Severities along it, from left to right: positive, in equal ratios.
    pub x: Vec<f64>,
    /// Title of the vertical axis, with its unit.
    pub y_axis: String,
    /// Severities along it, from the bottom up: positive, in equal ratios.
    pub y: Vec<f64>,
    /// Rays of each cell that exactly hit strictly inside, in the order of [`MapCells::t_ulp_p99`]. They are as many in
    /// every cell, or fewer where hardly any ray hits: a thin shape may have no inside left once it is rounded.
    pub hits: Vec<u64>,
}

/// A kernel's errors over a failure map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct MapCells {
    /// Kernel ID.
    pub id: String,
    /// Name of the map.
    pub map: String,
    /// Row by row from the bottom up, in each from left to right: the error of `t`, in ulp, that 99 % of the rays do not
    /// exceed, a miss counting as an infinite error. `null` where more than 1 % of the rays miss, or where there are none.
    pub t_ulp_p99: Vec<Option<u64>>,
}

/// Throughput of one face of a kernel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct SpeedRow {
    /// Kernel ID.
    pub id: String,
    /// `1x1` (scalar), `8x1` (eight rays, one primitive) or `1x8` (one ray, eight primitives).
    pub face: String,
    /// Threads that ran it at once.
    pub threads: usize,
    /// Wall nanoseconds per test of one ray against one primitive, all threads together: median of the samples.
    pub ns_per_test: f64,
    /// Median absolute deviation of the samples.
    pub ns_per_test_mad: f64,
    /// `1e9 / ns_per_test`.
    pub tests_per_second: f64,
    /// Number of samples.
    pub samples: usize,
    /// Share of the tests, taken 1 or 8 at once, in which anything was hit.
    pub hit_share: f64,
    /// Hash over the bits of every hit; equal for all faces and thread counts, or the study fails.
    pub checksum: String,
}

/// Errors of one kernel on one workload.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct AccuracyRow {
    /// Kernel ID.
    pub id: String,
    /// `generic`, `edge`, or the name of a regime of the kernel's family.
    pub workload: String,
    /// The regime's severity; `null` for the other workloads.
    pub severity: Option<f64>,
    /// Rays, each against one primitive, or against a small mesh in edge-aimed triangle workloads.
    pub rays: u64,
    /// Pairs of ray and primitive that were compared with the oracle.
    pub tests: u64,
    /// Pairs that exactly hit strictly inside; the base of `false_miss_per_million`.
    pub exact_hits: u64,
    /// Pairs that exactly miss; the base of `false_hit_per_million`.
    pub exact_misses: u64,
    /// Strict hits reported as misses, per million strict hits.
    pub false_miss_per_million: f64,
    /// Misses reported as hits, per million misses.
    pub false_hit_per_million: f64,
    /// Rays that exactly hit a mesh on an edge or a vertex, and are reported to hit nothing of it.
    pub boundary_none: u64,
    /// The same, reported once.
    pub boundary_one: u64,
    /// The same, reported more than once.
    pub boundary_many: u64,
    /// Rays that exactly hit the mesh, edges included; the base of `leak_per_million`. Zero where there is no mesh.
    pub mesh_hits: u64,
    /// Of those, reported to hit nothing, per million.
    pub leak_per_million: f64,
    /// Rays that exactly hit one triangle strictly inside and no other; the base of `double_per_million`.
    pub single_hits: u64,
    /// Of those, reported to hit two or more, per million.
    pub double_per_million: f64,
    /// Pairs that hit both exactly and as reported, save those whose `t` is clipped to the start of the ray's interval and
    /// so exact; the base of the errors below.
    pub agreed_hits: u64,
    /// Distance of `t` from the correctly rounded one, in representable numbers: median.
    pub t_ulp_p50: u64,
    /// 99th percentile.
    pub t_ulp_p99: u64,
    /// Greatest.
    pub t_ulp_max: u64,
    /// Hits whose `t` is off by more than 1 %, per million agreed hits.
    pub gross_per_million: f64,
    /// Absolute error of `u` and `v` (for a box: of the exit distance): 99th percentile.
    pub uv_error_p99: f64,
    /// Greatest.
    pub uv_error_max: f64,
}

/// Throughput of the tracer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct TracerRow {
    /// Scene name.
    pub scene: String,
    /// Triangles and quadrics in it, each counted once whatever its number of instances.
    pub triangles: usize,
    /// Instances of them.
    pub instances: usize,
    /// `primary`, `shadow`, `bounce` or `ambient occlusion`, as made by [`ray_sets`](super::ray_sets::ray_sets).
    pub rays: String,
    /// Number of rays.
    pub ray_count: usize,
    /// Rays that hit.
    pub hits: usize,
    /// `scalar`, `single`, `packet` or `auto`.
    pub mode: String,
    /// Kernel ID.
    pub kernel: String,
    /// Threads.
    pub threads: usize,
    /// Million rays per second: median of the samples.
    pub mrays_per_second: f64,
    /// Median absolute deviation of the samples.
    pub mrays_per_second_mad: f64,
    /// Seconds to build the scene's BVH, all threads.
    pub build_seconds: f64,
    /// Meshes, instances, prepared primitives and nodes, by [`TracerRow::triangles`].
    pub bytes_per_triangle: f64,
    /// Hash over the bits of every hit; equal for all modes and thread counts, or the study fails.
    pub checksum: String,
}

/// Throughput of the tracer on rays of a picture that were turned at random, closest hit, one thread; and what it took, in
/// a run that was not timed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct CoherenceRow {
    /// Scene name.
    pub scene: String,
    /// How far rays were turned: from 0, those of the picture, to 1, at random.
    pub jitter: f64,
    /// `scalar`, `single`, `packet` or `auto`.
    pub mode: String,
    /// Kernel ID.
    pub kernel: String,
    /// Number of rays.
    pub ray_count: u64,
    /// Million rays per second: median of the samples.
    pub mrays_per_second: f64,
    /// Median absolute deviation of the samples.
    pub mrays_per_second_mad: f64,
    /// Nodes visited, all rays together; a packet's visit counts once. Zero, like the next three, in modes that do not count.
    pub nodes: u64,
    /// Leaves visited, likewise.
    pub leaves: u64,
    /// Eight-wide triangle tests.
    pub tests: u64,
    /// Lanes of these tests in which a ray that is still looking met a triangle; at most eight times as many.
    pub lanes: u64,
    /// Hash over the bits of every hit; equal for all modes, or the study fails.
    pub checksum: String,
}

/// Cost of a ray in a scene that comes in several sizes, mode auto, one thread.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ScalingRow {
    /// Scene name.
    pub scene: String,
    /// Triangles in it.
    pub triangles: usize,
    /// As in [`TracerRow::rays`].
    pub rays: String,
    /// Number of rays.
    pub ray_count: usize,
    /// Rays that hit.
    pub hits: usize,
    /// Kernel ID.
    pub kernel: String,
    /// Wall nanoseconds per ray: median of the samples.
    pub ns_per_ray: f64,
    /// Median absolute deviation of the samples.
    pub ns_per_ray_mad: f64,
    /// Seconds to build the scene, all threads.
    pub build_seconds: f64,
    /// Mesh, prepared triangles and nodes.
    pub bytes_per_triangle: f64,
    /// Hash over the bits of every hit.
    pub checksum: String,
}

/// Throughput of one configuration of one tracer, ours or a peer, on a scene of triangles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct PeerRow {
    /// Scene name.
    pub scene: String,
    /// Triangles in it.
    pub triangles: usize,
    /// `primary`, `shadow`, `bounce` or `ambient occlusion`, as made by [`ray_sets`](super::ray_sets::ray_sets).
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
