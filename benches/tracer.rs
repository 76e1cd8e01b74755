//! Traces whole pictures: built-in scenes × every triangle kernel × mode × one and two threads, closest hit and any
//! hit.
//!
//! Modes differ in how they walk the tree, and the walk is the same for all kernels. So all four modes run only for the
//! watertight default kernel and for Möller–Trumbore; the other kernels run in modes single and auto. CI runs
//! everything once, and would take nearly twice as long with all modes.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use raylanes::geom::{Ray, Triangle};
use raylanes::kernels::Kernel;
use raylanes::kernels::triangle::MollerTrumbore;
use raylanes::registry::{self, Visitor};
use raylanes::study::TracerKernel;
use raylanes::tracer::{LoadedScene, Mode, Scene, SceneSource, World, occluded, thread_pool, trace};

const SIZE: u32 = 256;

struct Pictures<'a> {
    criterion: &'a mut Criterion,
    name: &'a str,
    world: &'a World,
    rays: &'a [Ray<f32>],
}

impl Visitor<Triangle> for Pictures<'_> {
    fn visit<K: Kernel<Shape = Triangle>>(&mut self) {
        let scene = Scene::<K>::new(self.world.clone());
        let mut group = self.criterion.benchmark_group(format!("{}/{}", self.name, K::INFO.id));
        let every_mode =
            [<TracerKernel as Kernel>::INFO.id, <MollerTrumbore<f32> as Kernel>::INFO.id].contains(&K::INFO.id);
        let modes = if every_mode { &Mode::ALL[..] } else { &[Mode::Single, Mode::Auto] };
        group.throughput(Throughput::Elements(self.rays.len() as u64));
        for threads in [1, 2] {
            let pool = thread_pool(threads).expect("a pool of two threads can be made");
            for &mode in modes {
                for any_hit in [false, true] {
                    let what = if any_hit { "any_hit" } else { "closest_hit" };
                    group.bench_function(BenchmarkId::new(format!("{}/{what}", mode.name()), threads), |timer| {
                        if any_hit {
                            timer.iter(|| pool.install(|| occluded(&scene, self.rays, mode)));
                        } else {
                            timer.iter(|| pool.install(|| trace(&scene, self.rays, mode)));
                        }
                    });
                }
            }
        }
    }
}

fn pictures(criterion: &mut Criterion) {
    for name in ["room", "terrain:1e5", "sphere"] {
        let source = SceneSource::parse(name).expect("this is a built-in scene");
        let LoadedScene { world, view, .. } = source.load().expect("a built-in scene needs no file");
        let rays = view.camera(SIZE, SIZE).rays(SIZE, SIZE);
        registry::triangles(&mut Pictures { criterion: &mut *criterion, name, world: &world, rays: &rays });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10).measurement_time(std::time::Duration::from_secs(1));
    targets = pictures
}
criterion_main!(benches);
