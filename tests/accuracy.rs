//! Pins the errors of every kernel: counts of wrong answers and errors of `t`, on every workload, step and failure map.
//!
//! The errors depend only on the seed. They are the same in every run, for any number of threads, and in every build
//! that has the kernel, native or baseline. `accuracy.expected` holds them as text, one line for each kernel, workload
//! and step, so `git diff tests/accuracy.expected` shows what became better or worse.
//!
//! After a change that is meant to change errors: `RAYLANES_BLESS=1 cargo test --test accuracy`, then read the diff. A
//! build without FMA lacks some kernels. It keeps their lines.

mod harness;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::{Display, Formatter, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::{Arc, LazyLock};

use libtest_mimic::Trial;
use raylanes::geom::{Aabb, Placed, Quadric, Triangle};
use raylanes::registry;
use raylanes::study::accuracy::Kernels;
use raylanes::study::record::{AccuracyRow, HitErrors, MapCells};
use raylanes::study::workload::{FailureMap, Subject, Workload};
use raylanes::tracer::thread_pool;

/// Rays for each workload and step.
const RAYS: u64 = 2_048;
/// Rays for each cell of a failure map.
const RAYS_PER_CELL: u64 = 32;
const SEED: u64 = 3;

const HOW_TO_BLESS: &str =
    "if this is intended: RAYLANES_BLESS=1 cargo test --test accuracy, then read git diff tests/accuracy.expected";

/// The first lines of the file.
const HEADER: &str = "\
# Errors of each kernel, written by `RAYLANES_BLESS=1 cargo test --test accuracy`. See tests/accuracy.rs.
#
# A line is: kernel, workload, step (a severity of the regime; none for generic and edge), then the figures.
#   tests       pairs of a ray and a primitive
#   false_miss  pairs that hit strictly inside, and that the kernel reports as a miss / all that hit strictly inside
#   false_hit   pairs that miss, and that the kernel reports as a hit / all that miss
#   leak        rays that hit the mesh, and for which the kernel reports no triangle / all that hit the mesh
#   double_hit  rays that hit one triangle strictly inside, and for which the kernel reports more / all such rays
#   odd         rays from outside a closed mesh, for which the kernel reports an odd number of hits / all such rays
#   wrong_closest  rays that hit several triangles, for which the kernel reports another one as closest / all such rays
#   box_rejected   hits that the kernel reports, and that the box rule rejects / all that it reports
#   box_clamped    hits that the kernel reports, and whose t the box rule changes / all that it reports
#   boundary    rays that exactly meet an edge or another boundary: the kernel reports none, one or many primitives
#   t_ulp       distance of t from the correctly rounded t in ulp: median, 99th percentile, greatest
#   gross       hits whose t is off by more than 1 % / all hits that kernel and oracle report
#   uv          absolute error of u and v (of a box: of the exit): 99th percentile, greatest
# The next figures are of one ray in eight: 99th percentile and greatest, relative to the size of the primitive and to
# the largest coordinate.
#   ray_point   distance of origin + t*dir, in f32, from the exact hit
#   uv_point    distance of (1-u-v)*v0 + u*v1 + v*v2, in f32, from the exact hit
#   ray_height  height of origin + t*dir off the exact surface
#   uv_height   height of (1-u-v)*v0 + u*v1 + v*v2 off the exact plane
#   normal      angle between the tracer's normal and the exact one, rad: 99th percentile, greatest
#   backward    error of t over the error that rounding the input to f32 can cause: 99th percentile
#   own_hit     rays that leave the hit, and that the kernel reports to hit the same primitive again / all such rays:
#               from the tracer's start, from origin + t*dir with a t_min of 1e-4 times the largest coordinate, with one
#               of 1e-4 times the length of the ray, and with one of 0
# A figure is left out where there is nothing to count. inf is an error beyond the range of numbers.
#
# In a line of a failure map the step is the severity of the vertical axis. cells are the errors of t along the
# horizontal axis, from easy to hard: the 99th percentile in ulp, or - where more than 1 % of the rays miss.
";

/// Where a line belongs. Lines are sorted by it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Place {
    kernel: String,
    workload: String,
    /// Bits of the severity, which is not negative: they have the order of the numbers.
    step: Option<u64>,
}

