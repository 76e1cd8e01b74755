//! Runs the whole study: everything that is measured, one after the other, into one record.

use std::time::{Instant, SystemTime};

use super::figures::{claims, summary};
use super::measure::accuracy::Kernels;
use super::measure::operation_rates::Rates;
use super::measure::survey::Survey;
use super::measure::{coherence, machine, scaling, speed, tracer};
use super::peers;
use super::progress::Progress;
use super::record::{AbsentRow, ClaimRow, Record, SCHEMA, seconds_since_1970};
use super::workload::Subject;
use crate::geom::{Aabb, Placed, Quadric, Triangle};
use crate::registry;
use crate::tracer::{Error, SceneSource};

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

    // The parts of the progress bar: about the seconds that each takes on a machine with two processors.
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

    let mut errors = Errors { survey: Survey::new(options.quick, options.seed), claims: Vec::new() };
    let shapes = of_accuracy.parts(&[20.0, 3.0, 3.5, 2.5, 2.5, 2.5]);
    errors.measure::<Triangle>(&shapes[0]);
    errors.measure::<Aabb>(&shapes[1]);
    errors.measure::<Quadric>(&shapes[2]);
    errors.measure::<Placed<Triangle>>(&shapes[3]);
    errors.measure::<Placed<Aabb>>(&shapes[4]);
    errors.measure::<Placed<Quadric>>(&shapes[5]);
    let Errors { survey, claims } = errors;

    let mut tracer_rows = Vec::new();
    let (size, samples) = if options.quick { (128, 3) } else { (384, 5) };
    for (scene, progress) in of_scenes.each(&options.scenes) {
        tracer_rows.extend(tracer::measure(scene, (size, options.seed), samples, &thread_counts, &progress)?);
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
        regimes: survey.regimes,
        accuracy: survey.rows,
        claims,
        maps: survey.maps,
        map_cells: survey.map_cells,
        tracer: tracer_rows,
        coherence,
        scaling,
        peers: peer_rows,
    };
    record.kernels = summary::kernels(&record);
    Ok(record)
}

/// The errors of all kernels, and what they say about the kernels' claims.
struct Errors {
    survey: Survey,
    claims: Vec<ClaimRow>,
}

impl Errors {
    /// Measures the kernels of a shape.
    fn measure<S: Subject>(&mut self, progress: &Progress) {
        let kernels = Kernels::<S>::registered();
        self.survey.measure(&kernels, progress);
        self.claims.extend(claims::judged(&kernels, &self.survey.rows));
    }
}
