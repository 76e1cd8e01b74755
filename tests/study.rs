//! The study covers every registered kernel, and kernels keep what they claim.

use std::collections::BTreeSet;

use raylanes::geom::Shape;
use raylanes::kernels::{Claim, Kernel};
use raylanes::registry::{self, Visitor};
use raylanes::study::record::Record;
use raylanes::study::workload::{Subject, Workload};
use raylanes::study::{self, Options, accuracy};
use raylanes::tracer::{SceneSource, thread_pool};

#[derive(Default)]
struct Ids(BTreeSet<String>);

impl<S: Shape> Visitor<S> for Ids {
    fn visit<K: Kernel<Shape = S>>(&mut self) {
        self.0.insert(K::INFO.id.to_string());
    }
}

#[test]
fn every_kernel_is_measured_and_charted() {
    let scenes = vec![SceneSource::parse("room:small").unwrap()];
    let record = study::run(&Options { scenes, quick: true, seed: 1 }).unwrap();
    let mut ids = Ids::default();
    registry::all(&mut ids);
    for id in &ids.0 {
        assert_eq!(record.kernels.iter().filter(|row| row.id == *id).count(), 1, "{id}");
        // Three faces, one and two threads; two workloads.
        assert_eq!(record.speed.iter().filter(|row| row.id == *id).count(), 6, "{id}");
        assert_eq!(record.accuracy.iter().filter(|row| row.id == *id).count(), 2, "{id}");
    }
    assert!(record.speed.iter().all(|row| row.ns_per_test > 0.0 && row.ns_per_test.is_finite()));
    assert!(record.accuracy.iter().all(|row| row.rays >= 2_000 && row.exact_hits > 0 && row.exact_misses > 0));
    // Primary and shadow rays, two modes, one and two threads.
    assert_eq!(record.tracer.len(), 8);

    let folder = std::env::temp_dir().join(format!("raylanes-study-{}", std::process::id()));
    study::write(&record, &folder).unwrap();
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    assert!(serde_json::from_str::<Record>(&read("results.json")).unwrap() == record, "JSON loses something");
    let (report, chart) = (read("report.md"), read("speed-accuracy.svg"));
    for id in &ids.0 {
        assert!(report.contains(id.as_str()), "{id} is not in the report");
        assert!(chart.contains(id.rsplit('/').next().unwrap()), "{id} is not in the chart");
    }
    std::fs::remove_dir_all(folder).unwrap();
}

/// Holds kernels to their claims, and looks for one that breaks each, without which a claim would say nothing.
#[derive(Default)]
struct Claims {
    kept: u32,
    broken_by_others: u32,
}

impl<S: Subject> Visitor<S> for Claims {
    fn visit<K: Kernel<Shape = S>>(&mut self) {
        let missed: f64 = Workload::ALL
            .into_iter()
            .map(|workload| accuracy::measure::<K>(workload, 100_000, 7))
            .map(|row| row.false_miss_per_million + row.boundary_none as f64)
            .sum();
        if K::INFO.claims.contains(&Claim::Conservative) {
            assert_eq!(missed, 0.0, "{} claims never to miss", K::INFO.id);
            self.kept += 1;
        } else {
            self.broken_by_others += u32::from(missed > 0.0);
        }
    }
}

#[test]
fn claims_are_kept_without_tolerance() {
    let mut claims = Claims::default();
    registry::boxes(&mut claims);
    assert_eq!((claims.kept, claims.broken_by_others), (1, 3 + u32::from(cfg!(fused))));
}

#[test]
fn accuracy_depends_on_nothing_but_the_seed() {
    use raylanes::kernels::triangle::MollerTrumbore;

    let measure = |threads, seed| {
        let pool = thread_pool(threads).unwrap();
        pool.install(|| accuracy::measure::<MollerTrumbore<f32>>(Workload::Edge, 20_000, seed))
    };
    assert_eq!(measure(1, 3), measure(2, 3));
    assert_ne!(measure(1, 3), measure(1, 4));
}
