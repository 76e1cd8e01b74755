//! Where the figures come from: method and bias, machine and build, sources of the kernels, checksums.

use super::cells::code;
use crate::study::figures::{number, severity};
use crate::study::present::grid::{Cell, Grid};
use crate::study::record::Record;

/// How the figures were measured, and what they leave out.
pub(super) const METHOD: &str = "\
## Method and bias

**What a test is.** Each ray finds its closest hit among a small set of primitives, as in the leaf of a tracer. All \
data is in the first-level cache. The time per test is the total time divided by rays × primitives. It includes \
loading, the test, keeping the closer hit, and the ray's setup, spread over the primitives. No ray is timed twice in a \
row, so the processor cannot predict branches from memory, as in a tracer. Cache misses of a real traversal are not \
included. In a tracer, kernels with many prepared bytes do worse, and ratios differ: *The same scenes, every kernel* \
shows them.

**What is compared.** Times of kernels are medians over several processes, because the layout of code and memory moves \
the median of one process by more than its samples differ. The samples of all kernels are interleaved in rounds. \
Intervals are 95 % intervals of a bootstrap that draws processes, and then rounds within them. Two kernels tie if the \
interval of their ratio, formed within each round, contains 1. A few processes tell little about others: such \
intervals are rather too short than too long. Times of the tracer are medians with their median absolute deviation. \
Other programs may share the machine, and clock rates drift. Trust ratios between rows of one record more than \
absolute figures, and more than ratios between records.

**What the errors describe.** Rays are seeded and aimed. `generic` rays go into and past a primitive of about unit \
size from a few units away. `edge` rays go to edges, vertices, corners and planes, and to the silhouettes, rims and \
apices of quadrics. The rates describe these workloads. The rays of a picture hit edges far less often. Harder \
geometry (slivers, large distances) may have far larger errors. Intervals of counts assume independent rays. Rays at \
the same mesh are not quite independent, so intervals are rather too narrow where errors are frequent.

**Why both belong together.** The scalar twin and the packet twin of a kernel are separate code and give identical \
bits. The checksums below confirm this for the timed rays: they are equal for all widths and thread counts.";

/// The machine and the build.
pub(super) fn machine(record: &Record) -> String {
    let machine = &record.machine;
    format!(
        "## Machine and build\n\n- Processor: {}, {} logical processors\n- System: {}, target `{}`\n\
         - Target features: {}\n\
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

/// Ideas and sources. Kernels that share both are listed together.
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

/// The checksums of all hits.
pub(super) fn checksums(record: &Record) -> String {
    let kernels = record.speed.iter().map(|row| (format!("`{}`", row.id), row.checksum.as_str()));
    let traced = |scene: &str, rays: &str, kernel: &str| format!("{scene}, {rays} rays, `{kernel}`");
    let tracer = record.tracer.iter().map(|row| (traced(&row.scene, &row.rays, &row.kernel), row.checksum.as_str()));
    let coherence = record.coherence.iter().map(|row| {
        (traced(&row.scene, &format!("jitter {}", severity(row.jitter)), &row.kernel), row.checksum.as_str())
    });
    // The checksum is equal for all widths, modes and thread counts, so each appears once.
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
