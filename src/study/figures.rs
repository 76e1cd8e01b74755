//! What table, chart and report share: kernels grouped into those that can be compared, figures as text, and grids of
//! cells.

use std::collections::BTreeSet;
use std::fmt;

use super::record::{AccuracyRow, KernelRow, Record, SpeedRow, TracerRow};

/// Printed where the record has no figure.
pub(super) const MISSING: &str = "–";

/// The kernels that can be compared: of one shape, and instances apart from what they are instances of.
#[derive(Debug)]
pub(super) struct Group<'a> {
    /// `triangle`, `instance of triangle`.
    pub(super) title: String,
    /// What all IDs begin with; a whole number of their parts, with the last slash.
    pub(super) prefix: String,
    /// Whether rays were aimed at meshes, so that [`Figures::lost`] counts leaks.
    pub(super) mesh: bool,
    /// In the order of the record.
    pub(super) kernels: Vec<Figures<'a>>,
}

impl Group<'_> {
    /// The title, with what the names lack where that is not the same.
    pub(super) fn heading(&self) -> String {
        if self.prefix.strip_suffix('/') == Some(self.title.as_str()) {
            self.title.clone()
        } else {
            format!("{} ({}…)", self.title, self.prefix)
        }
    }

    /// What [`Figures::lost`] counts, per million of what.
    pub(super) fn lost_means(&self) -> &'static str {
        if self.mesh {
            "leaks per million edge-aimed rays that exactly hit the mesh, edges included"
        } else {
            "lost rays (strict false misses and boundary hits reported as none) per million edge-aimed rays that exactly hit"
        }
    }
}

/// What the record says about one kernel.
#[derive(Debug)]
pub(super) struct Figures<'a> {
    /// The kernel.
    pub(super) kernel: &'a KernelRow,
    /// What distinguishes its ID within its group.
    pub(super) name: &'a str,
    /// Edge-aimed rays that exactly hit and are reported to hit nothing.
    pub(super) lost: Option<Rate>,
    record: &'a Record,
}

impl<'a> Figures<'a> {
    /// Throughput of a face.
    pub(super) fn speed(&self, face: &str, threads: usize) -> Option<&'a SpeedRow> {
        let mut rows = self.record.speed.iter();
        rows.find(|row| row.id == self.kernel.id && row.face == face && row.threads == threads)
    }

    /// Errors on a workload.
    pub(super) fn accuracy(&self, workload: &str) -> Option<&'a AccuracyRow> {
        self.record.accuracy.iter().find(|row| row.id == self.kernel.id && row.workload == workload)
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

    /// 99th percentile of the error of `t` over generic rays.
    pub(super) fn ulp(&self) -> Option<u64> {
        self.accuracy("generic").map(|row| row.t_ulp_p99)
    }

    /// Whether any ray was lost.
    pub(super) fn loses(&self) -> bool {
        self.lost.is_some_and(|lost| lost.per_million > 0.0)
    }
}

/// The kernels of a record, grouped, in its order.
pub(super) fn groups(record: &Record) -> Vec<Group<'_>> {
    let mut groups: Vec<(String, Vec<&KernelRow>)> = Vec::new();
    for kernel in &record.kernels {
        // An instance is named `instance/method/family/method`, anything else `family/method`.
        let title = match kernel.id.split('/').nth(2) {
            Some(inner) => format!("{} of {inner}", kernel.family),
            None => kernel.family.clone(),
        };
        match groups.iter_mut().find(|(other, _)| *other == title) {
            Some((_, kernels)) => kernels.push(kernel),
            None => groups.push((title, vec![kernel])),
        }
    }
    groups.into_iter().map(|(title, kernels)| group(record, title, &kernels)).collect()
}

fn group<'a>(record: &'a Record, title: String, kernels: &[&'a KernelRow]) -> Group<'a> {
    let prefix = common_prefix(kernels);
    let edge = |kernel: &KernelRow| record.accuracy.iter().find(|row| row.id == kernel.id && row.workload == "edge");
    let mesh = kernels.iter().filter_map(|kernel| edge(kernel)).any(|row| row.mesh_hits > 0);
    let kernels = kernels
        .iter()
        .map(|&kernel| Figures {
            kernel,
            name: &kernel.id[prefix.len()..],
            lost: edge(kernel).and_then(if mesh { leaks } else { lost_by_boxes }),
            record,
        })
        .collect();
    Group { title, prefix: prefix.to_owned(), mesh, kernels }
}

/// The longest common beginning that ends with a slash.
fn common_prefix<'a>(kernels: &[&'a KernelRow]) -> &'a str {
    let first = kernels[0].id.as_str();
    let mut ends = first.match_indices('/').map(|(slash, _)| &first[..=slash]);
    ends.rfind(|prefix| kernels.iter().all(|kernel| kernel.id.starts_with(prefix))).unwrap_or("")
}

fn leaks(row: &AccuracyRow) -> Option<Rate> {
    Rate::new(row.leak_per_million, row.mesh_hits)
}

