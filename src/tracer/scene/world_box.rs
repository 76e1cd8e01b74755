//! The box of an instance in the world. It contains the exact image of the object in spite of rounding.

use glam::{Affine3, Vec3};

use crate::geom::Aabb;
use crate::tracer::meshes::two_sum;

/// A box that contains the exact image of the box `object` under the affine transform. `object` must not be empty.
///
/// Each side is at most a few `f32` further out than the outermost transformed corner. The identity gives `object`
/// itself. A side beyond the range of `f32` is infinite.
pub(crate) fn world_box(object: &Aabb, object_to_world: &Affine3) -> Aabb {
    let (rows, translation) = (object_to_world.matrix3.transpose(), object_to_world.translation);
    let sides = [0, 1, 2].map(|axis| {
        let factors = rows.col(axis).to_array().map(f64::from);
        let (lo, hi) = (object.lo.to_array().map(f64::from), object.hi.to_array().map(f64::from));
        // Products of two f32 are exact in f64.
        let products = [0, 1, 2].map(|j| (factors[j] * lo[j], factors[j] * hi[j]));
        let least = products.map(|(a, b)| a.min(b));
        let greatest = products.map(|(a, b)| a.max(b));
        let translation = f64::from(translation[axis]);
        // A lower bound of x is the negative of an upper bound of -x.
        (-upper_bound(-translation, least.map(|product| -product)), upper_bound(translation, greatest))
    });
    Aabb { lo: Vec3::from_array(sides.map(|side| side.0)), hi: Vec3::from_array(sides.map(|side| side.1)) }
}

/// An upper bound of the exact sum: the smallest `f32` that is one, or at most a few `f32` larger.
fn upper_bound(first: f64, others: [f64; 3]) -> f32 {
    // The exact sum is the rounded sum plus the exact errors of the additions.
    let (mut sum, mut error) = (first, 0.0);
    for term in others {
        let (rounded, lost) = two_sum(sum, term);
        (sum, error) = (rounded, error + lost.abs());
    }
    // The error is usually zero. If not, twice the error also covers the rounding in the sum of errors, and `next_up`
    // covers the rounding of the last addition.
    let bound = if error > 0.0 { (sum + 2.0 * error).next_up() } else { sum };
    let nearest = bound as f32;
    if f64::from(nearest) < bound { nearest.next_up() } else { nearest }
}

#[cfg(test)]
mod tests {
    use glam::{Mat3, Vec3Swizzles};

    use super::*;

    /// Compares with exact integers: factors and corners are in steps of 2⁻¹², and translations are so large that `f64`
    /// cannot hold the sum.
    #[test]
    fn world_boxes_contain_the_exact_image_and_hardly_more() {
        let mut state = 1u32;
        let mut random = |bits: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            ((state >> 8) as i32 >> (24 - bits)) - (1 << (bits - 1))
        };
        let step = 1.0 / 4096.0;
        let mut inexact = 0;
        for round in 0..20_000 {
            let linear = [(); 9].map(|()| random(14));
            let corners = [(); 3].map(|()| {
                let (a, b) = (random(14), random(14));
                (a.min(b), a.max(b))
            });
            // 24 bits; the value of the last bit is 1 or 2¹³.
            let unit = if round % 2 == 0 { 1 } else { 1 << 13 };
            let translation = [(); 3].map(|()| random(24));
            let object = Aabb {
                lo: Vec3::from_array(corners.map(|corner| corner.0 as f32 * step)),
                hi: Vec3::from_array(corners.map(|corner| corner.1 as f32 * step)),
            };
            let transform = Affine3 {
                matrix3: Mat3::from_cols_array(&linear.map(|entry| entry as f32 * step)),
                translation: Vec3::from_array(translation.map(|entry| entry as f32 * unit as f32)),
            };
            let bounds = world_box(&object, &transform);
            for axis in 0..3 {
                let mut exact = [(i128::from(translation[axis]) * unit) << 24; 2];
                for column in 0..3 {
                    let factor = i128::from(linear[3 * column + axis]);
                    let products = [corners[column].0, corners[column].1].map(|corner| factor * i128::from(corner));
                    exact[0] += products[0].min(products[1]);
                    exact[1] += products[0].max(products[1]);
                }
                let scaled = |side: f32| f64::from(side) * 16_777_216.0;
                let (lo, hi) = (bounds.lo[axis], bounds.hi[axis]);
                assert!(scaled(lo).ceil() as i128 <= exact[0], "{transform:?} of {object:?}: {bounds:?}");
                assert!(scaled(hi).floor() as i128 >= exact[1], "{transform:?} of {object:?}: {bounds:?}");
                let inside = [lo.next_up().next_up(), hi.next_down().next_down()].map(scaled);
                assert!(
                    inside[0].floor() as i128 > exact[0] - 1 && (inside[1].ceil() as i128) < exact[1] + 1,
                    "{bounds:?}"
                );
                inexact += u32::from((exact[0] as f64) as i128 != exact[0]);
            }
        }
        assert!(inexact > 10_000, "{inexact}");
    }

    #[test]
    fn identity_and_rotations_by_right_angles_are_exact() {
        let object = Aabb { lo: Vec3::new(-0.1, 1e-45, 3.0), hi: Vec3::new(0.3, 1e30, f32::MAX) };
        assert_eq!(world_box(&object, &Affine3::IDENTITY), object);
        let rotation = Affine3::from_mat3(Mat3::from_cols(Vec3::Y, Vec3::Z, Vec3::X));
        assert_eq!(world_box(&object, &rotation), Aabb { lo: object.lo.zxy(), hi: object.hi.zxy() });
        let scale = -8_589_934_592.0; // a power of two, so 3 times it is an f32
        let beyond = world_box(&object, &Affine3::from_scale(Vec3::splat(scale)));
        assert_eq!((beyond.lo.z, beyond.lo.y, beyond.hi.z), (f32::NEG_INFINITY, f32::NEG_INFINITY, 3.0 * scale));
    }
}
