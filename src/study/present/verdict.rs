//! The verdict: which kernel to use, what that costs, and how noisy the timings were. It opens the report and ends the
//! table on the terminal.

use crate::study::figures::on_scenes::{Answers, gain};
use crate::study::figures::{Failures, Group, KernelFigures, Loss, count, number, severity, si, tied, times};
use crate::study::measure::stats::{Estimate, median, ratio};
use crate::study::ray_sets::{EDGES, NAMES};
use crate::study::record::{AccuracyRow, Record, SpeedRow};

/// The report warns if the median absolute deviation of the timings exceeds this share of the median.
const NOISY: f64 = 0.05;

/// The lines of the verdict, in Markdown: which kernel of each family to use, and what the alternatives cost.
pub(crate) fn verdict(record: &Record, groups: &[Group]) -> Vec<String> {
    let titles = [("triangle", "Triangles"), ("aabb", "Boxes"), ("quadric", "Quadrics")];
    let base = |shape: &str| groups.iter().find(|group| group.is_base() && group.shape == shape);
    let lines = |(shape, title)| base(shape).map(|group| lines(record, group, title)).unwrap_or_default();
    titles.into_iter().flat_map(lines).collect()
}

/// The verdict as a Markdown list; `None` if there is no verdict.
pub(crate) fn verdict_list(record: &Record, groups: &[Group]) -> Option<String> {
    let lines: Vec<_> = verdict(record, groups).into_iter().map(|line| format!("- {line}")).collect();
    (!lines.is_empty()).then(|| lines.join("\n"))
}

/// The lines about one group: the kernel to use, the fastest one if that is another, and those that are faster in whole
/// scenes.
fn lines(record: &Record, group: &Group, title: &str) -> Vec<String> {
    let (safest, fastest) = (group.safest(), group.fastest(PACKET));
    let [best, ties @ ..] = &safest[..] else { return Vec::new() };
    let mut lines: Vec<_> = recommended(record, group, title, best, ties).into_iter().collect();
    match &fastest[..] {
        [] => {}
        kernels if kernels.iter().any(|kernel| kernel.name == best.name) => {
            lines.push(format!(
                "No kernel for {} is faster than `{}` per test by more than the noise.",
                plural(group),
                best.name
            ));
        }
        [first, ties @ ..] => lines.extend(faster(record, group, first, ties, best)),
    }
    lines.extend(faster_in_scenes(record, group, best));
    lines
}

/// The shape of a group in the plural.
fn plural(group: &Group) -> String {
    if group.shape == "aabb" { "boxes".into() } else { format!("{}s", group.shape) }
}

const PACKET: &str = "8x1";

/// The names of kernels that tie with the one before, in brackets.
fn tied_with(ties: &[&KernelFigures]) -> String {
    let names: Vec<_> = ties.iter().map(|kernel| format!("`{}`", kernel.name)).collect();
    if names.is_empty() { String::new() } else { format!(" (tied: {})", names.join(", ")) }
}

/// The kernel of a group to use: how often it is wrong, and how fast it is.
fn recommended(
    record: &Record,
    group: &Group,
    title: &str,
    best: &KernelFigures,
    ties: &[&KernelFigures],
) -> Option<String> {
    let wrong = best.wrong?;
    let aimed = if best.errs() {
        format!("has the fewest wrong answers: {}", failures(group, best)?)
    } else {
        let what = match group.loss {
            Loss::Leaks => ["gave no wrong answer to", "rays at edges and vertices of meshes, or leaving a surface"],
            Loss::WithBoundary => ["lost none of", "rays that hit boxes at edges, corners and in thin places"],
            Loss::Strict => ["gave no wrong answer to", "rays at silhouettes, rims and distant surfaces"],
        };
        let (rays, bound) = (si(wrong.of as f64, 3), number(wrong.or_bound(), 2));
        format!("{} {rays} {} (95 %: fewer than {bound} per million)", what[0], what[1])
    };
    // Edges of scenes are those of triangles.
    let edges = if group.shape == "triangle" { at_edges(record, best) } else { None };
    let scenes = in_pictures(record, best).into_iter().chain(edges);
    Some(format!(
        "**{title}: `{}`**{} {aimed}. {}Speed: {} tests/s.",
        best.name,
        tied_with(ties),
        scenes.map(|text| text + ". ").collect::<String>(),
        si(best.speed(PACKET, 1)?.tests_per_second, 3)
    ))
}

