//! The machine of a comparison, with the versions of the peers.

use crate::study::measure::machine as measured;
use crate::study::record::Machine;

/// The machine, with the versions of those peers too that are crates.
pub fn machine() -> Machine {
    let mut machine = measured::describe();
    machine.versions.extend(measured::versions(&measured::PEERS));
    machine
}

/// Bytes of the last-level cache, where the system tells them.
pub fn cache_bytes() -> Option<u64> {
    measured::cache_bytes()
}
