//! Takes samples of many jobs in rounds. In a round every job has one turn, so no job is timed twice in a row. If the
//! machine is slow for a while, all jobs suffer equally.

use serde::{Deserialize, Serialize};

use crate::study::record::Samples;
use crate::tracer::Error;

/// Something that can be timed.
pub(crate) struct TimedJob<'a> {
    /// What distinguishes it from all other jobs.
    pub(crate) name: String,
    /// Takes one sample: nanoseconds, and a hash of what was computed. Fails if that is wrong.
    pub(crate) sample: Box<dyn Fn() -> Result<(f64, u64), Error> + 'a>,
}

/// The samples that one process took of a job.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct JobTimes {
    /// Name of the job.
    pub(crate) name: String,
    /// Hash of what it computed. It was the same in every round.
    pub(crate) checksum: u64,
    /// Nanoseconds, in the order of the rounds.
    pub(crate) ns: Vec<f64>,
}

/// Takes samples of all jobs. One more round comes first and does not count: it loads code and data. After each round,
/// calls `after_round` with the share of the rounds that is done.
///
/// # Errors
/// If a job or `after_round` fails, or if a job does not compute the same in every round: a timing of wrong results is
/// worthless.
pub(crate) fn take(
    jobs: &[TimedJob],
    rounds: usize,
    after_round: &mut dyn FnMut(f64) -> Result<(), Error>,
) -> Result<Vec<JobTimes>, Error> {
    let mut times: Vec<JobTimes> = Vec::with_capacity(jobs.len());
    for job in jobs {
        let (_, checksum) = (job.sample)()?;
        times.push(JobTimes { name: job.name.clone(), checksum, ns: Vec::with_capacity(rounds) });
    }
    for round in 1..=rounds {
        after_round(round as f64 / (rounds + 1) as f64)?;
        for (job, times) in jobs.iter().zip(&mut times) {
            let (ns, checksum) = (job.sample)()?;
            if checksum != times.checksum {
                return Err(Error::Disagreement(format!("{} while it was timed", job.name)));
            }
            times.ns.push(ns);
        }
    }
    after_round(1.0)?;
    Ok(times)
}

/// The samples of a job from all processes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Times {
    /// Name of the job.
    pub(crate) name: String,
    /// Hash of what it computed, the same in every process.
    pub(crate) checksum: u64,
    /// Nanoseconds.
    pub(crate) ns: Samples,
}

/// Puts together what several processes measured; each group is the jobs of one process. Jobs keep the order of the
/// first one.
///
/// # Errors
/// If a process lacks a job of the first one, or computed something else.
pub(crate) fn merge(groups: &[Vec<JobTimes>]) -> Result<Vec<Times>, Error> {
    let Some(first) = groups.first() else { return Ok(Vec::new()) };
    let merged = first.iter().map(|JobTimes { name, checksum, .. }| {
        let of_group = |(number, group): (usize, &Vec<JobTimes>)| {
            let differs = |what| Error::Disagreement(format!("{name}: processes 1 and {}{what}", number + 1));
            let same = group.iter().find(|other| other.name == *name).ok_or_else(|| differs(", which lacks it"))?;
            if same.checksum == *checksum { Ok(same.ns.clone()) } else { Err(differs("")) }
        };
        let ns = groups.iter().enumerate().map(of_group).collect::<Result<Vec<_>, _>>()?;
        Ok(Times { name: name.clone(), checksum: *checksum, ns: Samples::new(&ns) })
    });
    merged.collect()
}

/// Checks that another build computed the same. Each may lack jobs of the other.
///
/// # Errors
/// If a job of both computed something else.
pub(crate) fn same_in_both(own: &[Times], other: &[Times], target: &str) -> Result<(), Error> {
    let differs = |own: &&Times| other.iter().any(|other| other.name == own.name && other.checksum != own.checksum);
    match own.iter().find(differs) {
        Some(Times { name, .. }) => Err(Error::Disagreement(format!("{name}: this build and that for {target}"))),
        None => Ok(()),
    }
}

/// The times of the job of this name.
///
/// # Errors
/// If there is none.
pub(crate) fn of_job<'a>(times: &'a [Times], name: &str) -> Result<&'a Times, Error> {
    let found = times.iter().find(|times| times.name == name);
    found.ok_or_else(|| Error::Disagreement(format!("{name}: no process has timed it")))
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    #[test]
    fn every_round_takes_one_sample_of_each_job_and_the_first_does_not_count() {
        let turn = Cell::new(0.0);
        let next = || {
            turn.set(turn.get() + 1.0);
            Ok((turn.get(), 7))
        };
        let jobs = ["a", "b"].map(|name| TimedJob { name: name.into(), sample: Box::new(next) });
        let mut shares = Vec::new();
        let times = take(&jobs, 3, &mut |share| {
            shares.push(share);
            Ok(())
        });
        let ns: Vec<_> = times.unwrap().into_iter().map(|times| times.ns).collect();
        assert_eq!(ns, [[3.0, 5.0, 7.0], [4.0, 6.0, 8.0]]);
        assert_eq!(shares, [0.25, 0.5, 0.75, 1.0]);
    }

    #[test]
    fn a_job_that_computes_something_else_fails() {
        let turn = Cell::new(0);
        let sample = || {
            turn.set(turn.get() + 1);
            Ok((1.0, u64::from(turn.get() == 3)))
        };
        let jobs = [TimedJob { name: "a".into(), sample: Box::new(sample) }];
        let error = take(&jobs, 3, &mut |_| Ok(())).unwrap_err();
        assert_eq!(error.to_string(), "hits differ: a while it was timed");
    }

    #[test]
    fn processes_must_agree() {
        let job = |name: &str, checksum, ns: [f64; 2]| JobTimes { name: name.into(), checksum, ns: ns.into() };
        let first = vec![job("a", 1, [1.0, 2.0]), job("b", 2, [3.0, 4.0])];
        // The order does not matter.
        let second = vec![job("b", 2, [7.0, 8.0]), job("a", 1, [5.0, 6.0])];
        let merged = merge(&[first.clone(), second]).unwrap();
        assert_eq!(of_job(&merged, "a").unwrap().ns.groups(), [[1.0, 2.0], [5.0, 6.0]]);
        assert_eq!(of_job(&merged, "b").unwrap().ns.groups(), [[3.0, 4.0], [7.0, 8.0]]);
        assert!(of_job(&merged, "c").is_err());
        let error = |second: Vec<JobTimes>| merge(&[first.clone(), second]).unwrap_err().to_string();
        let other = vec![job("a", 1, [1.0; 2]), job("b", 3, [1.0; 2])];
        assert_eq!(error(other.clone()), "hits differ: b: processes 1 and 2");
        assert_eq!(error(first[..1].into()), "hits differ: b: processes 1 and 2, which lacks it");
        assert_eq!(merge(&[]).unwrap(), []);

        let [own, differing] = [first.clone(), other.clone()].map(|group| merge(&[group]).unwrap());
        assert!(same_in_both(&own, &own[..1], "x86-64").is_ok(), "another build may have fewer kernels");
        let error = same_in_both(&own, &differing, "x86-64").unwrap_err().to_string();
        assert_eq!(error, "hits differ: b: this build and that for x86-64");
        assert!(same_in_both(&own[..1], &own, "x86-64").is_ok());
    }
}
