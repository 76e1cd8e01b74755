//! Throughput of kernels, at every width, with the primitives in the first-level cache.
//!
//! The timed pass does what a tracer does with a kernel. Each ray finds its closest hit among [`PRIMITIVES`] prepared
//! primitives and keeps `t`, `u`, `v` and the primitive number. The per-ray setup is included. All widths do this for
//! the same rays and primitives, and must give the same hits.
//!
//! **No ray is timed twice in a row.** A processor remembers tens of thousands of branches. When 64 rays against 32
//! primitives were repeated, it predicted all 2,048 outcomes, and a scalar Möller–Trumbore test with four branches took
//! 5 ns. With rays that it had not just seen, the same test took 20 ns. So a sample is one pass over [`RAYS`] rays, and
//! all other jobs have their turn before the next pass. Before each pass, its rays and primitives are read into the
//! cache, and other rays run through its code.

use std::hint::black_box;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicIsize, Ordering};
use std::time::Instant;

use wide::{f32x8, u32x8};

use super::empty_kernel::EmptyKernel;
use super::rounds::{TimedJob, Times, of_job};
use super::stats::{median, typical};
use crate::geom::lanes::lt8;
use crate::geom::{Hit, Ray};
use crate::kernels::{Intersect, Kernel, Shape};
use crate::registry::Visitor;
use crate::study::record::{MethodRow, SpeedRow};
use crate::study::workload::{RAYS_PER_SAMPLE, Subject, Workload, rng};
use crate::tracer::{Error, checksum, threads_refused};

/// Number of rays of a pass.
pub const RAYS: usize = 8192;
/// Number of primitives that each ray is tested against: four groups of eight.
pub const PRIMITIVES: usize = 32;

/// How many rays and primitives one call tests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    /// The scalar twin.
    OneByOne,
    /// The packet twin: eight rays against one primitive.
    EightRays,
    /// The packet twin: one ray against eight primitives.
    EightPrimitives,
}

impl Width {
    /// Every width.
    pub const ALL: [Self; 3] = [Self::OneByOne, Self::EightRays, Self::EightPrimitives];

    /// Name, as used in records.
    pub fn name(self) -> &'static str {
        match self {
            Self::OneByOne => "1x1",
            Self::EightRays => "8x1",
            Self::EightPrimitives => "1x8",
        }
    }
}

/// Prepared primitives of a kernel, and rays aimed at them.
#[derive(Clone, Debug)]
struct Set<K: Kernel> {
    primitives: Vec<K>,
    groups: Vec<K::Packet>,
    rays: Vec<Ray<f32>>,
    packets: Vec<Ray<f32x8>>,
}

