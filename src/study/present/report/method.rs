//! How the figures came about: method and bias, machine and build, sources, checksums.

use super::cells::code;
use crate::study::figures::{number, severity};
use crate::study::present::grid::{Cell, Grid};
use crate::study::record::Record;

pub(super) const METHOD: &str = "\
## Method and bias

**What a test is.** Rays find their closest hit among a small set of primitives, as in the leaf of a tracer, with everything \
in the first-level cache. The time per test is that of the whole, divided by rays times primitives: loading, the test, \
keeping the closer hit by blends, and each ray's setup, spread over the primitives. No rays are timed twice in a row: what \
a processor remembers of branches is no help, here as in a tracer. Missing are the cache misses of a real traversal: expect \
kernels to differ less in a tracer than here, and one with many prepared bytes to do worse.

**What is compared.** Times are medians of repeated samples, those of all kernels interleaved, with their median absolute \
deviation (MAD). Two kernels tie where their medians differ by no more than the sum of both. Other programs may share the \
machine, and clock rates drift: trust ratios between rows of one record, rather than absolute figures or ratios between \
records.

**What the errors are errors of.** Rays are seeded and aimed. `generic` rays go into and past a primitive of about unit size \
from a few units away; `edge` rays go to edges, vertices, corners and planes, and to the silhouettes, rims and apices of quadrics. The rates describe these workloads: a picture \
meets an edge far more rarely, and harder geometry (slivers, great distances) may err far more.

**What ties the two together.** The scalar and the packet form of a kernel are written apart and give identical bits; the \
checksums below, equal for all faces and thread counts, say so for the very rays that were timed.";

pub(super) fn machine(record: &Record) -> String {
    let machine = &record.machine;
    format!(
        "## Machine and build\n\n- Processor: {}, {} logical processors\n- System: {}, target `{}`\n- Target features: {}\n\
         - Compiler: {}\n- Measured code: {}\n- Seed {}; {}; took {} s; record layout {}",
        machine.cpu,
        machine.processors,
        machine.os,
        machine.target,
        machine.target_features.join(", "),
        machine.rustc,
        machine.versions.join(", "),
        record.seed,
        if record.quick { "quick run" } else { "full run" },
        number(record.seconds, 3),
        record.schema
    )
}

/// Ideas and sources, kernels that share both together.
pub(super) fn sources(record: &Record) -> String {
    let mut sources: Vec<(&str, &str, Vec<String>)> = Vec::new();
    for kernel in &record.methods {
        let id = format!("`{}`", kernel.id);
        match sources.iter_mut().find(|(idea, source, _)| *idea == kernel.idea && *source == kernel.source) {
            Some((_, _, ids)) => ids.push(id),
            None => sources.push((&kernel.idea, &kernel.source, vec![id])),
        }
    }
    let lines = sources.into_iter().map(|(idea, source, ids)| format!("- {}: {idea}. {source}.\n", ids.join(", ")));
    format!("## Sources\n\n{}", lines.collect::<String>())
}

pub(super) fn checksums(record: &Record) -> String {
    let kernels = record.speed.iter().map(|row| (format!("`{}`", row.id), row.checksum.as_str()));
    let traced = |scene: &str, rays: &str, kernel: &str| format!("{scene}, {rays} rays, `{kernel}`");
    let tracer = record.tracer.iter().map(|row| (traced(&row.scene, &row.rays, &row.kernel), row.checksum.as_str()));
    let coherence = record.coherence.iter().map(|row| {
        (traced(&row.scene, &format!("jitter {}", severity(row.jitter)), &row.kernel), row.checksum.as_str())
    });
    // Equal for all faces, modes and thread counts: one line each.
    let mut lines: Vec<(String, &str)> = Vec::new();
    for line in kernels.chain(tracer).chain(coherence) {
        if !lines.contains(&line) {
            lines.push(line);
        }
    }
    let mut grid = Grid::new(2, ["hits of", "checksum of their bits"]);
    grid.rows.extend(lines.into_iter().map(|(what, checksum)| vec![Cell::from(what), code(checksum)]));
    format!("## Checksums\n\n{}", grid.markdown())
}
