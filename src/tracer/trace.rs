//! Tracing many rays: one by one or together, on the threads of the current rayon pool.

use rayon::prelude::*;

use super::block::{self, Outcome};
use super::packet::packet;
use super::scene::Scratch;
use super::stream;
use super::tally::Tally;
use super::{Counts, Error, Scene};
use crate::geom::{Hit, Ray, Triangle};
use crate::kernels::Kernel;

/// How rays are taken. The hits are the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// One by one, with the scalar twins of everything: the reference.
    Scalar,
    /// One by one, each against eight boxes or eight triangles at a time: for rays that have little in common.
    Single,
    /// Blocks of consecutive rays that start and run alike; of the others, packets of eight of one octant.
    Packet,
    /// What suits the scene and the rays at hand: blocks; for rays that are not alike, streams where the scene is one mesh, and
    /// packets where there are instances.
    Auto,
}

impl Mode {
    /// Every mode.
    pub const ALL: [Self; 4] = [Self::Scalar, Self::Single, Self::Packet, Self::Auto];

    /// As used on the command line and in records.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scalar => "scalar",
            Self::Single => "single",
            Self::Packet => "packet",
            Self::Auto => "auto",
        }
    }
}

/// Rays handed to a thread at a time, of which those that are not alike make a stream for each octant: few enough to balance and
/// to stay in the cache, many enough that they share nodes.
const CHUNK: usize = stream::RAYS;
// A number of a ray and its octant are kept in 16 bits.
const _: () = assert!(8 * CHUNK <= 1 << 16);
/// Rays that make packets, by the octants of their directions.
const GROUP: usize = 256;

/// Traces every ray for its closest hit, or with `any_hit` only for whether there is one; a hit then has `t`, `u`, `v` and
/// `primitive` zero. Hits are in ray order, and the same for every mode and number of threads.
pub fn trace<K: Kernel<Shape = Triangle>>(
    scene: &Scene<K>,
    rays: &[Ray<f32>],
    any_hit: bool,
    mode: Mode,
) -> Vec<Hit<f32>> {
    let mut hits = vec![Hit::MISS; rays.len()];
    trace_into(scene, rays, any_hit, mode, &mut hits);
    hits
}

/// [`trace`] into room that is there already.
///
/// # Panics
/// If there are not as many hits as rays.
pub fn trace_into<K: Kernel<Shape = Triangle>>(
    scene: &Scene<K>,
    rays: &[Ray<f32>],
    any_hit: bool,
    mode: Mode,
    hits: &mut [Hit<f32>],
) {
    assert_eq!(rays.len(), hits.len(), "a hit for every ray");
    hits.par_chunks_mut(CHUNK).zip(rays.par_chunks(CHUNK)).for_each_init(Scratch::new, |scratch, (hits, rays)| {
        trace_chunk(scene, rays, any_hit, mode, hits, scratch, &mut ());
    });
}

/// Traces the rays as [`trace`] does, and counts; one thread.
pub fn count<K: Kernel<Shape = Triangle>>(scene: &Scene<K>, rays: &[Ray<f32>], any_hit: bool, mode: Mode) -> Counts {
    let mut counts = Counts { rays: rays.len() as u64, ..Counts::default() };
    let (mut hits, mut scratch) = ([Hit::MISS; CHUNK], Scratch::new());
    for rays in rays.chunks(CHUNK) {
        trace_chunk(scene, rays, any_hit, mode, &mut hits[..rays.len()], &mut scratch, &mut counts);
    }
    counts
}

