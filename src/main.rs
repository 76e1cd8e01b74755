//! The program: arguments in, one call into the library, text out. Errors are one line and exit code 2.

#![forbid(unsafe_code)]

use std::fmt::Write as _;
use std::io::{self, Write as _};
use std::marker::PhantomData;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use anstream::{AutoStream, ColorChoice};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand, ValueEnum};
use glam::Vec3;
use raylanes::geom::{Hit, Quadric, Ray, Triangle};
use raylanes::kernels::{Intersect, Kernel, Shape};
use raylanes::registry::{self, Task, Visitor};
use raylanes::study::{self, Progress};
use raylanes::tracer::{
    self, BuiltIn, Camera, Differences, Error, Light, LoadedScene, Mode, Picture, Scene, SceneSource, Shade, Shot,
    View, World,
};
use serde::Serialize;

/// Ray-intersection kernels, measured for speed and for accuracy.
#[derive(Parser)]
#[command(version, after_help = scene_help())]
struct Arguments {
    /// Without a command: the study of the built-in scenes.
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    /// Measure every kernel and the tracer; write results.json, the report (report.html, report.md) and its charts.
    Study(StudyArguments),
    /// Trace the rays of a picture or of a file and tell how fast that was.
    Trace(TraceArguments),
    /// Trace and shade a picture, as PNG.
    Render(RenderArguments),
    /// List the kernels: ID, operations, prepared and per-ray bytes, claims, idea.
    List,
}

const DEFAULT_OUT: &str = "reports/latest";
const DEFAULT_SEED: u64 = 2026;

#[derive(Args)]
struct StudyArguments {
    /// Scenes for the tracer's table [default: room, terrain:1e5, sphere, forest:10000 and gallery].
    #[arg(value_name = "SCENE")]
    scenes: Vec<String>,
    /// Fewer rays, samples and pixels: to see that everything works, not to trust the figures.
    #[arg(long)]
    quick: bool,
    /// Measure the cost of a ray up to ten million triangles, instead of one: takes minutes and gigabytes more.
    #[arg(long)]
    large: bool,
    /// Where results go, in place of older ones.
    #[arg(long, value_name = "DIR", default_value = DEFAULT_OUT)]
    out: PathBuf,
    /// Write to reports/<date>-NAME instead, with today's date in UTC: a record to keep, which is not there yet.
    #[arg(long, value_name = "NAME", conflicts_with = "out", value_parser = parse_record_name)]
    record: Option<String>,
    /// What all random inputs derive from.
    #[arg(long, default_value_t = DEFAULT_SEED)]
    seed: u64,
    /// Trace the scenes of one mesh with obvhs, bvh and parry3d too; needs a build with the feature "peers".
    #[arg(long)]
    peers: bool,
}

impl Default for StudyArguments {
    fn default() -> Self {
        Self {
            scenes: Vec::new(),
            quick: false,
            large: false,
            out: DEFAULT_OUT.into(),
            record: None,
            seed: DEFAULT_SEED,
            peers: false,
        }
    }
}

/// What `trace` and `render` have in common.
#[derive(Args)]
struct SceneArguments {
    /// A scene file (TOML), an OBJ file or a built-in scene.
    scene: String,
    /// Triangle kernel, by ID or name; see `raylanes list`.
    #[arg(long, value_name = "ID", default_value = <study::TracerKernel as Kernel>::INFO.id.method)]
    kernel: String,
    /// Quadric kernel, by ID or name.
    #[arg(long, value_name = "ID", default_value = "mixed")]
    quadric_kernel: String,
    /// How rays are taken: one by one with scalar code (the reference), one by one against eight boxes at a time, in
    /// blocks and packets of eight, or as suits the scene and the rays. The hits are the same.
    #[arg(long, default_value = Mode::Auto.name(), value_parser = mode_parser())]
    mode: Mode,
    /// Threads; 0 for as many as there are processors.
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u16).range(..=1024))]
    threads: u16,
    /// Picture size.
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "1024x1024", value_parser = parse_size)]
    size: (u32, u32),
    /// Camera position [default: the scene's own, or outside with all of it in view].
    #[arg(long, value_name = "X,Y,Z", value_parser = tracer::parse_point, requires = "look_at", allow_hyphen_values = true)]
    eye: Option<Vec3>,
    /// Point in the middle of the picture.
    #[arg(long, value_name = "X,Y,Z", value_parser = tracer::parse_point, requires = "eye", allow_hyphen_values = true)]
    look_at: Option<Vec3>,
    /// Vertical field of view in degrees, for a camera given by --eye.
    #[arg(long, value_name = "DEGREES", default_value_t = 60.0, value_parser = parse_field_of_view)]
    fov: f32,
}

