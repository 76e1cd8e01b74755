//! The first screen in words: what to use, what it costs, and how far the machine let kernels be told apart.

use crate::study::figures::{Figures, Group, count, fastest_of, number, severity, si, tied, times};
use crate::study::measure::stats::median;
use crate::study::record::{Record, SpeedRow};

/// Above this share of the median, the median absolute deviation of the timings is worth a warning.
const NOISY: f64 = 0.05;

/// The lines of the verdict: which kernel to use of each family, and what the alternatives cost.
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

/// The verdict as a list, if there is one.
pub(crate) fn verdict_list(groups: &[Group]) -> Option<String> {
    let lines: Vec<_> = verdict(groups).into_iter().map(|line| format!("- {line}")).collect();
    (!lines.is_empty()).then(|| lines.join("\n"))
}

/// The fastest of the kernels that lose the fewest rays, and all that tie with it.
pub(crate) fn safest<'k, 'a: 'k>(group: &'k Group<'a>) -> Vec<&'k Figures<'a>> {
    let lost = |kernel: &Figures| kernel.lost.map(|lost| lost.per_million);
    // A zero over more rays says more, but not that another zero is worse.
    let least = group.kernels.iter().filter_map(lost).reduce(f64::min);
    fastest_of(group.kernels.iter().filter(|kernel| least.is_some() && lost(kernel) == least), "8x1")
}

fn equals(ties: &[&Figures]) -> String {
    let names: Vec<_> = ties.iter().map(|kernel| format!("`{}`", kernel.name)).collect();
    if names.is_empty() { String::new() } else { format!(" or, as fast, {}", names.join(", ")) }
}

fn packet_speed(kernel: &Figures) -> Option<f64> {
    kernel.speed("8x1", 1).map(|row| row.tests_per_second)
}

/// The kernel to use of a group: how much it loses, and how fast it is.
fn recommended(group: &Group, title: &str) -> Option<String> {
    let [best, ties @ ..] = &safest(group)[..] else { return None };
    let lost = best.lost?;
    let loses = if best.loses() {
        format!("loses the fewest rays, {}", at_worst(best)?)
    } else {
        format!("loses none of {} rays aimed where others do", si(lost.of as f64, 3))
    };
    Some(format!("**{title}: `{}`**{} {loses}; {} tests/s.", best.name, equals(ties), si(packet_speed(best)?, 3)))
}

/// The greatest share of rays that a kernel loses, and where.
fn at_worst(kernel: &Figures) -> Option<String> {
    let place = kernel.lost_in.map_or(String::new(), |row| match row.severity {
        Some(step) => format!(" ({} {})", row.workload.replace('_', " "), severity(step)),
        None => format!(" ({}s)", row.workload),
    });
    Some(format!("up to {} %{place}", number(kernel.lost?.per_million / 1e4, 2)))
}

/// What the fastest kernel gains and loses.
fn if_speed_is_all(group: &Group) -> Option<String> {
    let (fastest, safest) = (group.fastest("8x1"), safest(group));
    let ([first, ties @ ..], best) = (&fastest[..], safest.first()?) else { return None };
    if fastest.iter().any(|kernel| kernel.name == best.name) {
        return Some(format!("**Nothing is faster:** no kernel beats `{}` by more than the noise.", best.name));
    }
    Some(format!(
        "**If only speed counts: `{}`**{} is {} as fast, and loses {}.",
        first.name,
        equals(ties),
        times(Some(packet_speed(first)? / packet_speed(best)?)),
        at_worst(first)?
    ))
}

/// The most accurate kernel and its price.
fn if_t_must_be_exact(group: &Group) -> Option<String> {
    let least = group.kernels.iter().filter_map(Figures::ulp).min()?;
    let exact = fastest_of(group.kernels.iter().filter(|kernel| kernel.ulp() == Some(least)), "8x1");
    let (first, safest) = (exact.first()?, safest(group));
    let best = safest.first()?;
    if best.ulp() == Some(least) {
        return Some(format!(
            "**No `t` is more exact:** `{}` errs by {} ulp (99th percentile).",
            best.name,
            count(least)
        ));
    }
    let loses = if first.loses() { format!(", and loses {}", at_worst(first)?) } else { String::new() };
    Some(format!(
        "**If `t` must be exact: `{}`** errs by {} ulp instead of {} (99th percentile), takes {} the time{loses}.",
        first.name,
        count(least),
        best.ulp().map_or("–".into(), count),
        times(Some(packet_speed(best)? / packet_speed(first)?)),
    ))
}

/// What the fastest of a group gains and loses, as an afterthought.
fn price(group: &Group) -> Option<String> {
    let (fastest, safest) = (group.fastest("8x1"), safest(group));
    let (first, best) = (fastest.first()?, safest.first()?);
    if fastest.iter().any(|kernel| kernel.name == best.name) {
        return Some(" None is faster.".into());
    }
    let gain = times(Some(packet_speed(first)? / packet_speed(best)?));
    Some(format!(" `{}` is {gain} as fast, and loses {}.", first.name, at_worst(first)?))
}

