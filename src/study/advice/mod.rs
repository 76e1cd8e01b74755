//! Advice: which kernel, mode and model one scene needs, and why.
//!
//! | file | content |
//! | --- | --- |
//! | `traits` | properties of the scene and its rays that make kernels fail |
//! | `rays` | rays of the scene: to choose by, to score with, to time |
//! | `race` | every kernel judged by the exact answers and timed; the best ones timed again, in turns |
//! | `modes` | the modes of the tracer, timed with the chosen kernels |
//! | `models` | simpler models of the scene |
//! | `gains` | what each of them gains, measured |
//! | `reasons` | the answer in sentences |
//! | `plan` | a file that fixes kernels and mode |
//!
//! `figures/choice.rs` holds the rule of choice.

mod gains;
mod models;
mod modes;
mod plan;
mod race;
mod rays;
mod reasons;
mod traits;

use std::cell::OnceCell;
use std::time::{Duration, Instant};

use serde::Serialize;

use self::gains::Asked;
pub use self::gains::{ModelRow, SimplerScene};
use self::modes::fastest_mode;
pub use self::plan::Plan;
use self::race::{Clock, Listed, Pair, Race, prepare};
use self::rays::{Rays, Source};
pub use self::traits::Trait;
use crate::geom::{Quadric, Ray, Triangle};
use crate::study::figures::Rate;
use crate::study::figures::choice::{Candidate, Choice, Need, Standing, WrongAnswers};
use crate::study::measure::built_scene::TracerKernel;
use crate::study::measure::on_scenes::{Answered, MOST_DISPLACED};
use crate::study::measure::scene_truth::SceneTruth;
use crate::study::measure::stats::Estimate;
use crate::study::progress::Progress;
use crate::study::record::{OnSceneRow, SceneSpeedRow};
use crate::tracer::{Error, LoadedScene, Scene};

/// What is asked about a scene.
#[derive(Clone, Debug)]
pub struct Question {
    /// The greatest rate of wrong rays that the scene can live with, per million: rays that are lost, that hit what
    /// they exactly miss, or whose hit is displaced. Zero asks for a kernel that claims to be always right.
    pub max_wrong: f64,
    /// The greatest displacement of a hit along its ray that does not count, relative to the distance of the hit, or to
    /// the size of the instance that is hit where that is less.
    pub max_error: f64,
    /// How long to measure. Loading the scene and building its trees come before it.
    pub budget: Duration,
    /// Rays to choose by, and as many to score with. Fewer if their exact answers would take too long.
    pub rays: usize,
    /// The rays of a file, and whether any hit will do for them, instead of those of pictures.
    pub file: Option<(Vec<Ray<f32>>, bool)>,
    /// Seed of all random rays.
    pub seed: u64,
}

impl Default for Question {
    /// Ten wrong rays per million, displacements of a thousandth, twenty seconds, and a million rays.
    fn default() -> Self {
        Self {
            max_wrong: 10.0,
            max_error: MOST_DISPLACED,
            budget: Duration::from_secs(20),
            rays: 1_000_000,
            file: None,
            seed: 2026,
        }
    }
}

/// The answer: what the scene needs, and the figures behind it.
#[derive(Clone, Debug, Serialize)]
pub struct Advice {
    /// Scene name.
    pub scene: String,
    /// Number of triangles of all meshes.
    pub triangles: usize,
    /// Number of quadrics and discs.
    pub quadrics: usize,
    /// Number of instances.
    pub instances: usize,
    /// ID of the triangle kernel to use. If no kernel meets the need, the one that is wrong least often.
    pub kernel: String,
    /// ID of the quadric kernel to use, likewise.
    pub quadric_kernel: String,
    /// The mode to use.
    pub mode: &'static str,
    /// Whether both kernels meet the need.
    pub meets_need: bool,
    /// The need: wrong rays per million.
    pub max_wrong_per_million: f64,
    /// The need: displacement of a hit that does not count.
    pub max_error: f64,
    /// One line each: why.
    pub reasons: Vec<String>,
    /// For each kind of shape in the scene, the kernels.
    pub shapes: Vec<ShapeAdvice>,
    /// The chosen kernels on rays that had no part in choosing them.
    pub scored: Option<Score>,
    /// The modes.
    pub modes: Vec<ModeRow>,
    /// What makes kernels fail: properties of the scene and of its rays.
    pub traits: Vec<Trait>,
    /// Simpler models of the scene.
    pub models: Vec<ModelRow>,
    /// Those that are worth it, one after the other.
    pub simpler: Option<ModelRow>,
    /// The scene that they give.
    #[serde(skip)]
    pub simpler_scene: Option<SimplerScene>,
    /// Seconds that the measurements took.
    pub seconds: f64,
}

impl Advice {
    /// ID of the kernel that is faster than a chosen one and does not meet the need: the one for triangles, if any.
    pub fn cheaper(&self) -> Option<&str> {
        let rows = self.shapes.iter().rev().flat_map(|shape| &shape.kernels);
        rows.into_iter().find(|row| row.roles.contains(&"cheaper")).map(|row| row.id.as_str())
    }
}

