//! The study: how fast and how right each kernel is, measured, charted and written down.

pub mod accuracy;
mod chart;
mod failures;
mod figures;
#[cfg(test)]
mod fixture;
mod frames;
mod json;
mod machine;
pub mod record;
mod report;
pub mod speed;
mod stats;
mod table;
pub mod workload;

use std::path::Path;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use indicatif::{ProgressBar, ProgressStyle};

use crate::kernels::Kernel;
use crate::registry::{self, Visitor};
use crate::tracer::{Error, SceneSource, write_atomically};
use record::{AccuracyRow, Record, SCHEMA};
use workload::{Subject, Workload};

pub use machine::build_warning;
pub use stats::median;
pub use table::terminal_table;

/// What to measure, and how much of it.
#[derive(Clone, Debug)]
pub struct Options {
    /// Scenes for the tracer's table.
    pub scenes: Vec<SceneSource>,
    /// Fewer rays, samples and pixels: to see that everything works, not to trust the figures.
    pub quick: bool,
    /// What all random inputs derive from.
    pub seed: u64,
}

impl Options {
    /// The scenes that are measured when none is named.
    pub fn default_scenes(quick: bool) -> Vec<SceneSource> {
        let names =
            if quick { ["room:small", "terrain:1e3", "sphere:small"] } else { ["room", "terrain:1e5", "sphere"] };
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
const ACCURACY_DONE: f64 = 0.7;

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
    let (samples, sample_seconds) = if options.quick { (3, 0.0005) } else { (15, 0.01) };
    let speed_rows =
        speed.measure(samples, sample_seconds, &thread_counts, &|share| progress.reach(share * SPEED_DONE))?;

    let mut accuracy = Accuracy {
        rays: if options.quick { 2_000 } else { 200_000 },
        seed: options.seed,
        kernels: speed.kernels.len(),
        rows: Vec::new(),
        progress: &progress,
    };
    registry::all(&mut accuracy);
    let accuracy_rows = accuracy.rows;

    let mut tracer = Vec::new();
    let (size, samples) = if options.quick { (128, 3) } else { (512, 9) };
    for (index, scene) in options.scenes.iter().enumerate() {
        let share = index as f64 / options.scenes.len() as f64;
        progress.reach(ACCURACY_DONE + (1.0 - ACCURACY_DONE) * share);
        tracer.extend(frames::measure(scene, size, samples, &thread_counts, &progress)?);
    }
    progress.bar.finish_and_clear();
    Ok(Record {
        schema: SCHEMA,
        started_unix: started.duration_since(UNIX_EPOCH).map_or(0, |elapsed| elapsed.as_secs()),
        seconds: clock.elapsed().as_secs_f64(),
        quick: options.quick,
        seed: options.seed,
        machine: machine::describe(),
        kernels: speed.kernels,
        absent: Vec::new(),
        speed: speed_rows,
        regimes: Vec::new(),
        accuracy: accuracy_rows,
        claims: Vec::new(),
        maps: Vec::new(),
        map_cells: Vec::new(),
        tracer,
    })
}

struct Accuracy<'a> {
    rays: u64,
    seed: u64,
    kernels: usize,
    rows: Vec<AccuracyRow>,
    progress: &'a Progress,
}

impl<S: Subject> Visitor<S> for Accuracy<'_> {
    fn visit<K: Kernel<Shape = S>>(&mut self) {
        for workload in Workload::ALL {
            self.progress.note(&format!("{}: accuracy, {} rays", K::INFO.id, workload.name()));
            self.rows.push(accuracy::measure::<K>(workload, self.rays, self.seed));
            let share = self.rows.len() as f64 / (self.kernels * Workload::ALL.len()) as f64;
            self.progress.reach(SPEED_DONE + (ACCURACY_DONE - SPEED_DONE) * share);
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

/// Writes `results.json`, `report.md` and the charts that it shows into a folder, which is made if it is not there.
/// Nothing is removed.
///
/// # Errors
/// If something cannot be written.
pub fn write(record: &Record, folder: &Path) -> Result<(), Error> {
    make_folder(folder)?;
    let mut files = vec![("results.json".to_owned(), json::one_row_per_line(record).expect("a record is plain data"))];
    files.extend(chart::charts(record).into_iter().map(|chart| (chart.file, chart.svg.into_bytes())));
    // Last, so that what it shows is there.
    files.push(("report.md".to_owned(), report::report_markdown(record).into_bytes()));
    for (name, content) in files {
        write_atomically(&folder.join(name), |file| file.write_all(&content))?;
    }
    Ok(())
}