/// Traces at most [`CHUNK`] rays.
fn trace_chunk<K: Kernel<Shape = Triangle>>(
    scene: &Scene<K>,
    rays: &[Ray<f32>],
    any_hit: bool,
    mode: Mode,
    hits: &mut [Hit<f32>],
    scratch: &mut Scratch,
    tally: &mut impl Tally,
) {
    match mode {
        Mode::Scalar => {
            for (hit, ray) in hits.iter_mut().zip(rays) {
                *hit = if any_hit {
                    found(scene.any_hit_scalar(ray, scratch, tally))
                } else {
                    scene.closest_hit_scalar(ray, scratch, tally)
                };
            }
        }
        Mode::Single => {
            for (hit, ray) in hits.iter_mut().zip(rays) {
                *hit = single(scene, ray, any_hit, scratch, tally);
            }
        }
        Mode::Packet | Mode::Auto => {
            let streams = mode == Mode::Auto && scene.is_one_mesh();
            let group = if streams { CHUNK } else { GROUP };
            for (hits, rays) in hits.chunks_mut(group).zip(rays.chunks(group)) {
                let mut others = Others::new();
                // After each block in a row that was given up, twice as many are not tried.
                let (mut given_up, mut skip) = (0, 0);
                for (block, rays) in rays.chunks(block::RAYS).enumerate() {
                    let start = block * block::RAYS;
                    let hits = &mut hits[start..start + rays.len()];
                    if skip > 0 {
                        skip -= 1;
                        hits.fill(Hit::MISS);
                    } else {
                        match trace_block(scene, rays, any_hit, hits, scratch, tally) {
                            Outcome::Traced => {
                                given_up = 0;
                                continue;
                            }
                            Outcome::GivenUp => {
                                given_up += 1;
                                skip = 1 << given_up;
                            }
                            Outcome::Unlike => {}
                        }
                    }
                    others.extend(start, rays, hits);
                }
                if streams {
                    others.by_octant().trace_streams(scene, rays, any_hit, hits, scratch, tally);
                } else {
                    others.by_octant().trace_packets(scene, rays, any_hit, hits, scratch, tally);
                }
            }
        }
    }
}

/// What is said of any hit.
fn found(any: bool) -> Hit<f32> {
    Hit::<f32>::new(any, 0.0, 0.0, 0.0)
}

#[inline(always)]
fn single<K: Kernel<Shape = Triangle>>(
    scene: &Scene<K>,
    ray: &Ray<f32>,
    any_hit: bool,
    scratch: &mut Scratch,
    tally: &mut impl Tally,
) -> Hit<f32> {
    if any_hit {
        found(scene.any_hit_single(ray, scratch, tally))
    } else {
        scene.closest_hit_single(ray, scratch, tally)
    }
}

/// Traces the rays as a block, if that suits them. If not, some hits may be known all the same; the others are misses.
fn trace_block<K: Kernel<Shape = Triangle>>(
    scene: &Scene<K>,
    rays: &[Ray<f32>],
    any_hit: bool,
    hits: &mut [Hit<f32>],
    scratch: &mut Scratch,
    tally: &mut impl Tally,
) -> Outcome {
    if !any_hit {
        let outcome = scene.closest_hit_block(rays, hits, scratch, tally);
        if outcome != Outcome::Traced {
            hits.fill(Hit::MISS);
        }
        return outcome;
    }
    let (outcome, masks) = scene.any_hit_block(rays, scratch, tally);
    for (hits, mask) in hits.chunks_mut(8).zip(masks) {
        let bits = mask.bits();
        for (lane, hit) in hits.iter_mut().enumerate() {
            *hit = found(bits >> lane & 1 == 1);
        }
    }
    outcome
}

/// Of at most [`CHUNK`] rays, those that are not in blocks.
struct Others {
    /// Numbers of rays, and above them their octants.
    rays: [u16; CHUNK],
    len: usize,
    lens: [usize; 8],
}

impl Others {
    fn new() -> Self {
        Self { rays: [0; CHUNK], len: 0, lens: [0; 8] }
    }

    /// Adds rays, of which the first has the number `start`, except those whose hits are known.
    fn extend(&mut self, start: usize, rays: &[Ray<f32>], hits: &[Hit<f32>]) {
        for (index, ray) in rays.iter().enumerate() {
            if hits[index].mask {
                continue;
            }
            let [x, y, z] = ray.dir.to_array().map(|dir| usize::from(dir.is_sign_negative()));
            let octant = x | y << 1 | z << 2;
            self.rays[self.len % CHUNK] = (octant * CHUNK + start + index) as u16;
            self.lens[octant] += 1;
            self.len += 1;
        }
    }

