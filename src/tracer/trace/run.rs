//! Tracing many rays in a mode, on the threads of the current rayon pool.

use rayon::prelude::*;

use super::incoherent::{self, IncoherentRays};
use super::mode::Mode;
use crate::geom::{Hit, Ray, Triangle};
use crate::kernels::Kernel;
use crate::tracer::scene::{Filtered, Scene, Scratch, Visible};
use crate::tracer::walk::block::{self, Outcome};
use crate::tracer::walk::filter::{Everything, Filter};
use crate::tracer::walk::{Counter, TraversalStats};

/// Rays per task. Incoherent rays become one stream per octant. A task is small enough to balance the threads and to
/// stay in the cache, and large enough for its rays to share nodes.
const CHUNK: usize = incoherent::CAPACITY;
/// Rays that are sorted by octant together before they become packets.
const PACKET_GROUP: usize = 256;

/// What rays can be traced through: a [`Scene`], or a [part of one](Filtered).
pub trait Traceable: parts::Parts {}

impl<K: Kernel<Shape = Triangle>> Traceable for Scene<K> {}

impl<K: Kernel<Shape = Triangle>, F: Filter + Sync> Traceable for Filtered<'_, K, F> {}

mod parts {
    use super::*;

    /// What [`Traceable`] consists of. No other crate can implement it.
    pub trait Parts: Sync {
        type Kernel: Kernel<Shape = Triangle>;
        type Filter: Filter + Sync;

        /// The scene, and what of it counts.
        fn parts(&self) -> (&Scene<Self::Kernel>, &Visible<Self::Filter>);
    }

    impl<K: Kernel<Shape = Triangle>> Parts for Scene<K> {
        type Kernel = K;
        type Filter = Everything;

        fn parts(&self) -> (&Scene<K>, &Visible<Everything>) {
            (self, &Visible::EVERYTHING)
        }
    }

    impl<K: Kernel<Shape = Triangle>, F: Filter + Sync> Parts for Filtered<'_, K, F> {
        type Kernel = K;
        type Filter = F;

        fn parts(&self) -> (&Scene<K>, &Visible<F>) {
            (self.scene(), self.visible())
        }
    }
}

/// The closest hit of every ray, in ray order, on the threads of the current rayon pool. Hits are the same for every
/// mode and number of threads.
pub fn trace(scene: &impl Traceable, rays: &[Ray<f32>], mode: Mode) -> Vec<Hit<f32>> {
    let mut hits = vec![Hit::MISS; rays.len()];
    trace_into(scene, rays, mode, &mut hits);
    hits
}

/// [`trace`] into an existing slice.
///
/// # Panics
/// If `hits` and `rays` differ in length.
pub fn trace_into(scene: &impl Traceable, rays: &[Ray<f32>], mode: Mode, hits: &mut [Hit<f32>]) {
    trace_chunks::<false>(scene, rays, mode, hits);
}

/// Whether each ray hits anything, in ray order: for shadows and visibility. It is known sooner than the closest hit.
pub fn occluded(scene: &impl Traceable, rays: &[Ray<f32>], mode: Mode) -> Vec<bool> {
    let mut occluded = vec![false; rays.len()];
    occluded_into(scene, rays, mode, &mut occluded);
    occluded
}

/// [`occluded`] into an existing slice.
///
/// # Panics
/// If `occluded` and `rays` differ in length.
pub fn occluded_into(scene: &impl Traceable, rays: &[Ray<f32>], mode: Mode, occluded: &mut [bool]) {
    assert_eq!(rays.len(), occluded.len(), "one outcome for each ray");
    let (scene, visible) = scene.parts();
    let memory = || (Scratch::new(), [Hit::MISS; CHUNK]);
    occluded.par_chunks_mut(CHUNK).zip(rays.par_chunks(CHUNK)).for_each_init(
        memory,
        |(scratch, hits), (masks, rays)| {
            let hits = &mut hits[..rays.len()];
            trace_chunk::<true, _>(scene, visible, rays, mode, hits, scratch, &mut ());
            for (mask, hit) in masks.iter_mut().zip(hits) {
                *mask = hit.mask;
            }
        },
    );
}

