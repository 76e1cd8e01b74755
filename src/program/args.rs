//! The arguments of the program. Their doc comments are the text of `--help`.

use std::path::PathBuf;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand, ValueEnum};
use glam::Vec3;
use raylanes::kernels::Kernel;
use raylanes::study::{self, TracerKernel};
use raylanes::tracer::{self, BuiltIn, Mode, Shade};

/// Measures ray-intersection kernels: how fast and how accurate each of them is.
#[derive(Parser)]
#[command(version, after_help = closing_help())]
pub(super) struct Arguments {
    /// `None`: `study` of the built-in scenes.
    #[command(subcommand)]
    pub(super) command: Option<Command>,
}

#[derive(Subcommand)]
pub(super) enum Command {
    /// Measure every kernel and the tracer; write results.json, report.html, report.md and charts.
    Study(StudyArguments),
    /// Trace the rays of a picture or of a file; print the speed.
    Trace(TraceArguments),
    /// Trace and shade a picture; write it as PNG.
    Render(RenderArguments),
    /// Say which kernel and mode a scene needs, and why: measured on rays of this scene.
    Advise(AdviseArguments),
    /// List the kernels: ID, operations, bytes, claims and idea.
    List,
    /// What a study starts in processes of its own.
    #[command(hide = true, name = study::TIME_KERNELS)]
    TimeKernels(TimeKernelsArguments),
}

const DEFAULT_OUT: &str = "reports/latest";
const DEFAULT_SEED: u64 = 2026;

#[derive(Args)]
pub(super) struct StudyArguments {
    /// Scenes for the tracer's tables [default: room, terrain:1e5, sphere, forest:10000 and gallery].
    #[arg(value_name = "SCENE")]
    pub(super) scenes: Vec<String>,
    /// Use fewer rays, samples and pixels. This shows that everything works; do not trust the figures.
    #[arg(long)]
    pub(super) quick: bool,
    /// Measure the cost of a ray up to ten million triangles instead of one million. Takes minutes and gigabytes more.
    #[arg(long)]
    pub(super) large: bool,
    /// Folder for the results. They replace older results there.
    #[arg(long, value_name = "DIR", default_value = DEFAULT_OUT)]
    pub(super) out: PathBuf,
    /// Write a record to keep, in the new folder reports/<date>-NAME, with today's date in UTC. An existing record is
    /// never changed.
    #[arg(long, value_name = "NAME", conflicts_with = "out", value_parser = parse_record_name)]
    pub(super) record: Option<String>,
    /// Seed of all random inputs.
    #[arg(long, default_value_t = DEFAULT_SEED)]
    pub(super) seed: u64,
    /// Also trace with obvhs, bvh and parry3d, in scenes that are one mesh. Needs a build with the feature "peers".
    #[arg(long)]
    pub(super) peers: bool,
    /// Build the program once more for these x86-64 processors, and time the kernels of that build beside this one. Run
    /// the study with cargo for this. It takes minutes more.
    #[arg(long, value_enum, value_name = "LEVEL")]
    pub(super) build: Option<Level>,
}

/// A level of x86-64 processors, as the psABI defines it.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Level {
    /// SSE2: every x86-64 processor.
    V1,
    /// SSE4.2.
    V2,
    /// AVX2 and fused multiply-add.
    V3,
    /// AVX-512.
    V4,
}

impl Level {
    /// The compiler's name of these processors.
    pub(super) fn target_cpu(self) -> &'static str {
        match self {
            Self::V1 => "x86-64",
            Self::V2 => "x86-64-v2",
            Self::V3 => "x86-64-v3",
            Self::V4 => "x86-64-v4",
        }
    }
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
            build: None,
        }
    }
}

#[derive(Args)]
pub(super) struct TimeKernelsArguments {
    #[arg(long)]
    pub(super) seed: u64,
    /// How many samples of each kernel.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub(super) rounds: u16,
    /// Width and height of the scenes' pictures.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub(super) picture: u32,
    /// How many samples of each kernel in each scene.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub(super) scene_rounds: u16,
    /// Scenes to trace with each kernel.
    pub(super) scenes: Vec<String>,
}

