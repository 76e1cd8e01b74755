//! Confidence intervals of rates.

use crate::study::figures::Rate;

/// Probability that the true rate lies outside the interval.
const OUTSIDE: f64 = 0.05;

/// The exact 95 % interval of a rate, in events per million (Clopper, Pearson, "The Use of Confidence or Fiducial
/// Limits", 1934). For no events, it reaches from zero to the one-sided 95 % bound, about 3 events in the whole base.
pub(super) fn interval(rate: Rate) -> [f64; 2] {
    let (events, of) = (rate.events().round(), rate.of as f64);
    let failures = of - events;
    let (low, high) = if events <= 0.0 {
        (0.0, quantile(1.0 - OUTSIDE, 1.0, of))
    } else if failures <= 0.0 {
        (quantile(OUTSIDE, of, 1.0), 1.0)
    } else {
        let half = OUTSIDE / 2.0;
        (quantile(half, events, failures + 1.0), quantile(1.0 - half, events + 1.0, failures))
    };
    [1e6 * low, 1e6 * high]
}

/// The value below which a beta distribution with these parameters lies with this probability.
fn quantile(probability: f64, a: f64, b: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    // The middle of the exponents, so that small values get as many digits as large ones.
    for _ in 0..200 {
        let middle = if high < 1e-3 { f64::sqrt(f64::max(low, 1e-18) * high) } else { (low + high) / 2.0 };
        if incomplete_beta(middle, a, b) < probability { low = middle } else { high = middle }
    }
    high
}

/// The regularised incomplete beta function, by its continued fraction (Press et al., "Numerical Recipes", 6.4).
fn incomplete_beta(x: f64, a: f64, b: f64) -> f64 {
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - incomplete_beta(1.0 - x, b, a);
    }
    let front = libm::lgamma(a + b) - libm::lgamma(a) - libm::lgamma(b) + a * x.ln() + b * (-x).ln_1p();
    let away_from_zero = |value: f64| if value.abs() < 1e-300 { 1e-300 } else { value };
    let (mut c, mut d) = (1.0, 1.0 / away_from_zero(1.0 - (a + b) * x / (a + 1.0)));
    let mut fraction = d;
    // The number of terms grows with the square root of the larger parameter.
    for m in (1..100_000).map(f64::from) {
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        let before = fraction;
        for term in [even, odd] {
            d = 1.0 / away_from_zero(1.0 + term * d);
            c = away_from_zero(1.0 + term / c);
            fraction *= c * d;
        }
        if (fraction / before - 1.0).abs() < 1e-12 {
            break;
        }
    }
    front.exp() * fraction / a
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_agree_with_sums_of_the_distribution() {
        // From sums of the binomial distribution, as events in the base.
        for (events, of, expected) in [
            (0.0, 200_000, [0.0, 2.995_709_8]),
            (1.0, 200_000, [0.025_317_806, 5.571_579_7]),
            (3.0, 10_000, [0.618_714_86, 8.764_745_2]),
            (50.0, 100, [39.832_113, 60.167_887]),
            (100.0, 100, [97.048_695, 100.0]),
            (12_000.0, 20_000, [11_863.427, 12_135.991]),
        ] {
            let found = interval(Rate { per_million: events / f64::from(of) * 1e6, of: of as u64 });
            for (found, expected) in found.map(|rate| rate * f64::from(of) / 1e6).into_iter().zip(expected) {
                assert!((found - expected).abs() <= 1e-6 * expected, "{events} of {of}: {found}, not {expected}");
            }
        }
    }

    #[test]
    fn a_zero_lies_below_every_small_count_of_the_same_base() {
        let bounds: Vec<_> =
            (0..5).map(|events| interval(Rate { per_million: 5.0 * f64::from(events), of: 200_000 })).collect();
        assert!(bounds.is_sorted_by(|a, b| a[0] < b[0] && a[1] < b[1]), "{bounds:?}");
    }
}
