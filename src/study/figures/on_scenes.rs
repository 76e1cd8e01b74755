//! What kernels do to the pictures of whole scenes.

use super::rate::Rate;
use crate::study::record::{OnSceneRow, Record};

/// The name of the set of rays that are aimed at edges. All other sets are those of a picture.
pub(crate) const EDGES: &str = "edges";

/// Wrong answers of one kernel, per ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Answers {
    /// Rays that look through the surface at which they end.
    pub(crate) lost: Rate,
    /// Rays that hit what they exactly miss.
    pub(crate) false_hits: Rate,
    /// Rays that hit a triangle which touches the right one.
    pub(crate) neighbours: Rate,
}

impl Answers {
    /// The answers of a kernel in some sets of rays, together; `None` if there are none.
    pub(crate) fn of(record: &Record, id: &str, is_meant: impl Fn(&OnSceneRow) -> bool) -> Option<Self> {
        let rows = || record.on_scenes.iter().filter(|row| row.kernel == id && is_meant(row));
        let rate = |events: fn(&OnSceneRow) -> u64| {
            Rate::sum(rows().filter_map(|row| Rate::of_events(events(row), row.ray_count)))
        };
        Some(Self {
            lost: rate(|row| row.lost)?,
            false_hits: rate(|row| row.false_hits)?,
            neighbours: rate(|row| row.neighbours)?,
        })
    }

    /// The answers in the pictures of all scenes.
    pub(crate) fn in_pictures(record: &Record, id: &str) -> Option<Self> {
        Self::of(record, id, |row| row.rays != EDGES)
    }

    /// The answers to rays at edges of all scenes.
    pub(crate) fn at_edges(record: &Record, id: &str) -> Option<Self> {
        Self::of(record, id, |row| row.rays == EDGES)
    }

    /// Lost rays and false hits.
    pub(crate) fn wrong(&self) -> Rate {
        Rate { events: self.lost.events + self.false_hits.events, of: self.lost.of }
    }
}