/// The arguments that `trace` and `render` share.
#[derive(Args)]
pub(super) struct SceneArguments {
    /// A scene file (*.toml), a mesh (*.obj, *.ply, *.stl) or a built-in scene.
    pub(super) scene: String,
    /// Triangle kernel, by ID or name; see `raylanes list`.
    #[arg(long, value_name = "ID", default_value = <TracerKernel as Kernel>::INFO.id.method)]
    pub(super) kernel: String,
    /// Quadric kernel, by ID or name.
    #[arg(long, value_name = "ID", default_value = "mixed")]
    pub(super) quadric_kernel: String,
    /// How rays are traced. The hits are the same in every mode.
    #[arg(long, default_value = Mode::Auto.name(), value_parser = mode_parser())]
    pub(super) mode: Mode,
    /// Use kernels and mode of this plan, which `advise --save` has written.
    #[arg(long, value_name = "PLAN.toml", conflicts_with_all = ["kernel", "quadric_kernel", "mode"])]
    pub(super) plan: Option<PathBuf>,
    /// Number of threads; 0 means one for each processor.
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u16).range(..=1024))]
    pub(super) threads: u16,
    /// Size of the picture in pixels.
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "1024x1024", value_parser = parse_size)]
    pub(super) size: (u32, u32),
    /// Camera position [default: the scene's own, or outside the scene with all of it in view].
    #[arg(
        long,
        value_name = "X,Y,Z",
        value_parser = tracer::parse_point,
        requires = "look_at",
        allow_hyphen_values = true
    )]
    pub(super) eye: Option<Vec3>,
    /// Point in the middle of the picture.
    #[arg(long, value_name = "X,Y,Z", value_parser = tracer::parse_point, requires = "eye", allow_hyphen_values = true)]
    pub(super) look_at: Option<Vec3>,
    /// Vertical field of view in degrees [default: the scene's own, or 60 with --eye].
    #[arg(long, value_name = "DEGREES", value_parser = parse_field_of_view)]
    pub(super) fov: Option<f32>,
}

#[derive(Args)]
pub(super) struct TraceArguments {
    #[command(flatten)]
    pub(super) scene: SceneArguments,
    /// Trace the rays of this file instead of a picture's. Per ray: raw little-endian f32,
    /// `ox oy oz t_min dx dy dz t_max`.
    #[arg(long, value_name = "FILE")]
    pub(super) rays: Option<PathBuf>,
    /// Find out only whether a ray hits anything. A hit then has t = u = v = 0 and primitive 0.
    #[arg(long)]
    pub(super) any_hit: bool,
    /// Trace N times and report the median speed.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    pub(super) repeat: u32,
    /// Write the hits to this file, in ray order (of a picture: row by row from the upper left). Numbers are
    /// little-endian, of 32 bits each; see --hit-format.
    #[arg(long, value_name = "FILE")]
    pub(super) hits: Option<PathBuf>,
    /// What the file of --hits holds for each ray.
    #[arg(long, value_enum, value_name = "FORMAT", default_value_t = HitFormat::Narrow, requires = "hits")]
    pub(super) hit_format: HitFormat,
    /// Print the result as one JSON object.
    #[arg(long)]
    pub(super) json: bool,
}

