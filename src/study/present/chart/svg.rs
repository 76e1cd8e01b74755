//! The SVG backend that plotters draws with. The one that comes with plotters writes one element for each dash, repeats
//! all attributes, and has no tooltips. This one joins consecutive paths of the same style, leaves out attributes with
//! default values, and collects [hover targets](super::hover).

use super::layout::{Pixel, TEXT};
use std::convert::Infallible;
use std::fmt::Write;

use plotters::element::{Drawable, PointCollection};
use plotters::style::text_anchor::{HPos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind, FontStyle,
};

type Done = Result<(), DrawingErrorKind<Infallible>>;

/// A text size in plotters is this multiple of the same size in SVG.
pub(super) const FONT_SCALE: f64 = 1.24;

/// A drawing backend that writes an SVG into a string when it is [presented](DrawingBackend::present).
pub(super) struct Svg<'a> {
    target: &'a mut String,
    size: (u32, u32),
    body: String,
    /// A path that is not written yet, because more of the same style may follow: its attributes and its data.
    path: (String, String),
    /// All subjects (see [`SubjectGroup`]), in the order of their first appearance.
    subjects: Vec<String>,
    /// The subject that is being drawn.
    subject: Option<usize>,
    hover: String,
}

impl<'a> Svg<'a> {
    pub(super) fn new(target: &'a mut String, size: (u32, u32)) -> Self {
        Self {
            target,
            size,
            body: String::new(),
            path: Default::default(),
            subjects: Vec::new(),
            subject: None,
            hover: String::new(),
        }
    }

    /// The number of a subject. A new subject gets the next number.
    pub(super) fn number_of(&mut self, subject: &str) -> usize {
        self.subjects.iter().position(|known| known == subject).unwrap_or_else(|| {
            self.subjects.push(subject.to_owned());
            self.subjects.len() - 1
        })
    }

    /// Adds a hover target. Hover targets are invisible and lie above everything else.
    pub(super) fn hover(&mut self, element: &str) {
        self.hover += element;
    }

    fn element(&mut self, element: &str) -> Done {
        self.end_path();
        self.body += element;
        self.body.push('\n');
        Ok(())
    }

    /// Adds to the previous path if it has the same attributes. Translucent paths stay separate, because their colours
    /// add up where they overlap.
    fn path(&mut self, color: BackendColor, attributes: String, data: &str) -> Done {
        if color.alpha == 0.0 {
            return Ok(());
        }
        if attributes != self.path.0 || color.alpha < 1.0 {
            self.end_path();
            self.path.0 = attributes;
        }
        self.path.1 += data;
        Ok(())
    }

    fn end_path(&mut self) {
        let (attributes, data) = std::mem::take(&mut self.path);
        if !data.is_empty() {
            self.body += &format!("<path{attributes} d=\"{data}\"/>\n");
        }
    }

    fn stroke<S: BackendStyle>(&mut self, points: impl IntoIterator<Item = Pixel>, style: &S, more: &str) -> Done {
        let width = match style.stroke_width() {
            1 => String::new(),
            width => format!(" stroke-width=\"{width}\""),
        };
        let attributes = format!("{}{width}{more}", paint("stroke", style.color()));
        self.path(style.color(), attributes, &joined(points))
    }
}

/// Path data of connected lines. Each point is relative to the one before.
fn joined(points: impl IntoIterator<Item = Pixel>) -> String {
    let mut data = String::new();
    let mut last = (0, 0);
    for (i, (x, y)) in points.into_iter().enumerate() {
        let (dx, dy) = (x - last.0, y - last.1);
        // A minus sign separates two numbers, so no space is needed before it.
        let command = match i {
            0 => "M",
            1 => "l",
            _ if dx < 0 => "",
            _ => " ",
        };
        let space = if dy < 0 { "" } else { " " };
        write!(data, "{command}{dx}{space}{dy}").expect("writing to a string cannot fail");
        last = (x, y);
    }
    data
}

