//! How a kernel looks: a colour, a pattern of dashes and the shape of its marks. Any one of them tells kernels apart.

use plotters::prelude::*;

use super::{Area, Drawn, INK, Pixel};

/// How the lines and marks of a kernel look.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Look {
    pub(super) color: RGBColor,
    /// Pixels drawn and left out, in turn; none: a solid line.
    dash: &'static [f64],
    shape: Shape,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    Circle,
    /// Corners for a size of 5.
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

/// Okabe and Ito's colours, which the colour-blind can tell apart, without the yellow, which white swallows; then two of
/// Paul Tol's and a grey.
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

/// Pixels of one kernel's colour on a line that several share.
const STRIPE: f64 = 9.0;

impl Look {
    /// Of the kernel with that place in its group.
    pub(super) fn of(index: usize) -> Self {
        // Beyond ten, colours return with other shapes.
        Self { shape: LOOKS[(index + index / LOOKS.len()) % LOOKS.len()].shape, ..LOOKS[index % LOOKS.len()] }
    }

    /// Of no kernel: for legends.
    pub(super) fn neutral() -> Self {
        Self { color: INK, dash: &[], shape: Shape::Circle }
    }

    /// A mark, with a white rim that keeps neighbours apart. Hollow: the value is an upper bound, hence an arrow downward.
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

    /// The shape, filled or in outline.
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

/// A straight line of the kernels with these looks: in the pattern of one, in stripes of several.
pub(super) fn line(root: &Area, ends: [Pixel; 2], looks: &[Look]) -> Drawn {
    match looks {
        [look] if look.dash.is_empty() => root.draw(&PathElement::new(ends, look.color.stroke_width(2))),
        [look] => {
            let inked = look.dash.iter().enumerate().map(|(i, &length)| (length, (i % 2 == 0).then_some(look.color)));
            dashed(root, ends, &inked.collect::<Vec<_>>(), 0.0)
        }
        // Stripes go on from one step to the next.
        _ => {
            let stripes: Vec<_> = looks.iter().map(|look| (STRIPE, Some(look.color))).collect();
            dashed(root, ends, &stripes, f64::from(ends[0].0))
        }
    }
}

/// Draws a line in pieces of these lengths and colours, over and over, beginning at `phase`.
fn dashed(root: &Area, ends: [Pixel; 2], pieces: &[(f64, Option<RGBColor>)], phase: f64) -> Drawn {
    let [(x0, y0), (x1, y1)] = ends.map(|(x, y)| (f64::from(x), f64::from(y)));
    let length = (x1 - x0).hypot(y1 - y0);
    let at = |along: f64| {
        let share = (along / length).clamp(0.0, 1.0);
        ((x0 + share * (x1 - x0)).round() as i32, (y0 + share * (y1 - y0)).round() as i32)
    };
    let period: f64 = pieces.iter().map(|(length, _)| length).sum();
    let mut from = -(phase % period);
    for (piece, color) in pieces.iter().cycle() {
        if from >= length {
            return Ok(());
        }
        let to = from + piece;
        if let Some(color) = color.filter(|_| to > 0.0) {
            root.draw(&PathElement::new([at(from), at(to)], color.stroke_width(2)))?;
        }
        from = to;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn twenty_kernels_look_different() {
        let looks: Vec<Look> = (0..20).map(Look::of).collect();
        for (i, a) in looks.iter().enumerate() {
            assert!(looks[..i].iter().all(|b| a != b), "{i}");
            // Without colours, ten are told apart by their shapes.
            assert!(looks[i / 10 * 10..i].iter().all(|b| a.shape != b.shape && a.color != b.color), "{i}");
        }
    }

    #[test]
    fn stripes_show_every_kernel_and_go_on_at_the_next_step() {
        let looks: Vec<Look> = (0..3).map(Look::of).collect();
        let svg = |ends: &[[Pixel; 2]]| {
            super::super::canvas((300, 20), |root| ends.iter().try_for_each(|&ends| line(root, ends, &looks)))
        };
        let whole = svg(&[[(27, 9), (108, 9)]]);
        for color in ["#0072B2", "#D55E00", "#009E73"] {
            assert_eq!(whole.matches(color).count(), 3, "{color}");
        }
        assert_eq!(svg(&[[(27, 9), (63, 9)], [(63, 9), (108, 9)]]), whole);
    }
}