#[derive(Args)]
pub(super) struct AdviseArguments {
    /// A scene file (*.toml), a mesh (*.obj, *.ply, *.stl) or a built-in scene.
    pub(super) scene: String,
    /// How many rays of a million may be wrong: lost, hitting what they exactly miss, or displaced. 0 asks for kernels
    /// that claim to be always right, also at edges.
    #[arg(long, value_name = "PER_MILLION", default_value_t = 10.0, value_parser = parse_rate)]
    pub(super) max_wrong: f64,
    /// How far a hit may be displaced along its ray, relative to its distance, or to the size of what it hits if that
    /// is less. Farther is wrong.
    #[arg(long, value_name = "RELATIVE", default_value_t = 1e-3, value_parser = parse_error)]
    pub(super) max_error: f64,
    /// Advise for the rays of this file instead of those of a picture. Per ray: raw little-endian f32,
    /// `ox oy oz t_min dx dy dz t_max`.
    #[arg(long, value_name = "FILE")]
    pub(super) rays: Option<PathBuf>,
    /// Find out only whether rays of the file hit anything.
    #[arg(long, requires = "rays")]
    pub(super) any_hit: bool,
    /// How long to measure, in seconds. Loading and building come before it.
    #[arg(long, value_name = "SECONDS", default_value_t = 20.0, value_parser = parse_budget)]
    pub(super) budget: f64,
    /// Write a plan, which `trace --plan` and `render --plan` follow.
    #[arg(long, value_name = "PLAN.toml")]
    pub(super) save: Option<PathBuf>,
    /// Write a page with all figures.
    #[arg(long, value_name = "OUT.md")]
    pub(super) report: Option<PathBuf>,
    /// Write a picture of the pixels that the next cheaper kernel gets wrong.
    #[arg(short, long, value_name = "OUT.png")]
    pub(super) out: Option<PathBuf>,
    /// Write a simpler scene, if there is one that gains something: the scene file, and mesh files beside it.
    #[arg(long, value_name = "OUT.toml", value_parser = parse_scene_file)]
    pub(super) apply: Option<PathBuf>,
    /// Print the advice as one JSON object.
    #[arg(long)]
    pub(super) json: bool,
    /// Seed of all random rays.
    #[arg(long, default_value_t = DEFAULT_SEED)]
    pub(super) seed: u64,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum HitFormat {
    /// `t u v` as f32 and the primitive number as u32.
    Narrow,
    /// `t u v` as f32; numbers of primitive and instance and the side (1 front, 0 back) as u32; the geometric unit
    /// normal `nx ny nz` as f32.
    Wide,
}

#[derive(Args)]
pub(super) struct RenderArguments {
    #[command(flatten)]
    pub(super) scene: SceneArguments,
    /// PNG file to write.
    #[arg(short, long, value_name = "OUT.png")]
    pub(super) out: PathBuf,
    /// What a pixel shows.
    #[arg(long, value_enum, default_value_t = ShadeArgument::Lambert)]
    pub(super) shade: ShadeArgument,
    /// Trace with this triangle or quadric kernel too. Writes a second picture, OUT-compare.png, which marks the pixels
    /// where the two kernels hit different things, and prints how many there are.
    #[arg(long, value_name = "ID")]
    pub(super) compare: Option<String>,
}

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum ShadeArgument {
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
    /// How much of the hemisphere above the surface is open.
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

/// The last lines of `--help`.
fn closing_help() -> String {
    format!(
        "Without a command, `study` measures the built-in scenes.\n\
         SCENE is a mesh (*.obj, *.ply, *.stl), a scene file (*.toml) or a built-in scene: {}.\n\
         All built-in scenes but the last take a size: room:small, terrain:1e6.",
        BuiltIn::NAMES.join(", ")
    )
}

/// Largest number of pixels of a picture: 8192 × 8192.
const MAX_PIXELS: u64 = 1 << 26;

fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let parsed = text.split_once('x').and_then(|(width, height)| Some((width.parse().ok()?, height.parse().ok()?)));
    match parsed {
        Some((width, height)) if (1..=MAX_PIXELS).contains(&(u64::from(width) * u64::from(height))) => {
            Ok((width, height))
        }
        _ => Err(format!("expected WIDTHxHEIGHT with 1 to {MAX_PIXELS} pixels, such as 1024x768")),
    }
}

fn parse_record_name(text: &str) -> Result<String, String> {
    let allowed = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    if text.is_empty() || text.starts_with('.') || !text.chars().all(allowed) {
        return Err("expected letters, digits, '-', '_' and '.', and no '.' at the start".into());
    }
    Ok(text.into())
}

/// Accepts the names of the modes.
fn mode_parser() -> impl TypedValueParser<Value = Mode> {
    let value = |mode: Mode| PossibleValue::new(mode.name()).help(mode.about());
    let mode =
        |name: String| Mode::ALL.into_iter().find(|mode| mode.name() == name).expect("one of the possible values");
    PossibleValuesParser::new(Mode::ALL.map(value)).map(mode)
}

fn parse_scene_file(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml")) {
        Ok(path)
    } else {
        Err("expected a file name that ends in .toml".into())
    }
}

fn parse_rate(text: &str) -> Result<f64, String> {
    within(text, 0.0, 1e6).ok_or_else(|| "expected 0 to 1000000".into())
}

fn parse_error(text: &str) -> Result<f64, String> {
    within(text, 1e-7, 1.0).ok_or_else(|| "expected 1e-7 to 1; an f32 distance has no more digits".into())
}

fn parse_budget(text: &str) -> Result<f64, String> {
    within(text, 0.1, 3600.0).ok_or_else(|| "expected 0.1 to 3600 seconds".into())
}

/// A number in this range.
fn within(text: &str, least: f64, most: f64) -> Option<f64> {
    text.parse().ok().filter(|number| (least..=most).contains(number))
}

fn parse_field_of_view(text: &str) -> Result<f32, String> {
    match text.parse() {
        Ok(degrees) if (1.0..=170.0).contains(&degrees) => Ok(degrees),
        _ => Err("expected 1 to 170 degrees".into()),
    }
}