impl<K: Kernel> Set<K>
where
    K::Shape: Subject,
{
    /// Takes samples from number `index` on, until there are enough primitives, and moves `index` past them. Rays of
    /// different samples alternate: at most two rays in a row per primitive of a sample. The rays of a packet are
    /// therefore incoherent.
    fn new(workload: Workload, seed: u64, index: &mut u64) -> Self {
        let (mut primitives, mut samples) = (Vec::new(), Vec::new());
        while primitives.len() < PRIMITIVES {
            let sample = K::Shape::sample(workload, &mut rng(seed, K::Shape::FAMILY, workload.name(), &[], *index));
            *index += 1;
            primitives.extend(sample.shapes.iter().map(K::prepare));
            samples.push(sample);
        }
        let share = 2 * samples[0].shapes.len();
        let turns = (0..RAYS_PER_SAMPLE / share).map(|turn| share * turn..share * (turn + 1));
        let rays: Vec<_> =
            turns.flat_map(|turn| samples.iter().flat_map(move |one| &one.rays[turn.clone()])).copied().collect();
        let groups = primitives.chunks_exact(8).map(|eight| K::gather(eight.try_into().expect("groups of eight")));
        let packets = rays.chunks_exact(8).map(Ray::from_slice);
        Self { groups: groups.collect(), packets: packets.collect(), primitives, rays }
    }

    /// Finds the closest hit of each ray among all primitives.
    fn pass(&self, width: Width, hits: &mut [Hit<f32>]) {
        match width {
            Width::OneByOne => self.one_by_one(hits),
            Width::EightRays => self.eight_rays(hits),
            Width::EightPrimitives => self.eight_primitives(hits),
        }
    }

    #[inline(never)]
    fn one_by_one(&self, hits: &mut [Hit<f32>]) {
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

    #[inline(never)]
    fn eight_rays(&self, hits: &mut [Hit<f32>]) {
        for (packet, hits) in self.packets.iter().zip(hits.chunks_exact_mut(8)) {
            let setup = <K as Intersect<f32x8>>::setup(packet);
            let mut best = Hit::<f32x8>::miss();
            for (number, primitive) in self.primitives.iter().enumerate() {
                let candidate = primitive.candidate(packet, &setup);
                let closer = candidate.mask() & lt8(candidate.t(), best.t);
                best.replace(closer, &candidate.of_primitives(u32x8::splat(number as u32)));
            }
            best.write(hits);
        }
    }

    #[inline(never)]
    fn eight_primitives(&self, hits: &mut [Hit<f32>]) {
        for (ray, hit) in self.rays.iter().zip(hits) {
            let ray = Ray::splat(ray);
            let setup = <K as Intersect<f32x8>>::setup(&ray);
            let mut best = Hit::<f32x8>::miss();
            let mut numbers = u32x8::new([0, 1, 2, 3, 4, 5, 6, 7]);
            for group in &self.groups {
                let candidate = group.candidate(&ray, &setup);
                let closer = candidate.mask() & lt8(candidate.t(), best.t);
                best.replace(closer, &candidate.of_primitives(numbers));
                numbers += u32x8::splat(8);
            }
            *hit = best.closest();
        }
    }

    /// Bytes of the rays, the primitives and the hits. Every width has the same.
    fn bytes(&self) -> usize {
        size_of_val(&self.rays[..]) + size_of_val(&self.primitives[..]) + self.rays.len() * size_of::<Hit<f32>>()
    }

    /// Number of calls that hit anything, and number of calls, at this width.
    fn hits_and_calls(&self, width: Width) -> [u64; 2] {
        let (mut hits, mut tests) = (0, 0);
        let mut count = |hit: bool| (hits, tests) = (hits + u64::from(hit), tests + 1);
        match width {
            Width::OneByOne => {
                self.rays.iter().for_each(|ray| self.primitives.iter().for_each(|one| count(one.hit(ray).mask)));
            }
            Width::EightRays => {
                self.packets
                    .iter()
                    .for_each(|rays| self.primitives.iter().for_each(|one| count(one.hit(rays).mask.any())));
            }
            Width::EightPrimitives => {
                let packets = self.rays.iter().map(Ray::splat);
                packets.for_each(|ray| self.groups.iter().for_each(|eight| count(eight.hit(&ray).mask.any())));
            }
        }
        [hits, tests]
    }
}

/// The rays and prepared primitives that a kernel is timed with.
#[derive(Clone, Debug)]
pub struct Bench<K: Kernel> {
    sets: Vec<Set<K>>,
    /// Other rays and primitives, for [`Bench::warm_up`].
    other: Set<K>,
}

impl<K: Kernel> Bench<K>
where
    K::Shape: Subject,
{
    /// Makes rays and primitives. Each ray is aimed at one of its primitives, or at the neighbours of that one in a
    /// small mesh. It misses most others.
    pub fn new(workload: Workload, seed: u64) -> Self {
        let mut index = 0;
        let other = Set::new(workload, seed, &mut index);
        let sets = (0..RAYS / other.rays.len()).map(|_| Set::new(workload, seed, &mut index));
        Self { sets: sets.collect(), other }
    }

    /// One pass: writes the closest hit of each ray among its primitives, in ray order.
    ///
    /// # Panics
    /// If `hits` does not hold exactly [`RAYS`] hits.
    pub fn pass(&self, width: Width, hits: &mut [Hit<f32>]) {
        assert_eq!(hits.len(), RAYS, "one hit for each ray");
        for (set, hits) in self.sets.iter().zip(hits.chunks_exact_mut(self.other.rays.len())) {
            set.pass(width, hits);
        }
    }

    /// Reads the data of a pass into the cache, and runs the code of a pass on other rays. The processor then knows the
    /// code, but not the outcomes of the pass's branches.
    pub fn warm_up(&self, width: Width, hits: &mut [Hit<f32>]) {
        for set in &self.sets {
            match width {
                Width::OneByOne => (touch(&set.rays), touch(&set.primitives)),
                Width::EightRays => (touch(&set.packets), touch(&set.primitives)),
                Width::EightPrimitives => (touch(&set.rays), touch(&set.groups)),
            };
        }
        self.other.pass(width, &mut hits[..self.other.rays.len()]);
    }

    /// Share of the calls at this width that hit anything.
    fn hit_share(&self, width: Width) -> f64 {
        let counts = self.sets.iter().map(|set| set.hits_and_calls(width));
        let [hits, tests] = counts.fold([0; 2], |[a, b], [c, d]| [a + c, b + d]);
        hits as f64 / tests as f64
    }

    /// Nanoseconds per ray for the setup: scalar, and in packets.
    fn setup_ns(&self) -> [f64; 2] {
        let time = |run: &dyn Fn()| {
            let passes = 250;
            let samples = (0..5).map(|_| {
                let start = Instant::now();
                (0..passes).for_each(|_| run());
                start.elapsed().as_secs_f64() * 1e9 / (passes * self.other.rays.len()) as f64
            });
            median(&samples.collect::<Vec<_>>())
        };
        [
            time(&|| {
                for ray in &self.other.rays {
                    black_box(<K as Intersect<f32>>::setup(black_box(ray)));
                }
            }),
            time(&|| {
                for packet in &self.other.packets {
                    black_box(<K as Intersect<f32x8>>::setup(black_box(packet)));
                }
            }),
        ]
    }
}

/// Reads all values.
fn touch<T: Copy>(values: &[T]) {
    for value in values {
        black_box(*value);
    }
}

/// One width of one kernel, ready to be timed.
struct Job {
    id: String,
    width: Width,
    hit_share: f64,
    warm_up: Run,
    pass: Run,
}

/// The warm-up or the pass of a job.
type Run = Box<dyn Fn(&mut [Hit<f32>]) + Send + Sync>;

/// Every kernel is timed with each of these numbers of threads.
const THREAD_COUNTS: [usize; 2] = [1, 2];

impl Job {
    /// Its name with this number of threads.
    fn name(&self, threads: usize) -> String {
        format!("{}, {}, threads: {threads}", self.id, self.width.name())
    }
}

/// The jobs of all registered kernels.
#[derive(Default)]
pub(crate) struct Speed {
    pub(crate) methods: Vec<MethodRow>,
    jobs: Vec<Job>,
    /// The timed loop without a test.
    loops: Vec<Job>,
    seed: u64,
}

impl Speed {
    /// Prepares the jobs of every registered kernel.
    pub(crate) fn new(seed: u64) -> Self {
        let empty = Arc::new(Bench::<EmptyKernel<f32>>::new(Workload::Generic, seed));
        let mut speed = Self { seed, loops: jobs(&empty).into(), ..Self::default() };
        crate::registry::all(&mut speed);
        speed
    }

    /// Every job with each number of threads, and the loop without a test. All jobs with one thread come before those
    /// with two, so that no job is timed twice in a row. A sample is the nanoseconds per test, all threads together,
    /// and the checksum of the hits.
    pub(crate) fn timed_jobs(&self) -> Vec<TimedJob<'_>> {
        let of_threads = |threads| self.jobs.iter().chain(&self.loops).map(move |job| (job, threads));
        let timed_job = |(job, threads): (_, usize)| TimedJob {
            name: Job::name(job, threads),
            sample: Box::new(move || {
                let (seconds, sums) = timed(job, threads)?;
                if sums.iter().any(|sum| *sum != sums[0]) {
                    return Err(Error::Disagreement(format!("two threads of {}", job.name(threads))));
                }
                Ok((seconds * 1e9 / (threads * RAYS * PRIMITIVES) as f64, sums[0]))
            }),
        };
        THREAD_COUNTS.into_iter().flat_map(of_threads).map(timed_job).collect()
    }

    /// The rows of all kernels, from their times.
    ///
    /// # Errors
    /// If two widths or thread counts of a kernel gave different hits: a timing of wrong results is worthless. Or if a
    /// kernel was not timed.
    pub(crate) fn rows(&self, all: &[Times]) -> Result<Vec<SpeedRow>, Error> {
        Self::rows_of(&self.jobs.iter().collect::<Vec<_>>(), all)
    }

    /// The rows of another build, without the kernels that it lacks.
    ///
    /// # Errors
    /// Like [`Speed::rows`].
    pub(crate) fn rows_of_other_build(&self, all: &[Times]) -> Result<Vec<SpeedRow>, Error> {
        let is_there = |job: &&Job| all.iter().any(|times| times.name == job.name(1));
        Self::rows_of(&self.jobs.iter().filter(is_there).collect::<Vec<_>>(), all)
    }

    /// The rows of the loop without a test.
    ///
    /// # Errors
    /// Like [`Speed::rows`].
    pub(crate) fn loop_rows(&self, all: &[Times]) -> Result<Vec<SpeedRow>, Error> {
        Self::rows_of(&self.loops.iter().collect::<Vec<_>>(), all)
    }

    fn rows_of(jobs: &[&Job], all: &[Times]) -> Result<Vec<SpeedRow>, Error> {
        let of_threads = |threads| jobs.iter().map(move |&job| (job, threads));
        let row = |(job, threads): (&Job, usize)| {
            let times = of_job(all, &job.name(threads))?;
            let first = jobs.iter().find(|other| other.id == job.id).expect("the list contains the job itself");
            if times.checksum != of_job(all, &first.name(1))?.checksum {
                return Err(Error::Disagreement(format!("{} and {}", first.name(1), job.name(threads))));
            }
            let untimed = || Error::Disagreement(format!("{}: it has no samples", times.name));
            let ns = typical(&times.ns).ok_or_else(untimed)?;
            Ok(SpeedRow {
                id: job.id.clone(),
                width: job.width.name().into(),
                threads,
                ns_per_test: ns.value,
                ns_per_test_low: ns.low,
                ns_per_test_high: ns.high,
                tests_per_second: 1e9 / ns.value,
                hit_share: job.hit_share,
                ns_of_rounds: times.ns.clone(),
                checksum: format!("{:016x}", times.checksum),
            })
        };
        THREAD_COUNTS.into_iter().flat_map(of_threads).map(row).collect()
    }
}

