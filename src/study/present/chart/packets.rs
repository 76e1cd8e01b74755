//! `packets.svg`: the gain of packets of eight over scalar code, and how close packets come to the machine's limit.

use super::canvas::machine;
use super::dot_plot::{Dot, DotPlot, Group as Rows, Kind, Panel, Row, Scale};
use crate::study::figures::{Group, KernelFigures, number, optional, percent, times};
use crate::study::record::Record;

/// Draws the kernels of these groups.
pub(super) fn svg(record: &Record, groups: &[&Group]) -> String {
    let panel = |title: &str, reference| Panel {
        title: title.into(),
        kind: Kind::Speed,
        scale: Scale::Linear,
        share: 1,
        reference: Some(reference),
        marks: Vec::new(),
    };
    let rows = groups
        .iter()
        .map(|group| Rows { heading: Some(group.title.clone()), rows: group.kernels.iter().map(row).collect() });
    let plot = DotPlot {
        title: "Packets of eight against scalar code".into(),
        remarks: vec![
            "Limit: the machine's least time for the busiest class of operations (their number times their measured \
             rate)."
                .into(),
            machine(record) + ", one thread",
        ],
        panels: vec![
            panel("gain: time of 1x1 / time of 8x1 (line: 8)", 8.0),
            panel("limit as a share of the time, % (line: 100 %)", 100.0),
        ],
        groups: rows.collect(),
        failure: String::new(),
    };
    plot.svg()
}

fn row(kernel: &KernelFigures) -> Row {
    let figures = [kernel.gain(), kernel.limit_share().map(|share| 100.0 * share)];
    let dot = |value| Dot { mark: 0, value, interval: None, failed: false, tooltip: tooltip(kernel) };
    Row {
        id: kernel.method.id.clone(),
        name: kernel.name.clone(),
        bold: false,
        recommended: false,
        cells: figures.map(|value| value.filter(|value| value.is_finite()).map(dot).into_iter().collect()).into(),
    }
}

/// The tooltip of a kernel's dots.
fn tooltip(kernel: &KernelFigures) -> String {
    let ns = |width| format!("{width}: {} ns per test", optional(kernel.ns(width), 3));
    let limit = kernel.packet().and_then(|row| Some((row.limit_by.clone()?, number(row.limit_ns?, 3))));
    format!(
        "{}, {}, gain {}, limit {} of the time{}",
        ns("1x1"),
        ns("8x1"),
        times(kernel.gain()),
        percent(kernel.limit_share()),
        limit.map_or(String::new(), |(class, ns)| format!(" ({ns} ns, busiest class: {class})"))
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::figures::groups;
    use crate::study::tests::fixture::{all_ids, record_of};

    #[test]
    fn every_kernel_shows_its_gain_and_its_share_of_the_limit() {
        let record = record_of(&all_ids());
        let groups = groups(&record);
        let svg = svg(&record, &groups.iter().filter(|group| group.is_base()).collect::<Vec<_>>());
        for kernel in groups.iter().filter(|group| group.is_base()).flat_map(|group| &group.kernels) {
            let title = format!("<title>{}, {}</title>", kernel.method.id, tooltip(kernel));
            assert_eq!(svg.matches(&title).count(), 2, "{title}");
            for figure in [times(kernel.gain()), percent(kernel.limit_share())] {
                assert!(title.contains(&figure), "{}: {figure}", kernel.name);
            }
        }
    }
}
