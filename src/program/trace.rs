//! `raylanes trace`: traces the rays of a picture or of a file several times, and reports the median speed.

use std::path::PathBuf;
use std::time::Instant;

use raylanes::geom::{Hit, Ray, Triangle};
use raylanes::kernels::Kernel;
use raylanes::registry::Task;
use raylanes::study::{self, Progress};
use raylanes::tracer::{self, Error, Mode, World};
use rayon::ThreadPool;
use serde::Serialize;

use super::args::{HitFormat, TraceArguments};
use super::memory;
use super::scene::{ChosenKernels, Loaded};
use super::terminal;

/// A ray, its hit, its place in the picture, and its place in the file.
const BYTES_PER_RAY: usize = size_of::<Ray<f32>>() + size_of::<Hit<f32>>() + 8;

/// What `trace --json` prints.
#[derive(Serialize)]
struct TraceResult {
    scene: String,
    triangles: usize,
    quadrics: usize,
    instances: usize,
    rays: usize,
    hits: usize,
    /// Median of the repeats.
    mrays_per_second: f64,
    checksum: String,
    mode: &'static str,
    kernel: String,
    threads: usize,
    build_seconds: f64,
    /// Geometry, instances, trees and prepared primitives.
    bytes: usize,
    /// `bytes / triangles`; in a scene without triangles, `bytes / quadrics`.
    bytes_per_triangle: f64,
}

pub(super) fn run(arguments: &TraceArguments, progress: &Progress) -> Result<String, Error> {
    progress.suspend(terminal::warn_of_slow_build);
    let scene = &arguments.scene;
    // A large mesh takes long to load, so the other arguments are checked before it.
    if arguments.any_hit && arguments.hit_format == HitFormat::Wide {
        let message = "needs the closest hit, but --any-hit does not look for it".to_owned();
        return Err(Error::Argument { argument: "--hit-format wide".into(), message });
    }
    let outputs: Vec<_> = arguments.hits.iter().map(PathBuf::as_path).collect();
    outputs.iter().try_for_each(|output| tracer::check_output(output))?;
    let pool = scene.pool()?;
    let file_rays = arguments.rays.as_deref().map(tracer::read_rays).transpose()?;
    let (kernels, mode) = scene.kernels_and_mode()?;
    let Loaded { world, camera, .. } = pool.install(|| scene.load(&outputs, progress))?;
    let (width, height) = scene.size;
    let pixels = width as usize * height as usize;
    memory::check(&scene.name(), &world, file_rays.as_ref().map_or(pixels, Vec::len), BYTES_PER_RAY)?;
    let picture_order = file_rays.is_none().then(|| tracer::block_order(width, height));
    let rays = match file_rays {
        Some(rays) => rays,
        None => camera?.rays(width, height),
    };
    let result = kernels.run(Trace { kernels, mode, arguments, world, pool: &pool, rays, picture_order, progress })?;
    if arguments.json {
        return Ok(serde_json::to_string(&result).expect("plain data") + "\n");
    }
    let scene = scene.name();
    let TraceResult { triangles, quadrics, instances, rays, hits, mrays_per_second, .. } = result;
    let TraceResult { checksum, mode, kernel, threads, .. } = result;
    Ok(format!(
        "{scene}: {triangles} triangles, {quadrics} quadrics, {instances} instances, built in {:.3} s, {:.2} MB\n\
         {mrays_per_second:.2} Mrays/s (median of {}), {rays} rays, {hits} hits, checksum {checksum}\n\
         kernel {kernel}, mode {mode}, threads {threads}\n",
        result.build_seconds,
        result.bytes as f64 / 1e6,
        arguments.repeat,
    ))
}

/// Builds the scene, traces the rays and writes the hits, with the triangle kernel that is chosen at run time.
struct Trace<'a> {
    kernels: ChosenKernels,
    mode: Mode,
    arguments: &'a TraceArguments,
    world: World,
    pool: &'a ThreadPool,
    rays: Vec<Ray<f32>>,
    /// The pixel of each ray, unless the rays come from a file.
    picture_order: Option<Vec<u32>>,
    progress: &'a Progress,
}

impl Task<Triangle> for Trace<'_> {
    type Output = Result<TraceResult, Error>;

    fn run<K: Kernel<Shape = Triangle>>(self) -> Self::Output {
        let Self { kernels, mode, arguments, world, pool, rays, picture_order, progress } = self;
        let any_hit = arguments.any_hit;
        let [triangles, quadrics, instances] = [world.triangles(), world.quadrics(), world.instances().len()];
        progress.note(&format!("{}: building", arguments.scene.name()));
        let start = Instant::now();
        let scene = pool.install(|| kernels.scene::<K>(world));
        let build_seconds = start.elapsed().as_secs_f64();
        let (mut hits, mut occluded) = (vec![Hit::MISS; rays.len()], Vec::new());
        let mut trace = || {
            pool.install(|| {
                if any_hit {
                    occluded.resize(rays.len(), false);
                    tracer::occluded_into(&scene, &rays, mode, &mut occluded);
                } else {
                    tracer::trace_into(&scene, &rays, mode, &mut hits);
                }
            });
        };
        progress.note(&format!("{}: tracing", arguments.scene.name()));
        trace(); // a warm-up, which is not counted
        let mut rates = Vec::new();
        for _ in 0..arguments.repeat {
            let start = Instant::now();
            trace();
            rates.push(rays.len() as f64 / start.elapsed().as_secs_f64() / 1e6);
        }
        for (hit, mask) in hits.iter_mut().zip(occluded) {
            *hit = Hit::<f32>::new(mask, 0.0, 0.0, 0.0);
        }
        if let Some(file) = &arguments.hits {
            // The rays of a picture are traced in blocks; the file holds their hits row by row.
            let mut places: Vec<_> = (0..rays.len() as u32).collect();
            for (place, pixel) in (0..).zip(picture_order.into_iter().flatten()) {
                places[pixel as usize] = place;
            }
            let places = places.into_iter().map(|place| place as usize);
            match arguments.hit_format {
                HitFormat::Narrow => tracer::write_hits(file, places.map(|place| &hits[place]))?,
                HitFormat::Wide => {
                    tracer::write_wide_hits(file, &scene, places.map(|place| (&rays[place], &hits[place])))?;
                }
            }
        }
        Ok(TraceResult {
            scene: arguments.scene.scene.clone(),
            triangles,
            quadrics,
            instances,
            rays: rays.len(),
            hits: hits.iter().filter(|hit| hit.mask).count(),
            mrays_per_second: study::median(&rates),
            checksum: format!("{:016x}", tracer::checksum(&hits)),
            mode: mode.name(),
            kernel: K::INFO.id.to_string(),
            threads: pool.current_num_threads(),
            build_seconds,
            bytes: scene.bytes(),
            bytes_per_triangle: scene.bytes() as f64 / if triangles > 0 { triangles } else { quadrics } as f64,
        })
    }
}
