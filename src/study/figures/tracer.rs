//! Figures of the tracer: modes side by side, several threads against one, packets against single rays as coherence
//! falls, and growth of the cost with the size of the scene.

use super::scaling::Scaling;
use crate::study::record::{CoherenceRow, Record, ScalingRow, TracerRow};
use crate::tracer::Mode;

/// The names of all modes, as used in records.
pub(crate) fn modes() -> [&'static str; 4] {
    Mode::ALL.map(Mode::name)
}

/// One set of rays of one scene, in every mode and with every number of threads.
#[derive(Debug)]
pub(crate) struct TracedSet<'a> {
    /// Any of its rows, for the fields that all of them share.
    pub(crate) first: &'a TracerRow,
    rows: Vec<&'a TracerRow>,
}

impl<'a> TracedSet<'a> {
    /// All sets of a record, in the order of the record.
    pub(crate) fn all(record: &'a Record) -> Vec<Self> {
        let key = |row: &'a TracerRow| [&row.scene, &row.rays, &row.kernel];
        let mut all: Vec<Self> = Vec::new();
        for row in &record.tracer {
            match all.iter_mut().find(|traced| key(traced.first) == key(row)) {
                Some(traced) => traced.rows.push(row),
                None => all.push(Self { first: row, rows: vec![row] }),
            }
        }
        all
    }

    /// The row of a mode with this number of threads.
    pub(crate) fn row(&self, mode: &str, threads: usize) -> Option<&'a TracerRow> {
        self.rows.iter().find(|row| row.mode == mode && row.threads == threads).copied()
    }

    /// Million rays per second.
    pub(crate) fn mrays(&self, mode: &str, threads: usize) -> Option<f64> {
        self.row(mode, threads).map(|row| row.mrays_per_second)
    }

    /// Million rays per second of the fastest of these modes, in one thread.
    pub(crate) fn fastest(&self, modes: &[&str]) -> Option<f64> {
        modes.iter().filter_map(|mode| self.mrays(mode, 1)).reduce(f64::max)
    }

    /// Whether the row is the fastest with its number of threads, or ties with the fastest: no mode is faster by more
    /// than the sum of both median absolute deviations.
    pub(crate) fn is_among_the_fastest(&self, row: &TracerRow) -> bool {
        let is_faster = |other: &TracerRow| {
            let spread = other.mrays_per_second_mad + row.mrays_per_second_mad;
            other.threads == row.threads && other.mrays_per_second - row.mrays_per_second > spread
        };
        !self.rows.iter().any(|other| is_faster(other))
    }

    /// Speed of mode auto over that of the faster of single and packet, in one thread.
    pub(crate) fn auto_over_best(&self) -> Option<f64> {
        quotient(self.mrays("auto", 1)?, self.fastest(&["single", "packet"])?)
    }

    /// Speed of mode auto over that of mode scalar, in one thread.
    pub(crate) fn gain(&self) -> Option<f64> {
        quotient(self.mrays("auto", 1)?, self.mrays("scalar", 1)?)
    }

    /// Speed with several threads over speed with one thread.
    pub(crate) fn scaling(&self, mode: &str, threads: usize) -> Option<Scaling> {
        let [one, several] = [self.row(mode, 1)?, self.row(mode, threads)?];
        Scaling::of_times(&one.ns_of_rounds, &several.ns_of_rounds, threads)
    }
}

/// `a / b`; `None` if that is not finite.
fn quotient(a: f64, b: f64) -> Option<f64> {
    Some(a / b).filter(|quotient| quotient.is_finite())
}

/// The measurements of one scene at all jitters.
#[derive(Debug)]
pub(crate) struct Coherence<'a> {
    pub(crate) scene: &'a str,
    /// Jitters, from 0 (the rays of a picture) to 1 (random rays).
    pub(crate) jitters: Vec<f64>,
    rows: Vec<&'a CoherenceRow>,
}

impl<'a> Coherence<'a> {
    /// All scenes of a record, in the order of the record.
    pub(crate) fn all(record: &'a Record) -> Vec<Self> {
        let mut all: Vec<Self> = Vec::new();
        for row in &record.coherence {
            if all.last().is_none_or(|coherence| coherence.scene != row.scene) {
                all.push(Self { scene: &row.scene, jitters: Vec::new(), rows: Vec::new() });
            }
            let coherence = all.last_mut().expect("one was just added if there was none");
            coherence.rows.push(row);
            if !coherence.jitters.contains(&row.jitter) {
                coherence.jitters.push(row.jitter);
            }
        }
        all
    }

