//! The frame of a chart: an empty canvas, the header, and the styles of text.

use std::convert::Infallible;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::layout::{LINE, MARGIN, PROPORTIONAL, Pixel, TEXT, TITLE};
use super::palette::{FAINT, INK, PAGE};
use super::svg::{FONT_SCALE, Svg};
use crate::study::record::Record;

pub(super) type Area<'a> = DrawingArea<Svg<'a>, Shift>;
pub(super) type Drawing<T> = Result<T, DrawingAreaErrorKind<Infallible>>;
pub(super) type Drawn = Drawing<()>;

/// Draws an SVG of this size.
pub(super) fn canvas((width, height): Pixel, draw: impl FnOnce(&Area) -> Drawn) -> String {
    let mut svg = String::new();
    let root = Svg::new(&mut svg, (width as u32, height as u32)).into_drawing_area();
    // A page may be dark although its reader prefers light pages, so a chart has its own background.
    let drawn = root.fill(&PAGE).and_then(|()| draw(&root)).and_then(|()| root.present());
    drawn.expect("writing to a string cannot fail");
    drop(root);
    svg
}

/// Draws the title in bold and the remarks below it. Returns the vertical position of the next line.
pub(super) fn header(root: &Area, width: i32, title: &str, remarks: &[String]) -> Drawing<i32> {
    let mut y = 10;
    for line in wrapped(title, width - 2 * MARGIN, 1.1 * TITLE) {
        root.draw_text(&line, &heading(TITLE), (MARGIN, y + 14))?;
        y += 24;
    }
    for line in remarks.iter().flat_map(|remark| wrapped(remark, width - 2 * MARGIN, TEXT)) {
        root.draw_text(&line, &label(TEXT, FAINT), (MARGIN, y + 10))?;
        y += LINE;
    }
    Ok(y + 6)
}

/// Height of [`header`].
pub(super) fn header_height(width: i32, title: &str, remarks: &[String]) -> i32 {
    let lines = |text: &str, size| wrapped(text, width - 2 * MARGIN, size).len() as i32;
    16 + 24 * lines(title, 1.1 * TITLE) + LINE * remarks.iter().map(|remark| lines(remark, TEXT)).sum::<i32>()
}

/// Breaks text between words into lines of about `width` pixels.
pub(super) fn wrapped(text: &str, width: i32, size: f64) -> Vec<String> {
    let most = (f64::from(width) / (PROPORTIONAL * size)) as usize;
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut().filter(|line| line.chars().count() + word.chars().count() < most) {
            Some(line) => *line = format!("{line} {word}"),
            None => lines.push(word.to_owned()),
        }
    }
    lines
}

/// The machine and the compiler of the record, for the header.
pub(super) fn machine(record: &Record) -> String {
    let quick = if record.quick { ", quick run: fewer rays and samples" } else { "" };
    // The version of the compiler without its commit.
    let rustc = record.machine.rustc.split(" (").next().unwrap_or_default();
    format!("{}, {rustc}{quick}", record.machine.cpu)
}

/// The style of text that starts at a point and is vertically centred on it.
pub(super) fn label(size: f64, color: RGBColor) -> TextStyle<'static> {
    styled(FontFamily::SansSerif, FontStyle::Normal, size, color)
}

pub(super) fn heading(size: f64) -> TextStyle<'static> {
    styled(FontFamily::SansSerif, FontStyle::Bold, size, INK)
}

/// The style of kernel names.
pub(super) fn name(bold: bool, color: RGBColor) -> TextStyle<'static> {
    styled(FontFamily::Monospace, if bold { FontStyle::Bold } else { FontStyle::Normal }, TEXT, color)
}

fn styled(family: FontFamily<'static>, style: FontStyle, size: f64, color: RGBColor) -> TextStyle<'static> {
    FontDesc::new(family, size * FONT_SCALE, style).color(&color).pos(Pos::new(HPos::Left, VPos::Center))
}

/// This style, horizontally centred.
pub(super) fn centered(style: TextStyle<'static>) -> TextStyle<'static> {
    style.pos(Pos::new(HPos::Center, VPos::Center))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_text_is_broken_between_words() {
        let text = "every word of a title that is too long for one line stands in one of its lines";
        let lines = wrapped(text, 200, TEXT);
        assert!(lines.len() > 2 && lines.iter().all(|line| line.len() < 30), "{lines:?}");
        assert_eq!(lines.join(" "), text);
    }
}
