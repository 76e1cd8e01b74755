//! Tests that the scalar and the packet twin of every registered kernel give the same bits for every input: in each
//! lane, in full and partial packets, for eight rays against one primitive and one ray against eight primitives.
//!
//! `raylanes::conformance` also checks each kernel, as it checks the kernels of others: invalid rays and primitives
//! miss, and claims hold.
//!
//! There is one test per kernel. A failure names the kernel, the width, the lane and the simplest input that fails,
//! with its bits. `PROPTEST_CASES` raises the number of packets, `PROPTEST_RNG_SEED` changes the seed.

mod aim;
mod harness;

use std::process::ExitCode;
use std::sync::{Arc, LazyLock};

use libtest_mimic::Trial;
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::{Config, RngSeed, TestCaseError, TestError, TestRunner};
use raylanes::conformance::{Aimed, Case, Options, check_with, compare_twins};
use raylanes::geom::{Aabb, Placed, Quadric, Triangle};
use raylanes::kernels::Kernel;
use raylanes::registry::{self, Registered, Visitor};

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
        let check = move || Ok(format!("{}\n{}", check_all::<K>(&cases)?, conforms::<K>()?));
        self.trials.push(harness::of_kernel("twins", K::INFO.id.to_string(), check));
    }
}

/// Checks what the kit checks, also of the kernels of others. Enough hits must be damaged.
fn conforms<K: Kernel<Shape: Aimed>>() -> Result<String, String> {
    let report = check_with::<K>(&Options::new());
    if report.is_ok() && report.damaged > 500 { Ok(report.to_string()) } else { Err(report.to_string()) }
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
    fn count(&mut self, tests: u64, hits: u64) {
        self.tests += tests;
        self.hits += u64::from(hits.count_ones());
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

/// Compares the twins on one case, in every pairing.
fn check<K: Kernel<Shape: Aimed>>(case: &Case<K::Shape>, rates: &mut [HitRate; 2]) -> Result<(), String> {
    let hits =
        compare_twins::<K>(&case.rays, &case.shapes).map_err(|violation| format!("{}: {violation}", K::INFO.id))?;
    // The first shape meets eight rays at once. Each ray meets all shapes at once.
    rates[0].count(8, hits & 0xff);
    rates[1].count(64, hits);
    Ok(())
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
