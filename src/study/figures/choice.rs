//! Which kernel a scene needs: the fastest of those that are wrong rarely enough, and what its neighbours offer.
//!
//! No kernel is ranked before another within the noise. A rate of wrong rays meets a need only if its whole confidence
//! interval does. Kernels whose speeds differ by no more than the interval of their ratio, or by less than [`TIE`],
//! tie. Of kernels that tie, the most careful one is chosen, if it is less than [`TIE`] slower by its median: care that
//! costs nothing is welcome. A kernel that claims to be always right is more careful than others, and of others the one
//! with fewer wrong rays at edges.

use super::rate::Rate;
use crate::kernels::Claim;
use crate::study::measure::ray_sets::EDGES;
use crate::study::measure::stats::{Estimate, ratio, typical};
use crate::study::record::{OnSceneRow, Samples, SceneSpeedRow};

/// Kernels tie if one may be less than this share faster than the other. Two builds of the same code differ by as much.
pub(crate) const TIE: f64 = 0.02;

/// Kernels whose brief times are no farther apart than this may change places when they are timed well.
const CLOSE: f64 = 0.1;

/// A more careful kernel has at most this part of the wrong rays at edges.
const CAREFUL: f64 = 10.0;

/// What a scene can live with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Need {
    /// Wrong rays per million. Zero cannot be shown by any number of rays. It asks for a kernel that claims to be right
    /// always, and that gets no ray wrong, also of those aimed at edges.
    pub(crate) max_wrong: f64,
}

impl Need {
    /// Whether a rate of wrong rays meets the need.
    pub(crate) fn standing(self, wrong: Rate) -> Standing {
        let [low, high] = wrong.interval();
        match self.max_wrong {
            most if high <= most => Standing::Meets,
            most if low > most => Standing::Fails,
            _ => Standing::Open,
        }
    }
}

/// Whether a kernel meets a need.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Standing {
    /// It does: the whole interval of its rate is within the need.
    Meets,
    /// The rays cannot tell.
    Open,
    /// It does not: the whole interval is beyond the need.
    Fails,
}

/// Wrong answers: rays that are lost, falsely hit, or displaced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WrongAnswers {
    /// Wrong rays of pictures, or of a file.
    pub(crate) wrong: Rate,
    /// Wrong rays of those aimed at edges.
    pub(crate) at_edges: Option<Rate>,
    /// Displacement of right hits: 99 % of each set have at most this. See [`OnSceneRow::displacement_p99`].
    pub(crate) displacement: f64,
}

impl WrongAnswers {
    /// Those of all rows together; `None` without rays of pictures.
    pub(crate) fn of<'a>(rows: impl Iterator<Item = &'a OnSceneRow> + Clone) -> Option<Self> {
        let of = |edges: bool| rows.clone().filter(move |row| (row.rays == EDGES) == edges);
        let rate = |edges| Rate::sum(of(edges).filter_map(|row| Rate::of_events(row.wrong(), row.ray_count)));
        Some(Self {
            wrong: rate(false)?,
            at_edges: rate(true),
            displacement: of(false).map(|row| row.displacement_p99).fold(0.0, f64::max),
        })
    }
}

/// One kernel in one scene.
#[derive(Clone, Debug)]
pub(crate) struct Candidate {
    /// Kernel ID.
    pub(crate) id: String,
    /// How often it is wrong.
    pub(crate) answers: WrongAnswers,
    /// Nanoseconds per ray, over all rays of a picture, in each round.
    pub(crate) ns: Samples,
    /// What the kernel claims.
    pub(crate) claims: Vec<String>,
}

impl Candidate {
    /// The kernels of a family in one scene, in the order of the rows, with what they claim. Kernels that were not
    /// timed are left out.
    pub(crate) fn all(
        family: &str,
        judged: &[&OnSceneRow],
        timed: &[&SceneSpeedRow],
        claims: &dyn Fn(&str) -> Vec<String>,
    ) -> Vec<Self> {
        let mut ids: Vec<&str> = Vec::new();
        for row in judged {
            if row.kernel.split('/').next() == Some(family) && !ids.contains(&row.kernel.as_str()) {
                ids.push(&row.kernel);
            }
        }
        ids.into_iter().filter_map(|id| Self::new(id, judged, timed, claims(id))).collect()
    }

