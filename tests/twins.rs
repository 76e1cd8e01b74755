//! Tests that the scalar and the packet twin of every registered kernel give the same bits for every input: in each
//! lane, in full and partial packets, for eight rays against one primitive and one ray against eight primitives.
//!
//! There is one test per kernel. A failure names the kernel, the width, the lane and the simplest input that fails,
//! with its bits. `PROPTEST_CASES` raises the number of packets, `PROPTEST_RNG_SEED` changes the seed.

mod aim;
mod harness;

use std::fmt::{Debug, Write};
use std::process::ExitCode;
use std::sync::{Arc, LazyLock};

use libtest_mimic::Trial;
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::{Config, RngSeed, TestCaseError, TestError, TestRunner};
use raylanes::geom::{Aabb, Hit, Mask8, Placed, Quadric, Ray, Triangle};
use raylanes::kernels::{Intersect, Kernel};
use raylanes::registry::{self, Registered, Visitor};
use wide::f32x8;

use aim::{Aimed, Case};

const PACKETS: u32 = 20_000;

fn main() -> ExitCode {
    let generators = harness::test("generators_reach_what_they_promise", generators_reach_what_they_promise);
    let groups = vec![
        of_shape::<Aabb>(),
        of_shape::<Triangle>(),
        of_shape::<Quadric>(),
        of_shape::<Placed<Aabb>>(),
        of_shape::<Placed<Triangle>>(),
        of_shape::<Placed<Quadric>>(),
        vec![generators],
    ];
    harness::run(groups, registry::all)
}

/// One test for each kernel of a shape.
fn of_shape<S: Aimed + Registered>() -> Vec<Trial> {
    let mut tests = Tests { cases: Arc::new(LazyLock::new(make_cases::<S>)), trials: Vec::new() };
    S::visit_kernels(&mut tests);
    tests.trials
}

struct Tests<S> {
    /// Made once for all kernels of the shape: making the cases takes longer than checking them.
    cases: Arc<LazyLock<Vec<Case<S>>>>,
    trials: Vec<Trial>,
}

impl<S: Aimed> Visitor<S> for Tests<S> {
    fn visit<K: Kernel<Shape = S>>(&mut self) {
        let cases = self.cases.clone();
        let check = move || check_all::<K>(&cases);
        self.trials.push(harness::of_kernel("twins", K::INFO.id.to_string(), check));
    }
}

fn make_cases<S: Aimed>() -> Vec<Case<S>> {
    let (mut runner, cases) = runner();
    let strategy = aim::cases();
    (0..cases).map(|_| strategy.new_tree(&mut runner).unwrap().current()).collect()
}

/// The source of the cases, and how many of them to take.
fn runner() -> (TestRunner, u32) {
    let defaults = Config::default();
    let cases = defaults.cases.max(PACKETS);
    let rng_seed = match defaults.rng_seed {
        RngSeed::Random => RngSeed::Fixed(2026),
        fixed @ RngSeed::Fixed(_) => fixed,
    };
    (TestRunner::new(Config { cases, rng_seed, failure_persistence: None, ..defaults }), cases)
}

/// Tests and hits of one width. They show that the property did not pass on misses alone.
#[derive(Clone, Copy, Default)]
struct HitRate {
    tests: u64,
    hits: u64,
}

impl HitRate {
    fn count(&mut self, hit: &Hit<f32>) {
        self.tests += 1;
        self.hits += u64::from(hit.mask);
    }

    fn percent(self) -> f64 {
        100.0 * self.hits as f64 / self.tests as f64
    }
}

/// Checks all cases; returns the hit rates, or the simplest case that fails.
fn check_all<K: Kernel<Shape: Aimed>>(cases: &[Case<K::Shape>]) -> Result<String, String> {
    let mut rates = [HitRate::default(); 2];
    if let Some(failing) = cases.iter().position(|case| check::<K>(case, &mut rates).is_err()) {
        return Err(shrunk::<K>(failing));
    }
    let [many_rays, many_primitives] = rates.map(HitRate::percent);
    let summary = format!(
        "{}: {} packets, hits: {many_rays:.0} % of 8x1, {many_primitives:.0} % of 1x8",
        K::INFO.id,
        cases.len()
    );
    if !(15.0..=85.0).contains(&many_rays) || !(8.0..=85.0).contains(&many_primitives) {
        return Err(format!("{summary}: too many rays hit, or too many miss, to test both outcomes"));
    }
    Ok(summary)
}

