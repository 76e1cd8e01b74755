//! Throughput of kernels: every face of every kernel, with the data in the first-level cache.
//!
//! What is timed is what a tracer does with a kernel: [`RAYS`] rays find their closest hit among [`PRIMITIVES`] prepared
//! primitives, setup included, and keep `t`, `u`, `v` and the primitive number. All faces do this for the same rays and
//! primitives, and must end with the same hits.
//!
//! Jobs are interleaved: the first sample of every job, then the second of every job, and so on, so that a slow spell of
//! the machine falls on all alike.

use std::hint::black_box;
use std::sync::Barrier;
use std::time::Instant;

use wide::{f32x8, u32x8};

use super::record::{MethodRow, SpeedRow};
use super::stats::{mad, median};
use super::workload::{Subject, Workload, rng};
use crate::geom::lanes::lt8;
use crate::geom::{Hit, Ray};
use crate::kernels::{Intersect, Kernel, Shape};
use crate::registry::Visitor;
use crate::tracer::{Error, checksum};

/// Rays of a pass: eight packets.
pub const RAYS: usize = 64;
/// Primitives of a pass: four groups of eight.
pub const PRIMITIVES: usize = 32;

/// How rays and primitives are paired.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Face {
    /// The scalar twin.
    OneByOne,
    /// The packet twin: eight rays against one primitive.
    EightRays,
    /// The packet twin: one ray against eight primitives.
    EightPrimitives,
}

impl Face {
    /// Every face.
    pub const ALL: [Self; 3] = [Self::OneByOne, Self::EightRays, Self::EightPrimitives];

    /// As used in records.
    pub fn name(self) -> &'static str {
        match self {
            Self::OneByOne => "1x1",
            Self::EightRays => "8x1",
            Self::EightPrimitives => "1x8",
        }
    }
}

/// Rays and prepared primitives of a kernel.
#[derive(Clone, Debug)]
pub struct Bench<K: Kernel> {
    primitives: Vec<K>,
    groups: Vec<K::Packet>,
    rays: Vec<Ray<f32>>,
    packets: Vec<Ray<f32x8>>,
}