    /// The row of a mode at a jitter.
    pub(crate) fn row(&self, jitter: f64, mode: &str) -> Option<&'a CoherenceRow> {
        self.rows.iter().find(|row| row.jitter == jitter && row.mode == mode).copied()
    }

    /// Whether any mode counted visits or tests.
    pub(crate) fn is_counted(&self) -> bool {
        self.rows.iter().any(|row| row.nodes + row.leaves + row.tests > 0)
    }

    fn mrays(&self, jitter: f64, mode: &str) -> Option<f64> {
        self.row(jitter, mode).map(|row| row.mrays_per_second)
    }

    /// Speed of packets over that of single rays.
    pub(crate) fn packet_gain(&self, jitter: f64) -> Option<f64> {
        quotient(self.mrays(jitter, "packet")?, self.mrays(jitter, "single")?)
    }

    /// Speed of mode auto over that of the faster of single and packet.
    pub(crate) fn auto_over_best(&self, jitter: f64) -> Option<f64> {
        quotient(self.mrays(jitter, "auto")?, self.mrays(jitter, "single")?.max(self.mrays(jitter, "packet")?))
    }

    /// Index of the first jitter at which single rays are faster than packets, by more than the sum of both median
    /// absolute deviations.
    pub(crate) fn overtaking_step(&self) -> Option<usize> {
        self.jitters.iter().position(|&jitter| {
            let rows = self.row(jitter, "single").zip(self.row(jitter, "packet"));
            rows.is_some_and(|(single, packet)| {
                let spread = single.mrays_per_second_mad + packet.mrays_per_second_mad;
                single.mrays_per_second - packet.mrays_per_second > spread
            })
        })
    }

    /// The smallest [`auto_over_best`](Self::auto_over_best), and its jitter.
    pub(crate) fn worst_auto(&self) -> Option<(f64, f64)> {
        let choices = self.jitters.iter().filter_map(|&jitter| Some((self.auto_over_best(jitter)?, jitter)));
        choices.min_by(|(a, _), (b, _)| a.total_cmp(b))
    }
}

/// Counts per ray; `None` in modes that do not count.
impl CoherenceRow {
    /// Lane utilisation: the share of the lanes of eight-wide tests in which an active ray met a triangle.
    pub(crate) fn lane_utilisation(&self) -> Option<f64> {
        (self.tests > 0).then(|| self.lanes as f64 / (8 * self.tests) as f64)
    }

    pub(crate) fn nodes_per_ray(&self) -> Option<f64> {
        self.per_ray(self.nodes)
    }

    pub(crate) fn leaves_per_ray(&self) -> Option<f64> {
        self.per_ray(self.leaves)
    }

    pub(crate) fn tests_per_ray(&self) -> Option<f64> {
        self.per_ray(self.tests)
    }

    fn per_ray(&self, count: u64) -> Option<f64> {
        (count > 0 && self.ray_count > 0).then(|| count as f64 / self.ray_count as f64)
    }
}

/// One set of rays in every size of a scene, from small to large.
#[derive(Debug)]
pub(crate) struct Growth<'a> {
    pub(crate) rays: &'a str,
    pub(crate) rows: Vec<&'a ScalingRow>,
}

impl<'a> Growth<'a> {
    /// All sets of rays of a record, in the order of the record.
    pub(crate) fn all(record: &'a Record) -> Vec<Self> {
        let mut all: Vec<Self> = Vec::new();
        for row in &record.scaling {
            match all.iter_mut().find(|growth| growth.rays == row.rays) {
                Some(growth) => growth.rows.push(row),
                None => all.push(Self { rays: &row.rays, rows: vec![row] }),
            }
        }
        all
    }

