//! What a tracer needs to take part in the comparison: the trait [`Tracer`], and this crate as a contender.

use std::fmt;

use glam::Affine3;
use rayon::prelude::*;

use crate::geom::{Hit, Ray, Triangle};
use crate::kernels::{Claim, Kernel};
use crate::study::record::OURS;
use crate::tracer::{Geometry, Mesh, Mode, Scene, World, trace_set_into};

/// A scene that is ready to be traced by some tracer.
pub trait Tracer: Send + Sync {
    /// Finds the closest hit of every ray, or, with `any_hit`, only whether there is a hit. Runs on the threads of the
    /// current rayon pool. Up to rounding, hits are those of [`trace`](crate::tracer::trace).
    fn trace(&self, rays: &[Ray<f32>], any_hit: bool, hits: &mut [Hit<f32>]);
}

/// This crate in one of its modes.
struct Ours<'a, K: Kernel> {
    scene: &'a Scene<K>,
    mode: Mode,
}

impl<K: Kernel<Shape = Triangle>> Tracer for Ours<'_, K> {
    fn trace(&self, rays: &[Ray<f32>], any_hit: bool, hits: &mut [Hit<f32>]) {
        trace_set_into(self.scene, rays, any_hit, self.mode, hits);
    }
}

/// Splits rays and hits into chunks of 1024, and calls `trace` for each on the threads of the current rayon pool. For
/// tracers that have no threads of their own.
pub fn in_chunks(rays: &[Ray<f32>], hits: &mut [Hit<f32>], trace: impl Fn(&[Ray<f32>], &mut [Hit<f32>]) + Sync) {
    const CHUNK: usize = 1024;
    hits.par_chunks_mut(CHUNK).zip(rays.par_chunks(CHUNK)).for_each(|(hits, rays)| trace(rays, hits));
}

/// A tracer in one configuration.
pub struct Contender<'a> {
    /// Name of the tracer: [`OURS`], or the name of a crate or library.
    pub tracer: &'static str,
    /// Configuration of the tracer. For this crate, the mode.
    pub configuration: String,
    /// Whether its authors promise that no ray passes between two triangles that share an edge.
    pub watertight: bool,
    /// Seconds to build its tree.
    pub build_seconds: f64,
    /// Bytes of memory; `None` if unknown.
    pub bytes: Option<usize>,
    /// The scene, ready to be traced.
    pub scene: Box<dyn Tracer + 'a>,
}

impl fmt::Debug for Contender<'_> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{} {}", self.tracer, self.configuration)
    }
}

/// This crate in each of its modes, scalar first.
pub fn ours<K: Kernel<Shape = Triangle>>(scene: &Scene<K>, build_seconds: f64) -> [Contender<'_>; 4] {
    Mode::ALL.map(|mode| Contender {
        tracer: OURS,
        configuration: mode.name().into(),
        watertight: K::INFO.claims.contains(&Claim::EdgeWatertight),
        build_seconds,
        bytes: Some(scene.bytes()),
        scene: Box::new(Ours { scene, mode }),
    })
}

/// The mesh of a world that consists of one mesh, without a transform. Its primitive numbers are then those of its
/// triangles. `None` for any other world: peers that know no instances or quadrics could not trace it.
pub fn plain_mesh(world: &World) -> Option<&Mesh> {
    match (world.geometries(), world.instances()) {
        ([Geometry::Mesh(mesh)], [only]) if only.object_to_world == Affine3::IDENTITY => Some(mesh),
        _ => None,
    }
}
