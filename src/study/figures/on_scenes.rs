//! What kernels do to the pictures of whole scenes.

use super::rate::Rate;
use crate::study::measure::ray_sets::EDGES;
use crate::study::measure::stats::{Estimate, ratio, typical};
use crate::study::record::{OnSceneRow, Record, Samples, SceneSpeedRow};

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

/// The times of one kernel in all scenes together: in each round, the geometric mean of the nanoseconds per ray over
/// the scenes and those sets of rays that are meant. A scene weighs as much as any other. `None` if there are none.
pub(crate) fn times(all: &[SceneSpeedRow], id: &str, is_meant: impl Fn(&SceneSpeedRow) -> bool) -> Option<Samples> {
    let rows: Vec<_> = all.iter().filter(|row| row.kernel == id && is_meant(row)).collect();
    let groups = rows.first()?.ns_of_rounds.groups();
    let mean = |group: usize, round: usize| {
        let samples = rows.iter().filter_map(|row| row.ns_of_rounds.groups().get(group)?.get(round));
        let logarithms: Vec<f64> = samples.map(|ns| ns.ln()).collect();
        (logarithms.iter().sum::<f64>() / logarithms.len() as f64).exp()
    };
    let of_group = |(group, rounds): (usize, &Vec<f64>)| (0..rounds.len()).map(|round| mean(group, round)).collect();
    Some(Samples::new(&groups.iter().enumerate().map(of_group).collect::<Vec<_>>()))
}

/// Million rays per second of a kernel in the scenes; see [`times`].
pub(crate) fn mrays(record: &Record, id: &str, is_meant: impl Fn(&SceneSpeedRow) -> bool) -> Option<Estimate> {
    let ns = typical(&times(&record.scene_speed, id, is_meant)?)?;
    Some(Estimate { value: 1e3 / ns.value, low: 1e3 / ns.high, high: 1e3 / ns.low })
}

/// How much faster the first kernel traces the scenes than the second, with those sets of rays that are meant.
pub(crate) fn gain(
    record: &Record,
    [first, second]: [&str; 2],
    is_meant: impl Fn(&SceneSpeedRow) -> bool,
) -> Option<Estimate> {
    let [first, second] = [first, second].map(|id| times(&record.scene_speed, id, &is_meant));
    ratio(&second?, &first?)
}
