//! A picture: colours in memory, written as PNG.

use std::path::Path;

use glam::Vec3;

use super::camera::block_order;
use crate::error::Error;
use crate::files::write_atomically;

/// Colours, row by row from the upper left: linear red, green and blue from 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) pixels: Vec<Vec3>,
}

impl Picture {
    /// A picture from one colour per ray, in the order of [`Camera::rays`](super::camera::Camera::rays).
    ///
    /// # Panics
    /// If there is not one colour for each pixel.
    pub fn from_rays(width: u32, height: u32, colors: &[Vec3]) -> Self {
        assert_eq!(colors.len(), width as usize * height as usize, "one colour for each pixel");
        let mut pixels = vec![Vec3::ZERO; colors.len()];
        for (pixel, color) in block_order(width, height).into_iter().zip(colors) {
            pixels[pixel as usize] = *color;
        }
        Self { width, height, pixels }
    }

    /// The colours, row by row from the upper left: linear red, green and blue, from 0 to 1 where the light is not
    /// brighter than that.
    pub fn pixels(&self) -> &[Vec3] {
        &self.pixels
    }

    /// Writes a PNG file in sRGB, eight bits per channel. Colours outside 0 to 1 are clamped; NaN becomes 0.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        let bytes = self.pixels.iter().flat_map(|color| color.to_array().map(srgb_byte)).collect();
        let image = image::RgbImage::from_raw(self.width, self.height, bytes).expect("three bytes for each pixel");
        let mut png = Vec::new();
        let encoder = image::codecs::png::PngEncoder::new(&mut png);
        image.write_with_encoder(encoder).expect("an RGB picture in memory can always be encoded");
        write_atomically(path, |file| file.write_all(&png))
    }
}

/// The sRGB byte of a linear intensity.
fn srgb_byte(linear: f32) -> u8 {
    let linear = linear.clamp(0.0, 1.0);
    let encoded = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0 + 0.5) as u8
}
