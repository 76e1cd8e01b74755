//! The verdict: which kernel to use, what that costs, and how noisy the timings were. It opens the report and ends the
//! table on the terminal.

use crate::study::figures::{
    Group, KernelFigures, Loss, MISSING, count, fastest_of, number, severity, si, tied, times,
};
use crate::study::measure::stats::median;
use crate::study::record::{Record, SpeedRow};

/// The report warns if the median absolute deviation of the timings exceeds this share of the median.
const NOISY: f64 = 0.05;

/// The lines of the verdict, in Markdown: which kernel of each family to use, and what the alternatives cost.
pub(crate) fn verdict(groups: &[Group]) -> Vec<String> {
    let base = |shape: &str| groups.iter().find(|group| group.is_base() && group.shape == shape);
    let mut lines: Vec<String> = Vec::new();
    if let Some(triangles) = base("triangle") {
        lines.extend(recommended(triangles, "Triangles"));
        lines.extend(if_speed_is_all(triangles));
        lines.extend(if_t_must_be_exact(triangles));
    }
    lines.extend(base("aabb").and_then(|group| Some(recommended(group, "Boxes")? + &price(group)?)));
    lines.extend(base("quadric").and_then(|group| Some(recommended(group, "Quadrics")? + &price(group)?)));
    lines
}

/// The verdict as a Markdown list; `None` if there is no verdict.
pub(crate) fn verdict_list(groups: &[Group]) -> Option<String> {
    let lines: Vec<_> = verdict(groups).into_iter().map(|line| format!("- {line}")).collect();
    (!lines.is_empty()).then(|| lines.join("\n"))
}

/// The fastest of the kernels that lose the fewest rays, and all that tie with it.
fn safest<'k, 'a: 'k>(group: &'k Group<'a>) -> Vec<&'k KernelFigures<'a>> {
    let lost = |kernel: &KernelFigures| kernel.lost.map(|lost| lost.per_million);
    // All zeros count as equal, however many rays they stand for.
    let least = group.kernels.iter().filter_map(lost).reduce(f64::min);
    fastest_of(group.kernels.iter().filter(|kernel| least.is_some() && lost(kernel) == least), "8x1")
}

/// The names of kernels that tie with the one before, in brackets.
fn equally_fast(ties: &[&KernelFigures]) -> String {
    let names: Vec<_> = ties.iter().map(|kernel| format!("`{}`", kernel.name)).collect();
    if names.is_empty() { String::new() } else { format!(" (equally fast: {})", names.join(", ")) }
}

fn packet_speed(kernel: &KernelFigures) -> Option<f64> {
    kernel.speed("8x1", 1).map(|row| row.tests_per_second)
}

/// The kernel of a group to use: how many rays it loses, and how fast it is.
fn recommended(group: &Group, title: &str) -> Option<String> {
    let [best, ties @ ..] = &safest(group)[..] else { return None };
    let lost = best.lost?;
    let loses = if best.loses() {
        format!("loses the fewest rays, {}", at_worst(best)?)
    } else {
        let hard = match group.loss {
            Loss::Leaks => "edges and vertices, where other kernels leak",
            Loss::WithBoundary => "edges, corners and thin boxes, where other kernels lose rays",
            Loss::Strict => "silhouettes, rims and distant surfaces, where other kernels lose rays",
        };
        format!("lost 0 of {} rays aimed at {hard}", si(lost.of as f64, 3))
    };
    let speed = si(packet_speed(best)?, 3);
    Some(format!("**{title}: `{}`**{} {loses}. Speed: {speed} tests/s.", best.name, equally_fast(ties)))
}

/// The largest share of rays that a kernel loses, and in which workload.
fn at_worst(kernel: &KernelFigures) -> Option<String> {
    let place = kernel.lost_in.map_or(String::new(), |row| match row.severity {
        Some(step) => format!(" ({}, severity {})", row.workload.replace('_', " "), severity(step)),
        None => format!(" ({}s)", row.workload),
    });
    Some(format!("up to {} %{place}", number(kernel.lost?.per_million / 1e4, 2)))
}

/// The fastest kernel, and how many rays it loses.
fn if_speed_is_all(group: &Group) -> Option<String> {
    let (fastest, safest) = (group.fastest("8x1"), safest(group));
    let ([first, ties @ ..], best) = (&fastest[..], safest.first()?) else { return None };
    if fastest.iter().any(|kernel| kernel.name == best.name) {
        return Some(format!("**No kernel is faster:** none beats `{}` by more than the noise.", best.name));
    }
    Some(format!(
        "**If only speed counts: `{}`**{} is {} as fast, but loses {}.",
        first.name,
        equally_fast(ties),
        times(Some(packet_speed(first)? / packet_speed(best)?)),
        at_worst(first)?
    ))
}

/// The kernel with the most accurate `t`, and what it costs.
fn if_t_must_be_exact(group: &Group) -> Option<String> {
    let least = group.kernels.iter().filter_map(KernelFigures::ulp).min()?;
    let exact = fastest_of(group.kernels.iter().filter(|kernel| kernel.ulp() == Some(least)), "8x1");
    let (first, safest) = (exact.first()?, safest(group));
    let best = safest.first()?;
    if best.ulp() == Some(least) {
        return Some(format!("**No `t` is more accurate:** `{}` {} (99th percentile).", best.name, error_of_t(least)));
    }
    let loses = if first.loses() { format!(", and loses {}", at_worst(first)?) } else { String::new() };
    Some(format!(
        "**If `t` must be exact: `{}`** {} where `{}` is off by up to {} ulp (99th percentile). It takes {} the \
         time{loses}.",
        first.name,
        error_of_t(least),
        best.name,
        best.ulp().map_or(MISSING.into(), count),
        times(Some(packet_speed(best)? / packet_speed(first)?)),
    ))
}

