//! Hover targets: invisible shapes above a chart. Each has a title, which browsers show as a tooltip.

use plotters::element::{Drawable, PointCollection};
use plotters_backend::DrawingErrorKind;

use super::layout::Pixel;
use super::svg::{Svg, escaped};

/// An invisible shape with a tooltip.
pub(super) struct Hover<'a> {
    pub(super) shape: Shape,
    /// The subjects of the tooltip: see [`SubjectGroup`](super::svg::SubjectGroup).
    pub(super) subjects: Vec<&'a str>,
    /// The text of the tooltip: one line for each subject.
    pub(super) title: String,
    /// `data-` attributes for the script of the page: figures for parts of the shape.
    pub(super) data: Vec<(&'static str, String)>,
}

#[derive(Clone, Copy)]
pub(super) enum Shape {
    Disc { center: Pixel, radius: i32 },
    Rectangle { corner: Pixel, size: Pixel },
}

impl PointCollection<'_, Pixel> for &Hover<'_> {
    type Point = Pixel;
    type IntoIter = [Pixel; 1];

    fn point_iter(self) -> Self::IntoIter {
        match self.shape {
            Shape::Disc { center, .. } => [center],
            Shape::Rectangle { corner, .. } => [corner],
        }
    }
}

impl Drawable<Svg<'_>> for Hover<'_> {
    fn draw<I: Iterator<Item = Pixel>>(
        &self,
        at: I,
        svg: &mut Svg,
        _: (u32, u32),
    ) -> Result<(), DrawingErrorKind<std::convert::Infallible>> {
        let numbers: Vec<_> = self.subjects.iter().map(|subject| svg.number_of(subject).to_string()).collect();
        let data: String =
            self.data.iter().map(|(name, value)| format!(" data-{name}=\"{}\"", escaped(value))).collect();
        let inner = format!(" data-of=\"{}\"{data}><title>{}</title>", numbers.join(" "), escaped(&self.title));
        for (x, y) in at {
            svg.hover(&match self.shape {
                Shape::Disc { radius, .. } => format!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\"{inner}</circle>\n"),
                Shape::Rectangle { size: (width, height), .. } => {
                    format!("<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\"{inner}</rect>\n")
                }
            });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::canvas::canvas;
    use super::*;

    #[test]
    fn titles_are_escaped_and_lie_above_everything_else() {
        let hover = Hover {
            shape: Shape::Disc { center: (30, 20), radius: 5 },
            subjects: vec!["a", "b"],
            title: "a < b & \"c\"".into(),
            data: vec![("cells", "1 \"2\"".into())],
        };
        let svg = canvas((100, 50), |root| {
            root.draw(&hover)?;
            root.draw_text("<drawn later>", &super::super::canvas::label(12.0, super::super::palette::INK), (5, 5))
        });
        let target = "<circle cx=\"30\" cy=\"20\" r=\"5\" data-of=\"0 1\" data-cells=\"1 &quot;2&quot;\">\
                      <title>a &lt; b &amp; &quot;c&quot;</title></circle>";
        let (text, hover) = (svg.find(">&lt;drawn later&gt;</text>").unwrap(), svg.find(target).unwrap());
        assert!(text < svg.find("<g class=\"hover\"").unwrap() && text < hover, "{svg}");
    }
}
