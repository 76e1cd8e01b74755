//! The record as a table for a terminal.

use super::grid::{Cell, Grid};
use super::verdict::verdict;
use crate::study::figures::tracer::{TracedSet, modes};
use crate::study::figures::{Failures, KernelFigures, MISSING, count, groups, number, optional, thread_counts, times};
use crate::study::record::Record;

/// The record as text, in at most 110 columns for IDs of the usual length. Of the instances, only those are shown that
/// compare methods with the same inner kernel. The verdict comes last, where it stays visible.
///
/// With `color`, ANSI colours mark the best of each group and all that tie with it (green), and lost rays (red).
pub fn terminal_table(record: &Record, color: bool) -> String {
    let mut text = kernel_grid(record).terminal(color);
    text += "\n\
             ns: nanoseconds per test of one ray against one primitive, one thread. gain: time of 1x1 over 8x1.\n\
             Mt/s: million tests per second, 8x1. Green: the best, and all that tie with it.\n\
             lost: rays that exactly hit but are reported to miss; false: exact misses reported as hits, double hits\n\
             among them. Both per million rays aimed where kernels fail. worst in: the hardest workload.\n\
             0 (< b): none; b is the 95 % bound. ulp: 99th percentile of the error of t, generic rays.\n";
    if let Some(claims) = claims(record) {
        text += &claims;
    }
    if !record.tracer.is_empty() {
        text += "\n";
        text += &tracer_grid(record).terminal(color);
        text += "\n\
                 scalar, single, packet, auto: million rays per second; 1T: with one thread.\n\
                 auto/best: auto over the faster of single and packet. gain: auto over scalar.\n\
                 scaling: auto with several threads over auto with one. ?: > 1× per thread: noise or shared clock.\n";
    }
    let verdict = verdict(record, &groups(record));
    if !verdict.is_empty() {
        text += "\n";
        // A terminal does not show Markdown emphasis.
        text.extend(verdict.iter().map(|line| format!("- {}\n", line.replace(['*', '`'], ""))));
    }
    text
}

/// The number of claims that hold, and the list of those that do not.
fn claims(record: &Record) -> Option<String> {
    let (broken, kept): (Vec<_>, Vec<_>) =
        record.claims.iter().filter(|row| row.claimed && row.of > 0).partition(|row| row.violations > 0);
    let mut text = format!("claims: {} hold, {} are broken\n", kept.len(), broken.len());
    for row in &broken {
        text += &format!(
            "  BROKEN: {} is not {}: {} of {} rays\n",
            row.id,
            row.claim,
            count(row.violations),
            count(row.of)
        );
    }
    (!broken.is_empty() || !kept.is_empty()).then_some(text)
}

/// Failures per million of the rays that decide.
fn rate(failures: Option<Failures>) -> Cell {
    let rate = failures.map(|failures| failures.rate);
    Cell::from(rate.map_or(MISSING.to_owned(), |rate| rate.to_string()))
        .bad_if(rate.is_some_and(|rate| rate.events > 0))
}

/// The workload that loses the most rays per million; empty if none is lost.
fn lost_in(kernel: &KernelFigures) -> String {
    kernel.lost.and_then(|lost| lost.worst).map_or(String::new(), |(row, _)| row.workload.replace('_', " "))
}

fn kernel_grid(record: &Record) -> Grid {
    let threads = thread_counts(record.speed.iter().map(|row| row.threads));
    let mut grid = Grid::new(1, ["kernel", "ns 1x1", "ns 8x1", "gain"]);
    grid.header.extend(threads.iter().map(|threads| Cell::from(format!("Mt/s {threads}T"))));
    grid.header.extend(["lost", "false", "worst in", "ulp"].map(Cell::from));
    for group in groups(record) {
        grid.rows.push(vec![Cell::from(group.heading())]);
        let ulp = group.kernels.iter().filter_map(KernelFigures::ulp).min();
        for kernel in &group.kernels {
            let mut row = vec![
                Cell::from(format!("  {}", kernel.name)),
                Cell::from(optional(kernel.ns("1x1"), 3)).best_if(group.is_among_the_fastest(kernel, "1x1")),
                Cell::from(optional(kernel.ns("8x1"), 3)).best_if(group.is_among_the_fastest(kernel, "8x1")),
                Cell::from(times(kernel.gain())),
            ];
            row.extend(threads.iter().map(|&threads| Cell::from(optional(kernel.mtests("8x1", threads), 3))));
            row.extend([rate(kernel.lost), rate(kernel.false_hits)]);
            row.push(Cell::from(lost_in(kernel)));
            row.push(Cell::from(kernel.ulp().map_or(MISSING.to_owned(), count)).best_if(kernel.ulp() == ulp));
            grid.rows.push(row);
        }
    }
    grid
}

