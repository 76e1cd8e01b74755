//! The sections on errors: regimes step by step, failure maps, claims, and kernels that this build does not contain.

use super::accuracy;
use super::cells::code;
use crate::study::figures::failures::{FAILING_RATE, FAILING_ULP, Metric, Verdict, verdict};
use crate::study::figures::{Group, KernelFigures, MISSING, count, number, severity};
use crate::study::present::chart::{SPEED_ACCURACY_INSTANCES, failure_map_file, maps_of, stability_file};
use crate::study::present::grid::{Cell, Grid};
use crate::study::record::{ClaimRow, Record, RegimeRow};

/// The section on regimes: a summary of all, then a chart and tables for each regime of triangles and boxes.
pub(super) fn stability(record: &Record, groups: &[Group]) -> Vec<String> {
    if record.regimes.is_empty() {
        return Vec::new();
    }
    let mut parts = vec![
        "## Stability\n\nA regime is a workload that gets harder step by step. In its chart, easy is on the left and \
         hard on the right. Its tables have a row for each kernel and a column for each severity. Rates are per \
         million. If no event was observed, the number in brackets is the 95 % bound, and the chart has a hollow mark \
         there. One or two events lie below such a mark."
            .to_owned(),
        format!(
            "### Which kernels fail, and where\n\nA kernel fails at a step if one of its rates exceeds {} %, or if the \
             99th percentile of the error of `t` exceeds {FAILING_ULP} ulp. False hits of boxes are no failure: they \
             only cost a look inside. For instances, the methods are compared with the same kernel inside. Brackets \
             give the figures at the first failing step. For a kernel that does not fail, they give its smaller \
             errors.",
            number(FAILING_RATE / 1e4, 1)
        ),
        what_fails_where(record, groups),
    ];
    parts.extend(regimes(record, groups, |regime| !is_curved_or_placed(regime)));
    parts
}

/// Whether a regime is about quadrics or instances. These fail in ways of their own: by roots and by inverses.
fn is_curved_or_placed(regime: &RegimeRow) -> bool {
    regime.family == "quadric" || regime.family.starts_with("instance")
}

/// The section on quadrics and instances: the cost of instances, and a chart and tables for each regime.
pub(super) fn transforms_and_quadrics(record: &Record, groups: &[Group]) -> Vec<String> {
    let sections = regimes(record, groups, is_curved_or_placed);
    let instances = groups.iter().any(|group| !group.is_base());
    if sections.is_empty() && !instances {
        return Vec::new();
    }
    let mut parts = vec![
        "## Transforms and quadrics\n\nQuadrics fail where their discriminant cancels. Transforms fail where the \
         transformed ray is rounded. An instance costs one transform of the ray, and the setup of the inner kernel for \
         that ray."
            .to_owned(),
    ];
    if instances {
        parts.push(format!("![Speed against accuracy of instances]({SPEED_ACCURACY_INSTANCES})"));
    }
    parts.extend(sections);
    parts
}

/// A chart and tables for each of these regimes: one for each metric, and one about hits at the last step.
fn regimes(record: &Record, groups: &[Group], shown: impl Fn(&RegimeRow) -> bool) -> Vec<String> {
    let mut parts = Vec::new();
    for regime in record.regimes.iter().filter(|regime| shown(regime)) {
        let kernels: Vec<&KernelFigures> = kernels_of(groups, regime).collect();
        parts.push(format!("### {}, {}\n\n{}", regime.family, regime.name.replace('_', " "), regime.about));
        parts.push(format!("![{}, {}]({})", regime.family, regime.name, stability_file(regime)));
        for &metric in Metric::of(regime) {
            parts.push(format!("{}, by {}:", capitalized(metric.title()), regime.axis));
            parts.push(steps(&kernels, regime, metric));
        }
        if let Some(&hardest) = regime.steps.last() {
            let rows = kernels.iter().filter_map(|kernel| Some((*kernel, kernel.at_step(&regime.name, hardest)?)));
            parts.push(format!("Points, normals and leaving rays at the last step, {}:", severity(hardest)));
            parts.push(accuracy::hits(&rows.collect::<Vec<_>>()));
        }
    }
    parts
}

/// The kernels that were measured in a regime.
fn kernels_of<'a>(groups: &'a [Group<'a>], regime: &'a RegimeRow) -> impl Iterator<Item = &'a KernelFigures<'a>> {
    let measured =
        |kernel: &&KernelFigures| regime.steps.iter().any(|&step| kernel.at_step(&regime.name, step).is_some());
    let groups = groups.iter().filter(|group| group.title == regime.family);
    groups.flat_map(|group| &group.kernels).filter(measured)
}