/// [`trace_into`]; with `any_hit`, the hits tell only what [`occluded`] tells, and their fields are zero.
#[cfg(feature = "study")]
pub(crate) fn trace_set_into(
    scene: &impl Traceable,
    rays: &[Ray<f32>],
    any_hit: bool,
    mode: Mode,
    hits: &mut [Hit<f32>],
) {
    if any_hit {
        trace_chunks::<true>(scene, rays, mode, hits);
    } else {
        trace_chunks::<false>(scene, rays, mode, hits);
    }
}

fn trace_chunks<const ANY: bool>(scene: &impl Traceable, rays: &[Ray<f32>], mode: Mode, hits: &mut [Hit<f32>]) {
    assert_eq!(rays.len(), hits.len(), "hits and rays must have the same length");
    let (scene, visible) = scene.parts();
    hits.par_chunks_mut(CHUNK).zip(rays.par_chunks(CHUNK)).for_each_init(Scratch::new, |scratch, (hits, rays)| {
        trace_chunk::<ANY, _>(scene, visible, rays, mode, hits, scratch, &mut ());
    });
}

/// Traces the rays on one thread and returns statistics: as [`occluded`] does with `any_hit`, otherwise as [`trace`].
pub fn traversal_stats<K: Kernel<Shape = Triangle>>(
    scene: &Scene<K>,
    rays: &[Ray<f32>],
    any_hit: bool,
    mode: Mode,
) -> TraversalStats {
    let mut stats = TraversalStats { rays: rays.len() as u64, ..TraversalStats::default() };
    let (mut hits, mut scratch) = ([Hit::MISS; CHUNK], Scratch::new());
    for rays in rays.chunks(CHUNK) {
        let hits = &mut hits[..rays.len()];
        if any_hit {
            trace_chunk::<true, K>(scene, &Visible::EVERYTHING, rays, mode, hits, &mut scratch, &mut stats);
        } else {
            trace_chunk::<false, K>(scene, &Visible::EVERYTHING, rays, mode, hits, &mut scratch, &mut stats);
        }
    }
    stats
}

/// Traces at most [`CHUNK`] rays.
fn trace_chunk<const ANY: bool, K: Kernel<Shape = Triangle>>(
    scene: &Scene<K>,
    visible: &Visible<impl Filter>,
    rays: &[Ray<f32>],
    mode: Mode,
    hits: &mut [Hit<f32>],
    scratch: &mut Scratch,
    counter: &mut impl Counter,
) {
    match mode {
        Mode::Scalar => {
            for (hit, ray) in hits.iter_mut().zip(rays) {
                *hit = scene.trace_scalar::<ANY>(ray, visible, scratch, counter);
            }
        }
        Mode::Single => {
            for (hit, ray) in hits.iter_mut().zip(rays) {
                *hit = scene.trace_single::<ANY>(ray, visible, scratch, counter);
            }
        }
        Mode::Packet | Mode::Auto => {
            if scene.is_one_mesh() && !scene.shows_any(visible) {
                return hits.fill(Hit::MISS);
            }
            let streams = mode == Mode::Auto && scene.is_one_mesh();
            let group = if streams { CHUNK } else { PACKET_GROUP };
            for (hits, rays) in hits.chunks_mut(group).zip(rays.chunks(group)) {
                let mut incoherent =
                    trace_blocks::<ANY, K>(scene, &visible.filter, rays, hits, scratch, counter).by_octant();
                if streams {
                    incoherent.trace_streams::<ANY, K>(scene, &visible.filter, rays, hits, scratch, counter);
                } else {
                    incoherent.trace_packets::<ANY, K>(scene, visible, rays, hits, scratch, counter);
                }
            }
        }
    }
}

/// Traces consecutive rays as blocks. Returns the rays whose hits are not known yet.
fn trace_blocks<const ANY: bool, K: Kernel<Shape = Triangle>>(
    scene: &Scene<K>,
    filter: &impl Filter,
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
            match scene.trace_block::<ANY>(rays, hits, filter, scratch, counter) {
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