impl<K: Kernel> Bench<K>
where
    K::Shape: Subject,
{
    /// Each ray is aimed at one of the primitives, or at its neighbours in a small mesh, and misses most others.
    pub fn new(workload: Workload, seed: u64) -> Self {
        let (mut primitives, mut rays) = (Vec::new(), Vec::new());
        for index in 0.. {
            let sample = K::Shape::sample(workload, &mut rng(seed, K::Shape::FAMILY, workload.name(), &[], index));
            primitives.extend(sample.shapes.iter().map(K::prepare));
            rays.extend_from_slice(&sample.rays[..sample.shapes.len() * RAYS / PRIMITIVES]);
            if primitives.len() == PRIMITIVES {
                break;
            }
        }
        let groups = primitives.chunks_exact(8).map(|eight| K::gather(eight.try_into().expect("groups of eight")));
        let packets = rays.chunks_exact(8).map(Ray::from_slice);
        Self { groups: groups.collect(), packets: packets.collect(), primitives, rays }
    }

    /// One pass: the closest hit of each ray among all primitives, in ray order.
    #[inline(never)]
    pub fn pass(&self, face: Face, hits: &mut [Hit<f32>; RAYS]) {
        match face {
            Face::OneByOne => self.one_by_one(hits),
            Face::EightRays => self.eight_rays(hits),
            Face::EightPrimitives => self.eight_primitives(hits),
        }
    }

    fn one_by_one(&self, hits: &mut [Hit<f32>; RAYS]) {
        for (ray, best) in self.rays.iter().zip(hits) {
            let setup = <K as Intersect<f32>>::setup(ray);
            *best = Hit::MISS;
            for (number, primitive) in self.primitives.iter().enumerate() {
                let hit = primitive.closest_hit(ray, &setup);
                if hit.t < best.t {
                    *best = Hit { primitive: number as u32, ..hit };
                }
            }
        }
    }

    fn eight_rays(&self, hits: &mut [Hit<f32>; RAYS]) {
        for (packet, hits) in self.packets.iter().zip(hits.chunks_exact_mut(8)) {
            let setup = <K as Intersect<f32x8>>::setup(packet);
            let mut best = Hit::<f32x8>::miss();
            for (number, primitive) in self.primitives.iter().enumerate() {
                let hit = primitive.closest_hit(packet, &setup);
                if hit.mask.any() {
                    let closer = lt8(hit.t, best.t);
                    if closer.any() {
                        best.replace(closer, &Hit { primitive: u32x8::splat(number as u32), ..hit });
                    }
                }
            }
            best.write(hits);
        }
    }

    fn eight_primitives(&self, hits: &mut [Hit<f32>; RAYS]) {
        for (ray, hit) in self.rays.iter().zip(hits) {
            let ray = Ray::splat(ray);
            let setup = <K as Intersect<f32x8>>::setup(&ray);
            let mut best = Hit::<f32x8>::miss();
            let mut numbers = u32x8::new([0, 1, 2, 3, 4, 5, 6, 7]);
            for group in &self.groups {
                let hit = group.closest_hit(&ray, &setup);
                if hit.mask.any() {
                    let closer = lt8(hit.t, best.t);
                    if closer.any() {
                        best.replace(closer, &Hit { primitive: numbers, ..hit });
                    }
                }
                numbers += u32x8::splat(8);
            }
            *hit = best.closest();
        }
    }

    /// Share of the tests of this face in which anything is hit.
    fn hit_share(&self, face: Face) -> f64 {
        let (mut hits, mut tests) = (0, 0);
        let mut count = |hit: bool| (hits, tests) = (hits + u32::from(hit), tests + 1);
        match face {
            Face::OneByOne => {
                self.rays.iter().for_each(|ray| self.primitives.iter().for_each(|one| count(one.hit(ray).mask)));
            }
            Face::EightRays => {
                self.packets
                    .iter()
                    .for_each(|rays| self.primitives.iter().for_each(|one| count(one.hit(rays).mask.any())));
            }
            Face::EightPrimitives => {
                let packets = self.rays.iter().map(Ray::splat);
                packets.for_each(|ray| self.groups.iter().for_each(|eight| count(eight.hit(&ray).mask.any())));
            }
        }
        f64::from(hits) / f64::from(tests)
    }

    /// Nanoseconds per ray for the setup, scalar and in packets.
    fn setup_ns(&self) -> [f64; 2] {
        let time = |run: &dyn Fn()| {
            let passes = 2_000;
            let samples = (0..5).map(|_| {
                let start = Instant::now();
                (0..passes).for_each(|_| run());
                start.elapsed().as_secs_f64() * 1e9 / (passes * RAYS) as f64
            });
            median(&samples.collect::<Vec<_>>())
        };
        [
            time(&|| {
                for ray in &self.rays {
                    black_box(<K as Intersect<f32>>::setup(black_box(ray)));
                }
            }),
            time(&|| {
                for packet in &self.packets {
                    black_box(<K as Intersect<f32x8>>::setup(black_box(packet)));
                }
            }),
        ]
    }
}

/// One face of one kernel, ready to be timed.
struct Job {
    id: String,
    face: Face,
    hit_share: f64,
    /// Runs so many passes and returns the hits of the last.
    run: Box<dyn Fn(usize) -> [Hit<f32>; RAYS] + Send + Sync>,
}

#[derive(Default)]
pub(crate) struct Speed {
    pub(crate) methods: Vec<MethodRow>,
    jobs: Vec<Job>,
    seed: u64,
}

impl Speed {
    /// Prepares every registered kernel.
    pub(crate) fn new(seed: u64) -> Self {
        let mut speed = Self { seed, ..Self::default() };
        crate::registry::all(&mut speed);
        speed
    }

