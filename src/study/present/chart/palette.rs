//! The colours of the charts: each has a value for light pages and one for dark pages. None stands for a kernel. Red
//! stands for failure, and for nothing else.
//!
//! An SVG holds the light values as attributes, so every program can draw it. Classes beside them let a style sheet
//! replace them: [`file_style`] in a file of its own, [`page_style`] in the page of the report.

use std::fmt::Write;

use plotters::prelude::RGBColor;

/// Text.
pub(super) const INK: RGBColor = RGBColor(31, 35, 40);
/// Axes and text of less weight.
pub(super) const FAINT: RGBColor = RGBColor(89, 99, 110);
/// The background.
pub(super) const PAGE: RGBColor = RGBColor(255, 255, 255);
/// The background of a marked row.
pub(super) const BAND: RGBColor = RGBColor(243, 245, 247);
/// Grid lines.
pub(super) const RULE: RGBColor = RGBColor(213, 218, 224);
const LINK: RGBColor = RGBColor(11, 92, 173);
/// Failures.
pub(super) const BAD: RGBColor = RGBColor(200, 50, 26);
/// Speed.
pub(super) const SPEED: RGBColor = RGBColor(0, 98, 168);
/// Lost rays.
pub(super) const LOST: RGBColor = RGBColor(116, 66, 168);
/// False and double hits.
pub(super) const FALSE: RGBColor = RGBColor(138, 98, 0);
/// Lines that need no attention.
pub(super) const QUIET: RGBColor = RGBColor(148, 157, 166);
/// Sets of rays, modes and tracers: never kernels.
pub(super) const CATEGORIES: [RGBColor; 5] =
    [RGBColor(0, 114, 178), RGBColor(168, 98, 0), RGBColor(0, 125, 92), RGBColor(166, 78, 134), RGBColor(70, 70, 110)];
/// Steps of a scale, from small to large: Cynthia Brewer's `YlGnBu`. Lightness alone tells them apart.
pub(super) const STEPS: [RGBColor; 7] = [
    RGBColor(255, 255, 204),
    RGBColor(199, 233, 180),
    RGBColor(127, 205, 187),
    RGBColor(65, 182, 196),
    RGBColor(29, 145, 192),
    RGBColor(34, 94, 168),
    RGBColor(8, 29, 88),
];
/// Cells without a figure.
pub(super) const UNKNOWN: RGBColor = RGBColor(216, 216, 216);

/// A colour: its name in style sheets, and its value on light and on dark pages.
struct Tone(&'static str, RGBColor, RGBColor);

/// On dark pages the scale is reversed: small values are always closest to the background.
const TONES: [Tone; 24] = [
    Tone("ink", INK, RGBColor(226, 230, 234)),
    Tone("faint", FAINT, RGBColor(154, 164, 175)),
    Tone("page", PAGE, RGBColor(20, 23, 26)),
    Tone("band", BAND, RGBColor(38, 44, 50)),
    Tone("rule", RULE, RGBColor(54, 61, 68)),
    Tone("link", LINK, RGBColor(121, 184, 255)),
    Tone("bad", BAD, RGBColor(255, 115, 92)),
    Tone("speed", SPEED, RGBColor(98, 178, 240)),
    Tone("lost", LOST, RGBColor(194, 156, 240)),
    Tone("false", FALSE, RGBColor(224, 180, 84)),
    Tone("quiet", QUIET, RGBColor(106, 115, 124)),
    Tone("category-0", CATEGORIES[0], RGBColor(86, 180, 233)),
    Tone("category-1", CATEGORIES[1], RGBColor(230, 159, 0)),
    Tone("category-2", CATEGORIES[2], RGBColor(60, 200, 156)),
    Tone("category-3", CATEGORIES[3], RGBColor(232, 150, 200)),
    Tone("category-4", CATEGORIES[4], RGBColor(176, 176, 214)),
    Tone("step-0", STEPS[0], RGBColor(24, 42, 56)),
    Tone("step-1", STEPS[1], RGBColor(24, 68, 92)),
    Tone("step-2", STEPS[2], RGBColor(24, 100, 122)),
    Tone("step-3", STEPS[3], RGBColor(44, 136, 142)),
    Tone("step-4", STEPS[4], RGBColor(92, 174, 148)),
    Tone("step-5", STEPS[5], RGBColor(158, 212, 150)),
    Tone("step-6", STEPS[6], RGBColor(238, 246, 176)),
    Tone("unknown", UNKNOWN, RGBColor(66, 72, 78)),
];

/// The name of the colour with this light value; `None` for a colour that is the same on all pages.
pub(super) fn name_of((r, g, b): (u8, u8, u8)) -> Option<&'static str> {
    TONES.iter().find(|Tone(_, light, _)| *light == RGBColor(r, g, b)).map(|Tone(name, ..)| *name)
}