/// Describes the simplest case that fails. Case number `failing` is made again, this time with the means to simplify
/// it.
fn shrunk<K: Kernel<Shape: Aimed>>(failing: usize) -> String {
    let (mut runner, _) = runner();
    let strategy = aim::cases::<K::Shape>();
    for _ in 0..failing {
        strategy.new_tree(&mut runner).unwrap();
    }
    let tree = strategy.new_tree(&mut runner).unwrap();
    let check = |case: &Case<K::Shape>| check::<K>(case, &mut Default::default());
    match runner.run_one(tree, |case| check(&case).map_err(TestCaseError::fail)) {
        // The reason that proptest kept may come from a larger case than the final one.
        Err(TestError::Fail(_, case)) => check(&case).expect_err("shrinking keeps the failure"),
        Err(TestError::Abort(reason)) => panic!("{}: aborted: {reason}", K::INFO.id),
        Ok(_) => unreachable!("the same seed makes the same cases"),
    }
}

// Not inlined: one copy of each twin instead of one per call.

#[inline(never)]
fn hit<K: Kernel>(primitive: &K, ray: &Ray<f32>) -> Hit<f32> {
    Intersect::<f32>::hit(primitive, ray)
}

#[inline(never)]
fn any_hit<K: Kernel>(primitive: &K, ray: &Ray<f32>) -> bool {
    primitive.any_hit(ray, &<K as Intersect<f32>>::setup(ray))
}

#[inline(never)]
fn hit8<K: Kernel>(primitive: &K, packet: &Ray<f32x8>) -> Hit<f32x8> {
    Intersect::<f32x8>::hit(primitive, packet)
}

#[inline(never)]
fn any_hit8<K: Kernel>(primitive: &K, packet: &Ray<f32x8>) -> Mask8 {
    primitive.any_hit(packet, &<K as Intersect<f32x8>>::setup(packet))
}

#[inline(never)]
fn hit_gathered<K: Kernel>(primitives: &K::Packet, packet: &Ray<f32x8>) -> Hit<f32x8> {
    primitives.hit(packet)
}

/// Compares the twins on one packet of rays and one packet of primitives, in every pairing.
fn check<K: Kernel>(case: &Case<K::Shape>, rates: &mut [HitRate; 2]) -> Result<(), String> {
    let primitives = case.shapes.map(|shape| K::prepare(&shape));
    let gathered = K::gather(&primitives);
    let scalar = primitives.map(|primitive| case.rays.map(|ray| hit(&primitive, &ray)));

    // Eight rays against one primitive, in every lane position.
    for shift in 0..8 {
        let source = |lane: usize| (lane + shift) % 8;
        let packet = Ray::from_lanes(&std::array::from_fn(|lane| case.rays[source(lane)]));
        let hits = hit8(&primitives[0], &packet);
        for lane in 0..8 {
            let expected = scalar[0][source(lane)];
            let width = || format!("8 rays x 1 primitive, packet turned by {shift}");
            compare::<K>(width, case, 0, source(lane), lane, expected, hits.lane(lane))?;
            if shift == 0 {
                rates[0].count(&expected);
                well_formed::<K>(case, 0, lane, &expected)?;
            }
        }
        let any = any_hit8(&primitives[0], &packet);
        if any != hits.mask {
            return Err(format!("{}: any_hit {:08b}, closest_hit {:08b}", K::INFO.id, any.bits(), hits.mask.bits()));
        }
    }

    // Partial packets.
    for active in 0..8 {
        let hits = hit8(&primitives[0], &Ray::from_slice(&case.rays[..active]));
        for (lane, hit) in scalar[0].into_iter().enumerate() {
            let expected = if lane < active { hit } else { Hit::MISS };
            let width = || format!("8 rays x 1 primitive, {active} of 8 active");
            compare::<K>(width, case, 0, lane, lane, expected, hits.lane(lane))?;
        }
    }

    // One ray against eight primitives.
    for (ray, one) in case.rays.iter().enumerate() {
        let hits = hit_gathered::<K>(&gathered, &Ray::splat(one));
        for (lane, primitive) in primitives.iter().enumerate() {
            let expected = scalar[lane][ray];
            rates[1].count(&expected);
            compare::<K>(|| "1 ray x 8 primitives".into(), case, lane, ray, lane, expected, hits.lane(lane))?;
            if any_hit(primitive, one) != expected.mask {
                return Err(format!("{}: scalar any_hit and closest_hit differ", K::INFO.id));
            }
        }
    }

    // Lane by lane.
    let hits = hit_gathered::<K>(&gathered, &Ray::from_lanes(&case.rays));
    for (lane, row) in scalar.iter().enumerate() {
        let width = || "8 rays x 8 primitives".into();
        compare::<K>(width, case, lane, lane, lane, row[lane], hits.lane(lane))?;
        let width = || "1 ray x 1 primitive taken out of 8".into();
        compare::<K>(width, case, lane, lane, lane, row[lane], hit(&K::lane(&gathered, lane), &case.rays[lane]))?;
    }
    Ok(())
}

