//! Shares work among threads.

use std::panic::resume_unwind;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use super::counts::Counts;

/// The sum of the counts of all items, in their order, for any number of threads.
///
/// # Panics
/// If `count` panics, with the same content.
pub(super) fn sum<T: Sync>(items: &[T], count: impl Fn(&T) -> Counts + Sync) -> Counts {
    let next = AtomicUsize::new(0);
    let take_turns = || {
        let mut counted = Vec::new();
        while let index = next.fetch_add(1, Ordering::Relaxed)
            && let Some(item) = items.get(index)
        {
            counted.push((index, count(item)));
        }
        counted
    };
    let mut counted = thread::scope(|scope| {
        let helpers = thread::available_parallelism().map_or(1, usize::from).min(items.len()).saturating_sub(1);
        // Without threads, this one does all the work.
        let helpers: Vec<_> =
            (0..helpers).filter_map(|_| thread::Builder::new().spawn_scoped(scope, take_turns).ok()).collect();
        let mut counted = take_turns();
        for helper in helpers {
            counted.extend(helper.join().unwrap_or_else(|panic| resume_unwind(panic)));
        }
        counted
    });
    counted.sort_by_key(|(index, _)| *index);
    counted.into_iter().map(|(_, counts)| counts).fold(Counts::default(), Counts::plus)
}
