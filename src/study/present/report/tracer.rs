//! The sections on the tracer: throughput, threads, memory, coherence, and growth with the size of the scene.

use super::cells::{code, with_mad};
use crate::study::figures::tracer::{Coherence, Growth, TracedSet, modes};
use crate::study::figures::{
    Group, KernelFigures, MISSING, Scaling, count, number, optional, severity, thread_counts, times,
};
use crate::study::present::chart::{COHERENCE, SCALING};
use crate::study::present::grid::{Cell, Grid};
use crate::study::record::{CoherenceRow, Record, TracerRow};

/// The scenes, and the modes side by side.
pub(super) fn throughput(record: &Record) -> Vec<String> {
    let all = TracedSet::all(record);
    if all.is_empty() {
        return Vec::new();
    }
    vec![
        "## Tracer\n\nWhole scenes, each with four sets of rays. *Primary* rays of a picture, and *shadow* rays from \
         where they hit, are coherent. *Bounce* and *ambient occlusion* rays leave the hit points in all directions. \
         Shadow and ambient occlusion rays look for any hit, the others for the closest hit. All modes and thread \
         counts gave the same bits. Bytes are those of geometry, prepared primitives and nodes. A scene is built on \
         all threads."
            .to_owned(),
        scenes(&all),
        "### Modes\n\nMillion rays per second in one thread, median ± median absolute deviation. The fastest mode and \
         all that tie with it are bold.\n\n\
         - *scalar*: the reference, one ray at a time.\n\
         - *single*: one ray against eight boxes or triangles.\n\
         - *packet*: coherent rays in blocks, other rays in packets of eight.\n\
         - *auto*: coherent rays in blocks, other rays in streams (in packets of eight if the scene has instances).\n\n\
         *Auto / best* is auto over the faster of single and packet. *Gain* is auto over scalar."
            .to_owned(),
        side_by_side(&all),
    ]
}

/// Throughput with several threads over throughput with one, of kernels and of the tracer.
pub(super) fn several_threads(record: &Record, groups: &[Group]) -> Vec<String> {
    let all = TracedSet::all(record);
    let counts = record.speed.iter().map(|row| row.threads).chain(record.tracer.iter().map(|row| row.threads));
    let mut parts = Vec::new();
    for threads in thread_counts(counts.filter(|&threads| threads > 1)) {
        parts.push(format!(
            "## {threads} threads against one\n\nThroughput with {threads} threads over throughput with one. In \
             brackets is the 95 % interval of the ratio, which is formed within rounds. Each thread runs a kernel on \
             its own data in its own first-level cache. A kernel that stays below {threads}× is slowed down by what \
             the cores share, or by other work on the machine. More than {threads}× is no fact about a kernel: the \
             machine was noisy, or the clock changes with the number of busy cores.{}",
            min_and_max(&all, threads).map_or(String::new(), |range| format!(" Tracer in mode auto: {range}."))
        ));
        parts.extend([kernels_by_threads(groups, threads), by_threads(&all, threads)].into_iter().flatten());
    }
    parts
}

/// For each group of kernels: minimum, median and maximum of throughput with several threads over one.
fn kernels_by_threads(groups: &[Group], threads: usize) -> Option<String> {
    let mut grid = Grid::new(1, ["kernels, in packets of eight", "min", "median", "max"]);
    for group in groups {
        let scaling = |kernel: &KernelFigures| kernel.scaling("8x1", threads);
        let mut scalings: Vec<Scaling> = group.kernels.iter().filter_map(scaling).collect();
        scalings.sort_by(|a, b| a.value().total_cmp(&b.value()));
        if let [least, .., greatest] = scalings[..] {
            let figures =
                [least, scalings[scalings.len() / 2], greatest].map(|scaling| Cell::from(scaling.to_string()));
            grid.rows.push([Cell::from(group.heading())].into_iter().chain(figures).collect());
        }
    }
    (!grid.rows.is_empty()).then(|| grid.markdown())
}

/// Bytes per primitive, and the cost of a ray as the number of primitives grows.
pub(super) fn memory(record: &Record, groups: &[Group]) -> Vec<String> {
    let mut grid = Grid::new(1, ["kernels", "min bytes", "max bytes"]);
    for group in groups {
        let bytes = |kernel: &KernelFigures| (kernel.method.prepared_bytes, kernel.name.clone());
        let (least, most) = (group.kernels.iter().map(bytes).min(), group.kernels.iter().map(bytes).max());
        let cells = [least, most].into_iter().flatten().map(|(bytes, name)| Cell::from(format!("{bytes} (`{name}`)")));
        grid.rows.push([Cell::from(group.heading())].into_iter().chain(cells).collect());
    }
    let mut parts = vec![
        "## Memory\n\nBytes that kernels prepare per primitive. A tree adds its nodes. It also adds the vertices, if \
         they cannot be computed from the prepared data."
            .to_owned(),
        grid.markdown(),
    ];
    parts.extend(growth(record));
    parts
}

