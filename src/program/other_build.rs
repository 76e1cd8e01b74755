//! Builds the program once more, for other processors, so that a study can time both builds.
//!
//! Programs that are given to others are built for many processors, and this one for the processor that it runs on. The
//! difference in speed is of interest, and it can be measured only side by side.

use std::env;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use raylanes::study::{OtherBuild, Progress};
use raylanes::tracer::Error;

use super::args::Level;

/// Builds the program for processors of this level, into a folder of its own beside this build. A build that is up to
/// date is used as it is.
///
/// # Errors
/// If cargo did not start this program, if this is no x86-64 processor, or if the build fails.
pub(super) fn make(level: Level, progress: &Progress) -> Result<OtherBuild, Error> {
    let target = level.target_cpu();
    let refused = |message: String| Error::Argument { argument: "--build".into(), message };
    if cfg!(not(target_arch = "x86_64")) {
        return Err(refused(format!("{target} is for x86-64 processors, and this one is {}", env::consts::ARCH)));
    }
    let by_cargo = |name| env::var_os(name).map(PathBuf::from);
    let Some((cargo, package)) = by_cargo("CARGO").zip(by_cargo("CARGO_MANIFEST_DIR")) else {
        return Err(refused("start the study with cargo: cargo run --release -- study --build ...".into()));
    };
    progress.note(&format!("building for {target}"));
    let folder = package.join("target").join(target);
    let output = command(&cargo, &package, &folder, target).output().map_err(|source| Error::Io {
        action: "start",
        file: cargo.clone(),
        source,
    })?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        let line = said.lines().find(|line| line.starts_with("error")).unwrap_or("no reason given");
        return Err(refused(format!("cargo cannot build for {target}: {line}")));
    }
    let program = folder.join("release").join(format!("raylanes{}", env::consts::EXE_SUFFIX));
    Ok(OtherBuild { target: target.into(), program })
}

fn command(cargo: &Path, package: &Path, folder: &Path, target: &str) -> Command {
    let mut command = Command::new(cargo);
    command.args(["build", "--release", "--locked", "--bin", "raylanes"]);
    command.arg("--manifest-path").arg(package.join("Cargo.toml")).arg("--target-dir").arg(folder);
    // The encoded variable would come before the plain one.
    command.env_remove("CARGO_ENCODED_RUSTFLAGS").env_remove("CARGO_BUILD_TARGET");
    command.env("RUSTFLAGS", format!("-C target-cpu={target}")).stdin(Stdio::null());
    command
}
