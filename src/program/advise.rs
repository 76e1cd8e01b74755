//! `raylanes advise`: says which kernel and mode a scene needs, and why.

use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use anstream::{AutoStream, ColorChoice};
use raylanes::study::advice::{Advice, Plan};
use raylanes::study::{self, Progress};
use raylanes::tracer::{
    self, Error, LoadedScene, Mode, SceneSource, Shade, Shot, View, World, printable, printable_path,
};

use super::args::AdviseArguments;
use super::memory;
use super::render::Render;
use super::scene::ChosenKernels;
use super::terminal;

/// A ray, its exact answer, and its hit.
const BYTES_PER_RAY: usize = 200;

pub(super) fn run(arguments: &AdviseArguments, progress: &Progress) -> Result<String, Error> {
    progress.suspend(terminal::warn_of_slow_build);
    // A large mesh takes long to load, so the other arguments are checked before it.
    let outputs: Vec<_> = [&arguments.save, &arguments.report, &arguments.out, &arguments.apply]
        .into_iter()
        .flatten()
        .map(PathBuf::as_path)
        .collect();
    outputs.iter().try_for_each(|output| tracer::check_output(output))?;
    tracer::start_global_pool()?;
    let file = arguments.rays.as_deref().map(tracer::read_rays).transpose()?;
    if let (Some(path), Some([])) = (&arguments.rays, file.as_deref()) {
        return Err(Error::Input { file: path.clone(), line: None, message: "no rays".into() });
    }
    let source = SceneSource::parse(&arguments.scene)?;
    let name = printable(&arguments.scene);
    progress.note(&format!("{name}: loading"));
    let loaded = source.load()?;
    outputs.iter().try_for_each(|output| tracer::check_output(output))?;
    progress.suspend(|| terminal::remarks(&source.name(), &loaded.remarks));
    let LoadedScene { world, view, .. } = &loaded;
    if file.is_none() {
        let in_scene =
            |error: tracer::ViewError| Error::Argument { argument: source.name(), message: error.to_string() };
        view.check(world).map_err(in_scene)?;
    }
    let default = study::advice::Question::default();
    memory::check(&name, world, 2 * default.rays, BYTES_PER_RAY)?;
    let question = study::advice::Question {
        max_wrong: arguments.max_wrong,
        max_error: arguments.max_error,
        budget: Duration::from_secs_f64(arguments.budget),
        file: file.map(|rays| (rays, arguments.any_hit)),
        seed: arguments.seed,
        ..default
    };
    let kept = arguments.out.as_ref().map(|out| (out, loaded.world.clone(), loaded.view));
    let advice = study::advice::advise(&source.name(), loaded, &question, progress)?;
    if let Some(path) = &arguments.save {
        Plan::write(&advice, path)?;
    }
    if let Some(path) = &arguments.apply {
        apply(&advice, path)?;
    }
    if let Some(path) = &arguments.report {
        let page = study::advice_page(&advice, &study::describe());
        tracer::write_atomically(path, |file| file.write_all(page.as_bytes()))?;
    }
    let picture = kept.map(|(out, world, view)| wrong_pixels(&advice, world, &view, out, progress)).transpose()?;
    if arguments.json {
        return Ok(serde_json::to_string(&advice).expect("plain data") + "\n");
    }
    let color = AutoStream::choice(&io::stdout()) != ColorChoice::Never;
    Ok(study::advice_text(&advice, color) + &picture.unwrap_or_default())
}

/// Writes the simpler scene, and reads it again to see that it is the one whose hits were compared.
fn apply(advice: &Advice, path: &Path) -> Result<(), Error> {
    let Some(simpler) = &advice.simpler_scene else {
        let message = format!("nothing to write: no simpler model of {} gains anything", advice.scene);
        return Err(Error::Argument { argument: "--apply".into(), message });
    };
    tracer::write_scene(&simpler.world, &simpler.view, path)?;
    let read = tracer::load_scene(path)?;
    if read.world != simpler.world {
        return Err(Error::Disagreement(format!("the scene in memory and {}", printable_path(path))));
    }
    Ok(())
}

/// Writes a picture of the pixels that the next cheaper kernel gets wrong; without one, those of the chosen kernels.
/// Returns a line about it.
fn wrong_pixels(advice: &Advice, world: World, view: &View, out: &Path, progress: &Progress) -> Result<String, Error> {
    const SIZE: u32 = 1024;
    progress.note(&format!("{}: wrong pixels", advice.scene));
    let shot = Shot { camera: view.camera(SIZE, SIZE), light: view.light, mode: Mode::Auto, width: SIZE, height: SIZE };
    let exact = ChosenKernels { triangle: "triangle/exact", quadric: "quadric/f64" };
    let chosen = exact.with(&advice.kernel, &["triangle"])?.with(&advice.quadric_kernel, &["quadric"])?;
    let cheaper = advice.cheaper().map(|id| chosen.with(id, &["triangle", "quadric"])).transpose()?;
    let other = cheaper.unwrap_or(chosen);
    let shade = Shade::Lambert;
    let (right, hits, world) = exact.run(Render { kernels: exact, world, shot: &shot, shade });
    let (picture, other_hits, _) = other.run(Render { kernels: other, world, shot: &shot, shade });
    let (mut marked, differences) = tracer::compare(&shot, &right, &hits, &other_hits);
    let shadows = tracer::mark_colors(&mut marked, &right, &picture);
    marked.write(out)?;
    let name = advice.cheaper().unwrap_or("the choice");
    Ok(format!(
        "{}: of {} pixels, {name} shows something else in {} (red, blue, yellow), and another light in {shadows} \
         (magenta).\n",
        printable_path(out),
        hits.len(),
        differences.marked()
    ))
}