/// The kernels for one kind of shape, the fastest first.
#[derive(Clone, Debug, Serialize)]
pub struct ShapeAdvice {
    /// `triangle` or `quadric`.
    pub family: &'static str,
    /// All kernels.
    pub kernels: Vec<KernelRow>,
    /// The choice that the rows tell about.
    #[serde(skip)]
    pub(crate) choice: Choice,
}

/// One kernel on the rays that kernels are chosen by.
#[derive(Clone, Debug, Serialize)]
pub struct KernelRow {
    /// Kernel ID.
    pub id: String,
    /// `meets`, `open` (the rays cannot tell) or `fails`.
    pub standing: &'static str,
    /// What it is in the answer: `chosen`, `tie`, `runner-up`, `cheaper`, `more careful`. Several, or none.
    pub roles: Vec<&'static str>,
    /// Whether it is more right than every faster one.
    pub on_frontier: bool,
    /// How often it is wrong.
    #[serde(flatten)]
    pub score: Score,
    /// Nanoseconds per ray, mode auto, one thread.
    pub ns_per_ray: f64,
    /// How many times as fast as the tracer's own kernel it is.
    pub gain: f64,
    /// Lower end of its interval.
    pub gain_low: f64,
    /// Upper end of its interval.
    pub gain_high: f64,
}

/// Wrong rays among some rays.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Score {
    /// Rays of pictures or of the file.
    pub rays: u64,
    /// Wrong ones among them.
    pub wrong: u64,
    /// Wrong rays per million: 95 % interval.
    pub wrong_per_million: [f64; 2],
    /// Rays aimed at edges.
    pub edge_rays: u64,
    /// Wrong ones among them.
    pub edge_wrong: u64,
    /// 99 % of the right hits are displaced by at most this.
    pub displacement_p99: f64,
}

/// One mode with the chosen kernels.
#[derive(Clone, Debug, Serialize)]
pub struct ModeRow {
    /// Name of the mode.
    pub mode: &'static str,
    /// Million rays per second in one thread, median.
    pub mrays_per_second: f64,
    /// How many times as fast as mode auto it is.
    pub gain: f64,
    /// Lower end of its interval.
    pub gain_low: f64,
    /// Upper end of its interval.
    pub gain_high: f64,
}

/// Measures a scene, and says what it needs.
///
/// # Errors
/// If the system does not grant a thread, if hits differ that must be identical, or if no ray hits anything.
pub fn advise(name: &str, loaded: LoadedScene, question: &Question, progress: &Progress) -> Result<Advice, Error> {
    let LoadedScene { world, view, .. } = loaded;
    progress.note(&format!("{name}: building"));
    let scene = Scene::<TracerKernel>::new(world);
    let truth = SceneTruth::new(scene.world());
    let start = Instant::now();
    let until = |share: f64| start + question.budget.mul_f64(share);
    let source = match &question.file {
        Some((rays, any_hit)) => Source::File(rays, *any_hit),
        None => Source::Picture(&view),
    };
    let parts = progress.parts(&[0.3, 0.4, 0.1, 0.2]);
    progress.note(&format!("{name}: exact answers"));
    let amount = (question.rays, question.budget.mul_f64(0.3), question.seed);
    let rays = Rays::new(&scene, &truth, &source, amount, &|share| parts[0].reach(share));
    if !rays.search.iter().any(Answered::hits) {
        let message = "no ray hits anything, so nothing can be said about it; look at the scene from elsewhere";
        return Err(Error::Argument { argument: name.into(), message: message.into() });
    }
    let clock = Clock::new()?;
    let need = Need { max_wrong: question.max_wrong };
    let mut pair = Pair::of_tracer();
    let mut shapes = Vec::new();
    let world = scene.world();
    let families = [
        ("quadric", world.quadrics() > 0, Listed::of::<Quadric>()),
        ("triangle", world.triangles() > 0, Listed::of::<Triangle>()),
    ];
    let families: Vec<_> = families.into_iter().filter(|(_, is_there, _)| *is_there).collect();
    for ((family, _, listed), progress) in parts[1].each(&families) {
        progress.note(&format!("{name}: {family} kernels"));
        let reference = OnceCell::new();
        let most_displaced = question.max_error;
        let (scene, truth, rays, clock) = (&scene, &truth, &rays, &clock);
        let race = Race { name, scene, truth, rays, most_displaced, clock, family, pair: pair.clone(), reference };
        // The last of the families has time until this share of the budget has passed.
        let deadline = until(if *family == "triangle" { 0.65 } else { 0.45 });
        let choice = choose(&race, listed, need, deadline, &progress)?;
        let best = choice.chosen().unwrap_or_else(|| choice.least_wrong()).id.clone();
        pair = pair.with(family, &best);
        shapes.push(shape_advice(family, choice));
    }
    progress.note(&format!("{name}: modes"));
    let prepared = prepare(&scene, &pair);
    let modes = fastest_mode(&clock, &*prepared, &rays.timed, until(0.75), &|share| parts[2].reach(share))?;
    progress.note(&format!("{name}: score"));
    let judged = |set| prepared.judge(&truth, set, [name, ""], question.max_error);
    let judged: Vec<_> = rays.scored.iter().map(judged).collect();
    let scored = WrongAnswers::of(judged.iter()).map(Score::new);
    let cheaper = shapes.iter().rev().find_map(|shape| {
        let cheaper = &shape.choice.candidates[shape.choice.cheaper?];
        Some((shape.family, cheaper.id.clone()))
    });
    let asked = Asked {
        name,
        scene: &scene,
        view: &view,
        rays: &rays,
        clock: &clock,
        prepared: &*prepared,
        pair: &pair,
        mode: modes.fastest,
        need,
        most_displaced: question.max_error,
        cheaper,
    };
    let models = asked.models(until(0.95), &parts[3])?;
    let (simpler_scene, simpler) = asked.simpler(&models, until(1.0))?.unzip();
    let confirmed = scored.is_none_or(|score| score.wrong_per_million[0] <= question.max_wrong);
    let mut advice = Advice {
        scene: name.into(),
        triangles: world.triangles(),
        quadrics: world.quadrics(),
        instances: world.instances().len(),
        kernel: pair.triangle,
        quadric_kernel: pair.quadric,
        mode: modes.fastest.name(),
        meets_need: confirmed && shapes.iter().all(|shape| shape.choice.chosen.is_some()),
        max_wrong_per_million: question.max_wrong,
        max_error: question.max_error,
        reasons: Vec::new(),
        shapes,
        scored,
        modes: modes.rows,
        traits: traits::traits(&scene, &rays.timed),
        models,
        simpler,
        simpler_scene,
        seconds: start.elapsed().as_secs_f64(),
    };
    advice.reasons = reasons::of(&advice);
    Ok(advice)
}

