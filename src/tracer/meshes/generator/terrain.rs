//! A landscape: a square grid of 100 by 100 units with heights from fractal noise.

use glam::Vec3;

use super::hash::hash;
use crate::tracer::meshes::{Mesh, Part};

const EXTENT: f64 = 100.0;

/// Two triangles per square, `n × n` squares.
pub(super) fn triangles(n: u32) -> u32 {
    2 * n * n
}

pub(super) fn mesh(n: u32) -> Mesh {
    let at = |step: u32| f64::from(step) / f64::from(n);
    let mut positions = Vec::new();
    for row in 0..=n {
        for column in 0..=n {
            let (x, z) = (at(column), at(row));
            positions.push(Vec3::new(((x - 0.5) * EXTENT) as f32, height(x, z) as f32, ((z - 0.5) * EXTENT) as f32));
        }
    }
    let mut triangles = Vec::new();
    for row in 0..n {
        for column in 0..n {
            let here = row * (n + 1) + column;
            let (right, ahead) = (here + 1, here + n + 1);
            triangles.push([here, ahead, right]);
            triangles.push([right, ahead, ahead + 1]);
        }
    }
    let parts = vec![Part { first_triangle: 0, color: Vec3::new(0.45, 0.5, 0.3) }];
    Mesh::new(positions, triangles, parts).expect("a terrain is a valid mesh")
}

/// Height over the unit square: the sum of noise in octaves. Each octave has half the wavelength and half the amplitude
/// of the one before.
fn height(x: f64, z: f64) -> f64 {
    const OCTAVES: u32 = 9;
    let (mut sum, mut frequency, mut amplitude) = (0.0, 4.0, 16.0);
    for octave in 0..OCTAVES {
        sum += amplitude * noise(x * frequency, z * frequency, octave);
        frequency *= 2.0;
        amplitude *= 0.5;
    }
    sum
}

/// Value noise: random values from -½ to ½ at whole coordinates, interpolated smoothly.
fn noise(x: f64, z: f64, octave: u32) -> f64 {
    let (column, row) = (x as u32, z as u32);
    let (along, across) = (smooth(x - f64::from(column)), smooth(z - f64::from(row)));
    let mix = |a: f64, b: f64, weight: f64| a + (b - a) * weight;
    let corner = |dx, dz| random(column + dx, row + dz, octave);
    mix(mix(corner(0, 0), corner(1, 0), along), mix(corner(0, 1), corner(1, 1), along), across)
}

/// Smoothstep: from 0 to 1, with slope 0 at both ends.
fn smooth(x: f64) -> f64 {
    x * x * (3.0 - 2.0 * x)
}

/// The random value, from -½ to ½, at a whole coordinate of an octave.
fn random(x: u32, z: u32, octave: u32) -> f64 {
    f64::from(hash(x, z, octave)) / f64::from(u32::MAX) - 0.5
}
