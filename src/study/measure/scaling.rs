//! Cost of a ray against the size of the scene: one landscape with more and more triangles, always the same picture.

use super::built_scene::{BuiltScene, picture_size};
use super::ray_sets::RaySet;
use super::timing::{Job, Timing, time};
use crate::study::progress::Progress;
use crate::study::record::ScalingRow;
use crate::tracer::{Error, Mode, SceneSource, thread_pool};

/// How much to measure.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ScalingOptions {
    /// Smaller scenes, fewer rays and samples.
    pub(crate) quick: bool,
    /// Measure one more size, ten times the largest.
    pub(crate) large: bool,
}

impl ScalingOptions {
    /// The scene in all sizes. Each has about ten times as many triangles as the one before.
    fn scenes(self) -> &'static [&'static str] {
        let sizes = if self.quick {
            &["terrain:1e3", "terrain:1e4", "terrain:1e5"][..]
        } else {
            &["terrain:1e4", "terrain:1e5", "terrain:1e6", "terrain:1e7"]
        };
        &sizes[..sizes.len() - usize::from(!self.large)]
    }
}

/// Times every set of rays in every size of the scene, all interleaved. All sizes are in memory at the same time.
///
/// # Errors
/// If two runs of the same rays disagree.
pub(crate) fn measure(options: ScalingOptions, seed: u64, progress: &Progress) -> Result<Vec<ScalingRow>, Error> {
    let (size, samples) = (picture_size(options.quick), if options.quick { 3 } else { 5 });
    let build = |name: &&str| BuiltScene::new(&SceneSource::parse(name)?, (size, seed));
    let scenes = options.scenes().iter().map(build).collect::<Result<Vec<_>, _>>()?;
    progress.note("terrain: cost by size");
    let pool = thread_pool(1)?;
    let scenes_and_sets = || scenes.iter().flat_map(|built| built.sets.iter().map(move |set| (built, set)));
    let jobs: Vec<_> =
        scenes_and_sets().map(|(built, set)| Job { scene: &built.scene, set, mode: Mode::Auto, pool: &pool }).collect();
    let row = |((built, set), timing): ((&BuiltScene, &RaySet), Timing)| {
        let [ns_per_ray, ns_per_ray_mad] = timing.ns_per_ray();
        ScalingRow {
            scene: built.name.clone(),
            triangles: built.scene.primitives(),
            rays: set.name.into(),
            ray_count: timing.rays,
            hits: timing.hits,
            kernel: built.kernel(),
            ns_per_ray,
            ns_per_ray_mad,
            build_seconds: built.build_seconds,
            bytes_per_triangle: built.bytes_per_triangle(),
            checksum: format!("{:016x}", timing.checksum),
        }
    };
    Ok(scenes_and_sets().zip(time(&jobs, samples, progress)?).map(row).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_size_is_ten_times_the_one_before() {
        for (quick, large, count) in [(true, false, 2), (true, true, 3), (false, false, 3), (false, true, 4)] {
            let scenes = ScalingOptions { quick, large }.scenes();
            let exponents =
                scenes.iter().map(|scene| scene.strip_prefix("terrain:1e").unwrap().parse::<i32>().unwrap());
            let first = if quick { 3 } else { 4 };
            assert!(exponents.eq(first..first + count), "{scenes:?}");
        }
    }
}