impl Place {
    fn new(kernel: &str, workload: &str, step: Option<f64>) -> Self {
        Self { kernel: kernel.into(), workload: workload.into(), step: step.map(f64::to_bits) }
    }

    fn parse(text: &str) -> Option<Self> {
        let mut words = text.split(' ');
        let (kernel, workload) = (words.next()?, words.next()?);
        let step = words.next().map(str::parse).transpose().ok()?;
        words.next().is_none().then(|| Self::new(kernel, workload, step))
    }
}

impl Display for Place {
    fn fmt(&self, f: &mut Formatter) -> std::fmt::Result {
        write!(f, "{} {}", self.kernel, self.workload)?;
        match self.step.map(f64::from_bits) {
            None => Ok(()),
            Some(step) if step == 0.0 || (0.01..1e4).contains(&step) => write!(f, " {step}"),
            Some(step) => write!(f, " {step:e}"),
        }
    }
}

/// The figures of each line, as text.
type Lines = BTreeMap<Place, String>;

/// The count behind a rate.
fn count(per_million: f64, base: u64) -> u64 {
    let count = (per_million * base as f64 / 1e6).round() as u64;
    let expected = if base == 0 { 0.0 } else { 1e6 * count as f64 / base as f64 };
    assert_eq!(per_million, expected, "not the rate of a whole number of {base}");
    count
}

/// All figures of a row. The pattern lists every field: a new field does not compile until it is pinned too.
fn figures(row: &AccuracyRow) -> String {
    let &AccuracyRow {
        id: _,
        workload: _,
        severity: _,
        rays,
        tests,
        exact_hits,
        exact_misses,
        false_miss_per_million,
        false_hit_per_million,
        boundary_none,
        boundary_one,
        boundary_many,
        mesh_hits,
        leak_per_million,
        single_hits,
        double_hit_per_million,
        crossing_rays,
        odd_per_million,
        closest_rays,
        wrong_closest_per_million,
        box_hits,
        box_rejected_per_million,
        box_clamped_per_million,
        agreed_hits,
        t_ulp_p50,
        t_ulp_p99,
        t_ulp_max,
        gross_per_million,
        uv_error_p99,
        uv_error_max,
        hit_errors,
    } = row;
    assert_eq!(rays, RAYS, "{row:?}");
    let mut text = format!("tests {tests}");
    let mut rate = |name, per_million, base| {
        let count = count(per_million, base);
        if base > 0 {
            write!(text, ", {name} {count}/{base}").unwrap();
        }
    };
    rate("false_miss", false_miss_per_million, exact_hits);
    rate("false_hit", false_hit_per_million, exact_misses);
    rate("leak", leak_per_million, mesh_hits);
    rate("double_hit", double_hit_per_million, single_hits);
    rate("odd", odd_per_million, crossing_rays);
    rate("wrong_closest", wrong_closest_per_million, closest_rays);
    rate("box_rejected", box_rejected_per_million, box_hits);
    rate("box_clamped", box_clamped_per_million, box_hits);
    if boundary_none + boundary_one + boundary_many > 0 {
        write!(text, ", boundary none {boundary_none} one {boundary_one} many {boundary_many}").unwrap();
    }
    if agreed_hits > 0 {
        write!(text, ", t_ulp p50 {t_ulp_p50} p99 {t_ulp_p99} max {t_ulp_max}").unwrap();
        write!(text, ", gross {}/{agreed_hits}", count(gross_per_million, agreed_hits)).unwrap();
        let [p99, max] = [uv_error_p99, uv_error_max].map(|error| error as f32);
        assert_eq!([p99, max].map(f64::from), [uv_error_p99, uv_error_max], "errors of u and v are f32");
        write!(text, ", uv p99 {p99:e} max {max:e}").unwrap();
    } else {
        let errors = [uv_error_p99, uv_error_max, gross_per_million];
        assert!(t_ulp_max == 0 && errors == [0.0; 3], "an error without a hit: {row:?}");
    }
    text + &figures_of_hits(&hit_errors)
}