    fn new(id: &str, judged: &[&OnSceneRow], timed: &[&SceneSpeedRow], claims: Vec<String>) -> Option<Self> {
        let rows = judged.iter().copied().filter(|row| row.kernel == id);
        let timed: Vec<_> = timed.iter().filter(|row| row.kernel == id).collect();
        let weight = |speed: &SceneSpeedRow| {
            let same = rows.clone().find(|row| row.rays == speed.rays);
            same.map_or(0.0, |row| row.ray_count as f64)
        };
        let all: f64 = timed.iter().map(|row| weight(row)).sum();
        let mean = |group: usize, round: usize| {
            let ns = |row: &SceneSpeedRow| row.ns_of_rounds.groups().get(group)?.get(round).copied();
            timed.iter().map(|row| ns(row).unwrap_or(f64::NAN) * weight(row)).sum::<f64>() / all
        };
        let groups = timed.first()?.ns_of_rounds.groups().iter().enumerate();
        let ns: Vec<Vec<f64>> =
            groups.map(|(group, rounds)| (0..rounds.len()).map(|round| mean(group, round)).collect()).collect();
        Some(Self { id: id.into(), answers: WrongAnswers::of(rows.clone())?, ns: Samples::new(&ns), claims })
    }

    /// The name without the family.
    pub(crate) fn name(&self) -> &str {
        self.id.rsplit('/').next().unwrap_or(&self.id)
    }

    /// Nanoseconds per ray.
    pub(crate) fn time(&self) -> Option<Estimate> {
        typical(&self.ns)
    }

    /// How many times as fast as another kernel it is.
    pub(crate) fn gain_over(&self, other: &Self) -> Option<Estimate> {
        ratio(&other.ns, &self.ns)
    }

    /// Whether it may be less than [`TIE`] slower than another kernel.
    fn ties_in_speed_with(&self, faster: &Self) -> bool {
        faster.gain_over(self).is_none_or(|gain| gain.low <= 1.0 + TIE)
    }

    fn claims_to_be_right(&self) -> bool {
        self.claims.iter().any(|claim| claim == Claim::RightDecision.name())
    }

    /// Whether it meets a need.
    pub(crate) fn standing(&self, need: Need) -> Standing {
        if need.max_wrong == 0.0 {
            let errs =
                [Some(self.answers.wrong), self.answers.at_edges].into_iter().flatten().any(|rate| rate.events > 0);
            return if errs || !self.claims_to_be_right() { Standing::Fails } else { Standing::Meets };
        }
        need.standing(self.answers.wrong)
    }

    /// Whether it is wrong less often than another kernel, beyond chance, in pictures or at edges, and nowhere more
    /// often. If they tie, a kernel that claims to be right always is more right than one that does not.
    pub(crate) fn is_more_right_than(&self, other: &Self) -> bool {
        let sides =
            [Some((self.answers.wrong, other.answers.wrong)), self.answers.at_edges.zip(other.answers.at_edges)];
        let differing = sides.into_iter().flatten().filter(|(own, other)| !own.ties_with(*other));
        let less: Vec<bool> = differing.map(|(own, other)| own.per_million() < other.per_million()).collect();
        match &less[..] {
            [] => self.claims_to_be_right() && !other.claims_to_be_right(),
            less => less.iter().all(|less| *less),
        }
    }
}

impl Candidate {
    /// Whether it is [more right](Self::is_more_right_than) by so much that it may be worth its price: in pictures, or
    /// [many times](CAREFUL) at edges, or by its claims.
    fn is_more_careful_than(&self, other: &Self) -> bool {
        let at_edges = self.answers.at_edges.zip(other.answers.at_edges).filter(|(own, other)| !own.ties_with(*other));
        let is_small = |(own, other): (Rate, Rate)| CAREFUL * own.per_million() <= other.per_million();
        self.is_more_right_than(other)
            && (!self.answers.wrong.ties_with(other.answers.wrong) || at_edges.is_none_or(is_small))
    }
}

/// The kernel that a scene needs, among the kernels of one family. All numbers are places in [`Choice::candidates`].
#[derive(Clone, Debug)]
pub(crate) struct Choice {
    /// All kernels, the fastest first.
    pub(crate) candidates: Vec<Candidate>,
    /// Whether each of them meets the need.
    pub(crate) standings: Vec<Standing>,
    /// The kernel to use. `None` if no kernel meets the need.
    pub(crate) chosen: Option<usize>,
    /// Kernels that meet the need and tie with the chosen one in speed.
    pub(crate) ties: Vec<usize>,
    /// The fastest kernel that meets the need, besides the chosen one.
    pub(crate) runner_up: Option<usize>,
    /// The fastest of the kernels that are faster than the chosen one. None of them meets the need.
    pub(crate) cheaper: Option<usize>,
    /// The fastest of the kernels that are much more right than the chosen one: a tenth of the wrong rays at edges,
    /// fewer wrong rays in pictures, or the claim to be always right. It does not tie with the chosen one in speed.
    pub(crate) careful: Option<usize>,
    /// The kernels that are more right than every faster one: what can be had for a price.
    pub(crate) frontier: Vec<usize>,
}

