//! Logarithmic axes that also have a place for zero.

use std::ops::{Range, RangeInclusive};

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

use super::layout::text_width;

/// A logarithmic axis and its ticks.
#[derive(Clone, Debug)]
pub(super) struct LogAxis {
    /// Decimal logarithms of the two ends. A falling axis starts with the larger one.
    ends: Range<f64>,
    /// The position of zero, as a decimal logarithm.
    zero: f64,
    /// The position of the break between zero and the other values, as a decimal logarithm; `None` if the axis has no
    /// zero at an end.
    break_at: Option<f64>,
    /// The labelled values.
    pub(super) ticks: Vec<f64>,
}

impl LogAxis {
    /// An axis that covers the given values, with at most `most` ticks or a few more. Zero is drawn clearly before the
    /// smallest other value. A value outside `possible` gets no tick.
    pub(super) fn around(values: impl Iterator<Item = f64>, possible: RangeInclusive<f64>, most: usize) -> Self {
        let values: Vec<f64> = values.collect();
        let any_zero = values.contains(&0.0);
        let logs = values.iter().filter(|&&value| value > 0.0).map(|value| value.log10());
        let (low, high) =
            logs.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), log| (log.min(low), log.max(high)));
        // Without values, any range will do.
        let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
        // Space around the outermost marks, and room for two ticks if all values are equal.
        let padding = (0.08 * (high - low) + 0.12).max(0.5 - (high - low) / 2.0);
        let ends = low - padding..high + padding;
        let decades = ends.end - ends.start;
        let steps: &[f64] = if decades < 2.5 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let every = (decades / most as f64).ceil() as i32;
        let exponents = (ends.start.floor() as i32..=ends.end.ceil() as i32).filter(|exponent| exponent % every == 0);
        let positive = exponents.flat_map(|exponent| steps.iter().map(move |step| step * 10f64.powi(exponent)));
        let positive = positive.filter(|tick| ends.contains(&tick.log10()) && possible.contains(tick));
        let ticks = any_zero.then_some(0.0).into_iter().chain(positive).collect();
        let space = (0.18 * decades).max(0.4);
        let zero = ends.start - space;
        let start = if any_zero { zero - space / 2.0 } else { ends.start };
        let break_at = any_zero.then_some(ends.start - space / 2.0);
        Self { ends: start..ends.end, zero, break_at, ticks }
    }

    /// The labels of the ticks of an axis of this length in pixels: those that would overlap others are left out. Zero
    /// and the first tick keep theirs.
    pub(super) fn labelled(&self, length: i32, text: impl Fn(f64) -> String) -> Vec<f64> {
        const GAP: f64 = 8.0;
        let ends = |&tick: &f64| {
            let (middle, width) = (self.position(tick) * f64::from(length), f64::from(text_width(&text(tick))));
            (middle - width / 2.0, middle + width / 2.0)
        };
        let mut labelled: Vec<f64> = Vec::new();
        let (zeros, others): (Vec<f64>, Vec<f64>) = self.ticks.iter().partition(|&&tick| tick == 0.0);
        for tick in zeros.into_iter().chain(others) {
            let (left, right) = ends(&tick);
            let is_free = |other: &f64| ends(other).1 + GAP < left || right + GAP < ends(other).0;
            if labelled.iter().all(is_free) {
                labelled.push(tick);
            }
        }
        labelled
    }

    /// An axis with a tick at each of these severities, in their order, rising or falling. A zero at either end is
    /// drawn one step beyond the others.
    pub(super) fn through(steps: &[f64]) -> Self {
        let logs: Vec<f64> = steps.iter().filter(|&&step| step > 0.0).map(|step| step.log10()).collect();
        let (first, last) = (logs.first().copied().unwrap_or(0.0), logs.last().copied().unwrap_or(0.0));
        let step = if logs.len() > 1 { (last - first) / (logs.len() - 1) as f64 } else { 1.0 };
        let (from, to, zero) = match (steps.first() == Some(&0.0), steps.last() == Some(&0.0)) {
            (true, false) => (first - step, last, first - step),
            (_, true) => (first, last + step, last + step),
            (false, false) => (first, last, last + step),
        };
        let break_at = match steps {
            [.., _, 0.0] => Some(last + step / 2.0),
            [0.0, _, ..] => Some(first - step / 2.0),
            _ => None,
        };
        Self { ends: from - 0.4 * step..to + 0.4 * step, zero, break_at, ticks: steps.to_vec() }
    }

    /// An axis for cells side by side, one for each of `values`, which must be in equal ratios. The ticks are powers of
    /// ten.
    pub(super) fn of_cells(values: &[f64]) -> Self {
        let (first, last) = values.first().zip(values.last()).map_or((0.0, 0.0), |(a, b)| (a.log10(), b.log10()));
        let half = if values.len() > 1 { (last - first) / (values.len() - 1) as f64 / 2.0 } else { 0.5 };
        let ends = first - half..last + half;
        let range = ends.start.min(ends.end)..ends.start.max(ends.end);
        let every = ((range.end - range.start) / 4.0).ceil() as i32;
        let exponents = (range.start.ceil() as i32..=range.end.floor() as i32).filter(|exponent| exponent % every == 0);
        Self { ends, zero: 0.0, break_at: None, ticks: exponents.map(|exponent| 10f64.powi(exponent)).collect() }
    }

    /// The position, from 0 to 1, of the break beside zero; `None` if the axis has no zero at an end.
    pub(super) fn gap(&self) -> Option<f64> {
        self.break_at.map(|log| self.share(log))
    }

    /// The position of a value between the ends: 0 to 1.
    pub(super) fn position(&self, value: f64) -> f64 {
        let log = if value == 0.0 { self.zero } else { value.log10() };
        self.share(log)
    }

    fn share(&self, log: f64) -> f64 {
        (log - self.ends.start) / (self.ends.end - self.ends.start)
    }
}

