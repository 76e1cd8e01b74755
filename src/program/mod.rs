//! The program: reads the arguments, runs one command, and prints the text that the command returns.
//!
//! | file | content |
//! | --- | --- |
//! | `args` | every option, with its help text and its parser |
//! | `study`, `trace`, `render`, `list` | one command each |
//! | `scene` | what `trace` and `render` share: the chosen kernels and the loaded scene |
//! | `terminal` | standard output, standard error, and what happens on Ctrl-C |
//!
//! An error is one line on standard error; the exit code is then 2.

mod args;
mod list;
mod render;
mod scene;
mod study;
mod terminal;
mod trace;

use std::process::ExitCode;

use clap::Parser;
use raylanes::study::Progress;

use args::{Arguments, Command, StudyArguments};

/// Runs the command that the arguments name.
pub(crate) fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let command = arguments.command.unwrap_or(Command::Study(StudyArguments::default()));
    let progress = if matches!(command, Command::Study(_)) { Progress::bar() } else { Progress::spinner() };
    terminal::exit_when_interrupted(progress.clone());
    let outcome = match command {
        Command::Study(arguments) => study::run(&arguments, &progress),
        Command::Trace(arguments) => trace::run(&arguments, &progress),
        Command::Render(arguments) => render::run(&arguments, &progress),
        Command::List => Ok(list::run()),
    };
    progress.clear();
    match outcome.and_then(|text| terminal::print(&text)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            terminal::note(&format!("raylanes: {error}"));
            ExitCode::from(2)
        }
    }
}
