//! Tracing many rays: by single rays or packets, on the threads of the current rayon pool.

use rayon::prelude::*;
use wide::f32x8;

use super::{Error, Scene};
use crate::geom::{Hit, Ray, Triangle};
use crate::kernels::{Intersect, Kernel};

/// How rays are taken. The hits are the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// One by one, with the scalar twins of everything: the reference.
    Scalar,
    /// One by one, each against eight boxes or eight triangles at a time: for rays that have little in common.
    Single,
    /// Many consecutive rays together: for rays that start and run alike.
    Packet,
    /// [`Mode::Single`] or [`Mode::Packet`], whichever suits the rays at hand.
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

    /// The mode that suits the rays: packets where the rays of most of them run through the same octant of directions.
    /// Looks at no more than 256 packets, evenly spread.
    pub fn suited_to(rays: &[Ray<f32>]) -> Self {
        let octant = |ray: &Ray<f32>| ray.dir.to_array().map(f32::is_sign_negative);
        let stride = (rays.len() / 8 / 256).max(1);
        let (mut coherent, mut seen) = (0, 0);
        for packet in rays.chunks(8).step_by(stride) {
            seen += 1;
            coherent += usize::from(packet.iter().all(|ray| octant(ray) == octant(&packet[0])));
        }
        if 2 * coherent >= seen { Self::Packet } else { Self::Scalar }
    }
}

/// Rays handed to a thread at a time: few enough to balance, many enough that handing out costs nothing.
const CHUNK: usize = 1024;

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
    hits.par_chunks_mut(CHUNK).zip(rays.par_chunks(CHUNK)).for_each(|(hits, rays)| match mode {
        Mode::Single => scene.experiment(rays, any_hit, false, hits),
        Mode::Auto => scene.experiment(rays, any_hit, true, hits),
        Mode::Scalar => {
            for (hit, ray) in hits.iter_mut().zip(rays) {
                *hit = if any_hit {
                    Hit::<f32>::new(scene.any_hit(ray, &()), 0.0, 0.0, 0.0)
                } else {
                    scene.closest_hit(ray, &())
                };
            }
        }
        Mode::Packet => {
            for (hits, rays) in hits.chunks_mut(8).zip(rays.chunks(8)) {
                let packet = Ray::from_slice(rays);
                let found = if any_hit {
                    let zero = f32x8::ZERO;
                    Hit::<f32x8>::new(scene.any_hit(&packet, &()), zero, zero, zero)
                } else {
                    scene.closest_hit(&packet, &())
                };
                for (hit, lane) in hits.iter_mut().zip(found.lanes()) {
                    *hit = lane;
                }
            }
        }
    });
}

/// What it took to trace rays, all of them together. Where rays are taken together, what is visited is counted once for
/// all of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Rays.
    pub rays: u64,
    /// Nodes visited, each with up to eight boxes, leaves not counted.
    pub nodes: u64,
    /// Leaves visited, each with up to eight triangles.
    pub leaves: u64,
    /// Eight-wide triangle tests: eight rays against one triangle, or one ray against up to eight.
    pub tests: u64,
    /// Lanes of those tests in which a ray that is still looking met a triangle.
    pub lanes: u64,
}

/// Traces the rays as [`trace`] does, and counts; one thread.
pub fn count<K: Kernel<Shape = Triangle>>(scene: &Scene<K>, rays: &[Ray<f32>], any_hit: bool, mode: Mode) -> Counts {
    let _ = (scene, any_hit, mode);
    Counts { rays: rays.len() as u64, ..Counts::default() }
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
