//! Times every registered kernel on every workload in each width, on one core and on two: one test of one ray against
//! one primitive. Each core tests the same rays and writes hits of its own.
//!
//! `cargo bench --bench kernels -- triangle/` runs only the IDs that contain the text.

use std::hint::black_box;
use std::sync::Mutex;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use raylanes::geom::Hit;
use raylanes::kernels::Kernel;
use raylanes::registry::{self, Visitor};
use raylanes::study::speed::{Bench, PRIMITIVES, RAYS, Width};
use raylanes::study::workload::{Subject, Workload};
use raylanes::tracer::thread_pool;

struct Benches<'a>(&'a mut Criterion);

impl<S: Subject> Visitor<S> for Benches<'_> {
    fn visit<K: Kernel<Shape = S>>(&mut self) {
        for workload in Workload::ALL {
            let mut group = self.0.benchmark_group(format!("{}/{}", K::INFO.id, workload.name()));
            let bench = Bench::<K>::new(workload, 2026);
            for threads in [1, 2] {
                let pool = thread_pool(threads).expect("a pool of two threads can be made");
                let hits: Vec<_> = (0..threads).map(|_| Mutex::new(vec![Hit::MISS; RAYS])).collect();
                group.throughput(Throughput::Elements((threads * RAYS * PRIMITIVES) as u64));
                for width in Width::ALL {
                    let pass = |thread: usize| {
                        let mut hits = hits[thread].lock().expect("no pass panics");
                        black_box(&bench).pass(width, black_box(&mut hits));
                    };
                    group.bench_function(BenchmarkId::new(width.name(), threads), |timer| {
                        timer.iter(|| pool.broadcast(|context| pass(context.index())));
                    });
                }
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
