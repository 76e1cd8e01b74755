//! Points and directions with whole coordinates, and what is exact about them.

use std::ops::{Mul, Sub};

use glam::Vec3;

/// A point or a direction.
pub(super) type Int3 = [i64; 3];

pub(super) fn minus<T: Copy + Sub<Output = T>>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `a + b·factor`.
pub(super) fn plus(a: Int3, b: Int3, factor: i64) -> Int3 {
    [a[0] + b[0] * factor, a[1] + b[1] * factor, a[2] + b[2] * factor]
}

pub(super) fn cross<T: Copy + Sub<Output = T> + Mul<Output = T>>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn dot<T: Copy + Into<i128>>(a: [T; 3], b: [T; 3]) -> i128 {
    (0..3).map(|axis| a[axis].into() * b[axis].into()).sum()
}

/// The same point in `f32`.
///
/// # Panics
/// If `f32` cannot hold it exactly.
pub(super) fn exactly(point: Int3) -> Vec3 {
    let rounded = point.map(|x| x as f32);
    assert_eq!(rounded.map(|x| x as i64), point, "{point:?} needs more than 24 bits");
    Vec3::from(rounded)
}

/// Whether `origin + t·dir` passes exactly through `target` at a positive `t`. Differences of points have at most 49
/// bits in their products.
pub(super) fn is_aimed(origin: Int3, dir: Int3, target: Int3) -> bool {
    let way = minus(target, origin);
    cross(way, dir) == [0; 3] && dot(way, dir) > 0
}