/// A box has no neighbour that could catch what it loses, so its boundary counts like its interior.
fn lost_by_boxes(row: &AccuracyRow) -> Option<Rate> {
    let of = row.exact_hits + row.boundary_none + row.boundary_one + row.boundary_many;
    // Without strict hits their rate has no meaning, and may be anything.
    let strict = Rate::new(row.false_miss_per_million, row.exact_hits).map_or(0.0, Rate::events);
    Rate::new((strict + row.boundary_none as f64) / of as f64 * 1e6, of)
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

/// The numbers of threads that occur, ascending.
pub(super) fn thread_counts(threads: impl Iterator<Item = usize>) -> BTreeSet<usize> {
    threads.collect()
}

/// The rows of the tracer, those of one scene, kind of ray and kernel together; none of the lists is empty.
pub(super) fn tracer_rows(record: &Record) -> Vec<Vec<&TracerRow>> {
    let key = |row: &TracerRow| [&row.scene, &row.rays, &row.kernel].map(String::clone);
    let mut lists: Vec<Vec<&TracerRow>> = Vec::new();
    for row in &record.tracer {
        match lists.iter_mut().find(|list| key(list[0]) == key(row)) {
            Some(list) => list.push(row),
            None => lists.push(vec![row]),
        }
    }
    lists
}

/// The heads of [`tracer_cells`].
pub(super) fn tracer_header(threads: &BTreeSet<usize>) -> impl Iterator<Item = Cell> {
    let heads = |threads| [format!("scalar {threads}T"), format!("packet {threads}T"), "ratio".to_owned()];
    threads.iter().flat_map(heads).map(Cell::from)
}

/// Million rays per second of scalar and packet mode and their ratio, for each number of threads.
pub(super) fn tracer_cells(rows: &[&TracerRow], threads: &BTreeSet<usize>) -> impl Iterator<Item = Cell> {
    let speed = |mode: &str, threads| {
        rows.iter().find(|row| row.mode == mode && row.threads == threads).map(|row| row.mrays_per_second)
    };
    threads.iter().flat_map(move |&threads| {
        let [scalar, packet] = ["scalar", "packet"].map(|mode| speed(mode, threads));
        let ratio = packet.zip(scalar).map(|(packet, scalar)| packet / scalar);
        [optional(scalar, 3), optional(packet, 3), times(ratio)].map(Cell::from)
    })
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
pub(super) mod tests {
    use super::*;
    use crate::study::record::{Machine, SCHEMA};

    /// A record of the given kernels with plausible figures, differing from kernel to kernel.
    pub(in crate::study) fn record_of(ids: &[String]) -> Record {
        let mut record = Record {
            schema: SCHEMA,
            started_unix: 1_800_000_000,
            seconds: 61.5,
            quick: false,
            seed: 1,
            machine: Machine {
                cpu: "Some CPU @ 3 GHz".into(),
                processors: 2,
                os: "linux".into(),
                target: "x86_64-unknown-linux-gnu".into(),
                target_features: ["avx2", "fma"].map(String::from).to_vec(),
                rustc: "rustc 1.95.0".into(),
                versions: ["raylanes 0.1.0", "glam 0.34.2"].map(String::from).to_vec(),
            },
            kernels: Vec::new(),
            absent: Vec::new(),
            speed: Vec::new(),
            regimes: Vec::new(),
            accuracy: Vec::new(),
            claims: Vec::new(),
            maps: Vec::new(),
            map_cells: Vec::new(),
            tracer: Vec::new(),
        };
        for (i, id) in ids.iter().enumerate() {
            add_kernel(&mut record, i, id);
        }
        for (mode, threads, mrays) in [("scalar", 1, 2.5), ("packet", 1, 7.25), ("scalar", 2, 4.9), ("packet", 2, 14.1)]
        {
            record.tracer.push(TracerRow {
                scene: "spheres".into(),
                triangles: 81_920,
                rays: "primary".into(),
                ray_count: 1_048_576,
                hits: 700_000,
                mode: mode.into(),
                kernel: "triangle/moller_trumbore".into(),
                threads,
                mrays_per_second: mrays,
                mrays_per_second_mad: 0.05,
                build_seconds: 0.21,
                bytes_per_triangle: 132.5,
                checksum: "7357c0de".into(),
            });
        }
        record
    }

    fn add_kernel(record: &mut Record, i: usize, id: &str) {
        let mesh = id.contains("triangle");
        record.kernels.push(KernelRow {
            id: id.into(),
            family: id.split('/').next().unwrap_or_default().into(),
            idea: format!("idea {i}"),
            source: "Author, \"Title\", 2000".into(),
            operations: [27, 18, 1],
            prepared_bytes: 36,
            setup_bytes: 12,
            setup_ns: 1.5,
            setup_ns_packet: 0.25,
            claims: if i.is_multiple_of(2) { vec!["conservative".into()] } else { Vec::new() },
        });
        let ns = 6.0 * (1.0 + 0.37 * (i % 7) as f64);
        for (face, ns) in [("1x1", ns), ("8x1", ns / 6.1), ("1x8", ns / 5.2)] {
            for threads in [1, 2] {
                let ns_per_test = ns / (0.95 * threads as f64);
                record.speed.push(SpeedRow {
                    id: id.into(),
                    face: face.into(),
                    threads,
                    ns_per_test,
                    ns_per_test_mad: 0.012 * ns_per_test,
                    tests_per_second: 1e9 / ns_per_test,
                    samples: 15,
                    checksum: format!("{i:016x}"),
                });
            }
        }
        for (workload, rays) in [("generic", 1_000_000), ("edge", 200_000)] {
            let edge = workload == "edge";
            let lost = if edge { [0.0, 51_234.0, 3.5, 840.0][i % 4] } else { 0.0 };
            record.accuracy.push(AccuracyRow {
                id: id.into(),
                workload: workload.into(),
                severity: None,
                rays,
                tests: 8 * rays,
                exact_hits: rays / 4,
                exact_misses: rays / 4,
                false_miss_per_million: lost,
                false_hit_per_million: 0.0,
                boundary_none: if edge { 100 * (i as u64 % 4) } else { 0 },
                boundary_one: if edge { rays / 2 } else { 0 },
                boundary_many: 0,
                mesh_hits: if edge && mesh { rays } else { 0 },
                leak_per_million: lost,
                single_hits: if edge && mesh { rays / 4 } else { 0 },
                double_per_million: 0.0,
                agreed_hits: 45_000,
                t_ulp_p50: 0,
                t_ulp_p99: [2, 4, 0, 44_000, 2][i % 5],
                t_ulp_max: 1 << 20,
                gross_per_million: 0.0,
                uv_error_p99: 1.3e-7,
                uv_error_max: 2.5e-3,
            });
        }
    }

    /// The kernels of today.
    pub(in crate::study) fn some_ids() -> Vec<String> {
        let methods = ["triangle/cramer", "triangle/moller_trumbore", "aabb/division", "aabb/padded"];
        methods
            .iter()
            .map(|&id| id.to_owned())
            .chain(methods.map(|id| format!("instance/subtract_first/{id}")))
            .collect()
    }

    /// No rows but those of the kernels; and rows of zeros.
    pub(in crate::study) fn degenerate_records() -> [Record; 3] {
        let mut bare = record_of(&some_ids());
        bare.speed.clear();
        bare.accuracy.clear();
        bare.tracer.clear();
        let mut zeros = record_of(&some_ids());
        for row in &mut zeros.speed {
            (row.ns_per_test, row.ns_per_test_mad, row.tests_per_second) = (0.0, 0.0, f64::INFINITY);
        }
        for row in &mut zeros.accuracy {
            let (id, workload) = (row.id.clone(), row.workload.clone());
            *row = serde_json::from_value(serde_json::json!({
                "id": id, "workload": workload, "severity": null, "rays": 0, "tests": 0, "exact_hits": 0, "exact_misses": 0,
                "false_miss_per_million": 0.0, "false_hit_per_million": 0.0, "boundary_none": 0, "boundary_one": 0,
                "boundary_many": 0, "mesh_hits": 0, "leak_per_million": 0.0, "single_hits": 0,
                "double_per_million": 0.0, "agreed_hits": 0, "t_ulp_p50": 0, "t_ulp_p99": 0, "t_ulp_max": 0,
                "gross_per_million": 0.0, "uv_error_p99": 0.0, "uv_error_max": 0.0,
            }))
            .unwrap();
        }
        let mut empty = record_of(&[]);
        empty.tracer.clear();
        [bare, zeros, empty]
    }

    #[test]
    fn figures_have_significant_digits() {
        let cases = [(51_234.0, "51,200"), (9.996, "10.0"), (0.12345, "0.123"), (999.6, "1,000"), (1.25e-7, "1.25e-7")];
        for (value, text) in cases {
            assert_eq!(number(value, 3), text);
        }
        assert_eq!(number(0.0, 3), "0");
        assert_eq!(number(f64::NAN, 3), MISSING);
        assert_eq!([count(7), count(1_048_576)], ["7", "1,048,576"]);
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
        let row = record.accuracy.iter_mut().find(|row| row.workload == "edge").unwrap();
        (row.exact_hits, row.false_miss_per_million) = (1000, 5000.0);
        (row.boundary_none, row.boundary_one, row.boundary_many) = (45, 955, 0);
        let lost = groups(&record)[0].kernels[0].lost.unwrap();
        assert_eq!((lost.events(), lost.of), (50.0, 2000));
    }

    #[test]
    fn instances_are_grouped_by_what_they_are_instances_of() {
        let record = record_of(&some_ids());
        let groups = groups(&record);
        let titles: Vec<_> = groups.iter().map(|group| group.title.as_str()).collect();
        assert_eq!(titles, ["triangle", "aabb", "instance of triangle", "instance of aabb"]);
        assert_eq!(groups[2].prefix, "instance/subtract_first/triangle/");
        assert_eq!(groups[2].kernels[1].name, "moller_trumbore");
        assert!(groups[2].mesh && !groups[3].mesh);
    }
}
