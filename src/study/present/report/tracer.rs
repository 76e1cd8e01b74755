//! The sections on the tracer: throughput, coherence, growth with size.

use super::cells::{code, with_mad};
use crate::study::figures::tracer::{Coherence, Growth, Traced, modes};
use crate::study::figures::{Figures, Group, MISSING, count, number, optional, severity, thread_counts, times};
use crate::study::measure::stats::median;
use crate::study::present::chart::{COHERENCE, SCALING};
use crate::study::present::grid::{Cell, Grid};
use crate::study::record::{CoherenceRow, Record, TracerRow};

/// Scenes, modes side by side, and more threads against one.
pub(super) fn throughput(record: &Record) -> Vec<String> {
    let all = Traced::all(record);
    if all.is_empty() {
        return Vec::new();
    }
    vec![
        "## Tracer\n\nWhole scenes, and four sets of rays for each: *primary* rays of a picture and the *shadow* rays of what \
         they hit run alike; *bounce* and *ambient occlusion* rays leave what was hit in all directions. Shadow and \
         ambient occlusion ask for any hit, the others for the closest. All modes and thread counts gave the same bits. Bytes \
         are those of geometry, prepared primitives and nodes; a scene is built on all threads."
            .to_owned(),
        scenes(&all),
        "### Modes\n\nMillion rays per second in one thread, median ± median absolute deviation; the fastest is bold, with all \
         that tie with it. *scalar* is the reference, one ray at a time; *single* one ray against eight boxes or triangles; \
         *packet* blocks of rays that run alike, and of the others packets of eight; *auto* blocks too, and of the others \
         streams, or packets where there are instances. *Choice* is auto over the faster of single and packet, *gain* auto over \
         scalar."
            .to_owned(),
        side_by_side(&all),
    ]
}

/// Throughput with more threads over that with one, of kernels and of the tracer.
pub(super) fn several_threads(record: &Record, groups: &[Group]) -> Vec<String> {
    let all = Traced::all(record);
    let counts = record.speed.iter().map(|row| row.threads).chain(record.tracer.iter().map(|row| row.threads));
    let mut parts = Vec::new();
    for threads in thread_counts(counts.filter(|&threads| threads > 1)) {
        parts.push(format!(
            "## {threads} threads against one\n\nThroughput over that with one thread, of the tracer ± what both median absolute \
             deviations together make of it. Kernels work on data of their own in first-level caches of their own: what they lack \
             of {threads}× is what the cores share with each other, and with whatever else runs on the machine.{}",
            least_and_greatest(&all, threads).map_or(String::new(), |range| format!(" Tracer in mode auto: {range}."))
        ));
        parts.extend([kernels_by_threads(groups, threads), by_threads(&all, threads)].into_iter().flatten());
    }
    parts
}

/// Groups of kernels: the least, the middle and the greatest of their scalings.
fn kernels_by_threads(groups: &[Group], threads: usize) -> Option<String> {
    let mut grid = Grid::new(1, ["kernels, in packets of eight", "least", "median", "greatest"]);
    for group in groups {
        let scaling = |kernel: &Figures| Some(kernel.mtests("8x1", threads)? / kernel.mtests("8x1", 1)?);
        let mut scalings: Vec<f64> = group.kernels.iter().filter_map(scaling).collect();
        scalings.sort_by(f64::total_cmp);
        if let [least, .., greatest] = scalings[..] {
            let figures = [least, median(&scalings), greatest].map(|ratio| Cell::from(times(Some(ratio))));
            grid.rows.push([Cell::from(group.heading())].into_iter().chain(figures).collect());
        }
    }
    (!grid.rows.is_empty()).then(|| grid.markdown())
}

/// What is kept for each primitive, and what becomes of the cost of a ray when there are ever more of them.
pub(super) fn memory(record: &Record, groups: &[Group]) -> Vec<String> {
    let mut grid = Grid::new(1, ["kernels", "least bytes", "most bytes"]);
    for group in groups {
        let bytes = |kernel: &Figures| (kernel.kernel.prepared_bytes, kernel.name.clone());
        let (least, most) = (group.kernels.iter().map(bytes).min(), group.kernels.iter().map(bytes).max());
        let cells = [least, most].into_iter().flatten().map(|(bytes, name)| Cell::from(format!("{bytes} (`{name}`)")));
        grid.rows.push([Cell::from(group.heading())].into_iter().chain(cells).collect());
    }
    let mut parts = vec![
        "## Memory\n\nWhat kernels prepare for each primitive; a tree adds its nodes, and vertices where nothing is prepared from \
         which they could be told."
            .to_owned(),
        grid.markdown(),
    ];
    parts.extend(growth(record));
    parts
}

