//! The machine of a comparison, with the versions of the peers.

use crate::study::measure::machine as measured;
use crate::study::record::Machine;

/// The machine and the build, including the versions of the peers that are crates.
pub fn machine() -> Machine {
    let mut machine = measured::describe();
    machine.versions.extend(measured::versions(&measured::PEERS));
    machine
}

/// Bytes of the last-level cache; `None` if the system does not say.
pub fn cache_bytes() -> Option<u64> {
    measured::cache_bytes()
}
