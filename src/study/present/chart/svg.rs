//! The SVG backend that plotters draws with. The one that comes with plotters writes one element for each dash, repeats
//! all attributes, and has no tooltips. This one joins consecutive paths of the same style, leaves out attributes with
//! default values, names its colours so that pages can replace them, and collects [hover targets](super::hover).

use super::layout::{Pixel, TEXT};
use super::palette;
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
    /// The subjects that are being drawn.
    group: Vec<usize>,
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
            group: Vec::new(),
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

    fn stroke<S: BackendStyle>(&mut self, points: impl IntoIterator<Item = Pixel>, style: &S) -> Done {
        let width = match style.stroke_width() {
            1 => String::new(),
            width => format!(" stroke-width=\"{width}\""),
        };
        let attributes = paint("stroke", style.color()) + &width;
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

/// The attributes of a fill or a stroke. A colour of the palette also gets its class.
fn paint(attribute: &str, color: BackendColor) -> String {
    let opacity = if color.alpha < 1.0 { format!(" opacity=\"{}\"", color.alpha) } else { String::new() };
    let class = palette::name_of(color.rgb);
    let class = class.map_or(String::new(), |name| format!(" class=\"{}-{name}\"", &attribute[..1]));
    format!(" {attribute}=\"{}\"{opacity}{class}", palette::hex(color.rgb))
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
        debug_assert!(self.group.is_empty(), "the last subject group must be ended");
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
        self.stroke([from, to], style)
    }

    fn draw_rect<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S, fill: bool) -> Done {
        let ((x, y), (width, height)) = (from, (to.0 - from.0, to.1 - from.1));
        let data = format!("M{x} {y}h{width}v{height}h{}z", -width);
        self.path(style.color(), paint(if fill { "fill" } else { "stroke" }, style.color()), &data)
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, path: I, style: &S) -> Done {
        self.stroke(path, style)
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
        if text.is_empty() {
            return Ok(());
        }
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

/// Starts the elements of some subjects, such as kernels, or of none. Elements of the same subjects form groups with
/// their numbers, so that a script can tell them from others.
pub(super) struct SubjectGroup<'a>(pub(super) &'a [&'a str]);

impl<'a> PointCollection<'a, Pixel> for &'a SubjectGroup<'_> {
    type Point = Pixel;
    type IntoIter = [Pixel; 0];

    fn point_iter(self) -> Self::IntoIter {
        []
    }
}

impl Drawable<Svg<'_>> for SubjectGroup<'_> {
    fn draw<I: Iterator<Item = Pixel>>(&self, _: I, svg: &mut Svg, _: (u32, u32)) -> Done {
        let group: Vec<_> = self.0.iter().map(|subject| svg.number_of(subject)).collect();
        if group == svg.group {
            return Ok(());
        }
        if !svg.group.is_empty() {
            svg.element("</g>")?;
        }
        svg.group = group;
        if svg.group.is_empty() {
            return Ok(());
        }
        let numbers: Vec<_> = svg.group.iter().map(usize::to_string).collect();
        svg.element(&format!("<g data-of=\"{}\">", numbers.join(" ")))
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
    fn colours_of_the_palette_have_their_class() {
        let svg = canvas((100, 50), |root| root.draw_text("a", &label(TEXT, palette::INK), (1, 2)));
        assert!(
            svg.contains(" fill=\"#FFF\" class=\"f-page\"") && svg.contains(" fill=\"#1F2328\" class=\"f-ink\">a<")
        );
        let style = palette::file_style(&svg);
        assert_eq!(style, "@media(prefers-color-scheme:dark){.f-ink{fill:#E2E6EA}.f-page{fill:#14171A}}");
    }

    #[test]
    fn elements_of_a_subject_are_grouped_under_its_number() {
        let text = |root: &Area, subjects: &[&str]| {
            root.draw(&SubjectGroup(subjects))?;
            root.draw_text("<&>", &label(TEXT, BLACK), (1, 2))
        };
        let svg = canvas((100, 50), |root| {
            let groups: [&[&str]; 6] = [&["a"], &["a"], &["b"], &[], &["b", "a"], &[]];
            groups.into_iter().try_for_each(|subjects| text(root, subjects))
        });
        let grouped =
            svg.replace("<text x=\"1\" y=\"2\" dy=\"0.5ex\" fill=\"#000\">&lt;&amp;&gt;</text>", "T").replace('\n', "");
        let (_, body) = grouped.split_once("z\"/>").unwrap();
        assert_eq!(body, "<g data-of=\"0\">TT</g><g data-of=\"1\">T</g>T<g data-of=\"1 0\">T</g>T</svg>",);
    }
}
