//! The answer: the first page of a report. It says which kernel to use, what the others get wrong and where, and how to
//! choose. Everything else is in the appendix.

use super::cells::code;
use super::renderer;
use crate::study::figures::failures::{Metric, Verdict, verdict_by};
use crate::study::figures::on_scenes::Answers;
use crate::study::figures::{Failures, Group, KernelFigures, MISSING, Rate, count, number, optional};
use crate::study::present::grid::{Cell, Grid};
use crate::study::present::verdict::place;
use crate::study::record::Record;

/// The figures of both charts: speed per test, and wrong answers where rays are aimed, in pictures and at edges.
pub(super) fn figures(record: &Record, groups: &[&Group]) -> String {
    let header = [
        "kernel",
        "1x1, M tests/s",
        "8x1, M tests/s",
        "1x8, M tests/s",
        "lost, aimed rays",
        "false or double, aimed rays",
        "wrong, pictures",
        "wrong, edges of scenes",
    ];
    let mut grid = Grid::new(1, header);
    for group in groups {
        for kernel in &group.kernels {
            let mut row = vec![code(&kernel.method.id).best_if(group.is_among_the_safest(kernel))];
            row.extend(["1x1", "8x1", "1x8"].map(|width| {
                Cell::from(optional(kernel.mtests(width, 1), 3)).best_if(group.is_among_the_fastest(kernel, width))
            }));
            let rates = [
                kernel.lost.map(|lost| lost.rate),
                kernel.false_hits.map(|false_hits| false_hits.rate),
                Answers::in_pictures(record, &kernel.method.id).map(|answers| answers.wrong()),
                Answers::at_edges(record, &kernel.method.id).map(|answers| answers.wrong()),
            ];
            row.extend(rates.map(|rate| Cell::from(rate.map_or(MISSING.to_owned(), |rate: Rate| rate.to_string()))));
            grid.rows.push(row);
        }
    }
    let means = groups.iter().map(|group| format!("- {}: {}.", group.title, group.lost_means()));
    format!(
        "{}\nBold names have the fewest wrong answers, or tie. Rates are per million; `0 (< b)`: none was seen; b is \
         the upper end of the 95 % interval. *False or double*: in a mesh, rays that exactly hit one triangle and are \
         reported to hit several; elsewhere, exact misses reported as hits. *Lost*:\n\n{}",
        grid.markdown(),
        means.collect::<Vec<_>>().join("\n")
    )
}

/// For each kernel, the regimes in which it gives wrong answers, and its worst rates.
pub(super) fn what_fails(record: &Record, groups: &[&Group]) -> String {
    let header = ["kernel", "wrong in", "loses at most, %", "false or double at most, %"];
    let mut grid = Grid::new(2, header);
    for group in groups {
        for kernel in &group.kernels {
            let worst = |failures: Option<Failures>| {
                let worst = failures.and_then(|failures| failures.worst);
                let text = |(row, rate): (_, Rate)| format!("{} ({})", number(rate.per_million() / 1e4, 2), place(row));
                Cell::from(worst.map_or("0".into(), text))
            };
            // A false hit of a bounding box is harmless.
            let false_hits = if group.shape == "aabb" { Cell::from(MISSING) } else { worst(kernel.false_hits) };
            let fails = Cell::from(fails_in(record, group, kernel));
            grid.rows.push(vec![code(&kernel.method.id), fails, worst(kernel.lost), false_hits]);
        }
    }
    format!(
        "## What fails where\n\nA regime is a workload that gets harder step by step; the [appendix](appendix.md) \
         explains each of them. A kernel is *wrong in* a regime if more than 0.1 % of its answers are wrong at one of \
         its steps. In brackets: the workload, and the step, in the regime's unit.\n\n{}",
        grid.markdown()
    )
}

fn fails_in(record: &Record, group: &Group, kernel: &KernelFigures) -> String {
    let regimes = record.regimes.iter().filter(|regime| regime.family == group.title);
    let (mut failing, mut holding) = (Vec::new(), Vec::new());
    for regime in regimes {
        let name = regime.name.replace('_', " ");
        match verdict_by(kernel, regime, |metric| metric != Metric::Ulp) {
            Some(Verdict::Fails { .. }) => failing.push(name),
            Some(Verdict::Holds { .. }) => holding.push(name),
            None => {}
        }
    }
    match (&failing[..], &holding[..]) {
        ([], _) => "none".into(),
        (failing, []) => format!("all {}", failing.len()),
        (failing, holding) if failing.len() > holding.len() => {
            format!("all but {} of {}: {}", holding.len(), failing.len() + holding.len(), holding.join(", "))
        }
        (failing, _) => failing.join(", "),
    }
}

/// Which kernel fits which need, among those with the fewest wrong answers.
pub(super) fn how_to_choose(record: &Record, groups: &[&Group]) -> Option<String> {
    let lines: Vec<String> =
        groups.iter().flat_map(|group| needs(group).into_iter().chain(renderer::line(record, group))).collect();
    (!lines.is_empty()).then(|| format!("## How to choose\n\n{}", lines.join("\n")))
}

fn needs(group: &Group) -> Vec<String> {
    let safest = group.safest();
    let Some(best) = safest.first() else { return Vec::new() };
    let names = |kernels: &[&KernelFigures]| {
        kernels.iter().map(|kernel| format!("`{}`", kernel.name)).collect::<Vec<_>>().join(", ")
    };
    let right: Vec<_> = group.kernels.iter().filter(|kernel| group.is_among_the_safest(kernel)).collect();
    let mut lines = vec![format!("- {}: use {}.", group.title, names(&safest))];
    let bytes = |kernel: &&KernelFigures| kernel.method.prepared_bytes;
    if let Some(small) = right.iter().copied().min_by_key(bytes).filter(|small| bytes(small) < bytes(best)) {
        let time = small.ns("8x1").zip(best.ns("8x1")).map(|(small, best)| small / best);
        lines.push(format!(
            "- {}, if memory is short: `{}` is as right and prepares {} bytes per primitive instead of {}. It takes {} \
             the time of `{}` (8x1).",
            group.title,
            small.name,
            bytes(&small),
            bytes(best),
            crate::study::figures::times(time),
            best.name
        ));
    }
    // Rows that count no hits have no error.
    let error = |kernel: &&KernelFigures| kernel.greatest_ulp().unwrap_or(u64::MAX);
    if let Some(exact) = right.iter().copied().min_by_key(error).filter(|exact| error(exact) < error(best)) {
        lines.push(format!(
            "- {}, if `t` itself matters: in the hardest step of all regimes, 99 % of the errors of `{}` stay below {} \
             units in the last place, and those of `{}` below {}.",
            group.title,
            exact.name,
            count(error(&exact)),
            best.name,
            count(error(best))
        ));
    }
    lines
}