impl Choice {
    /// Chooses among kernels; `None` if there are none.
    pub(crate) fn new(mut candidates: Vec<Candidate>, need: Need) -> Option<Self> {
        let middle = |candidate: &Candidate| candidate.time().map_or(f64::INFINITY, |time| time.value);
        candidates.sort_by(|a, b| middle(a).total_cmp(&middle(b)));
        let standings: Vec<_> = candidates.iter().map(|candidate| candidate.standing(need)).collect();
        let all = 0..candidates.len();
        let fit: Vec<_> = all.clone().filter(|&number| standings[number] == Standing::Meets).collect();
        let fastest = fit.first().copied();
        let tied: Vec<_> = fit
            .iter()
            .copied()
            .filter(|&number| fastest.is_some_and(|first| candidates[number].ties_in_speed_with(&candidates[first])))
            .collect();
        // The most careful of those that are hardly slower. Of equals, the first one in the list is the fastest.
        let hardly_slower = |&number: &usize| {
            let gain = fastest.and_then(|first| candidates[first].gain_over(&candidates[number]));
            gain.is_none_or(|gain| gain.value <= 1.0 + TIE)
        };
        let chosen = tied.iter().copied().filter(hardly_slower).min_by(|&a, &b| {
            let [a, b] = [a, b].map(|number| &candidates[number]);
            let at_edges = |candidate: &Candidate| candidate.answers.at_edges.map_or(0.0, Rate::per_million);
            let claims = b.claims_to_be_right().cmp(&a.claims_to_be_right());
            claims.then(at_edges(a).total_cmp(&at_edges(b))).then(b.claims.len().cmp(&a.claims.len()))
        });
        let best = chosen.map(|chosen| &candidates[chosen]);
        let is_faster =
            |candidate: &Candidate| best.and_then(|best| candidate.gain_over(best)).is_some_and(|gain| gain.low > 1.0);
        let cheaper =
            all.clone().find(|&number| standings[number] != Standing::Meets && is_faster(&candidates[number]));
        let is_more_careful = |candidate: &Candidate| best.is_some_and(|best| candidate.is_more_careful_than(best));
        let is_slower = |number: &usize| !tied.contains(number);
        let careful = all.clone().filter(is_slower).find(|&number| is_more_careful(&candidates[number]));
        let mut frontier: Vec<usize> = Vec::new();
        for number in all {
            if frontier.iter().all(|&faster| candidates[number].is_more_right_than(&candidates[faster])) {
                frontier.push(number);
            }
        }
        (!candidates.is_empty()).then(|| Self {
            chosen,
            ties: tied.iter().copied().filter(|&number| Some(number) != chosen).collect(),
            runner_up: fit.iter().copied().find(|&number| Some(number) != chosen),
            cheaper,
            careful,
            frontier,
            standings,
            candidates,
        })
    }

    /// The kernel to use; see [`Choice::chosen`].
    pub(crate) fn chosen(&self) -> Option<&Candidate> {
        self.chosen.map(|number| &self.candidates[number])
    }

    /// The kernel that is wrong least often, beyond chance, and of these the fastest: what remains if none meets the
    /// need.
    pub(crate) fn least_wrong(&self) -> &Candidate {
        let last = self.frontier.last().expect("the fastest kernel is at the frontier");
        &self.candidates[*last]
    }

