//! Shows how far a long run has come: a bar or a spinner on standard error.

use std::fmt;
use std::ops::Range;
use std::time::{Duration, Instant};

use indicatif::style::ProgressTracker;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

/// A line on standard error about the work in progress: a bar or a spinner on a terminal, nothing in a pipe. Clones
/// share the line.
#[derive(Clone, Debug)]
pub struct Progress {
    bar: ProgressBar,
    /// The part of the bar that [`Progress::reach`] fills, from 0 to 1.
    part: Range<f64>,
}

impl Progress {
    /// Number of steps of the whole bar.
    const STEPS: u64 = 1000;

    /// A bar with an estimate of the remaining time, for work that takes minutes.
    pub fn bar() -> Self {
        // The longest message still fits into 80 columns.
        let style = ProgressStyle::with_template("{clock:>5} [{bar:20}] {percent:>3} % {remaining:<10} {wide_msg}")
            .expect("the template is well formed")
            .with_key("clock", |state: &ProgressState, line: &mut dyn fmt::Write| {
                // An error could not be reported anywhere.
                let _ = line.write_str(&clock(state.elapsed()));
            })
            .with_key("remaining", Remaining::default())
            .progress_chars("=> ");
        let bar = ProgressBar::new(Self::STEPS).with_style(style);
        // The clock runs on during a long step. One tick a second does not disturb the timings.
        keep_drawing(&bar, Duration::from_secs(1), || {});
        Self { bar, part: 0.0..1.0 }
    }

    /// A spinner, for work of unknown length. It appears after half a second, so short work shows none.
    pub fn spinner() -> Self {
        let style =
            ProgressStyle::with_template("{spinner} {elapsed} {wide_msg}").expect("the template is well formed");
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden()).with_style(style);
        let late = bar.clone();
        keep_drawing(&bar, Duration::from_millis(250), move || {
            std::thread::sleep(Duration::from_millis(500));
            late.set_draw_target(ProgressDrawTarget::stderr());
        });
        Self { bar, part: 0.0..1.0 }
    }

    /// Shows a message about the current work.
    pub fn note(&self, message: &str) {
        self.bar.set_message(message.to_owned());
    }

    /// Sets the share of this part that is done, from 0 to 1.
    pub(crate) fn reach(&self, share: f64) {
        let Range { start, end } = self.part;
        self.bar.set_position(((start + (end - start) * share) * Self::STEPS as f64).round() as u64);
    }

    /// The same line, for work that fills only this range of the part.
    pub(crate) fn part(&self, shares: Range<f64>) -> Self {
        let position = |share: f64| self.part.start + (self.part.end - self.part.start) * share;
        Self { bar: self.bar.clone(), part: position(shares.start)..position(shares.end) }
    }

    /// Divides this part into consecutive parts. `lengths` are relative.
    pub(crate) fn parts(&self, lengths: &[f64]) -> Vec<Self> {
        let sum: f64 = lengths.iter().sum();
        let part = |end: &mut f64, length: &f64| {
            let start = *end;
            *end += length / sum;
            Some(self.part(start..*end))
        };
        lengths.iter().scan(0.0, part).collect()
    }

    /// Each item with a part of its own; all parts are equally long.
    pub(crate) fn each<'a, T>(&self, items: &'a [T]) -> impl Iterator<Item = (&'a T, Self)> {
        items.iter().zip(self.parts(&vec![1.0; items.len()]))
    }

    /// Hides the line while `print` runs, so that its output is not mixed with the line.
    pub fn suspend<T>(&self, print: impl FnOnce() -> T) -> T {
        self.bar.suspend(print)
    }

    /// Removes the line from the terminal for good.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

/// Draws the line again and again until it is cleared, in a thread that calls `begin` first. `indicatif` could do this,
/// but it panics if the system has no thread left. Here the line then only stands still.
fn keep_drawing(bar: &ProgressBar, interval: Duration, begin: impl FnOnce() + Send + 'static) {
    let bar = bar.downgrade();
    let draw = move || {
        begin();
        while let Some(bar) = bar.upgrade().filter(|bar| !bar.is_hidden() && !bar.is_finished()) {
            bar.tick();
            drop(bar);
            std::thread::sleep(interval);
        }
    };
    let _ = std::thread::Builder::new().spawn(draw);
}

/// The remaining time, if the work goes on at its average speed so far. Between two steps it counts down.
#[derive(Clone, Debug, Default)]
struct Remaining {
    position: u64,
    /// The estimate, at that position, of the time from start to end.
    total: Duration,
}

impl Remaining {
    /// No estimate is shown before this step: it would be a poor one.
    const FIRST: u64 = Progress::STEPS / 50;

    fn reach(&mut self, position: u64, elapsed: Duration) {
        if position != self.position {
            *self = Self { position, total: elapsed.mul_f64(Progress::STEPS as f64 / position.max(1) as f64) };
        }
    }

    fn text(&self, elapsed: Duration) -> String {
        if self.position < Self::FIRST {
            return String::new();
        }
        format!("{} left", clock(self.total.saturating_sub(elapsed)))
    }
}

impl ProgressTracker for Remaining {
    fn clone_box(&self) -> Box<dyn ProgressTracker> {
        Box::new(self.clone())
    }

    fn tick(&mut self, state: &ProgressState, _: Instant) {
        self.reach(state.pos(), state.elapsed());
    }

    fn reset(&mut self, _: &ProgressState, _: Instant) {}

    fn write(&self, state: &ProgressState, line: &mut dyn fmt::Write) {
        let _ = line.write_str(&self.text(state.elapsed()));
    }
}

/// Minutes and seconds, as `m:ss`.
fn clock(time: Duration) -> String {
    format!("{}:{:02}", time.as_secs() / 60, time.as_secs() % 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_consecutive_and_can_be_divided_again() {
        let progress = Progress::bar();
        let reached = |part: &Progress, share| {
            part.reach(share);
            progress.bar.position()
        };
        let parts = progress.parts(&[1.0, 3.0, 0.0]);
        let [first, second, none] = &parts[..] else { panic!("{parts:?}") };
        assert_eq!([reached(first, 0.0), reached(first, 1.0), reached(second, 0.0)], [0, 250, 250]);
        let half = second.part(0.5..1.0);
        assert_eq!([reached(&half, 0.0), reached(&half, 0.5), reached(&half, 1.0)], [625, 813, 1000]);
        assert_eq!([reached(none, 0.0), reached(none, 1.0)], [1000; 2]);
        let each = progress.each(&["a", "b", "c", "d"]).map(|(name, part)| (*name, reached(&part, 0.0)));
        assert_eq!(each.collect::<Vec<_>>(), [("a", 0), ("b", 250), ("c", 500), ("d", 750)]);
    }

    #[test]
    fn the_remaining_time_counts_down_between_steps() {
        let mut remaining = Remaining::default();
        let mut text = |position, elapsed| {
            let elapsed = Duration::from_secs(elapsed);
            remaining.reach(position, elapsed);
            remaining.text(elapsed)
        };
        assert_eq!([text(0, 1), text(Remaining::FIRST - 1, 2)], [""; 2], "too early for an estimate");
        assert_eq!([text(250, 30), text(250, 31), text(250, 119)], ["1:30 left", "1:29 left", "0:01 left"]);
        assert_eq!(text(250, 999), "0:00 left", "longer than estimated");
        assert_eq!([text(500, 1000), text(Progress::STEPS, 1500)], ["16:40 left", "0:00 left"]);
    }
}
