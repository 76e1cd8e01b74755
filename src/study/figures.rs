//! What table, chart and report share: kernels grouped into those that can be compared, figures as text, and grids of
//! cells.

use std::collections::BTreeSet;
use std::fmt;

use super::record::{AccuracyRow, KernelRow, MethodRow, Record, RegimeRow, SpeedRow};

/// Printed where the record has no figure.
pub(super) const MISSING: &str = "–";

/// The kernels that can be compared: of one shape, and instances apart from what they are instances of.
#[derive(Debug)]
pub(super) struct Group<'a> {
    /// `triangle`, `instance of triangle`.
    pub(super) title: String,
    /// What all IDs begin with; a whole number of their parts, with the last slash.
    pub(super) prefix: String,
    /// The title, or, of instances that all have one kernel inside, which one: `instance of triangle/moller_trumbore`.
    pub(super) subject: String,
    /// What is hit in the end: `triangle`.
    pub(super) shape: &'a str,
    /// What [`Figures::lost`] counts.
    pub(super) loss: Loss,
    /// The workloads that [`Figures::lost`] is the worst of.
    pub(super) losing: Vec<&'a str>,
    /// In the order of the record.
    pub(super) kernels: Vec<Figures<'a>>,
}

impl Group<'_> {
    /// The fastest of a face in one thread, and all that tie with it.
    pub(super) fn fastest(&self, face: &str) -> Vec<&Figures<'_>> {
        fastest_of(self.kernels.iter(), face)
    }

    /// Whether a kernel of the group is one of these.
    pub(super) fn is_among_the_fastest(&self, kernel: &Figures, face: &str) -> bool {
        self.fastest(face).iter().any(|best| best.kernel.id == kernel.kernel.id)
    }

    /// The title, with what the names lack where that is not the same.
    pub(super) fn heading(&self) -> String {
        let several_methods = !self.is_base() && !self.prefix.ends_with(&format!("/{}/", self.shape));
        if self.prefix.strip_suffix('/') == Some(self.title.as_str()) {
            self.title.clone()
        } else if several_methods {
            format!("{} ({}…/{}/…)", self.title, self.prefix, self.shape)
        } else {
            format!("{} ({}…)", self.title, self.prefix)
        }
    }

    /// Whether these are kernels of primitives, not instances of one.
    pub(super) fn is_base(&self) -> bool {
        self.title == self.shape
    }

    /// What [`Figures::lost`] counts, per million of what, over which workloads.
    pub(super) fn lost_means(&self) -> String {
        let what = match self.loss {
            Loss::Leaks => "leaks per million rays that exactly hit a mesh, edges included",
            Loss::WithBoundary => {
                "lost rays (false misses, and boundary hits reported as none) per million that exactly hit"
            }
            Loss::Strict => "lost rays (false misses) per million that exactly hit, boundaries apart",
        };
        let worst = if self.losing.len() > 1 { "the worst of" } else { "of" };
        format!("{what}; {worst} {}", self.losing.join(", "))
    }
}

/// Which rays count as lost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Loss {
    /// Those that hit a mesh: a neighbour may catch what one triangle loses.
    Leaks,
    /// All that hit, the boundary included, which nothing else would catch.
    WithBoundary,
    /// Those that hit but not on the boundary: where a surface is curved, its silhouette is nobody's edge.
    Strict,
}

impl Loss {
    pub(super) const ALL: [Self; 3] = [Self::Leaks, Self::WithBoundary, Self::Strict];

    fn by(shape: &str, mesh: bool) -> Self {
        match (shape, mesh) {
            (_, true) => Self::Leaks,
            ("quadric", _) => Self::Strict,
            _ => Self::WithBoundary,
        }
    }

    fn of(self, row: &AccuracyRow) -> Option<Rate> {
        match self {
            Self::Leaks => leaks(row),
            Self::WithBoundary => lost_by_boxes(row),
            Self::Strict => Rate::new(row.false_miss_per_million, row.exact_hits),
        }
    }

    /// Whether a regime's rays are aimed at what may be lost so.
    fn concerns(self, regime: &RegimeRow) -> bool {
        let one_of = |names: &[&str]| names.contains(&regime.name.as_str());
        match self {
            Self::Leaks => regime.mesh,
            Self::WithBoundary => one_of(&["box_edge", "box_corner", "parallel", "flat"]),
            Self::Strict => one_of(&["afar", "tangent", "parabolic", "generatrix"]),
        }
    }
}

