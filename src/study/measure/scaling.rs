//! Cost of a ray against the size of the scene: one landscape, of ever more triangles, seen in one picture.

use super::built_scene::Stage;
use super::ray_sets::RaySet;
use super::timing::{Job, Timing, time};
use crate::study::progress::Progress;
use crate::study::record::ScalingRow;
use crate::tracer::{Error, Mode, SceneSource, thread_pool};

/// How much of it to measure.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    /// Smaller scenes, fewer rays and samples.
    pub(crate) quick: bool,
    /// One size more.
    pub(crate) large: bool,
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

/// Times every set of rays in every size of the scene, interleaved: all sizes are held in memory at once.
///
/// # Errors
/// If two runs of the same rays disagree.
pub(crate) fn measure(extent: Extent, seed: u64, progress: &Progress) -> Result<Vec<ScalingRow>, Error> {
    let (size, samples) = if extent.quick { (64, 3) } else { (512, 5) };
    let stage = |name: &&str| Stage::set(&SceneSource::parse(name)?, (size, seed), progress);
    let stages = extent.scenes().iter().map(stage).collect::<Result<Vec<_>, _>>()?;
    progress.note("terrain: cost by size");
    let pool = thread_pool(1)?;
    let places = || stages.iter().flat_map(|stage| stage.sets.iter().map(move |set| (stage, set)));
    let jobs: Vec<_> =
        places().map(|(stage, set)| Job { scene: &stage.scene, set, mode: Mode::Auto, pool: &pool }).collect();
    let row = |((stage, set), timing): ((&Stage, &RaySet), Timing)| {
        let [ns_per_ray, ns_per_ray_mad] = timing.ns_per_ray();
        ScalingRow {
            scene: stage.name.clone(),
            triangles: stage.scene.primitives(),
            rays: set.name.into(),
            ray_count: timing.rays,
            hits: timing.hits,
            kernel: stage.kernel(),
            ns_per_ray,
            ns_per_ray_mad,
            build_seconds: stage.build_seconds,
            bytes_per_triangle: stage.bytes_per_triangle(),
            checksum: format!("{:016x}", timing.checksum),
        }
    };
    Ok(places().zip(time(&jobs, samples, progress)?).map(row).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_a_factor_of_ten_apart() {
        for (quick, large, count) in [(true, false, 2), (true, true, 3), (false, false, 3), (false, true, 4)] {
            let scenes = Extent { quick, large }.scenes();
            let exponents =
                scenes.iter().map(|scene| scene.strip_prefix("terrain:1e").unwrap().parse::<i32>().unwrap());
            let first = if quick { 3 } else { 4 };
            assert!(exponents.eq(first..first + count), "{scenes:?}");
        }
    }
}