/// A faster kernel: how much faster it is at each width, and how often it is wrong.
fn faster(
    record: &Record,
    group: &Group,
    first: &KernelFigures,
    ties: &[&KernelFigures],
    best: &KernelFigures,
) -> Option<String> {
    let widths = ["8x1", "1x1", "1x8"].map(|width| {
        let rows = best.speed(width, 1).zip(first.speed(width, 1));
        let gain = rows.and_then(|(best, first)| ratio(&best.ns_of_rounds, &first.ns_of_rounds)).map(|gain| gain.value);
        format!("{} ({width})", times(gain))
    });
    let ids = [&*first.method.id, &*best.method.id];
    let scenes = gain(record, ids, |_| true).map_or(String::new(), |all| {
        let of_rays = |rays: &str| {
            let gain = gain(record, ids, |row| row.rays == rays)?;
            Some(format!("{rays} {}", times(Some(gain.value))))
        };
        let of_rays: Vec<_> = NAMES.iter().filter_map(|rays| of_rays(rays)).collect();
        format!(", and {} in whole scenes ({})", interval(all), of_rays.join(", "))
    });
    let pictures = in_pictures(record, first).map_or(String::new(), |text| format!(" {text}."));
    Some(format!(
        "`{}`{} is faster: {} per test{scenes}. It is wrong: {}.{pictures}",
        first.name,
        tied_with(ties),
        widths.join(", "),
        failures(group, first)?
    ))
}

/// The kernels that answer as many rays of pictures rightly as the recommended one, and are faster there. Tests of
/// single primitives do not show this.
fn faster_in_scenes(record: &Record, group: &Group, best: &KernelFigures) -> Option<String> {
    let wrong = |kernel: &KernelFigures| Some(Answers::in_pictures(record, &kernel.method.id)?.wrong());
    let most = wrong(best)?.events;
    let mut faster: Vec<_> = group
        .kernels
        .iter()
        .filter(|kernel| wrong(kernel).is_some_and(|wrong| wrong.events <= most))
        .filter_map(|kernel| Some((kernel, gain(record, [&kernel.method.id, &best.method.id], |_| true)?)))
        .filter(|(_, gain)| gain.low > 1.0)
        .collect();
    faster.sort_by(|(_, a), (_, b)| b.value.total_cmp(&a.value));
    if faster.is_empty() {
        return None;
    }
    let named = |(kernel, gain): &(&KernelFigures, Estimate)| format!("`{}` {}", kernel.name, times(Some(gain.value)));
    let names: Vec<_> = faster.iter().map(named).collect();
    let mut line =
        format!("As right in pictures as `{}`, and faster in whole scenes: {}.", best.name, names.join(", "));
    // Edges of scenes are those of triangles.
    if group.shape == "triangle" {
        let wrong = |kernel: &KernelFigures| Some(Answers::at_edges(record, &kernel.method.id)?.wrong().per_million());
        let mut rates: Vec<f64> = faster.iter().filter_map(|(kernel, _)| wrong(kernel)).collect();
        rates.sort_by(f64::total_cmp);
        if let [least, .., most] | [least @ most] = rates[..] {
            let [least, most, own] = [least, most, wrong(best)?].map(|rate| number(rate, 2));
            let range = if least == most { least } else { format!("{least} to {most}") };
            line +=
                &format!(" Of rays at edges of scenes, they get {range} per million wrong, and `{}` {own}.", best.name);
        }
    }
    Some(line)
}

/// A ratio with its interval.
pub(crate) fn interval(ratio: Estimate) -> String {
    format!("{} ({} to {})", times(Some(ratio.value)), number(ratio.low, 3), number(ratio.high, 3))
}

/// The highest rates at which a kernel fails, and where.
fn failures(group: &Group, kernel: &KernelFigures) -> Option<String> {
    let worst = |what: &str, failures: Option<Failures>| {
        let (row, rate) = failures?.worst?;
        Some(format!("{what} {} % in the worst regime measured ({})", number(rate.per_million() / 1e4, 2), place(row)))
    };
    let lost = worst("loses", kernel.lost);
    // A false hit of a bounding box is harmless.
    let false_hits =
        if group.loss == Loss::WithBoundary { None } else { worst("hits falsely or twice", kernel.false_hits) };
    let both: Vec<_> = [lost, false_hits].into_iter().flatten().collect();
    (!both.is_empty()).then(|| both.join(", "))
}

/// A workload, and its severity.
pub(crate) fn place(row: &AccuracyRow) -> String {
    match row.severity {
        Some(step) => format!("{} {}", row.workload.replace('_', " "), severity(step)),
        None => format!("{} rays", row.workload),
    }
}

