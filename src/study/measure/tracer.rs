//! Throughput of the tracer on the ray sets of a picture, in every mode.

use super::built_scene::BuiltScene;
use super::timing::{Job, time};
use crate::study::progress::Progress;
use crate::study::record::TracerRow;
use crate::tracer::{Error, Mode, SceneSource, thread_pool};

/// Times one scene in every mode and with each number of threads. All of them are interleaved.
///
/// # Errors
/// If the scene cannot be loaded, or if two modes or thread counts disagree about a hit.
pub(crate) fn measure(
    source: &SceneSource,
    (size, seed): (u32, u64),
    samples: usize,
    thread_counts: &[usize],
    progress: &Progress,
) -> Result<Vec<TracerRow>, Error> {
    progress.note(&format!("{}: building", source.name()));
    let built = BuiltScene::new(source, (size, seed))?;
    let pools = thread_counts.iter().map(|&threads| thread_pool(threads)).collect::<Result<Vec<_>, _>>()?;
    let mut rows = Vec::new();
    for (set, progress) in progress.each(&built.sets) {
        progress.note(&format!("{}: {} rays", built.name, set.name));
        let with_mode = |mode| pools.iter().map(move |pool| (mode, pool));
        let jobs: Vec<_> = Mode::ALL
            .into_iter()
            .flat_map(with_mode)
            .map(|(mode, pool)| Job { scene: &built.scene, set, mode, pool })
            .collect();
        rows.extend(jobs.iter().zip(time(&jobs, samples, &progress)?).map(|(job, timing)| {
            let [mrays_per_second, mrays_per_second_mad] = timing.mrays_per_second();
            TracerRow {
                scene: built.name.clone(),
                triangles: built.scene.primitives(),
                instances: built.scene.world().instances().len(),
                rays: set.name.into(),
                ray_count: timing.rays,
                hits: timing.hits,
                mode: job.mode.name().into(),
                kernel: built.kernel(),
                threads: job.pool.current_num_threads(),
                mrays_per_second,
                mrays_per_second_mad,
                ns_of_rounds: timing.ns_of_rounds(),
                build_seconds: built.build_seconds,
                bytes_per_triangle: built.bytes_per_triangle(),
                checksum: format!("{:016x}", timing.checksum),
            }
        }));
    }
    Ok(rows)
}
