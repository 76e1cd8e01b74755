//! Judges and times kernels on one scene: every kernel briefly, and those that an answer names until their times are
//! known well enough.
//!
//! A kernel is timed in turns with others, so that all of them suffer equally if the machine is slow for a while. In
//! the brief round its turns alternate with those of the tracer's own kernel, and only two prepared scenes are in
//! memory. All times are given relative to that kernel's time in the same turn. So times of different rounds can be
//! compared.

use std::cell::{OnceCell, RefCell};
use std::time::Instant;

use rayon::ThreadPool;

use super::rays::Rays;
use crate::geom::{Hit, Quadric, Triangle};
use crate::kernels::Kernel;
use crate::kernels::quadric::Mixed;
use crate::registry::{self, Registered, Task, Visitor};
use crate::study::measure::built_scene::TracerKernel;
use crate::study::measure::on_scenes::Answered;
use crate::study::measure::ray_sets::RaySet;
use crate::study::measure::scene_speed::row_of;
use crate::study::measure::scene_truth::SceneTruth;
use crate::study::measure::stats::{median, ratio};
use crate::study::record::{OnSceneRow, Samples, SceneSpeedRow};
use crate::tracer::{Error, Mode, Scene, check_memory, checksum, thread_pool, trace_set_into};

/// A kernel for triangles and one for quadrics, by ID.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Pair {
    pub(super) triangle: String,
    pub(super) quadric: String,
}

impl Pair {
    /// The kernels that the tracer has by default.
    pub(super) fn of_tracer() -> Self {
        Self { triangle: TracerKernel::INFO.id.to_string(), quadric: Mixed::<f32>::INFO.id.to_string() }
    }

    /// With another kernel of a family.
    pub(super) fn with(&self, family: &str, id: &str) -> Self {
        match family {
            "triangle" => Self { triangle: id.into(), ..self.clone() },
            _ => Self { quadric: id.into(), ..self.clone() },
        }
    }
}

/// IDs and claims of the kernels of a shape.
pub(super) struct Listed(pub(super) Vec<(String, Vec<String>)>);

impl Listed {
    pub(super) fn of<S: Registered>() -> Self {
        let mut listed = Self(Vec::new());
        S::visit_kernels(&mut listed);
        listed
    }

    /// What a kernel claims.
    pub(super) fn claims(&self, id: &str) -> Vec<String> {
        self.0.iter().find(|(other, _)| other == id).map_or(Vec::new(), |(_, claims)| claims.clone())
    }
}

impl<S: Registered> Visitor<S> for Listed {
    fn visit<K: Kernel<Shape = S>>(&mut self) {
        let claims = K::INFO.claims.iter().map(|claim| claim.name().into()).collect();
        self.0.push((K::INFO.id.to_string(), claims));
    }
}

/// A scene that is prepared for some kernels.
pub(super) trait Prepared: Sync {
    /// Finds the hits of a set of rays.
    fn trace(&self, set: &RaySet, mode: Mode, hits: &mut [Hit<f32>]);

    /// Compares the hits of a set of rays with the exact answers.
    fn judge(&self, truth: &SceneTruth, answered: &Answered, names: [&str; 2], most_displaced: f64) -> OnSceneRow;
}

impl<K: Kernel<Shape = Triangle>> Prepared for Scene<K> {
    fn trace(&self, set: &RaySet, mode: Mode, hits: &mut [Hit<f32>]) {
        trace_set_into(self, &set.rays, set.any_hit, mode, hits);
    }

    fn judge(&self, truth: &SceneTruth, answered: &Answered, names: [&str; 2], most_displaced: f64) -> OnSceneRow {
        answered.judge(truth, names, self, most_displaced)
    }
}

