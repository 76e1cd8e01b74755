//! Describes the machine that the study runs on, and the build of the program.

use crate::study::record::Machine;

/// Crates whose code is measured.
const MEASURED: [&str; 4] = ["glam", "wide", "rayon", "dashu-int"];

/// Crates of peers whose code is measured in a comparison, in addition to those.
pub(crate) const PEERS: [&str; 3] = ["bvh", "obvhs", "parry3d"];

/// Describes this machine and this build.
pub fn describe() -> Machine {
    let mut target_features: Vec<_> =
        env!("RAYLANES_TARGET_FEATURES").split(',').filter(|name| !name.is_empty()).map(String::from).collect();
    target_features.sort();
    Machine {
        cpu: cpu(),
        first_level_cache_bytes: first_level_cache_bytes(),
        processors: std::thread::available_parallelism().map_or(1, usize::from),
        os: std::env::consts::OS.into(),
        target: env!("RAYLANES_TARGET").into(),
        target_features,
        rustc: env!("RAYLANES_RUSTC").into(),
        versions: [format!("raylanes {}", env!("CARGO_PKG_VERSION"))].into_iter().chain(versions(&MEASURED)).collect(),
    }
}

/// `name version` of each crate, from the lock file at build time.
pub(crate) fn versions(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| version(include_str!("../../../Cargo.lock"), name)).collect()
}

/// Bytes of the largest cache of the first processor; `None` if the system does not say.
pub(crate) fn cache_bytes() -> Option<u64> {
    (0..8).filter_map(bytes_of_cache).max()
}

/// Bytes of the first-level data cache of the first processor; `None` if the system does not say.
fn first_level_cache_bytes() -> Option<u64> {
    let is_it = |&index: &u32| {
        about_cache(index, "level").as_deref() == Some("1")
            && about_cache(index, "type").is_some_and(|kind| ["Data", "Unified"].contains(&kind.as_str()))
    };
    (0..8).find(is_it).and_then(bytes_of_cache)
}

fn bytes_of_cache(index: u32) -> Option<u64> {
    let kilobytes: u64 = about_cache(index, "size")?.strip_suffix('K')?.parse().ok()?;
    Some(kilobytes * 1024)
}

/// What the system says about a cache of the first processor.
fn about_cache(index: u32, what: &str) -> Option<String> {
    let text = std::fs::read_to_string(format!("/sys/devices/system/cpu/cpu0/cache/index{index}/{what}")).ok()?;
    Some(text.trim().to_owned())
}

/// The processor's name, with family and model number if the system gives them: virtual machines often shorten the
/// name.
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

/// `name version` of a crate in a lock file; `name unknown` if it is not there.
fn version(lock: &str, name: &str) -> String {
    let package = |name: &str| lock.split("[[package]]").find(|text| text.contains(&format!("\nname = \"{name}\"\n")));
    // The lock file may list several versions of a crate. Ours is the one in our own list of dependencies.
    let start = format!("\"{name} ");
    let ours = package(env!("CARGO_PKG_NAME")).and_then(|text| text.split(&start).nth(1));
    let only = || package(name)?.split("version = \"").nth(1);
    let version = ours.or_else(only).and_then(|text| text.split('"').next());
    format!("{name} {}", version.unwrap_or("unknown"))
}

/// One line of advice if the build is slower than it could be: built without AVX2 on a processor that has it. Else
/// `None`.
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
    fn versions_are_read_from_the_lock_file() {
        let package =
            |name: &str, version: &str| format!("[[package]]\nname = \"{name}\"\nversion = \"{version}\"\n\n");
        let lock = [package("glam", "1.1.0"), package("glam", "1.2.3"), package("wide", "4.5.6")].concat()
            + "[[package]]\nname = \"raylanes\"\ndependencies = [\n \"glam 1.2.3\",\n \"wide\",\n]\n";
        let found = ["glam", "wide", "obvhs"].map(|name| version(&lock, name));
        assert_eq!(found, ["glam 1.2.3", "wide 4.5.6", "obvhs unknown"]);
        let all = [describe().versions, versions(&PEERS)].concat();
        assert!(all.len() > 7 && all.iter().all(|version| !version.ends_with("unknown")), "{all:?}");
    }
}
