//! Sizes, distances and colours that all charts share. Lengths are in pixels.

use plotters::prelude::RGBColor;

pub(super) type Pixel = (i32, i32);

pub(super) const INK: RGBColor = RGBColor(40, 40, 40);
pub(super) const FAINT: RGBColor = RGBColor(120, 120, 120);
pub(super) const GRID: RGBColor = RGBColor(228, 228, 228);

/// Minimum width of a chart; long names widen it.
pub(super) const WIDTH: i32 = 1060;
pub(super) const LEFT: i32 = 66;
pub(super) const MARGIN: i32 = 16;
pub(super) const TEXT: f64 = 13.0;
pub(super) const TITLE: f64 = 18.0;
/// Distance from one line of text to the next.
pub(super) const LINE: i32 = 17;
/// Width of a character of [`TEXT`] size in the widest of the common monospaced fonts.
pub(super) const ADVANCE: f64 = 0.605 * TEXT;
/// Average width of a character of a proportional font, as a share of its size. A generous estimate. Bold text is
/// wider.
pub(super) const PROPORTIONAL: f64 = 0.58;
