//! The charts, as SVG:
//!
//! - `on_scenes`: the tracer's speed on whole scenes with every kernel, and the wrong answers there, as a dot plot;
//! - `speed_accuracy`: speed of every kernel, and how often it is wrong, as a dot plot;
//! - `packets`: speed of packets over scalar code, and how close packets come to the machine's limit;
//! - `stability`: for each regime, the errors from the easy steps to the hard ones;
//! - `failure_map`: for each kernel, the error of `t` over two severities, as an image;
//! - `coherence`: the modes of the tracer on less and less coherent rays;
//! - `scaling`: the cost of a ray in larger and larger scenes;
//! - `peers`: rays per second of this crate's tracer and of others.
//!
//! `dot_plot` and `panel` are the two forms of most charts. No colour stands for a kernel: kernels are told apart by
//! their names, beside their row or at the end of their line.
//!
//! plotters maps values to pixels and draws the axes. Names and legends are placed in pixels by the code here, so that
//! they do not overlap. An SVG without fonts cannot measure text, so kernel names are set in a monospaced font of known
//! width.

mod axis;
mod canvas;
mod coherence;
mod dot_plot;
mod failure_map;
mod file_names;
mod hover;
mod layout;
mod look;
mod on_scenes;
mod packets;
mod palette;
mod panel;
mod peers;
mod scaling;
mod speed_accuracy;
mod stability;
mod svg;

pub(crate) use file_names::{
    COHERENCE, ON_SCENES, PACKETS, PEERS, SCALING, SPEED_ACCURACY, SPEED_ACCURACY_INSTANCES, failure_map_file, maps_of,
    stability_file,
};
pub(crate) use palette::page_style;
pub(crate) use svg::escaped;

use crate::study::figures::groups;
use crate::study::record::Record;

/// A chart: the name of its file, and its SVG. The SVG has light colours, which [`page_style`] or
/// [`file_content`](Self::file_content) replace on dark pages.
pub(crate) struct Chart {
    pub(crate) file: String,
    pub(crate) svg: String,
}

impl Chart {
    /// The SVG with a style sheet of its own.
    pub(crate) fn file_content(&self) -> String {
        let (start, rest) = self.svg.split_once('>').expect("an SVG starts with a tag");
        format!("{start}>\n<style>{}</style>{rest}", palette::file_style(&self.svg))
    }
}

