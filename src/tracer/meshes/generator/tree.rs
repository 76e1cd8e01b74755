//! A fir, one unit high: a surface of revolution about the `y` axis with a rough crown.

use glam::{DVec2, DVec3, Vec3};

use super::hash::hash;
use crate::tracer::meshes::{Mesh, Part};

/// Radius and height along the outline: from the foot of the trunk over three tiers of branches to the tip.
const OUTLINE: [DVec2; 9] = [
    DVec2::new(0.030, 0.00),
    DVec2::new(0.025, 0.14),
    DVec2::new(0.230, 0.10),
    DVec2::new(0.090, 0.40),
    DVec2::new(0.180, 0.36),
    DVec2::new(0.065, 0.64),
    DVec2::new(0.120, 0.61),
    DVec2::new(0.035, 0.84),
    DVec2::new(0.010, 0.97),
];
/// Number of outline pieces, from the foot, that are bark.
const TRUNK_PIECES: u32 = 1;
const BARK: Vec3 = Vec3::new(0.24, 0.15, 0.09);
const NEEDLES: Vec3 = Vec3::new(0.09, 0.22, 0.08);
/// Largest random change of a crown point's radius, relative to that radius.
const ROUGHNESS: f64 = 0.22;

/// Number of pieces of the outline. Each is divided into `n` bands of `8n` squares.
const PIECES: u32 = OUTLINE.len() as u32 - 1;

/// Number of vertices on a ring.
fn around(n: u32) -> u32 {
    8 * n
}

/// Two triangles per square, and a fan of triangles at the foot and at the tip.
pub(super) fn triangles(n: u32) -> u32 {
    2 * around(n) * (PIECES * n + 1)
}

/// The first vertex is the middle of the foot, the last one the tip. Between them the vertices lie on rings.
pub(super) fn mesh(n: u32) -> Mesh {
    let (around, rings) = (around(n), PIECES * n + 1);
    let mut positions = vec![Vec3::ZERO];
    for ring in 0..rings {
        let (piece, step) = ((ring / n).min(PIECES - 1) as usize, ring % n);
        let along = if ring == rings - 1 { 1.0 } else { f64::from(step) / f64::from(n) };
        let DVec2 { x: radius, y: height } = OUTLINE[piece] + (OUTLINE[piece + 1] - OUTLINE[piece]) * along;
        let is_bark = ring <= TRUNK_PIECES * n;
        positions.extend((0..around).map(|step| {
            let random = f64::from(hash(step, ring, n)) / f64::from(u32::MAX) - 0.5;
            let rough = if is_bark { 1.0 } else { 1.0 + 2.0 * ROUGHNESS * random };
            let out = direction(step, n);
            DVec3::new(out.x * radius * rough, height, out.y * radius * rough).as_vec3()
        }));
    }
    let tip = positions.len() as u32;
    positions.push(Vec3::Y);

    let vertex = |ring: u32, step: u32| 1 + ring * around + step % around;
    let mut triangles: Vec<[u32; 3]> = (0..around).map(|step| [0, vertex(0, step), vertex(0, step + 1)]).collect();
    let mut crown = 0;
    for ring in 1..rings {
        if ring == TRUNK_PIECES * n + 1 {
            crown = triangles.len() as u32;
        }
        for step in 0..around {
            let [a, b] = [step, step + 1].map(|step| vertex(ring - 1, step));
            let [c, d] = [step, step + 1].map(|step| vertex(ring, step));
            triangles.extend([[a, c, b], [b, c, d]]);
        }
    }
    triangles.extend((0..around).map(|step| [vertex(rings - 1, step), tip, vertex(rings - 1, step + 1)]));
    let parts = vec![Part { first_triangle: 0, color: BARK }, Part { first_triangle: crown, color: NEEDLES }];
    Mesh::new(positions, triangles, parts).expect("a tree is a valid mesh")
}

/// The direction of step number `step` of `8n`, clockwise seen from above. Directions go through points evenly spaced
/// on a square.
fn direction(step: u32, n: u32) -> DVec2 {
    let side = 2 * n;
    let (along, n) = (f64::from(step % side), f64::from(n));
    let (across, ahead) = (n - along, n);
    let [x, z] = match step / side {
        0 => [across, ahead],
        1 => [-ahead, across],
        2 => [-across, -ahead],
        _ => [ahead, -across],
    };
    DVec2::new(x, z).normalize()
}
