//! Sizes, distances and colours that all charts share, in pixels.

use plotters::prelude::RGBColor;

pub(super) type Pixel = (i32, i32);

pub(super) const INK: RGBColor = RGBColor(40, 40, 40);
pub(super) const FAINT: RGBColor = RGBColor(120, 120, 120);
pub(super) const GRID: RGBColor = RGBColor(228, 228, 228);

/// Charts are at least this wide; long names widen them.
pub(super) const WIDTH: i32 = 1060;
pub(super) const LEFT: i32 = 66;
pub(super) const MARGIN: i32 = 16;
pub(super) const TEXT: f64 = 13.0;
pub(super) const TITLE: f64 = 18.0;
/// From one line of text to the next.
pub(super) const LINE: i32 = 17;
/// Advance of a character of [`TEXT`] size in the widest of the common monospaced faces.
pub(super) const ADVANCE: f64 = 0.605 * TEXT;
/// The same of a proportional face, on average over a line, generously; bold is wider.
pub(super) const PROPORTIONAL: f64 = 0.58;
