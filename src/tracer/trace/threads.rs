//! Pools of threads. They are started before any work, so that a missing thread is an error and not a panic.

use std::env;
use std::thread::available_parallelism;

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::error::{Error, reason};

/// Largest number of threads. Far more than that only exhaust the system.
const MAX_THREADS: usize = 1024;

/// The environment variable that sets the number of threads where no argument does. It is that of `rayon`.
const VARIABLE: &str = "RAYON_NUM_THREADS";

/// A pool of `threads` threads, to run [`trace`](super::trace) or [`Scene::new`](crate::tracer::Scene::new) in. 0 means
/// the number in the environment variable `RAYON_NUM_THREADS`, or one per processor.
///
/// # Errors
/// If there are more than 1024 threads, if the variable is no number, or if the system does not grant the threads.
pub fn thread_pool(threads: usize) -> Result<ThreadPool, Error> {
    let threads = number(threads)?;
    ThreadPoolBuilder::new().num_threads(threads).build().map_err(|error| refused(threads, &error))
}

/// Starts the pool that everything outside a [`thread_pool`] runs in: as many threads as `thread_pool(0)` has.
///
/// # Errors
/// Like [`thread_pool`], or if the pool has been started before.
pub fn start_global_pool() -> Result<(), Error> {
    let threads = number(0)?;
    ThreadPoolBuilder::new().num_threads(threads).build_global().map_err(|error| refused(threads, &error))
}

/// The error if the system does not grant `threads` threads.
pub(crate) fn refused(threads: usize, error: &dyn std::error::Error) -> Error {
    Error::Argument { argument: format!("{threads} threads"), message: format!("cannot be started: {}", reason(error)) }
}

fn number(threads: usize) -> Result<usize, Error> {
    match threads {
        0 => match env::var_os(VARIABLE) {
            Some(value) => parse(&value.to_string_lossy()),
            None => Ok(per_processor()),
        },
        1..=MAX_THREADS => Ok(threads),
        _ => Err(Error::Argument { argument: format!("{threads} threads"), message: EXPECTED.into() }),
    }
}

const EXPECTED: &str = "expected at most 1024 threads";

/// Parses the environment variable. As for `rayon`, 0 and an empty value mean one thread per processor.
fn parse(value: &str) -> Result<usize, Error> {
    match value.parse() {
        _ if value.is_empty() => Ok(per_processor()),
        Ok(0) => Ok(per_processor()),
        Ok(threads @ 1..=MAX_THREADS) => Ok(threads),
        _ => Err(Error::Argument { argument: format!("{VARIABLE}={value}"), message: EXPECTED.into() }),
    }
}

fn per_processor() -> usize {
    available_parallelism().map_or(1, usize::from).min(MAX_THREADS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_of_threads_is_limited() {
        assert_eq!(thread_pool(3).unwrap().current_num_threads(), 3);
        assert_eq!(thread_pool(1025).unwrap_err().to_string(), "1025 threads: expected at most 1024 threads");
        for (value, threads) in [("1", 1), ("1024", 1024), ("0", per_processor()), ("", per_processor())] {
            assert_eq!(parse(value).unwrap(), threads, "{value}");
        }
        for value in ["1025", "60000", "99999999999999999999", "-1", "abc", "2 ", "1.5"] {
            let expected = format!("RAYON_NUM_THREADS={value}: expected at most 1024 threads");
            assert_eq!(parse(value).unwrap_err().to_string(), expected);
        }
    }
}