impl<S: Subject> Visitor<S> for Speed {
    fn visit<K: Kernel<Shape = S>>(&mut self) {
        let bench = Bench::<K>::new(Workload::Generic, self.seed);
        let [setup_ns, setup_ns_packet] =
            if size_of::<<K as Intersect<f32>>::Setup>() == 0 { [0.0; 2] } else { bench.setup_ns() };
        self.methods.push(MethodRow {
            id: K::INFO.id.to_string(),
            family: S::FAMILY.into(),
            idea: K::INFO.idea.into(),
            source: K::INFO.source.into(),
            operations: K::INFO.operations.into(),
            prepared_bytes: size_of::<K>(),
            set_bytes: bench.other.bytes(),
            setup_bytes: size_of::<<K as Intersect<f32>>::Setup>(),
            setup_ns,
            setup_ns_packet,
            claims: K::INFO.claims.iter().map(|claim| claim.name().into()).collect(),
        });
        self.jobs.extend(jobs(&Arc::new(bench)));
    }
}

/// A job for each width of a kernel.
fn jobs<K: Kernel>(bench: &Arc<Bench<K>>) -> [Job; 3]
where
    K::Shape: Subject,
{
    Width::ALL.map(|width| {
        let run = |run: fn(&Bench<K>, Width, &mut [Hit<f32>])| -> Run {
            let bench = Arc::clone(bench);
            Box::new(move |hits| run(&bench, width, hits))
        };
        let (warm_up, pass) = (run(Bench::warm_up), run(Bench::pass));
        Job { id: K::INFO.id.to_string(), width, hit_share: bench.hit_share(width), warm_up, pass }
    })
}