/// All figures about hits, each after a comma.
fn figures_of_hits(errors: &HitErrors) -> String {
    let &HitErrors {
        measured_hits,
        ray_point_size_p99,
        ray_point_scene_p99,
        uv_point_size_p99,
        uv_point_scene_p99,
        ray_height_size_p99,
        ray_height_scene_p99,
        uv_height_size_p99,
        uv_height_scene_p99,
        normal_error_p99,
        t_backward_p99,
        leaving_rays,
        own_hit_offset_per_million,
        own_hit_scene_epsilon_per_million,
        own_hit_t_epsilon_per_million,
        own_hit_no_epsilon_per_million,
    } = errors;
    if measured_hits == 0 {
        assert_eq!(*errors, HitErrors::default(), "an error without a hit");
        return String::new();
    }
    let mut text = format!(", measured {measured_hits}");
    let mut lengths = |name, size: Option<f64>, scene: Option<f64>| {
        // Without a number the shape has no such point.
        if size.or(scene).is_some() {
            let [size, scene] = [size, scene].map(|error| error.unwrap_or(f64::INFINITY));
            write!(text, ", {name} size_p99 {size:e} scene_p99 {scene:e}").unwrap();
        }
    };
    lengths("ray_point", ray_point_size_p99, ray_point_scene_p99);
    lengths("uv_point", uv_point_size_p99, uv_point_scene_p99);
    lengths("ray_height", ray_height_size_p99, ray_height_scene_p99);
    lengths("uv_height", uv_height_size_p99, uv_height_scene_p99);
    if let Some(p99) = normal_error_p99 {
        write!(text, ", normal p99 {p99:e}").unwrap();
    }
    if let Some(p99) = t_backward_p99 {
        write!(text, ", backward p99 {p99:e}").unwrap();
    }
    if leaving_rays > 0 {
        text += ", own_hit";
        for (way, rate) in [
            ("offset", own_hit_offset_per_million),
            ("scene_epsilon", own_hit_scene_epsilon_per_million),
            ("t_epsilon", own_hit_t_epsilon_per_million),
            ("no_epsilon", own_hit_no_epsilon_per_million),
        ] {
            write!(text, " {way} {}/{leaving_rays}", count(rate, leaving_rays)).unwrap();
        }
    }
    text
}

/// Adds a line for each row of a failure map.
fn add_map<S>(lines: &mut Lines, map: &FailureMap<S>, cells: &MapCells) {
    let (width, steps) = (map.x.steps().len(), map.y.steps());
    assert_eq!(cells.t_ulp_p99.len(), width * steps.len(), "{}", map.name);
    for (step, row) in steps.iter().zip(cells.t_ulp_p99.chunks(width)) {
        let row: Vec<_> = row.iter().map(|cell| cell.map_or("-".into(), |ulp| ulp.to_string())).collect();
        // Four steps to a decade: three digits tell them apart.
        let step = format!("{step:.2e}").parse().unwrap();
        lines.insert(Place::new(&cells.id, map.name, Some(step)), format!("cells {}", row.join(" ")));
    }
}