/// The 99th percentile of the error of `t`, in words.
fn error_of_t(ulp: u64) -> String {
    if ulp == 0 { "rounds `t` correctly".into() } else { format!("is off by up to {} ulp", count(ulp)) }
}

/// The speed and the lost rays of a group's fastest kernel, as a sentence after the recommendation.
fn price(group: &Group) -> Option<String> {
    let (fastest, safest) = (group.fastest("8x1"), safest(group));
    let (first, best) = (fastest.first()?, safest.first()?);
    if fastest.iter().any(|kernel| kernel.name == best.name) {
        return Some(" No kernel is faster.".into());
    }
    let gain = times(Some(packet_speed(first)? / packet_speed(best)?));
    Some(format!(" `{}` is {gain} as fast, but loses {}.", first.name, at_worst(first)?))
}

/// Half the width of the median interval, relative to the time; `None` if there are no timings.
pub(crate) fn spread(record: &Record) -> Option<f64> {
    let half_width = |row: &SpeedRow| (row.ns_per_test_high - row.ns_per_test_low) / 2.0 / row.ns_per_test;
    let spreads: Vec<f64> = record.speed.iter().filter(|row| row.threads == 1).map(half_width).collect();
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
        "{warning}A ray is lost if it exactly hits and is reported to miss. Speeds are those of packets of eight in \
         one thread. The median interval reaches {} % to either side. In the rankings of packets, {ties} of {pairs} \
         pairs of neighbours tie: the interval of their ratio contains 1, so neither kernel is called faster.",
        number(100.0 * spread, 2)
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::figures::groups;
    use crate::study::tests::fixture::{all_ids, degenerate_records, record_of, set_rounds};

    fn lines(record: &Record) -> Vec<String> {
        verdict(&groups(record))
    }

    #[test]
    fn five_lines_name_the_safest_kernels_and_the_cost_of_alternatives() {
        let record = record_of(&all_ids());
        let lines = lines(&record);
        assert_eq!(lines.len(), 5, "{lines:#?}");
        assert!(
            lines[0].starts_with(
                "**Triangles: `woop_dop`** loses the fewest rays, up to 0.084 % (edges). Speed: 668 M tests/s."
            ),
            "{}",
            lines[0]
        );
        assert!(lines[1].starts_with("**If only speed counts: `cramer`** is 1.21× as fast"), "{lines:#?}");
        assert!(
            lines[2].starts_with("**No `t` is more accurate:** `woop_dop` rounds `t` correctly (99th percentile)."),
            "{lines:#?}"
        );
        assert!(lines[3].starts_with("**Boxes: `") && lines[4].starts_with("**Quadrics: `"));
    }

    #[test]
    fn a_fast_kernel_that_loses_rays_is_mentioned_but_never_recommended() {
        let mut record = record_of(&["triangle/a".into(), "triangle/b".into(), "triangle/c".into()]);
        let set = |record: &mut Record, id: &str, ns: &[f64], leaks: f64| {
            for row in record.speed.iter_mut().filter(|row| row.id == id) {
                set_rounds(row, ns);
            }
            for row in record.accuracy.iter_mut().filter(|row| row.id == id) {
                row.t_ulp_p99 = 7;
                row.leak_per_million =
                    if row.workload == "vertex_fan" && row.severity == Some(4.0) { leaks } else { 0.0 };
            }
        };
        set(&mut record, "triangle/a", &[1.0; 3], 60_000.0);
        set(&mut record, "triangle/b", &[2.0; 3], 0.0);
        set(&mut record, "triangle/c", &[2.01, 1.99, 2.02], 0.0);
        let [first, second, ..] = &lines(&record)[..] else { panic!("{:?}", lines(&record)) };
        assert!(first.contains("`b`** (equally fast: `c`) lost 0 of"), "{first}");
        assert!(second.contains("`a`** is 2.00× as fast, but loses up to 6.0 % (vertex fan, severity 4)"), "{second}");
        assert!(
            lines(&record)[2].starts_with("**No `t` is more accurate:** `b` is off by up to 7 ulp"),
            "{}",
            lines(&record)[2]
        );
        // Slower by more than the noise: no longer equally fast.
        set(&mut record, "triangle/c", &[2.03, 2.01, 2.04], 0.0);
        let generic = record.accuracy.iter_mut().find(|row| row.id == "triangle/c" && row.workload == "generic");
        generic.unwrap().t_ulp_p99 = 1;
        let exact = &lines(&record)[2];
        let expected = "`c`** is off by up to 1 ulp where `b` is off by up to 7 ulp (99th percentile). It takes 1.01× \
                        the time.";
        assert!(exact.contains(expected), "{exact}");
        assert!(lines(&record)[0].contains("`b`** lost 0 of"), "{}", lines(&record)[0]);
    }

    #[test]
    fn noise_is_reported_and_ties_are_counted() {
        let mut record = record_of(&["triangle/a".into(), "triangle/b".into(), "triangle/c".into()]);
        let text = |record: &Record| noise(record, &groups(record)).unwrap();
        assert!(text(&record).contains("reaches 1.2 % to either side") && text(&record).contains(" 0 of 2 pairs"));
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