/// What the record says about one kernel.
#[derive(Debug)]
pub(super) struct Figures<'a> {
    /// The kernel.
    pub(super) kernel: &'a MethodRow,
    /// What distinguishes its ID within its group, the family of an instance's inner kernel left out: that is in the group's
    /// title.
    pub(super) name: String,
    /// Rays that exactly hit and are reported to hit nothing, by [`Group::loss`]: the worst of [`Group::losing`] and their severities, or, where
    /// there are none, all of them together.
    pub(super) lost: Option<Rate>,
    /// The row that `lost` is from, if any were.
    pub(super) lost_in: Option<&'a AccuracyRow>,
    record: &'a Record,
}

impl<'a> Figures<'a> {
    /// Throughput of a face.
    pub(super) fn speed(&self, face: &str, threads: usize) -> Option<&'a SpeedRow> {
        let mut rows = self.record.speed.iter();
        rows.find(|row| row.id == self.kernel.id && row.face == face && row.threads == threads)
    }

    /// Errors on a workload that has no severities.
    pub(super) fn accuracy(&self, workload: &str) -> Option<&'a AccuracyRow> {
        self.rows(workload).find(|row| row.severity.is_none())
    }

    /// Errors at a step of a regime.
    pub(super) fn at_step(&self, regime: &str, severity: f64) -> Option<&'a AccuracyRow> {
        self.rows(regime).find(|row| row.severity == Some(severity))
    }

    fn rows(&self, workload: &str) -> impl Iterator<Item = &'a AccuracyRow> {
        rows_of(self.record, &self.kernel.id).filter(move |row| row.workload == workload)
    }

    /// Nanoseconds per test in one thread.
    pub(super) fn ns(&self, face: &str) -> Option<f64> {
        self.speed(face, 1).map(|row| row.ns_per_test)
    }

    /// Million tests per second.
    pub(super) fn mtests(&self, face: &str, threads: usize) -> Option<f64> {
        self.speed(face, threads).map(|row| row.tests_per_second / 1e6)
    }

    /// How much less time a test takes in a packet of eight rays.
    pub(super) fn gain(&self) -> Option<f64> {
        Some(self.ns("1x1")? / self.ns("8x1")?)
    }

    /// The figures of eight rays against one primitive at a glance.
    pub(super) fn packet(&self) -> Option<&'a KernelRow> {
        self.record.kernels.iter().find(|row| row.id == self.kernel.id && row.face == "8x1")
    }

    /// What share of the time of a packet its busiest class of operations takes at least.
    pub(super) fn limit_share(&self) -> Option<f64> {
        self.packet()?.limit_share
    }

    /// The same of scalar code, were a scalar operation to take as long as one on eight lanes.
    pub(super) fn scalar_limit_share(&self) -> Option<f64> {
        Some(8.0 * self.packet()?.limit_ns? / self.ns("1x1")?).filter(|share| share.is_finite())
    }

    /// 99th percentile of the error of `t` over generic rays.
    pub(super) fn ulp(&self) -> Option<u64> {
        self.accuracy("generic").and_then(ulp_p99)
    }

    /// Whether any ray was lost.
    pub(super) fn loses(&self) -> bool {
        self.lost.is_some_and(|lost| lost.per_million > 0.0)
    }
}

/// The fastest of some kernels, in a face and one thread, before all that tie with it, in order of their speed.
pub(super) fn fastest_of<'k, 'a: 'k>(
    kernels: impl Iterator<Item = &'k Figures<'a>>,
    face: &str,
) -> Vec<&'k Figures<'a>> {
    let mut timed: Vec<_> = kernels.filter_map(|kernel| Some((kernel, kernel.speed(face, 1)?))).collect();
    timed.sort_by(|(_, a), (_, b)| a.ns_per_test.total_cmp(&b.ns_per_test));
    let Some(&(_, first)) = timed.first() else { return Vec::new() };
    timed.into_iter().filter(|(_, row)| tied(first, row)).map(|(kernel, _)| kernel).collect()
}

