//! Times every registered kernel on every workload in each width: one test of one ray against one primitive.
//!
//! `cargo bench --bench kernels -- triangle/` runs only the IDs that contain the text.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use raylanes::geom::Hit;
use raylanes::kernels::Kernel;
use raylanes::registry::{self, Visitor};
use raylanes::study::speed::{Bench, PRIMITIVES, RAYS, Width};
use raylanes::study::workload::{Subject, Workload};

struct Benches<'a>(&'a mut Criterion);

impl<S: Subject> Visitor<S> for Benches<'_> {
    fn visit<K: Kernel<Shape = S>>(&mut self) {
        for workload in Workload::ALL {
            let mut group = self.0.benchmark_group(format!("{}/{}", K::INFO.id, workload.name()));
            group.throughput(Throughput::Elements((RAYS * PRIMITIVES) as u64));
            let bench = Bench::<K>::new(workload, 2026);
            for width in Width::ALL {
                let mut hits = vec![Hit::MISS; RAYS];
                group.bench_function(width.name(), |timer| {
                    timer.iter(|| black_box(&bench).pass(width, black_box(&mut hits)));
                });
            }
        }
    }
}

fn kernels(criterion: &mut Criterion) {
    registry::all(&mut Benches(criterion));
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20).measurement_time(std::time::Duration::from_secs(1));
    targets = kernels
}
criterion_main!(benches);
