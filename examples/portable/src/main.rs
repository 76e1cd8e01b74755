//! Every kernel of this build on the same rays, with the checksum of its hits: equal on all targets.
//!
//! `cargo run --release -p portable`. [levels] lets the program use newer processors and still run on old ones.

mod levels;

use raylanes::geom::{Aabb, Hit, Placed, Quadric, Ray, Shape, Triangle};
use raylanes::glam::{Affine3, Mat3, Vec3};
use raylanes::kernels::{Intersect, Kernel};
use raylanes::registry::{self, Visitor};
use raylanes::wide::f32x8;

const RAYS: usize = 512;
const PRIMITIVES: usize = 64;

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
        println!("{}\t{:016x}", K::INFO.id, checksum.0);
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

fn main() {
    levels::run_best_build();
    println!("level\t{}", if levels::IS_V3 { "x86-64-v3" } else { "baseline" });
    registry::all(&mut Rows);
}
