//! The sections on what goes wrong: regimes step by step, failure maps, claims and absent kernels.

use super::cells::code;
use crate::study::figures::failures::{FAILING_RATE, FAILING_ULP, Measure, Verdict, verdict};
use crate::study::figures::{Figures, Group, MISSING, count, number, severity};
use crate::study::present::chart::{SPEED_ACCURACY_INSTANCES, failure_map_file, maps_of, stability_file};
use crate::study::present::grid::{Cell, Grid};
use crate::study::record::{ClaimRow, Record, RegimeRow};

/// Regimes: what fails where, and then, of triangles and boxes, a chart and tables for each.
pub(super) fn stability(record: &Record, groups: &[Group]) -> Vec<String> {
    if record.regimes.is_empty() {
        return Vec::new();
    }
    let mut parts = vec![
        "## Stability\n\nA regime makes one workload harder step by step. In its chart easy is at the left and hard at \
         the right. In the tables there is a row for each kernel and a column for each severity; rates are per million, \
         and where nothing was observed, the bracket gives the 95 % bound; the chart has a hollow mark there, below which \
         one or two observations lie."
            .to_owned(),
        format!(
            "### What fails where\n\nA kernel fails at a step where more than {} % of the answers of one kind are wrong, or \
             the 99th percentile of the error of `t` exceeds {FAILING_ULP} ulp. False hits of boxes are no failure: they cost \
             a look inside. Of instances, the methods are compared, with the same kernel inside. Brackets give the figures at the first such \
             step, or, of a kernel that holds, what it got wrong nevertheless.",
            number(FAILING_RATE / 1e4, 1)
        ),
        what_fails_where(record, groups),
    ];
    parts.extend(regimes(record, groups, |regime| !is_curved_or_placed(regime)));
    parts
}

/// Quadrics have roots and transforms have inverses, and either fails in its own ways.
fn is_curved_or_placed(regime: &RegimeRow) -> bool {
    regime.family == "quadric" || regime.family.starts_with("instance")
}

/// The regimes of quadrics and of instances, with what instances cost.
pub(super) fn transforms_and_quadrics(record: &Record, groups: &[Group]) -> Vec<String> {
    let sections = regimes(record, groups, is_curved_or_placed);
    let instances = groups.iter().any(|group| !group.is_base());
    if sections.is_empty() && !instances {
        return Vec::new();
    }
    let mut parts = vec![
        "## Transforms and quadrics\n\nQuadrics fail where their discriminant cancels, transforms where the ray that the object \
         sees is rounded. An instance costs one transform of the ray, and the inner kernel's setup anew."
            .to_owned(),
    ];
    if instances {
        parts.push(format!("![Speed against accuracy of instances]({SPEED_ACCURACY_INSTANCES})"));
    }
    parts.extend(sections);
    parts
}

/// A chart and tables for each of these regimes.
fn regimes(record: &Record, groups: &[Group], shown: impl Fn(&RegimeRow) -> bool) -> Vec<String> {
    let mut parts = Vec::new();
    for regime in record.regimes.iter().filter(|regime| shown(regime)) {
        let kernels: Vec<&Figures> = kernels_of(groups, regime).collect();
        parts.push(format!("### {}, {}\n\n{}", regime.family, regime.name.replace('_', " "), regime.about));
        parts.push(format!("![{}, {}]({})", regime.family, regime.name, stability_file(regime)));
        for &measure in Measure::of(regime) {
            parts.push(format!("{}, by {}:", capitalized(measure.title()), regime.axis));
            parts.push(steps(&kernels, regime, measure));
        }
    }
    parts
}

/// The kernels that were measured in a regime.
fn kernels_of<'a>(groups: &'a [Group<'a>], regime: &'a RegimeRow) -> impl Iterator<Item = &'a Figures<'a>> {
    let measured = |kernel: &&Figures| regime.steps.iter().any(|&step| kernel.at_step(&regime.name, step).is_some());
    let groups = groups.iter().filter(|group| group.title == regime.family);
    groups.flat_map(|group| &group.kernels).filter(measured)
}