#[derive(Args)]
struct TraceArguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Rays to trace instead of a picture's: raw little-endian f32, `ox oy oz t_min dx dy dz t_max` per ray.
    #[arg(long, value_name = "FILE")]
    rays: Option<PathBuf>,
    /// Only ask whether anything is hit; hits then have t = u = v = 0 and primitive 0.
    #[arg(long)]
    any_hit: bool,
    /// Trace so many times and report the median.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    repeat: u32,
    /// Write the hits: little-endian `t u v` as f32 and the primitive number as u32 per ray, in ray order (of a picture: row
    /// by row from the upper left).
    #[arg(long, value_name = "FILE")]
    hits: Option<PathBuf>,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

#[derive(Args)]
struct RenderArguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// The PNG to write.
    #[arg(short, long, value_name = "OUT.png")]
    out: PathBuf,
    /// What a pixel shows.
    #[arg(long, value_enum, default_value_t = ShadeArgument::Lambert)]
    shade: ShadeArgument,
    /// Trace with another triangle or quadric kernel too, write a second picture (OUT-compare.png) that marks every pixel where
    /// the two see something else, and print how many there are.
    #[arg(long, value_name = "ID")]
    compare: Option<String>,
}

#[derive(Clone, Copy, ValueEnum)]
enum ShadeArgument {
    /// Diffuse reflection with hard shadows.
    Lambert,
    /// Geometric normals as colours.
    Normals,
    /// Distance from the eye.
    Depth,
    /// A colour for each primitive.
    Primitives,
    /// A colour for each instance.
    Instances,
    /// How open the surroundings are.
    AmbientOcclusion,
}

impl From<ShadeArgument> for Shade {
    fn from(argument: ShadeArgument) -> Self {
        match argument {
            ShadeArgument::Lambert => Self::Lambert,
            ShadeArgument::Normals => Self::Normals,
            ShadeArgument::Depth => Self::Depth,
            ShadeArgument::Primitives => Self::Primitives,
            ShadeArgument::Instances => Self::Instances,
            ShadeArgument::AmbientOcclusion => Self::AmbientOcclusion,
        }
    }
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let command = arguments.command.unwrap_or(Command::Study(StudyArguments::default()));
    let progress = if matches!(command, Command::Study(_)) { Progress::bar() } else { Progress::spinner() };
    exit_when_interrupted(progress.clone());
    let outcome = match command {
        Command::Study(arguments) => run_study(&arguments, &progress),
        Command::Trace(arguments) => trace(&arguments, &progress),
        Command::Render(arguments) => render(&arguments, &progress),
        Command::List => list(),
    };
    progress.clear();
    match outcome.and_then(|text| print(&text)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            note(&format!("raylanes: {error}"));
            ExitCode::from(2)
        }
    }
}

/// What shells tell of a program that Ctrl-C has ended.
const INTERRUPTED: i32 = 130;

/// On Ctrl-C, and where the system asks the program to end, lets a file or a set of files be finished that is being written,
/// tidies the terminal, says what was written, and exits.
fn exit_when_interrupted(progress: Progress) {
    let exit = move || {
        let written = tracer::hold_writes();
        progress.clear();
        note(&match written.last() {
            None => "raylanes: interrupted, nothing was written".into(),
            Some(last) => format!("raylanes: interrupted after writing to {}", last.display()),
        });
        std::process::exit(INTERRUPTED);
    };
    // It refuses where a signal is ignored already, by `nohup` for one, and that is right: whoever arranged it meant it.
    let _ = ctrlc::try_set_handler(exit);
}

