//! Random numbers, points and directions for the workloads. Tests use some of them too.
//!
//! Records and pinned errors depend on the bits that these functions return and on how many numbers they draw. The
//! functions use only sums, products, divisions and square roots, which give the same bits on every machine.

use glam::{Mat3, Vec2, Vec3};
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// The generator of one sample. It depends on the arguments alone, so samples can be made in any order and on any
/// thread. `severities` are those of a regime or a map.
pub fn rng(seed: u64, family: &str, workload: &str, severities: &[f32], index: u64) -> Pcg64 {
    let severities = severities.iter().flat_map(|severity| severity.to_bits().to_le_bytes());
    let stream = family
        .bytes()
        .chain(workload.bytes())
        .chain(severities)
        .fold(seed, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3));
    Pcg64::seed_from_u64(stream.wrapping_add(index.wrapping_mul(0x9e37_79b9_7f4a_7c15)))
}

/// 1 or -1.
pub(super) fn sign(rng: &mut Pcg64) -> f32 {
    if rng.random() { 1.0 } else { -1.0 }
}

/// A whole number from `-reach` to `reach`.
pub fn whole(rng: &mut impl Rng, reach: i32) -> f32 {
    rng.random_range(-reach..=reach) as f32
}

/// A point in the cube from `-half` (included) to `half` (excluded), uniformly distributed.
pub fn in_cube(rng: &mut impl Rng, half: f32) -> Vec3 {
    Vec3::from([0; 3].map(|_| rng.random_range(-half..half)))
}

/// A point in the square from `-half` to `half`.
pub(super) fn in_square(rng: &mut Pcg64, half: f32) -> Vec2 {
    Vec2::from([0; 2].map(|_| rng.random_range(-half..half)))
}

/// A point in the unit disc, not next to its centre.
pub(super) fn in_disc(rng: &mut Pcg64) -> Vec2 {
    loop {
        let point = in_square(rng, 1.0);
        if (0.01..1.0).contains(&(point.x * point.x + point.y * point.y)) {
            return point;
        }
    }
}

/// A direction of unit length, uniformly distributed.
pub(in crate::study) fn direction(rng: &mut Pcg64) -> Vec3 {
    loop {
        let inside = in_cube(rng, 1.0);
        if (0.01..1.0).contains(&inside.length_squared()) {
            return inside.normalize();
        }
    }
}

/// A random rotation: three directions at right angles, as columns.
pub(super) fn frame(rng: &mut Pcg64) -> Mat3 {
    let z = direction(rng);
    let x = loop {
        let across = z.cross(direction(rng));
        if across.length_squared() > 0.01 {
            break across.normalize();
        }
    };
    Mat3::from_cols(x, z.cross(x), z)
}