/// The kernels of a record, grouped, in its order.
pub(super) fn groups(record: &Record) -> Vec<Group<'_>> {
    grouped(record, record.methods.iter())
}

/// The same, with only those instances whose inner kernel is that of several methods: regimes and maps, which are about
/// the transform, then compare methods with one kernel inside, and not kernels.
pub(super) fn groups_of_methods(record: &Record) -> Vec<Group<'_>> {
    let is_of_several = |kernel: &&MethodRow| match inner(&kernel.id) {
        Some(own) => record.methods.iter().filter(|other| inner(&other.id) == Some(own)).count() > 1,
        None => true,
    };
    grouped(record, record.methods.iter().filter(is_of_several))
}

/// What an instance is of: an instance is named `instance/method/family/method`, anything else `family/method`.
fn inner(id: &str) -> Option<&str> {
    id.splitn(3, '/').nth(2)
}

/// The family of what an instance is of.
fn inner_family(id: &str) -> Option<&str> {
    inner(id).and_then(|inner| inner.split('/').next())
}

impl MethodRow {
    /// What is hit in the end: the family, or that of the kernel inside an instance.
    pub(super) fn shape(&self) -> &str {
        inner_family(&self.id).unwrap_or(&self.family)
    }
}

/// Whether two timings differ by no more than the sum of their median absolute deviations: they are then not ranked.
pub(super) fn tied(a: &SpeedRow, b: &SpeedRow) -> bool {
    (a.ns_per_test - b.ns_per_test).abs() <= a.ns_per_test_mad + b.ns_per_test_mad
}

fn grouped<'a>(record: &'a Record, kernels: impl Iterator<Item = &'a MethodRow>) -> Vec<Group<'a>> {
    let mut groups: Vec<(&str, Option<&str>, Vec<&MethodRow>)> = Vec::new();
    for kernel in kernels {
        let key = (kernel.family.as_str(), inner_family(&kernel.id));
        match groups.iter_mut().find(|(family, inner, _)| (*family, *inner) == key) {
            Some((.., kernels)) => kernels.push(kernel),
            None => groups.push((key.0, key.1, vec![kernel])),
        }
    }
    groups.into_iter().map(|(family, inner, kernels)| group(record, family, inner, &kernels)).collect()
}

fn group<'a>(record: &'a Record, family: &'a str, inner: Option<&'a str>, kernels: &[&'a MethodRow]) -> Group<'a> {
    let title = inner.map_or(family.to_owned(), |inner| format!("{family} of {inner}"));
    let shape = inner.unwrap_or(family);
    let own =
        self::inner(&kernels[0].id).filter(|own| kernels.iter().all(|kernel| self::inner(&kernel.id) == Some(own)));
    let subject = own.map_or(title.clone(), |own| format!("{family} of {own}"));
    let prefix = common_prefix(kernels);
    let suffix = common_suffix(kernels, prefix);
    let mesh = kernels.iter().any(|kernel| rows_of(record, &kernel.id).any(|row| row.mesh_hits > 0));
    let loss = Loss::by(shape, mesh);
    let losing = losing_workloads(record, shape, loss, kernels);
    let kernels = kernels
        .iter()
        .map(|&kernel| {
            let rows = rows_of(record, &kernel.id).filter(|row| losing.contains(&row.workload.as_str()));
            let rates = rows.filter_map(|row| Some((loss.of(row)?, row)));
            let rates: Vec<(Rate, &AccuracyRow)> = rates.collect();
            let worst = rates.iter().max_by(|(a, _), (b, _)| a.per_million.total_cmp(&b.per_million));
            // Where nothing was lost anywhere, it was lost by none of all these rays.
            let all = rates.iter().map(|(rate, _)| rate.of).sum();
            let lost = worst.map(|(rate, _)| if rate.per_million == 0.0 { Rate { of: all, ..*rate } } else { *rate });
            Figures {
                kernel,
                name: kernel.id[prefix.len()..kernel.id.len() - suffix.len()].replace(&format!("/{shape}/"), "/"),
                lost,
                lost_in: worst.filter(|(rate, _)| rate.per_million > 0.0).map(|&(_, row)| row),
                record,
            }
        })
        .collect();
    Group { title, prefix: prefix.to_owned(), subject, shape, loss, losing, kernels }
}

fn rows_of<'a>(record: &'a Record, id: &str) -> impl Iterator<Item = &'a AccuracyRow> {
    record.accuracy.iter().filter(move |row| row.id == id)
}

