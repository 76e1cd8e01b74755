//! The study: how fast and how right each kernel is, measured, charted and written down.

pub mod accuracy;
mod chart;
pub mod claims;
pub mod coherence;
mod date;
mod failures;
#[cfg(test)]
mod fields;
mod figures;
#[cfg(test)]
mod fixture;
mod frames;
mod json;
mod machine;
pub mod peers;
mod progress;
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

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use rand_pcg::Pcg64;

use crate::files::{try_folder, write_new_folder, write_together};
use crate::geom::{Aabb, Placed, Quadric, Triangle};
use crate::kernels::triangle::Woop;
use crate::registry;
use crate::tracer::{Error, SceneSource};
use accuracy::Kernels;
use date::date;
use rates::Rates;
use record::{AbsentRow, AccuracyRow, ClaimRow, MapCells, MapRow, Record, RegimeRow, SCHEMA};
use workload::{Sample, Subject, Workload};

pub use machine::build_warning;
pub use progress::Progress;
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

/// Runs the study, and tells `progress` how far it is.
///
/// # Errors
/// If a scene cannot be loaded, or if hits that must be identical are not.
pub fn run(options: &Options, progress: &Progress) -> Result<Record, Error> {
    let (started, clock) = (SystemTime::now(), Instant::now());
    let thread_counts = [1, 2];

    // In about the seconds that they take on a machine with two processors.
    let [of_speed, of_accuracy, of_scenes, of_coherence, of_scaling] =
        if options.quick { [0.6, 4.0, 4.7, 1.0, 0.1] } else { [41.0, 34.0, 23.0, 8.0, 3.0] };
    let of_scaling = if options.large { 12.0 * of_scaling } else { of_scaling };
    let of_peers = if options.peers { 2.0 * of_scenes } else { 0.0 };
    let parts = progress.parts(&[of_speed, of_accuracy, of_scenes, of_coherence, of_scaling, of_peers]);
    let [of_speed, of_accuracy, of_scenes, of_coherence, of_scaling, of_peers] = &parts[..] else {
        unreachable!("there are six")
    };

    progress.note("kernels: preparing");
    let speed = speed::Speed::new(options.seed);
    progress.note("kernels: speed");
    // Many short samples: whatever else the machine does then falls on some of them, and the median is of the others.
    let samples = if options.quick { 3 } else { 61 };
    let mut rates = Rates::new();
    let speed_rows = speed.measure(samples, &thread_counts, &mut |share| {
        rates.sample();
        of_speed.reach(share);
    })?;

    let mut accuracy = Accuracy {
        quick: options.quick,
        seed: options.seed,
        rows: Vec::new(),
        regimes: Vec::new(),
        claims: Vec::new(),
        maps: Vec::new(),
        map_cells: Vec::new(),
    };
    let shapes = of_accuracy.parts(&[20.0, 3.0, 3.5, 2.5, 2.5, 2.5]);
    accuracy.of::<Triangle>(&shapes[0]);
    accuracy.of::<Aabb>(&shapes[1]);
    accuracy.of::<Quadric>(&shapes[2]);
    accuracy.of::<Placed<Triangle>>(&shapes[3]);
    accuracy.of::<Placed<Aabb>>(&shapes[4]);
    accuracy.of::<Placed<Quadric>>(&shapes[5]);

    let mut tracer = Vec::new();
    let (size, samples) = if options.quick { (128, 3) } else { (384, 5) };
    for (scene, progress) in of_scenes.each(&options.scenes) {
        tracer.extend(frames::measure(scene, (size, options.seed), samples, &thread_counts, &progress)?);
    }
    let coherence = coherence::measure(options.quick, options.seed, of_coherence)?;
    let extent = scaling::Extent { quick: options.quick, large: options.large };
    let scaling = scaling::measure(extent, options.seed, of_scaling)?;
    let mut peer_rows = Vec::new();
    for (scene, progress) in of_peers.each(&options.scenes).filter(|_| options.peers) {
        progress.note(&format!("{}: peers", scene.name()));
        progress.reach(0.0);
        peer_rows.extend(peers::compare(scene, size, options.seed, samples)?);
    }
    let mut record = Record {
        schema: SCHEMA,
        started_unix: seconds_since_1970(started),
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
struct Accuracy {
    quick: bool,
    seed: u64,
    rows: Vec<AccuracyRow>,
    regimes: Vec<RegimeRow>,
    claims: Vec<ClaimRow>,
    maps: Vec<MapRow>,
    map_cells: Vec<MapCells>,
}

impl Accuracy {
    /// Measures the kernels of a shape.
    fn of<S: Subject>(&mut self, progress: &Progress) {
        let kernels = Kernels::<S>::registered();
        let [workload_rays, step_rays, cell_rays] =
            if self.quick { [2_000, 1_024, 64] } else { [200_000, 100_000, 512] };
        // What takes time are tests, of all rays against all shapes of their sample: there are one, or hundreds.
        let tests = |rays: u64, sample: &dyn Fn(&mut Pcg64) -> Sample<S>| {
            rays as f64 * sample(&mut workload::rng(self.seed, S::FAMILY, "", &[], 0)).shapes.len() as f64
        };
        let of_workloads = Workload::ALL.iter().map(|&workload| tests(workload_rays, &|rng| S::sample(workload, rng)));
        let steps = S::REGIMES.iter().flat_map(|regime| regime.steps.iter().map(move |&severity| (regime, severity)));
        let of_steps = steps.map(|(regime, step)| tests(step_rays, &|rng| (regime.sample)(step as f32, rng)));
        let of_maps = S::MAPS.iter().map(|map| (map.x.steps().len() * map.y.steps().len()) as f64 * cell_rays as f64);
        let mut parts = progress.parts(&of_workloads.chain(of_steps).chain(of_maps).collect::<Vec<_>>()).into_iter();
        let mut begin = |name: &str| {
            let part = parts.next().expect("every workload, step and map has its part");
            part.note(&format!("{}: accuracy, {name}", S::FAMILY));
            part.reach(0.0);
        };
        for workload in Workload::ALL {
            begin(workload.name());
            self.rows.extend(kernels.on_workload(workload, workload_rays, self.seed));
        }
        for regime in S::REGIMES {
            for &severity in regime.steps {
                begin(regime.name);
                self.rows.extend(kernels.on_regime(regime, severity, step_rays, self.seed));
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
            let (hits, cells) = kernels.on_map(map, cell_rays, self.seed);
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

/// Makes a folder to write into, if it is not there.
///
/// # Errors
/// If it cannot be made.
pub fn make_folder(folder: &Path) -> Result<(), Error> {
    std::fs::create_dir_all(folder).map_err(Error::creating(folder))
}

/// Writes `results.json`, `report.md` and the charts that it shows, and the same as one page, `report.html`, into a folder,
/// which is made if it is not there. Nothing is removed, and nothing is replaced before all is written.
///
/// # Errors
/// If something cannot be written.
pub fn write(record: &Record, folder: &Path) -> Result<(), Error> {
    let files = files(record);
    make_folder(folder)?;
    write_together(folder, &files)
}

/// The same into a new folder, which is there with all files or not at all.
///
/// # Errors
/// If something of that name exists, or if something cannot be written.
pub fn write_new(record: &Record, folder: &Path) -> Result<(), Error> {
    write_new_folder(folder, &files(record))
}

/// Whether [`write()`] could write into a folder, as far as that can be told before. Nothing is left behind.
///
/// # Errors
/// If it cannot be made or written.
pub fn try_write(folder: &Path) -> Result<(), Error> {
    try_folder(folder)
}

/// The folder of a new record: `reports/<date>-<name>` below the current one, with today's date in UTC.
///
/// # Errors
/// If it exists, since records are never edited, or if it could not be written.
pub fn new_record(name: &str) -> Result<PathBuf, Error> {
    let folder = Path::new("reports").join(format!("{}-{name}", date(seconds_since_1970(SystemTime::now()))));
    match folder.symlink_metadata() {
        Err(error) if error.kind() == ErrorKind::NotFound => try_folder(&folder).map(|()| folder),
        Err(error) => Err(Error::writing(&folder)(error)),
        Ok(_) => Err(Error::Argument {
            argument: folder.display().to_string(),
            message: "it exists, and records are never edited: choose another name".into(),
        }),
    }
}

fn seconds_since_1970(time: SystemTime) -> u64 {
    time.duration_since(UNIX_EPOCH).map_or(0, |elapsed| elapsed.as_secs())
}

/// What a study is written as: names of files, and what they hold.
fn files(record: &Record) -> Vec<(String, Vec<u8>)> {
    let mut files = vec![("results.json".to_owned(), json::one_row_per_line(record).expect("a record is plain data"))];
    let (report, charts) = (report::report_markdown(record), chart::charts(record));
    let page = report::report_html(&report, &charts);
    files.extend(charts.into_iter().map(|chart| (chart.file, chart.svg.into_bytes())));
    // Last, so that what they show is there.
    files.extend([("report.md".to_owned(), report.into_bytes()), ("report.html".to_owned(), page.into_bytes())]);
    files
}
