//! Every kernel of this build on the same rays: the checksum of its hits, which is equal on all targets, and the
//! times of a scalar and of a packet test, in nanoseconds per ray. Each ray finds its closest hit among the primitives.
//!
//! `cargo run --release -p portable`. [levels] lets the program use newer processors and still run on old ones.
//! `portable compare ROUNDS NAME=COMMAND...` runs several builds and compares them; `measure` makes them.

mod compare;
mod levels;

use std::hint::black_box;
use std::process::ExitCode;
use std::time::Instant;

use raylanes::geom::{Aabb, Hit, Placed, Quadric, Ray, Shape, Triangle};
use raylanes::glam::{Affine3, Mat3, Vec3};
use raylanes::kernels::{Intersect, Kernel};
use raylanes::registry::{self, Visitor};
use raylanes::wide::f32x8;

const RAYS: usize = 2048;
const PRIMITIVES: usize = 32;
const PASSES: usize = 9;

/// The same numbers on every target: a linear congruential generator.
struct Random(u64);

impl Random {
    fn number(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 23) as f32 - 1.0
    }

    fn point(&mut self) -> Vec3 {
        Vec3::new(self.number(), self.number(), self.number())
    }
}

trait Generate: Shape {
    fn generate(random: &mut Random) -> Self;
}

impl Generate for Aabb {
    fn generate(random: &mut Random) -> Self {
        let (a, b) = (random.point(), random.point());
        Self { lo: a.min(b), hi: a.max(b) }
    }
}

impl Generate for Triangle {
    fn generate(random: &mut Random) -> Self {
        Self { v0: random.point(), v1: random.point(), v2: random.point() }
    }
}

impl Generate for Quadric {
    fn generate(random: &mut Random) -> Self {
        Self::ellipsoid(random.point().abs() + 0.1)
    }
}

impl<S: Generate> Generate for Placed<S> {
    fn generate(random: &mut Random) -> Self {
        let matrix3 = Mat3::from_cols(random.point(), random.point(), random.point());
        Self { shape: S::generate(random), object_to_world: Affine3 { matrix3, translation: random.point() } }
    }
}

struct Rows;

impl<S: Generate> Visitor<S> for Rows {
    fn visit<K: Kernel<Shape = S>>(&mut self) {
        let mut random = Random(7);
        let primitives: Vec<K> = (0..PRIMITIVES).map(|_| K::prepare(&S::generate(&mut random))).collect();
        let rays: Vec<_> = (0..RAYS).map(|_| Ray::new(random.point() * 3.0, random.point())).collect();
        let mut checksum = Checksum(0xcbf2_9ce4_8422_2325);
        for primitive in &primitives {
            rays.iter().for_each(|ray| checksum.add(&Intersect::<f32>::hit(primitive, ray)));
            for eight in rays.chunks_exact(8) {
                let hits = Intersect::<f32x8>::hit(primitive, &Ray::from_slice(eight));
                hits.lanes().iter().for_each(|hit| checksum.add(hit));
            }
        }
        let scalar = time(|| {
            for ray in &rays {
                let (setup, mut closest) = (<K as Intersect<f32>>::setup(ray), Hit::MISS);
                for primitive in &primitives {
                    let hit = Intersect::<f32>::closest_hit(primitive, ray, &setup);
                    closest = if hit.is_closer_than(&closest) { hit } else { closest };
                }
                black_box(closest);
            }
        });
        let packet = time(|| {
            for eight in rays.chunks_exact(8) {
                let packet = Ray::from_slice(eight);
                let (setup, mut closest) = (<K as Intersect<f32x8>>::setup(&packet), Hit::<f32x8>::miss());
                for primitive in &primitives {
                    closest.keep_closer(&Intersect::<f32x8>::candidate(primitive, &packet, &setup));
                }
                black_box(closest);
            }
        });
        println!("{}\t{:016x}\t{scalar:.3}\t{packet:.3}", K::INFO.id, checksum.0);
    }
}

/// FNV-1a over the bits of hits.
struct Checksum(u64);

impl Checksum {
    fn add(&mut self, hit: &Hit<f32>) {
        for word in hit.to_bits() {
            self.0 = (self.0 ^ u64::from(word)).wrapping_mul(0x100_0000_01b3);
        }
    }
}

/// The time of the fastest pass, in nanoseconds per ray and primitive.
fn time(mut pass: impl FnMut()) -> f64 {
    let seconds = (0..PASSES).map(|_| {
        let start = Instant::now();
        pass();
        start.elapsed().as_secs_f64()
    });
    seconds.fold(f64::INFINITY, f64::min) * 1e9 / (RAYS * PRIMITIVES) as f64
}

fn main() -> ExitCode {
    levels::run_best_build();
    let arguments: Vec<_> = std::env::args().skip(1).collect();
    let outcome = match &arguments[..] {
        [] => {
            println!("# {}", if levels::IS_V3 { "x86-64-v3" } else { std::env::consts::ARCH });
            registry::all(&mut Rows);
            Ok(())
        }
        [command, rounds, builds @ ..] if command == "compare" && !builds.is_empty() => match rounds.parse() {
            Ok(rounds @ 1..) => compare::compare(rounds, builds),
            _ => Err(format!("expected a number of rounds, found '{rounds}'")),
        },
        _ => Err("expected nothing, or: compare ROUNDS NAME=COMMAND...".into()),
    };
    outcome.map_or_else(
        |error| {
            eprintln!("{error}");
            ExitCode::from(2)
        },
        |()| ExitCode::SUCCESS,
    )
}
