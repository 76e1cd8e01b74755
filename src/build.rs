//! Build script. Passes the compiler version, the target and its features to the crate, because every record states
//! them. Sets `cfg(fused)` where multiply-add is fused.

use std::env;
use std::process::Command;

fn main() {
    let rustc = env::var("RUSTC").unwrap_or_else(|_| "rustc".into());
    let version = Command::new(rustc).arg("--version").output().ok().and_then(|out| String::from_utf8(out.stdout).ok());
    println!("cargo::rustc-env=RAYLANES_RUSTC={}", version.as_deref().unwrap_or("unknown").trim());
    for (name, source) in [("RAYLANES_TARGET", "TARGET"), ("RAYLANES_TARGET_FEATURES", "CARGO_CFG_TARGET_FEATURE")] {
        println!("cargo::rustc-env={name}={}", env::var(source).unwrap_or_default());
    }
    // Whether the multiply-add of `wide` is fused, for eight lanes and for four. These are the conditions of `wide`;
    // see `geom::lanes`.
    let list = |name: &str| env::var(name).unwrap_or_default();
    let has = |feature: &str| list("CARGO_CFG_TARGET_FEATURE").split(',').any(|name| name == feature);
    println!("cargo::rustc-check-cfg=cfg(fused)");
    if match list("CARGO_CFG_TARGET_ARCH").as_str() {
        "x86" | "x86_64" => has("avx") && has("fma"),
        "aarch64" => has("neon"),
        _ => false,
    } {
        println!("cargo::rustc-cfg=fused");
    }
    println!("cargo::rerun-if-changed=src/build.rs");
}
