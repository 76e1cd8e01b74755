//! The errors that the study measures depend on nothing but the seed: they are equal from run to run, for any number of
//! threads, and in every build, native or baseline, in which the kernel exists.
//!
//! `accuracy.expected` pins them, as one hash per kernel and workload. After a change that is meant to change errors,
//! rewrite it with `RAYLANES_BLESS=1 cargo test --test accuracy`; the difference tells which workloads changed.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use raylanes::geom::{Aabb, Placed, Quadric, Triangle};
use raylanes::study::accuracy::Kernels;
use raylanes::study::workload::{Subject, Workload};
use raylanes::tracer::thread_pool;
use serde::Serialize;

const RAYS: u64 = 2_048;

/// FNV-1a of the rows as JSON, which tells all of every float.
fn hash(rows: &[impl Serialize]) -> u64 {
    let json = serde_json::to_string(rows).unwrap();
    json.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3))
}

/// `kernel workload` → hash.
type Hashes = BTreeMap<String, u64>;

fn measure<S: Subject>(seed: u64, hashes: &mut Hashes) {
    let kernels = Kernels::<S>::registered();
    let mut note = |name: &str, rows: Vec<Vec<_>>| {
        for (index, kernel) in kernels.iter().enumerate() {
            let own: Vec<_> = rows.iter().map(|rows| &rows[index]).collect();
            hashes.insert(format!("{} {name}", kernel.id), hash(&own));
        }
    };
    for workload in Workload::ALL {
        note(workload.name(), vec![kernels.on_workload(workload, RAYS, seed)]);
    }
    for regime in S::REGIMES {
        let steps = regime.steps.iter();
        note(regime.name, steps.map(|&severity| kernels.on_regime(regime, severity, RAYS, seed)).collect());
    }
    for map in S::MAPS {
        for (kernel, cells) in kernels.iter().zip(kernels.on_map(map, 32, seed).1) {
            hashes.insert(format!("{} {}", kernel.id, map.name), hash(&cells.t_ulp_p99));
        }
    }
}

fn measured(threads: usize, seed: u64) -> Hashes {
    thread_pool(threads).unwrap().install(|| {
        let mut hashes = Hashes::new();
        measure::<Triangle>(seed, &mut hashes);
        measure::<Aabb>(seed, &mut hashes);
        measure::<Quadric>(seed, &mut hashes);
        measure::<Placed<Triangle>>(seed, &mut hashes);
        measure::<Placed<Aabb>>(seed, &mut hashes);
        measure::<Placed<Quadric>>(seed, &mut hashes);
        hashes
    })
}

#[test]
fn accuracy_depends_on_nothing_but_the_seed() {
    let hashes = measured(2, 3);
    assert_eq!(hashes, measured(1, 3), "threads change the errors");
    let others = measured(2, 4);
    assert!(
        hashes.iter().filter(|(key, hash)| others[*key] == **hash).count() < hashes.len() / 4,
        "the seed is not used"
    );

    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/accuracy.expected");
    let text = std::fs::read_to_string(&file).unwrap_or_default();
    let mut pinned: Hashes = text
        .lines()
        .map(|line| {
            let (key, hash) = line.rsplit_once(' ').expect("a line is kernel, workload and hash");
            (key.to_owned(), u64::from_str_radix(hash, 16).expect("hashes are hexadecimal"))
        })
        .collect();
    if std::env::var_os("RAYLANES_BLESS").is_some() {
        // What this build has not keeps its line.
        pinned.extend(hashes);
        let lines = pinned.iter().fold(String::new(), |mut text, (key, hash)| {
            writeln!(text, "{key} {hash:016x}").unwrap();
            text
        });
        std::fs::write(file, lines).unwrap();
        return;
    }
    let changed: Vec<_> =
        hashes.iter().filter(|(key, hash)| pinned.get(*key) != Some(hash)).map(|(key, _)| key).collect();
    assert!(changed.is_empty(), "errors changed, or are new, in this build: {changed:#?}");
}
