//! The comparison with peers as tables: for a terminal, for `peers.md` and for the study's report.

use super::grid::{Cell, Grid};
use crate::study::figures::peers::{is_ours, ratio};
use crate::study::figures::{MISSING, count, number, optional};
use crate::study::record::{OURS, PeerRow, PeersRecord, TargetRow};
use crate::tracer::Mode;

/// The meaning of the columns of [`rates`].
pub(crate) const LEGEND: &str = "\
Million rays per second with one thread (1T), median of the rounds ± median absolute deviation, and with two threads \
(2T). *Ratio*: speed of raylanes in mode auto over the speed of this tracer, both with one thread, formed within each \
round. The next four columns count rays on which the tracer disagrees with raylanes in mode scalar. *Only ours*: only \
raylanes reports a hit. *Only it*: only the other tracer does. *Other*: both hit, but different primitives at \
different `t`. *Tie*: both hit different primitives at about the same `t`, and both are right (an edge that two \
triangles share, or a triangle that occurs twice). *B/tri*: bytes per triangle of everything that the tracer keeps. \
The table does not show what mode auto chose.";

/// A heading and a table for each scene and set of rays. The fastest with one thread is marked as best.
pub(crate) fn rates(rows: &[PeerRow]) -> Vec<(String, Grid)> {
    rows.chunk_by(|a, b| (&a.scene, &a.rays) == (&b.scene, &b.rays)).map(|set| (heading(set), rates_of(set))).collect()
}

fn heading(set: &[PeerRow]) -> String {
    let PeerRow { scene, rays, ray_count, hits, triangles, .. } = &set[0];
    let [triangles, ray_count, hits] = [triangles, ray_count, hits].map(|&value| count(value as u64));
    format!("{scene}, {rays}: {triangles} triangles, {ray_count} rays, {hits} hits")
}

fn rates_of(set: &[PeerRow]) -> Grid {
    let header =
        ["tracer", "Mrays/s 1T", "±", "ratio", "2T", "only ours", "only it", "other", "tie", "build s", "B/tri"];
    let mut grid = Grid::new(1, header);
    let ours = set.iter().find(|row| is_ours(row, Mode::Auto) && row.threads == 1);
    let one_thread = || set.iter().filter(|row| row.threads == 1);
    let best = one_thread().map(|row| row.mrays_per_second).reduce(f64::max);
    for row in one_thread() {
        let name = |row: &PeerRow| (row.tracer.clone(), row.configuration.clone());
        let two = set.iter().find(|other| other.threads == 2 && name(other) == name(row));
        let found = row.disagreements;
        let differing = [found.only_first, found.only_second, found.other_primitive, found.ties];
        let mut cells = vec![
            Cell::from(format!("{} {}", row.tracer, row.configuration)),
            Cell::from(number(row.mrays_per_second, 3)).best_if(Some(row.mrays_per_second) == best),
            Cell::from(number(row.mrays_per_second_mad, 2)),
            Cell::from(optional(ours.map(|ours| ratio(ours, row).0), 3)),
            Cell::from(optional(two.map(|row| row.mrays_per_second), 3)),
        ];
        // Our modes never disagree, else there would be no record.
        cells.extend(
            differing.map(|rays| Cell::from(if row.tracer == OURS { String::new() } else { count(rays as u64) })),
        );
        cells.push(Cell::from(number(row.build_seconds, 3)));
        cells.push(Cell::from(optional(row.bytes_per_triangle, 3)));
        grid.rows.push(cells);
    }
    grid
}

/// The targets, and whether they are met. A target that is not met is marked as a failure.
fn targets(judged: &[TargetRow]) -> Grid {
    let mut grid = Grid::new(4, ["scene", "rays", "against", "peer", "target", "aim", "ratio", "±", "verdict"]);
    for row in judged {
        let bound = match (row.least, row.most) {
            (Some(least), _) => format!("≥ {least}"),
            (None, Some(most)) => format!("≤ {most}"),
            (None, None) => MISSING.into(),
        };
        let verdict = match row.met {
            Some(true) => "met",
            Some(false) => "not met",
            None if row.ratio.is_some() => "within caches",
            None => "not measured",
        };
        grid.rows.push(vec![
            Cell::from(row.scene.as_str()),
            Cell::from(row.rays.as_str()),
            Cell::from(row.against.as_str()),
            Cell::from(row.peer.as_deref().unwrap_or(MISSING)),
            Cell::from(bound),
            Cell::from(row.aim.map_or(MISSING.into(), |aim| aim.to_string())),
            Cell::from(optional(row.ratio, 3)),
            Cell::from(optional(row.ratio_mad, 2)),
            Cell::from(verdict).best_if(row.met == Some(true)).bad_if(row.met == Some(false)),
        ]);
    }
    grid
}

