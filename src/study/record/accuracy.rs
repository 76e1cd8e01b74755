//! Rows about errors: workloads, regimes, failure maps and claims.

use serde::{Deserialize, Serialize};

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