/// How many rays of the scenes' pictures a kernel gets wrong.
fn in_pictures(record: &Record, kernel: &KernelFigures) -> Option<String> {
    let answers = Answers::in_pictures(record, &kernel.method.id)?;
    let wrong = answers.wrong();
    let neighbours = match answers.neighbours.events {
        0 => String::new(),
        events => format!(" ({} more name a triangle that touches the right one)", count(events)),
    };
    Some(format!("Of {} rays of whole pictures, {} are wrong{neighbours}", si(wrong.of as f64, 3), count(wrong.events)))
}

/// How many rays at edges of the scenes a kernel gets wrong, and in which scenes.
fn at_edges(record: &Record, kernel: &KernelFigures) -> Option<String> {
    let wrong = Answers::at_edges(record, &kernel.method.id)?.wrong();
    let rows = record.on_scenes.iter().filter(|row| row.rays == EDGES && row.kernel == kernel.method.id);
    let scenes: Vec<_> = rows.filter(|row| row.lost + row.false_hits > 0).map(|row| row.scene.as_str()).collect();
    let scenes = if scenes.is_empty() { String::new() } else { format!(" ({})", scenes.join(", ")) };
    Some(format!("Of {} rays at edges of scenes, {}{scenes}", si(wrong.of as f64, 3), count(wrong.events)))
}

/// Half the width of the median interval of packets, relative to the time; `None` if there are no timings.
pub(crate) fn spread(record: &Record) -> Option<f64> {
    let half_width = |row: &SpeedRow| (row.ns_per_test_high - row.ns_per_test_low) / 2.0 / row.ns_per_test;
    let packets = record.speed.iter().filter(|row| row.threads == 1 && row.width == PACKET);
    let spreads: Vec<f64> = packets.map(half_width).collect();
    Some(median(&spreads)).filter(|spread| spread.is_finite())
}