/// How far apart timings were, and what therefore is not ranked.
pub(crate) fn noise(record: &Record, groups: &[Group]) -> Option<String> {
    let spreads: Vec<f64> =
        record.speed.iter().filter(|row| row.threads == 1).map(|row| row.ns_per_test_mad / row.ns_per_test).collect();
    let spread = median(&spreads);
    if !spread.is_finite() {
        return None;
    }
    let (mut ties, mut pairs) = (0, 0);
    for group in groups {
        let mut rows: Vec<&SpeedRow> = group.kernels.iter().filter_map(|kernel| kernel.speed("8x1", 1)).collect();
        rows.sort_by(|a, b| a.ns_per_test.total_cmp(&b.ns_per_test));
        ties += rows.windows(2).filter(|pair| tied(pair[0], pair[1])).count();
        pairs += rows.len().saturating_sub(1);
    }
    let warning = if spread > NOISY { "**The machine was noisy: trust only large differences.** " } else { "" };
    Some(format!(
        "{warning}Rays lost are those that exactly hit and are reported to miss, tests per second those of packets of eight in one \
         thread. Samples deviated from their median by {} % in the middle. Of {pairs} pairs of neighbours in the rankings of \
         packets, {ties} differ by no more than the sum of their deviations: they are shown as tied, and none is called the \
         faster.",
        number(100.0 * spread, 2)
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::figures::groups;
    use crate::study::tests::fixture::{all_ids, degenerate_records, record_of};

    fn lines(record: &Record) -> Vec<String> {
        verdict(&groups(record))
    }

    #[test]
    fn five_lines_name_the_safest_and_what_speed_and_digits_cost() {
        let record = record_of(&all_ids());
        let lines = lines(&record);
        assert_eq!(lines.len(), 5, "{lines:#?}");
        assert!(
            lines[0]
                .starts_with("**Triangles: `woop_dop`** loses the fewest rays, up to 0.084 % (edges); 669 M tests/s."),
            "{}",
            lines[0]
        );
        assert!(lines[1].starts_with("**If only speed counts: `cramer`** is 1.21× as fast"), "{lines:#?}");
        assert!(lines[2].starts_with("**No `t` is more exact:** `woop_dop` errs by 0 ulp"), "{lines:#?}");
        assert!(lines[3].starts_with("**Boxes: `") && lines[4].starts_with("**Quadrics: `"));
    }

    #[test]
    fn a_fast_kernel_that_loses_rays_is_an_option_and_never_the_advice() {
        let mut record = record_of(&["triangle/a".into(), "triangle/b".into(), "triangle/c".into()]);
        let set = |record: &mut Record, id: &str, ns: f64, leaks: f64| {
            for row in record.speed.iter_mut().filter(|row| row.id == id) {
                (row.ns_per_test, row.ns_per_test_mad, row.tests_per_second) = (ns, 0.01, 1e9 / ns);
            }
            for row in record.accuracy.iter_mut().filter(|row| row.id == id) {
                row.t_ulp_p99 = 7;
                row.leak_per_million =
                    if row.workload == "vertex_fan" && row.severity == Some(4.0) { leaks } else { 0.0 };
            }
        };
        set(&mut record, "triangle/a", 1.0, 60_000.0);
        set(&mut record, "triangle/b", 2.0, 0.0);
        set(&mut record, "triangle/c", 2.01, 0.0);
        let [first, second, ..] = &lines(&record)[..] else { panic!("{:?}", lines(&record)) };
        assert!(first.contains("`b`** or, as fast, `c` loses none"), "{first}");
        assert!(second.contains("`a`** is 2.00× as fast, and loses up to 6.0 % (vertex fan 4)"), "{second}");
        assert!(lines(&record)[2].starts_with("**No `t` is more exact:** `b` errs by"), "{}", lines(&record)[2]);
        // Apart by more than the noise: no longer an equal.
        set(&mut record, "triangle/c", 2.03, 0.0);
        let generic = record.accuracy.iter_mut().find(|row| row.id == "triangle/c" && row.workload == "generic");
        generic.unwrap().t_ulp_p99 = 1;
        let exact = &lines(&record)[2];
        assert!(exact.contains("`c`** errs by 1 ulp instead of 7 (99th percentile), takes 1.01× the time."), "{exact}");
        assert!(lines(&record)[0].contains("`b`** loses none"), "{}", lines(&record)[0]);
    }

    #[test]
    fn noise_is_said_and_ties_are_counted() {
        let mut record = record_of(&["triangle/a".into(), "triangle/b".into(), "triangle/c".into()]);
        let text = |record: &Record| noise(record, &groups(record)).unwrap();
        assert!(text(&record).contains("by 1.2 % in the middle. Of 2 pairs") && text(&record).contains(", 0 differ"));
        record.speed.iter_mut().for_each(|row| row.ns_per_test_mad = row.ns_per_test);
        assert!(text(&record).starts_with("**The machine was noisy") && text(&record).contains(", 2 differ"));
    }

    #[test]
    fn degenerate_records_have_a_verdict_or_none() {
        for record in degenerate_records() {
            let text = lines(&record).join("\n") + &noise(&record, &groups(&record)).unwrap_or_default();
            assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
        }
    }
}
