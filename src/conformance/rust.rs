//! Numbers, vectors and rays as expressions in Rust, equal to the bit.

use glam::{Affine3, Vec3};

use crate::geom::Ray;

/// The shortest expression for this number.
pub(super) fn float(number: f32) -> String {
    if number.to_bits() == f32::NAN.to_bits() {
        "f32::NAN".into()
    } else if number.is_nan() {
        format!("f32::from_bits({:#x})", number.to_bits())
    } else if number.is_infinite() {
        if number > 0.0 { "f32::INFINITY" } else { "f32::NEG_INFINITY" }.into()
    } else {
        format!("{number:?}")
    }
}

pub(super) fn vec3(vector: Vec3) -> String {
    let [x, y, z] = vector.to_array().map(float);
    format!("Vec3::new({x}, {y}, {z})")
}

pub(super) fn ray(ray: &Ray<f32>) -> String {
    let (origin, dir, [t_min, t_max]) = (vec3(ray.origin), vec3(ray.dir), [ray.t_min, ray.t_max].map(float));
    format!("Ray {{ origin: {origin}, dir: {dir}, t_min: {t_min}, t_max: {t_max} }}")
}

pub(super) fn affine(transform: &Affine3) -> String {
    let [x, y, z] = [transform.matrix3.x_axis, transform.matrix3.y_axis, transform.matrix3.z_axis].map(vec3);
    format!("Affine3::from_cols({x}, {y}, {z}, {})", vec3(transform.translation))
}

/// In decimal and in bits.
pub(super) fn decimal_and_hex(number: f32) -> String {
    format!("{number:e} {:08x}", number.to_bits())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn expressions_make_the_same_bits() {
        assert_eq!(
            [f32::NAN, -f32::NAN, f32::NEG_INFINITY, -0.0, 1e-45, f32::MAX, 1.0].map(float),
            ["f32::NAN", "f32::from_bits(0xffc00000)", "f32::NEG_INFINITY", "-0.0", "1e-45", "3.4028235e38", "1.0"]
        );
        assert_eq!(
            ray(&Ray::INACTIVE),
            "Ray { origin: Vec3::new(0.0, 0.0, 0.0), dir: Vec3::new(0.0, 0.0, 1.0), t_min: f32::INFINITY, \
             t_max: f32::NEG_INFINITY }"
        );
    }
}
