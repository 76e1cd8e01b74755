//! Times all contenders in turn on the same rays, and compares their hits with ours.

use std::time::Instant;

use rayon::ThreadPool;

use super::contender::Contender;
#[cfg(feature = "peers")]
use super::contender::{ours, plain_mesh};
#[cfg(feature = "peers")]
use super::crates::rust_peers;
use crate::geom::Hit;
#[cfg(feature = "peers")]
use crate::study::TracerKernel;
use crate::study::measure::ray_sets::RaySet;
#[cfg(feature = "peers")]
use crate::study::measure::ray_sets::ray_sets;
use crate::study::measure::stats::{mad, median};
use crate::study::record::{Disagreements, OURS, PeerRow};
use crate::tracer::{Error, SceneSource, checksum};
#[cfg(feature = "peers")]
use crate::tracer::{LoadedScene, Scene, thread_pool};

/// Traces a set of rays with every contender in turn, each on its pool, in `rounds` rounds after a warm-up. A change of
/// the clock rate, or other work on the machine, affects all of them equally. Only the tracing is timed. Hits are
/// compared with those of the first contender, which must be ours.
///
/// # Errors
/// If two contenders of this crate disagree about a hit, or if any contender gives different hits in two rounds.
pub fn measure(
    (scene, triangles): (&str, usize),
    set: &RaySet,
    contenders: &[(&Contender, &ThreadPool)],
    rounds: usize,
) -> Result<Vec<PeerRow>, Error> {
    let mut hits = vec![Hit::MISS; set.rays.len()];
    let mut reference = None;
    let mut rows = Vec::<PeerRow>::new();
    // Round 0 is the warm-up.
    for round in 0..=rounds {
        for (number, (contender, pool)) in contenders.iter().enumerate() {
            // Overwrite the hits of the tracer before: a tracer that skips a ray must not inherit its hit.
            hits.fill(Hit { mask: true, t: f32::NAN, ..Hit::MISS });
            let start = Instant::now();
            pool.install(|| contender.scene.trace(&set.rays, set.any_hit, &mut hits));
            let mrays = set.rays.len() as f64 / start.elapsed().as_secs_f64() / 1e6;
            let checksum = format!("{:016x}", checksum(&hits));
            if round > 0 {
                rows[number].mrays_of_rounds.push(mrays);
            } else {
                let reference = reference.get_or_insert_with(|| hits.clone());
                rows.push(PeerRow {
                    scene: scene.into(),
                    triangles,
                    rays: set.name.into(),
                    ray_count: set.rays.len(),
                    hits: hits.iter().filter(|hit| hit.mask).count(),
                    tracer: contender.tracer.into(),
                    configuration: contender.configuration.clone(),
                    watertight: contender.watertight,
                    threads: pool.current_num_threads(),
                    mrays_per_second: f64::NAN,
                    mrays_per_second_mad: f64::NAN,
                    mrays_of_rounds: Vec::new(),
                    disagreements: Disagreements::between(reference, &hits, set.any_hit),
                    build_seconds: contender.build_seconds,
                    bytes_per_triangle: contender.bytes.map(|bytes| bytes as f64 / triangles as f64),
                    checksum: checksum.clone(),
                });
            }
            let expected = &rows[if contender.tracer == OURS { 0 } else { number }].checksum;
            if checksum != *expected {
                return Err(Error::Disagreement(format!("{scene}, {} rays, {contender:?}", set.name)));
            }
        }
    }
    for row in &mut rows {
        row.mrays_per_second = median(&row.mrays_of_rounds);
        row.mrays_per_second_mad = mad(&row.mrays_of_rounds);
    }
    Ok(rows)
}

/// Compares all our modes with the peers that are crates on one scene, with one thread. Returns no rows if the scene is
/// more than one mesh.
///
/// # Errors
/// If the scene cannot be loaded, if hits differ that must be identical, or if this build has no peers.
#[cfg(feature = "peers")]
pub(crate) fn compare(source: &SceneSource, size: u32, seed: u64, rounds: usize) -> Result<Vec<PeerRow>, Error> {
    let LoadedScene { world, view, .. } = source.load()?;
    let start = Instant::now();
    let scene = Scene::<TracerKernel>::new(world);
    let build_seconds = start.elapsed().as_secs_f64();
    let Some(mesh) = plain_mesh(scene.world()) else { return Ok(Vec::new()) };
    let pool = thread_pool(1)?;
    let all: Vec<_> = ours(&scene, build_seconds).into_iter().chain(rust_peers(mesh)).collect();
    let contenders: Vec<_> = all.iter().map(|contender| (contender, &pool)).collect();
    let mut rows = Vec::new();
    for set in ray_sets(&scene, &view, size, seed) {
        rows.extend(measure((&source.name(), mesh.len()), &set, &contenders, rounds)?);
    }
    Ok(rows)
}

#[cfg(not(feature = "peers"))]
pub(crate) fn compare(_: &SceneSource, _: u32, _: u64, _: usize) -> Result<Vec<PeerRow>, Error> {
    available().map(|()| Vec::new())
}

