//! The table that says which kernel of each group to use, and the legend of its figures.

use crate::study::figures::{Group, KernelFigures, Loss, MISSING, count, number, tied, times};
use crate::study::present::grid::{Cell, Grid};
use crate::study::record::SpeedRow;

/// The section on which kernel to use.
pub(super) fn advice(groups: &[Group]) -> String {
    format!("## Which kernel\n\n{}", advice_table(groups))
}

/// For each group: the fastest kernel, the one that loses the fewest rays, and the one with the most accurate `t`.
pub(crate) fn advice_table(groups: &[Group]) -> String {
    let header = ["kernels", "fastest in packets (8x1)", "fewest lost rays", "most accurate `t`"];
    let mut grid = Grid::new(header.len(), header);
    for group in groups {
        let mut timed: Vec<(&KernelFigures, &SpeedRow)> =
            group.kernels.iter().filter_map(|kernel| Some((kernel, kernel.speed("8x1", 1)?))).collect();
        timed.sort_by(|(_, a), (_, b)| a.ns_per_test.total_cmp(&b.ns_per_test));
        let cells = [fastest(&timed), fewest_lost(&timed), most_accurate(&timed)];
        let mut row = vec![Cell::from(group.heading())];
        row.extend(cells.map(|cell| Cell::from(cell.unwrap_or(MISSING.to_owned()))));
        grid.rows.push(row);
    }
    grid.markdown()
}

/// The timed kernels of a group, fastest first.
type Timed<'a> = [(&'a KernelFigures<'a>, &'a SpeedRow)];

fn fastest(timed: &Timed) -> Option<String> {
    let &(kernel, row) = timed.first()?;
    let ties = timed[1..].iter().filter(|(_, other)| tied(row, other)).map(|(kernel, _)| kernel.name.as_str());
    let lost = kernel.lost.map_or(String::new(), |lost| format!(", loses {lost}"));
    Some(format!(
        "**`{}`** {} M/s{lost}{}",
        kernel.name,
        number(row.tests_per_second / 1e6, 3),
        list("tied with", ties)
    ))
}

fn fewest_lost(timed: &Timed) -> Option<String> {
    // All zeros count as equal, however many rays they stand for.
    best(timed, |kernel| kernel.lost.map(|lost| lost.per_million), |kernel| kernel.lost.map(|lost| lost.to_string()))
}

fn most_accurate(timed: &Timed) -> Option<String> {
    best(timed, |kernel| kernel.ulp().map(|ulp| ulp as f64), |kernel| Some(format!("{} ulp", count(kernel.ulp()?))))
}

/// The fastest of the kernels with the smallest `figure`, and its time relative to the fastest kernel of the group.
fn best(
    timed: &Timed,
    figure: impl Fn(&KernelFigures) -> Option<f64>,
    text: impl Fn(&KernelFigures) -> Option<String>,
) -> Option<String> {
    let least = timed.iter().filter_map(|(kernel, _)| figure(kernel)).reduce(f64::min)?;
    let equals: Vec<_> = timed.iter().filter(|(kernel, _)| figure(kernel) == Some(least)).collect();
    let (kernel, row) = equals.first()?;
    let price = times(Some(row.ns_per_test / timed[0].1.ns_per_test));
    let (ties, slower): (Vec<_>, Vec<_>) = equals[1..].iter().partition(|(_, other)| tied(row, other));
    let names = |of: Vec<&&(&KernelFigures, &SpeedRow)>, remark| {
        list(remark, of.iter().map(|(kernel, _)| kernel.name.as_str()))
    };
    let others = names(ties, "equally good and tied in speed:") + &names(slower, "equally good but slower:");
    Some(format!("**`{}`** {}, {price} the time{others}", kernel.name, text(kernel)?))
}

/// A remark about other kernels: up to four by name, or their number.
fn list<'a>(remark: &str, names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<_> = names.map(|name| format!("`{name}`")).collect();
    match names.len() {
        0 => String::new(),
        1..=4 => format!("; {remark} {}", names.join(", ")),
        more => format!("; {remark} {more} others"),
    }
}

/// The meaning of the figures of [`advice`].
pub(super) fn legend(groups: &[Group]) -> String {
    let mut text =
        "M/s: million tests of one ray against one primitive per second, in one thread. Two kernels tie if the \
         interval of their ratio contains 1. Times are relative to the fastest kernel. ulp: 99th percentile of the \
         error of `t` on generic rays, in units in the last place. `0 (< b)`: no event was observed, and b is the 95 % \
         bound. Lost rays:\n"
            .to_owned();
    for loss in Loss::ALL {
        let mut same = groups.iter().filter(|group| group.loss == loss);
        if let Some(first) = same.next() {
            let titles: Vec<_> = [first].into_iter().chain(same).map(|group| group.title.as_str()).collect();
            text += &format!("\n- {}: {}", titles.join(", "), first.lost_means());
        }
    }
    text
}