/// To standard output. A reader that closes its end early (`raylanes list | head -1`) is no error.
fn print(text: &str) -> Result<(), Error> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(source) if source.kind() != io::ErrorKind::BrokenPipe => {
            Err(Error::Io { action: "write", file: "standard output".into(), source })
        }
        _ => Ok(()),
    }
}

/// To standard error; there is nowhere to report that it is closed.
fn note(text: &str) {
    let _ = writeln!(io::stderr(), "{text}");
}

fn run_study(arguments: &StudyArguments, progress: &Progress) -> Result<String, Error> {
    progress.suspend(warn_of_slow_build);
    // Cheap errors first: the study takes its time.
    if arguments.peers {
        study::peers::available()?;
    }
    let scenes = if arguments.scenes.is_empty() {
        study::Options::default_scenes(arguments.quick)
    } else {
        arguments.scenes.iter().map(|name| SceneSource::parse(name)).collect::<Result<_, _>>()?
    };
    let folder = match &arguments.record {
        Some(name) => study::new_record(name)?,
        None => {
            study::try_write(&arguments.out)?;
            arguments.out.clone()
        }
    };
    let StudyArguments { quick, large, seed, peers, .. } = *arguments;
    let record = study::run(&study::Options { scenes, quick, large, seed, peers }, progress)?;
    progress.note("writing");
    let write = if arguments.record.is_some() { study::write_new } else { study::write };
    write(&record, &folder)?;
    let color = AutoStream::choice(&io::stdout()) != ColorChoice::Never;
    let mut text = study::terminal_table(&record, color);
    let folder = folder.display();
    writeln!(text, "\nWritten to {folder}: report.html (or report.md and its charts), results.json")
        .expect("strings grow");
    Ok(text)
}

fn warn_of_slow_build() {
    if let Some(warning) = study::build_warning() {
        note(&format!("note: {warning}"));
    }
}

/// A scene that is ready to be traced, but for the kernels.
struct Loaded {
    world: World,
    camera: Camera,
    light: Light,
    pool: rayon::ThreadPool,
}

impl SceneArguments {
    fn kernels(&self) -> Result<Kernels, Error> {
        Kernels { triangle: "", quadric: "" }
            .with(&self.kernel, &["triangle"])?
            .with(&self.quadric_kernel, &["quadric"])
    }

    fn load(&self, progress: &Progress) -> Result<Loaded, Error> {
        progress.note(&format!("{}: loading", self.scene));
        let source = SceneSource::parse(&self.scene)?;
        let LoadedScene { world, mut view, remarks } = source.load()?;
        for remark in remarks {
            progress.suspend(|| note(&format!("note: {}: {remark}", source.name())));
        }
        if let (Some(eye), Some(look_at)) = (self.eye, self.look_at) {
            view = View { eye, look_at, vertical_fov: self.fov, transform: None, light: view.light };
        }
        let (width, height) = self.size;
        let camera = view.camera(width, height);
        Ok(Loaded { world, camera, light: view.light, pool: tracer::thread_pool(self.threads.into())? })
    }
}

/// What primitives are intersected by: the IDs of one registered kernel for each shape.
#[derive(Clone, Copy)]
struct Kernels {
    triangle: &'static str,
    quadric: &'static str,
}

impl Kernels {
    /// With the kernel of this ID, of which the family may be left out, instead of the one for the same shape.
    fn with(self, id: &str, families: &[&str]) -> Result<Self, Error> {
        let triangle = families.contains(&"triangle").then(|| registry::with_kernel::<Triangle, _>(id, IdOf)).flatten();
        let quadric = families.contains(&"quadric").then(|| registry::with_kernel::<Quadric, _>(id, IdOf)).flatten();
        match (triangle, quadric) {
            (Some(triangle), _) => Ok(Self { triangle, ..self }),
            (None, Some(quadric)) => Ok(Self { quadric, ..self }),
            (None, None) => {
                let mut ids = Ids(Vec::new());
                registry::triangles(&mut ids);
                registry::quadrics(&mut ids);
                ids.0.retain(|id| families.iter().any(|family| id.starts_with(family)));
                let message = format!("no such {} kernel: expected one of {}", families.join(" or "), ids.0.join(", "));
                Err(Error::Argument { argument: id.into(), message })
            }
        }
    }

