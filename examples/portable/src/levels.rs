//! Ships a program for every x86-64 processor as two builds that lie beside each other: `NAME` runs everywhere,
//! `NAME-v3` where there are AVX2 and FMA.
//!
//! `wide` chooses its instructions at compile time, so one build cannot choose at run time. A library for each level,
//! loaded at run time, would need `unsafe`. Starting another program does not.

use std::env::{self, consts::EXE_SUFFIX};
use std::io::{Error, ErrorKind};
use std::process::Command;

/// Whether this is the build for `x86-64-v3` or above.
pub(crate) const IS_V3: bool = cfg!(all(
    target_arch = "x86_64",
    target_feature = "avx2",
    target_feature = "bmi1",
    target_feature = "bmi2",
    target_feature = "f16c",
    target_feature = "fma",
    target_feature = "lzcnt",
    target_feature = "movbe",
));

/// Whether the processor and the operating system can run that build.
#[cfg(target_arch = "x86_64")]
fn can_run_v3() -> bool {
    is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("bmi1")
        && is_x86_feature_detected!("bmi2")
        && is_x86_feature_detected!("f16c")
        && is_x86_feature_detected!("fma")
        && is_x86_feature_detected!("lzcnt")
        && is_x86_feature_detected!("movbe")
}

#[cfg(not(target_arch = "x86_64"))]
fn can_run_v3() -> bool {
    false
}

/// Runs `NAME-v3` in place of this program, with the same arguments, and ends with its exit code. Returns if this is
/// that build, if the processor cannot run it, or if it cannot be started. Call it first in `main`.
pub(crate) fn run_best_build() {
    if IS_V3 || !can_run_v3() {
        return;
    }
    let Ok(this) = env::current_exe() else { return };
    let stem = if EXE_SUFFIX.is_empty() { this.file_name() } else { this.file_stem() };
    let mut name = stem.unwrap_or_default().to_owned();
    name.push("-v3");
    name.push(EXE_SUFFIX);
    let v3 = this.with_file_name(name);
    let error = run(Command::new(&v3).args(env::args_os().skip(1)));
    if error.kind() != ErrorKind::NotFound {
        eprintln!("{}: {error}; going on without it", v3.display());
    }
}

/// Becomes the other program. Returns only if that fails.
#[cfg(unix)]
fn run(program: &mut Command) -> Error {
    std::os::unix::process::CommandExt::exec(program)
}

/// Waits for the other program, and ends with its exit code. Returns only if it cannot be started.
#[cfg(not(unix))]
fn run(program: &mut Command) -> Error {
    match program.status() {
        Ok(status) => std::process::exit(status.code().unwrap_or(1)),
        Err(error) => error,
    }
}
