//! The look of marks and lines: a colour and a shape. Each of the two alone tells the series of a panel apart.

use plotters::prelude::*;

use super::canvas::{Area, Drawn};
use super::layout::Pixel;
use super::palette::{CATEGORIES, PAGE};

/// The look of the line and the marks of a series.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Look {
    pub(super) color: RGBColor,
    shape: Shape,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    Circle,
    /// Corners of a polygon of size 5.
    Corners(&'static [Pixel]),
}

/// The shapes, the most different ones first.
const SHAPES: [Shape; 8] = [
    Shape::Circle,
    Shape::Corners(&[(0, -6), (6, 4), (-6, 4)]),
    Shape::Corners(&[(0, -6), (6, 0), (0, 6), (-6, 0)]),
    Shape::Corners(&[(-4, -4), (4, -4), (4, 4), (-4, 4)]),
    Shape::Corners(&[(0, 6), (6, -4), (-6, -4)]),
    Shape::Corners(&[(-5, -6), (5, -6), (1, 0), (5, 6), (-5, 6), (-1, 0)]),
    Shape::Corners(&[(6, 0), (-4, 6), (-4, -6)]),
    Shape::Corners(&[(-6, -5), (0, -1), (6, -5), (6, 5), (0, 1), (-6, 5)]),
];

/// Number of shapes.
pub(super) const DISTINCT: usize = SHAPES.len();

impl Look {
    /// A colour with the shape of this number.
    pub(super) fn new(color: RGBColor, shape: usize) -> Self {
        Self { color, shape: SHAPES[shape % SHAPES.len()] }
    }

    /// The look of a category, such as a mode of the tracer.
    pub(super) fn of_category(number: usize) -> Self {
        Self::new(CATEGORIES[number % CATEGORIES.len()], number)
    }

    /// Draws a mark, with a rim in the colour of the page that separates it from its neighbours. A hollow mark stands
    /// for a count of zero.
    pub(super) fn mark(&self, root: &Area, at: Pixel, size: i32, hollow: bool) -> Drawn {
        self.stamp(root, at, size + 2, PAGE.filled())?;
        self.stamp(root, at, size, if hollow { self.color.stroke_width(2) } else { self.color.filled() })
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn categories_differ_in_colour_and_in_shape() {
        let looks: Vec<Look> = (0..CATEGORIES.len()).map(Look::of_category).collect();
        for (i, a) in looks.iter().enumerate() {
            assert!(looks[..i].iter().all(|b| a.color != b.color && a.shape != b.shape), "{i}");
        }
    }
}
