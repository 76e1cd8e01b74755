//! Rows about kernels: how they describe themselves, and how fast they are.

use serde::{Deserialize, Serialize};

use super::samples::Samples;
use crate::kernels::Operations;

/// One width of a kernel in one thread: the most important figures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct KernelRow {
    /// Kernel ID.
    pub id: String,
    /// The shape that is hit: `aabb`, `triangle` or `quadric`. For an instance, the shape inside it.
    pub shape: String,
    /// `1x1` (scalar), `8x1` (eight rays, one primitive) or `1x8` (one ray, eight primitives).
    #[serde(rename = "face")]
    pub width: String,
    /// Tests at once: 1 or 8.
    #[serde(rename = "width")]
    pub lanes: usize,
    /// Nanoseconds per test of one ray against one primitive, median.
    pub ns_per_test: f64,
    /// Lower end of its interval.
    pub ns_per_test_low: f64,
    /// Upper end of its interval.
    pub ns_per_test_high: f64,
    /// `1e9 / ns_per_test`.
    pub tests_per_second: f64,
    /// Bytes that the kernel prepares per primitive.
    pub prepared_bytes: usize,
    /// Nanoseconds per ray for the setup, at this number of tests at once.
    pub setup_ns: f64,
    /// Strict hits reported as misses, per million strict hits, on generic rays.
    pub false_miss_per_million: Option<f64>,
    /// Misses reported as hits, per million misses, on generic rays.
    pub false_hit_per_million: Option<f64>,
    /// Rays that exactly hit a mesh and are reported to miss it, per million. The worst workload counts, except the one
    /// with T-junctions. `null` where there are no meshes.
    pub leak_per_million: Option<f64>,
    /// Rays that exactly hit one triangle, strictly inside, and no other, but are reported to hit several, per million.
    /// The worst workload counts, except the one with T-junctions. `null` where there are no meshes.
    #[serde(rename = "double_per_million")]
    pub double_hit_per_million: Option<f64>,
    /// Error of `t` on generic rays, in ulp: median.
    pub t_ulp_p50: Option<u64>,
    /// Error of `t` on generic rays, in ulp: 99th percentile.
    pub t_ulp_p99: Option<u64>,
    /// Error of `t` on generic rays, in ulp: maximum.
    pub t_ulp_max: Option<u64>,
    /// What the kernel claims.
    pub claims: Vec<String>,
    /// The limit: the least time in which the machine can do the kernel's busiest class of operations, in nanoseconds
    /// per test. `null` for `1x1`.
    pub limit_ns: Option<f64>,
    /// The busiest class: `multiply`, `add`, `divide`, `load`, or `multiply and add` for all arithmetic together.
    pub limit_by: Option<String>,
    /// `limit_ns / ns_per_test`.
    pub limit_share: Option<f64>,
    /// Hash of the bits of every hit. It is the same for all widths of a kernel.
    pub checksum: String,
}

/// A kernel, as it describes itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct MethodRow {
    /// Kernel ID.
    pub id: String,
    /// Family of its shape: `aabb`, `triangle`, `quadric` or `instance`.
    pub family: String,
    /// The idea in one line.
    pub idea: String,
    /// Authors, title, year.
    pub source: String,
    /// Operations of one test, without early exits.
    pub operations: OperationCounts,
    /// Bytes that the kernel prepares per primitive.
    pub prepared_bytes: usize,
    /// Bytes of a set that it is timed with: 512 rays, 32 prepared primitives, and the hits. A timed pass goes through
    /// one set after the other.
    pub set_bytes: usize,
    /// Bytes of the per-ray setup, scalar.
    pub setup_bytes: usize,
    /// Nanoseconds per ray for the setup, scalar.
    pub setup_ns: f64,
    /// Nanoseconds per ray for the setup, in a packet of eight.
    pub setup_ns_packet: f64,
    /// What the kernel claims.
    pub claims: Vec<String>,
}

/// Numbers of operations. Selections, logic and conversions are not counted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct OperationCounts {
    /// Multiplications, `f32` and `f64` together. The next three fields also count both together.
    pub mul: u32,
    /// Additions and subtractions.
    pub add: u32,
    /// Comparisons, minima and maxima.
    pub compare: u32,
    /// Divisions and square roots.
    pub div: u32,
    /// Fused multiply-adds. Each is also counted once in `mul` and once in `add`.
    pub fused: u32,
    /// Numbers read from the prepared primitive.
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

/// A kernel that this build does not contain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct AbsentRow {
    /// Kernel ID.
    pub id: String,
    /// What the build lacks.
    pub reason: String,
}

/// Throughput of one width of a kernel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct SpeedRow {
    /// Kernel ID.
    pub id: String,
    /// `1x1` (scalar), `8x1` (eight rays, one primitive) or `1x8` (one ray, eight primitives).
    #[serde(rename = "face")]
    pub width: String,
    /// Number of threads that ran it at the same time.
    pub threads: usize,
    /// Wall nanoseconds per test of one ray against one primitive, all threads together: median of the samples.
    pub ns_per_test: f64,
    /// Lower end of its interval.
    pub ns_per_test_low: f64,
    /// Upper end of its interval.
    pub ns_per_test_high: f64,
    /// `1e9 / ns_per_test`.
    pub tests_per_second: f64,
    /// Share of the calls (1 or 8 tests each) in which anything was hit.
    pub hit_share: f64,
    /// All samples of `ns_per_test`, with four significant digits: a list for each process that timed the kernels, in
    /// the order of the rounds. All rows were timed in the same processes and rounds, so samples at the same place can
    /// be compared. Two rows tie if the interval of the median of their ratios contains 1.
    pub ns_of_rounds: Samples,
    /// Hash of the bits of every hit. It is equal for all widths, thread counts and processes, else the study fails.
    pub checksum: String,
}

/// Measured throughput of one eight-lane operation in one thread, where no operation waits for another.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct RateRow {
    /// `multiply`, `add` (alternating additions and maxima), `fused`, `divide`, `multiply and add` (alternating,
    /// counted as two operations) or `load`.
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
