//! Passes on what only the compiler knows about this build, so that every record can state it.

use std::env;
use std::process::Command;

fn main() {
    let rustc = env::var("RUSTC").unwrap_or_else(|_| "rustc".into());
    let version = Command::new(rustc).arg("--version").output().ok().and_then(|out| String::from_utf8(out.stdout).ok());
    println!("cargo::rustc-env=RAYLANES_RUSTC={}", version.as_deref().unwrap_or("unknown").trim());
    for (name, source) in [("RAYLANES_TARGET", "TARGET"), ("RAYLANES_TARGET_FEATURES", "CARGO_CFG_TARGET_FEATURE")] {
        println!("cargo::rustc-env={name}={}", env::var(source).unwrap_or_default());
    }
    println!("cargo::rerun-if-changed=src/build.rs");
}