/// Judges and times all kernels of a family, and then times those again that the answer names.
fn choose(race: &Race, listed: &Listed, need: Need, deadline: Instant, progress: &Progress) -> Result<Choice, Error> {
    let parts = progress.parts(&[1.0, 2.0]);
    let ids: Vec<&str> = listed.0.iter().map(|(id, _)| id.as_str()).collect();
    let (judged, mut timed) = race.all(&ids, &|share| parts[0].reach(share))?;
    let chosen_of = |timed: &[SceneSpeedRow]| {
        let (judged, timed): (Vec<&OnSceneRow>, Vec<_>) = (judged.iter().collect(), timed.iter().collect());
        let candidates = Candidate::all(race.family, &judged, &timed, &|id| listed.claims(id));
        Choice::new(candidates, need).expect("every family has kernels")
    };
    let first = chosen_of(&timed);
    let named: Vec<&str> = first.close().into_iter().map(|number| first.candidates[number].id.as_str()).collect();
    let again = race.named(&named, deadline, &|share| parts[1].reach(share))?;
    timed.retain(|row| !named.contains(&row.kernel.as_str()));
    timed.extend(again);
    Ok(chosen_of(&timed))
}

fn shape_advice(family: &'static str, choice: Choice) -> ShapeAdvice {
    let row = |(number, candidate): (usize, &Candidate)| {
        let roles = [
            ("chosen", choice.chosen == Some(number)),
            ("tie", choice.ties.contains(&number)),
            ("runner-up", choice.runner_up == Some(number)),
            ("cheaper", choice.cheaper == Some(number)),
            ("more careful", choice.careful == Some(number)),
        ];
        let own = Pair::of_tracer();
        let base = choice.candidates.iter().find(|other| [&own.triangle, &own.quadric].contains(&&other.id));
        let gain = base.and_then(|base| candidate.gain_over(base));
        let gain = |figure: fn(&Estimate) -> f64| gain.as_ref().map_or(f64::NAN, figure);
        KernelRow {
            id: candidate.id.clone(),
            standing: match choice.standings[number] {
                Standing::Meets => "meets",
                Standing::Open => "open",
                Standing::Fails => "fails",
            },
            roles: roles.into_iter().filter(|(_, is)| *is).map(|(role, _)| role).collect(),
            on_frontier: choice.frontier.contains(&number),
            score: Score::new(candidate.answers),
            ns_per_ray: candidate.time().map_or(f64::NAN, |time| time.value),
            gain: gain(|gain| gain.value),
            gain_low: gain(|gain| gain.low),
            gain_high: gain(|gain| gain.high),
        }
    };
    let kernels = choice.candidates.iter().enumerate().map(row).collect();
    ShapeAdvice { family, kernels, choice }
}

impl Score {
    fn new(answers: WrongAnswers) -> Self {
        let WrongAnswers { wrong, at_edges, displacement } = answers;
        let edges = at_edges.unwrap_or(Rate { events: 0, of: 0 });
        Self {
            rays: wrong.of,
            wrong: wrong.events,
            wrong_per_million: wrong.interval(),
            edge_rays: edges.of,
            edge_wrong: edges.events,
            displacement_p99: displacement,
        }
    }
}
