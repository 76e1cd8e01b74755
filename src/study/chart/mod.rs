//! The charts, as SVG:
//!
//! - `speed_accuracy`: every kernel's speed against its error of `t` and against the rays it loses;
//! - `packets`: what packets gain over scalar code, and their share of the machine's limit;
//! - `stability`: for each regime, what goes wrong from the easy steps to the hard ones;
//! - `failure_map`: for each kernel, the error of `t` over two severities at once, as an image;
//! - `coherence`: the tracer's modes on rays that have ever less in common;
//! - `scaling`: the cost of a ray in ever larger scenes;
//! - `peers`: rays per second of this crate's tracer and others.
//!
//! plotters maps values to pixels and draws the axes. What must not overlap is placed here, in pixels,
//! since a chart without fonts cannot measure text: kernel names are set in a monospaced face, whose width is known.

mod axis;
mod coherence;
mod failure_map;
mod hover;
mod look;
mod packets;
mod panel;
mod peers;
mod scaling;
mod speed_accuracy;
mod stability;
mod svg;

use std::convert::Infallible;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

pub(super) use self::svg::escaped;
use self::svg::{FONT_SCALE, Svg};
use super::figures::{Group, groups, groups_of_methods};
use super::record::{MapRow, Record, RegimeRow};

type Area<'a> = DrawingArea<Svg<'a>, Shift>;
type Drawing<T> = Result<T, DrawingAreaErrorKind<Infallible>>;
type Drawn = Drawing<()>;
type Pixel = (i32, i32);

const INK: RGBColor = RGBColor(40, 40, 40);
const FAINT: RGBColor = RGBColor(120, 120, 120);
const GRID: RGBColor = RGBColor(228, 228, 228);

/// Charts are at least this wide; long names widen them.
const WIDTH: i32 = 1060;
const LEFT: i32 = 66;
const MARGIN: i32 = 16;
const TEXT: f64 = 13.0;
const TITLE: f64 = 18.0;
/// From one line of text to the next.
const LINE: i32 = 17;
/// Advance of a character of [`TEXT`] size in the widest of the common monospaced faces.
const ADVANCE: f64 = 0.605 * TEXT;
/// The same of a proportional face, on average over a line, generously; bold is wider.
const PROPORTIONAL: f64 = 0.58;

/// The file of a chart and what it contains.
pub(super) struct Chart {
    pub(super) file: String,
    pub(super) svg: String,
}

/// Every chart of a record.
pub(super) fn charts(record: &Record) -> Vec<Chart> {
    let groups = groups(record);
    let (bases, instances): (Vec<_>, Vec<_>) = groups.iter().partition(|group| group.is_base());
    let mut charts = vec![Chart { file: SPEED_ACCURACY.into(), svg: speed_accuracy::overview(record, &bases) }];
    if !instances.is_empty() {
        charts.push(Chart { file: SPEED_ACCURACY_INSTANCES.into(), svg: speed_accuracy::stacked(record, &instances) });
    }
    if groups.iter().any(|group| group.kernels.iter().any(|kernel| kernel.gain().is_some())) {
        charts.push(Chart { file: PACKETS.into(), svg: packets::svg(record, &bases) });
    }
    for group in &groups_of_methods(record) {
        for regime in record.regimes.iter().filter(|regime| regime.family == group.title) {
            charts.push(Chart { file: stability_file(regime), svg: stability::svg(record, group, regime) });
        }
        let maps = maps_of(record, group);
        if !maps.is_empty() {
            charts.push(Chart { file: failure_map_file(group), svg: failure_map::svg(record, group, &maps) });
        }
    }
    if !record.coherence.is_empty() {
        charts.push(Chart { file: COHERENCE.into(), svg: coherence::svg(record) });
    }
    if !record.scaling.is_empty() {
        charts.push(Chart { file: SCALING.into(), svg: scaling::svg(record) });
    }
    if !record.peers.is_empty() {
        charts.push(Chart { file: PEERS.into(), svg: peers::svg(record) });
    }
    charts
}

/// File of the chart of raylanes and its peers.
pub(super) const PEERS: &str = "peers.svg";
/// File of the chart of all kernels that are no instances.
pub(super) const SPEED_ACCURACY: &str = "speed-accuracy.svg";
/// File of the same chart of the instances.
pub(super) const SPEED_ACCURACY_INSTANCES: &str = "speed-accuracy-instances.svg";

/// File of the chart of what packets gain.
pub(super) const PACKETS: &str = "packets.svg";
/// File of the chart of modes by coherence.
pub(super) const COHERENCE: &str = "coherence.svg";
/// File of the chart of cost by size.
pub(super) const SCALING: &str = "scaling.svg";

/// File of a regime's chart.
pub(super) fn stability_file(regime: &RegimeRow) -> String {
    format!("stability-{}-{}.svg", regime.family.replace(' ', "-"), regime.name)
}

/// File of a group's failure maps.
pub(super) fn failure_map_file(group: &Group) -> String {
    format!("failure-map-{}.svg", group.title.replace(' ', "-"))
}

/// The failure maps that are for a group.
pub(super) fn maps_of<'a>(record: &'a Record, group: &Group) -> Vec<&'a MapRow> {
    record.maps.iter().filter(|map| map.family == group.title).collect()
}