/// The text with its first letter in upper case.
fn capitalized(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// For each regime: the kernels that do not fail, and those that do, ordered by their first failing step.
fn what_fails_where(record: &Record, groups: &[Group]) -> String {
    let header = ["regime", "hardest step", "never failing", "failing, earliest first"];
    let mut grid = Grid::new(header.len(), header);
    for regime in &record.regimes {
        let verdicts: Vec<_> =
            kernels_of(groups, regime).filter_map(|kernel| Some((kernel, verdict(kernel, regime)?))).collect();
        let holding = verdicts.iter().filter_map(|(kernel, verdict)| match verdict {
            Verdict::Holds { minor } if minor.is_empty() => Some(format!("`{}`", kernel.name)),
            Verdict::Holds { minor } => Some(format!("`{}` ({minor})", kernel.name)),
            Verdict::Fails { .. } => None,
        });
        let holding: Vec<_> = holding.collect();
        let mut failing: Vec<_> = verdicts
            .iter()
            .filter_map(|(kernel, verdict)| match verdict {
                Verdict::Holds { .. } => None,
                Verdict::Fails { first, at, how } => Some((*first, format!("`{}` {at} ({how})", kernel.name))),
            })
            .collect();
        failing.sort_by_key(|&(first, _)| first);
        let failing: Vec<_> = failing.into_iter().map(|(_, text)| text).collect();
        let listed = |list: Vec<String>, separator| {
            Cell::from(if list.is_empty() { MISSING.to_owned() } else { list.join(separator) })
        };
        let hardest = regime.steps.last().map_or(MISSING.to_owned(), |&step| severity(step));
        grid.rows.push(vec![
            Cell::from(format!("{}, {}", regime.family, regime.name.replace('_', " "))),
            Cell::from(hardest),
            listed(holding, ", "),
            listed(failing, "; "),
        ]);
    }
    grid.markdown()
}

/// Kernel × severity: the values of a metric.
fn steps(kernels: &[&KernelFigures], regime: &RegimeRow, metric: Metric) -> String {
    let mut grid = Grid::new(1, ["kernel"]);
    grid.header.extend(regime.steps.iter().map(|&step| Cell::from(severity(step))));
    for kernel in kernels {
        let figures = regime.steps.iter().map(|&step| metric.figure(kernel.at_step(&regime.name, step)?));
        let cells = figures.map(|figure| Cell::from(figure.map_or(MISSING.to_owned(), |figure| figure.to_string())));
        grid.rows.push([code(&kernel.method.id)].into_iter().chain(cells).collect());
    }
    grid.markdown()
}

/// The section on failure maps.
pub(super) fn failure_maps(record: &Record, groups: &[Group]) -> Vec<String> {
    let shown = groups.iter().filter(|group| !maps_of(record, group).is_empty());
    let images: Vec<_> = shown.map(|group| format!("![{}]({})", group.title, failure_map_file(group))).collect();
    if images.is_empty() {
        return Vec::new();
    }
    let text = "## Failure maps\n\nThe 99th percentile of the error of `t` over two severities. All rays exactly hit, \
                strictly inside. Light cells have small errors, dark cells large ones. In red, striped cells, more \
                than 1 % of the rays miss.";
    [text.to_owned()].into_iter().chain(images).collect()
}

/// The section on claims. Kernel × claim: kept or broken, whether the kernel makes the claim or not.
pub(super) fn claims(record: &Record, groups: &[Group]) -> Vec<String> {
    let text = "## Claims\n\nWhat kernels claim, and whether any ray broke a claim. Kernels that do not make a claim \
                are tested too: a claim that every kernel keeps would tell nothing. For quadrics, `right-decision` and \
                `no-gross-error` do not cover the workload `edge`, whose rays pass as close as possible to \
                silhouettes, rims and apices.";
    let mut parts = Vec::new();
    for group in groups {
        let rows = |id: &str| record.claims.iter().filter(move |row| row.id == id).collect::<Vec<_>>();
        let mut claims: Vec<&str> = Vec::new();
        for row in group.kernels.iter().flat_map(|kernel| rows(&kernel.method.id)) {
            if !claims.contains(&row.claim.as_str()) {
                claims.push(&row.claim);
            }
        }
        if claims.is_empty() {
            continue;
        }
        let mut grid = Grid::new(1 + claims.len(), ["kernel"]);
        grid.header.extend(claims.iter().map(|&claim| Cell::from(claim)));
        for kernel in &group.kernels {
            let rows = rows(&kernel.method.id);
            let cells = claims.iter().map(|claim| {
                let row = rows.iter().find(|row| row.claim == *claim);
                Cell::from(row.map_or(MISSING.to_owned(), |row| claim_text(row)))
            });
            grid.rows.push([code(&kernel.method.id)].into_iter().chain(cells).collect());
        }
        parts.push(grid.markdown());
    }
    if parts.is_empty() { parts } else { [text.to_owned()].into_iter().chain(parts).collect() }
}

/// A cell of the table of claims.
fn claim_text(row: &ClaimRow) -> String {
    let [broken, of] = [row.violations, row.of].map(count);
    match (row.claimed, row.violations, row.of) {
        (true, 0, 0) => "claimed, not tested".into(),
        (false, 0, 0) => "not claimed, not tested".into(),
        (true, 0, _) => format!("claimed, kept (0 of {of})"),
        (true, ..) => format!("claimed, **BROKEN** {broken} of {of}"),
        (false, 0, _) => format!("not claimed, not broken in {of} rays"),
        (false, ..) => format!("not claimed: broken {broken} of {of}"),
    }
}

/// The kernels that this build does not contain, and why.
pub(super) fn absent(record: &Record) -> Option<String> {
    let lines: String = record.absent.iter().map(|row| format!("- `{}`: {}\n", row.id, row.reason)).collect();
    (!lines.is_empty()).then(|| format!("## Not in this build\n\n{lines}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::figures::groups;
    use crate::study::tests::fixture::{all_ids, record_of};

    #[test]
    fn the_summary_lists_failing_kernels_by_their_first_failing_step() {
        let record = record_of(&all_ids());
        let summary = what_fails_where(&record, &groups(&record));
        let line = |start: &str| summary.lines().find(|line| line.starts_with(start)).unwrap().to_owned();
        // In the made-up record, rates grow from a step on that comes later for each kernel. Every fourth kernel has
        // none.
        let line = line("| triangle, sliver | 1e6 |");
        let cells: Vec<&str> = line.split(" | ").collect();
        assert!(cells[2].contains("`baldwin_weber`") && !cells[3].contains("baldwin"), "{line}");
        let (first, later) =
            (cells[3].find("`cramer` from 1e5 (").unwrap(), cells[3].find("`moller_trumbore` ").unwrap());
        assert!(first < later, "{line}");
        assert_eq!(summary.lines().count(), 2 + record.regimes.len());
        // Methods of instancing are listed by their own names, each once.
        let line =
            summary.lines().find(|line| line.starts_with("| instance of triangle, translation | 1e6 |")).unwrap();
        for method in ["subtract_first", "inverse", "f64", "baked"] {
            assert_eq!(line.matches(&format!("`{method}`")).count(), 1, "{line}");
        }
    }

    #[test]
    fn every_regime_has_a_chart_and_a_table_for_each_metric_and_for_hits() {
        let record = record_of(&all_ids());
        let groups = groups(&record);
        let text = [stability(&record, &groups), transforms_and_quadrics(&record, &groups)].concat().join("\n\n");
        for regime in &record.regimes {
            let section = text.split("\n### ").find(|section| section.contains(&stability_file(regime))).unwrap();
            assert!(section.contains(&regime.about));
            let group = groups.iter().find(|group| group.title == regime.family).unwrap();
            for kernel in &group.kernels {
                let rows = section.matches(&format!("\n| `{}` |", kernel.method.id)).count();
                assert_eq!(rows, Metric::of(regime).len() + 1, "{} {}", regime.name, kernel.method.id);
            }
        }
        assert!(text.contains("| 0 (< 180) |"), "a zero in 20,000 rays must be shown with its bound");
    }

    #[test]
    fn a_claim_is_kept_broken_or_not_made() {
        let row = |claimed, violations, of| {
            claim_text(&ClaimRow { id: String::new(), claim: String::new(), claimed, violations, of })
        };
        assert_eq!(row(true, 0, 1000), "claimed, kept (0 of 1,000)");
        assert_eq!(row(true, 2, 1000), "claimed, **BROKEN** 2 of 1,000");
        assert_eq!(row(false, 2, 1000), "not claimed: broken 2 of 1,000");
        assert_eq!(row(false, 0, 1000), "not claimed, not broken in 1,000 rays");
        assert_eq!(row(true, 0, 0), "claimed, not tested");
        let record = record_of(&all_ids());
        let text = claims(&record, &groups(&record)).join("\n\n");
        for kernel in &record.methods {
            assert_eq!(text.matches(&format!("\n| `{}` |", kernel.id)).count(), 1, "{}", kernel.id);
        }
    }
}
