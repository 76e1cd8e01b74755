//! Tests the claims of triangle kernels with rays that exactly meet edges and vertices of meshes, with rays that leave
//! a triangle, and with rays that pass close to edges. There is one test per kernel.
//!
//! A claim must hold for every ray. If a kernel does not make a claim, at least one ray must break it.
//!
//! The meshes in `meshes` are random fans, lattices, split triangles and stars of 8 to 65,536 triangles. Vulkan's
//! conformance suite does such a test on graphics hardware. `small_grid` adds all edges and fans on a small grid,
//! `crossings` all closed meshes of four triangles there. `decisions` compares with the oracle, beside edges.
//!
//! `RAYLANES_ROUNDS=100 cargo test --release --test watertight` compares 100 times as many decisions.

mod crossings;
mod decisions;
mod harness;
mod meshes;
mod random;
mod small_grid;

use std::fmt::{Display, Formatter, Write};
use std::process::ExitCode;
use std::sync::{Arc, LazyLock};

use glam::Vec3;
use libtest_mimic::Trial;
use raylanes::geom::{Ray, Triangle};
use raylanes::kernels::{Claim, Intersect, Kernel};
use raylanes::oracle::Exact;
use raylanes::registry::{self, Visitor};
use raylanes::study::workload::{Sample, Subject, rng};
use rayon::prelude::*;
use wide::f32x8;

use meshes::{Mesh, Shot, Target};

const CLAIMS: [Claim; 6] = [
    Claim::EdgeWatertight,
    Claim::VertexWatertight,
    Claim::SingleHit,
    Claim::EvenCrossings,
    Claim::NoHitBehind,
    Claim::RightDecision,
];

/// The rays that a claim is about, and how many of them break it.
#[derive(Default)]
struct Count {
    rays: u64,
    broken: u64,
    /// The first ray that breaks it.
    example: Option<String>,
}

impl Count {
    fn add(&mut self, rays: u64, broken: u64, example: impl FnOnce() -> String) {
        self.rays += rays;
        self.broken += broken;
        if broken > 0 && self.example.is_none() {
            self.example = Some(example());
        }
    }

    fn plus(self, later: Self) -> Self {
        Self {
            rays: self.rays + later.rays,
            broken: self.broken + later.broken,
            example: self.example.or(later.example),
        }
    }
}

/// One count for each of [`CLAIMS`].
#[derive(Default)]
struct Counts([Count; 6]);

impl Counts {
    fn of(&mut self, claim: Claim) -> &mut Count {
        &mut self.0[CLAIMS.iter().position(|other| *other == claim).unwrap()]
    }

    fn plus(self, later: Self) -> Self {
        let mut later = later.0.into_iter();
        Self(self.0.map(|count| count.plus(later.next().expect("as many counts"))))
    }
}

impl Display for Counts {
    fn fmt(&self, f: &mut Formatter) -> std::fmt::Result {
        let counts = CLAIMS.iter().zip(&self.0);
        let counts = counts.map(|(claim, count)| format!("{} {} of {}", claim.name(), count.broken, count.rays));
        f.write_str(&counts.collect::<Vec<_>>().join(", "))
    }
}

/// What the rays of all kernels meet or leave.
struct Inputs {
    meshes: Vec<(Mesh, Vec<Shot>)>,
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
    let inputs = || Inputs { meshes: meshes(), leaving: leaving() };
    let mut tests = Tests { inputs: Arc::new(LazyLock::new(inputs)), trials: Vec::new() };
    registry::triangles(&mut tests);
    tests.trials.push(harness::test("rays_of_the_small_grid_meet_their_targets_exactly", small_grid::confirm));
    tests.trials.push(harness::test("distances_of_exact_t_are_right_to_4096_ulp", decisions::confirm_distances));
    harness::run(vec![tests.trials], registry::triangles)
}

/// Checks that every ray keeps the claims of the kernel, and that some ray breaks each claim that it does not make.
/// Returns how many rays break each claim.
fn hold_to_claims<K: Kernel<Shape = Triangle>>(inputs: &Inputs) -> Result<String, String> {
    let on_meshes = on_meshes::<K>(&inputs.meshes).plus(on_leaving::<K>(&inputs.leaving)).plus(decisions::all::<K>());
    let on_small_grid = small_grid::all::<K>().plus(crossings::all::<K>());
    let summary = format!("{}: broken on meshes: {on_meshes}; on the small grid: {on_small_grid}", K::INFO.id);
    let mut failures = Vec::new();
    for (claim, Count { rays, broken, example }) in CLAIMS.into_iter().zip(on_meshes.plus(on_small_grid).0) {
        let (id, name) = (K::INFO.id, claim.name());
        match (K::INFO.claims.contains(&claim), example) {
            (true, Some(example)) => {
                failures.push(format!(
                    "{id} claims to be {name}, but {broken} of {rays} rays break it. One is:\n{example}"
                ));
            }
            (false, None) => {
                failures.push(format!("{id} does not claim to be {name}, but none of {rays} rays breaks it"));
            }
            _ => {}
        }
    }
    if failures.is_empty() { Ok(summary) } else { Err(failures.join("\n")) }
}

