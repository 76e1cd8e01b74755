//! How a tracer takes part in the comparison.

use std::fmt;

use glam::Affine3;
use rayon::prelude::*;

use crate::geom::{Hit, Ray, Triangle};
use crate::kernels::{Claim, Kernel};
use crate::study::record::OURS;
use crate::tracer::{Geometry, Mesh, Mode, Scene, World, trace_into};

/// A scene that is ready to be traced, by whatever means.
pub trait Tracer: Send + Sync {
    /// Traces every ray for its closest hit, or with `any_hit` only for whether there is one, on the threads of the current
    /// rayon pool. Hits are those of [`trace_into`], but for rounding.
    fn trace(&self, rays: &[Ray<f32>], any_hit: bool, hits: &mut [Hit<f32>]);
}

/// This crate, in one of its modes.
struct Ours<'a, K: Kernel> {
    scene: &'a Scene<K>,
    mode: Mode,
}

impl<K: Kernel<Shape = Triangle>> Tracer for Ours<'_, K> {
    fn trace(&self, rays: &[Ray<f32>], any_hit: bool, hits: &mut [Hit<f32>]) {
        trace_into(self.scene, rays, any_hit, self.mode, hits);
    }
}

/// Hands out a thousand rays at a time, and the room for their hits, to the threads of the current rayon pool: what a tracer
/// without threads of its own needs around it.
pub fn in_chunks(rays: &[Ray<f32>], hits: &mut [Hit<f32>], trace: impl Fn(&[Ray<f32>], &mut [Hit<f32>]) + Sync) {
    const CHUNK: usize = 1024;
    hits.par_chunks_mut(CHUNK).zip(rays.par_chunks(CHUNK)).for_each(|(hits, rays)| trace(rays, hits));
}

/// A tracer in one configuration.
pub struct Contender<'a> {
    /// Whose: [`OURS`], or the name of a crate or library.
    pub tracer: &'static str,
    /// How it is set up. Ours: the mode.
    pub configuration: String,
    /// Whether no ray slips through between triangles that share an edge, by its authors' word.
    pub watertight: bool,
    /// Seconds to build it.
    pub build_seconds: f64,
    /// What it takes in memory, where that can be told.
    pub bytes: Option<usize>,
    /// The scene in it.
    pub scene: Box<dyn Tracer + 'a>,
}

impl fmt::Debug for Contender<'_> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{} {}", self.tracer, self.configuration)
    }
}

/// This crate in each of its modes, the scalar one first.
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

/// The mesh of a world that is nothing but one mesh as it is, so that primitive numbers are those of its triangles; `None` of
/// any other, for which peers without instances or quadrics would do other work.
pub fn plain_mesh(world: &World) -> Option<&Mesh> {
    match (world.geometries(), world.instances()) {
        ([Geometry::Mesh(mesh)], [only]) if only.object_to_world == Affine3::IDENTITY => Some(mesh),
        _ => None,
    }
}
