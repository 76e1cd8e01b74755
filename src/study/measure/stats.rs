//! Robust statistics, and the distance between two floats in ulp. Timings on shared machines have outliers on one side,
//! so medians are used and not means.

/// The middle value. For an even number of values, the mean of the two middle ones. NaN if there are no values.
pub fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    match sorted.len() {
        0 => f64::NAN,
        odd if odd % 2 == 1 => sorted[odd / 2],
        even => (sorted[even / 2 - 1] + sorted[even / 2]) / 2.0,
    }
}

/// Median absolute deviation from the median. NaN if there are no values.
pub(crate) fn mad(values: &[f64]) -> f64 {
    let middle = median(values);
    median(&values.iter().map(|value| (value - middle).abs()).collect::<Vec<_>>())
}

/// Distance of two floats in representable numbers. Neither may be NaN. +0 and −0 count as equal.
pub(crate) fn ulps_between(a: f32, b: f32) -> u32 {
    // The position on a number line of all floats: negative floats count downwards from zero.
    let position = |x: f32| {
        let magnitude = i64::from(x.to_bits() & 0x7fff_ffff);
        if x.is_sign_negative() { -magnitude } else { magnitude }
    };
    position(a).abs_diff(position(b)).try_into().expect("two floats are less than 2^32 apart")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ulps_count_representable_numbers() {
        assert_eq!(ulps_between(1.0, 1.0 + f32::EPSILON), 1);
        assert_eq!(ulps_between(1.0, 1.0 - f32::EPSILON), 2);
        assert_eq!(ulps_between(0.0, -0.0), 0);
        assert_eq!(ulps_between(-1e-45, 1e-45), 2);
        assert_eq!(ulps_between(f32::MAX, f32::INFINITY), 1);
        assert_eq!(ulps_between(f32::NEG_INFINITY, f32::INFINITY), 2 * 0x7f80_0000);
    }

    #[test]
    fn median_and_mad_ignore_an_outlier() {
        assert_eq!(median(&[3.0, 1.0, 1e9]), 3.0);
        assert_eq!(median(&[4.0, 1.0, 2.0, 3.0]), 2.5);
        assert_eq!(mad(&[1.0, 2.0, 3.0, 4.0, 1e9]), 1.0);
        assert!(median(&[]).is_nan());
    }
}
