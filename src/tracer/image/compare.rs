//! Comparison of two kernels on one picture: where their hits differ.

use glam::Vec3;

use super::camera::block_order;
use super::picture::Picture;
use super::shot::Shot;
use crate::geom::Hit;

/// Numbers of pixels where two kernels disagree. Each pixel counts at most once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Differences {
    /// Only the first kernel hits.
    pub only_first: usize,
    /// Only the second kernel hits.
    pub only_second: usize,
    /// Both hit, but different primitives or instances.
    pub other_primitive: usize,
    /// Both hit the same primitive, but the bits of `t` differ.
    pub other_t: usize,
}

impl Differences {
    /// Number of pixels that [`compare`] marks: all differences except those in `t` alone.
    pub fn marked(&self) -> usize {
        self.only_first + self.only_second + self.other_primitive
    }
}

/// Darkens a picture to grey and marks the pixels where two kernels disagree: red where only the first hits, blue where
/// only the second hits, yellow where they hit different primitives.
///
/// Pixels that differ in `t` alone are counted but not marked: `t` differs nearly everywhere, by an ulp or two.
///
/// `first` and `second` are the hits of both kernels, in the order of [`Camera::rays`](super::Camera::rays).
pub fn compare(shot: &Shot, picture: &Picture, first: &[Hit<f32>], second: &[Hit<f32>]) -> (Picture, Differences) {
    let mut differences = Differences::default();
    let mut marked = picture.clone();
    for pixel in &mut marked.pixels {
        *pixel = Vec3::splat(0.25 * pixel.element_sum() / 3.0);
    }
    for ((pixel, a), b) in block_order(shot.width, shot.height).into_iter().zip(first).zip(second) {
        let (count, mark) = match (a.mask, b.mask) {
            (true, false) => (&mut differences.only_first, Some(Vec3::X)),
            (false, true) => (&mut differences.only_second, Some(Vec3::new(0.1, 0.4, 1.0))),
            (true, true) if (a.instance, a.primitive) != (b.instance, b.primitive) => {
                (&mut differences.other_primitive, Some(Vec3::new(1.0, 1.0, 0.0)))
            }
            (true, true) if a.t.to_bits() != b.t.to_bits() => (&mut differences.other_t, None),
            _ => continue,
        };
        *count += 1;
        if let Some(mark) = mark {
            marked.pixels[pixel as usize] = mark;
        }
    }
    (marked, differences)
}

/// Marks in magenta the pixels whose colours in two pictures differ by more than a hundredth, unless [`compare`] has
/// marked them: most of them are in the shadow in one picture only. Returns their number. All pictures have one size.
pub fn mark_colors(marked: &mut Picture, first: &Picture, second: &Picture) -> usize {
    const MAGENTA: Vec3 = Vec3::new(1.0, 0.0, 1.0);
    let is_grey = |pixel: &Vec3| pixel.x == pixel.y && pixel.y == pixel.z;
    let colors = first.pixels.iter().zip(&second.pixels);
    let differ = |(a, b): (&Vec3, &Vec3)| (a - b).abs().max_element() > 0.01;
    let pixels = marked.pixels.iter_mut().zip(colors).filter(|(pixel, colors)| is_grey(pixel) && differ(*colors));
    pixels.map(|(pixel, _)| *pixel = MAGENTA).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracer::image::camera::Camera;
    use crate::tracer::image::view::Light;
    use crate::tracer::trace::Mode;

    fn hit(primitive: u32, instance: u32, t: f32) -> Hit<f32> {
        Hit { mask: true, t, u: 0.0, v: 0.0, primitive, instance }
    }

    #[test]
    fn differences_are_counted_and_marked() {
        let camera = Camera::new(Vec3::Z, Vec3::ZERO, 40.0, 3, 2);
        let shot = Shot { camera, light: Light::Point(Vec3::ONE), mode: Mode::Scalar, width: 3, height: 2 };
        let white = Picture { width: 3, height: 2, pixels: vec![Vec3::ONE; 6] };
        let one = hit(0, 0, 1.0);
        let first = [one, one, Hit::MISS, one, one, Hit::MISS];
        let second = [one, Hit::MISS, one, hit(0, 1, 1.0), hit(0, 0, 2.0), Hit::MISS];
        let (marked, differences) = compare(&shot, &white, &first, &second);
        assert_eq!(differences, Differences { only_first: 1, only_second: 1, other_primitive: 1, other_t: 1 });
        assert_eq!(differences.marked(), 3);
        let mut colors = [white.clone(), white.clone()];
        colors[1].pixels[0] = Vec3::new(1.0, 0.98, 1.0); // a pixel that is not marked
        colors[1].pixels[1] = Vec3::ZERO; // one that is
        colors[1].pixels[5] = Vec3::splat(0.995); // hardly another colour
        let mut shadows = marked.clone();
        assert_eq!(mark_colors(&mut shadows, &colors[0], &colors[1]), 1);
        assert_eq!(shadows.pixels[..2], [Vec3::new(1.0, 0.0, 1.0), Vec3::X]);
        let grey = marked.pixels.iter().filter(|pixel| **pixel == Vec3::splat(0.25)).count();
        assert_eq!((grey, marked.pixels[1]), (3, Vec3::X));
    }
}