/// All charts of a record.
pub(crate) fn charts(record: &Record) -> Vec<Chart> {
    let groups = groups(record);
    let (bases, instances): (Vec<_>, Vec<_>) = groups.iter().partition(|group| group.is_base());
    let on_scenes = on_scenes::svg(record, &bases).map(|svg| Chart { file: ON_SCENES.into(), svg });
    let mut charts: Vec<_> = on_scenes.into_iter().collect();
    charts.push(Chart { file: SPEED_ACCURACY.into(), svg: speed_accuracy::svg(record, &bases) });
    if !instances.is_empty() {
        charts.push(Chart { file: SPEED_ACCURACY_INSTANCES.into(), svg: speed_accuracy::svg(record, &instances) });
    }
    if groups.iter().any(|group| group.kernels.iter().any(|kernel| kernel.gain().is_some())) {
        charts.push(Chart { file: PACKETS.into(), svg: packets::svg(record, &bases) });
    }
    for group in &groups {
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

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::study::figures::Group;
    use crate::study::tests::fixture::{all_ids, degenerate_records, record_of};

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
        let groups = groups(&record);
        let with_maps: BTreeSet<_> = record.maps.iter().map(|map| &map.family).collect();
        assert_eq!(charts.len(), 7 + record.regimes.len() + with_maps.len());
        for chart in &charts {
            sound(chart);
            if [COHERENCE, SCALING, PEERS].contains(&chart.file.as_str()) {
                continue; // These show no kernels.
            }
            let regime = record.regimes.iter().find(|regime| stability_file(regime) == chart.file);
            let shown: Vec<_> = match chart.file.as_str() {
                SPEED_ACCURACY | PACKETS => groups.iter().filter(|group| group.is_base()).collect(),
                ON_SCENES => {
                    groups.iter().filter(|group| ["triangle", "quadric"].contains(&group.title.as_str())).collect()
                }
                SPEED_ACCURACY_INSTANCES => groups.iter().filter(|group| !group.is_base()).collect(),
                file => {
                    let is_for = |group: &&Group| {
                        regime.map_or(file == failure_map_file(group), |regime| regime.family == group.title)
                    };
                    groups.iter().filter(is_for).collect()
                }
            };
            let kernels: Vec<_> = shown.iter().flat_map(|group| &group.kernels).collect();
            assert!(kernels.len() >= 3, "{}", chart.file);
            for kernel in kernels {
                // In a stability chart, a label may count the kernels of a shared line: the tooltip names them all.
                let (id, name) = (&kernel.method.id, kernel.name.rsplit('/').next().unwrap_or_default());
                let is_shown = |text: &&str| chart.svg.contains(&format!(">{text}<"));
                let is_named = is_shown(&name) || failure_map::lines_of(&kernel.name).iter().all(is_shown);
                let is_told = chart.svg.contains(&format!("{id}, "));
                assert!(is_told || is_named && regime.is_none(), "{}: {id}", chart.file);
                assert!(is_named || regime.is_some(), "{}: {name}", chart.file);
            }
        }
    }

    #[test]
    fn charts_depend_only_on_the_record() {
        let svgs = || charts(&record_of(&all_ids())).into_iter().map(|chart| chart.svg).collect::<Vec<_>>();
        assert!(svgs() == svgs());
    }

    #[test]
    fn every_title_fits_one_line() {
        for chart in charts(&record_of(&all_ids())) {
            let titles = chart.svg.lines().filter(|line| line.contains(" font-size=\"18\" "));
            assert_eq!(titles.count(), 1, "the title of {} is longer than one line", chart.file);
        }
    }

    #[test]
    fn every_text_is_readable_on_a_phone() {
        for chart in charts(&record_of(&all_ids())) {
            let width = chart.svg.split('"').skip_while(|text| !text.ends_with(" width=")).nth(1).unwrap();
            let size = layout::TEXT * 390.0 / width.parse::<f64>().unwrap();
            assert!(size >= 9.0, "{}: {size} pixels", chart.file);
        }
    }

    #[test]
    fn legends_of_dot_plots_have_at_most_two_lines() {
        let charts = charts(&record_of(&all_ids()));
        for (file, first) in [(ON_SCENES, "primary"), (SPEED_ACCURACY, "8x1")] {
            let svg = &charts.iter().find(|chart| chart.file == file).unwrap().svg;
            let y = |text: &str| -> i32 {
                let line = svg.lines().find(|line| line.contains(&format!(">{text}</text>"))).unwrap();
                line.split('"').skip_while(|text| !text.ends_with(" y=")).nth(1).unwrap().parse().unwrap()
            };
            assert!((0..=layout::LINE).contains(&(y("over 0.1 %") - y(first))), "{file}");
        }
    }

    #[test]
    fn every_colour_has_a_value_for_dark_pages() {
        for chart in charts(&record_of(&all_ids())) {
            for attribute in ["fill", "stroke"] {
                let (all, classes) = (format!("{attribute}=\"#"), format!("class=\"{}-", &attribute[..1]));
                assert_eq!(chart.svg.matches(&all).count(), chart.svg.matches(&classes).count(), "{}", chart.file);
            }
            assert!(chart.file_content().contains(">\n<style>@media(prefers-color-scheme:dark){.f-ink{fill:#E2E6EA}"));
        }
    }

    #[test]
    fn degenerate_records_have_charts() {
        for record in degenerate_records() {
            let charts = charts(&record);
            assert!(!charts.is_empty());
            charts.iter().for_each(sound);
        }
    }
}
