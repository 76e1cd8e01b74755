//! Figures about peers: the fastest configuration of each tracer, ratios of speed, and whether the targets are met.

use crate::study::measure::stats::{mad, median};
use crate::study::record::{EMBREE, OURS, PeerRow, TargetRow};
use crate::tracer::Mode;

/// Whether the row is about raylanes in this mode.
pub(crate) fn is_ours(row: &PeerRow, mode: Mode) -> bool {
    row.tracer == OURS && row.configuration == mode.name()
}

/// The fastest one-thread configuration of every tracer. `set` is the rows of one scene and one set of rays. For
/// raylanes, only mode auto counts.
pub(crate) fn fastest(set: &[PeerRow]) -> Vec<&PeerRow> {
    let mut fastest: Vec<&PeerRow> = Vec::new();
    for row in set.iter().filter(|row| row.threads == 1 && (row.tracer != OURS || is_ours(row, Mode::Auto))) {
        match fastest.iter_mut().find(|other| other.tracer == row.tracer) {
            Some(other) if other.mrays_per_second >= row.mrays_per_second => {}
            Some(other) => *other = row,
            None => fastest.push(row),
        }
    }
    fastest
}

/// What mode auto of raylanes is compared with: the fastest configuration of this kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Against {
    Embree,
    WatertightEmbree,
    Rust,
    Scalar,
    OneThread,
}

/// A ratio that is required, and a more ambitious one.
struct Target {
    against: Against,
    least: f64,
    aim: f64,
}

const fn target(against: Against, least: f64, aim: f64) -> Target {
    Target { against, least, aim }
}

/// Targets for coherent rays: those with similar origins and directions.
const COHERENT: [Target; 4] = [
    target(Against::Embree, 1.5, 2.0),
    target(Against::Rust, 2.0, 2.0),
    target(Against::Scalar, 6.0, 6.0),
    target(Against::OneThread, 1.9, 1.9),
];

/// Targets for incoherent rays.
const INCOHERENT: [Target; 5] = [
    target(Against::WatertightEmbree, 1.2, 1.2),
    target(Against::Embree, 1.0, 1.2),
    target(Against::Rust, 2.0, 2.0),
    target(Against::Scalar, 2.0, 2.0),
    target(Against::OneThread, 1.9, 1.9),
];

/// Allowed growth of the time per ray for ten times as many triangles, once the scene is larger than the caches.
const GROWTH: f64 = 1.35;

impl Against {
    fn describe(self) -> &'static str {
        match self {
            Self::Embree => "Embree, best",
            Self::WatertightEmbree => "Embree, best watertight",
            Self::Rust => "Rust peers, best",
            Self::Scalar => "raylanes, scalar",
            Self::OneThread => "raylanes, 2 threads against 1",
        }
    }

    fn includes(self, row: &PeerRow) -> bool {
        row.threads == 1
            && match self {
                Self::Embree => row.tracer == EMBREE,
                Self::WatertightEmbree => row.tracer == EMBREE && row.watertight,
                Self::Rust => row.tracer != EMBREE && row.tracer != OURS,
                Self::Scalar => is_ours(row, Mode::Scalar),
                Self::OneThread => is_ours(row, Mode::Auto),
            }
    }
}

/// Rays per second of one configuration over those of another. The ratio is formed within each round. Returns the
/// median of the ratios, and their median absolute deviation.
pub fn ratio(of: &PeerRow, to: &PeerRow) -> (f64, f64) {
    let ratios: Vec<f64> = of.mrays_of_rounds.iter().zip(&to.mrays_of_rounds).map(|(of, to)| of / to).collect();
    (median(&ratios), mad(&ratios))
}

/// Judges mode auto of raylanes by every target, for each scene and set of rays. A target stays open if none of its
/// peers took part. `cache_bytes` is the size of the last-level cache, if known.
pub fn judge(rows: &[PeerRow], cache_bytes: Option<u64>) -> Vec<TargetRow> {
    let mut judged = Vec::new();
    for set in rows.chunk_by(|a, b| a.scene == b.scene && a.rays == b.rays) {
        let ours = |threads| set.iter().find(|row| is_ours(row, Mode::Auto) && row.threads == threads);
        let coherent = ["primary", "shadow"].contains(&set[0].rays.as_str());
        for Target { against, least, aim } in if coherent { &COHERENT[..] } else { &INCOHERENT[..] } {
            let fastest = |a: &&PeerRow, b: &&PeerRow| a.mrays_per_second.total_cmp(&b.mrays_per_second);
            let peer = set.iter().filter(|row| against.includes(row)).max_by(fastest);
            let ratio = ours(if *against == Against::OneThread { 2 } else { 1 }).zip(peer).map(|(a, b)| ratio(a, b));
            judged.push(TargetRow {
                scene: set[0].scene.clone(),
                rays: set[0].rays.clone(),
                against: against.describe().into(),
                peer: peer.map(|peer| peer.configuration.clone()),
                least: Some(*least),
                most: None,
                aim: Some(*aim),
                ratio: ratio.map(|(ratio, _)| ratio),
                ratio_mad: ratio.map(|(_, mad)| mad),
                met: ratio.map(|(ratio, _)| ratio >= *least),
            });
        }
    }
    judged.extend(growth(rows, cache_bytes));
    judged
}