impl Ranged for LogAxis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (start, end): (i32, i32)) -> i32 {
        start + (self.position(*value) * f64::from(end - start)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        // One grid line per tick, and no finer ones.
        if hint.weight().allow_light_points() { Vec::new() } else { self.ticks.clone() }
    }

    fn range(&self) -> Range<f64> {
        10f64.powf(self.ends.start)..10f64.powf(self.ends.end)
    }
}

impl ValueFormatter<f64> for LogAxis {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_have_at_least_two_ticks() {
        for values in [vec![], vec![1e6], vec![20.0, 21.0], vec![0.1, 44_000.0], vec![1e-3, 4e9], vec![1e-300, 1e300]] {
            let ticks = LogAxis::around(values.iter().copied(), 0.0..=f64::INFINITY, 6).ticks.len();
            assert!((2..=10).contains(&ticks), "{values:?}: {ticks}");
        }
    }

    #[test]
    fn zero_lies_before_every_other_value_and_has_a_tick_only_if_it_occurs() {
        let axis = |values: [f64; 2]| LogAxis::around(values.into_iter(), 1.0..=f64::INFINITY, 6);
        assert!(axis([0.0, 5.0]).ticks.contains(&0.0) && !axis([0.5, 5.0]).ticks.contains(&0.0));
        for value in [1e-9, 0.4, 5.0, 1e6] {
            let axis = axis([0.0, value]);
            assert!(axis.position(0.0) > 0.0 && axis.position(0.0) + 0.1 < axis.position(value), "{value}");
            assert!(axis.gap().is_some_and(|gap| axis.position(0.0) < gap && gap < axis.position(value)), "{value}");
            assert!(axis.ticks.iter().all(|&tick| tick == 0.0 || tick >= 1.0), "there is no tenth of an ulp");
        }
    }

    #[test]
    fn labels_are_left_out_where_they_would_overlap() {
        let steps: Vec<f64> = (-5..=5).map(|step| 10f64.powi(3 * step)).collect();
        let text = |value: f64| format!("{value:e}");
        let axis = LogAxis::through(&steps);
        assert_eq!(axis.labelled(2000, text), steps);
        let few = axis.labelled(250, text);
        assert!(few[0] == steps[0] && (3..8).contains(&few.len()), "{few:?}");
        let ending_in_zero = LogAxis::through(&[1e-1, 1e-2, 1e-3, 1e-4, 0.0]);
        assert!(ending_in_zero.labelled(90, text).contains(&0.0));
    }

    #[test]
    fn severities_run_from_left_to_right_in_their_order() {
        for steps in [vec![1e-1, 1e-3, 1e-6, 0.0], vec![1.0, 1e3, 1e6], vec![1e-15, 1.0, 1e15], vec![4.0, 64.0, 0.0]] {
            let axis = LogAxis::through(&steps);
            let positions: Vec<f64> = steps.iter().map(|&step| axis.position(step)).collect();
            assert!(positions.is_sorted() && positions[0] > 0.0, "{steps:?}: {positions:?}");
            assert!(positions.last() < Some(&1.0) && axis.ticks == steps, "{steps:?}");
        }
        assert_eq!(LogAxis::through(&[1.0, 10.0]).gap(), None);
        let axis = LogAxis::through(&[1e-1, 1e-2, 0.0]);
        assert!(axis.gap().is_some_and(|gap| axis.position(1e-2) < gap && gap < axis.position(0.0)));
        let steps = [0.0, 1e-3, 1e-1, 1.0];
        let axis = LogAxis::through(&steps);
        assert!(steps.map(|step| axis.position(step)).is_sorted() && axis.position(0.0) > 0.0, "zero may come first");
        assert!(axis.gap().is_some_and(|gap| axis.position(0.0) < gap && gap < axis.position(1e-3)));
        for steps in [vec![], vec![0.0], vec![3.0]] {
            let axis = LogAxis::through(&steps);
            assert!(steps.iter().all(|&step| (0.0..=1.0).contains(&axis.position(step))), "{steps:?}");
        }
    }

    #[test]
    fn cells_divide_their_axis_equally() {
        let axis = LogAxis::of_cells(&[1.0, 10.0, 100.0, 1000.0]);
        for (i, value) in [1.0, 10.0, 100.0, 1000.0].into_iter().enumerate() {
            assert!((axis.position(value) - (i as f64 + 0.5) / 4.0).abs() < 1e-12);
        }
        assert_eq!(axis.ticks, [1.0, 10.0, 100.0, 1000.0]);
        assert_eq!(LogAxis::of_cells(&[]).ticks, [1.0]);
    }
}
