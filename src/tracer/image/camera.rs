//! A pinhole camera, and the order in which its rays are traced.

use glam::{Affine3, DVec3, Vec3};

use crate::geom::Ray;

/// A pinhole camera. Its rays start at the eye with `t_min = 0`. They are not normalised: at `t = 1` a ray crosses the
/// image plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    eye: Vec3,
    /// From the eye to the middle of the image.
    forward: Vec3,
    /// From the middle of the image to its right edge.
    right: Vec3,
    /// From the middle of the image to its upper edge.
    up: Vec3,
}

impl Camera {
    /// A camera at `eye` that looks at `look_at`. In the picture, y points up; if the camera looks along y, z does.
    ///
    /// `vertical_fov` is the vertical field of view in degrees. `width` and `height` give the aspect ratio. If `eye`
    /// and `look_at` are equal, the camera looks along -z; [`View::check`](super::View::check) refuses such a view.
    pub fn new(eye: Vec3, look_at: Vec3, vertical_fov: f32, width: u32, height: u32) -> Self {
        // In `f64` the square of the distance neither overflows nor vanishes.
        let forward = (look_at.as_dvec3() - eye.as_dvec3()).normalize_or(DVec3::NEG_Z).as_vec3();
        let world_up = if forward.y.abs() > 0.999 { Vec3::Z } else { Vec3::Y };
        let half_height = (vertical_fov.to_radians() * 0.5).tan();
        let right = forward.cross(world_up).normalize();
        let up = right.cross(forward);
        Self { eye, forward, right: right * (half_height * width as f32 / height as f32), up: up * half_height }
    }

    /// The camera after an affine transform. The eye is transformed as a point, the directions as vectors. A transform
    /// that is not a rigid motion distorts the picture.
    #[must_use]
    pub fn transformed(&self, transform: &Affine3) -> Self {
        Self {
            eye: transform.transform_point3(self.eye),
            forward: transform.transform_vector3(self.forward),
            right: transform.transform_vector3(self.right),
            up: transform.transform_vector3(self.up),
        }
    }

    /// One ray through the middle of each pixel of a `width` × `height` picture, in [`block_order`].
    pub fn rays(&self, width: u32, height: u32) -> Vec<Ray<f32>> {
        let offset = |index: u32, count: u32| (index as f32 + 0.5) * (2.0 / count as f32) - 1.0;
        block_order(width, height)
            .into_iter()
            .map(|pixel| {
                let (x, y) = (offset(pixel % width, width), offset(pixel / width, height));
                Ray::new(self.eye, self.forward + self.right * x - self.up * y)
            })
            .collect()
    }
}

/// The order in which the pixels of a picture are traced, as indices `y·width + x` from the upper left.
///
/// Pixels come in blocks of 4 × 2, these in blocks of 8 × 8, and these in tiles of 32 × 32. So eight consecutive rays
/// see nearly the same.
pub fn block_order(width: u32, height: u32) -> Vec<u32> {
    let mut order = Vec::with_capacity(width as usize * height as usize);
    // At the right and lower edges blocks are cut off. Packets there are filled with rays of the next block.
    for_blocks((0, width), (0, height), (32, 32), &mut |tile_x, tile_y| {
        for_blocks(tile_x, tile_y, (8, 8), &mut |block_x, block_y| {
            for_blocks(block_x, block_y, (4, 2), &mut |xs, ys| {
                for y in ys.0..ys.1 {
                    order.extend((xs.0..xs.1).map(|x| y * width + x));
                }
            });
        });
    });
    order
}

/// Calls `visit` with the x and y range of each block of the given size, row by row. Blocks at the end are cut off.
fn for_blocks(xs: (u32, u32), ys: (u32, u32), size: (u32, u32), visit: &mut dyn FnMut((u32, u32), (u32, u32))) {
    for y in (ys.0..ys.1).step_by(size.1 as usize) {
        for x in (xs.0..xs.1).step_by(size.0 as usize) {
            visit((x, xs.1.min(x.saturating_add(size.0))), (y, ys.1.min(y.saturating_add(size.1))));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_is_visited_once() {
        for (width, height) in [(1, 1), (4, 2), (33, 65), (100, 7)] {
            let mut order = block_order(width, height);
            order.sort_unstable();
            assert_eq!(order, (0..width * height).collect::<Vec<_>>());
        }
        assert_eq!(block_order(64, 64)[..10], [0, 1, 2, 3, 64, 65, 66, 67, 4, 5]);
    }

    #[test]
    fn the_picture_is_upright_and_not_mirrored() {
        let camera = Camera::new(Vec3::new(0.0, 0.0, 5.0), Vec3::ZERO, 90.0, 4, 2);
        let rays = camera.rays(4, 2);
        // Upper left: to the left (-x), up (+y), away (-z).
        assert!(rays[0].dir.abs_diff_eq(Vec3::new(-1.5, 0.5, -1.0), 1e-6), "{}", rays[0].dir);
        assert!(rays[7].dir.abs_diff_eq(Vec3::new(1.5, -0.5, -1.0), 1e-6), "{}", rays[7].dir);
    }
}