/// Workloads whose rays are aimed at what a kernel may lose.
fn losing_workloads<'a>(record: &'a Record, shape: &str, loss: Loss, kernels: &[&MethodRow]) -> Vec<&'a str> {
    let loses = |regime: &&RegimeRow| regime.family == shape && loss.concerns(regime);
    let measured =
        |workload: &&str| kernels.iter().any(|kernel| rows_of(record, &kernel.id).any(|row| row.workload == *workload));
    let regimes = record.regimes.iter().filter(loses).map(|regime| regime.name.as_str());
    ["edge"].into_iter().chain(regimes).filter(measured).collect()
}

/// The longest common beginning that ends with a slash.
fn common_prefix<'a>(kernels: &[&'a MethodRow]) -> &'a str {
    let first = kernels[0].id.as_str();
    let mut ends = first.match_indices('/').map(|(slash, _)| &first[..=slash]);
    ends.rfind(|prefix| kernels.iter().all(|kernel| kernel.id.starts_with(prefix))).unwrap_or("")
}

/// The longest common ending, after the prefix, that begins with a slash.
fn common_suffix<'a>(kernels: &[&'a MethodRow], prefix: &str) -> &'a str {
    let first = &kernels[0].id[prefix.len()..];
    let mut starts = first.match_indices('/').map(|(slash, _)| &first[slash..]);
    starts.find(|suffix| kernels.iter().all(|kernel| kernel.id[prefix.len()..].ends_with(suffix))).unwrap_or("")
}

/// Rays that hit a mesh and are lost.
pub(super) fn leaks(row: &AccuracyRow) -> Option<Rate> {
    Rate::new(row.leak_per_million, row.mesh_hits)
}

/// Rays that hit one triangle of a mesh strictly inside, and are reported to hit several.
pub(super) fn doubles(row: &AccuracyRow) -> Option<Rate> {
    Rate::new(row.double_per_million, row.single_hits)
}

/// A box has no neighbour that could catch what it loses, so its boundary counts like its interior.
pub(super) fn lost_by_boxes(row: &AccuracyRow) -> Option<Rate> {
    let of = row.exact_hits + row.boundary_none + row.boundary_one + row.boundary_many;
    // Without strict hits their rate has no meaning, and may be anything.
    let strict = Rate::new(row.false_miss_per_million, row.exact_hits).map_or(0.0, Rate::events);
    Rate::new((strict + row.boundary_none as f64) / of as f64 * 1e6, of)
}

/// False misses and false hits together.
pub(super) fn wrong(row: &AccuracyRow) -> Option<Rate> {
    let sides = [(row.false_miss_per_million, row.exact_hits), (row.false_hit_per_million, row.exact_misses)];
    // A rate of nothing has no meaning, and may be anything.
    let events: f64 = sides.iter().filter_map(|&(rate, of)| Rate::new(rate, of)).map(Rate::events).sum();
    let of = row.exact_hits + row.exact_misses;
    Rate::new(events / of as f64 * 1e6, of)
}

/// Agreed hits whose `t` is off by more than 1 %.
pub(super) fn gross(row: &AccuracyRow) -> Option<Rate> {
    Rate::new(row.gross_per_million, row.agreed_hits)
}

/// The 99th percentile of the error of `t`, where there are hits whose `t` could err.
pub(super) fn ulp_p99(row: &AccuracyRow) -> Option<u64> {
    (row.agreed_hits > 0).then_some(row.t_ulp_p99)
}

/// So many per million, of a number of rays or pairs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rate {
    /// Events per million.
    pub(super) per_million: f64,
    /// The base.
    pub(super) of: u64,
}

impl Rate {
    /// `None` where the base is empty.
    pub(super) fn new(per_million: f64, of: u64) -> Option<Self> {
        (of > 0 && per_million >= 0.0 && per_million.is_finite()).then_some(Self { per_million, of })
    }

    /// Number of events.
    pub(super) fn events(self) -> f64 {
        self.per_million * self.of as f64 / 1e6
    }

