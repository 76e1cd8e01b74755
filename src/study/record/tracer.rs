//! Rows about the tracer: throughput, coherence of the rays, size of the scene.

use serde::{Deserialize, Serialize};

use super::samples::Samples;

/// Throughput of the tracer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct TracerRow {
    /// Scene name.
    pub scene: String,
    /// Number of triangles and quadrics. Each counts once, however many instances it has.
    pub triangles: usize,
    /// Number of instances.
    pub instances: usize,
    /// `primary`, `shadow`, `bounce` or `ambient occlusion`, as made by [`ray_sets`](crate::study::ray_sets::ray_sets).
    pub rays: String,
    /// Number of rays.
    pub ray_count: usize,
    /// Number of rays that hit.
    pub hits: usize,
    /// `scalar`, `single`, `packet` or `auto`.
    pub mode: String,
    /// Kernel ID.
    pub kernel: String,
    /// Number of threads.
    pub threads: usize,
    /// Million rays per second: median of the samples.
    pub mrays_per_second: f64,
    /// Median absolute deviation of the samples.
    pub mrays_per_second_mad: f64,
    /// The samples in wall nanoseconds per ray, with four significant digits: a list for the one process that takes
    /// them, in the order of the rounds. Rows with the same scene and rays were timed in the same rounds.
    pub ns_of_rounds: Samples,
    /// Seconds to build the scene's BVH, on all threads.
    pub build_seconds: f64,
    /// Bytes of meshes, instances, prepared primitives and nodes, divided by [`TracerRow::triangles`].
    pub bytes_per_triangle: f64,
    /// Hash of the bits of every hit. It is equal for all modes and thread counts, else the study fails.
    pub checksum: String,
}

/// The answers of one kernel on the rays of a picture, compared with the exact ones of the whole scene.
///
/// A ray ends at the first solid hit: inside a primitive, or on an edge or a vertex that several triangles of an
/// instance share and all turn the same side to. A boundary before it, such as a silhouette, may be reported or not.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct OnSceneRow {
    /// Scene name.
    pub scene: String,
    /// Set of rays: as in [`TracerRow::rays`], or `edges`: from the eye at random points on edges that it sees.
    pub rays: String,
    /// Kernel ID. The other shapes of the scene use the tracer's own kernels.
    pub kernel: String,
    /// Number of rays: the base of all rates.
    pub ray_count: u64,
    /// Rays that exactly end at a solid hit.
    pub solid: u64,
    /// Rays that only touch boundaries, so that either answer is right.
    pub open: u64,
    /// Rays that end at a surface, but are reported to miss it: to hit nothing, or something farther away.
    pub lost: u64,
    /// Rays that are reported to hit something that they exactly miss.
    pub false_hits: u64,
    /// Rays that are reported to hit a triangle which they exactly miss, but which has a vertex in common with the
    /// right one. The place is right up to rounding. Not counted in `false_hits`.
    pub neighbours: u64,
    /// Rays whose hit is right, but displaced by more than a thousandth of its distance from the ray's origin, or of
    /// the diagonal of the instance's box in the world where that is less.
    #[serde(default)]
    pub displaced: u64,
    /// This displacement along the ray, relative to the same length: 99 % of the right hits have at most this. Zero in
    /// sets of any hit.
    #[serde(default)]
    pub displacement_p99: f64,
    /// Hash of the bits of every hit.
    pub checksum: String,
}

impl OnSceneRow {
    /// Rays whose answer is wrong: lost, false, or displaced.
    pub(crate) fn wrong(&self) -> u64 {
        self.lost + self.false_hits + self.displaced
    }
}

/// Throughput of the tracer with one kernel on the rays of a picture. Mode auto, one thread.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct SceneSpeedRow {
    /// Scene name.
    pub scene: String,
    /// Set of rays, as in [`TracerRow::rays`]. The picture is smaller than the one whose answers are judged.
    pub rays: String,
    /// Kernel ID.
    pub kernel: String,
    /// Wall nanoseconds per ray: median of the samples.
    pub ns_per_ray: f64,
    /// Lower end of its interval.
    pub ns_per_ray_low: f64,
    /// Upper end of its interval.
    pub ns_per_ray_high: f64,
    /// `1e3 / ns_per_ray`.
    pub mrays_per_second: f64,
    /// All samples of `ns_per_ray`, as in [`SpeedRow::ns_of_rounds`](super::SpeedRow::ns_of_rounds).
    pub ns_of_rounds: Samples,
    /// Hash of the bits of every hit. It is equal in all processes, else the study fails.
    pub checksum: String,
}

/// Throughput of the tracer on the rays of a picture, each turned at random. Closest hit, one thread.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct CoherenceRow {
    /// Scene name.
    pub scene: String,
    /// How far the rays were turned, from 0 (the rays of the picture) to 1 (random directions).
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
    /// Nodes visited by all rays together, counted in a run that is not timed. A packet's visit counts once. Zero in
    /// modes that do not count, as in the next three fields.
    pub nodes: u64,
    /// Leaves visited, counted in the same way.
    pub leaves: u64,
    /// Eight-wide triangle tests.
    pub tests: u64,
    /// Lanes of these tests in which an active ray met a triangle: at most eight per test.
    pub lanes: u64,
    /// Hash of the bits of every hit. It is equal for all modes, else the study fails.
    pub checksum: String,
}

/// Cost of a ray in a scene that exists in several sizes. Mode auto, one thread.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ScalingRow {
    /// Scene name.
    pub scene: String,
    /// Number of triangles.
    pub triangles: usize,
    /// Set of rays, as in [`TracerRow::rays`].
    pub rays: String,
    /// Number of rays.
    pub ray_count: usize,
    /// Number of rays that hit.
    pub hits: usize,
    /// Kernel ID.
    pub kernel: String,
    /// Wall nanoseconds per ray: median of the samples.
    pub ns_per_ray: f64,
    /// Median absolute deviation of the samples.
    pub ns_per_ray_mad: f64,
    /// Seconds to build the scene, on all threads.
    pub build_seconds: f64,
    /// Bytes of mesh, prepared triangles and nodes, per triangle.
    pub bytes_per_triangle: f64,
    /// Hash of the bits of every hit.
    pub checksum: String,
}
