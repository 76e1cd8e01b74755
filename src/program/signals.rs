//! What happens when the program is interrupted, or when the system refuses to go on.

use raylanes::study::{self, Progress};
use raylanes::tracer::{self, Error, printable_path};

use super::terminal::note;

/// The exit code that shells report for a program that Ctrl-C ended.
const INTERRUPTED: i32 = 130;

/// Handles the requests to end the program: lets the current write finish, clears the progress line, says what was
/// written, and exits.
///
/// # Errors
/// If there is no thread left to wait for the requests.
pub(super) fn exit_when_interrupted(progress: &Progress) -> Result<(), Error> {
    let refused = |source| Error::Io { action: "start", file: "a thread".into(), source };
    let exit = |progress: &Progress| {
        let written = tracer::hold_writes();
        let _stopped = study::stop_processes();
        progress.clear();
        note(&match written.last() {
            None => "raylanes: interrupted, nothing was written".into(),
            Some(last) => format!("raylanes: interrupted after writing to {}", printable_path(last)),
        });
        std::process::exit(INTERRUPTED);
    };
    let on_interrupt = progress.clone();
    // This handles SIGINT, SIGTERM and SIGHUP, or none of them if one is ignored, for instance under `nohup`.
    let handles_all = match ctrlc::try_set_handler(move || exit(&on_interrupt)) {
        Err(ctrlc::Error::System(error)) => return Err(refused(error)),
        result => result.is_ok(),
    };
    #[cfg(unix)]
    {
        let mut signals = signal_hook::iterator::Signals::new(unix::other_signals(handles_all)).map_err(refused)?;
        let progress = progress.clone();
        let wait = move || signals.forever().for_each(|_| exit(&progress));
        std::thread::Builder::new().spawn(wait).map_err(refused)?;
    }
    #[cfg(not(unix))]
    let _ = handles_all;
    Ok(())
}

#[cfg(unix)]
mod unix {
    use std::ffi::c_int;
    use std::fs;

    use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGUSR1, SIGUSR2, SIGXCPU};

    /// The requests to end the program that `ctrlc` does not handle. A signal that is ignored shall stay ignored.
    pub(super) fn other_signals(ctrlc_handles_all: bool) -> Vec<c_int> {
        let ignored = ignored_signals();
        let is_ignored = |signal: c_int| ignored.map(|ignored| ignored >> (signal - 1) & 1 == 1);
        // What batch systems send before they kill a job. If the system does not tell, they are not ignored.
        let mut signals = vec![SIGXCPU, SIGUSR1, SIGUSR2];
        if !ctrlc_handles_all {
            signals.push(SIGTERM);
        }
        signals.retain(|&signal| is_ignored(signal) != Some(true));
        // Shells ignore these on purpose, SIGINT and SIGQUIT together. So what `ctrlc` found decides in doubt.
        let of_terminal: &[c_int] = if ctrlc_handles_all { &[SIGQUIT] } else { &[SIGINT, SIGHUP, SIGQUIT] };
        signals.extend(of_terminal.iter().filter(|&&signal| !is_ignored(signal).unwrap_or(!ctrlc_handles_all)));
        signals
    }

    /// A bit for each signal that is ignored, if the system tells.
    fn ignored_signals() -> Option<u64> {
        let status = fs::read_to_string("/proc/self/status").ok()?;
        let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"))?;
        u64::from_str_radix(mask.trim(), 16).ok()
    }
}

/// Makes two failures errors, each with one line and exit code 2, which would end the program by a signal.
pub(super) fn fail_without_dumps() {
    #[cfg(unix)]
    {
        use std::sync::Arc;
        use std::sync::atomic::AtomicBool;

        use signal_hook::consts::{SIGABRT, SIGXFSZ};
        use signal_hook::flag;

        // A file that becomes larger than the limit: with a handler, the write fails. Without one, the program ends
        // and leaves a temporary file.
        let _ = flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)));
        // No memory left: the standard library prints a line and aborts.
        let _ = flag::register_conditional_shutdown(SIGABRT, 2, Arc::new(AtomicBool::new(true)));
    }
}
