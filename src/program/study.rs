//! `raylanes study`: measures everything, writes the report, and returns the table for the terminal.

use std::fmt::Write as _;
use std::io;

use anstream::{AutoStream, ColorChoice};
use raylanes::study::{self, Progress};
use raylanes::tracer::{Error, SceneSource};

use super::args::StudyArguments;
use super::terminal;

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