    /// The world, ready for them.
    fn scene<K: Kernel<Shape = Triangle>>(self, world: World) -> Scene<K> {
        struct Build<K>(World, PhantomData<K>);
        impl<K: Kernel<Shape = Triangle>> Task<Quadric> for Build<K> {
            type Output = Scene<K>;
            fn run<Q: Kernel<Shape = Quadric>>(self) -> Scene<K> {
                Scene::with_quadrics::<Q>(self.0)
            }
        }
        registry::with_kernel(self.quadric, Build::<K>(world, PhantomData)).expect("the kernel was found before")
    }

    fn run<T: Task<Triangle>>(self, task: T) -> T::Output {
        registry::with_kernel(self.triangle, task).expect("the kernel was found before")
    }
}

struct IdOf;

impl<S: Shape> Task<S> for IdOf {
    type Output = &'static str;
    fn run<K: Kernel<Shape = S>>(self) -> &'static str {
        K::INFO.id.method
    }
}

struct Ids(Vec<String>);

impl<S: Shape> Visitor<S> for Ids {
    fn visit<K: Kernel<Shape = S>>(&mut self) {
        self.0.push(K::INFO.id.to_string());
    }
}

/// What `trace --json` prints.
#[derive(Serialize)]
struct TraceResult {
    scene: String,
    triangles: usize,
    quadrics: usize,
    instances: usize,
    rays: usize,
    hits: usize,
    /// Median of the repeats.
    mrays_per_second: f64,
    checksum: String,
    mode: &'static str,
    kernel: String,
    threads: usize,
    build_seconds: f64,
    /// Of geometry, instances, trees and prepared primitives.
    bytes: usize,
    /// The same, of a scene of quadrics alone per quadric.
    bytes_per_triangle: f64,
}

fn trace(arguments: &TraceArguments, progress: &Progress) -> Result<String, Error> {
    progress.suspend(warn_of_slow_build);
    let scene = &arguments.scene;
    // Cheap errors first: a large mesh takes its time.
    let file_rays = arguments.rays.as_deref().map(tracer::read_rays).transpose()?;
    let kernels = scene.kernels()?;
    let loaded = scene.load(progress)?;
    let (width, height) = scene.size;
    let picture_order = file_rays.is_none().then(|| tracer::block_order(width, height));
    let rays = file_rays.unwrap_or_else(|| loaded.camera.rays(width, height));
    let (result, mut hits) = kernels.run(Trace { kernels, arguments, loaded, rays, progress });
    if let Some(file) = &arguments.hits {
        if let Some(order) = picture_order {
            let mut rows = vec![Hit::MISS; hits.len()];
            for (pixel, hit) in order.into_iter().zip(hits) {
                rows[pixel as usize] = hit;
            }
            hits = rows;
        }
        tracer::write_hits(file, &hits)?;
    }
    if arguments.json {
        return Ok(serde_json::to_string(&result).expect("plain data") + "\n");
    }
    let TraceResult { scene, triangles, quadrics, instances, rays, hits, mrays_per_second, .. } = result;
    let TraceResult { checksum, mode, kernel, threads, .. } = result;
    Ok(format!(
        "{scene}: {triangles} triangles, {quadrics} quadrics, {instances} instances, built in {:.3} s, {:.2} MB\n\
         {mrays_per_second:.2} Mrays/s (median of {}), {rays} rays, {hits} hits, checksum {checksum}\n\
         kernel {kernel}, mode {mode}, threads {threads}\n",
        result.build_seconds,
        result.bytes as f64 / 1e6,
        arguments.repeat,
    ))
}

struct Trace<'a> {
    kernels: Kernels,
    arguments: &'a TraceArguments,
    loaded: Loaded,
    rays: Vec<Ray<f32>>,
    progress: &'a Progress,
}