/// How noisy the timings were, and how many kernels tie; `None` if there are no timings.
pub(crate) fn noise(record: &Record, groups: &[Group]) -> Option<String> {
    let spread = spread(record)?;
    let (mut ties, mut pairs) = (0, 0);
    for group in groups {
        let mut rows: Vec<&SpeedRow> = group.kernels.iter().filter_map(|kernel| kernel.speed("8x1", 1)).collect();
        rows.sort_by(|a, b| a.ns_per_test.total_cmp(&b.ns_per_test));
        ties += rows.windows(2).filter(|pair| tied(pair[0], pair[1])).count();
        pairs += rows.len().saturating_sub(1);
    }
    let warning = if spread > NOISY { "**The machine was noisy: trust only large differences.** " } else { "" };
    Some(format!(
        "{warning}Speeds are those of one thread. `1x1` tests one ray against one primitive, `8x1` eight rays against \
         one, `1x8` one ray against eight; without a width, `8x1` is meant. Half the width of the median interval of \
         `8x1` is {} %. In the rankings of `8x1`, {ties} of {pairs} pairs of neighbours tie: the interval of their \
         ratio contains 1, so neither kernel is called faster. Lost rays of triangles are those that exactly hit a \
         mesh and are reported to miss all of it; T-junctions are left out. A false hit of a box only costs a look \
         inside. Of kernels that tie in wrong answers, the one with most claims is recommended, and of these the \
         fastest. Rays at the same mesh are not independent, so the intervals of counts are rather too narrow.",
        number(100.0 * spread, 2)
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::figures::groups;
    use crate::study::tests::fixture::{all_ids, degenerate_records, record_of, set_rounds};

    fn lines(record: &Record) -> Vec<String> {
        verdict(record, &groups(record))
    }

    #[test]
    fn two_lines_for_each_shape_name_the_safest_kernel_and_a_faster_one() {
        let mut record = record_of(&["triangle/a".into(), "triangle/b".into(), "triangle/c".into()]);
        record.methods.iter_mut().for_each(|method| method.claims.clear());
        for row in &mut record.accuracy {
            row.leak_per_million = match (row.id.as_str(), row.workload.as_str(), row.severity) {
                ("triangle/a", "vertex_fan", Some(4.0)) => 60_000.0,
                _ => 0.0,
            };
            row.double_hit_per_million = 0.0;
        }
        let set = |record: &mut Record, id: &str, ns: &[f64]| {
            record.speed.iter_mut().filter(|row| row.id == id).for_each(|row| set_rounds(row, ns));
        };
        set(&mut record, "triangle/a", &[1.0; 3]);
        set(&mut record, "triangle/b", &[2.0; 3]);
        set(&mut record, "triangle/c", &[2.01, 1.99, 2.02]);
        let [safest, faster, in_scenes] = &lines(&record)[..] else { panic!("{:?}", lines(&record)) };
        assert!(safest.starts_with("**Triangles: `b`** (tied: `c`) gave no wrong answer to "), "{safest}");
        assert!(safest.contains("leaving a surface (95 %: fewer than "), "{safest}");
        assert!(
            safest.contains(". Of 1.05 M rays of whole pictures, 160 are wrong (28 more name a triangle that "),
            "{safest}"
        );
        assert!(safest.contains(". Of 262 k rays at edges of scenes, 5,040 (room). Speed: "), "{safest}");
        let expected = "`a` is faster: 2.00× (8x1), 2.00× (1x1), 2.00× (1x8) per test, and ";
        assert!(faster.starts_with(expected), "{faster}");
        assert!(faster.contains("loses 6.0 % in the worst regime measured (vertex fan 4)"), "{faster}");
        assert!(faster.contains(" in whole scenes (primary "), "{faster}");
        assert!(faster.contains("). Of 1.05 M rays of whole pictures, 0 are wrong"), "{faster}");
        // `c` is slower in scenes, and `a` is faster there too. Neither has more wrong rays.
        let expected = "As right in pictures as `b`, and faster in whole scenes: `a` 1.03×. Of rays at edges of \
                        scenes, they get 0 per million wrong, and `b` 19,000.";
        assert!(in_scenes.starts_with(expected), "{in_scenes}");
        // Slower by more than the noise: no longer tied.
        set(&mut record, "triangle/c", &[2.03, 2.01, 2.04]);
        assert!(lines(&record)[0].starts_with("**Triangles: `b`** gave no wrong answer"), "{}", lines(&record)[0]);
        // A kernel that is both is recommended, and nothing is faster.
        set(&mut record, "triangle/b", &[0.5; 3]);
        assert_eq!(lines(&record)[1], "No kernel for triangles is faster than `b` per test by more than the noise.");
        let titles = ["**Triangles: `", "`", "**Boxes: `", "`", "**Quadrics: `", "`"];
        let mut all = lines(&record_of(&all_ids()));
        all.retain(|line| !line.starts_with("As right in pictures"));
        for (line, title) in all.iter().zip(titles) {
            assert!(line.starts_with(title) || line.starts_with("No kernel for"), "{all:#?}");
        }
        assert_eq!(all.len(), 6, "{all:#?}");
    }

    #[test]
    fn false_hits_are_named_like_lost_rays_but_not_for_boxes() {
        let mut record = record_of(&["quadric/a".into(), "quadric/b".into(), "aabb/a".into(), "aabb/b".into()]);
        record.methods.iter_mut().for_each(|method| method.claims.clear());
        for row in &mut record.accuracy {
            (row.false_miss_per_million, row.boundary_none, row.false_hit_per_million) = (0.0, 0, 0.0);
            if row.id.ends_with("/a") && row.severity.is_none() && row.workload == "edge" {
                row.false_hit_per_million = 590_000.0;
            }
        }
        for row in &mut record.speed {
            set_rounds(row, &[if row.id.ends_with("/a") { 1.0 } else { 2.0 }; 3]);
        }
        let lines = lines(&record);
        assert!(lines[0].starts_with("**Boxes: `a`** lost none of "), "{lines:#?}");
        assert!(lines[2].starts_with("**Quadrics: `b`** gave no wrong answer"), "{lines:#?}");
        assert!(lines[3].contains("hits falsely or twice 59 % in the worst regime measured (edge rays)"), "{lines:#?}");
    }

    #[test]
    fn noise_is_reported_and_ties_are_counted() {
        let mut record = record_of(&["triangle/a".into(), "triangle/b".into(), "triangle/c".into()]);
        let text = |record: &Record| noise(record, &groups(record)).unwrap();
        assert!(text(&record).contains("interval of `8x1` is 1.2 %") && text(&record).contains(" 0 of 2 pairs"));
        for (number, row) in record.speed.iter_mut().enumerate() {
            let noise = [0.2, 1.0, 5.0][number / 6];
            set_rounds(row, &[1.0, noise, 1.0 / noise]);
        }
        assert!(text(&record).starts_with("**The machine was noisy") && text(&record).contains(" 2 of 2 pairs"));
    }

    #[test]
    fn degenerate_records_have_a_verdict_or_none() {
        for record in degenerate_records() {
            let text = lines(&record).join("\n") + &noise(&record, &groups(&record)).unwrap_or_default();
            assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
        }
    }
}
