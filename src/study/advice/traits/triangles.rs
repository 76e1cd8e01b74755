//! Traits of the triangles alone: aspect, position, correct digits of the normal, zero area.

use glam::Vec3;
use rayon::prelude::*;

use super::{HIGH, LOW, Trait, percent_of, quantile};
use crate::geom::Triangle;
use crate::study::figures::{count, number};
use crate::tracer::{Geometry, World, has_zero_area};

/// The limit of longest edge / smallest height. Regime: triangle, sliver.
const MAX_ASPECT: f64 = 1e3;

/// The limit of a vertex's distance to the origin of the mesh, in longest edges of the triangle. Regime: triangle,
/// offset.
const MAX_OFFSET: f64 = 1e3;

/// The limit of the relative error of a normal in `f32`. Regime: triangle, sliver. Slivers at the limit of the aspect
/// have about this error.
const MAX_NORMAL_ERROR: f64 = 1e-5;

/// The limit of the share of triangles without area. There is no regime for them; it is the share of the rare values.
const MAX_DEGENERATE: f64 = LOW;

/// A triangle that has an area.
struct Measured {
    /// Longest edge by smallest height.
    aspect: f64,
    /// Distance of the farthest vertex to the origin, by the longest edge.
    offset: f64,
    /// Length of the error of the cross product of two edges in `f32`, by the length of the product: at most 1.
    normal_error: f64,
}

impl Measured {
    /// None if the triangle has no area.
    fn of(triangle: &Triangle) -> Option<Self> {
        if has_zero_area(triangle) {
            return None;
        }
        let Triangle { v0, v1, v2 } = *triangle;
        let [a, b, c] = triangle.vertices().map(Vec3::as_dvec3);
        let exact = (b - a).cross(c - a);
        let rounded = (v1 - v0).cross(v2 - v0).as_dvec3();
        let longest = (b - a).length().max((c - a).length()).max((c - b).length());
        Some(Self {
            // The smallest height is the double area by the longest edge.
            aspect: longest * (longest / exact.length()),
            offset: a.length().max(b.length()).max(c.length()) / longest,
            // If the product overflows in f32, the first operand is a NaN, and min returns the other.
            normal_error: ((rounded - exact).length() / exact.length()).min(1.0),
        })
    }
}

/// The traits of all triangles of all meshes; none if there are no triangles.
pub(super) fn traits(world: &World) -> Vec<Trait> {
    let all = world.triangles();
    if all == 0 {
        return Vec::new();
    }
    let mut measured = Vec::new();
    for geometry in world.geometries() {
        if let Geometry::Mesh(mesh) = geometry {
            let triangles = (0..mesh.len() as u32).into_par_iter();
            measured.par_extend(triangles.filter_map(|number| Measured::of(&mesh.triangle(number))));
        }
    }
    let degenerate = all - measured.len();
    let mut traits = vec![Trait::above(
        MAX_DEGENERATE,
        "triangles without area",
        degenerate as f64 / all as f64,
        format!("{} of {} triangles have no area", count(degenerate as u64), count(all as u64)),
        "no ray hits them, but rounding may give them an area",
    )];
    if !measured.is_empty() {
        let column = |of: fn(&Measured) -> f64| measured.iter().map(of).collect();
        traits.push(aspect(column(|triangle| triangle.aspect)));
        traits.push(normal_error(column(|triangle| triangle.normal_error)));
        traits.push(offset(column(|triangle| triangle.offset)));
    }
    traits
}

fn aspect(mut aspects: Vec<f64>) -> Trait {
    let slivers = percent_of(&aspects, |aspect| aspect > MAX_ASPECT);
    let [median, most, high, greatest] = [0.5, 0.99, HIGH, 1.0].map(|share| quantile(&mut aspects, share));
    let [median_text, most, high_text, greatest] = [median, most, high, greatest].map(|aspect| number(aspect, 2));
    Trait::above(
        MAX_ASPECT,
        "slivers",
        high,
        format!(
            "longest edge / smallest height: median {median_text}, 99 % {most}, 99.9 % {high_text}, greatest \
             {greatest}; {slivers} are slivers"
        ),
        "normal and determinant cancel, so thin triangles lose hits and get false ones",
    )
}

fn normal_error(mut errors: Vec<f64>) -> Trait {
    let beyond = percent_of(&errors, |error| error > MAX_NORMAL_ERROR);
    let high = quantile(&mut errors, HIGH);
    Trait::above(
        MAX_NORMAL_ERROR,
        "nearly degenerate triangles",
        high,
        format!("the relative error of normals in f32 is up to {} at 99.9 %; {beyond} are worse", number(high, 2)),
        "prepared normals and planes have few correct digits",
    )
}

fn offset(mut offsets: Vec<f64>) -> Trait {
    let [median, high] = [0.5, HIGH].map(|share| quantile(&mut offsets, share));
    Trait::above(
        MAX_OFFSET,
        "small triangles far from the origin",
        high,
        format!(
            "vertices are {} longest edges from the origin in the median, {} at 99.9 %",
            number(median, 2),
            number(high, 2)
        ),
        "prepared planes lose digits: their distance to the origin is rounded relative to itself",
    )
}