/// A colour in the shortest form of CSS.
pub(super) fn hex((r, g, b): (u8, u8, u8)) -> String {
    match [r, g, b] {
        rgb if rgb.iter().all(|value| value % 17 == 0) => format!("#{:X}{:X}{:X}", r / 17, g / 17, b / 17),
        _ => format!("#{r:02X}{g:02X}{b:02X}"),
    }
}

fn hex_of(RGBColor(r, g, b): RGBColor) -> String {
    hex((r, g, b))
}

/// The style sheet of an SVG file: on dark pages it replaces the colours that the SVG uses.
pub(super) fn file_style(svg: &str) -> String {
    let mut rules = String::new();
    for Tone(name, _, dark) in TONES {
        for (class, property) in [('f', "fill"), ('s', "stroke")] {
            if svg.contains(&format!("\"{class}-{name}\"")) {
                write!(rules, ".{class}-{name}{{{property}:{}}}", hex_of(dark))
                    .expect("writing to a string cannot fail");
            }
        }
    }
    format!("@media(prefers-color-scheme:dark){{{rules}}}")
}

/// The style sheet of a page with charts: all colours as variables, such as `--ink`, and the charts drawn in them.
pub(crate) fn page_style() -> String {
    let variables = |value: fn(&Tone) -> RGBColor| -> String {
        TONES.iter().map(|tone| format!("--{}:{};", tone.0, hex_of(value(tone)))).collect()
    };
    let rules: String = TONES
        .iter()
        .map(|Tone(name, ..)| format!(".f-{name}{{fill:var(--{name})}}.s-{name}{{stroke:var(--{name})}}\n"))
        .collect();
    format!(
        ":root{{color-scheme:light dark;{}}}\n@media(prefers-color-scheme:dark){{:root{{{}}}}}\n{rules}",
        variables(|Tone(_, light, _)| *light),
        variables(|Tone(.., dark)| *dark)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative luminance, as in the Web Content Accessibility Guidelines.
    fn luminance(RGBColor(r, g, b): RGBColor) -> f64 {
        let linear = |value: u8| {
            let value = f64::from(value) / 255.0;
            if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b)
    }

    fn contrast(a: RGBColor, b: RGBColor) -> f64 {
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    #[test]
    fn colours_can_be_told_apart_and_read_on_both_pages() {
        let page = &TONES[2];
        for (i, tone) in TONES.iter().enumerate() {
            for other in &TONES[..i] {
                assert!(tone.1 != other.1 && tone.2 != other.2 && tone.0 != other.0, "{} and {}", tone.0, other.0);
            }
            let least = match tone.0 {
                "page" | "band" | "rule" | "unknown" => continue,
                name if name.starts_with("step") => continue,
                "quiet" => 2.5,
                "ink" | "faint" | "bad" => 4.5,
                _ => 4.0,
            };
            for (color, page) in [(tone.1, page.1), (tone.2, page.2)] {
                assert!(contrast(color, page) >= least, "{}: {}", tone.0, contrast(color, page));
            }
        }
    }

    #[test]
    fn the_scale_moves_away_from_the_background_on_both_pages() {
        let steps: Vec<&Tone> = TONES.iter().filter(|tone| tone.0.starts_with("step")).collect();
        assert_eq!(steps.len(), STEPS.len());
        for pair in steps.windows(2) {
            assert!(contrast(pair[0].1, PAGE) < contrast(pair[1].1, PAGE), "{}", pair[1].0);
            assert!(contrast(pair[0].2, TONES[2].2) < contrast(pair[1].2, TONES[2].2), "{}", pair[1].0);
        }
    }
}