/// An SVG of that size.
fn canvas((width, height): Pixel, draw: impl FnOnce(&Area) -> Drawn) -> String {
    let mut svg = String::new();
    let root = Svg::new(&mut svg, (width as u32, height as u32)).into_drawing_area();
    // Pages are white or dark; a chart brings its own background.
    let drawn = root.fill(&WHITE).and_then(|()| draw(&root)).and_then(|()| root.present());
    drawn.expect("a string takes whatever is written to it");
    drop(root);
    svg
}

/// A chart's message in bold, and lines below it; returns where the next line would be.
fn header(root: &Area, width: i32, title: &str, remarks: &[String]) -> Drawing<i32> {
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
fn header_height(width: i32, title: &str, remarks: &[String]) -> i32 {
    let lines = |text: &str, size| wrapped(text, width - 2 * MARGIN, size).len() as i32;
    16 + 24 * lines(title, 1.1 * TITLE) + LINE * remarks.iter().map(|remark| lines(remark, TEXT)).sum::<i32>()
}

/// Words in lines that are about as long as `width` allows.
fn wrapped(text: &str, width: i32, size: f64) -> Vec<String> {
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

/// Where the record is from, for the header.
fn machine(record: &Record) -> String {
    let quick = if record.quick { ", quick run: fewer rays and samples" } else { "" };
    format!("{}, {}{quick}", record.machine.cpu, record.machine.rustc)
}

/// Text that begins at a point, vertically centred on it.
fn label(size: f64, color: RGBColor) -> TextStyle<'static> {
    styled(FontFamily::SansSerif, FontStyle::Normal, size, color)
}

fn heading(size: f64) -> TextStyle<'static> {
    styled(FontFamily::SansSerif, FontStyle::Bold, size, INK)
}

/// Kernel names.
fn name(bold: bool) -> TextStyle<'static> {
    styled(FontFamily::Monospace, if bold { FontStyle::Bold } else { FontStyle::Normal }, TEXT, INK)
}

fn styled(family: FontFamily<'static>, style: FontStyle, size: f64, color: RGBColor) -> TextStyle<'static> {
    FontDesc::new(family, size * FONT_SCALE, style).color(&color).pos(Pos::new(HPos::Left, VPos::Center))
}

/// The same, horizontally centred.
fn centered(style: TextStyle<'static>) -> TextStyle<'static> {
    style.pos(Pos::new(HPos::Center, VPos::Center))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::study::fixture::{all_ids, degenerate_records, record_of};

    fn sound(chart: &Chart) {
        let svg = &chart.svg;
        assert!(!svg.contains("NaN") && !svg.contains("inf\"") && svg.contains("</svg>"), "{}", chart.file);
        for limit in [i32::MAX, i32::MIN] {
            assert!(!svg.contains(&limit.to_string()), "{}", chart.file);
        }
    }

    #[test]
    fn every_group_regime_and_map_has_a_chart_that_names_its_kernels() {
        let record = record_of(&all_ids());
        let charts = charts(&record);
        let (groups, methods) = (groups(&record), groups_of_methods(&record));
        let with_maps: BTreeSet<_> = record.maps.iter().map(|map| &map.family).collect();
        assert_eq!(charts.len(), 6 + record.regimes.len() + with_maps.len());
        for chart in &charts {
            sound(chart);
            if [COHERENCE, SCALING, PEERS].contains(&chart.file.as_str()) {
                continue; // of no kernels
            }
            let regime = record.regimes.iter().find(|regime| stability_file(regime) == chart.file);
            let shown: Vec<_> = match chart.file.as_str() {
                SPEED_ACCURACY | PACKETS => groups.iter().filter(|group| group.is_base()).collect(),
                SPEED_ACCURACY_INSTANCES => groups.iter().filter(|group| !group.is_base()).collect(),
                file => {
                    let is_for = |group: &&Group| {
                        regime.map_or(file == failure_map_file(group), |regime| regime.family == group.title)
                    };
                    methods.iter().filter(is_for).collect()
                }
            };
            let kernels: Vec<_> = shown.iter().flat_map(|group| &group.kernels).collect();
            assert!(kernels.len() >= 3, "{}", chart.file);
            for kernel in kernels {
                assert!(chart.svg.contains(&format!(">{}<", kernel.name)), "{}: {}", chart.file, kernel.name);
            }
        }
    }

    #[test]
    fn charts_depend_on_nothing_but_the_record() {
        let svgs = || charts(&record_of(&all_ids())).into_iter().map(|chart| chart.svg).collect::<Vec<_>>();
        assert!(svgs() == svgs());
    }

    #[test]
    fn degenerate_records_have_charts() {
        for record in degenerate_records() {
            let charts = charts(&record);
            assert!(!charts.is_empty());
            charts.iter().for_each(sound);
        }
    }

    #[test]
    fn long_titles_are_wrapped_between_words() {
        let text = "every word of a title that is too long for one line stands in one of its lines";
        let lines = wrapped(text, 200, TEXT);
        assert!(lines.len() > 2 && lines.iter().all(|line| line.len() < 30), "{lines:?}");
        assert_eq!(lines.join(" "), text);
    }
}