fn scenes(all: &[Traced]) -> String {
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

fn side_by_side(all: &[Traced]) -> String {
    let mut grid = Grid::new(2, ["scene", "rays", "ray count", "hits"]);
    grid.header.extend(modes().into_iter().chain(["choice", "gain"]).map(Cell::from));
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
        row.extend([traced.choice(), traced.gain()].map(|ratio| Cell::from(times(ratio))));
        grid.rows.push(row);
    }
    grid.markdown()
}

fn by_threads(all: &[Traced], threads: usize) -> Option<String> {
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

/// Where mode auto gains least and most by that many threads.
fn least_and_greatest(all: &[Traced], threads: usize) -> Option<String> {
    let ratio = |traced: &Traced| Some((traced.scaling("auto", threads)?, place(traced)));
    let mut ratios: Vec<_> = all.iter().filter_map(ratio).collect();
    ratios.sort_by(|(a, _), (b, _)| a.value.total_cmp(&b.value));
    let [(least, least_at), .., (most, most_at)] = &ratios[..] else { return None };
    Some(format!("from {least} ({least_at}) to {most} ({most_at})"))
}

fn place(traced: &Traced) -> String {
    format!("{}, {}", traced.first.scene, traced.first.rays)
}

/// Where packets stop to pay.
pub(super) fn coherence(record: &Record) -> Vec<String> {
    let all = Coherence::all(record);
    if all.is_empty() {
        return Vec::new();
    }
    let mut parts = vec![format!(
        "## Coherence\n\nThe rays of a picture, turned at random: with jitter `j` each runs along `(1 - j)·p + j·r`, where `p` is \
         the direction through its pixel and `r` a random one, both of unit length. At 0 they are the picture's, at 1 they \
         have nothing in common but their origin. One thread, closest hit. Lane utilisation is the share of the eight lanes \
         of triangle tests in which a ray that is still looking meets a triangle; nodes, leaves and tests are counted once \
         for all rays that are taken together, and given by ray, in a run that is not timed.\n\n\
         ![Speed, lane utilisation, nodes and tests against coherence]({COHERENCE})"
    )];
    for coherence in &all {
        parts.push(format!("### {}\n\n{}", coherence.scene, summary(coherence)));
        parts.push("Million rays per second; choice is auto over the faster of single and packet:".to_owned());
        parts.push(speeds(coherence));
        if coherence.is_counted() {
            parts.push("What was counted:".to_owned());
            parts.push(counts(coherence));
        }
    }
    parts
}

/// Where single rays overtake packets, and how well mode auto chooses.
fn summary(coherence: &Coherence) -> String {
    let packets = |jitter: f64| format!("{} at {}", times(coherence.packet_gain(jitter)), severity(jitter));
    let mut text = String::new();
    if let [first, .., last] = coherence.jitters[..]
        && coherence.packet_gain(first).is_some()
    {
        text += &match coherence.overtaking() {
            None => "Single rays do not overtake packets by more than the spread of the samples.".to_owned(),
            Some(0) => "Single rays are faster than packets from the beginning.".to_owned(),
            Some(step) => format!(
                "Single rays overtake packets at jitter {}. Up to {} packets pay.",
                severity(coherence.jitters[step]),
                severity(coherence.jitters[step - 1])
            ),
        };
        let between = coherence.overtaking().filter(|&step| step > 0).into_iter().flat_map(|step| [step - 1, step]);
        let mut shown = vec![first];
        shown.extend(between.map(|step| coherence.jitters[step]).filter(|&jitter| jitter > first && jitter < last));
        shown.push(last);
        let shown: Vec<_> = shown.into_iter().map(packets).collect();
        text += &format!(" Packets over single rays, by jitter: {}.", shown.join(", "));
    }
    if let Some((ratio, jitter)) = coherence.worst_choice() {
        let ratio = times(Some(ratio));
        text += &format!(
            " Mode auto is at worst {ratio} as fast as the better of the two, at jitter {}.",
            severity(jitter)
        );
    }
    text
}

/// Jitter × mode: speed.
fn speeds(coherence: &Coherence) -> String {
    let mut grid = Grid::new(1, ["jitter"]);
    grid.header.extend(modes().into_iter().chain(["packet / single", "choice"]).map(Cell::from));
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
        let ratios = [coherence.packet_gain(jitter), coherence.choice(jitter)];
        cells.extend(ratios.map(|ratio| Cell::from(times(ratio))));
        grid.rows.push(cells);
    }
    grid.markdown()
}