/// The attributes of a fill or a stroke.
fn paint(attribute: &str, color: BackendColor) -> String {
    let (r, g, b) = color.rgb;
    let opacity = if color.alpha < 1.0 { format!(" opacity=\"{}\"", color.alpha) } else { String::new() };
    // SVG has a short form for pairs of equal digits.
    let color = match [r, g, b] {
        rgb if rgb.iter().all(|value| value % 17 == 0) => format!("{:X}{:X}{:X}", r / 17, g / 17, b / 17),
        _ => format!("{r:02X}{g:02X}{b:02X}"),
    };
    format!(" {attribute}=\"#{color}\"{opacity}")
}

/// Text with special characters escaped for XML and HTML, also within attributes.
pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

impl DrawingBackend for Svg<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        self.size
    }

    fn ensure_prepared(&mut self) -> Done {
        Ok(())
    }

    fn present(&mut self) -> Done {
        self.end_path();
        debug_assert!(self.subject.is_none(), "the last subject group must be ended");
        let (width, height) = self.size;
        *self.target = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} \
             {height}\" fill=\"none\" font-family=\"sans-serif\" font-size=\"{TEXT}\">\n{}",
            self.body
        );
        if !self.hover.is_empty() {
            *self.target += &format!("<g class=\"hover\" pointer-events=\"all\">\n{}</g>\n", self.hover);
        }
        *self.target += "</svg>\n";
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, color: BackendColor) -> Done {
        self.path(color, paint("fill", color), &format!("M{x} {y}h1v1h-1z"))
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Done {
        self.stroke([from, to], style, "")
    }

    fn draw_rect<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S, fill: bool) -> Done {
        let ((x, y), (width, height)) = (from, (to.0 - from.0, to.1 - from.1));
        let data = format!("M{x} {y}h{width}v{height}h{}z", -width);
        self.path(style.color(), paint(if fill { "fill" } else { "stroke" }, style.color()), &data)
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, path: I, style: &S) -> Done {
        self.stroke(path, style, "")
    }

    fn draw_circle<S: BackendStyle>(&mut self, (x, y): BackendCoord, radius: u32, style: &S, fill: bool) -> Done {
        let paint = if fill {
            paint("fill", style.color())
        } else {
            format!("{} stroke-width=\"{}\"", paint("stroke", style.color()), style.stroke_width())
        };
        self.element(&format!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\"{paint}/>"))
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, path: I, style: &S) -> Done {
        self.element(&format!("<path{} d=\"{}z\"/>", paint("fill", style.color()), joined(path)))
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, (x, y): BackendCoord) -> Done {
        let anchor = match style.anchor().h_pos {
            HPos::Left => "",
            HPos::Center => " text-anchor=\"middle\"",
            HPos::Right => " text-anchor=\"end\"",
        };
        let shift = match style.anchor().v_pos {
            VPos::Top => "0.76em",
            VPos::Center => "0.5ex",
            VPos::Bottom => "-0.5ex",
        };
        let family = match style.family().as_str() {
            "sans-serif" => String::new(),
            family => format!(" font-family=\"{family}\""),
        };
        let size = (style.size() / FONT_SCALE * 100.0).round() / 100.0;
        let size = if size == TEXT { String::new() } else { format!(" font-size=\"{size}\"") };
        let weight = if matches!(style.style(), FontStyle::Bold) { " font-weight=\"bold\"" } else { "" };
        let look = format!("{anchor}{family}{size}{weight}{}", paint("fill", style.color()));
        self.element(&format!("<text x=\"{x}\" y=\"{y}\" dy=\"{shift}\"{look}>{}</text>", escaped(text)))
    }
}

/// Starts the elements of a subject, such as a kernel, or of none. Elements of one subject form groups with its number,
/// so that a script can tell them from others.
pub(super) struct SubjectGroup<'a>(pub(super) Option<&'a str>);

impl<'a> PointCollection<'a, Pixel> for &'a SubjectGroup<'_> {
    type Point = Pixel;
    type IntoIter = [Pixel; 0];

    fn point_iter(self) -> Self::IntoIter {
        []
    }
}

