//! Runs the whole study: takes all measurements one after the other and collects them in one record.

use std::path::PathBuf;
use std::time::{Instant, SystemTime};

use super::figures::{claims, summary};
use super::measure::accuracy::Kernels;
use super::measure::built_scene::picture_size;
use super::measure::processes::Timed;
use super::measure::survey::Survey;
use super::measure::{
    coherence, machine, on_scenes, operation_rates, processes, rounds, scaling, scene_speed, speed, tracer,
};
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
    /// Scenes for the throughput of the tracer (and of the peers).
    pub scenes: Vec<SceneSource>,
    /// Fewer rays, samples and pixels: a check that everything works, with figures that are not to be trusted.
    pub quick: bool,
    /// Also measure the cost of a ray in a scene of ten million triangles. This takes several gigabytes of memory. With
    /// `quick`, the additional scene is smaller.
    pub large: bool,
    /// The seed of all random inputs.
    pub seed: u64,
    /// Whether to trace the scenes with the peers too. Needs the feature `peers`.
    pub peers: bool,
    /// The program `raylanes` of this build: kernels are timed in several of its processes. Without it, this process
    /// times them.
    pub program: Option<PathBuf>,
    /// Another build of the program, to be timed beside this one. Needs `program`.
    pub other: Option<OtherBuild>,
}

/// The program, built for other processors.
#[derive(Clone, Debug)]
pub struct OtherBuild {
    /// The processors, as the compiler names them: `x86-64-v3`.
    pub target: String,
    /// The program `raylanes` of that build.
    pub program: PathBuf,
}

impl Options {
    /// The scenes that are measured if none is named.
    pub fn default_scenes(quick: bool) -> Vec<SceneSource> {
        let names = if quick {
            ["room:small", "terrain:1e3", "sphere:small", "forest:1000", "gallery"]
        } else {
            ["room", "terrain:1e5", "sphere", "forest:10000", "gallery"]
        };
        names.map(|name| SceneSource::parse(name).expect("these are built-in scenes")).into()
    }
}