fn meshes() -> Vec<(Mesh, Vec<Shot>)> {
    type Plan = (Box<dyn Fn(u64) -> Mesh + Sync>, u64, usize);
    let mut plans: Vec<Plan> = Vec::new();
    // Triangles, columns and rows of a whole lattice, columns and rows of a lattice to split, seeds.
    for (total, [columns, rows], coarse, seeds) in [
        (8, [2, 2], 1, 64),
        (64, [4, 8], 1, 32),
        (512, [16, 16], 4, 8),
        (4096, [32, 64], 8, 4),
        (65_536, [128, 256], 32, 2),
    ] {
        let shots = 8_192 / seeds as usize;
        plans.push((Box::new(move |seed| Mesh::lattice(columns, rows, total, 0, seed)), seeds, shots));
        plans.push((Box::new(move |seed| Mesh::lattice(columns, rows, total, 64, seed)), seeds, shots));
        plans.push((Box::new(move |seed| Mesh::lattice(coarse, coarse, total, 0, seed)), seeds, shots));
        // Each ray meets all triangles of a fan, so large fans get fewer rays.
        plans.push((Box::new(move |seed| Mesh::fan(total, seed)), seeds, shots.min(1 << 21 >> total.ilog2())));
    }
    for (levels, seeds) in [(0, 64), (1, 32), (2, 16), (4, 2)] {
        plans.push((Box::new(move |seed| Mesh::star(levels, seed)), seeds, 2_048 / seeds as usize));
    }
    let all = plans.par_iter().enumerate().flat_map(|(index, &(ref make, seeds, shots))| {
        (0..seeds).into_par_iter().map(move |seed| {
            let seed = 1_000 * index as u64 + seed;
            let mesh = make(seed);
            let shots = mesh.shots(shots, !seed);
            (mesh, shots)
        })
    });
    all.collect()
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
                    counts.of(claim).add(1, broken.into(), || describe(ray, &[(0, *triangle, true)]));
                }
            }
        }
    }
    counts
}

fn on_meshes<K: Kernel<Shape = Triangle>>(meshes: &[(Mesh, Vec<Shot>)]) -> Counts {
    meshes.par_iter().map(|(mesh, shots)| on_mesh::<K>(mesh, shots)).reduce(Counts::default, Counts::plus)
}

fn on_mesh<K: Kernel<Shape = Triangle>>(mesh: &Mesh, shots: &[Shot]) -> Counts {
    let prepared: Vec<K> = mesh.triangles.iter().map(K::prepare).collect();
    let packets: Vec<K::Packet> = prepared.as_chunks().0.iter().map(K::gather).collect();
    let fire = |mut counts: Counts, shot: &Shot| {
        let ray = Ray::splat(&shot.ray);
        let setup = <K as Intersect<f32x8>>::setup(&ray);
        let mut hits = Vec::new();
        for &group in &shot.groups {
            let mask = packets[group as usize].closest_hit(&ray, &setup).mask.bits();
            hits.extend((0..8).filter(|lane| mask >> lane & 1 == 1).map(|lane| 8 * group + lane));
        }
        // One ulp off the target, a hit of any triangle is enough.
        let accepted = |hit: &u32| shot.around.is_empty() || shot.around.binary_search(hit).is_ok();
        let leaks = !hits.iter().any(accepted);
        let watertight = match shot.target {
            Target::Edge => Claim::EdgeWatertight,
            Target::Vertex => Claim::VertexWatertight,
        };
        for (claim, broken) in [(watertight, leaks), (Claim::SingleHit, hits.len() != 1)] {
            counts.of(claim).add(1, broken.into(), || {
                let in_reach = || shot.groups.iter().flat_map(|group| 8 * group..8 * group + 8);
                let involved = in_reach().filter_map(|index| {
                    let (triangle, reported) = (mesh.triangles[index as usize], hits.binary_search(&index).is_ok());
                    (reported || triangle.truth(&shot.ray).hit).then_some((index, triangle, reported))
                });
                format!("{}\n{}", mesh.name, describe(&shot.ray, &involved.collect::<Vec<_>>()))
            });
        }
        counts
    };
    shots.par_iter().fold(Counts::default, fire).reduce(Counts::default, Counts::plus)
}

/// Prints the ray and the first eight of these triangles, in decimal and in bits.
fn describe(ray: &Ray<f32>, triangles: &[(u32, Triangle, bool)]) -> String {
    let point = |p: Vec3| {
        let [x, y, z] = p.to_array().map(f32::to_bits);
        format!("{p:?} {x:08x} {y:08x} {z:08x}")
    };
    let mut text = format!("    origin {}\n    dir    {}\n", point(ray.origin), point(ray.dir));
    for (index, triangle, hit) in triangles.iter().take(8) {
        writeln!(text, "    triangle {index}, {}", if *hit { "reported" } else { "not reported" }).unwrap();
        for vertex in triangle.vertices() {
            writeln!(text, "        {}", point(vertex)).unwrap();
        }
    }
    if triangles.len() > 8 {
        writeln!(text, "    and {} more", triangles.len() - 8).unwrap();
    }
    text
}
