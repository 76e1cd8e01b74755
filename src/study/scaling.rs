//! Cost of a ray against the size of the scene: one landscape, of ever more triangles, seen in one picture.

use std::time::Instant;

use super::ray_sets::{RaySet, ray_sets};
use super::record::ScalingRow;
use super::timing::{Job, time};
use super::{Progress, TracedWith};
use crate::kernels::Kernel;
use crate::tracer::{Error, LoadedScene, Mode, Scene, SceneSource, thread_pool};

/// How much of it to measure.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    /// Smaller scenes, fewer rays and samples.
    pub(super) quick: bool,
    /// One size more.
    pub(super) large: bool,
}

impl Extent {
    /// The scene in all sizes, each about ten times the one before.
    fn scenes(self) -> &'static [&'static str] {
        let sizes = if self.quick {
            &["terrain:1e3", "terrain:1e4", "terrain:1e5"][..]
        } else {
            &["terrain:1e4", "terrain:1e5", "terrain:1e6", "terrain:1e7"]
        };
        &sizes[..sizes.len() - usize::from(!self.large)]
    }
}

/// A scene and its rays.
struct Stage {
    name: &'static str,
    scene: Scene<TracedWith>,
    build_seconds: f64,
    sets: [RaySet; 4],
}

/// Times every set of rays in every size of the scene, interleaved: all sizes are held in memory at once.
///
/// # Errors
/// If two runs of the same rays disagree.
pub(super) fn measure(extent: Extent, seed: u64, progress: &Progress) -> Result<Vec<ScalingRow>, Error> {
    let (size, samples) = if extent.quick { (64, 3) } else { (512, 7) };
    let mut stages = Vec::new();
    for &name in extent.scenes() {
        progress.note(&format!("{name}: building"));
        let LoadedScene { world, view, .. } = SceneSource::parse(name)?.load()?;
        let start = Instant::now();
        let scene = Scene::<TracedWith>::new(world);
        let build_seconds = start.elapsed().as_secs_f64();
        let sets = ray_sets(&scene, &view, size, seed);
        stages.push(Stage { name, scene, build_seconds, sets });
    }
    progress.note("terrain: cost by size");
    let pool = thread_pool(1)?;
    let places = || stages.iter().flat_map(|stage| stage.sets.iter().map(move |set| (stage, set)));
    let jobs: Vec<Job<TracedWith>> =
        places().map(|(stage, set)| Job { scene: &stage.scene, set, mode: Mode::Auto, pool: &pool }).collect();
    let row = |((stage, set), timing): ((&Stage, &RaySet), super::timing::Timing)| {
        let [ns_per_ray, ns_per_ray_mad] = timing.ns_per_ray();
        ScalingRow {
            scene: stage.name.into(),
            triangles: stage.scene.primitives(),
            rays: set.name.into(),
            ray_count: timing.rays,
            hits: timing.hits,
            kernel: TracedWith::INFO.id.to_string(),
            ns_per_ray,
            ns_per_ray_mad,
            build_seconds: stage.build_seconds,
            bytes_per_triangle: stage.scene.bytes() as f64 / stage.scene.primitives() as f64,
            checksum: format!("{:016x}", timing.checksum),
        }
    };
    Ok(places().zip(time(&jobs, samples)?).map(row).collect())
}