/// Jitter × what was counted, in the two modes that do not choose.
fn counts(coherence: &Coherence) -> String {
    const MODES: [&str; 2] = ["single", "packet"];
    let mut grid = Grid::new(1, ["jitter"]);
    for figure in ["lanes", "nodes / ray", "leaves / ray", "tests / ray"] {
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

/// Cost of a ray against the size of the scene.
fn growth(record: &Record) -> Vec<String> {
    let all = Growth::all(record);
    let Some(sizes) = all.first().map(|growth| &growth.rows) else { return Vec::new() };
    let mut header =
        Grid::new(1, ["scene", "triangles", "triangles / pixel", "megabytes", "bytes / triangle", "build s"]);
    // The first set is that of the picture, one ray for each pixel.
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
            "### Size\n\nOne landscape in one picture, of ever more triangles; mode auto, one thread. Cost grows with \
             the depth of the tree, with misses of the caches, and, where triangles are smaller than pixels, with what \
             neighbouring rays no longer have in common. The growth is that of a ray's cost, per factor of ten of \
             triangles.{}\n\n![Cost of a ray, build and memory against size]({SCALING})",
            greatest(&all).map_or(String::new(), |text| format!(" {text}"))
        ),
        header.markdown(),
        costs.markdown(),
    ]
}

fn greatest(all: &[Growth]) -> Option<String> {
    let growths = all.iter().flat_map(|growth| {
        let to = growth.rows.iter().skip(1);
        growth.per_decade().into_iter().zip(to).filter_map(|(value, row)| Some((value?, growth.rays, row)))
    });
    let (value, rays, row) = growths.max_by(|(a, ..), (b, ..)| a.total_cmp(b))?;
    Some(format!("It is greatest, {}, for {rays} rays up to {}.", times(Some(value)), row.scene))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::figures::groups;
    use crate::study::tests::fixture::record_of;

    #[test]
    fn the_summary_names_where_packets_stop_to_pay() {
        let record = record_of(&[]);
        let text = coherence(&record).join("\n\n");
        assert!(
            text.contains(
                "Single rays overtake packets at jitter 0.2. Up to 0.1 packets pay. Packets over single rays, by jitter: \
                 2.86× at 0, 1.03× at 0.1, 0.67× at 0.2, 0.44× at 1. Mode auto"
            ),
            "{text}"
        );
        assert!(text.contains("Mode auto is at worst "), "{text}");
        let changed = |mode: &str, factor: f64| {
            let mut record = record.clone();
            let rows = record.coherence.iter_mut().filter(|row| row.mode == mode);
            rows.for_each(|row| row.mrays_per_second *= factor);
            coherence(&record).join("\n\n")
        };
        assert!(changed("packet", 100.0).contains("Single rays do not overtake packets"));
        assert!(changed("single", 100.0).contains("Single rays are faster than packets from the beginning"));
        assert!(changed("auto", 0.5).contains("Mode auto is at worst 0.48× as fast"), "{}", changed("auto", 0.5));
    }

    #[test]
    fn threads_are_summed_up_by_the_least_and_the_greatest() {
        let mut record = record_of(&[]);
        for row in record.tracer.iter_mut().filter(|row| row.threads == 2 && row.mode == "auto") {
            match (row.scene.as_str(), row.rays.as_str()) {
                ("spheres", "bounce") => row.mrays_per_second *= 0.4,
                ("forest:10000", "shadow") => row.mrays_per_second *= 1.1,
                _ => {}
            }
        }
        let text = [throughput(&record), several_threads(&record, &groups(&record))].concat().join("\n\n");
        assert!(text.contains("## 2 threads against one"));
        assert!(
            text.contains(
                "Tracer in mode auto: from 0.77× ± 0.03 (spheres, bounce) to 2.12× ± 0.04 (forest:10000, shadow)."
            ),
            "{text}"
        );
        for rays in ["primary", "shadow", "bounce", "ambient occlusion"] {
            assert_eq!(text.matches(&format!("\n| spheres | {rays} |")).count(), 2, "{rays}");
        }
        assert_eq!(text.matches("| 132 |").count() + text.matches("| 133 |").count(), 2, "each scene once");
    }

    #[test]
    fn growth_is_named_where_it_is_greatest() {
        let mut record = record_of(&[]);
        let last = record.scaling.iter_mut().rfind(|row| row.rays == "bounce").unwrap();
        last.ns_per_ray *= 2.0;
        let text = memory(&record, &groups(&record)).join("\n\n");
        assert!(text.contains("It is greatest, 2.50×, for bounce rays up to terrain:1e6."), "{text}");
        assert!(text.contains("| terrain:1e6 | 1,000,000 | 3.8 | 178 | 178 | 0.300 |"), "{text}");
    }
}
