//! Fields about hits as a renderer meets them. They are fields of each row of `accuracy`.

use serde::{Deserialize, Serialize};

/// Errors of points, normals and rays that leave them, of one kernel on one workload.
// A record that was written before these errors were measured has none of the fields.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct HitErrors {
    /// Agreed hits of one ray in eight: the base of the errors below. An error is `null` if there is no such hit, if it
    /// is infinite, or if the shape has none: only triangles have points from `u` and `v`, and boxes have points only.
    pub measured_hits: u64,
    /// Distance of `origin + t·dir`, computed in `f32`, from the exact hit, in sizes of the primitive: 99th percentile.
    /// The size is the longest edge of a triangle, or the longest side of a box or of a quadric's clip box.
    pub ray_point_size_p99: Option<f64>,
    /// The same distance, relative to the largest coordinate of the ray's origin and of the primitive: 99th percentile.
    pub ray_point_scene_p99: Option<f64>,
    /// Distance of `(1-u-v)·v0 + u·v1 + v·v2`, computed in `f32`, from the exact hit, in sizes of the primitive: 99th
    /// percentile.
    pub uv_point_size_p99: Option<f64>,
    /// The same distance, relative to the largest coordinate of the ray's origin and of the primitive: 99th percentile.
    pub uv_point_scene_p99: Option<f64>,
    /// Height of `origin + t·dir` above or below the exact surface, in sizes of the primitive: 99th percentile. The
    /// surface is the triangle's plane, or the quadric without its clip box.
    pub ray_height_size_p99: Option<f64>,
    /// The same height, relative to the largest coordinate of the ray's origin and of the primitive: 99th percentile.
    pub ray_height_scene_p99: Option<f64>,
    /// Height of `(1-u-v)·v0 + u·v1 + v·v2` above or below the exact plane, in sizes of the primitive: 99th percentile.
    pub uv_height_size_p99: Option<f64>,
    /// The same height, relative to the largest coordinate of the ray's origin and of the primitive: 99th percentile.
    pub uv_height_scene_p99: Option<f64>,
    /// Angle between the normal that the tracer computes for the hit and the exact normal, in rad: 99th percentile. A
    /// triangle's normal does not depend on the hit.
    pub normal_error_p99: Option<f64>,
    /// Backward error of `t`: its error, divided by the error that rounding each number of ray and primitive to `f32`
    /// once can cause (the condition number times 2⁻²⁴). 99th percentile. A stable method stays below about 10, however
    /// hard the input.
    pub t_backward_p99: Option<f64>,
    /// Rays that leave measured hits: the base of the rates below. They have a random direction, with the cosine
    /// distribution, on the side from which the surface was hit. A ray that exactly hits the same quadric elsewhere is
    /// left out.
    pub leaving_rays: u64,
    /// Leaving rays for which the kernel reports another hit of the same primitive, per million. They start where the
    /// tracer puts them: off the surface by its error bound.
    pub own_hit_offset_per_million: f64,
    /// The same, for rays that start at `origin + t·dir`, with a `t_min` of 1e-4 times the largest coordinate. A
    /// `t_min` also hides whatever is nearer.
    pub own_hit_scene_epsilon_per_million: f64,
    /// The same, with a `t_min` of 1e-4 times the length of the ray that hit.
    pub own_hit_t_epsilon_per_million: f64,
    /// The same, with a `t_min` of 0.
    pub own_hit_no_epsilon_per_million: f64,
}
