//! A target figure of Pylon, and its measured value.

use serde::Serialize;

/// One figure.
#[derive(Clone, Debug, Serialize)]
pub struct Figure {
    /// Name of the measured quantity.
    pub name: String,
    /// As measured now, with its unit.
    pub measured: String,
    /// The target.
    pub wanted: String,
    /// Whether the target is reached.
    pub met: bool,
}

impl Figure {
    /// A figure with an upper limit.
    pub fn at_most(name: impl Into<String>, measured: f64, limit: f64, unit: &str) -> Self {
        Self {
            name: name.into(),
            measured: format!("{measured:.2}{unit}"),
            wanted: format!("<= {limit}{unit}"),
            met: measured <= limit,
        }
    }

    /// A figure with a lower limit.
    pub fn at_least(name: impl Into<String>, measured: f64, limit: f64, unit: &str) -> Self {
        Self {
            name: name.into(),
            measured: format!("{measured:.2}{unit}"),
            wanted: format!(">= {limit}{unit}"),
            met: measured >= limit,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_itself_is_met_and_no_number_is_not() {
        assert!(Figure::at_most("", 3.0, 3.0, "").met);
        assert!(!Figure::at_most("", 3.001, 3.0, "").met);
        assert!(Figure::at_least("", 2.0, 2.0, "").met);
        assert!(!Figure::at_least("", f64::NAN, 2.0, "").met);
        assert!(!Figure::at_most("", f64::NAN, 3.0, "").met);
    }

    #[test]
    fn words_have_units() {
        let figure = Figure::at_least("", 2.346, 2.0, " M/s");
        assert_eq!((figure.measured.as_str(), figure.wanted.as_str()), ("2.35 M/s", ">= 2 M/s"));
    }
}
