//! Standard output and standard error.

use std::io::{self, Write as _};

use raylanes::study;
use raylanes::tracer::Error;

/// Writes to standard output. A reader that closes its end early (`raylanes list | head -1`) is no error.
pub(super) fn print(text: &str) -> Result<(), Error> {
    let mut stdout = io::stdout().lock();
    written(stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()))
}

/// The error of writing to standard output, if it is one.
pub(super) fn written(result: io::Result<()>) -> Result<(), Error> {
    match result {
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

/// Writes the remarks about a scene, one line each. Of very many, only the first: a file can give thousands.
pub(super) fn remarks(scene: &str, remarks: &[String]) {
    const MAX_LINES: usize = 20;
    let (shown, others) = remarks.split_at(remarks.len().min(MAX_LINES));
    for remark in shown {
        note(&format!("note: {scene}: {remark}"));
    }
    if !others.is_empty() {
        note(&format!("note: {scene}: and {} more remarks", others.len()));
    }
}

/// Says so if this build does not use the instructions that the processor has.
pub(super) fn warn_of_slow_build() {
    if let Some(warning) = study::build_warning() {
        note(&format!("note: {warning}"));
    }
}