/// Runs the study, and shows in `progress` how far it has come.
///
/// # Errors
/// If a scene cannot be loaded, if hits differ that must be identical, or if `options.peers` is set and this build has
/// no peers.
pub fn run(options: &Options, progress: &Progress) -> Result<Record, Error> {
    let (started, clock) = (SystemTime::now(), Instant::now());
    let thread_counts = [1, 2];

    // The parts of the progress bar: about the seconds that each takes on a machine with two processors.
    let [speed_part, accuracy_part, judged_part, scenes_part, coherence_part, scaling_part] =
        if options.quick { [4.0, 4.0, 1.0, 2.0, 1.0, 0.1] } else { [45.0, 40.0, 20.0, 27.0, 19.0, 4.0] };
    let scaling_part = if options.large { 12.0 * scaling_part } else { scaling_part };
    let speed_part = if options.other.is_some() { 2.0 * speed_part } else { speed_part };
    let peers_part = if options.peers { 2.0 * scenes_part } else { 0.0 };
    let parts = progress.parts(&[
        speed_part,
        accuracy_part,
        judged_part,
        scenes_part,
        coherence_part,
        scaling_part,
        peers_part,
    ]);
    let [speed_part, accuracy_part, judged_part, scenes_part, coherence_part, scaling_part, peers_part] = &parts[..]
    else {
        unreachable!("seven lengths give seven parts")
    };

    progress.note("kernels: preparing");
    let speed = speed::Speed::new(options.seed);
    progress.note("kernels: speed");
    // Many short samples: other work on the machine disturbs some of them, and the median ignores those.
    let (processes, rounds, picture, scene_rounds) = if options.quick { (2, 2, 32, 1) } else { (5, 6, 192, 3) };
    let timed = Timed { seed: options.seed, rounds, scenes: options.scenes.clone(), picture, scene_rounds };
    let mut reach = |share| speed_part.reach(share);
    let of_builds = match &options.program {
        Some(program) => {
            let other = options.other.iter().map(|other| other.program.as_path());
            let programs: Vec<_> = [program.as_path()].into_iter().chain(other).collect();
            processes::time_in_processes(&programs, processes, &timed, &mut reach)?
        }
        None => {
            let all = Timed { rounds: processes * rounds, scene_rounds: processes * scene_rounds, ..timed };
            vec![vec![processes::time_here(&all, &mut |share| {
                reach(share);
                Ok(())
            })?]]
        }
    };
    let mut of_builds = of_builds.iter().map(|groups| rounds::merge(groups));
    let times = of_builds.next().expect("this build is timed")?;
    let other_times = of_builds.next().transpose()?.unwrap_or_default();
    let other_build = options.other.as_ref().map(|other| other.target.clone());
    if let Some(target) = &other_build {
        rounds::same_in_both(&times, &other_times, target)?;
    }

    let mut errors = Errors { survey: Survey::new(options.quick, options.seed), claims: Vec::new() };
    let shapes = accuracy_part.parts(&[32.0, 3.5, 6.0, 6.0, 3.0, 4.5]);
    errors.measure::<Triangle>(&shapes[0]);
    errors.measure::<Aabb>(&shapes[1]);
    errors.measure::<Quadric>(&shapes[2]);
    errors.measure::<Placed<Triangle>>(&shapes[3]);
    errors.measure::<Placed<Aabb>>(&shapes[4]);
    errors.measure::<Placed<Quadric>>(&shapes[5]);
    let Errors { survey, claims } = errors;

    let mut on_scenes = Vec::new();
    let judged_size = if options.quick { 64 } else { 512 };
    for (scene, progress) in judged_part.each(&options.scenes) {
        on_scenes.extend(on_scenes::judge(scene, (judged_size, options.seed), &progress)?);
    }
    let scene_speed = scene_speed::rows(&on_scenes, &times)?;
    let mut tracer_rows = Vec::new();
    let (size, samples) = (picture_size(options.quick), 3);
    for (scene, progress) in scenes_part.each(&options.scenes) {
        tracer_rows.extend(tracer::measure(scene, (size, options.seed), samples, &thread_counts, &progress)?);
    }
    let coherence = coherence::measure(options.quick, options.seed, coherence_part)?;
    let scaling_options = scaling::ScalingOptions { quick: options.quick, large: options.large };
    let scaling = scaling::measure(scaling_options, options.seed, scaling_part)?;
    let mut peer_rows = Vec::new();
    for (scene, progress) in peers_part.each(&options.scenes).filter(|_| options.peers) {
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
        methods: speed.methods.clone(),
        absent: registry::absent()
            .iter()
            .map(|absent| AbsentRow { id: absent.id.into(), reason: absent.reason.into() })
            .collect(),
        speed: speed.rows(&times)?,
        loops: speed.loop_rows(&times)?,
        rates: operation_rates::rows(&times)?,
        regimes: survey.regimes,
        accuracy: survey.rows,
        claims,
        maps: survey.maps,
        map_cells: survey.map_cells,
        other_build,
        other_speed: speed.rows_of_other_build(&other_times)?,
        other_scene_speed: scene_speed::rows_of_other_build(&on_scenes, &other_times)?,
        on_scenes,
        scene_speed,
        tracer: tracer_rows,
        coherence,
        scaling,
        peers: peer_rows,
    };
    record.kernels = summary::kernels(&record);
    Ok(record)
}

/// The errors of all kernels, and the claims that they are checked for.
struct Errors {
    survey: Survey,
    claims: Vec<ClaimRow>,
}

impl Errors {
    /// Measures the kernels of one shape, and checks their claims.
    fn measure<S: Subject>(&mut self, progress: &Progress) {
        let kernels = Kernels::<S>::registered();
        self.survey.measure(&kernels, progress);
        self.claims.extend(claims::judged(&kernels, &self.survey.rows));
    }
}
