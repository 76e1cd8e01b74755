//! What a study writes: `results.json`, field by field. Tables, charts and the report are generated from it alone.

use serde::{Deserialize, Serialize};

/// Version of the layout below; raised when a field changes its meaning.
pub const SCHEMA: u32 = 1;

/// One study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// [`SCHEMA`].
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
    /// Every registered kernel.
    pub kernels: Vec<KernelRow>,
    /// Kernel × face × threads: throughput.
    pub speed: Vec<SpeedRow>,
    /// Kernel × workload: errors against the oracle. Both twins give the same bits, so there is one row for both.
    pub accuracy: Vec<AccuracyRow>,
    /// Scene × rays × mode × threads.
    pub tracer: Vec<TracerRow>,
}

/// The machine and the build.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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

/// A kernel, as it describes itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct KernelRow {
    /// Its ID.
    pub id: String,
    /// Family of its shape: `aabb`, `triangle` or `instance`.
    pub family: String,
    /// The idea in one line.
    pub idea: String,
    /// Authors, title, year.
    pub source: String,
    /// Multiplications, additions and divisions of one test.
    pub operations: [u32; 3],
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

/// Throughput of one face of a kernel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    /// Hash over the bits of every hit; equal for all faces and thread counts, or the study fails.
    pub checksum: String,
}

/// Errors of one kernel on one workload.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AccuracyRow {
    /// Kernel ID.
    pub id: String,
    /// `generic` or `edge`.
    pub workload: String,
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
pub struct TracerRow {
    /// Scene name.
    pub scene: String,
    /// Triangles in it.
    pub triangles: usize,
    /// `primary` (closest hit) or `shadow` (any hit).
    pub rays: String,
    /// Number of rays.
    pub ray_count: usize,
    /// Rays that hit.
    pub hits: usize,
    /// `scalar` or `packet`.
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
    /// Mesh, prepared triangles and nodes, per triangle.
    pub bytes_per_triangle: f64,
    /// Hash over the bits of every hit; equal for all modes and thread counts, or the study fails.
    pub checksum: String,
}