/// The lines of all kernels of a shape.
fn measure<S: Subject>(threads: usize, seed: u64) -> Lines {
    let kernels = Kernels::<S>::registered();
    let measure = || {
        let mut rows: Vec<AccuracyRow> = Vec::new();
        rows.extend(Workload::ALL.into_iter().flat_map(|workload| kernels.on_workload(workload, RAYS, seed)));
        for regime in S::REGIMES {
            rows.extend(regime.steps.iter().flat_map(|&step| kernels.on_regime(regime, step, RAYS, seed)));
        }
        let places = rows.iter().map(|row| Place::new(&row.id, &row.workload, row.severity));
        let mut lines: Lines = places.zip(rows.iter().map(figures)).collect();
        assert_eq!(lines.len(), rows.len(), "two rows have the same name");
        for map in S::MAPS {
            for cells in kernels.on_map(map, RAYS_PER_CELL, seed).1 {
                add_map(&mut lines, map, &cells);
            }
        }
        lines
    };
    thread_pool(threads).unwrap().install(measure)
}

/// A shape, its kernels, and their errors, which are measured when they are first asked for.
struct Subjects {
    title: String,
    kernels: Vec<String>,
    measure: fn(usize, u64) -> Lines,
    lines: Arc<LazyLock<Lines>>,
}

impl Subjects {
    fn of<S: Subject>() -> Self {
        Self {
            title: S::title(),
            kernels: Kernels::<S>::registered().iter().map(|kernel| kernel.id.clone()).collect(),
            measure: measure::<S>,
            lines: Arc::new(LazyLock::new(|| measure::<S>(2, SEED))),
        }
    }
}

fn main() -> ExitCode {
    let subjects = [
        Subjects::of::<Aabb>(),
        Subjects::of::<Triangle>(),
        Subjects::of::<Quadric>(),
        Subjects::of::<Placed<Aabb>>(),
        Subjects::of::<Placed<Triangle>>(),
        Subjects::of::<Placed<Quadric>>(),
    ];
    if std::env::var_os("RAYLANES_BLESS").is_some_and(|value| value == "1") {
        bless(&subjects);
    }
    let pinned = Arc::new(read());
    let mut groups = vec![vec![gone_kernels(&subjects, &pinned), seed_matters(&subjects), differences_are_judged()]];
    groups.extend(subjects.iter().map(|subject| of_shape(subject, &pinned)));
    harness::run(groups, registry::all)
}

/// One test for each kernel, and one that the number of threads does not matter.
fn of_shape(subject: &Subjects, pinned: &Arc<Lines>) -> Vec<Trial> {
    let of_kernel = |id: &String| {
        let (kernel, lines, pinned) = (id.clone(), subject.lines.clone(), pinned.clone());
        harness::of_kernel("errors", id, move || {
            let of_kernel =
                |lines: &Lines| lines.clone().into_iter().filter(|(place, _)| place.kernel == kernel).collect();
            let differences = differences(&of_kernel(&pinned), &of_kernel(&lines));
            if differences.is_empty() { Ok(String::new()) } else { Err(format!("{differences}{HOW_TO_BLESS}")) }
        })
    };
    let mut trials: Vec<_> = subject.kernels.iter().map(of_kernel).collect();
    let (measure, lines) = (subject.measure, subject.lines.clone());
    let name = format!("errors_of_{}_do_not_depend_on_the_number_of_threads", subject.title.replace(' ', "_"));
    trials.push(harness::test(&name, move || assert!(measure(1, SEED) == **lines)));
    trials
}

/// Most lines of each kernel and workload change with the seed.
fn seed_matters(subjects: &[Subjects]) -> Trial {
    let shapes: Vec<_> = subjects.iter().map(|subject| (subject.measure, subject.lines.clone())).collect();
    harness::test("errors_depend_on_the_seed", move || {
        let (mut same, mut all) = (0, 0);
        for (measure, lines) in shapes {
            let others = measure(2, SEED + 1);
            let mut changed = BTreeMap::<_, bool>::new();
            for (place, figures) in lines.iter() {
                *changed.entry((&place.kernel, &place.workload)).or_default() |= others[place] != *figures;
            }
            all += changed.len();
            same += changed.values().filter(|changed| !**changed).count();
        }
        assert!(same < all / 4, "another seed gives the same errors in {same} of {all} workloads");
    })
}

