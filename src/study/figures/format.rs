//! Numbers as text: significant digits, thousands separators, unit prefixes, and a dash for a missing figure.

/// The text of a missing figure.
pub(crate) const MISSING: &str = "–";

/// `value` to that many significant digits, with thousands separators. Very large and very small values are in
/// scientific notation. [`MISSING`] if `value` is not finite.
pub(crate) fn number(value: f64, digits: i32) -> String {
    if !value.is_finite() {
        return MISSING.to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    // The exponent after rounding: 9.996 to three digits is 10.0.
    let scientific = format!("{value:.*e}", (digits - 1).max(0) as usize);
    let exponent: i32 = scientific.rsplit('e').next().and_then(|exponent| exponent.parse().ok()).unwrap_or(0);
    if !(-4..12).contains(&exponent) {
        return scientific;
    }
    let rounded: f64 = scientific.parse().unwrap_or(value);
    let plain = format!("{rounded:.*}", (digits - 1 - exponent).max(0) as usize);
    let (whole, fraction) = plain.split_at(plain.find('.').unwrap_or(plain.len()));
    separated(whole) + fraction
}

/// A severity, as short as possible.
pub(crate) fn severity(value: f64) -> String {
    match value.abs() {
        1e3..1e5 => count(value.round() as u64),
        1e-2..1e3 => short(&format!("{:.*}", if value < 1.0 { 3 } else { 1 }, value)).to_owned(),
        0.0 => "0".to_owned(),
        _ => {
            let scientific = format!("{value:.1e}");
            let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
            format!("{}e{exponent}", short(mantissa))
        }
    }
}

/// A decimal fraction without trailing zeros.
fn short(fraction: &str) -> &str {
    fraction.trim_end_matches('0').trim_end_matches('.')
}

/// A whole number with thousands separators.
pub(crate) fn count(value: u64) -> String {
    separated(&value.to_string())
}

fn separated(digits: &str) -> String {
    let mut out = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

/// `value` to that many significant digits, with a unit prefix: k, M or G.
pub(crate) fn si(value: f64, digits: i32) -> String {
    match value.abs() {
        1e9.. => number(value / 1e9, digits) + " G",
        1e6.. => number(value / 1e6, digits) + " M",
        1e4.. => number(value / 1e3, digits) + " k",
        _ => number(value, digits),
    }
}

/// A figure that may be missing, to that many significant digits.
pub(crate) fn optional(value: Option<f64>, digits: i32) -> String {
    value.map_or(MISSING.to_owned(), |value| number(value, digits))
}

/// A ratio that may be missing, as `1.50×`.
pub(crate) fn times(ratio: Option<f64>) -> String {
    ratio.filter(|ratio| ratio.is_finite()).map_or(MISSING.to_owned(), |ratio| format!("{ratio:.2}×"))
}

/// A share that may be missing, in whole percent.
pub(crate) fn percent(share: Option<f64>) -> String {
    share.filter(|share| share.is_finite()).map_or(MISSING.to_owned(), |share| format!("{:.0} %", 100.0 * share))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_significant_digits_and_short_severities() {
        let cases = [(51_234.0, "51,200"), (9.996, "10.0"), (0.12345, "0.123"), (999.6, "1,000"), (1.25e-7, "1.25e-7")];
        for (value, text) in cases {
            assert_eq!(number(value, 3), text);
        }
        assert_eq!(number(0.0, 3), "0");
        assert_eq!(number(f64::NAN, 3), MISSING);
        assert_eq!([count(7), count(1_048_576)], ["7", "1,048,576"]);
        let severities = [1e-15, 0.0999, 1e-6 * (1.0 + 1e-15), 0.25, 1.0, 30.0, 65_536.0, 1.5e7, 0.0].map(severity);
        assert_eq!(severities, ["1e-15", "0.1", "1e-6", "0.25", "1", "30", "65,536", "1.5e7", "0"]);
        assert_eq!([si(2e6, 1), si(51_200.0, 3), si(250.0, 3)], ["2 M", "51.2 k", "250"]);
    }
}
