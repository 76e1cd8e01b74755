//! `raylanes study`: measures everything, writes the report, and returns the table for the terminal.

use std::env;
use std::fmt::Write as _;
use std::fs;
use std::io;
use std::path::Path;

use anstream::{AutoStream, ColorChoice};
use raylanes::study::{self, Progress};
use raylanes::tracer::{Error, SceneSource, check_output, printable_path, start_global_pool};

use super::args::{StudyArguments, TimeKernelsArguments};
use super::{other_build, terminal};

pub(super) fn run(arguments: &StudyArguments, progress: &Progress) -> Result<String, Error> {
    progress.suspend(terminal::warn_of_slow_build);
    // The study takes minutes, so everything that can be checked before it is checked here.
    if arguments.peers {
        study::peers::available()?;
    }
    let scenes = if arguments.scenes.is_empty() {
        study::Options::default_scenes(arguments.quick)
    } else {
        arguments.scenes.iter().map(|name| SceneSource::parse(name)).collect::<Result<_, _>>()?
    };
    let reserved = match &arguments.record {
        Some(name) => study::new_record(name)?,
        None => study::reserve(&arguments.out)?,
    };
    start_global_pool()?;
    for scene in &scenes {
        progress.note(&format!("{}: checking", scene.name()));
        refuse_pipe(scene)?;
        scene.check()?;
    }
    check_results(reserved.path())?;
    let StudyArguments { quick, large, seed, peers, .. } = *arguments;
    let own = env::current_exe().map_err(|source| Error::Io { action: "find", file: "this program".into(), source })?;
    let other = arguments.build.map(|level| other_build::make(level, progress)).transpose()?;
    let options = study::Options { scenes, quick, large, seed, peers, program: Some(own), other };
    let record = study::run(&options, progress)?;
    progress.note("writing");
    let write = if arguments.record.is_some() { study::write_new } else { study::write };
    write(&record, reserved.path())?;
    let color = AutoStream::choice(&io::stdout()) != ColorChoice::Never;
    let mut text = study::terminal_table(&record, color);
    let folder = printable_path(reserved.path());
    writeln!(text, "\nWritten to {folder}: report.html and appendix.html (or .md and charts), results.json")
        .expect("strings grow");
    Ok(text)
}

/// A study reads its scenes several times, also in processes of its own. A pipe can be read only once.
fn refuse_pipe(scene: &SceneSource) -> Result<(), Error> {
    let (SceneSource::Mesh(path) | SceneSource::Toml(path)) = scene else { return Ok(()) };
    if path.metadata().is_ok_and(|file| !file.is_file() && !file.is_dir()) {
        let message = "a study reads its scenes several times, so it needs a file and not a pipe".into();
        return Err(Error::Argument { argument: printable_path(path), message });
    }
    Ok(())
}

/// Times what a study starts in processes of its own.
pub(super) fn time(arguments: &TimeKernelsArguments) -> Result<(), Error> {
    let TimeKernelsArguments { seed, rounds, picture, scene_rounds, scenes } = arguments;
    let timed = study::Timed {
        seed: *seed,
        rounds: (*rounds).into(),
        scenes: scenes.iter().map(|name| SceneSource::parse(name)).collect::<Result<_, _>>()?,
        picture: *picture,
        scene_rounds: (*scene_rounds).into(),
    };
    study::time_kernels(&timed, &mut io::stdout().lock())
}

/// Refuses to replace older results that are unwritable, or that a scene of this study consists of.
fn check_results(folder: &Path) -> Result<(), Error> {
    let reading = |source| Error::Io { action: "read", file: folder.into(), source };
    for entry in fs::read_dir(folder).map_err(reading)? {
        let file = entry.map_err(reading)?.path();
        if file.extension().is_some_and(|extension| study::RESULT_EXTENSIONS.iter().any(|known| extension == *known)) {
            check_output(&file)?;
        }
    }
    Ok(())
}