/// Every kernel of the file exists, at least in other builds.
fn gone_kernels(subjects: &[Subjects], pinned: &Lines) -> Trial {
    let known = |place: &&Place| is_absent(&place.kernel) || is_present(subjects, &place.kernel);
    let unknown: BTreeSet<_> = pinned.keys().filter(|place| !known(place)).map(|place| place.kernel.clone()).collect();
    harness::test("every_pinned_kernel_exists", move || {
        assert!(unknown.is_empty(), "pinned, but there is no such kernel: {unknown:?}; {HOW_TO_BLESS}");
    })
}

fn is_present(subjects: &[Subjects], kernel: &str) -> bool {
    subjects.iter().any(|subject| subject.kernels.iter().any(|id| id == kernel))
}

/// Whether this build lacks the kernel.
fn is_absent(kernel: &str) -> bool {
    registry::absent().iter().any(|absent| kernel == absent.id)
}

// ---- The file ------------------------------------------------------------------------------------------------------

fn file() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/accuracy.expected")
}

/// A file that is not there pins nothing.
fn read() -> Lines {
    parse(&std::fs::read_to_string(file()).unwrap_or_default())
}

fn parse(text: &str) -> Lines {
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    let entry = |line: &str| {
        let (place, figures) = line.split_once(": ")?;
        Some((Place::parse(place)?, figures.to_owned()))
    };
    lines
        .map(|line| entry(line).unwrap_or_else(|| panic!("{line:?} is not a kernel, a workload and figures")))
        .collect()
}

/// Writes the file: the lines of this build, and the old lines of the kernels that it lacks.
fn bless(subjects: &[Subjects]) {
    let mut lines = read();
    lines.retain(|place, _| is_absent(&place.kernel));
    lines.extend(subjects.iter().flat_map(|subject| (**subject.lines).clone()));
    let body = lines.iter().map(|(place, figures)| format!("{place}: {figures}\n"));
    std::fs::write(file(), HEADER.to_owned() + &body.collect::<String>()).unwrap();
}

// ---- What changed --------------------------------------------------------------------------------------------------

/// One figure of a line.
#[derive(Debug, PartialEq)]
struct Figure {
    name: String,
    text: String,
    /// The value, or for a count the share.
    value: f64,
}

/// The figures of a line: `name value`, `name count/base`, `name part value part value`, or `cells value value …`.
fn split(figures: &str) -> Vec<Figure> {
    let figure = |name: String, text: &str| {
        let number = |text: &str| text.parse::<f64>().unwrap_or(f64::INFINITY);
        let value = text.split_once('/').map_or_else(|| number(text), |(count, base)| number(count) / number(base));
        Figure { name, text: text.into(), value }
    };
    let of_group = |group: &str| {
        let words: Vec<_> = group.split(' ').collect();
        match words[..] {
            ["cells", ref cells @ ..] => {
                (0..).zip(cells).map(|(column, cell)| figure(format!("cell {column}"), cell)).collect()
            }
            [name, value] => vec![figure(name.into(), value)],
            [name, ref parts @ ..] => {
                parts.as_chunks().0.iter().map(|[part, value]| figure(format!("{name} {part}"), value)).collect()
            }
            [] => Vec::new(),
        }
    };
    figures.split(", ").flat_map(of_group).collect()
}

/// Whether a change is better or worse, or neither.
fn verdict(name: &str, old: f64, new: f64) -> &'static str {
    // The kernel does not decide how many tests there are. An equal share with another base is the same error rate.
    if name == "tests" || name == "measured" || old == new {
        return "changed";
    }
    // All figures count errors, except the boundary rays that hit exactly one primitive.
    if (new < old) == (name != "boundary one") { "better" } else { "worse" }
}

