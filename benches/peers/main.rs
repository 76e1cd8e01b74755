//! Compares this crate with its peers on the same rays: obvhs, bvh and parry3d, and Embree 4 if its library is found.
//!
//! `cargo bench --bench peers --features peers -- SCENE… --record reports/peers` writes `peers.json` and `peers.md`.
//! Without a scene, the built-in terrain of a million triangles is traced. `--test` checks that everything works.

mod embree;

use std::io::{self, IsTerminal};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use clap::Parser;
use glam::Vec3;
use raylanes::geom::Triangle;
use raylanes::kernels::Kernel;
use raylanes::registry::{self, Task};
use raylanes::study::peers::{self, Contender, EMBREE, OURS};
use raylanes::study::ray_sets::ray_sets;
use raylanes::study::record::{PeerRow, PeersRecord, SCHEMA};
use raylanes::study::{TracerKernel, build_warning, make_folder};
use raylanes::tracer::{Error, LoadedScene, Mesh, Scene, SceneSource, View, parse_point};
use rayon::{ThreadPool, ThreadPoolBuilder};

use embree::{Caller, Calls, Embree, Quality};

/// Traces the same rays with raylanes and its peers.
#[derive(Parser)]
struct Arguments {
    /// Built-in scenes, mesh files or scene files of one mesh each; a camera may follow as points X,Y,Z.
    #[arg(value_name = "SCENE[@EYE:LOOK_AT]", default_value = "terrain:1e6")]
    scenes: Vec<String>,
    /// Width and height of the picture whose rays are traced.
    #[arg(long, value_name = "PIXELS", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(1..=8192))]
    size: u32,
    /// Number of rounds after a warm-up; every configuration has one turn in each.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..))]
    rounds: u16,
    /// Triangle kernel of raylanes, by ID or name.
    #[arg(long, value_name = "ID", default_value = <TracerKernel as Kernel>::INFO.id.method)]
    kernel: String,
    /// Run only configurations whose name contains one of these, and raylanes in mode scalar.
    #[arg(long, value_name = "TEXT")]
    only: Vec<String>,
    /// Seed of bounce and occlusion rays.
    #[arg(long, default_value_t = 2026)]
    seed: u64,
    /// Write peers.json and peers.md into this folder, relative to the project's root.
    #[arg(long, value_name = "DIR")]
    record: Option<PathBuf>,
    /// Check that everything works: a small scene and picture, one round.
    #[arg(long)]
    test: bool,
    /// Accepted because cargo passes it.
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() -> ExitCode {
    let mut arguments = Arguments::parse();
    if arguments.test {
        (arguments.scenes, arguments.size, arguments.rounds) = (vec!["terrain:small".into()], 64, 1);
    }
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("peers: {error}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), Error> {
    let (started, clock) = (SystemTime::now(), Instant::now());
    let scenes = arguments.scenes.iter().map(|text| SceneArgument::parse(text)).collect::<Result<Vec<_>, _>>()?;
    let no_kernel = || Error::Argument {
        argument: arguments.kernel.clone(),
        message: "no such triangle kernel; `raylanes list` shows all".into(),
    };
    let kernel = registry::with_kernel::<Triangle, _>(&arguments.kernel, IdOf).ok_or_else(no_kernel)?;
    let embree = Embree::load()?;
    if embree.is_none() {
        eprintln!("note: Embree 4 was not found; set EMBREE_LIB to the path of its library");
    }
    if let Some(warning) = build_warning() {
        eprintln!("note: {warning}");
    }
    // Find errors of the file system first: the measurement takes a while.
    if let Some(folder) = &arguments.record {
        make_folder(folder)?;
    }
    let pools = [1, 2].map(pinned_pool);
    let mut rows = Vec::new();
    for scene in &scenes {
        let loaded = scene.load()?;
        let task = Compare { arguments, name: scene.source.name(), loaded, embree: embree.as_ref(), pools: &pools };
        rows.extend(registry::with_kernel::<Triangle, _>(&arguments.kernel, task).ok_or_else(no_kernel)??);
    }
    let mut machine = peers::machine();
    machine.versions.extend(embree.map(|embree| format!("Embree {}", embree.version)));
    let record = PeersRecord {
        schema: SCHEMA,
        started_unix: started.duration_since(UNIX_EPOCH).map_or(0, |elapsed| elapsed.as_secs()),
        seconds: clock.elapsed().as_secs_f64(),
        machine,
        size: arguments.size,
        rounds: arguments.rounds.into(),
        seed: arguments.seed,
        kernel,
        targets: peers::judge(&rows, peers::cache_bytes()),
        peers: rows,
    };
    let table = peers::terminal(&record, io::stdout().is_terminal());
    if arguments.test {
        println!("Success: {} configurations and sets of rays in {} lines", record.peers.len(), table.lines().count());
    } else {
        println!("{table}");
    }
    if let Some(folder) = &arguments.record {
        peers::write(&record, folder)?;
        println!("Written to {}: peers.md, peers.json", folder.display());
    }
    Ok(())
}

struct IdOf;

impl Task<Triangle> for IdOf {
    type Output = String;
    fn run<K: Kernel<Shape = Triangle>>(self) -> String {
        K::INFO.id.to_string()
    }
}

/// A scene, and a camera that replaces the scene's own.
struct SceneArgument {
    source: SceneSource,
    camera: Option<(Vec3, Vec3)>,
}

impl SceneArgument {
    fn parse(text: &str) -> Result<Self, Error> {
        let Some((scene, camera)) = text.rsplit_once('@') else {
            return Ok(Self { source: SceneSource::parse(text)?, camera: None });
        };
        let bad = |message: String| Error::Argument { argument: text.into(), message };
        let (eye, look_at) = camera
            .split_once(':')
            .ok_or_else(|| bad("expected EYE:LOOK_AT after the @, such as 1,2,3:0,0,0".into()))?;
        let camera = (parse_point(eye).map_err(bad)?, parse_point(look_at).map_err(bad)?);
        Ok(Self { source: SceneSource::parse(scene)?, camera: Some(camera) })
    }

    fn load(&self) -> Result<LoadedScene, Error> {
        let mut loaded = self.source.load()?;
        if peers::plain_mesh(&loaded.world).is_none() {
            return Err(Error::Argument {
                argument: self.source.name(),
                message:
                    "expected a scene of one mesh without a transform: not every peer knows quadrics and instances"
                        .into(),
            });
        }
        if let Some((eye, look_at)) = self.camera {
            loaded.view = View { eye, look_at, vertical_fov: 60.0, transform: None, ..loaded.view };
        }
        Ok(loaded)
    }
}

/// A pool whose threads are pinned to one processor each, if the system allows it.
fn pinned_pool(threads: usize) -> ThreadPool {
    let processors = core_affinity::get_core_ids().unwrap_or_default();
    let pin = move |thread: usize| {
        if let Some(&processor) = processors.get(thread) {
            core_affinity::set_for_current(processor);
        }
    };
    ThreadPoolBuilder::new().num_threads(threads).start_handler(pin).build().expect("a pool of two threads can be made")
}

/// The comparison of all tracers on one scene.
struct Compare<'a> {
    arguments: &'a Arguments,
    name: String,
    loaded: LoadedScene,
    embree: Option<&'a Embree>,
    pools: &'a [ThreadPool; 2],
}

impl Task<Triangle> for Compare<'_> {
    type Output = Result<Vec<PeerRow>, Error>;

