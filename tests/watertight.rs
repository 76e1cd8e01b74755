//! Tests the claims of triangle kernels with rays that exactly meet edges and vertices of meshes, with rays that leave
//! a triangle, and with rays that pass close to edges. There is one test per kernel.
//!
//! A claim must hold for every ray. If a kernel does not make a claim, at least one ray must break it.
//!
//! Most inputs are those of `raylanes::conformance`, all of them. The rays of a regime of the study are added here, and
//! `decisions` compares with the oracle, beside edges.
//!
//! `RAYLANES_ROUNDS=100 cargo test --release --test watertight` compares 100 times as many decisions.

mod decisions;
mod harness;

use std::process::ExitCode;
use std::sync::{Arc, LazyLock};

use libtest_mimic::Trial;
use raylanes::conformance::{self, Count, Counts, Options, describe};
use raylanes::geom::{Ray, Triangle};
use raylanes::kernels::{Claim, Intersect, Kernel};
use raylanes::oracle::Exact;
use raylanes::registry::{self, Visitor};
use raylanes::study::workload::{Sample, Subject, rng};
use wide::f32x8;

const CLAIMS: [Claim; 6] = [
    Claim::EdgeWatertight,
    Claim::VertexWatertight,
    Claim::SingleHit,
    Claim::EvenCrossings,
    Claim::NoHitBehind,
    Claim::RightDecision,
];

/// What the rays of all kernels meet or leave.
struct Inputs {
    exact: conformance::Inputs,
    /// Triangles, and rays that pass them only behind their start.
    leaving: Vec<(Triangle, Vec<Ray<f32>>)>,
}

/// One test for each kernel.
struct Tests {
    /// Made once for all kernels.
    inputs: Arc<LazyLock<Inputs>>,
    trials: Vec<Trial>,
}

impl Visitor<Triangle> for Tests {
    fn visit<K: Kernel<Shape = Triangle>>(&mut self) {
        let inputs = self.inputs.clone();
        self.trials.push(harness::of_kernel("claims", K::INFO.id.to_string(), move || hold_to_claims::<K>(&inputs)));
    }
}

fn main() -> ExitCode {
    let inputs = || Inputs { exact: conformance::Inputs::new(&Options::new().exhaustive()), leaving: leaving() };
    let mut tests = Tests { inputs: Arc::new(LazyLock::new(inputs)), trials: Vec::new() };
    registry::triangles(&mut tests);
    tests.trials.push(harness::test("distances_of_exact_t_are_right_to_4096_ulp", decisions::confirm_distances));
    harness::run(vec![tests.trials], registry::triangles)
}

/// A claim that a kernel does not make, although no ray here breaks it: its bound of the error is not proven.
const UNPROVEN: (&str, Claim) = ("triangle/pbrt_woop", Claim::NoHitBehind);

/// Checks that every ray keeps the claims of the kernel, and that some ray breaks each claim that it does not make.
/// Returns how many rays break each claim.
fn hold_to_claims<K: Kernel<Shape = Triangle>>(inputs: &Inputs) -> Result<String, String> {
    let counts = inputs.exact.count::<K>().plus(on_leaving::<K>(&inputs.leaving)).plus(decisions::all::<K>());
    let mut failures = Vec::new();
    for claim in CLAIMS {
        let (id, name) = (K::INFO.id, claim.name());
        let Count { rays, broken, ref example, .. } = *counts.of(claim);
        match (K::INFO.claims.contains(&claim), example) {
            (true, Some(example)) => {
                failures.push(format!(
                    "{id} claims to be {name}, but {broken} of {rays} rays break it. One is:\n{example}"
                ));
            }
            (false, None) if (id.method, claim) == UNPROVEN => {}
            (false, None) => {
                failures.push(format!("{id} does not claim to be {name}, but none of {rays} rays breaks it"));
            }
            _ => {}
        }
    }
    if failures.is_empty() { Ok(format!("{}: broken: {counts}", K::INFO.id)) } else { Err(failures.join("\n")) }
}

/// The rays of the regime `leaving`, without those that do not leave.
fn leaving() -> Vec<(Triangle, Vec<Ray<f32>>)> {
    let regime = Triangle::REGIMES.iter().find(|regime| regime.name == "leaving").unwrap();
    let samples = regime.steps.iter().flat_map(|&step| {
        (0..4_096).map(move |index| {
            let Sample { shapes, mut rays } =
                (regime.sample)(step as f32, &mut rng(5, "claims", "leaving", &[], index));
            let passed_by = |ray: &Ray<f32>| shapes[0].truth(ray).hit;
            rays.retain(|ray| !passed_by(ray) && passed_by(&Ray { t_min: f32::NEG_INFINITY, ..*ray }));
            (shapes[0], rays)
        })
    });
    samples.collect()
}

fn on_leaving<K: Kernel<Shape = Triangle>>(samples: &[(Triangle, Vec<Ray<f32>>)]) -> Counts {
    let mut counts = Counts::default();
    for (triangle, rays) in samples {
        let prepared = K::prepare(triangle);
        for rays in rays.chunks(8) {
            let packet = Ray::from_slice(rays);
            let mask = prepared.closest_hit(&packet, &<K as Intersect<f32x8>>::setup(&packet)).mask.bits();
            for (lane, ray) in rays.iter().enumerate() {
                let broken = mask >> lane & 1;
                for claim in [Claim::NoHitBehind, Claim::RightDecision] {
                    counts.add(claim, 1, broken.into(), || describe(ray, &[(0, *triangle, true)]));
                }
            }
        }
    }
    counts
}