/// Checks that a miss is [`Hit::MISS`], and that a hit contains no NaN and is within the interval.
fn well_formed<K: Kernel>(case: &Case<K::Shape>, primitive: usize, ray: usize, hit: &Hit<f32>) -> Result<(), String> {
    let Ray { t_min, t_max, .. } = case.rays[ray];
    let good = if hit.mask {
        !hit.u.is_nan() && !hit.v.is_nan() && t_min <= hit.t && hit.t <= t_max && hit.primitive == 0
    } else {
        hit.to_bits() == Hit::MISS.to_bits()
    };
    if good {
        return Ok(());
    }
    let mut text = format!("{}: malformed hit {hit:?}\n", K::INFO.id);
    describe(&mut text, &case.shapes[primitive], &case.rays[ray]);
    Err(text)
}

fn compare<K: Kernel>(
    width: impl FnOnce() -> String,
    case: &Case<K::Shape>,
    primitive: usize,
    ray: usize,
    lane: usize,
    scalar: Hit<f32>,
    packet: Hit<f32>,
) -> Result<(), String> {
    if scalar.mask == packet.mask && scalar.to_bits() == packet.to_bits() {
        return Ok(());
    }
    let mut text = format!("{}: twins differ, {}, lane {lane}\n", K::INFO.id, width());
    describe(&mut text, &case.shapes[primitive], &case.rays[ray]);
    writeln!(text, "          {:>24} {:>24}", "scalar", "packet").unwrap();
    writeln!(text, "mask      {:>24} {:>24}", scalar.mask, packet.mask).unwrap();
    for (name, a, b) in [("t", scalar.t, packet.t), ("u", scalar.u, packet.u), ("v", scalar.v, packet.v)] {
        let mark = if a.to_bits() == b.to_bits() { "" } else { "  <-" };
        writeln!(text, "{name:9} {:>24} {:>24}{mark}", decimal_and_hex(a), decimal_and_hex(b)).unwrap();
    }
    writeln!(text, "primitive {:>24} {:>24}", scalar.primitive, packet.primitive).unwrap();
    Err(text)
}

fn decimal_and_hex(value: f32) -> String {
    format!("{value:e} {:08x}", value.to_bits())
}

/// Prints ray and shape in decimal, and the ray also in bits.
fn describe(text: &mut String, shape: &impl Debug, ray: &Ray<f32>) {
    writeln!(text, "shape     {shape:?}").unwrap();
    for (name, v) in [("origin", ray.origin), ("dir", ray.dir)] {
        writeln!(text, "{name:9} {}", v.to_array().map(decimal_and_hex).join(", ")).unwrap();
    }
    writeln!(text, "interval  {}", [ray.t_min, ray.t_max].map(decimal_and_hex).join(", ")).unwrap();
}

/// The cases contain every kind of input that the generators promise: the property above is only as good as they are.
fn generators_reach_what_they_promise() {
    let mut runner = TestRunner::new(Config { rng_seed: RngSeed::Fixed(1), ..Config::default() });
    let strategy = aim::cases::<Aabb>();
    let mut seen = std::collections::BTreeMap::<&str, u32>::new();
    for _ in 0..4_000 {
        let case = strategy.new_tree(&mut runner).unwrap().current();
        let Aabb { lo, hi } = case.shapes[0];
        for ray in &case.rays {
            let numbers = [ray.origin.to_array(), ray.dir.to_array()].concat();
            let parallel_on_plane = (0..3)
                .any(|axis| ray.dir[axis] == 0.0 && (ray.origin[axis] == lo[axis] || ray.origin[axis] == hi[axis]));
            for (kind, present) in [
                ("NaN", numbers.iter().any(|x| x.is_nan())),
                ("infinity", numbers.iter().any(|x| x.is_infinite())),
                ("subnormal", numbers.iter().any(|x| x.is_subnormal())),
                ("+0 direction", (0..3).any(|axis| ray.dir[axis].to_bits() == 0)),
                ("-0 direction", (0..3).any(|axis| ray.dir[axis].to_bits() == 1 << 31)),
                ("parallel, origin on a plane", parallel_on_plane),
                ("huge", numbers.iter().any(|x| x.is_finite() && x.abs() > 1e37)),
                ("tiny", numbers.iter().any(|x| x.is_normal() && x.abs() < 1e-37)),
                ("empty interval", ray.t_min > ray.t_max),
                ("interval of one point", ray.t_min == ray.t_max && ray.t_min.is_finite()),
                ("NaN interval", ray.t_min.is_nan() || ray.t_max.is_nan()),
                ("infinite interval", ray.t_max == f32::INFINITY),
                ("flat box", (0..3).any(|axis| lo[axis] == hi[axis])),
                ("inverted box", (0..3).any(|axis| lo[axis] > hi[axis])),
            ] {
                *seen.entry(kind).or_default() += u32::from(present);
            }
        }
    }
    for (kind, count) in &seen {
        assert!(*count >= 30, "only {count} of 32000 rays have: {kind}; all: {seen:?}");
    }
}