fn capitalized(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// For each regime the kernels that stay right, and those that fail, first at the easiest step.
fn what_fails_where(record: &Record, groups: &[Group]) -> String {
    let header = ["regime", "hardest", "holding to the last step", "failing, earliest first"];
    let mut grid = Grid::new(header.len(), header);
    for regime in &record.regimes {
        let verdicts: Vec<_> =
            kernels_of(groups, regime).filter_map(|kernel| Some((kernel, verdict(kernel, regime)?))).collect();
        let holding = verdicts.iter().filter_map(|(kernel, verdict)| match verdict {
            Verdict::Holds { but } if but.is_empty() => Some(format!("`{}`", kernel.name)),
            Verdict::Holds { but } => Some(format!("`{}` ({but})", kernel.name)),
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

/// Kernel × severity.
fn steps(kernels: &[&Figures], regime: &RegimeRow, measure: Measure) -> String {
    let mut grid = Grid::new(1, ["kernel"]);
    grid.header.extend(regime.steps.iter().map(|&step| Cell::from(severity(step))));
    for kernel in kernels {
        let figures = regime.steps.iter().map(|&step| measure.figure(kernel.at_step(&regime.name, step)?));
        let cells = figures.map(|figure| Cell::from(figure.map_or(MISSING.to_owned(), |figure| figure.to_string())));
        grid.rows.push([code(&kernel.kernel.id)].into_iter().chain(cells).collect());
    }
    grid.markdown()
}

/// Two severities at once.
pub(super) fn failure_maps(record: &Record, groups: &[Group]) -> Vec<String> {
    let shown = groups.iter().filter(|group| !maps_of(record, group).is_empty());
    let images: Vec<_> = shown.map(|group| format!("![{}]({})", group.title, failure_map_file(group))).collect();
    if images.is_empty() {
        return Vec::new();
    }
    let text = "## Failure maps\n\nThe error of `t` over two severities at once, for rays that all exactly hit strictly \
                inside. Light is right, dark is wrong; in the red, striped cells more than 1 % of the rays miss.";
    [text.to_owned()].into_iter().chain(images).collect()
}

/// Kernel × claim: kept or broken, whether made or not.
pub(super) fn claims(record: &Record, groups: &[Group]) -> Vec<String> {
    let text = "## Claims\n\nWhat kernels promise, and whether any ray broke the promise; also for kernels that do not make \
                it, since a promise that everyone keeps is no information.";
    let mut parts = Vec::new();
    for group in groups {
        let rows = |id: &str| record.claims.iter().filter(move |row| row.id == id).collect::<Vec<_>>();
        let mut claims: Vec<&str> = Vec::new();
        for row in group.kernels.iter().flat_map(|kernel| rows(&kernel.kernel.id)) {
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
            let rows = rows(&kernel.kernel.id);
            let cells = claims.iter().map(|claim| {
                let row = rows.iter().find(|row| row.claim == *claim);
                Cell::from(row.map_or(MISSING.to_owned(), |row| claim_text(row)))
            });
            grid.rows.push([code(&kernel.kernel.id)].into_iter().chain(cells).collect());
        }
        parts.push(grid.markdown());
    }
    if parts.is_empty() { parts } else { [text.to_owned()].into_iter().chain(parts).collect() }
}

fn claim_text(row: &ClaimRow) -> String {
    let [broken, of] = [row.violations, row.of].map(count);
    match (row.claimed, row.violations, row.of) {
        (true, 0, 0) => "claimed, not tested".into(),
        (false, 0, 0) => "not claimed, not tested".into(),
        (true, 0, _) => format!("claimed, kept (0 of {of})"),
        (true, ..) => format!("claimed, **BROKEN** {broken} of {of}"),
        (false, 0, _) => format!("not claimed, yet not broken in {of} rays"),
        (false, ..) => format!("not claimed: broken {broken} of {of}"),
    }
}

/// Kernels that this build has not, and why.
pub(super) fn absent(record: &Record) -> Option<String> {
    let lines: String = record.absent.iter().map(|row| format!("- `{}`: {}\n", row.id, row.reason)).collect();
    (!lines.is_empty()).then(|| format!("## Not in this build\n\n{lines}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::figures::{groups, groups_of_methods};
    use crate::study::tests::fixture::{all_ids, record_of};

    #[test]
    fn the_summary_separates_right_from_failing_and_begins_with_the_earliest() {
        let record = record_of(&all_ids());
        let summary = what_fails_where(&record, &groups_of_methods(&record));
        let line = |start: &str| summary.lines().find(|line| line.starts_with(start)).unwrap().to_owned();
        // The made-up rates grow eightfold from a step on that comes later with each kernel; the fourth never errs.
        let line = line("| triangle, sliver | 1e6 |");
        let cells: Vec<&str> = line.split(" | ").collect();
        assert!(cells[2].contains("`baldwin_weber`") && !cells[3].contains("baldwin"), "{line}");
        let (first, later) =
            (cells[3].find("`cramer` from 1e5 (").unwrap(), cells[3].find("`moller_trumbore` ").unwrap());
        assert!(first < later, "{line}");
        assert_eq!(summary.lines().count(), 2 + record.regimes.len());
        // Methods by their own names alone, and each once.
        let line =
            summary.lines().find(|line| line.starts_with("| instance of triangle, translation | 1e6 |")).unwrap();
        for method in ["subtract_first", "inverse", "f64", "baked"] {
            assert_eq!(line.matches(&format!("`{method}`")).count(), 1, "{line}");
        }
        assert!(!line.contains("cramer"), "{line}");
    }

    #[test]
    fn every_regime_has_its_chart_and_a_table_for_each_measure() {
        let record = record_of(&all_ids());
        let groups = groups_of_methods(&record);
        let text = [stability(&record, &groups), transforms_and_quadrics(&record, &groups)].concat().join("\n\n");
        for regime in &record.regimes {
            let section = text.split("\n### ").find(|section| section.contains(&stability_file(regime))).unwrap();
            assert!(section.contains(&regime.about));
            let group = groups.iter().find(|group| group.title == regime.family).unwrap();
            for kernel in &group.kernels {
                let rows = section.matches(&format!("\n| `{}` |", kernel.kernel.id)).count();
                assert_eq!(rows, Measure::of(regime).len(), "{} {}", regime.name, kernel.kernel.id);
            }
        }
        assert!(text.contains("| 0 (< 150) |"), "a zero over 20,000 rays is a bound");
    }

    #[test]
    fn claims_are_kept_broken_or_not_made() {
        let row = |claimed, violations, of| {
            claim_text(&ClaimRow { id: String::new(), claim: String::new(), claimed, violations, of })
        };
        assert_eq!(row(true, 0, 1000), "claimed, kept (0 of 1,000)");
        assert_eq!(row(true, 2, 1000), "claimed, **BROKEN** 2 of 1,000");
        assert_eq!(row(false, 2, 1000), "not claimed: broken 2 of 1,000");
        assert_eq!(row(false, 0, 1000), "not claimed, yet not broken in 1,000 rays");
        assert_eq!(row(true, 0, 0), "claimed, not tested");
        let record = record_of(&all_ids());
        let text = claims(&record, &groups(&record)).join("\n\n");
        for kernel in &record.methods {
            assert_eq!(text.matches(&format!("\n| `{}` |", kernel.id)).count(), 1, "{}", kernel.id);
        }
    }
}
