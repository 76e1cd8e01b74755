//! Rows about the tracer: throughput, coherence of the rays, size of the scene.

use serde::{Deserialize, Serialize};

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
    /// `primary`, `shadow`, `bounce` or `ambient occlusion`, as made by [`ray_sets`](crate::study::ray_sets::ray_sets).
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