fn tracer_grid(record: &Record) -> Grid {
    let threads = thread_counts(record.tracer.iter().map(|row| row.threads).filter(|&threads| threads > 1));
    let mut grid = Grid::new(1, ["scene, rays"]);
    grid.header.extend(modes().map(|mode| Cell::from(format!("{mode} 1T"))));
    grid.header.extend(["auto/best", "gain"].map(Cell::from));
    for threads in &threads {
        grid.header.extend([format!("auto {threads}T"), format!("scaling {threads}T")].map(Cell::from));
    }
    let mut heading = String::new();
    for traced in TracedSet::all(record) {
        let first = traced.first;
        let scene = format!(
            "{}: {} primitives, {} instances, built in {} s, {} bytes per primitive, {}",
            first.scene,
            count(first.triangles as u64),
            count(first.instances as u64),
            number(first.build_seconds, 2),
            number(first.bytes_per_triangle, 3),
            first.kernel
        );
        if scene != heading {
            grid.rows.push(vec![Cell::from(scene.as_str())]);
            heading = scene;
        }
        let mut row = vec![Cell::from(format!("  {}", first.rays))];
        row.extend(modes().map(|mode| {
            let row = traced.row(mode, 1);
            Cell::from(optional(row.map(|row| row.mrays_per_second), 3))
                .best_if(row.is_some_and(|row| traced.is_among_the_fastest(row)))
        }));
        row.extend([traced.auto_over_best(), traced.gain()].map(|ratio| Cell::from(times(ratio))));
        for &threads in &threads {
            let scaling = traced.scaling("auto", threads);
            let doubt = if scaling.is_some_and(|scaling| scaling.is_doubtful()) { "?" } else { "" };
            let scaling = times(scaling.map(|scaling| scaling.value())) + doubt;
            row.extend([optional(traced.mrays("auto", threads), 3), scaling].map(Cell::from));
        }
        grid.rows.push(row);
    }
    grid
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::tests::fixture::{all_ids, degenerate_records, record_of};

    #[test]
    fn the_table_shows_every_kernel_in_at_most_110_columns() {
        let record = record_of(&all_ids());
        let plain = terminal_table(&record, false);
        for group in groups(&record) {
            let section = plain.lines().skip_while(|line| *line != group.heading());
            let names: Vec<_> = section.skip(1).map(|line| line.split_whitespace().next().unwrap_or("")).collect();
            let expected: Vec<_> = group.kernels.iter().map(|kernel| kernel.name.as_str()).collect();
            assert!(names.starts_with(&expected), "{}: {names:?}", group.title);
        }
        assert!(plain.contains(" 0 (< "), "a zero must be shown with its bound");
        let (tables, verdict) = plain.split_at(plain.find("\n- ").unwrap());
        assert!(tables.lines().all(|line| line.chars().count() <= 110), "{plain}");
        assert!(verdict.contains("- Triangles: ") && verdict.contains("- Quadrics: "), "{verdict}");
        assert!(!plain.contains('\x1b'));
    }

    #[test]
    fn colours_do_not_change_the_text() {
        let record = record_of(&all_ids());
        let mut colored = terminal_table(&record, true);
        assert!(colored.matches("\x1b[31m").count() > 10, "wrong answers must be red");
        for code in ["0", "1", "31", "32"] {
            colored = colored.replace(&format!("\x1b[{code}m"), "");
        }
        assert_eq!(colored, terminal_table(&record, false));
    }

    #[test]
    fn degenerate_records_have_a_table() {
        for record in degenerate_records() {
            let table = terminal_table(&record, false);
            assert!(!table.contains("NaN") && !table.contains("inf"), "{table}");
        }
    }
}