/// Prepares a scene for a pair of registered kernels.
pub(super) fn prepare(scene: &Scene<TracerKernel>, pair: &Pair) -> Box<dyn Prepared> {
    struct Outer<'a>(&'a Scene<TracerKernel>, &'a str);
    impl Task<Triangle> for Outer<'_> {
        type Output = Box<dyn Prepared>;
        fn run<K: Kernel<Shape = Triangle>>(self) -> Self::Output {
            struct Inner<'a, K>(&'a Scene<TracerKernel>, std::marker::PhantomData<K>);
            impl<K: Kernel<Shape = Triangle>> Task<Quadric> for Inner<'_, K> {
                type Output = Box<dyn Prepared>;
                fn run<Q: Kernel<Shape = Quadric>>(self) -> Self::Output {
                    Box::new(self.0.prepared_for::<K, Q>())
                }
            }
            registry::with_kernel(self.1, Inner::<K>(self.0, std::marker::PhantomData)).expect("a registered ID")
        }
    }
    registry::with_kernel(&pair.triangle, Outer(scene, &pair.quadric)).expect("a registered ID")
}

/// What is timed: a prepared scene, and how it is traced.
#[derive(Clone, Copy)]
pub(super) struct Runner<'a> {
    pub(super) prepared: &'a dyn Prepared,
    pub(super) mode: Mode,
    pub(super) sets: &'a [RaySet],
}

/// Times of one runner: for each set of rays, nanoseconds per ray in each round.
#[derive(Clone, Debug)]
pub(super) struct Turns {
    pub(super) ns: Vec<Vec<f64>>,
    /// Hash of the hits of all sets.
    pub(super) checksum: u64,
}

impl Turns {
    /// Nanoseconds per ray over all sets, in each round.
    pub(super) fn total(&self, sets: &[RaySet]) -> Vec<f64> {
        let rays: usize = sets.iter().map(|set| set.rays.len()).sum();
        let of_round = |round: usize| {
            let ns = self.ns.iter().zip(sets).map(|(ns, set)| ns[round] * set.rays.len() as f64);
            ns.sum::<f64>() / rays as f64
        };
        (0..self.ns.first().map_or(0, Vec::len)).map(of_round).collect()
    }
}

/// When rounds end.
pub(super) struct Rounds {
    pub(super) least: usize,
    pub(super) most: usize,
    /// No round begins after it, once there are enough.
    pub(super) deadline: Instant,
}

/// After so many rounds the intervals are looked at, and then again and again.
const LOOK_AFTER: usize = 6;
/// Rounds end if every interval of a ratio is narrower than this.
const NARROW: f64 = 0.008;

/// Times runners in turns, each in one thread.
pub(super) struct Clock {
    pool: ThreadPool,
    hits: RefCell<Vec<Hit<f32>>>,
}

impl Clock {
    /// # Errors
    /// If the system does not grant the thread.
    pub(super) fn new() -> Result<Self, Error> {
        Ok(Self { pool: thread_pool(1)?, hits: RefCell::new(Vec::new()) })
    }

    /// Takes samples of all runners. One more round comes first and does not count: it loads code and data.
    ///
    /// # Errors
    /// If a runner does not find the same hits in every round: a timing of wrong results is worthless.
    pub(super) fn time(&self, runners: &[Runner], rounds: &Rounds, reach: &dyn Fn(f64)) -> Result<Vec<Turns>, Error> {
        let start = Instant::now();
        let mut turns: Vec<Turns> = Vec::new();
        for runner in runners {
            let (_, checksum) = self.turn(runner);
            turns.push(Turns { ns: vec![Vec::new(); runner.sets.len()], checksum });
        }
        for round in 0..rounds.most {
            let available = rounds.deadline.saturating_duration_since(start).as_secs_f64();
            let by_time = start.elapsed().as_secs_f64() / available.max(f64::MIN_POSITIVE);
            reach(by_time.max(round as f64 / rounds.most as f64).min(1.0));
            let is_enough = round >= rounds.least
                && (Instant::now() >= rounds.deadline || round % LOOK_AFTER == 0 && are_narrow(runners, &turns));
            if is_enough {
                break;
            }
            for (runner, turns) in runners.iter().zip(&mut turns) {
                let (ns, checksum) = self.turn(runner);
                if checksum != turns.checksum {
                    return Err(Error::Disagreement("two rounds with one kernel while it was timed".into()));
                }
                turns.ns.iter_mut().zip(ns).for_each(|(rounds, ns)| rounds.push(ns));
            }
        }
        Ok(turns)
    }

