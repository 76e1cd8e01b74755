//! Rows about kernels: what they are, and how fast they are.

use serde::{Deserialize, Serialize};

use crate::kernels::Operations;

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

/// A kernel that this build has not.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct AbsentRow {
    /// Its ID.
    pub id: String,
    /// What it lacks.
    pub reason: String,
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