/// Checks that this build has peers.
///
/// # Errors
/// If it has none. The message says how to build with peers.
pub fn available() -> Result<(), Error> {
    if cfg!(feature = "peers") {
        return Ok(());
    }
    let message =
        "this build has no peers; build it with the feature: cargo run --release --features peers -- study --peers";
    Err(Error::Argument { argument: "--peers".into(), message: message.into() })
}

#[cfg(test)]
mod timing_tests {
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::super::contender::Tracer;
    use super::*;
    use crate::geom::Ray;
    use crate::tracer::thread_pool;

    /// A tracer whose calls report a hit of these primitives, one after the other.
    struct FakeTracer(Vec<u32>, AtomicU32);

    impl Tracer for FakeTracer {
        fn trace(&self, _: &[Ray<f32>], _: bool, hits: &mut [Hit<f32>]) {
            let call = self.1.fetch_add(1, Ordering::Relaxed) as usize;
            hits.fill(Hit { primitive: self.0[call % self.0.len()], ..Hit::<f32>::new(true, 1.0, 0.0, 0.0) });
        }
    }

    fn contender(tracer: &'static str, primitives: &[u32]) -> Contender<'static> {
        Contender {
            tracer,
            configuration: "fake".into(),
            watertight: false,
            build_seconds: 0.5,
            bytes: Some(1000),
            scene: Box::new(FakeTracer(primitives.into(), AtomicU32::new(0))),
        }
    }

    #[test]
    fn a_tracer_that_contradicts_itself_or_a_mode_of_ours_is_an_error() {
        let pool = thread_pool(1).unwrap();
        let set = RaySet { name: "primary", any_hit: false, rays: vec![Ray::INACTIVE; 3] };
        let measured = |contenders: &[Contender]| {
            let contenders: Vec<_> = contenders.iter().map(|contender| (contender, &pool)).collect();
            measure(("fake", 10), &set, &contenders, 4)
        };
        let rows = measured(&[contender(OURS, &[1]), contender(OURS, &[1]), contender("other", &[2])]).unwrap();
        let differing: Vec<_> = rows.iter().map(|row| row.disagreements.ties).collect();
        assert_eq!(differing, [0, 0, 3]);
        for row in &rows {
            assert_eq!((row.hits, row.mrays_of_rounds.len(), row.bytes_per_triangle), (3, 4, Some(100.0)));
            assert!(row.mrays_per_second > 0.0 && row.mrays_per_second_mad >= 0.0);
        }
        for wrong in [contender(OURS, &[2]), contender(OURS, &[1, 1, 1, 2]), contender("other", &[2, 2, 2, 3])] {
            let error = measured(&[contender(OURS, &[1]), wrong]).unwrap_err().to_string();
            assert!(error.starts_with("hits differ: fake, primary rays, "), "{error}");
        }
    }
}

#[cfg(all(test, feature = "peers"))]
mod peer_tests {
    use super::*;
    use crate::tracer::{Mode, trace};

    #[test]
    fn every_peer_reports_our_hits_up_to_rounding() {
        let source = SceneSource::parse("terrain:1e3").unwrap();
        let rows = compare(&source, 64, 7, 1).unwrap();
        assert_eq!(rows.len(), 4 * (Mode::ALL.len() + 7), "four sets of rays, all our modes and seven peers");
        for row in &rows {
            let Disagreements { only_first, only_second, other_primitive, ties } = row.disagreements;
            assert!(row.hits > 0 && row.mrays_per_second > 0.0, "{row:?}");
            if row.tracer == OURS {
                assert_eq!(row.disagreements, Disagreements::default(), "{row:?}");
            }
            // Tracers may differ on rays along an edge, and on rays that leave a surface at a grazing angle.
            assert!(only_first + only_second + other_primitive <= row.ray_count / 500, "{row:?}");
            assert!(ties <= row.ray_count / 100, "{row:?}");
        }
    }

    #[test]
    fn all_peers_agree_on_the_meaning_of_u_and_v() {
        let LoadedScene { world, view, .. } = SceneSource::parse("terrain:1e3").unwrap().load().unwrap();
        let scene = Scene::<TracerKernel>::new(world);
        let [primary, ..] = ray_sets(&scene, &view, 64, 7);
        let reference = trace(&scene, &primary.rays, Mode::Scalar);
        for peer in rust_peers(plain_mesh(scene.world()).unwrap()) {
            let mut hits = vec![Hit::MISS; reference.len()];
            peer.scene.trace(&primary.rays, false, &mut hits);
            let both = reference.iter().zip(&hits).filter(|(a, b)| a.mask && b.mask && a.primitive == b.primitive);
            assert!(both.clone().count() > 1000, "{peer:?}");
            for (a, b) in both {
                let error = (a.u - b.u).abs().max((a.v - b.v).abs()).max((a.t / b.t - 1.0).abs());
                assert!(error < 1e-3, "{peer:?}: {a:?} {b:?}");
            }
        }
    }
}