/// The whole comparison as text for a terminal. `color` adds ANSI colours.
pub fn terminal(record: &PeersRecord, color: bool) -> String {
    let mut text = String::new();
    for (heading, grid) in rates(&record.peers) {
        text += &format!("{heading}\n{}\n", grid.terminal(color));
    }
    text + &targets(&record.targets).terminal(color)
}

/// The whole comparison in Markdown.
pub(crate) fn markdown(record: &PeersRecord) -> String {
    let PeersRecord { machine, size, rounds, seed, kernel, seconds, .. } = record;
    let mut parts = vec![
        "# raylanes and its peers".to_owned(),
        format!(
            "All tracers trace the same rays, those of a picture of {size} × {size} pixels (seed {seed}). They take \
             turns, in {rounds} rounds after a warm-up, and write hits of the same form to the same memory. The time \
             includes converting rays and hits, but not building. The triangle kernel of raylanes is `{kernel}`. All \
             of it took {} s.",
            number(*seconds, 3)
        ),
        format!(
            "{}, {} logical processors, {}, {}; {}.",
            machine.cpu,
            machine.processors,
            machine.os,
            machine.rustc,
            machine.versions.join(", ")
        ),
        "## Targets".to_owned(),
        "The ratio is rays per second of raylanes in mode auto over those of the fastest peer of a kind. It is formed \
         within each round: median ± median absolute deviation. All with one thread, except where the table says two."
            .to_owned(),
        targets(&record.targets).markdown(),
        format!("## Rates\n\n{LEGEND}"),
    ];
    for (heading, grid) in rates(&record.peers) {
        parts.push(format!("### {heading}"));
        parts.push(grid.markdown());
    }
    parts.iter().map(|part| part.trim_end()).collect::<Vec<_>>().join("\n\n") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::figures::peers::judge;
    use crate::study::record::EMBREE;
    use crate::study::tests::fixture::peer_row;

    #[test]
    fn a_row_shows_both_thread_counts_the_ratio_and_the_disagreements() {
        let rows = [
            peer_row(OURS, "auto", 1, &[20.0, 20.0, 30.0]),
            peer_row(EMBREE, "robust", 1, &[10.0, 10.0, 12.0]),
            peer_row(EMBREE, "robust", 2, &[19.0, 19.5, 19.0]),
        ];
        let [(heading, grid)] = &rates(&rows)[..] else { panic!("one scene with one set of rays makes one table") };
        assert_eq!(heading, "spheres, primary: 81,920 triangles, 1,048,576 rays, 700,000 hits");
        let lines: Vec<_> = grid.markdown().lines().map(str::to_owned).collect();
        assert_eq!(lines[2], "| raylanes auto | **20.0** | 0 | 1.00 | – |  |  |  |  | 0.210 | – |");
        assert_eq!(lines[3], "| Embree robust | 10.0 | 0 | 2.00 | 19.0 | 1 | 2 | 4 | 30 | 0.210 | – |");
        assert_eq!(lines.len(), 4);
    }

    #[test]
    fn a_target_is_met_not_met_or_not_measured() {
        let rows = [peer_row(OURS, "auto", 1, &[12.0]), peer_row(EMBREE, "fast", 1, &[10.0])];
        let text = targets(&judge(&rows, None)).markdown();
        assert!(
            text.contains("| spheres | primary | Embree, best | fast | ≥ 1.5 | 2 | 1.20 | 0 | not met |"),
            "{text}"
        );
        assert!(text.contains("| Rust peers, best | – | ≥ 2 | 2 | – | – | not measured |"), "{text}");
        let rows = [peer_row(OURS, "auto", 1, &[16.0]), peer_row(EMBREE, "fast", 1, &[10.0])];
        assert!(targets(&judge(&rows, None)).markdown().contains("| 1.60 | 0 | **met** |"));
    }
}