    /// Sorted, in their order within each octant.
    fn by_octant(&self) -> ByOctant {
        let (mut next, mut start) = ([0; 8], 0);
        for (next, len) in next.iter_mut().zip(self.lens) {
            *next = start;
            start += len;
        }
        let mut numbers = [0; CHUNK];
        for &ray in &self.rays[..self.len] {
            let place = &mut next[usize::from(ray) / CHUNK % 8];
            numbers[*place % CHUNK] = ray % CHUNK as u16;
            *place += 1;
        }
        ByOctant { numbers, lens: self.lens }
    }
}

/// Numbers of rays, octant by octant, and how many there are of each.
struct ByOctant {
    numbers: [u16; CHUNK],
    lens: [usize; 8],
}

impl ByOctant {
    /// Traces the rays as streams.
    fn trace_streams<K: Kernel<Shape = Triangle>>(
        &mut self,
        scene: &Scene<K>,
        rays: &[Ray<f32>],
        any_hit: bool,
        hits: &mut [Hit<f32>],
        scratch: &mut Scratch,
        tally: &mut impl Tally,
    ) {
        let mut rest = &mut self.numbers[..];
        for (octant, len) in self.lens.into_iter().enumerate() {
            let numbers = rest.split_off_mut(..len).unwrap_or_default();
            if numbers.is_empty() {
                continue;
            }
            if any_hit {
                scene.trace_stream::<true>(rays, octant, numbers, hits, scratch, tally);
            } else {
                scene.trace_stream::<false>(rays, octant, numbers, hits, scratch, tally);
            }
        }
    }

    /// Traces them as packets.
    fn trace_packets<K: Kernel<Shape = Triangle>>(
        &self,
        scene: &Scene<K>,
        rays: &[Ray<f32>],
        any_hit: bool,
        hits: &mut [Hit<f32>],
        scratch: &mut Scratch,
        tally: &mut impl Tally,
    ) {
        let mut rest = &self.numbers[..];
        let octants = self.lens.map(|len| rest.split_off(..len).unwrap_or_default());
        for numbers in octants.into_iter().flat_map(|numbers| numbers.chunks(8)) {
            if let [number] = numbers {
                let number = usize::from(*number);
                hits[number] = single(scene, &rays[number], any_hit, scratch, tally);
                continue;
            }
            let ray = packet(numbers.iter().map(|&number| &rays[usize::from(number)]));
            if any_hit {
                let bits = scene.any_hit_packet(&ray, scratch, tally).bits();
                for (lane, &number) in numbers.iter().enumerate() {
                    hits[usize::from(number)] = found(bits >> lane & 1 == 1);
                }
            } else {
                let mut lanes = [Hit::MISS; 8];
                scene.closest_hit_packet(&ray, scratch, tally).write(&mut lanes);
                for (hit, &number) in lanes.iter().zip(numbers) {
                    hits[usize::from(number)] = *hit;
                }
            }
        }
    }
}

/// A pool of so many threads, to run [`trace`] or [`Scene::new`] in; 0 means as many as there are processors.
///
/// # Errors
/// If the system does not grant the threads.
pub fn thread_pool(threads: usize) -> Result<rayon::ThreadPool, Error> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|error| Error::Argument { argument: format!("{threads} threads"), message: error.to_string() })
}

/// FNV-1a over the bits of every hit, in order: equal hits have equal checksums.
pub fn checksum(hits: &[Hit<f32>]) -> u64 {
    hits.iter()
        .flat_map(Hit::to_bits)
        .fold(0xcbf2_9ce4_8422_2325, |hash, word| (hash ^ u64::from(word)).wrapping_mul(0x0000_0100_0000_01b3))
}
