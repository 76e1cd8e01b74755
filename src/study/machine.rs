//! What a measurement was made on, and how the program was built.

use super::record::Machine;

/// Crates whose code is inside what is measured.
const MEASURED: [&str; 5] = ["glam", "wide", "obvhs", "rayon", "dashu-int"];

/// Describes this machine and this build.
pub(crate) fn describe() -> Machine {
    let mut target_features: Vec<_> =
        env!("RAYLANES_TARGET_FEATURES").split(',').filter(|name| !name.is_empty()).map(String::from).collect();
    target_features.sort();
    Machine {
        cpu: cpu(),
        processors: std::thread::available_parallelism().map_or(1, usize::from),
        os: std::env::consts::OS.into(),
        target: env!("RAYLANES_TARGET").into(),
        target_features,
        rustc: env!("RAYLANES_RUSTC").into(),
        versions: versions(include_str!("../../Cargo.lock")),
    }
}

/// The processor's name, with family and model number where the system tells them: virtual machines shorten the name.
fn cpu() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let field = |name: &str| {
        text.lines().find_map(|line| {
            let (key, value) = line.split_once(':')?;
            (key.trim() == name).then(|| value.trim())
        })
    };
    match (field("model name"), field("cpu family"), field("model")) {
        (Some(name), Some(family), Some(model)) => format!("{name} (family {family}, model {model})"),
        (Some(name), ..) => name.into(),
        _ => format!("unknown {}", std::env::consts::ARCH),
    }
}

/// `name version` of this crate and of the measured ones, from the lock file the program was built with.
fn versions(lock: &str) -> Vec<String> {
    let mut versions = vec![format!("raylanes {}", env!("CARGO_PKG_VERSION"))];
    for name in MEASURED {
        let package = lock.split("[[package]]").find(|package| package.contains(&format!("name = \"{name}\"\n")));
        let version = package.and_then(|package| package.split("version = \"").nth(1)?.split('"').next());
        versions.push(format!("{name} {}", version.unwrap_or("unknown")));
    }
    versions
}

/// One line of advice where the build leaves speed on the table, else `None`.
pub fn build_warning() -> Option<&'static str> {
    #[cfg(target_arch = "x86_64")]
    if !cfg!(target_feature = "avx2") && std::arch::is_x86_feature_detected!("avx2") {
        return Some(
            "built without AVX2 on a processor that has it: packets run at half width or less \
             (build with RUSTFLAGS=\"-C target-cpu=native\")",
        );
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_come_from_the_lock_file() {
        let lock =
            "[[package]]\nname = \"glam\"\nversion = \"1.2.3\"\n\n[[package]]\nname = \"wide\"\nversion = \"4.5.6\"\n";
        assert_eq!(versions(lock)[1..4], ["glam 1.2.3", "wide 4.5.6", "obvhs unknown"]);
        assert!(describe().versions.iter().all(|version| !version.ends_with("unknown")), "{:?}", describe());
    }
}
