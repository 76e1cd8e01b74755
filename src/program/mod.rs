//! The program: reads the arguments, runs one command, and prints the text that the command returns.
//!
//! | file | content |
//! | --- | --- |
//! | `args` | every option, with its help text and its parser |
//! | `usage` | reads the arguments, and makes one line of what is wrong with them |
//! | `study`, `advise`, `trace`, `render`, `list` | one command each |
//! | `scene`, `memory` | what `trace` and `render` share: the chosen kernels, the loaded scene, checks |
//! | `terminal` | standard output and standard error |
//! | `signals` | what happens on Ctrl-C, and where the system refuses to go on |
//!
//! An error is one line on standard error; the exit code is then 2. A study starts the program again, with a hidden
//! command that times kernels.

mod advise;
mod args;
mod list;
mod memory;
mod other_build;
mod render;
mod scene;
mod signals;
mod study;
mod terminal;
mod trace;
mod usage;

use std::process::ExitCode;

use raylanes::study::Progress;
use raylanes::tracer::{self, Error};

use args::{Command, StudyArguments};
use usage::Request;

/// Runs the command that the arguments name.
pub(crate) fn main() -> ExitCode {
    signals::fail_without_dumps();
    let outcome = match usage::request() {
        Request::Done(printed) => printed.map_err(|error| error.to_string()),
        Request::Wrong(line) => Err(line),
        Request::Run(arguments) => {
            let command = arguments.command.unwrap_or(Command::Study(StudyArguments::default()));
            run(command).and_then(|text| terminal::print(&text)).map_err(|error| error.to_string())
        }
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(line) => {
            // An interrupt removes reserved folders, so the command may fail because of it. This error and the message
            // of the interrupt exclude each other: whoever holds the writes first exits while holding them.
            let _held = tracer::hold_writes();
            terminal::note(&format!("raylanes: {line}"));
            std::process::exit(2)
        }
    }
}

/// Runs the command. Returns what it prints.
fn run(command: Command) -> Result<String, Error> {
    let progress =
        if matches!(command, Command::Study(_) | Command::Advise(_)) { Progress::bar() } else { Progress::spinner() };
    // Whoever starts a process that times kernels also ends it.
    if !matches!(command, Command::TimeKernels(_)) {
        signals::exit_when_interrupted(&progress)?;
    }
    let outcome = match command {
        Command::Study(arguments) => study::run(&arguments, &progress),
        Command::Trace(arguments) => trace::run(&arguments, &progress),
        Command::Render(arguments) => render::run(&arguments, &progress),
        Command::Advise(arguments) => advise::run(&arguments, &progress),
        Command::List => Ok(list::run()),
        Command::TimeKernels(arguments) => study::time(&arguments).map(|()| String::new()),
    };
    progress.clear();
    outcome
}