    /// Nanoseconds per ray for each set of rays, and a hash of all hits.
    fn turn(&self, runner: &Runner) -> (Vec<f64>, u64) {
        // A value that no ray can give. It overwrites the hits of earlier runs, so that they cannot pass for hits of a
        // later one.
        let unset = Hit::<f32>::new(true, f32::NEG_INFINITY, 0.0, 0.0);
        let buffer = &mut *self.hits.borrow_mut();
        let mut all = 0;
        let mut of_set = |set: &RaySet| {
            buffer.clear();
            buffer.resize(set.rays.len(), unset);
            let seconds = self.pool.install(|| {
                let start = Instant::now();
                runner.prepared.trace(set, runner.mode, buffer);
                start.elapsed().as_secs_f64()
            });
            all = (all * 31 + u128::from(checksum(buffer))) % u128::from(u64::MAX);
            seconds * 1e9 / set.rays.len() as f64
        };
        let ns = runner.sets.iter().map(&mut of_set).collect();
        (ns, all as u64)
    }
}

/// Whether the ratios of all runners to the first are known well.
fn are_narrow(runners: &[Runner], turns: &[Turns]) -> bool {
    let total = |number: usize| Samples::new(&[turns[number].total(runners[number].sets)]);
    let first = total(0);
    (1..turns.len())
        .all(|number| ratio(&total(number), &first).is_some_and(|ratio| ratio.high - ratio.low < NARROW * ratio.value))
}

/// The kernels of one family on one scene.
pub(super) struct Race<'a> {
    pub(super) name: &'a str,
    pub(super) scene: &'a Scene<TracerKernel>,
    pub(super) truth: &'a SceneTruth<'a>,
    pub(super) rays: &'a Rays,
    pub(super) most_displaced: f64,
    pub(super) clock: &'a Clock,
    /// `triangle` or `quadric`.
    pub(super) family: &'static str,
    /// The other family has its kernel of this pair.
    pub(super) pair: Pair,
    /// Nanoseconds per ray of the tracer's own kernel when it was first timed. All times are relative to it.
    pub(super) reference: OnceCell<f64>,
}

