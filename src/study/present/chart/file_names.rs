//! The names of the chart files, and which failure maps belong to which chart.

use crate::study::figures::Group;
use crate::study::record::{MapRow, Record, RegimeRow};

/// The chart of raylanes and its peers.
pub(crate) const PEERS: &str = "peers.svg";
/// The chart of whole scenes with every kernel.
pub(crate) const ON_SCENES: &str = "on-scenes.svg";
/// The chart of speed against accuracy of all kernels except instances.
pub(crate) const SPEED_ACCURACY: &str = "speed-accuracy.svg";
/// The chart of speed against accuracy of instances.
pub(crate) const SPEED_ACCURACY_INSTANCES: &str = "speed-accuracy-instances.svg";

/// The chart of the gain of packets over scalar code.
pub(crate) const PACKETS: &str = "packets.svg";
/// The chart of the tracer's modes against coherence.
pub(crate) const COHERENCE: &str = "coherence.svg";
/// The chart of the cost of a ray against the size of the scene.
pub(crate) const SCALING: &str = "scaling.svg";

/// The name of a regime's chart.
pub(crate) fn stability_file(regime: &RegimeRow) -> String {
    format!("stability-{}-{}.svg", regime.family.replace(' ', "-"), regime.name)
}

/// The name of the chart of a group's failure maps.
pub(crate) fn failure_map_file(group: &Group) -> String {
    format!("failure-map-{}.svg", group.title.replace(' ', "-"))
}

/// The failure maps of a group.
pub(crate) fn maps_of<'a>(record: &'a Record, group: &Group) -> Vec<&'a MapRow> {
    record.maps.iter().filter(|map| map.family == group.title).collect()
}