impl Drawable<Svg<'_>> for SubjectGroup<'_> {
    fn draw<I: Iterator<Item = Pixel>>(&self, _: I, svg: &mut Svg, _: (u32, u32)) -> Done {
        let subject = self.0.map(|subject| svg.number_of(subject));
        if subject == svg.subject {
            return Ok(());
        }
        if svg.subject.is_some() {
            svg.element("</g>")?;
        }
        svg.subject = subject;
        subject.map_or(Ok(()), |number| svg.element(&format!("<g data-of=\"{number}\">")))
    }
}

/// A dashed line.
pub(super) struct Dashed<'a, S> {
    pub(super) points: &'a [Pixel],
    pub(super) style: S,
    /// Lengths of dashes and gaps in pixels, alternating. Empty for a solid line.
    pub(super) pattern: &'a [f64],
    /// Length of the pattern, in pixels, that is skipped at the start of the line.
    pub(super) phase: f64,
}

impl<'a, S> PointCollection<'a, Pixel> for &'a Dashed<'_, S> {
    type Point = &'a Pixel;
    type IntoIter = &'a [Pixel];

    fn point_iter(self) -> Self::IntoIter {
        self.points
    }
}

impl<S: BackendStyle> Drawable<Svg<'_>> for Dashed<'_, S> {
    fn draw<I: Iterator<Item = Pixel>>(&self, points: I, svg: &mut Svg, _: (u32, u32)) -> Done {
        if self.pattern.is_empty() {
            return svg.stroke(points, &self.style, "");
        }
        let pattern = self.pattern.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
        let phase = if self.phase == 0.0 { String::new() } else { format!(" stroke-dashoffset=\"{}\"", self.phase) };
        svg.stroke(points, &self.style, &format!(" stroke-dasharray=\"{pattern}\"{phase}"))
    }
}

#[cfg(test)]
mod tests {
    use plotters::prelude::*;

    use super::super::canvas::{Area, canvas, label};
    use super::*;

    #[test]
    fn consecutive_paths_of_the_same_style_are_joined() {
        let line = |x, color: RGBAColor| {
            let style = ShapeStyle { color, filled: false, stroke_width: 2 };
            PathElement::new([(x, 5), (x + 2, 4), (x, 9)], style)
        };
        let svg = canvas((100, 50), |root| {
            for (x, color) in [(10, RED), (20, RED), (30, BLACK), (40, RED)] {
                root.draw(&line(x, color.into()))?;
            }
            // Translucent colours add up where they overlap.
            (0..2).try_for_each(|_| root.draw(&line(60, RED.mix(0.5))))
        });
        let paths: Vec<_> = svg.lines().filter(|line| line.starts_with("<path stroke")).collect();
        let red = |data: &str| format!("<path stroke=\"#F00\" stroke-width=\"2\" d=\"{data}\"/>");
        assert_eq!(
            paths[..2],
            [red("M10 5l2-1-2 5M20 5l2-1-2 5"), red("M30 5l2-1-2 5").replace("F00", "000")],
            "{svg}"
        );
        assert_eq!(paths[2], red("M40 5l2-1-2 5"));
        assert!(paths[3].contains(" opacity=\"0.5\"") && paths[3] == paths[4] && paths.len() == 5, "{svg}");
    }

    #[test]
    fn elements_of_a_subject_are_grouped_under_its_number() {
        let text = |root: &Area, subject| {
            root.draw(&SubjectGroup(subject))?;
            root.draw_text("<&>", &label(TEXT, BLACK), (1, 2))
        };
        let svg = canvas((100, 50), |root| {
            [Some("a"), Some("a"), Some("b"), None, Some("a"), None].iter().try_for_each(|subject| text(root, *subject))
        });
        let grouped =
            svg.replace("<text x=\"1\" y=\"2\" dy=\"0.5ex\" fill=\"#000\">&lt;&amp;&gt;</text>", "T").replace('\n', "");
        let (_, body) = grouped.split_once("z\"/>").unwrap();
        assert_eq!(body, "<g data-of=\"0\">TT</g><g data-of=\"1\">T</g>T<g data-of=\"0\">T</g>T</svg>",);
    }
}
