//! Sizes and distances that all charts share. Lengths are in pixels of a chart at its natural width. A phone shows a
//! chart at about two thirds of it, and text must still be readable there.

pub(super) type Pixel = (i32, i32);

/// Minimum width of a chart; long names widen it.
pub(super) const WIDTH: i32 = 540;
pub(super) const LEFT: i32 = 58;
pub(super) const MARGIN: i32 = 10;
pub(super) const TEXT: f64 = 15.0;
pub(super) const TITLE: f64 = 18.0;
/// Distance from one line of text to the next.
pub(super) const LINE: i32 = 20;
/// Width of a character of [`TEXT`] size in the widest of the common monospaced fonts.
pub(super) const ADVANCE: f64 = 0.605 * TEXT;
/// Average width of a character of a proportional font, as a share of its size. A generous estimate. Bold text is
/// wider.
pub(super) const PROPORTIONAL: f64 = 0.56;

/// Width of a text of [`TEXT`] size in a proportional font: an estimate.
pub(super) fn text_width(text: &str) -> i32 {
    (text.chars().count() as f64 * PROPORTIONAL * TEXT).ceil() as i32
}

/// Width of a kernel name.
pub(super) fn name_width(name: &str) -> i32 {
    (name.chars().count() as f64 * ADVANCE).ceil() as i32
}