    /// For each size but the first: the growth of the cost of a ray since the size before, per factor of ten in
    /// triangles.
    pub(crate) fn per_decade(&self) -> Vec<Option<f64>> {
        let growth = |pair: &[&ScalingRow]| {
            let decades = quotient(pair[1].triangles as f64, pair[0].triangles as f64)?.log10();
            let growth = quotient(pair[1].ns_per_ray, pair[0].ns_per_ray)?.powf(1.0 / decades);
            Some(growth).filter(|growth| growth.is_finite())
        };
        self.rows.windows(2).map(growth).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::record::Samples;
    use crate::study::tests::fixture::record_of;

    #[test]
    fn modes_within_the_noise_of_the_fastest_tie_with_it() {
        let mut record = record_of(&[]);
        let set = |record: &mut Record, mode: &str, mrays: f64| {
            for row in record.tracer.iter_mut().filter(|row| row.mode == mode) {
                // Rows with two threads must not be compared with rows of one.
                row.mrays_per_second = mrays * row.threads as f64;
                row.mrays_per_second_mad = 0.1;
            }
        };
        for (mode, mrays) in [("scalar", 2.0), ("single", 9.7), ("packet", 9.85), ("auto", 10.0)] {
            set(&mut record, mode, mrays);
        }
        let traced = &TracedSet::all(&record)[0];
        let fastest = |threads| modes().map(|mode| traced.is_among_the_fastest(traced.row(mode, threads).unwrap()));
        assert_eq!([fastest(1), fastest(2)], [[false, false, true, true], [false, false, false, true]]);
    }

    #[test]
    fn several_threads_are_compared_with_one() {
        let mut record = record_of(&[]);
        for row in &mut record.tracer {
            row.ns_of_rounds = Samples::new(&[if row.threads == 1 { vec![7.0, 70.0] } else { vec![4.0, 40.0] }]);
        }
        let scaling = TracedSet::all(&record)[0].scaling("auto", 2).unwrap();
        assert_eq!(scaling.to_string(), "1.75× (1.75 to 1.75)");
        assert!(TracedSet::all(&record)[0].scaling("auto", 3).is_none());
    }

    #[test]
    fn single_rays_overtake_packets_at_the_first_gain_above_the_noise() {
        let overtaking_step = |packets: [f64; 4]| {
            let mut record = record_of(&[]);
            record.coherence.retain(|row| row.scene == "room" && row.jitter <= 0.01);
            for row in &mut record.coherence {
                let step = [0.0, 0.001, 0.003, 0.01].iter().position(|&jitter| jitter == row.jitter).unwrap();
                row.mrays_per_second = if row.mode == "packet" { packets[step] } else { 5.0 };
                row.mrays_per_second_mad = 0.2;
            }
            Coherence::all(&record)[0].overtaking_step()
        };
        assert_eq!(overtaking_step([9.0, 8.0, 6.0, 5.0]), None);
        assert_eq!(overtaking_step([9.0, 8.0, 6.0, 4.7]), None, "a tie");
        assert_eq!(overtaking_step([9.0, 8.0, 4.5, 6.0]), Some(2));
        assert_eq!(overtaking_step([4.0; 4]), Some(0));
        let mut record = record_of(&[]);
        record.coherence.retain(|row| row.mode != "single");
        assert_eq!(Coherence::all(&record)[0].overtaking_step(), None);
    }

    #[test]
    fn the_worst_auto_is_the_lowest_ratio_to_the_better_mode() {
        let mut record = record_of(&[]);
        for row in &mut record.coherence {
            row.mrays_per_second = match (row.mode.as_str(), row.jitter) {
                ("packet", 0.1) => 8.0,
                ("single", 0.5) => 10.0,
                ("auto", 0.5) => 7.0,
                ("auto", 0.1) => 6.0,
                _ => 5.0,
            };
        }
        assert_eq!(Coherence::all(&record)[1].worst_auto(), Some((0.7, 0.5)));
    }

    #[test]
    fn growth_is_given_per_factor_of_ten_in_triangles() {
        let mut record = record_of(&[]);
        for row in &mut record.scaling {
            (row.triangles, row.ns_per_ray) = match row.scene.as_str() {
                "terrain:1e4" => (10_000, 20.0),
                "terrain:1e5" => (100_000, 30.0),
                _ => (10_000_000, 67.5),
            };
        }
        let growth = Growth::all(&record)[0].per_decade();
        assert!(growth.len() == 2 && growth.iter().all(|growth| (growth.unwrap() - 1.5).abs() < 1e-12), "{growth:?}");
    }

    #[test]
    fn utilisation_is_a_share_and_counts_are_per_ray() {
        let mut row = record_of(&[]).coherence.remove(0);
        (row.ray_count, row.nodes, row.leaves, row.tests, row.lanes) = (100, 50, 200, 400, 800);
        assert_eq!(row.lane_utilisation(), Some(0.25));
        assert_eq!([row.nodes_per_ray(), row.leaves_per_ray(), row.tests_per_ray()], [Some(0.5), Some(2.0), Some(4.0)]);
        (row.nodes, row.leaves, row.tests, row.lanes) = (0, 0, 0, 0);
        assert_eq!((row.lane_utilisation(), row.nodes_per_ray()), (None, None));
    }
}
