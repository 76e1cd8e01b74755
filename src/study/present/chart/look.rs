//! The look of a series: a colour, a dash pattern and the shape of its marks. Each of the three alone tells series
//! apart.

use plotters::prelude::*;

use super::canvas::{Area, Drawn};
use super::layout::{INK, Pixel};
use super::svg::{Dashed, SubjectGroup};

/// The look of the lines and marks of a kernel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Look {
    pub(super) color: RGBColor,
    /// Lengths of dashes and gaps in pixels, alternating. Empty for a solid line.
    dash: &'static [f64],
    shape: Shape,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    Circle,
    /// Corners of a polygon of size 5.
    Corners(&'static [Pixel]),
}

const SQUARE: Shape = Shape::Corners(&[(-4, -4), (4, -4), (4, 4), (-4, 4)]);
const UP: Shape = Shape::Corners(&[(0, -6), (6, 4), (-6, 4)]);
const DIAMOND: Shape = Shape::Corners(&[(0, -6), (6, 0), (0, 6), (-6, 0)]);
const DOWN: Shape = Shape::Corners(&[(0, 6), (6, -4), (-6, -4)]);
const PLUS: Shape = Shape::Corners(&[
    (-2, -6),
    (2, -6),
    (2, -2),
    (6, -2),
    (6, 2),
    (2, 2),
    (2, 6),
    (-2, 6),
    (-2, 2),
    (-6, 2),
    (-6, -2),
    (-2, -2),
]);
const HOURGLASS: Shape = Shape::Corners(&[(-5, -6), (5, -6), (1, 0), (5, 6), (-5, 6), (-1, 0)]);
const RIGHT: Shape = Shape::Corners(&[(6, 0), (-4, 6), (-4, -6)]);
const LEFT: Shape = Shape::Corners(&[(-6, 0), (4, 6), (4, -6)]);
const BOW_TIE: Shape = Shape::Corners(&[(-6, -5), (0, -1), (6, -5), (6, 5), (0, 1), (-6, 5)]);

/// The colours of Okabe and Ito, which colour-blind readers can tell apart, without their yellow, which is too light on
/// white. Then two colours of Paul Tol, and a grey.
const LOOKS: [Look; 10] = [
    Look { color: RGBColor(0, 114, 178), dash: &[], shape: Shape::Circle },
    Look { color: RGBColor(213, 94, 0), dash: &[9.0, 3.0], shape: SQUARE },
    Look { color: RGBColor(0, 158, 115), dash: &[3.0, 3.0], shape: UP },
    Look { color: RGBColor(204, 121, 167), dash: &[12.0, 3.0, 3.0, 3.0], shape: DIAMOND },
    Look { color: RGBColor(0, 0, 0), dash: &[6.0, 6.0], shape: DOWN },
    Look { color: RGBColor(230, 159, 0), dash: &[], shape: PLUS },
    Look { color: RGBColor(86, 180, 233), dash: &[9.0, 3.0], shape: HOURGLASS },
    Look { color: RGBColor(136, 34, 85), dash: &[3.0, 3.0], shape: RIGHT },
    Look { color: RGBColor(153, 153, 51), dash: &[12.0, 3.0, 3.0, 3.0], shape: LEFT },
    Look { color: RGBColor(110, 110, 110), dash: &[6.0, 6.0], shape: BOW_TIE },
];

/// Length, in pixels, of one kernel's colour on a line that several kernels share.
const STRIPE: f64 = 9.0;

impl Look {
    /// The look of the kernel with this index in its group.
    pub(super) fn of(index: usize) -> Self {
        // After ten kernels, the colours repeat with other shapes.
        Self { shape: LOOKS[(index + index / LOOKS.len()) % LOOKS.len()].shape, ..LOOKS[index % LOOKS.len()] }
    }

    /// A look that belongs to no kernel, for legends.
    pub(super) fn neutral() -> Self {
        Self { color: INK, dash: &[], shape: Shape::Circle }
    }

