//! Numbers with their units, as an engineer writes them.

/// Placeholder for a missing value.
pub(crate) const NONE: &str = "-";

/// A length with its sign: `+12.34 m`.
pub(crate) fn signed_m(value: Option<f64>) -> String {
    finite(value).map_or_else(|| NONE.to_owned(), |value| format!("{:+.*} m", decimals(value), value))
}

/// A length: `12.34 m`.
pub(crate) fn metres(value: Option<f64>) -> String {
    finite(value).map_or_else(|| NONE.to_owned(), |value| format!("{:.*} m", decimals(value), value))
}

/// A value with its one sigma: `-72.89 ± 0.64 m`.
pub(crate) fn with_sigma_m(value: Option<f64>, sigma: Option<f64>) -> String {
    match (finite(value), finite(sigma)) {
        (Some(value), Some(sigma)) => {
            let places = decimals(sigma).min(decimals(value).max(2));
            format!("{value:+.places$} ± {sigma:.places$} m")
        }
        _ => signed_m(value),
    }
}

/// A time: `7.60 s`, `12 min`.
pub(crate) fn seconds(value: Option<f64>) -> String {
    match finite(value) {
        None => NONE.to_owned(),
        Some(value) if value < 0.1 => format!("{value:.3} s"),
        Some(value) if value < 1_000.0 => format!("{value:.*} s", if value < 100.0 { 2 } else { 1 }),
        Some(value) if value < 36_000.0 => format!("{:.1} min", value / 60.0),
        Some(value) => format!("{:.1} h", value / 3_600.0),
    }
}

/// A share: `31.7 %`.
pub(crate) fn percent(value: Option<f64>) -> String {
    match finite(value).map(|share| 100.0 * share) {
        None => NONE.to_owned(),
        Some(0.0) => "0 %".to_owned(),
        Some(share) if share < 0.01 => "< 0.01 %".to_owned(),
        Some(share) if share < 10.0 => format!("{share:.2} %"),
        Some(share) => format!("{share:.1} %"),
    }
}

/// A rate of events: `0.10 an hour`.
pub(crate) fn per_hour(value: Option<f64>) -> String {
    match finite(value) {
        None => NONE.to_owned(),
        Some(rate) if rate < 1e-3 => "< 0.001 an hour".to_owned(),
        Some(rate) if rate < 10.0 => format!("{rate:.*} an hour", if rate < 0.1 { 3 } else { 2 }),
        Some(rate) => format!("{} an hour", grouped(rate.round() as u64)),
    }
}

/// A plain number with two or three significant digits.
pub(crate) fn plain(value: Option<f64>) -> String {
    finite(value).map_or_else(|| NONE.to_owned(), |value| format!("{value:.*}", decimals(value)))
}

/// A whole number in groups of three: `720,000`.
pub(crate) fn grouped(value: u64) -> String {
    let digits = value.to_string();
    let mut text = String::with_capacity(digits.len() + digits.len() / 3);
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

fn finite(value: Option<f64>) -> Option<f64> {
    value.filter(|value| value.is_finite())
}

/// Number of decimals that leaves two or three significant digits.
fn decimals(value: f64) -> usize {
    match value.abs() {
        size if size >= 1_000.0 => 0,
        size if size >= 100.0 => 1,
        size if size >= 0.095 || size == 0.0 => 2,
        size if size >= 0.0095 => 3,
        _ => 4,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn writes_what_a_reader_expects() {
        assert_eq!(signed_m(Some(12.345)), "+12.35 m");
        assert_eq!(signed_m(Some(-1_234.5)), "-1234 m");
        assert_eq!(metres(None), "-");
        assert_eq!(metres(Some(f64::NAN)), "-");
        assert_eq!(with_sigma_m(Some(-72.890_9), Some(0.637)), "-72.89 ± 0.64 m");
        assert_eq!(with_sigma_m(Some(-121.87), Some(1.42)), "-121.87 ± 1.42 m");
        assert_eq!(seconds(Some(7.6)), "7.60 s");
        assert_eq!(seconds(Some(0.005)), "0.005 s");
        assert_eq!(seconds(Some(5_400.0)), "90.0 min");
        assert_eq!(percent(Some(0.317_3)), "31.7 %");
        assert_eq!(percent(Some(1e-9)), "< 0.01 %");
        assert_eq!(per_hour(Some(12_345.0)), "12,345 an hour");
        assert_eq!(grouped(720_000), "720,000");
        assert_eq!(grouped(12), "12");
    }
}
