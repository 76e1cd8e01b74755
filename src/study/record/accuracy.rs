//! Rows about errors: workloads, regimes, failure maps and claims.

use serde::{Deserialize, Serialize};

use super::hit_errors::HitErrors;

/// Errors of one kernel on one workload.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct AccuracyRow {
    /// Kernel ID.
    pub id: String,
    /// `generic`, `edge`, or the name of a regime of the kernel's family.
    pub workload: String,
    /// Severity of the regime; `null` for the other workloads.
    pub severity: Option<f64>,
    /// Number of rays. Each is tested against one primitive, or against a small mesh in the edge-aimed triangle
    /// workloads.
    pub rays: u64,
    /// Number of ray-primitive pairs that were compared with the oracle.
    pub tests: u64,
    /// Pairs that exactly hit, strictly inside; the base of `false_miss_per_million`.
    pub exact_hits: u64,
    /// Pairs that exactly miss; the base of `false_hit_per_million`.
    pub exact_misses: u64,
    /// Strict hits reported as misses, per million strict hits.
    pub false_miss_per_million: f64,
    /// Misses reported as hits, per million misses.
    pub false_hit_per_million: f64,
    /// Rays that exactly hit a boundary (an edge or a vertex, for example) and are reported to hit nothing.
    pub boundary_none: u64,
    /// Rays that exactly hit a boundary and are reported to hit once.
    pub boundary_one: u64,
    /// Rays that exactly hit a boundary and are reported to hit more than once.
    pub boundary_many: u64,
    /// Rays that exactly hit the mesh, edges included; the base of `leak_per_million`. Zero where there is no mesh.
    pub mesh_hits: u64,
    /// Rays that exactly hit the mesh and are reported to hit nothing, per million.
    pub leak_per_million: f64,
    /// Rays that exactly hit one triangle, strictly inside, and no other; the base of `double_per_million`.
    pub single_hits: u64,
    /// Rays that exactly hit one triangle, strictly inside, and no other, but are reported to hit two or more, per
    /// million.
    #[serde(rename = "double_per_million")]
    pub double_hit_per_million: f64,
    /// Rays that start outside a closed mesh and are aimed past its silhouette; the base of `odd_per_million`. Zero in
    /// other workloads.
    #[serde(default)]
    pub crossing_rays: u64,
    /// Rays reported to hit an odd number of the triangles of a closed mesh, per million.
    #[serde(default)]
    pub odd_per_million: f64,
    /// Rays that exactly hit two or more shapes, all strictly inside. The two least `t` differ, also when rounded to
    /// `f32`. The base of `wrong_closest_per_million`. Zero where no shapes lie one behind the other.
    #[serde(default)]
    pub closest_rays: u64,
    /// Rays whose least reported `t` is not that of the closest shape, or that are reported to hit nothing, per
    /// million. Between equal `t`, the shape with the lower number counts.
    #[serde(default)]
    pub wrong_closest_per_million: f64,
    /// Reported hits that were held to the shape's own box; the base of the next two rates. Zero in other workloads.
    #[serde(default)]
    pub box_hits: u64,
    /// Reported hits of rays that miss the shape's own padded box, per million. The box rule rejects them.
    #[serde(default)]
    pub box_rejected_per_million: f64,
    /// Reported hits whose `t` is less than the entry into the shape's own box, or greater than the padded exit, per
    /// million. The box rule clamps them.
    #[serde(default)]
    pub box_clamped_per_million: f64,
    /// Pairs that hit both exactly and as reported; the base of the errors below. Pairs whose `t` is clipped to the
    /// start of the ray's interval are left out: their `t` is exact.
    pub agreed_hits: u64,
    /// Distance of `t` from the correctly rounded value, in representable numbers: median.
    pub t_ulp_p50: u64,
    /// Distance of `t` from the correctly rounded value, in representable numbers: 99th percentile.
    pub t_ulp_p99: u64,
    /// Distance of `t` from the correctly rounded value, in representable numbers: maximum.
    pub t_ulp_max: u64,
    /// Hits whose `t` is off by more than 1 %, per million agreed hits.
    pub gross_per_million: f64,
    /// Absolute error of `u` and `v`, or of a box's exit distance: 99th percentile.
    pub uv_error_p99: f64,
    /// Absolute error of `u` and `v`, or of a box's exit distance: maximum.
    pub uv_error_max: f64,
    /// Errors of points and normals, and of rays that leave them.
    #[serde(flatten)]
    pub hit_errors: HitErrors,
}

/// A regime: a workload that gets harder step by step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct RegimeRow {
    /// The kernels that it is for: a family, such as `triangle`, or instances of one, such as `instance of triangle`.
    pub family: String,
    /// Name, unique within the family, such as `grazing`.
    pub name: String,
    /// What the rays are, and what to look for.
    pub about: String,
    /// What a severity measures, with its unit: the title of an axis.
    pub axis: String,
    /// The severities, from easy to hard. All are positive, except that the last one may be zero.
    pub steps: Vec<f64>,
    /// Whether the rays are aimed at meshes, where they can leak.
    pub mesh: bool,
    /// What is counted besides wrong answers of single tests: `tests` (nothing else), `mesh` (leaks and double hits),
    /// `crossings` (odd numbers of hits), `closest` (wrong closest hits) or `boxes` (hits outside the shape's own box).
    #[serde(default)]
    pub counts: String,
}

/// A failure map: a workload with two severities.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct MapRow {
    /// The kernels that it is for, as in [`RegimeRow::family`].
    pub family: String,
    /// Name, unique within the family, such as `offset-aspect`.
    pub name: String,
    /// Title of the horizontal axis, with its unit.
    pub x_axis: String,
    /// Severities along the horizontal axis, from left to right: positive, in equal ratios.
    pub x: Vec<f64>,
    /// Title of the vertical axis, with its unit.
    pub y_axis: String,
    /// Severities along the vertical axis, from the bottom up: positive, in equal ratios.
    pub y: Vec<f64>,
    /// For each cell, the rays that exactly hit, strictly inside. The order is that of [`MapCells::t_ulp_p99`]. The
    /// number is the same in every cell, or smaller where few rays hit: a thin shape may have no inside left once it is
    /// rounded.
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
    /// Error of `t` in ulp for each cell: 99 % of the rays have at most this error. A miss counts as an infinite error.
    /// Cells are listed row by row from the bottom up, and from left to right within a row. `null` where more than 1 %
    /// of the rays miss, or where no ray hits.
    pub t_ulp_p99: Vec<Option<u64>>,
}

/// How often a kernel violates a claim, whether it makes the claim or not.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ClaimRow {
    /// Kernel ID.
    pub id: String,
    /// Name of the claim.
    pub claim: String,
    /// Whether the kernel makes the claim.
    pub claimed: bool,
    /// Number of rays that violated it (for boxes: ray-box pairs).
    pub violations: u64,
    /// Number of rays or pairs that were checked.
    pub of: u64,
}