    /// Times every job with each number of threads, and calls `after_round` each time that all had a turn, with the share that is
    /// done.
    ///
    /// # Errors
    /// If two faces, or two threads, of a kernel end with different hits: a timing of wrong results is worth nothing.
    pub(crate) fn measure(
        &self,
        samples: usize,
        sample_seconds: f64,
        thread_counts: &[usize],
        after_round: &mut dyn FnMut(f64),
    ) -> Result<Vec<SpeedRow>, Error> {
        let expected: Vec<u64> = self.jobs.iter().map(|job| checksum(&(job.run)(1))).collect();
        for (job, sum) in self.jobs.iter().zip(&expected) {
            let first = self.jobs.iter().position(|other| other.id == job.id).expect("the job itself is there");
            if *sum != expected[first] {
                return Err(Error::Disagreement(format!("{}: faces {} and 1x1", job.id, job.face.name())));
            }
        }
        let passes: Vec<usize> = self.jobs.iter().map(|job| passes_for(job, sample_seconds)).collect();
        let mut times = vec![Vec::with_capacity(samples); self.jobs.len() * thread_counts.len()];
        for sample in 0..samples {
            for (slot, times) in times.iter_mut().enumerate() {
                let (index, threads) = (slot / thread_counts.len(), thread_counts[slot % thread_counts.len()]);
                let (seconds, sums) = timed(&self.jobs[index], passes[index], threads);
                if sums.iter().any(|sum| *sum != expected[index]) {
                    return Err(Error::Disagreement(format!("{} while it was timed", self.jobs[index].id)));
                }
                times.push(seconds * 1e9 / (passes[index] * threads * RAYS * PRIMITIVES) as f64);
            }
            after_round((sample + 1) as f64 / samples as f64);
        }
        let row = |(slot, times): (usize, &Vec<f64>)| {
            let index = slot / thread_counts.len();
            let ns_per_test = median(times);
            SpeedRow {
                id: self.jobs[index].id.clone(),
                face: self.jobs[index].face.name().into(),
                threads: thread_counts[slot % thread_counts.len()],
                ns_per_test,
                ns_per_test_mad: mad(times),
                tests_per_second: 1e9 / ns_per_test,
                samples,
                hit_share: self.jobs[index].hit_share,
                checksum: format!("{:016x}", expected[index]),
            }
        };
        Ok(times.iter().enumerate().map(row).collect())
    }
}

impl<S: Subject> Visitor<S> for Speed {
    fn visit<K: Kernel<Shape = S>>(&mut self) {
        let bench = Bench::<K>::new(Workload::Generic, self.seed);
        let id = K::INFO.id.to_string();
        let [setup_ns, setup_ns_packet] =
            if size_of::<<K as Intersect<f32>>::Setup>() == 0 { [0.0; 2] } else { bench.setup_ns() };
        self.methods.push(MethodRow {
            id: id.clone(),
            family: S::FAMILY.into(),
            idea: K::INFO.idea.into(),
            source: K::INFO.source.into(),
            operations: K::INFO.operations.into(),
            prepared_bytes: size_of::<K>(),
            setup_bytes: size_of::<<K as Intersect<f32>>::Setup>(),
            setup_ns,
            setup_ns_packet,
            claims: K::INFO.claims.iter().map(|claim| claim.name().into()).collect(),
        });
        for face in Face::ALL {
            let (bench, hit_share) = (bench.clone(), bench.hit_share(face));
            let run = move |passes| {
                let mut hits = [Hit::MISS; RAYS];
                for _ in 0..passes {
                    black_box(&bench).pass(face, black_box(&mut hits));
                }
                hits
            };
            self.jobs.push(Job { id: id.clone(), face, hit_share, run: Box::new(run) });
        }
    }
}

/// Passes that take about so many seconds, found by doubling.
fn passes_for(job: &Job, seconds: f64) -> usize {
    let mut passes = 1;
    loop {
        let (elapsed, _) = timed(job, passes, 1);
        if elapsed > seconds / 4.0 {
            return ((passes as f64 * seconds / elapsed) as usize).max(1);
        }
        passes *= 2;
    }
}

/// Runs the job on so many threads at once: seconds until the last is done, and the checksum of each.
fn timed(job: &Job, passes: usize, threads: usize) -> (f64, Vec<u64>) {
    if threads == 1 {
        let start = Instant::now();
        let hits = (job.run)(passes);
        return (start.elapsed().as_secs_f64(), vec![checksum(&hits)]);
    }
    let barrier = Barrier::new(threads);
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads)
            .map(|_| {
                scope.spawn(|| {
                    barrier.wait();
                    let start = Instant::now();
                    let hits = (job.run)(passes);
                    (start, Instant::now(), checksum(&hits))
                })
            })
            .collect();
        let done: Vec<_> =
            workers.into_iter().map(|worker| worker.join().expect("a timed job does not panic")).collect();
        let start = done.iter().map(|(start, ..)| *start).min().expect("there is a thread");
        let end = done.iter().map(|(_, end, _)| *end).max().expect("there is a thread");
        ((end - start).as_secs_f64(), done.into_iter().map(|(.., sum)| sum).collect())
    })
}