impl Race<'_> {
    /// Turns of the brief round.
    const BRIEF: usize = 6;
    /// Least and greatest number of turns of the others.
    const OTHERS: [usize; 2] = [12, 40];

    /// Judges kernels, and times them briefly.
    ///
    /// # Errors
    /// Like [`Clock::time`].
    pub(super) fn all(
        &self,
        ids: &[&str],
        reach: &dyn Fn(f64),
    ) -> Result<(Vec<OnSceneRow>, Vec<SceneSpeedRow>), Error> {
        let base = self.base();
        let (mut judged, mut timed) = (Vec::new(), Vec::new());
        for (number, id) in ids.iter().enumerate() {
            reach(number as f64 / ids.len() as f64);
            let prepared = self.prepare(id);
            judged.extend(self.judge(&*prepared, id, &self.rays.search));
            let rounds = Rounds { least: Self::BRIEF, most: Self::BRIEF, deadline: Instant::now() };
            let turns = self.clock.time(&[self.runner(&*base), self.runner(&*prepared)], &rounds, &|_| {})?;
            timed.extend(self.rows(id, &turns[1], &turns[0]));
        }
        Ok((judged, timed))
    }

    /// Times some kernels in turns, until their times are known well or until the deadline.
    ///
    /// # Errors
    /// Like [`Clock::time`].
    pub(super) fn named(
        &self,
        ids: &[&str],
        deadline: Instant,
        reach: &dyn Fn(f64),
    ) -> Result<Vec<SceneSpeedRow>, Error> {
        let base = self.base();
        let groups: Vec<_> = ids.chunks(self.scenes_in_memory(ids.len())).collect();
        let (start, count) = (Instant::now(), groups.len() as f64);
        let mut rows = Vec::new();
        for (number, ids) in groups.into_iter().enumerate() {
            let prepared: Vec<_> = ids.iter().map(|id| self.prepare(id)).collect();
            let runners: Vec<_> = [&base].into_iter().chain(&prepared).map(|one| self.runner(&**one)).collect();
            let share = deadline.saturating_duration_since(start).mul_f64((number + 1) as f64 / count);
            let [least, most] = Self::OTHERS;
            let rounds = Rounds { least, most, deadline: start + share };
            let turns = self.clock.time(&runners, &rounds, &|share| reach((number as f64 + share) / count))?;
            for (id, own) in ids.iter().zip(&turns[1..]) {
                rows.extend(self.rows(id, own, &turns[0]));
            }
        }
        Ok(rows)
    }

    /// Compares the hits of a kernel with the exact answers.
    pub(super) fn judge(&self, prepared: &dyn Prepared, id: &str, sets: &[Answered]) -> Vec<OnSceneRow> {
        let row = |set: &Answered| prepared.judge(self.truth, set, [self.name, id], self.most_displaced);
        sets.iter().map(row).collect()
    }

    /// The scene, prepared for a kernel of the family.
    pub(super) fn prepare(&self, id: &str) -> Box<dyn Prepared> {
        prepare(self.scene, &self.pair.with(self.family, id))
    }

    /// The scene, prepared for the kernel that all times are relative to.
    fn base(&self) -> Box<dyn Prepared> {
        let Pair { triangle, quadric } = Pair::of_tracer();
        self.prepare(if self.family == "triangle" { &triangle } else { &quadric })
    }

    fn runner<'a>(&'a self, prepared: &'a dyn Prepared) -> Runner<'a> {
        Runner { prepared, mode: Mode::Auto, sets: &self.rays.timed }
    }

    /// How many prepared scenes fit into memory, besides one more. At least one.
    fn scenes_in_memory(&self, wanted: usize) -> usize {
        let bytes = self.scene.bytes();
        (1..=wanted).rev().find(|count| check_memory(bytes.saturating_mul(count + 1)).is_ok()).unwrap_or(1)
    }

    /// The times of a kernel for each set of rays, relative to those of `base` in the same turn.
    fn rows(&self, id: &str, own: &Turns, base: &Turns) -> Vec<SceneSpeedRow> {
        let sets = &self.rays.timed;
        let base = base.total(sets);
        let reference = self.reference.get_or_init(|| median(&base));
        let of_set = |(set, ns): (&RaySet, &Vec<f64>)| {
            let ns: Vec<f64> = ns.iter().zip(&base).map(|(ns, base)| ns * reference / base).collect();
            row_of([self.name, set.name, id], Samples::new(&[ns]), own.checksum)
        };
        sets.iter().zip(&own.ns).filter_map(of_set).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::measure::built_scene::BuiltScene;
    use crate::tracer::SceneSource;

    #[test]
    fn turns_weigh_each_set_by_its_rays() {
        let set = |count| RaySet { name: "x", any_hit: false, rays: vec![crate::geom::Ray::INACTIVE; count] };
        let turns = Turns { ns: vec![vec![10.0, 20.0], vec![50.0, 60.0]], checksum: 0 };
        assert_eq!(turns.total(&[set(3), set(1)]), [20.0, 30.0]);
    }

    #[test]
    fn every_kernel_is_prepared_under_its_own_id_and_rounds_end() {
        let built = BuiltScene::new(&SceneSource::parse("sphere:1000").unwrap(), (24, 1)).unwrap();
        let clock = Clock::new().unwrap();
        let checksum = |id: &str| {
            let prepared = prepare(&built.scene, &Pair::of_tracer().with("triangle", id));
            let runner = Runner { prepared: &*prepared, mode: Mode::Single, sets: &built.sets };
            let rounds = Rounds { least: 2, most: 3, deadline: Instant::now() };
            let turns = clock.time(&[runner], &rounds, &|_| {}).unwrap();
            assert!(turns[0].ns.iter().all(|ns| ns.len() == 2), "the deadline has passed");
            turns[0].checksum
        };
        let kernels = Listed::of::<Triangle>();
        let own: Vec<u64> = kernels.0.iter().map(|(id, _)| checksum(id)).collect();
        assert_eq!(own[0], checksum("triangle/cramer"));
        let distinct: std::collections::HashSet<_> = own.iter().collect();
        assert!(distinct.len() > own.len() / 2, "kernels differ in their last bits: {own:x?}");
        assert!(kernels.claims("triangle/exact").contains(&"right-decision".to_owned()));
    }
}