    /// Draws a mark, with a white rim that separates it from its neighbours. A hollow mark means that the value is an
    /// upper bound; it has an arrow pointing down.
    pub(super) fn mark(&self, root: &Area, at: Pixel, size: i32, hollow: bool) -> Drawn {
        self.stamp(root, at, size + 2, WHITE.filled())?;
        if !hollow {
            return self.stamp(root, at, size, self.color.filled());
        }
        self.stamp(root, at, size, self.color.stroke_width(2))?;
        let (x, from) = (at.0, at.1 + size + 1);
        let tip = from + 6;
        root.draw(&PathElement::new([(x, from), (x, tip)], self.color.stroke_width(2)))?;
        root.draw(&PathElement::new([(x - 3, tip - 3), (x, tip), (x + 3, tip - 3)], self.color.stroke_width(2)))
    }

    /// Draws the shape, filled or as an outline.
    fn stamp(&self, root: &Area, (x, y): Pixel, size: i32, style: ShapeStyle) -> Drawn {
        let Shape::Corners(corners) = self.shape else {
            return root.draw(&Circle::new((x, y), size, style));
        };
        let scale = |offset: i32| (f64::from(offset * size) / 5.0).round() as i32;
        let mut corners: Vec<Pixel> = corners.iter().map(|&(dx, dy)| (x + scale(dx), y + scale(dy))).collect();
        if style.filled {
            return root.draw(&Polygon::new(corners, style));
        }
        corners.extend_from_within(..1);
        root.draw(&PathElement::new(corners, style))
    }
}

/// Draws a line that these series share, each given by its ID, if it has one, and its look. A single series has its own
/// dash pattern. Several series alternate in stripes of their colours.
pub(super) fn line(root: &Area, points: &[Pixel], series: &[(Option<&str>, Look)]) -> Drawn {
    let period = series.len() as f64 * STRIPE;
    let stripe = [STRIPE, period - STRIPE];
    for (i, (id, look)) in (0..).zip(series) {
        root.draw(&SubjectGroup(*id))?;
        let (pattern, phase) = match series {
            [_] => (look.dash, 0.0),
            _ => (&stripe[..], (f64::from(-i) * STRIPE).rem_euclid(period)),
        };
        root.draw(&Dashed { points, style: look.color.stroke_width(2), pattern, phase })?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn twenty_kernels_all_look_different() {
        let looks: Vec<Look> = (0..20).map(Look::of).collect();
        for (i, a) in looks.iter().enumerate() {
            assert!(looks[..i].iter().all(|b| a != b), "{i}");
            // Within ten kernels, both colours and shapes are distinct.
            assert!(looks[i / 10 * 10..i].iter().all(|b| a.shape != b.shape && a.color != b.color), "{i}");
        }
    }

    #[test]
    fn a_line_of_one_series_is_dashed_and_a_shared_line_is_striped() {
        let looks = [0, 1, 2].map(|i| (None, Look::of(i)));
        let svg = super::super::canvas::canvas((300, 20), |root| line(root, &[(27, 9), (63, 9), (108, 9)], &looks));
        for (color, skipped) in
            [("0072B2", ""), ("D55E00", " stroke-dashoffset=\"18\""), ("009E73", " stroke-dashoffset=\"9\"")]
        {
            let path = format!(
                "<path stroke=\"#{color}\" stroke-width=\"2\" stroke-dasharray=\"9 18\"{skipped} \
                 d=\"M27 9l36 0 45 0\"/>"
            );
            assert_eq!(svg.matches(&path).count(), 1, "{svg}");
        }
        let alone = super::super::canvas::canvas((300, 20), |root| line(root, &[(27, 9), (63, 9)], &looks[1..2]));
        assert!(alone.contains(" stroke-dasharray=\"9 3\" d=\"M27 9l36 0\""), "{alone}");
    }
}