    /// The kernels that an answer names, and those that meet the need and tie with the fastest of them, or are at most
    /// [`CLOSE`] slower: what must be timed well.
    pub(crate) fn close(&self) -> Vec<usize> {
        let ns = |number: usize| self.candidates[number].time().map_or(f64::INFINITY, |time| time.value);
        let named = [self.chosen, self.runner_up, self.cheaper, self.careful];
        let fit = |&number: &usize| self.standings[number] == Standing::Meets;
        let fastest = (0..self.candidates.len()).find(fit);
        let ties = |number: usize| {
            fastest.is_some_and(|first| self.candidates[number].ties_in_speed_with(&self.candidates[first]))
        };
        let least = fastest.map_or(0.0, ns);
        let is_meant = |&number: &usize| {
            named.contains(&Some(number))
                || self.frontier.contains(&number)
                || fit(&number) && (ties(number) || ns(number) <= (1.0 + CLOSE) * least)
        };
        (0..self.candidates.len()).filter(is_meant).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RAYS: u64 = 1_000_000;

    /// A kernel with this time per ray, wrong rays in pictures and at edges, and claims.
    fn candidate(name: &str, ns: f64, wrong: u64, at_edges: u64, claims: &[Claim]) -> Candidate {
        let rounds = [0.99, 1.0, 1.01, 1.0, 1.0].map(|noise| noise * ns);
        Candidate {
            id: format!("triangle/{name}"),
            answers: WrongAnswers {
                wrong: Rate::of_events(wrong, RAYS).unwrap(),
                at_edges: Rate::of_events(at_edges, RAYS),
                displacement: 1e-7,
            },
            ns: Samples::new(&[rounds.into()]),
            claims: claims.iter().map(|claim| claim.name().into()).collect(),
        }
    }

    fn names(choice: &Choice, numbers: impl IntoIterator<Item = usize>) -> Vec<&str> {
        numbers.into_iter().map(|number| choice.candidates[number].name()).collect()
    }

    fn five() -> Vec<Candidate> {
        vec![
            candidate("exact", 60.0, 0, 0, &[Claim::EdgeWatertight, Claim::RightDecision]),
            candidate("leaky", 40.0, 900, 90_000, &[]),
            candidate("fair", 50.0, 0, 3000, &[]),
            candidate("slow", 55.0, 0, 3050, &[]),
            candidate("tied", 50.4, 1, 2900, &[Claim::EdgeWatertight]),
        ]
    }

    #[test]
    fn the_fastest_kernel_that_meets_the_need_is_chosen_and_of_ties_the_most_careful() {
        let choice = Choice::new(five(), Need { max_wrong: 10.0 }).unwrap();
        assert_eq!(choice.chosen().unwrap().name(), "tied", "it is wrong less often at edges than the one that ties");
        assert_eq!(names(&choice, choice.ties.clone()), ["fair"]);
        assert_eq!(names(&choice, choice.runner_up), ["fair"]);
        assert_eq!(names(&choice, choice.cheaper), ["leaky"]);
        assert_eq!(names(&choice, choice.careful), ["exact"]);
        assert_eq!(names(&choice, choice.frontier.clone()), ["leaky", "fair", "exact"]);
        assert_eq!(choice.least_wrong().name(), "exact");
        // With a need that everything meets, the fastest one has no rival.
        let lax = Choice::new(five(), Need { max_wrong: 1e4 }).unwrap();
        assert_eq!((lax.chosen().unwrap().name(), lax.cheaper), ("leaky", None));
        assert!(lax.ties.is_empty());
        // A need of zero asks for a claim, and for edges.
        let none = Choice::new(five(), Need { max_wrong: 0.0 }).unwrap();
        assert_eq!((none.chosen().unwrap().name(), none.careful), ("exact", None));
        let mut at_edges = five();
        at_edges[0].answers.at_edges = Rate::of_events(1, RAYS);
        assert_eq!(Choice::new(at_edges, Need { max_wrong: 0.0 }).unwrap().chosen, None);
        assert!(Choice::new(Vec::new(), Need { max_wrong: 1.0 }).is_none());
    }

    #[test]
    fn care_must_not_cost_more_than_the_tie_and_cheaper_kernels_do_not_meet_the_need() {
        let noisy = |name: &str, ns: [f64; 5], at_edges| Candidate {
            ns: Samples::new(&[ns.into()]),
            ..candidate(name, 1.0, 0, at_edges, &[])
        };
        // Their interval contains 1, but by the median the careful one is 5 % slower.
        let fast = noisy("fast", [48.0, 50.0, 50.0, 52.0, 50.0], 3000);
        let careful = noisy("careful", [53.0, 52.5, 49.0, 52.5, 53.0], 100);
        let choice = Choice::new(vec![fast, careful], Need { max_wrong: 10.0 }).unwrap();
        assert_eq!((choice.chosen().unwrap().name(), choice.ties.len()), ("fast", 1));
        // The fastest one meets the need, and the careful one that ties with it is chosen: nothing is cheaper.
        let pair = vec![candidate("fast", 50.0, 0, 3000, &[]), candidate("careful", 50.4, 0, 100, &[])];
        let choice = Choice::new(pair, Need { max_wrong: 10.0 }).unwrap();
        assert_eq!((choice.chosen().unwrap().name(), choice.cheaper), ("careful", None));
    }

    #[test]
    fn a_little_more_right_is_not_more_careful() {
        let kernels =
            |at_edges| vec![candidate("chosen", 50.0, 0, 3000, &[]), candidate("slower", 60.0, 0, at_edges, &[])];
        let careful = |at_edges| Choice::new(kernels(at_edges), Need { max_wrong: 10.0 }).unwrap().careful;
        assert_eq!([careful(2000), careful(301), careful(300), careful(0)], [None, None, Some(1), Some(1)]);
    }

    #[test]
    fn a_need_is_met_only_by_a_whole_interval() {
        let standing = |wrong| candidate("x", 1.0, wrong, 0, &[]).standing(Need { max_wrong: 10.0 });
        // 3 of a million: at most 8.8 per million; 4: at most 10.2. 18: at least 10.7; 17: at least 9.9.
        let cases = [(0, Standing::Meets), (3, Standing::Meets), (4, Standing::Open), (17, Standing::Open)];
        for (wrong, expected) in cases {
            assert_eq!(standing(wrong), expected, "{wrong}");
        }
        assert_eq!(standing(18), Standing::Fails);
        let mut few = candidate("x", 1.0, 0, 0, &[]);
        few.answers.wrong = Rate::of_events(0, 1000).unwrap();
        assert_eq!(few.standing(Need { max_wrong: 10.0 }), Standing::Open, "few rays show nothing");
    }

    #[test]
    fn more_right_needs_evidence_and_no_counterevidence() {
        let of = |wrong, at_edges, claims: &[Claim]| candidate("x", 1.0, wrong, at_edges, claims);
        assert!(of(0, 100, &[]).is_more_right_than(&of(50, 100, &[])));
        assert!(!of(0, 100, &[]).is_more_right_than(&of(3, 100, &[])), "chance");
        assert!(of(3, 100, &[]).is_more_right_than(&of(0, 900, &[])), "edges decide where pictures tie");
        assert!(!of(0, 900, &[]).is_more_right_than(&of(50, 100, &[])), "one speaks for each");
        let right = [Claim::RightDecision];
        assert!(of(0, 0, &right).is_more_right_than(&of(0, 0, &[])));
        assert!(!of(0, 0, &right).is_more_right_than(&of(0, 0, &right)));
    }

    #[test]
    fn rows_of_a_scene_become_candidates() {
        let judged = |rays: &str, ray_count, lost, displaced| OnSceneRow {
            scene: "room".into(),
            rays: rays.into(),
            kernel: "triangle/woop".into(),
            ray_count,
            solid: 0,
            open: 0,
            lost,
            false_hits: 1,
            neighbours: 100,
            displaced,
            displacement_p99: 1e-6 * lost as f64,
            checksum: String::new(),
        };
        let timed = |rays: &str, ns: f64| SceneSpeedRow {
            scene: "room".into(),
            rays: rays.into(),
            kernel: "triangle/woop".into(),
            ns_per_ray: ns,
            ns_per_ray_low: ns,
            ns_per_ray_high: ns,
            mrays_per_second: 1e3 / ns,
            ns_of_rounds: Samples::new(&[vec![ns, 2.0 * ns], vec![3.0 * ns]]),
            checksum: String::new(),
        };
        let judged = [judged("primary", 3000, 2, 4), judged("shadow", 1000, 0, 0), judged(EDGES, 500, 7, 0)];
        let timed = [timed("primary", 10.0), timed("shadow", 50.0)];
        let (judged, timed): (Vec<_>, Vec<_>) = (judged.iter().collect(), timed.iter().collect());
        let candidates = Candidate::all("triangle", &judged, &timed, &|_| vec!["single-hit".into()]);
        let [woop] = &candidates[..] else { panic!("{candidates:?}") };
        assert_eq!(
            (woop.answers.wrong, woop.answers.at_edges),
            (Rate { events: 8, of: 4000 }, Rate::of_events(8, 500))
        );
        assert_eq!(woop.answers.displacement, 2e-6);
        // Three quarters of the rays of a picture are primary rays.
        assert_eq!(woop.ns.groups(), [vec![20.0, 40.0], vec![60.0]]);
        assert_eq!(woop.claims, ["single-hit"]);
        assert!(Candidate::all("quadric", &judged, &timed, &|_| Vec::new()).is_empty());
    }
}