    /// The rate; for a zero its 95 % bound, `3/n`.
    pub(super) fn or_bound(self) -> f64 {
        if self.per_million > 0.0 { self.per_million } else { 3e6 / self.of as f64 }
    }
}

impl fmt::Display for Rate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.per_million > 0.0 {
            f.write_str(&number(self.per_million, 3))
        } else {
            write!(f, "0 (< {})", number(self.or_bound(), 2))
        }
    }
}

/// `value` to that many significant digits, thousands separated.
pub(super) fn number(value: f64, digits: i32) -> String {
    if !value.is_finite() {
        return MISSING.to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    // The exponent after rounding: 9.996 to three digits is 10.0.
    let scientific = format!("{value:.*e}", (digits - 1).max(0) as usize);
    let exponent: i32 = scientific.rsplit('e').next().and_then(|exponent| exponent.parse().ok()).unwrap_or(0);
    if !(-4..12).contains(&exponent) {
        return scientific;
    }
    let rounded: f64 = scientific.parse().unwrap_or(value);
    let plain = format!("{rounded:.*}", (digits - 1 - exponent).max(0) as usize);
    let (whole, fraction) = plain.split_at(plain.find('.').unwrap_or(plain.len()));
    separated(whole) + fraction
}

/// A severity, as short as it can be.
pub(super) fn severity(value: f64) -> String {
    match value.abs() {
        1e3..1e5 => count(value.round() as u64),
        1e-2..1e3 => short(&format!("{:.*}", if value < 1.0 { 3 } else { 1 }, value)).to_owned(),
        0.0 => "0".to_owned(),
        _ => {
            let scientific = format!("{value:.1e}");
            let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
            format!("{}e{exponent}", short(mantissa))
        }
    }
}

/// A decimal fraction without its last zeros.
fn short(fraction: &str) -> &str {
    fraction.trim_end_matches('0').trim_end_matches('.')
}

/// A whole number, thousands separated.
pub(super) fn count(value: u64) -> String {
    separated(&value.to_string())
}

fn separated(digits: &str) -> String {
    let mut out = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

/// `value` to that many significant digits, with a unit prefix.
pub(super) fn si(value: f64, digits: i32) -> String {
    match value.abs() {
        1e9.. => number(value / 1e9, digits) + " G",
        1e6.. => number(value / 1e6, digits) + " M",
        1e4.. => number(value / 1e3, digits) + " k",
        _ => number(value, digits),
    }
}

/// A figure that may be missing.
pub(super) fn optional(value: Option<f64>, digits: i32) -> String {
    value.map_or(MISSING.to_owned(), |value| number(value, digits))
}

/// A ratio that may be missing.
pub(super) fn times(ratio: Option<f64>) -> String {
    ratio.filter(|ratio| ratio.is_finite()).map_or(MISSING.to_owned(), |ratio| format!("{ratio:.2}×"))
}

/// A share that may be missing, in whole percent.
pub(super) fn percent(share: Option<f64>) -> String {
    share.filter(|share| share.is_finite()).map_or(MISSING.to_owned(), |share| format!("{:.0} %", 100.0 * share))
}

/// The numbers of threads that occur, ascending.
pub(super) fn thread_counts(threads: impl Iterator<Item = usize>) -> BTreeSet<usize> {
    threads.collect()
}

/// A cell, and whether it stands out.
#[derive(Clone, Debug)]
pub(super) struct Cell {
    text: String,
    emphasis: Emphasis,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Emphasis {
    None,
    Best,
    Bad,
}

impl<T: Into<String>> From<T> for Cell {
    fn from(text: T) -> Self {
        Self { text: text.into(), emphasis: Emphasis::None }
    }
}

impl Cell {
    /// Marks the best of its kind.
    pub(super) fn best_if(self, best: bool) -> Self {
        if best { Self { emphasis: Emphasis::Best, ..self } } else { self }
    }

    pub(super) fn bad_if(self, bad: bool) -> Self {
        if bad { Self { emphasis: Emphasis::Bad, ..self } } else { self }
    }
}

/// A table whose first `left` columns are text, and the others numbers.
#[derive(Debug)]
pub(super) struct Grid {
    left: usize,
    /// Heads of the columns.
    pub(super) header: Vec<Cell>,
    /// Rows as long as the header, or of one cell: a heading across all columns.
    pub(super) rows: Vec<Vec<Cell>>,
}

impl Grid {
    /// A grid without rows.
    pub(super) fn new<const N: usize>(left: usize, header: [&str; N]) -> Self {
        Self { left, header: header.map(Cell::from).to_vec(), rows: Vec::new() }
    }

    /// In Markdown; the best cells are bold.
    pub(super) fn markdown(&self) -> String {
        let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
        let rule = |column| if column < self.left { "---" } else { "--:" }.to_owned();
        let text = |cell: &Cell| {
            let text = cell.text.replace('|', "\\|");
            if cell.emphasis == Emphasis::Best { format!("**{text}**") } else { text }
        };
        let mut out = line(self.header.iter().map(text).collect());
        out += &line((0..self.header.len()).map(rule).collect());
        out.extend(self.rows.iter().map(|row| line(row.iter().map(text).collect())));
        out
    }

    /// In columns, with colours if asked for.
    pub(super) fn terminal(&self, color: bool) -> String {
        let width = |cell: &Cell| cell.text.chars().count();
        let full_rows = || self.rows.iter().filter(|row| row.len() == self.header.len()).chain([&self.header]);
        let widths: Vec<usize> = (0..self.header.len())
            .map(|column| full_rows().map(|row| width(&row[column])).max().unwrap_or(0))
            .collect();
        let paint = |text: &str, code: &str| {
            if color { format!("\x1b[{code}m{text}\x1b[0m") } else { text.to_owned() }
        };
        let line = |row: &Vec<Cell>| {
            let cells = row.iter().enumerate().map(|(column, cell)| {
                // Padding stays outside of the colour codes, which have no width.
                let padding = " ".repeat(widths[column].saturating_sub(width(cell)));
                let text = match cell.emphasis {
                    Emphasis::None => cell.text.clone(),
                    Emphasis::Best => paint(&cell.text, "32"),
                    Emphasis::Bad => paint(&cell.text, "31"),
                };
                if column < self.left { text + &padding } else { padding + &text }
            });
            cells.collect::<Vec<_>>().join("  ").trim_end().to_owned()
        };
        let mut out = paint(&line(&self.header), "1") + "\n";
        for row in &self.rows {
            let heading = row.len() < self.header.len();
            out += &if heading { paint(&line(row), "1") } else { line(row) };
            out += "\n";
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::fixture::{all_ids, record_of};

    #[test]
    fn figures_have_significant_digits() {
        let cases = [(51_234.0, "51,200"), (9.996, "10.0"), (0.12345, "0.123"), (999.6, "1,000"), (1.25e-7, "1.25e-7")];
        for (value, text) in cases {
            assert_eq!(number(value, 3), text);
        }
        assert_eq!(number(0.0, 3), "0");
        assert_eq!(number(f64::NAN, 3), MISSING);
        assert_eq!([count(7), count(1_048_576)], ["7", "1,048,576"]);
        let severities = [1e-15, 0.0999, 1e-6 * (1.0 + 1e-15), 0.25, 1.0, 30.0, 65_536.0, 1.5e7, 0.0].map(severity);
        assert_eq!(severities, ["1e-15", "0.1", "1e-6", "0.25", "1", "30", "65,536", "1.5e7", "0"]);
        assert_eq!([si(2e6, 1), si(51_200.0, 3), si(250.0, 3)], ["2 M", "51.2 k", "250"]);
    }

    #[test]
    fn a_zero_rate_is_a_bound() {
        assert_eq!(Rate::new(0.0, 100_000).unwrap().to_string(), "0 (< 30)");
        assert_eq!(Rate::new(10.0, 100_000).unwrap().to_string(), "10.0");
        assert_eq!(Rate::new(0.0, 0), None);
        assert_eq!(Rate::new(f64::NAN, 1), None);
    }

    #[test]
    fn boxes_lose_strict_hits_and_boundary_hits() {
        let mut record = record_of(&["aabb/division".into()]);
        record.accuracy.retain(|row| row.severity.is_none());
        let row = record.accuracy.iter_mut().find(|row| row.workload == "edge").unwrap();
        (row.exact_hits, row.false_miss_per_million) = (1000, 5000.0);
        (row.boundary_none, row.boundary_one, row.boundary_many) = (45, 955, 0);
        let lost = groups(&record)[0].kernels[0].lost.unwrap();
        assert_eq!((lost.events(), lost.of), (50.0, 2000));
    }

    #[test]
    fn what_is_lost_is_the_worst_of_the_workloads_that_aim_at_it() {
        let mut record = record_of(&["triangle/cramer".into(), "aabb/division".into()]);
        for row in &mut record.accuracy {
            (row.leak_per_million, row.false_miss_per_million, row.boundary_none) = (0.0, 0.0, 0);
            let worst = if row.mesh_hits > 0 { ("vertex_fan", Some(256.0)) } else { ("flat", Some(0.0)) };
            if (row.workload.as_str(), row.severity) == worst {
                (row.leak_per_million, row.false_miss_per_million) = (70.0, 100.0);
            }
            // Neither is aimed at what could be lost.
            if row.workload == "generic" || row.workload == "offset" {
                (row.leak_per_million, row.false_miss_per_million) = (1e5, 1e5);
            }
        }
        let groups = groups(&record);
        assert_eq!(groups[0].losing, ["edge", "shared_edge", "vertex_fan", "closed_mesh"]);
        assert_eq!(groups[1].losing, ["edge", "box_edge", "box_corner", "parallel", "flat"]);
        let [triangle, bounds] = [0, 1].map(|group: usize| &groups[group].kernels[0]);
        assert_eq!(triangle.lost, Rate::new(70.0, 20_000));
        assert_eq!(triangle.lost_in.map(|row| row.severity), Some(Some(256.0)));
        assert!(bounds.lost.is_some_and(|lost| (lost.events() - 1.0).abs() < 1e-9));
        assert_eq!(bounds.lost_in.map(|row| row.workload.as_str()), Some("flat"));
    }

    #[test]
    fn nothing_lost_is_nothing_of_all_rays() {
        let mut record = record_of(&["triangle/cramer".into()]);
        record.accuracy.iter_mut().for_each(|row| row.leak_per_million = 0.0);
        let all = record.accuracy.iter().map(|row| row.mesh_hits).sum();
        let kernel = &groups(&record)[0].kernels[0];
        assert!(all > 200_000 && kernel.lost_in.is_none());
        assert_eq!(kernel.lost, Rate::new(0.0, all));
    }

    #[test]
    fn instances_are_grouped_by_what_they_are_instances_of() {
        let record = record_of(&all_ids());
        let groups = groups(&record);
        let titles: Vec<_> = groups.iter().map(|group| group.title.as_str()).collect();
        assert_eq!(
            titles,
            ["triangle", "aabb", "quadric", "instance of triangle", "instance of aabb", "instance of quadric"]
        );
        assert_eq!((groups[3].prefix.as_str(), groups[3].kernels.len()), ("instance/", 12));
        assert_eq!(groups[3].kernels[1].name, "subtract_first/moller_trumbore");
        assert_eq!(groups[3].heading(), "instance of triangle (instance/…/triangle/…)");
        let losses = groups.iter().map(|group| group.loss);
        let each = [Loss::Leaks, Loss::WithBoundary, Loss::Strict];
        assert!(losses.eq(each.into_iter().chain(each)));
    }

    #[test]
    fn methods_are_compared_with_one_kernel_inside() {
        let record = record_of(&all_ids());
        let names = |group: &Group| group.kernels.iter().map(|kernel| kernel.name.clone()).collect::<Vec<_>>();
        let (groups, methods) = (groups(&record), groups_of_methods(&record));
        assert_eq!([0, 1, 2].map(|base| names(&methods[base])), [0, 1, 2].map(|base| names(&groups[base])));
        assert_eq!(methods[3].title, "instance of triangle");
        assert_eq!(methods[3].subject, "instance of triangle/moller_trumbore");
        assert_eq!([&methods[0].subject, &groups[3].subject], ["triangle", "instance of triangle"]);
        assert_eq!(names(&methods[3]), ["subtract_first", "inverse", "f64", "baked"]);
        assert_eq!(names(&methods[4]), ["subtract_first", "inverse", "f64"]);
        // One method is nothing to compare.
        let record = record_of(&["triangle/cramer".into(), "instance/subtract_first/triangle/cramer".into()]);
        assert_eq!(groups_of_methods(&record).len(), 1);
    }
}
