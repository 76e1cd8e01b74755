//! Tracing many rays in a mode, on the threads of the current rayon pool.

use rayon::prelude::*;

use super::incoherent::{self, IncoherentRays};
use super::mode::Mode;
use crate::geom::{Hit, Ray, Triangle};
use crate::kernels::Kernel;
use crate::tracer::scene::{Scene, Scratch};
use crate::tracer::walk::block::{self, Outcome};
use crate::tracer::walk::{Counter, TraversalStats};

/// Rays per task. Incoherent rays become one stream per octant. A task is small enough to balance the threads and to
/// stay in the cache, and large enough for its rays to share nodes.
const CHUNK: usize = incoherent::CAPACITY;
/// Rays that are sorted by octant together before they become packets.
const PACKET_GROUP: usize = 256;

/// Traces every ray and returns the hits in ray order. They are the same for every mode and number of threads.
///
/// A hit is the closest one. With `any_hit` it only tells whether there is any: `t`, `u`, `v`, `primitive` and
/// `instance` are then zero.
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

/// [`trace`] into an existing slice.
///
/// # Panics
/// If `hits` and `rays` differ in length.
pub fn trace_into<K: Kernel<Shape = Triangle>>(
    scene: &Scene<K>,
    rays: &[Ray<f32>],
    any_hit: bool,
    mode: Mode,
    hits: &mut [Hit<f32>],
) {
    assert_eq!(rays.len(), hits.len(), "hits and rays must have the same length");
    hits.par_chunks_mut(CHUNK).zip(rays.par_chunks(CHUNK)).for_each_init(Scratch::new, |scratch, (hits, rays)| {
        trace_chunk(scene, rays, any_hit, mode, hits, scratch, &mut ());
    });
}

/// Traces the rays as [`trace`] does, on one thread, and returns statistics.
pub fn count<K: Kernel<Shape = Triangle>>(
    scene: &Scene<K>,
    rays: &[Ray<f32>],
    any_hit: bool,
    mode: Mode,
) -> TraversalStats {
    let mut stats = TraversalStats { rays: rays.len() as u64, ..TraversalStats::default() };
    let (mut hits, mut scratch) = ([Hit::MISS; CHUNK], Scratch::new());
    for rays in rays.chunks(CHUNK) {
        trace_chunk(scene, rays, any_hit, mode, &mut hits[..rays.len()], &mut scratch, &mut stats);
    }
    stats
}

/// Traces at most [`CHUNK`] rays.
fn trace_chunk<K: Kernel<Shape = Triangle>>(
    scene: &Scene<K>,
    rays: &[Ray<f32>],
    any_hit: bool,
    mode: Mode,
    hits: &mut [Hit<f32>],
    scratch: &mut Scratch,
    counter: &mut impl Counter,
) {
    if any_hit {
        trace_chunk_for::<true, K>(scene, rays, mode, hits, scratch, counter);
    } else {
        trace_chunk_for::<false, K>(scene, rays, mode, hits, scratch, counter);
    }
}

fn trace_chunk_for<const ANY: bool, K: Kernel<Shape = Triangle>>(
    scene: &Scene<K>,
    rays: &[Ray<f32>],
    mode: Mode,
    hits: &mut [Hit<f32>],
    scratch: &mut Scratch,
    counter: &mut impl Counter,
) {
    match mode {
        Mode::Scalar => {
            for (hit, ray) in hits.iter_mut().zip(rays) {
                *hit = scene.trace_scalar::<ANY>(ray, scratch, counter);
            }
        }
        Mode::Single => {
            for (hit, ray) in hits.iter_mut().zip(rays) {
                *hit = scene.trace_single::<ANY>(ray, scratch, counter);
            }
        }
        Mode::Packet | Mode::Auto => {
            let streams = mode == Mode::Auto && scene.is_one_mesh();
            let group = if streams { CHUNK } else { PACKET_GROUP };
            for (hits, rays) in hits.chunks_mut(group).zip(rays.chunks(group)) {
                let mut incoherent = trace_blocks::<ANY, K>(scene, rays, hits, scratch, counter).by_octant();
                if streams {
                    incoherent.trace_streams::<ANY, K>(scene, rays, hits, scratch, counter);
                } else {
                    incoherent.trace_packets::<ANY, K>(scene, rays, hits, scratch, counter);
                }
            }
        }
    }
}

/// Traces consecutive rays as blocks. Returns the rays whose hits are not known yet.
fn trace_blocks<const ANY: bool, K: Kernel<Shape = Triangle>>(
    scene: &Scene<K>,
    rays: &[Ray<f32>],
    hits: &mut [Hit<f32>],
    scratch: &mut Scratch,
    counter: &mut impl Counter,
) -> IncoherentRays {
    let mut incoherent = IncoherentRays::new();
    // After each block in a row that gave up, twice as many blocks are skipped.
    let (mut given_up, mut skip) = (0, 0);
    for (block, rays) in rays.chunks(block::RAYS).enumerate() {
        let start = block * block::RAYS;
        let hits = &mut hits[start..start + rays.len()];
        if skip > 0 {
            skip -= 1;
            hits.fill(Hit::MISS);
        } else {
            match scene.trace_block::<ANY>(rays, hits, scratch, counter) {
                Outcome::Traced => {
                    given_up = 0;
                    continue;
                }
                Outcome::GivenUp => {
                    given_up += 1;
                    skip = 1 << given_up;
                }
                Outcome::Incoherent => {}
            }
        }
        incoherent.extend(start, rays, hits);
    }
    incoherent
}

/// FNV-1a over the bits of every hit, in order. Equal hits have equal checksums.
pub fn checksum(hits: &[Hit<f32>]) -> u64 {
    hits.iter()
        .flat_map(Hit::to_bits)
        .fold(0xcbf2_9ce4_8422_2325, |hash, word| (hash ^ u64::from(word)).wrapping_mul(0x0000_0100_0000_01b3))
}
