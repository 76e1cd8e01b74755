//! The section on another build of the program: the same kernels, built for other processors.

use super::cells::code;
use crate::study::figures::{Group, KernelFigures, MISSING, on_scenes, times};
use crate::study::measure::stats::{Estimate, median, ratio};
use crate::study::present::grid::{Cell, Grid};
use crate::study::present::verdict::interval;
use crate::study::record::Record;

/// The section; `None` if no other build was timed.
pub(super) fn section(record: &Record, groups: &[Group]) -> Option<String> {
    let target = record.other_build.as_ref()?;
    let mut grid = Grid::new(1, ["kernel", "1x1", "8x1", "1x8", "whole scenes"]);
    let kernels = || groups.iter().flat_map(|group| &group.kernels);
    for kernel in kernels() {
        let mut row = vec![code(&kernel.method.id)];
        row.extend(["1x1", "8x1", "1x8"].map(|width| cell(in_tests(record, kernel, width))));
        row.push(cell(in_scenes(record, kernel)));
        grid.rows.push(row);
    }
    let packets: Vec<f64> = kernels().filter_map(|kernel| Some(in_tests(record, kernel, "8x1")?.value)).collect();
    let medians = if packets.is_empty() {
        String::new()
    } else {
        format!(" The median of 8x1 over all kernels is {}.", times(Some(median(&packets))))
    };
    Some(format!(
        "## The build for {target}\n\nThe program was built for `{target}` too, and timed in processes that took turns \
         with those of this build. Both found the same hits, bit for bit. The table shows the time of that build over \
         the time of this one, with its 95 % interval: above 1, that build is slower.{medians} {MISSING}: that build \
         does not contain the kernel, or it was not timed in scenes.\n\n{}",
        grid.markdown()
    ))
}

fn in_tests(record: &Record, kernel: &KernelFigures, width: &str) -> Option<Estimate> {
    let other =
        record.other_speed.iter().find(|row| (&row.id, &*row.width, row.threads) == (&kernel.method.id, width, 1));
    ratio(&other?.ns_of_rounds, &kernel.speed(width, 1)?.ns_of_rounds)
}

fn in_scenes(record: &Record, kernel: &KernelFigures) -> Option<Estimate> {
    let [own, other] = [&record.scene_speed, &record.other_scene_speed]
        .map(|rows| on_scenes::times(rows, &kernel.method.id, |_| true));
    ratio(&other?, &own?)
}

fn cell(ratio: Option<Estimate>) -> Cell {
    Cell::from(ratio.map_or(MISSING.to_owned(), interval))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::figures::groups;
    use crate::study::record::Samples;
    use crate::study::tests::fixture::{all_ids, record_of};

    #[test]
    fn every_kernel_is_compared_and_one_that_the_build_lacks_is_shown_as_missing() {
        let mut record = record_of(&all_ids());
        assert_eq!(section(&record, &groups(&record)), None);
        record.other_build = Some("x86-64-v3".into());
        record.other_speed = record.speed.clone();
        record.other_scene_speed = record.scene_speed.clone();
        let lacking = record.methods[0].id.clone();
        record.other_speed.retain(|row| row.id != lacking);
        for row in &mut record.other_speed {
            let slower = row.ns_of_rounds.groups().iter().map(|round| round.iter().map(|ns| ns * 1.5).collect());
            row.ns_of_rounds = Samples::new(&slower.collect::<Vec<_>>());
        }
        let text = section(&record, &groups(&record)).unwrap();
        for method in &record.methods {
            let row = text.lines().find(|line| line.starts_with(&format!("| `{}` |", method.id))).unwrap();
            let traced = record.scene_speed.iter().any(|row| row.kernel == method.id);
            let in_tests = if method.id == lacking { MISSING } else { "1.50× (1.50 to 1.50)" };
            let in_scenes = if traced { "1.00× (1.00 to 1.00) |" } else { "– |" };
            assert_eq!(
                row.split(" | ").skip(1).collect::<Vec<_>>(),
                [in_tests, in_tests, in_tests, in_scenes],
                "{row}"
            );
        }
        assert!(text.contains("The median of 8x1 over all kernels is 1.50×."), "{text}");
    }
}