    fn run<K: Kernel<Shape = Triangle>>(self) -> Self::Output {
        let Self { arguments, name, loaded: LoadedScene { world, view, .. }, embree, pools } = self;
        eprintln!("{name}: building");
        let start = Instant::now();
        let scene = Scene::<K>::new(world);
        let build_seconds = start.elapsed().as_secs_f64();
        let mesh = peers::plain_mesh(scene.world()).expect("loading checked that the scene is one mesh");

        let [scalar, others @ ..] = peers::ours(&scene, build_seconds);
        let mut rivals: Vec<_> = others.into_iter().collect();
        // Embree comes before the crates, which take long to build, so that an error of the library shows early.
        if let Some(embree) = embree {
            rivals.extend(embree_contenders(embree, mesh)?);
        }
        let chosen = |contender: &Contender| {
            let name = format!("{contender:?}");
            arguments.only.is_empty() || arguments.only.iter().any(|text| name.contains(text))
        };
        if arguments.only.is_empty() || arguments.only.iter().any(|text| !text.contains(OURS) && !text.contains(EMBREE))
        {
            rivals.extend(peers::rust_peers(mesh));
        }
        rivals.retain(chosen);

        let [one, two] = pools;
        let mut contenders = vec![(&scalar, one)];
        for rival in &rivals {
            contenders.push((rival, one));
            // Only raylanes and Embree are also run with two threads.
            if [OURS, EMBREE].contains(&rival.tracer) {
                contenders.push((rival, two));
            }
        }
        let mut rows = Vec::new();
        for set in ray_sets(&scene, &view, arguments.size, arguments.seed) {
            eprintln!("{name}: {} rays, {} configurations", set.name, contenders.len());
            rows.extend(peers::measure((&name, mesh.len()), &set, &contenders, arguments.rounds.into())?);
        }
        Ok(rows)
    }
}

/// Embree in every configuration of flag, build and call that could be its fastest.
fn embree_contenders(embree: &Embree, mesh: &Mesh) -> Result<Vec<Contender<'static>>, Error> {
    let mut calls = vec![Calls::One, Calls::Eight { coherent: false }, Calls::Eight { coherent: true }];
    if embree.native16 {
        calls.extend([Calls::Sixteen { coherent: false }, Calls::Sixteen { coherent: true }]);
    }
    // With the robust flag, Embree builds the same tree for both qualities (`Scene::createTriangleAccel`).
    let builds = [
        (false, Quality::Medium, "fast, medium"),
        (false, Quality::High, "fast, high"),
        (true, Quality::Medium, "robust"),
    ];
    let mut contenders = Vec::new();
    for (robust, quality, name) in builds {
        let scene = Arc::new(embree::Scene::new(embree, mesh, robust, quality)?);
        contenders.extend(calls.iter().map(|&calls| Contender {
            tracer: EMBREE,
            configuration: format!("{name}, {calls}"),
            watertight: robust,
            build_seconds: scene.build_seconds,
            bytes: Some(scene.bytes()),
            scene: Box::new(Caller { scene: scene.clone(), calls }),
        }));
    }
    Ok(contenders)
}