/// For each scene that occurs in several sizes (`name:size`): the growth of the time per ray for ten times as many
/// triangles.
fn growth(rows: &[PeerRow], cache_bytes: Option<u64>) -> Vec<TargetRow> {
    let mut ours: Vec<&PeerRow> = rows.iter().filter(|row| is_ours(row, Mode::Auto) && row.threads == 1).collect();
    let family = |row: &PeerRow| row.scene.split_once(':').map(|(name, _)| name.to_owned());
    ours.sort_by_key(|row| (family(row), row.rays.clone(), row.triangles));
    let mut judged = Vec::new();
    for pair in ours.windows(2) {
        let [small, large] = [pair[0], pair[1]];
        if family(small).is_none() || (family(small), &small.rays) != (family(large), &large.rays) {
            continue;
        }
        let tens = libm::log10(large.triangles as f64 / small.triangles as f64);
        let cost = small.mrays_per_second / large.mrays_per_second;
        let spread = |row: &PeerRow| row.mrays_per_second_mad / row.mrays_per_second;
        let ratio = libm::pow(cost, 1.0 / tens);
        let bytes = small.bytes_per_triangle.map(|bytes| bytes * small.triangles as f64);
        let beyond_caches = bytes.zip(cache_bytes).is_none_or(|(bytes, cache)| bytes > cache as f64);
        judged.push(TargetRow {
            scene: large.scene.clone(),
            rays: large.rays.clone(),
            against: "time per ray for ten times as many triangles".into(),
            peer: Some(small.scene.clone()),
            least: None,
            most: Some(GROWTH),
            aim: None,
            ratio: Some(ratio),
            ratio_mad: Some(ratio * (spread(small) + spread(large)) / tens),
            // From a scene within the caches to one beyond them, the time must grow.
            met: beyond_caches.then_some(ratio <= GROWTH),
        });
    }
    judged
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::tests::fixture::peer_row;

    fn verdict(judged: &[TargetRow], against: Against) -> (Option<&str>, Option<f64>, Option<bool>) {
        let row = judged.iter().find(|row| row.against == against.describe()).expect("every target must be judged");
        (row.peer.as_deref(), row.ratio, row.met)
    }

    #[test]
    fn the_fastest_peer_counts_and_ratios_are_formed_within_rounds() {
        let mut rows = vec![
            peer_row(OURS, "scalar", 1, &[2.0, 2.0, 4.0]),
            peer_row(OURS, "auto", 1, &[15.0, 15.0, 30.0]),
            peer_row(OURS, "auto", 2, &[27.0, 27.0, 54.0]),
            peer_row(EMBREE, "fast", 1, &[10.0, 10.0, 20.0]),
            peer_row(EMBREE, "robust", 1, &[8.0, 8.0, 16.0]),
            peer_row(EMBREE, "robust", 2, &[99.0, 99.0, 99.0]),
            peer_row("obvhs", "Bvh2", 1, &[5.0, 5.0, 10.0]),
            peer_row("parry3d", "binned", 1, &[8.0, 8.0, 16.0]),
        ];
        rows[4].watertight = true;
        let judged = judge(&rows, None);
        assert_eq!(verdict(&judged, Against::Embree), (Some("fast"), Some(1.5), Some(true)));
        assert_eq!(verdict(&judged, Against::Rust), (Some("binned"), Some(1.875), Some(false)));
        assert_eq!(verdict(&judged, Against::Scalar), (Some("scalar"), Some(7.5), Some(true)));
        assert_eq!(verdict(&judged, Against::OneThread), (Some("auto"), Some(1.8), Some(false)));
        assert_eq!(judged.len(), COHERENT.len());

        rows.iter_mut().for_each(|row| row.rays = "bounce".into());
        let judged = judge(&rows, None);
        assert_eq!(verdict(&judged, Against::WatertightEmbree), (Some("robust"), Some(1.875), Some(true)));
        assert_eq!(verdict(&judged, Against::Embree), (Some("fast"), Some(1.5), Some(true)));

        rows.retain(|row| row.tracer == OURS);
        assert_eq!(verdict(&judge(&rows, None), Against::Embree), (None, None, None));
    }

    #[test]
    fn growth_is_per_factor_of_ten_and_judged_only_beyond_the_caches() {
        let of_size = |scene: &str, triangles, mrays| {
            let mut row = peer_row(OURS, "auto", 1, &[mrays]);
            (row.scene, row.triangles, row.bytes_per_triangle) = (scene.into(), triangles, Some(100.0));
            row
        };
        let rows = [
            of_size("terrain:1e6", 1_000_000, 4.0),
            of_size("terrain:1e4", 10_000, 9.0),
            of_size("terrain:1e7", 10_000_000, 2.0),
            of_size("bunny.obj", 70_000, 1.0),
        ];
        let grown: Vec<_> = growth(&rows, Some(50_000_000))
            .into_iter()
            .map(|row| (row.scene, row.peer.unwrap(), row.ratio.unwrap(), row.met))
            .collect();
        assert_eq!(grown.len(), 2);
        assert_eq!((&*grown[0].0, &*grown[0].1, grown[0].3), ("terrain:1e6", "terrain:1e4", None));
        assert!((grown[0].2 - 1.5).abs() < 1e-12, "{grown:?}");
        assert_eq!(
            (&*grown[1].0, &*grown[1].1, grown[1].2, grown[1].3),
            ("terrain:1e7", "terrain:1e6", 2.0, Some(false))
        );
    }
}