fn scenes(all: &[TracedSet]) -> String {
    let mut grid = Grid::new(2, ["scene", "kernel", "primitives", "instances", "build s", "bytes / primitive"]);
    let mut last: Option<&TracerRow> = None;
    for row in all.iter().map(|traced| traced.first) {
        if last.is_none_or(|last| (&last.scene, &last.kernel) != (&row.scene, &row.kernel)) {
            let mut cells = vec![Cell::from(row.scene.as_str()), code(&row.kernel)];
            cells.extend([row.triangles, row.instances].map(|value| Cell::from(count(value as u64))));
            cells.extend([row.build_seconds, row.bytes_per_triangle].map(|value| Cell::from(number(value, 3))));
            grid.rows.push(cells);
        }
        last = Some(row);
    }
    grid.markdown()
}

fn side_by_side(all: &[TracedSet]) -> String {
    let mut grid = Grid::new(2, ["scene", "rays", "ray count", "hits"]);
    grid.header.extend(modes().into_iter().chain(["auto / best", "gain"]).map(Cell::from));
    for traced in all {
        let first = traced.first;
        let mut row = [&first.scene, &first.rays].map(|text| Cell::from(text.as_str())).to_vec();
        row.extend([first.ray_count, first.hits].map(|value| Cell::from(count(value as u64))));
        row.extend(modes().map(|mode| {
            match traced.row(mode, 1) {
                Some(row) => Cell::from(with_mad(row.mrays_per_second, row.mrays_per_second_mad))
                    .best_if(traced.is_among_the_fastest(row)),
                None => Cell::from(MISSING),
            }
        }));
        row.extend([traced.auto_over_best(), traced.gain()].map(|ratio| Cell::from(times(ratio))));
        grid.rows.push(row);
    }
    grid.markdown()
}

fn by_threads(all: &[TracedSet], threads: usize) -> Option<String> {
    let mut grid = Grid::new(2, ["scene", "rays"]);
    grid.header.extend(modes().map(Cell::from));
    for traced in all {
        let mut row = [&traced.first.scene, &traced.first.rays].map(|text| Cell::from(text.as_str())).to_vec();
        row.extend(modes().map(|mode| {
            Cell::from(traced.scaling(mode, threads).map_or(MISSING.to_owned(), |ratio| ratio.to_string()))
        }));
        grid.rows.push(row);
    }
    (!grid.rows.is_empty()).then(|| grid.markdown())
}

/// Where mode auto gains least and where it gains most from this number of threads.
fn min_and_max(all: &[TracedSet], threads: usize) -> Option<String> {
    let ratio = |traced: &TracedSet| Some((traced.scaling("auto", threads)?, place(traced)));
    let mut ratios: Vec<_> = all.iter().filter_map(ratio).collect();
    ratios.sort_by(|(a, _), (b, _)| a.value().total_cmp(&b.value()));
    let [(least, least_at), .., (most, most_at)] = &ratios[..] else { return None };
    Some(format!("from {least} ({least_at}) to {most} ({most_at})"))
}

fn place(traced: &TracedSet) -> String {
    format!("{}, {}", traced.first.scene, traced.first.rays)
}

/// The section on coherence: when packets stop paying.
pub(super) fn coherence(record: &Record) -> Vec<String> {
    let all = Coherence::all(record);
    if all.is_empty() {
        return Vec::new();
    }
    let mut parts = vec![format!(
        "## Coherence\n\nThe rays of a picture, each turned at random. With jitter `j`, the direction of a ray is \
         `(1 - j)·p + j·r`, normalised. `p` is the unit direction through its pixel, and `r` is a random unit \
         direction. At jitter 0, these are the primary rays of the picture, the same as in the \
         other sections. At jitter 1, they share nothing but their origin. \
         One thread, closest hit.\n\n\
         Counts come from a run that is not timed. *Lane utilisation* is the share of the eight lanes of triangle \
         tests in which an active ray meets a triangle. Nodes, leaves and tests are given per ray; what several rays \
         do together counts once.\n\n\
         ![Speed, lane utilisation, nodes and tests against coherence]({COHERENCE})"
    )];
    for coherence in &all {
        parts.push(format!("### {}\n\n{}", coherence.scene, summary(coherence)));
        parts.push("Million rays per second. *Auto / best* is auto over the faster of single and packet:".to_owned());
        parts.push(speeds(coherence));
        if coherence.is_counted() {
            parts.push("Counts:".to_owned());
            parts.push(counts(coherence));
        }
    }
    parts
}

