//! Tails of the binomial distribution, for intervals and comparisons of counts. Sums of probabilities, so that counts
//! of millions and chances of one in a million are no problem.

/// The chance of at most `events` events in `trials`, if each has the chance `p`.
pub(super) fn at_most(events: u64, trials: u64, p: f64) -> f64 {
    if events >= trials {
        return 1.0;
    }
    if events as f64 >= p * trials as f64 {
        return 1.0 - at_least(events + 1, trials, p);
    }
    // From the largest term down: `i` events are this much more likely than `i - 1`.
    let odds = (1.0 - p) / p;
    tail(events, trials, p, (1..=events).rev().map(|i| i as f64 / (trials - i + 1) as f64 * odds))
}

/// The chance of at least `events` events in `trials`, if each has the chance `p`.
pub(super) fn at_least(events: u64, trials: u64, p: f64) -> f64 {
    if events == 0 {
        return 1.0;
    }
    if events as f64 <= p * trials as f64 {
        return 1.0 - at_most(events - 1, trials, p);
    }
    let odds = p / (1.0 - p);
    tail(events, trials, p, (events..trials).map(|i| (trials - i) as f64 / (i + 1) as f64 * odds))
}

/// The chance of exactly `events` events and of those beyond it. Each ratio leads from one chance to the next.
fn tail(events: u64, trials: u64, p: f64, ratios: impl Iterator<Item = f64>) -> f64 {
    let (k, n) = (events as f64, trials as f64);
    let choices = libm::lgamma(n + 1.0) - libm::lgamma(k + 1.0) - libm::lgamma(n - k + 1.0);
    let first = (choices + k * p.ln() + (n - k) * (-p).ln_1p()).exp();
    let (mut term, mut sum) = (1.0, 1.0);
    for ratio in ratios {
        term *= ratio;
        sum += term;
        // Ratios fall, so the rest is smaller than a rounding error.
        if term < 1e-17 * sum {
            break;
        }
    }
    first * sum
}

/// The `p` at which a rising function has this value, between 0 and 1, to twelve digits.
pub(super) fn rising_to(value: f64, function: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    // Halves the logarithm first: rates may be tiny.
    while high > 1e-300 && high - low > 1e-12 * high {
        let middle = if low == 0.0 { high / 16.0 } else { (low + high) / 2.0 };
        if function(middle) < value { low = middle } else { high = middle }
    }
    (low + high) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tails_are_sums_of_chances() {
        const TRIALS: u64 = 12;
        for p in [0.001, 0.25, 0.5, 0.9] {
            let chance = |events: u64| {
                let choices: f64 = (1..=events).map(|i| (TRIALS - events + i) as f64 / i as f64).product();
                choices * f64::powi(p, events as i32) * f64::powi(1.0 - p, (TRIALS - events) as i32)
            };
            for events in 0..=TRIALS {
                let most: f64 = (0..=events).map(chance).sum();
                let least: f64 = (events..=TRIALS).map(chance).sum();
                assert!((at_most(events, TRIALS, p) - most).abs() < 1e-12, "at most {events}, {p}");
                assert!((at_least(events, TRIALS, p) - least).abs() < 1e-12, "at least {events}, {p}");
            }
        }
    }

    #[test]
    fn small_arguments_are_found_to_twelve_digits_too() {
        for value in [0.75, 1e-6, 1e-18] {
            assert!((rising_to(value, |p| p) / value - 1.0).abs() < 1e-11, "{value}");
        }
    }
}