/// Runs the job once on each of `threads` threads at the same time. Returns the seconds until the last one is done, and
/// the checksum of each.
///
/// # Errors
/// If the system does not grant the threads.
fn timed(job: &Job, threads: usize) -> Result<(f64, Vec<u64>), Error> {
    let waiting = AtomicIsize::new(threads.cast_signed());
    let run = || {
        let mut hits = vec![Hit::MISS; RAYS];
        (job.warm_up)(&mut hits);
        // Spin until all threads are ready: one that slept could wake up when the others are half done.
        waiting.fetch_sub(1, Ordering::AcqRel);
        while waiting.load(Ordering::Acquire) > 0 {
            std::thread::yield_now();
        }
        let start = Instant::now();
        (job.pass)(&mut hits);
        (start, Instant::now(), checksum(&hits))
    };
    let done = std::thread::scope(|scope| {
        let others = (1..threads).map(|_| std::thread::Builder::new().spawn_scoped(scope, run));
        // The threads that did start need not wait for the others.
        let others = others.collect::<io::Result<Vec<_>>>().inspect_err(|_| waiting.store(0, Ordering::Release))?;
        let mut done = vec![run()];
        done.extend(others.into_iter().map(|other| other.join().expect("timed jobs do not panic")));
        Ok(done)
    });
    let done = done.map_err(|error: io::Error| threads_refused(threads, &error))?;
    let start = done.iter().map(|(start, ..)| *start).min().expect("at least one thread ran");
    let end = done.iter().map(|(_, end, _)| *end).max().expect("at least one thread ran");
    Ok(((end - start).as_secs_f64(), done.into_iter().map(|(.., sum)| sum).collect()))
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    struct Benches;

    impl<S: Subject> Visitor<S> for Benches {
        fn visit<K: Kernel<Shape = S>>(&mut self) {
            for workload in Workload::ALL {
                let bench = Bench::<K>::new(workload, 3);
                let of =
                    |ray: &Ray<f32>| [ray.origin, ray.dir].map(|vector| vector.to_array().map(f32::to_bits)).concat();
                let rays: Vec<_> = bench.sets.iter().chain([&bench.other]).flat_map(|set| &set.rays).map(of).collect();
                assert_eq!(rays.len(), RAYS + bench.other.rays.len(), "{}", K::INFO.id);
                let different = rays.iter().collect::<HashSet<_>>().len();
                // On a grid, some rays are equal by chance.
                let least = if workload == Workload::Generic { 1.0 } else { 0.9 };
                assert!(different as f64 >= least * rays.len() as f64, "{}: {different} of {}", K::INFO.id, rays.len());
            }
        }
    }

    #[test]
    fn a_pass_does_not_repeat_its_rays() {
        crate::registry::all(&mut Benches);
    }
}
