//! Where a long run stands, for whoever waits for it.

use std::fmt;
use std::ops::Range;
use std::time::{Duration, Instant};

use indicatif::style::ProgressTracker;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

/// What is being done, on standard error: a bar or a spinner on a terminal, nothing in a pipe. Clones draw the same line.
#[derive(Clone, Debug)]
pub struct Progress {
    bar: ProgressBar,
    /// The part of the bar that [`Progress::reach`] fills.
    part: Range<f64>,
}

impl Progress {
    /// Steps of the whole bar.
    const STEPS: u64 = 1000;

    /// A bar with the time that is left, for work that takes its minutes.
    pub fn bar() -> Self {
        // With the longest message it fits into 80 columns.
        let style = ProgressStyle::with_template("{clock:>5} [{bar:20}] {percent:>3} % {remaining:<10} {wide_msg}")
            .expect("the template is well formed")
            .with_key("clock", |state: &ProgressState, line: &mut dyn fmt::Write| {
                // There is nobody to tell if it fails.
                let _ = line.write_str(&clock(state.elapsed()));
            })
            .with_key("remaining", Remaining::default())
            .progress_chars("=> ");
        let bar = ProgressBar::new(Self::STEPS).with_style(style);
        // The clock goes on where a single step takes long. Once a second does not disturb what is timed.
        if !bar.is_hidden() {
            bar.enable_steady_tick(Duration::from_secs(1));
        }
        Self { bar, part: 0.0..1.0 }
    }

    /// A spinner, for work that may be done at once: it shows after half a second.
    pub fn spinner() -> Self {
        let style =
            ProgressStyle::with_template("{spinner} {elapsed} {wide_msg}").expect("the template is well formed");
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden()).with_style(style);
        let late = bar.clone();
        std::thread::spawn(move || {
            std::thread::sleep(Duration::from_millis(500));
            late.set_draw_target(ProgressDrawTarget::stderr());
            if !late.is_hidden() {
                late.enable_steady_tick(Duration::from_millis(250));
            }
        });
        Self { bar, part: 0.0..1.0 }
    }

    /// Says what is being done.
    pub fn note(&self, message: &str) {
        self.bar.set_message(message.to_owned());
    }

    /// Sets the share that is done, of this part or else of the whole.
    pub(crate) fn reach(&self, share: f64) {
        let Range { start, end } = self.part;
        self.bar.set_position(((start + (end - start) * share) * Self::STEPS as f64).round() as u64);
    }

    /// The same line, of which only what lies between these shares is to be filled.
    pub(crate) fn part(&self, shares: Range<f64>) -> Self {
        let place = |share: f64| self.part.start + (self.part.end - self.part.start) * share;
        Self { bar: self.bar.clone(), part: place(shares.start)..place(shares.end) }
    }

    /// One part after the other, as long in relation to each other as these numbers.
    pub(crate) fn parts(&self, lengths: &[f64]) -> Vec<Self> {
        let sum: f64 = lengths.iter().sum();
        let part = |end: &mut f64, length: &f64| {
            let start = *end;
            *end += length / sum;
            Some(self.part(start..*end))
        };
        lengths.iter().scan(0.0, part).collect()
    }

    /// Items with equal parts.
    pub(crate) fn each<'a, T>(&self, items: &'a [T]) -> impl Iterator<Item = (&'a T, Self)> {
        items.iter().zip(self.parts(&vec![1.0; items.len()]))
    }

    /// Prints something beside it.
    pub fn suspend<T>(&self, print: impl FnOnce() -> T) -> T {
        self.bar.suspend(print)
    }

    /// Takes it off the terminal, for good.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

/// The time that is left if all goes on as it went so far on the average. Between two steps it counts down.
#[derive(Clone, Debug, Default)]
struct Remaining {
    position: u64,
    /// From the beginning to the end, as it looked at that position.
    whole: Duration,
}

impl Remaining {
    /// Before so many steps, any guess would be a bad one.
    const FIRST: u64 = Progress::STEPS / 50;

    fn reach(&mut self, position: u64, elapsed: Duration) {
        if position != self.position {
            *self = Self { position, whole: elapsed.mul_f64(Progress::STEPS as f64 / position.max(1) as f64) };
        }
    }

    fn text(&self, elapsed: Duration) -> String {
        if self.position < Self::FIRST {
            return String::new();
        }
        format!("{} left", clock(self.whole.saturating_sub(elapsed)))
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

/// Minutes and seconds.
fn clock(time: Duration) -> String {
    format!("{}:{:02}", time.as_secs() / 60, time.as_secs() % 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_follow_each_other_and_may_have_parts() {
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
    fn the_time_left_counts_down_between_steps() {
        let mut remaining = Remaining::default();
        let mut text = |position, elapsed| {
            let elapsed = Duration::from_secs(elapsed);
            remaining.reach(position, elapsed);
            remaining.text(elapsed)
        };
        assert_eq!([text(0, 1), text(Remaining::FIRST - 1, 2)], [""; 2], "too early to tell");
        assert_eq!([text(250, 30), text(250, 31), text(250, 119)], ["1:30 left", "1:29 left", "0:01 left"]);
        assert_eq!(text(250, 999), "0:00 left", "longer than it looked");
        assert_eq!([text(500, 1000), text(Progress::STEPS, 1500)], ["16:40 left", "0:00 left"]);
    }
}
