//! Throughput of the tracer on the rays of pictures.

use super::built_scene::Stage;
use super::timing::{Job, time};
use crate::study::progress::Progress;
use crate::study::record::TracerRow;
use crate::tracer::{Error, Mode, SceneSource, thread_pool};

/// Times one scene, with every mode and number of threads, interleaved.
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
    let stage = Stage::set(source, (size, seed), progress)?;
    let pools = thread_counts.iter().map(|&threads| thread_pool(threads)).collect::<Result<Vec<_>, _>>()?;
    let mut rows = Vec::new();
    for (set, progress) in progress.each(&stage.sets) {
        progress.note(&format!("{}: {} rays", stage.name, set.name));
        let with_mode = |mode| pools.iter().map(move |pool| (mode, pool));
        let jobs: Vec<_> = Mode::ALL
            .into_iter()
            .flat_map(with_mode)
            .map(|(mode, pool)| Job { scene: &stage.scene, set, mode, pool })
            .collect();
        rows.extend(jobs.iter().zip(time(&jobs, samples, &progress)?).map(|(job, timing)| {
            let [mrays_per_second, mrays_per_second_mad] = timing.mrays_per_second();
            TracerRow {
                scene: stage.name.clone(),
                triangles: stage.scene.primitives(),
                instances: stage.scene.world().instances().len(),
                rays: set.name.into(),
                ray_count: timing.rays,
                hits: timing.hits,
                mode: job.mode.name().into(),
                kernel: stage.kernel(),
                threads: job.pool.current_num_threads(),
                mrays_per_second,
                mrays_per_second_mad,
                build_seconds: stage.build_seconds,
                bytes_per_triangle: stage.bytes_per_triangle(),
                checksum: format!("{:016x}", timing.checksum),
            }
        }));
    }
    Ok(rows)
}