impl Task<Triangle> for Trace<'_> {
    type Output = (TraceResult, Vec<Hit<f32>>);

    fn run<K: Kernel<Shape = Triangle>>(self) -> Self::Output {
        let Self { kernels, arguments, loaded: Loaded { world, pool, .. }, rays, progress } = self;
        let (any_hit, mode) = (arguments.any_hit, arguments.scene.mode);
        let [triangles, quadrics, instances] = [world.triangles(), world.quadrics(), world.instances().len()];
        progress.note(&format!("{}: building", arguments.scene.scene));
        let start = Instant::now();
        let scene = pool.install(|| kernels.scene::<K>(world));
        let build_seconds = start.elapsed().as_secs_f64();
        let mut hits = vec![Hit::MISS; rays.len()];
        let mut trace = || pool.install(|| tracer::trace_into(&scene, &rays, any_hit, mode, &mut hits));
        progress.note(&format!("{}: tracing", arguments.scene.scene));
        trace(); // not counted: it warms up
        let mut rates = Vec::new();
        for _ in 0..arguments.repeat {
            let start = Instant::now();
            trace();
            rates.push(rays.len() as f64 / start.elapsed().as_secs_f64() / 1e6);
        }
        let result = TraceResult {
            scene: arguments.scene.scene.clone(),
            triangles,
            quadrics,
            instances,
            rays: rays.len(),
            hits: hits.iter().filter(|hit| hit.mask).count(),
            mrays_per_second: study::median(&rates),
            checksum: format!("{:016x}", tracer::checksum(&hits)),
            mode: mode.name(),
            kernel: K::INFO.id.to_string(),
            threads: pool.current_num_threads(),
            build_seconds,
            bytes: scene.bytes(),
            bytes_per_triangle: scene.bytes() as f64 / if triangles > 0 { triangles } else { quadrics } as f64,
        };
        (result, hits)
    }
}

fn render(arguments: &RenderArguments, progress: &Progress) -> Result<String, Error> {
    let scene = &arguments.scene;
    let kernels = scene.kernels()?;
    // Cheap errors first: a large mesh takes its time.
    let other = arguments.compare.as_deref().map(|id| kernels.with(id, &["triangle", "quadric"])).transpose()?;
    let Loaded { world, camera, light, pool } = scene.load(progress)?;
    let (width, height) = scene.size;
    let shot = Shot { camera, light, mode: scene.mode, width, height };
    let name = &scene.scene;
    pool.install(|| {
        progress.note(&format!("{name}: rendering"));
        let (picture, hits, world) =
            kernels.run(Render { kernels, world, shot: &shot, shade: arguments.shade.into() });
        picture.write(&arguments.out)?;
        let Some(other) = other else { return Ok(String::new()) };
        progress.note(&format!("{name}: comparing"));
        let other_hits = other.run(Look { kernels: other, world, shot: &shot });
        let (marked, differences) = tracer::compare(&shot, &picture, &hits, &other_hits);
        let file = beside(&arguments.out, "-compare");
        marked.write(&file)?;
        let [first, second] = if kernels.triangle == other.triangle {
            [kernels.quadric, other.quadric]
        } else {
            [kernels.triangle, other.triangle]
        };
        let Differences { only_first, only_second, other_primitive, other_t } = differences;
        Ok(format!(
            "{} of {} pixels differ: {only_first} are hit by {first} only (red), {only_second} by {second} only (blue), and \
             {other_primitive} on another primitive (yellow); see {}\nOn {other_t} more pixels t has other bits.\n",
            differences.marked(),
            hits.len(),
            file.display()
        ))
    })
}

struct Render<'a> {
    kernels: Kernels,
    world: World,
    shot: &'a Shot,
    shade: Shade,
}

impl Task<Triangle> for Render<'_> {
    type Output = (Picture, Vec<Hit<f32>>, World);

    fn run<K: Kernel<Shape = Triangle>>(self) -> Self::Output {
        let Self { kernels, world, shot, shade } = self;
        let scene = kernels.scene::<K>(world);
        let hits = tracer::picture_hits(&scene, shot);
        (tracer::shade(&scene, shot, &hits, shade), hits, scene.into_world())
    }
}

