//! Standard output, standard error, and what happens when the program is interrupted.

use std::io::{self, Write as _};

use raylanes::study::{self, Progress};
use raylanes::tracer::{self, Error};

/// The exit code that shells report for a program that Ctrl-C ended.
const INTERRUPTED: i32 = 130;

/// Handles Ctrl-C and the system's request to end the program: lets the current write finish, clears the progress line,
/// says what was written, and exits.
pub(super) fn exit_when_interrupted(progress: Progress) {
    let exit = move || {
        let written = tracer::hold_writes();
        progress.clear();
        note(&match written.last() {
            None => "raylanes: interrupted, nothing was written".into(),
            Some(last) => format!("raylanes: interrupted after writing to {}", last.display()),
        });
        std::process::exit(INTERRUPTED);
    };
    // This fails where the signal is already ignored, for instance under `nohup`. Then it shall stay ignored.
    let _ = ctrlc::try_set_handler(exit);
}

/// Writes to standard output. A reader that closes its end early (`raylanes list | head -1`) is no error.
pub(super) fn print(text: &str) -> Result<(), Error> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(source) if source.kind() != io::ErrorKind::BrokenPipe => {
            Err(Error::Io { action: "write", file: "standard output".into(), source })
        }
        _ => Ok(()),
    }
}

/// Writes a line to standard error. If standard error is closed, there is nowhere left to report that.
pub(super) fn note(text: &str) {
    let _ = writeln!(io::stderr(), "{text}");
}

/// Says so if this build does not use the instructions that the processor has.
pub(super) fn warn_of_slow_build() {
    if let Some(warning) = study::build_warning() {
        note(&format!("note: {warning}"));
    }
}
