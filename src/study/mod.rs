//! The study: how fast and how right each kernel is, measured, charted and written down.

pub mod accuracy;
mod chart;
pub mod claims;
pub mod coherence;
mod failures;
mod figures;
#[cfg(test)]
mod fixture;
mod frames;
mod json;
mod machine;
pub mod peers;
mod rates;
pub mod ray_sets;
pub mod record;
mod report;
mod scaling;
pub mod speed;
mod stats;
mod summary;
mod table;
mod timing;
mod tracing;
pub mod workload;

use std::ops::Range;
use std::path::Path;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use indicatif::{ProgressBar, ProgressStyle};

use crate::geom::{Aabb, Placed, Quadric, Triangle};
use crate::kernels::triangle::Woop;
use crate::registry;
use crate::tracer::{Error, SceneSource, write_atomically};
use accuracy::Kernels;
use rates::Rates;
use record::{AbsentRow, AccuracyRow, ClaimRow, MapCells, MapRow, Record, RegimeRow, SCHEMA};
use workload::{Subject, Workload};

pub use machine::build_warning;
pub use stats::median;
pub use table::terminal_table;

/// What the tracer is measured with, and traces with where nothing else is asked for: a kernel that leaks is no base for
/// comparing tracers.
pub type TracerKernel = Woop<f32>;

/// What to measure, and how much of it.
#[derive(Clone, Debug)]
pub struct Options {
    /// Scenes for the tracer's table.
    pub scenes: Vec<SceneSource>,
    /// Fewer rays, samples and pixels: to see that everything works, not to trust the figures.
    pub quick: bool,
    /// One size more where cost is measured against size, of ten million triangles: takes several gigabytes.
    pub large: bool,
    /// What all random inputs derive from.
    pub seed: u64,
    /// Whether to trace the scenes with the peers too; needs the feature of that name.
    pub peers: bool,
}

impl Options {
    /// The scenes that are measured when none is named.
    pub fn default_scenes(quick: bool) -> Vec<SceneSource> {
        let names = if quick {
            ["room:small", "terrain:1e3", "sphere:small", "forest:1000", "gallery"]
        } else {
            ["room", "terrain:1e5", "sphere", "forest:10000", "gallery"]
        };
        names.map(|name| SceneSource::parse(name).expect("built-in scenes exist in these sizes")).into()
    }
}

/// Where a long study stands: a bar on a terminal, nothing in a pipe.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// Steps of the whole bar.
    const STEPS: u64 = 1000;

    fn new() -> Self {
        let style = ProgressStyle::with_template("{elapsed_precise} [{bar:32}] {percent:>3} % {msg}")
            .expect("the template is well formed")
            .progress_chars("=> ");
        Self { bar: ProgressBar::new(Self::STEPS).with_style(style) }
    }

    /// Says what is being done.
    fn note(&self, message: &str) {
        self.bar.set_message(message.to_owned());
        self.bar.tick();
    }

    /// Sets the share of the whole study that is done.
    fn reach(&self, share: f64) {
        self.bar.set_position((share * Self::STEPS as f64) as u64);
    }
}

/// Shares of the whole that are done when each part ends.
const SPEED_DONE: f64 = 0.35;
const ACCURACY_DONE: f64 = 0.65;
const SCENES_DONE: f64 = 0.88;
const COHERENCE_DONE: f64 = 0.95;

/// Runs the study.
///
/// # Errors
/// If a scene cannot be loaded, or if hits that must be identical are not.
pub fn run(options: &Options) -> Result<Record, Error> {
    let (started, clock) = (SystemTime::now(), Instant::now());
    let progress = Progress::new();
    let thread_counts = [1, 2];

    progress.note("kernels: preparing");
    let speed = speed::Speed::new(options.seed);
    progress.note("kernels: speed");
    // Many short samples: whatever else the machine does then falls on some of them, and the median is of the others.
    let (samples, sample_seconds) = if options.quick { (3, 0.0005) } else { (61, 0.0025) };
    let mut rates = Rates::new();
    let speed_rows = speed.measure(samples, sample_seconds, &thread_counts, &mut |share| {
        rates.sample();
        progress.reach(share * SPEED_DONE);
    })?;

    let mut accuracy = Accuracy {
        quick: options.quick,
        seed: options.seed,
        progress: &progress,
        rows: Vec::new(),
        regimes: Vec::new(),
        claims: Vec::new(),
        maps: Vec::new(),
        map_cells: Vec::new(),
    };
    accuracy.of::<Triangle>(0.0..0.35);
    accuracy.of::<Aabb>(0.35..0.5);
    accuracy.of::<Quadric>(0.5..0.7);
    accuracy.of::<Placed<Triangle>>(0.7..0.85);
    accuracy.of::<Placed<Aabb>>(0.85..0.92);
    accuracy.of::<Placed<Quadric>>(0.92..1.0);

    let mut tracer = Vec::new();
    let (size, samples) = if options.quick { (128, 3) } else { (384, 5) };
    for (index, scene) in options.scenes.iter().enumerate() {
        let share = index as f64 / options.scenes.len() as f64;
        progress.reach(ACCURACY_DONE + (SCENES_DONE - ACCURACY_DONE) * share);
        tracer.extend(frames::measure(scene, (size, options.seed), samples, &thread_counts, &progress)?);
    }
    progress.reach(SCENES_DONE);
    let coherence = coherence::measure(options.quick, options.seed, &progress)?;
    progress.reach(COHERENCE_DONE);
    let extent = scaling::Extent { quick: options.quick, large: options.large };
    let scaling = scaling::measure(extent, options.seed, &progress)?;
    let mut peer_rows = Vec::new();
    for scene in options.scenes.iter().filter(|_| options.peers) {
        progress.note(&format!("{}: peers", scene.name()));
        peer_rows.extend(peers::compare(scene, size, options.seed, samples)?);
    }
    progress.bar.finish_and_clear();
    let mut record = Record {
        schema: SCHEMA,
        started_unix: started.duration_since(UNIX_EPOCH).map_or(0, |elapsed| elapsed.as_secs()),
        seconds: clock.elapsed().as_secs_f64(),
        quick: options.quick,
        seed: options.seed,
        machine: if options.peers { peers::machine() } else { machine::describe() },
        kernels: Vec::new(),
        methods: speed.methods,
        absent: registry::absent()
            .iter()
            .map(|absent| AbsentRow { id: absent.id.into(), reason: absent.reason.into() })
            .collect(),
        speed: speed_rows,
        rates: rates.rows(),
        regimes: accuracy.regimes,
        accuracy: accuracy.rows,
        claims: accuracy.claims,
        maps: accuracy.maps,
        map_cells: accuracy.map_cells,
        tracer,
        coherence,
        scaling,
        peers: peer_rows,
    };
    record.kernels = summary::kernels(&record);
    Ok(record)
}