struct Look<'a> {
    kernels: Kernels,
    world: World,
    shot: &'a Shot,
}

impl Task<Triangle> for Look<'_> {
    type Output = Vec<Hit<f32>>;

    fn run<K: Kernel<Shape = Triangle>>(self) -> Self::Output {
        tracer::picture_hits(&self.kernels.scene::<K>(self.world), self.shot)
    }
}

/// The file with this ending of its name, before the extension.
fn beside(file: &Path, ending: &str) -> PathBuf {
    let mut name = file.file_stem().unwrap_or_default().to_owned();
    name.push(ending);
    if let Some(extension) = file.extension() {
        name.push(".");
        name.push(extension);
    }
    file.with_file_name(name)
}
fn list() -> Result<String, Error> {
    struct List(Vec<[String; 6]>);
    impl<S: Shape> Visitor<S> for List {
        fn visit<K: Kernel<Shape = S>>(&mut self) {
            let info = K::INFO;
            let operations = info.operations;
            let claims: Vec<_> = info.claims.iter().map(|claim| claim.name()).collect();
            self.0.push([
                info.id.to_string(),
                format!("{}/{}/{}", operations.mul, operations.add, operations.div),
                size_of::<K>().to_string(),
                size_of::<<K as Intersect<f32>>::Setup>().to_string(),
                if claims.is_empty() { "-".into() } else { claims.join(" ") },
                info.idea.into(),
            ]);
        }
    }
    let header = ["kernel", "mul/add/div", "prepared", "setup", "claims", "idea"].map(String::from);
    let mut rows = List(vec![header]);
    registry::all(&mut rows);
    let width = |column: usize| rows.0.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: [usize; 5] = std::array::from_fn(width);
    let mut text = String::new();
    for row in &rows.0 {
        for (cell, width) in row.iter().zip(widths) {
            write!(text, "{cell:width$}  ").expect("strings grow");
        }
        writeln!(text, "{}", row[5]).expect("strings grow");
    }
    for absent in registry::absent() {
        writeln!(text, "{}  absent: {}", absent.id, absent.reason).expect("strings grow");
    }
    text.push_str("\nOperations of one test; bytes prepared per primitive and set up per ray.\n");
    Ok(text)
}

fn scene_help() -> String {
    format!(
        "SCENE is an OBJ file (*.obj), a scene file (*.toml) or a built-in scene: {}. A size may follow all but the last, \
         such as room:small or terrain:1e6.",
        BuiltIn::NAMES.join(", ")
    )
}

/// The greatest number of pixels of a picture: 8192 × 8192.
const MOST_PIXELS: u64 = 1 << 26;

fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let parsed = text.split_once('x').and_then(|(width, height)| Some((width.parse().ok()?, height.parse().ok()?)));
    match parsed {
        Some((width, height)) if (1..=MOST_PIXELS).contains(&(u64::from(width) * u64::from(height))) => {
            Ok((width, height))
        }
        _ => Err(format!("expected WIDTHxHEIGHT with 1 to {MOST_PIXELS} pixels, such as 1024x768")),
    }
}

fn parse_record_name(text: &str) -> Result<String, String> {
    let allowed = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    if text.is_empty() || text.starts_with('.') || !text.chars().all(allowed) {
        return Err("expected letters, digits, '-', '_' and '.', which does not come first".into());
    }
    Ok(text.into())
}

/// Understands the names of modes.
fn mode_parser() -> impl TypedValueParser<Value = Mode> {
    let mode =
        |name: String| Mode::ALL.into_iter().find(|mode| mode.name() == name).expect("one of the possible values");
    PossibleValuesParser::new(Mode::ALL.map(Mode::name)).map(mode)
}

fn parse_field_of_view(text: &str) -> Result<f32, String> {
    match text.parse() {
        Ok(degrees) if (1.0..=170.0).contains(&degrees) => Ok(degrees),
        _ => Err("expected 1 to 170 degrees".into()),
    }
}
