//! Rays that exactly meet the edges and vertices of meshes: what a kernel claims of them holds without exception, and
//! what it does not claim, it breaks before our eyes.
//!
//! The meshes are random fans, lattices, split triangles and stars of 8 to 65,536 triangles (`meshes`), a test that Vulkan's
//! conformance suite does on graphics hardware, and all edges and fans of a small grid (`small_grid`).

mod meshes;
mod random;
mod small_grid;

use std::fmt::Write;
use std::time::Instant;

use glam::Vec3;
use raylanes::geom::{Ray, Triangle};
use raylanes::kernels::{Claim, Intersect, Kernel};
use raylanes::oracle::Exact;
use raylanes::registry::{self, Visitor};
use rayon::prelude::*;
use wide::f32x8;

use meshes::{Mesh, Shot, Target};

const CLAIMS: [Claim; 3] = [Claim::EdgeWatertight, Claim::VertexWatertight, Claim::SingleHit];

/// Rays that a claim is about, and those of them that break it.
#[derive(Default)]
struct Tally {
    rays: u64,
    broken: u64,
    /// The first of these.
    example: Option<String>,
}

impl Tally {
    fn count(&mut self, rays: u64, broken: u64, example: impl FnOnce() -> String) {
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

/// One tally for each of [`CLAIMS`].
#[derive(Default)]
struct Tallies([Tally; 3]);

impl Tallies {
    fn of(&mut self, claim: Claim) -> &mut Tally {
        &mut self.0[CLAIMS.iter().position(|other| *other == claim).unwrap()]
    }

    fn plus(self, later: Self) -> Self {
        let [a, b, c] = self.0;
        let [d, e, f] = later.0;
        Self([a.plus(d), b.plus(e), c.plus(f)])
    }
}

struct Suite {
    meshes: Vec<(Mesh, Vec<Shot>)>,
    kernels: usize,
    failures: Vec<String>,
}

impl Visitor<Triangle> for Suite {
    fn visit<K: Kernel<Shape = Triangle>>(&mut self) {
        self.kernels += 1;
        let mut all = Tallies::default();
        let mut note = |name: &str, measure: &dyn Fn() -> Tallies| {
            let start = Instant::now();
            let tallies = measure();
            let broken = CLAIMS.iter().zip(&tallies.0);
            let broken = broken.map(|(claim, tally)| format!("{} {} of {}", claim.name(), tally.broken, tally.rays));
            let broken = broken.collect::<Vec<_>>().join(", ");
            println!("{}, {name}, {:.1} s: broken: {broken}", K::INFO.id, start.elapsed().as_secs_f32());
            all = std::mem::take(&mut all).plus(tallies);
        };
        note("meshes", &|| on_meshes::<K>(&self.meshes));
        note("small grid", &small_grid::all::<K>);
        for (claim, tally) in CLAIMS.into_iter().zip(all.0) {
            let claimed = K::INFO.claims.contains(&claim);
            match tally.example {
                Some(example) if claimed => self.failures.push(format!(
                    "{} claims to be {}, but {} of {} rays say otherwise, such as this one:\n{example}",
                    K::INFO.id,
                    claim.name(),
                    tally.broken,
                    tally.rays
                )),
                None if !claimed => self.failures.push(format!(
                    "{} does not claim to be {}, and yet not one of {} rays shows it",
                    K::INFO.id,
                    claim.name(),
                    tally.rays
                )),
                _ => {}
            }
        }
    }
}

#[test]
fn claims_are_kept_and_what_is_not_claimed_is_broken() {
    let start = Instant::now();
    let mut suite = Suite { meshes: meshes(), kernels: 0, failures: Vec::new() };
    let shots = suite.meshes.iter().map(|(_, shots)| shots.len()).sum::<usize>();
    println!("{} meshes, {shots} rays at them, made in {:.1} s", suite.meshes.len(), start.elapsed().as_secs_f32());
    registry::triangles(&mut suite);
    assert!(suite.kernels > 0, "the registry is empty");
    assert!(suite.failures.is_empty(), "{}", suite.failures.join("\n"));
}

#[test]
fn the_rays_of_the_small_grid_are_exact() {
    small_grid::confirm();
}

fn meshes() -> Vec<(Mesh, Vec<Shot>)> {
    type Plan = (Box<dyn Fn(u64) -> Mesh + Sync>, u64, usize);
    let mut plans: Vec<Plan> = Vec::new();
    // Columns and rows of a whole lattice, and of one to split.
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
        // Each ray meets all triangles of a fan.
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

fn on_meshes<K: Kernel<Shape = Triangle>>(meshes: &[(Mesh, Vec<Shot>)]) -> Tallies {
    meshes.par_iter().map(|(mesh, shots)| on_mesh::<K>(mesh, shots)).reduce(Tallies::default, Tallies::plus)
}

fn on_mesh<K: Kernel<Shape = Triangle>>(mesh: &Mesh, shots: &[Shot]) -> Tallies {
    let prepared: Vec<K> = mesh.triangles.iter().map(K::prepare).collect();
    let packets: Vec<K::Packet> = prepared.as_chunks().0.iter().map(K::gather).collect();
    let fire = |mut tallies: Tallies, shot: &Shot| {
        let ray = Ray::splat(&shot.ray);
        let setup = <K as Intersect<f32x8>>::setup(&ray);
        let mut hits = Vec::new();
        for &group in &shot.groups {
            let mask = packets[group as usize].closest_hit(&ray, &setup).mask.bits();
            hits.extend((0..8).filter(|lane| mask >> lane & 1 == 1).map(|lane| 8 * group + lane));
        }
        // Beside an edge, a hit of anything will do.
        let counts = |hit: &u32| shot.around.is_empty() || shot.around.binary_search(hit).is_ok();
        let leaks = !hits.iter().any(counts);
        let watertight = match shot.target {
            Target::Edge => Claim::EdgeWatertight,
            Target::Vertex => Claim::VertexWatertight,
        };
        for (claim, broken) in [(watertight, leaks), (Claim::SingleHit, hits.len() != 1)] {
            tallies.of(claim).count(1, broken.into(), || {
                let in_reach = || shot.groups.iter().flat_map(|group| 8 * group..8 * group + 8);
                let involved = in_reach().filter_map(|index| {
                    let (triangle, reported) = (mesh.triangles[index as usize], hits.binary_search(&index).is_ok());
                    (reported || triangle.truth(&shot.ray).hit).then_some((index, triangle, reported))
                });
                format!("{}\n{}", mesh.name, describe(&shot.ray, &involved.collect::<Vec<_>>()))
            });
        }
        tallies
    };
    shots.par_iter().fold(Tallies::default, fire).reduce(Tallies::default, Tallies::plus)
}

/// The ray, and the first of these triangles, which it hits or is reported to hit: by number, in decimal and in bits.
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
