//! The scalar and the packet twin of every registered kernel give the same bits for every input: in each lane position,
//! in full and partial packets, for eight rays against one primitive and one ray against eight primitives.
//!
//! `PROPTEST_CASES` raises the number of packets, `PROPTEST_RNG_SEED` changes the seed.

mod aim;

use std::fmt::{Debug, Write};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::{Config, RngSeed, TestCaseError, TestError, TestRunner};
use raylanes::geom::{Aabb, Hit, Mask8, Placed, Quadric, Ray, Triangle};
use raylanes::kernels::{Intersect, Kernel};
use raylanes::registry::{self, Visitor};
use wide::f32x8;

use aim::{Aimed, Case};

const PACKETS: u32 = 20_000;

/// What is to be done, each by itself, so that all cores can help.
#[derive(Default)]
struct Twins(Vec<fn() -> Outcome>);

#[test]
fn twins_have_identical_hits() {
    let mut twins = Twins::default();
    registry::all(&mut twins);
    let Twins(jobs) = twins;
    assert!(!jobs.is_empty(), "the registry is empty");
    // The cases of each shape first, or every thread would wait for the first shape's.
    let fills = [
        fill::<Aabb>,
        fill::<Triangle>,
        fill::<Quadric>,
        fill::<Placed<Aabb>>,
        fill::<Placed<Triangle>>,
        fill::<Placed<Quadric>>,
    ];
    in_parallel(&fills);

    let mut failures = Vec::new();
    for Outcome { summary, failure } in in_parallel(&jobs) {
        print!("{summary}");
        failures.extend(failure);
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

fn fill<S: Pooled>() {
    S::cases();
}

/// Runs the jobs on all cores; the results are in the order of the jobs.
fn in_parallel<T: Send + Sync>(jobs: &[fn() -> T]) -> Vec<T> {
    let results: Vec<OnceLock<T>> = jobs.iter().map(|_| OnceLock::new()).collect();
    let next = AtomicUsize::new(0);
    let work = || {
        loop {
            let job = next.fetch_add(1, Ordering::Relaxed);
            let (Some(run), Some(slot)) = (jobs.get(job), results.get(job)) else { break };
            assert!(slot.set(run()).is_ok(), "each job is taken once");
        }
    };
    let threads = thread::available_parallelism().map_or(1, usize::from);
    thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(work);
        }
    });
    results.into_iter().map(|slot| slot.into_inner().expect("every job was taken")).collect()
}

/// A shape whose cases are made once, for all its kernels: making them takes longer than checking them.
trait Pooled: Aimed {
    fn cases() -> &'static [Case<Self>];
}

macro_rules! pooled {
    ($($shape:ty),*) => {$(
        impl Pooled for $shape {
            fn cases() -> &'static [Case<Self>] {
                static CASES: OnceLock<Vec<Case<$shape>>> = OnceLock::new();
                CASES.get_or_init(|| {
                    let (mut runner, cases) = runner();
                    let strategy = aim::cases();
                    (0..cases).map(|_| strategy.new_tree(&mut runner).unwrap().current()).collect()
                })
            }
        }
    )*};
}
pooled!(Aabb, Triangle, Quadric, Placed<Aabb>, Placed<Triangle>, Placed<Quadric>);

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

/// What came of one kernel.
struct Outcome {
    summary: String,
    failure: Option<String>,
}

/// Tests and hits of one face, to show that a property did not pass on misses alone.
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

impl<S: Pooled> Visitor<S> for Twins {
    fn visit<K: Kernel<Shape = S>>(&mut self) {
        self.0.push(check_all::<S, K>);
    }
}

fn check_all<S: Pooled, K: Kernel<Shape = S>>() -> Outcome {
    let id = K::INFO.id;
    let mut rates = [HitRate::default(); 2];
    let cases = S::cases();
    if let Some(failing) = cases.iter().position(|case| check::<K>(case, &mut rates).is_err()) {
        return Outcome { summary: String::new(), failure: Some(shrunk::<S, K>(failing)) };
    }
    let [many_rays, many_primitives] = rates.map(HitRate::percent);
    let packets = cases.len();
    Outcome {
        summary: format!("{id}: {packets} packets, hits: {many_rays:.0} % of 8x1, {many_primitives:.0} % of 1x8\n"),
        failure: (!(15.0..=85.0).contains(&many_rays) || !(8.0..=85.0).contains(&many_primitives))
            .then(|| format!("{id}: the rays are badly aimed, the property saw next to one outcome")),
    }
}

/// Makes case number `failing` again, this time with what is needed to simplify it, and describes the simplest that
/// fails.
fn shrunk<S: Pooled, K: Kernel<Shape = S>>(failing: usize) -> String {
    let (mut runner, _) = runner();
    let strategy = aim::cases::<S>();
    for _ in 0..failing {
        strategy.new_tree(&mut runner).unwrap();
    }
    let tree = strategy.new_tree(&mut runner).unwrap();
    let check = |case: &Case<S>| check::<K>(case, &mut Default::default());
    match runner.run_one(tree, |case| check(&case).map_err(TestCaseError::fail)) {
        // The reason that proptest kept may belong to a larger case than the one it shrank to.
        Err(TestError::Fail(_, case)) => check(&case).expect_err("shrinking keeps the failure"),
        Err(TestError::Abort(reason)) => panic!("{}: aborted: {reason}", K::INFO.id),
        Ok(_) => unreachable!("the same seed makes the same cases"),
    }
}

// One copy of each twin, instead of one for each place that calls it.

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

/// Checks one packet of rays against one packet of primitives.
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
            let face = || format!("8 rays x 1 primitive, packet turned by {shift}");
            compare::<K>(face, case, 0, source(lane), lane, expected, hits.lane(lane))?;
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
            let face = || format!("8 rays x 1 primitive, {active} of 8 active");
            compare::<K>(face, case, 0, lane, lane, expected, hits.lane(lane))?;
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
        let face = || "8 rays x 8 primitives".into();
        compare::<K>(face, case, lane, lane, lane, row[lane], hits.lane(lane))?;
        let face = || "1 ray x 1 primitive taken out of 8".into();
        compare::<K>(face, case, lane, lane, lane, row[lane], hit(&K::lane(&gathered, lane), &case.rays[lane]))?;
    }
    Ok(())
}

/// A miss has one content, and a hit holds no NaN and keeps to its interval.
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
    face: impl FnOnce() -> String,
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
    let mut text = format!("{}: twins differ, {}, lane {lane}\n", K::INFO.id, face());
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

/// Ray and shape, in decimal and, where they are numbers, in bits.
fn describe(text: &mut String, shape: &impl Debug, ray: &Ray<f32>) {
    writeln!(text, "shape     {shape:?}").unwrap();
    for (name, v) in [("origin", ray.origin), ("dir", ray.dir)] {
        writeln!(text, "{name:9} {}", v.to_array().map(decimal_and_hex).join(", ")).unwrap();
    }
    writeln!(text, "interval  {}", [ray.t_min, ray.t_max].map(decimal_and_hex).join(", ")).unwrap();
}

/// The property above is only as good as the cases: one pass over them shows that every kind that the generators
/// promise comes up.
#[test]
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
    println!("{seen:#?}");
    for (kind, count) in seen {
        assert!(count >= 30, "only {count} of 32000 rays have: {kind}");
    }
}