/// The figures that changed, each with its verdict.
fn compare(old: &str, new: &str) -> Vec<(&'static str, String)> {
    let (old, new) = (split(old), split(new));
    let mut changes = Vec::new();
    for figure in &old {
        match new.iter().find(|other| other.name == figure.name) {
            Some(other) if other == figure => {}
            Some(other) => {
                let verdict = verdict(&figure.name, figure.value, other.value);
                changes.push((verdict, format!("{} {} -> {}", figure.name, figure.text, other.text)));
            }
            None => changes.push(("changed", format!("{} {} -> nothing to count", figure.name, figure.text))),
        }
    }
    for figure in new.iter().filter(|figure| !old.iter().any(|other| other.name == figure.name)) {
        changes.push(("changed", format!("{} nothing to count -> {}", figure.name, figure.text)));
    }
    changes
}

/// The lines that differ, each with the figures that became better and worse, and the totals. Empty if no line differs.
fn differences(pinned: &Lines, got: &Lines) -> String {
    let (mut text, mut totals) = (String::new(), BTreeMap::<_, usize>::new());
    let places: BTreeSet<_> = pinned.keys().chain(got.keys()).collect();
    let mut lines = 0;
    for place in places {
        let (old, new) = (pinned.get(place), got.get(place));
        if old == new {
            continue;
        }
        lines += 1;
        let or_nothing = |line: Option<&String>| line.map_or("nothing".into(), String::clone);
        writeln!(text, "{place}\n  pinned  {}\n  got     {}", or_nothing(old), or_nothing(new)).unwrap();
        let changes = old.zip(new).map_or(Vec::new(), |(old, new)| compare(old, new));
        for verdict in ["worse", "better", "changed"] {
            let of_verdict: Vec<_> =
                changes.iter().filter(|(own, _)| *own == verdict).map(|(_, change)| change.as_str()).collect();
            if !of_verdict.is_empty() {
                writeln!(text, "  {verdict:7} {}", of_verdict.join(", ")).unwrap();
                *totals.entry(verdict).or_default() += of_verdict.len();
            }
        }
    }
    if lines > 0 {
        let of = |verdict| totals.get(verdict).copied().unwrap_or(0);
        let (worse, better, changed) = (of("worse"), of("better"), of("changed"));
        writeln!(text, "{lines} lines differ: {worse} figures worse, {better} better, {changed} otherwise changed")
            .unwrap();
    }
    text
}

/// Tests the comparison above.
fn differences_are_judged() -> Trial {
    harness::test("differences_say_what_became_better_and_worse", || {
        let pinned = parse(
            "# comment\n\
             a/b edge: tests 96, false_miss 3/10, boundary none 1 one 5 many 0, t_ulp p50 0 p99 2 max 3, uv max 1e-7\n\
             a/b map 1e-3: cells 0 3 - 7\n\
             a/b same: tests 16\n",
        );
        let got = parse(
            "a/b edge: tests 96, false_miss 2/10, boundary none 1 one 4 many 1, t_ulp p50 0 p99 4 max 3, uv max 9e-8\n\
             a/b map 1e-3: cells 0 2 9 -\n\
             a/b map 1e-2: cells 0\n\
             a/b same: tests 16\n",
        );
        let text = differences(&pinned, &got);
        for line in [
            "  worse   boundary one 5 -> 4, boundary many 0 -> 1, t_ulp p99 2 -> 4",
            "  better  false_miss 3/10 -> 2/10, uv max 1e-7 -> 9e-8",
            "  worse   cell 3 7 -> -",
            "  better  cell 1 3 -> 2, cell 2 - -> 9",
            "  pinned  nothing",
            "3 lines differ: 4 figures worse, 4 better, 0 otherwise changed",
        ] {
            assert!(text.lines().any(|other| other == line), "{line:?} is not in:\n{text}");
        }
        assert!(!text.contains("a/b same"), "{text}");
        assert_eq!(differences(&got, &got), "");
        let order: Vec<_> = got.keys().map(ToString::to_string).collect();
        assert_eq!(order, ["a/b edge", "a/b map 1e-3", "a/b map 0.01", "a/b same"]);
    })
}