/// At which jitter single rays overtake packets, and how well mode auto chooses.
fn summary(coherence: &Coherence) -> String {
    let packets = |jitter: f64| format!("{} at {}", times(coherence.packet_gain(jitter)), severity(jitter));
    let mut text = String::new();
    if let [first, .., last] = coherence.jitters[..]
        && coherence.packet_gain(first).is_some()
    {
        text += &match coherence.overtaking_step() {
            None => "Single rays do not overtake packets by more than the noise.".to_owned(),
            Some(0) => "Single rays are faster than packets from the start.".to_owned(),
            Some(step) => format!(
                "Single rays overtake packets at jitter {}. Packets pay up to jitter {}.",
                severity(coherence.jitters[step]),
                severity(coherence.jitters[step - 1])
            ),
        };
        let between =
            coherence.overtaking_step().filter(|&step| step > 0).into_iter().flat_map(|step| [step - 1, step]);
        let mut shown = vec![first];
        shown.extend(between.map(|step| coherence.jitters[step]).filter(|&jitter| jitter > first && jitter < last));
        shown.push(last);
        let shown: Vec<_> = shown.into_iter().map(packets).collect();
        text += &format!(" Speed of packets over single rays, by jitter: {}.", shown.join(", "));
    }
    if let Some((ratio, jitter)) = coherence.worst_auto() {
        let ratio = times(Some(ratio));
        text += &format!(
            " At worst, mode auto is {ratio} as fast as the better of the two, at jitter {}.",
            severity(jitter)
        );
    }
    text
}

/// Jitter × mode: speed.
fn speeds(coherence: &Coherence) -> String {
    let mut grid = Grid::new(1, ["jitter"]);
    grid.header.extend(modes().into_iter().chain(["packet / single", "auto / best"]).map(Cell::from));
    for &jitter in &coherence.jitters {
        let rows = modes().map(|mode| coherence.row(jitter, mode));
        let best = rows.iter().flatten().map(|row| row.mrays_per_second).reduce(f64::max);
        let mut cells = vec![Cell::from(severity(jitter))];
        cells.extend(rows.map(|row| {
            match row {
                Some(row) => Cell::from(with_mad(row.mrays_per_second, row.mrays_per_second_mad))
                    .best_if(Some(row.mrays_per_second) == best),
                None => Cell::from(MISSING),
            }
        }));
        let ratios = [coherence.packet_gain(jitter), coherence.auto_over_best(jitter)];
        cells.extend(ratios.map(|ratio| Cell::from(times(ratio))));
        grid.rows.push(cells);
    }
    grid.markdown()
}

/// Jitter × count, for single and packet.
fn counts(coherence: &Coherence) -> String {
    const MODES: [&str; 2] = ["single", "packet"];
    let mut grid = Grid::new(1, ["jitter"]);
    for figure in ["lanes used", "nodes / ray", "leaves / ray", "tests / ray"] {
        grid.header.extend(MODES.map(|mode| Cell::from(format!("{mode}: {figure}"))));
    }
    for &jitter in &coherence.jitters {
        let rows = MODES.map(|mode| coherence.row(jitter, mode));
        let lanes = |row: &CoherenceRow| row.lane_utilisation().map(|share| format!("{:.0} %", 100.0 * share));
        let mut cells = vec![Cell::from(severity(jitter))];
        cells.extend(rows.map(|row| Cell::from(row.and_then(lanes).unwrap_or(MISSING.to_owned()))));
        for figure in [CoherenceRow::nodes_per_ray, CoherenceRow::leaves_per_ray, CoherenceRow::tests_per_ray] {
            cells.extend(rows.map(|row| Cell::from(optional(row.and_then(figure), 3))));
        }
        grid.rows.push(cells);
    }
    grid.markdown()
}

/// The section on size: the cost of a ray as the scene grows.
fn growth(record: &Record) -> Vec<String> {
    let all = Growth::all(record);
    let Some(sizes) = all.first().map(|growth| &growth.rows) else { return Vec::new() };
    let mut header =
        Grid::new(1, ["scene", "triangles", "triangles / pixel", "megabytes", "bytes / triangle", "build s"]);
    // The first set is the primary rays, one for each pixel.
    header.rows.extend(sizes.iter().map(|row| {
        let megabytes = row.bytes_per_triangle * row.triangles as f64 / 1e6;
        vec![
            Cell::from(row.scene.as_str()),
            Cell::from(count(row.triangles as u64)),
            Cell::from(number(row.triangles as f64 / row.ray_count as f64, 2)),
            Cell::from(number(megabytes, 3)),
            Cell::from(number(row.bytes_per_triangle, 3)),
            Cell::from(number(row.build_seconds, 3)),
        ]
    }));
    let mut costs = Grid::new(1, ["rays"]);
    costs.header.extend(sizes.iter().map(|row| Cell::from(format!("{} ns / ray", row.scene))));
    costs.header.extend(sizes.iter().skip(1).map(|row| Cell::from(format!("growth to {}", row.scene))));
    for growth in &all {
        let mut row = vec![Cell::from(growth.rays)];
        row.extend(growth.rows.iter().map(|row| Cell::from(with_mad(row.ns_per_ray, row.ns_per_ray_mad))));
        row.extend(growth.per_decade().into_iter().map(|growth| Cell::from(times(growth))));
        costs.rows.push(row);
    }
    vec![
        format!(
            "### Size\n\nOne landscape with more and more triangles, in the same picture, as large as those of the \
             other sections. So the same scene has the same rays here. Mode auto, one thread. The cost of a ray grows \
             with the depth of the tree and with cache misses. It also grows when triangles become smaller than \
             pixels, because neighbouring rays then have less in common. Growth is given per factor of ten in \
             triangles.{}\n\n\
             ![Cost of a ray, build time and memory against size]({SCALING})",
            largest_growth(&all).map_or(String::new(), |text| format!(" {text}"))
        ),
        header.markdown(),
        costs.markdown(),
    ]
}

