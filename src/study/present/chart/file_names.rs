//! The files of the charts, and which failure maps a chart shows.

use crate::study::figures::Group;
use crate::study::record::{MapRow, Record, RegimeRow};

/// File of the chart of raylanes and its peers.
pub(crate) const PEERS: &str = "peers.svg";
/// File of the chart of all kernels that are no instances.
pub(crate) const SPEED_ACCURACY: &str = "speed-accuracy.svg";
/// File of the same chart of the instances.
pub(crate) const SPEED_ACCURACY_INSTANCES: &str = "speed-accuracy-instances.svg";

/// File of the chart of what packets gain.
pub(crate) const PACKETS: &str = "packets.svg";
/// File of the chart of modes by coherence.
pub(crate) const COHERENCE: &str = "coherence.svg";
/// File of the chart of cost by size.
pub(crate) const SCALING: &str = "scaling.svg";

/// File of a regime's chart.
pub(crate) fn stability_file(regime: &RegimeRow) -> String {
    format!("stability-{}-{}.svg", regime.family.replace(' ', "-"), regime.name)
}

/// File of a group's failure maps.
pub(crate) fn failure_map_file(group: &Group) -> String {
    format!("failure-map-{}.svg", group.title.replace(' ', "-"))
}

/// The failure maps that are for a group.
pub(crate) fn maps_of<'a>(record: &'a Record, group: &Group) -> Vec<&'a MapRow> {
    record.maps.iter().filter(|map| map.family == group.title).collect()
}