/// What there is to be measured of the accuracy of all kernels of all shapes.
struct Accuracy<'a> {
    quick: bool,
    seed: u64,
    progress: &'a Progress,
    rows: Vec<AccuracyRow>,
    regimes: Vec<RegimeRow>,
    claims: Vec<ClaimRow>,
    maps: Vec<MapRow>,
    map_cells: Vec<MapCells>,
}

impl Accuracy<'_> {
    /// Measures the kernels of a shape; `share` is this part's place in the whole.
    fn of<S: Subject>(&mut self, share: Range<f64>) {
        let kernels = Kernels::<S>::registered();
        let steps: usize = S::REGIMES.iter().map(|regime| regime.steps.len()).sum();
        let parts = (Workload::ALL.len() + steps + S::MAPS.len()) as f64;
        let mut done = 0.0;
        let mut begin = |name: &str| {
            self.progress.note(&format!("{}: accuracy, {name}", S::FAMILY));
            self.progress.reach(
                SPEED_DONE + (ACCURACY_DONE - SPEED_DONE) * (share.start + (share.end - share.start) * done / parts),
            );
            done += 1.0;
        };
        for workload in Workload::ALL {
            begin(workload.name());
            let rays = if self.quick { 2_000 } else { 200_000 };
            self.rows.extend(kernels.on_workload(workload, rays, self.seed));
        }
        for regime in S::REGIMES {
            for &severity in regime.steps {
                begin(regime.name);
                let rays = if self.quick { 1_024 } else { 100_000 };
                self.rows.extend(kernels.on_regime(regime, severity, rays, self.seed));
            }
            self.regimes.push(RegimeRow {
                family: S::title(),
                name: regime.name.into(),
                about: regime.about.into(),
                axis: regime.axis.into(),
                steps: regime.steps.to_vec(),
                mesh: regime.mesh,
            });
        }
        self.claims.extend(claims::judged(&kernels, &self.rows));
        for map in S::MAPS {
            begin(map.name);
            let rays = if self.quick { 64 } else { 512 };
            let (hits, cells) = kernels.on_map(map, rays, self.seed);
            self.map_cells.extend(cells);
            self.maps.push(MapRow {
                family: S::title(),
                name: map.name.into(),
                x_axis: map.x.title.into(),
                x: map.x.steps(),
                y_axis: map.y.title.into(),
                y: map.y.steps(),
                hits,
            });
        }
    }
}

/// Makes the folder that [`write()`] writes into, if it is not there.
///
/// # Errors
/// If it cannot be made.
pub fn make_folder(folder: &Path) -> Result<(), Error> {
    std::fs::create_dir_all(folder).map_err(|source| Error::Io { action: "create", file: folder.into(), source })
}

/// Writes `results.json`, `report.md` and the charts that it shows, and the same as one page, `report.html`, into a folder,
/// which is made if it is not there. Nothing is removed.
///
/// # Errors
/// If something cannot be written.
pub fn write(record: &Record, folder: &Path) -> Result<(), Error> {
    make_folder(folder)?;
    let mut files = vec![("results.json".to_owned(), json::one_row_per_line(record).expect("a record is plain data"))];
    let (report, charts) = (report::report_markdown(record), chart::charts(record));
    let page = report::report_html(&report, &charts);
    files.extend(charts.into_iter().map(|chart| (chart.file, chart.svg.into_bytes())));
    // Last, so that what they show is there.
    files.extend([("report.md".to_owned(), report.into_bytes()), ("report.html".to_owned(), page.into_bytes())]);
    for (name, content) in files {
        write_atomically(&folder.join(name), |file| file.write_all(&content))?;
    }
    Ok(())
}