/// The largest growth, in words.
fn largest_growth(all: &[Growth]) -> Option<String> {
    let growths = all.iter().flat_map(|growth| {
        let to = growth.rows.iter().skip(1);
        growth.per_decade().into_iter().zip(to).filter_map(|(value, row)| Some((value?, growth.rays, row)))
    });
    let (value, rays, row) = growths.max_by(|(a, ..), (b, ..)| a.total_cmp(b))?;
    Some(format!("The largest growth is {}, for {rays} rays at {}.", times(Some(value)), row.scene))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::figures::groups;
    use crate::study::record::Samples;
    use crate::study::tests::fixture::record_of;

    #[test]
    fn the_summary_names_the_jitter_where_packets_stop_paying() {
        let record = record_of(&[]);
        let text = coherence(&record).join("\n\n");
        assert!(
            text.contains(
                "Single rays overtake packets at jitter 0.2. Packets pay up to jitter 0.1. Speed of packets over \
                 single rays, by jitter: 2.86× at 0, 1.03× at 0.1, 0.67× at 0.2, 0.44× at 1. At worst, mode auto"
            ),
            "{text}"
        );
        assert!(text.contains("At worst, mode auto is "), "{text}");
        let changed = |mode: &str, factor: f64| {
            let mut record = record.clone();
            let rows = record.coherence.iter_mut().filter(|row| row.mode == mode);
            rows.for_each(|row| row.mrays_per_second *= factor);
            coherence(&record).join("\n\n")
        };
        assert!(changed("packet", 100.0).contains("Single rays do not overtake packets"));
        assert!(changed("single", 100.0).contains("Single rays are faster than packets from the start"));
        assert!(changed("auto", 0.5).contains("At worst, mode auto is 0.48× as fast"), "{}", changed("auto", 0.5));
    }

    #[test]
    fn the_gain_of_threads_is_summed_up_by_its_minimum_and_maximum() {
        let mut record = record_of(&[]);
        for row in record.tracer.iter_mut().filter(|row| row.threads == 2 && row.mode == "auto") {
            let gain = match (row.scene.as_str(), row.rays.as_str()) {
                ("spheres", "bounce") => 0.4,
                ("forest:10000", "shadow") => 1.1,
                _ => 1.0,
            };
            row.ns_of_rounds = Samples::new(&[row.ns_of_rounds.all().iter().map(|ns| ns / gain).collect()]);
        }
        let text = [throughput(&record), several_threads(&record, &groups(&record))].concat().join("\n\n");
        assert!(text.contains("## 2 threads against one"));
        assert!(
            text.contains(
                "Tracer in mode auto: from 0.77× (0.772 to 0.772) (spheres, bounce) to 2.12× (2.12 to 2.12), > 2×: \
                 noise or shared clock (forest:10000, shadow)."
            ),
            "{text}"
        );
        for rays in ["primary", "shadow", "bounce", "ambient occlusion"] {
            assert_eq!(text.matches(&format!("\n| spheres | {rays} |")).count(), 2, "{rays}");
        }
        assert_eq!(text.matches("| 132 |").count() + text.matches("| 133 |").count(), 2, "each scene must appear once");
    }

    #[test]
    fn the_largest_growth_is_named() {
        let mut record = record_of(&[]);
        let last = record.scaling.iter_mut().rfind(|row| row.rays == "bounce").unwrap();
        last.ns_per_ray *= 2.0;
        let text = memory(&record, &groups(&record)).join("\n\n");
        assert!(text.contains("The largest growth is 2.50×, for bounce rays at terrain:1e6."), "{text}");
        assert!(text.contains("| terrain:1e6 | 1,000,000 | 3.8 | 178 | 178 | 0.300 |"), "{text}");
    }
}
