//! Tests whether a sequence is white.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Autocovariance;
use super::distributions::chi_squared_above;

/// Number of lags in the portmanteau test.
const LAGS: usize = 15;

/// The Ljung-Box statistic of autocorrelations at lags 1, 2, ...: chi-squared with as many degrees
/// of freedom as lags, if the `count` values are white.
///
/// Source: Ljung and Box, "On a measure of lack of fit in time series models", Biometrika 65 (1978) 297, eq. 1.
#[must_use]
pub fn ljung_box(autocorrelations: &[f64], count: u64) -> f64 {
    let n = count as f64;
    let sum: f64 =
        autocorrelations.iter().enumerate().map(|(index, rho)| rho * rho / (n - (index + 1) as f64)).sum();
    n * (n + 2.0) * sum
}

/// Whiteness of a sequence.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Whiteness {
    /// Autocorrelation at a lag of one sample; its standard error is 1 / sqrt(n) for a white sequence.
    pub lag_one: f64,
    /// Ljung-Box statistic over the first 15 lags.
    pub ljung_box: f64,
    /// Probability that a white sequence exceeds it.
    pub p_value: f64,
    /// Number of values.
    pub count: u64,
}

impl Whiteness {
    /// Tests a sequence by its autocovariance; `None` when it is too short or constant.
    #[must_use]
    pub fn test(autocovariance: &Autocovariance) -> Option<Self> {
        let rho = autocovariance.leading_autocorrelations();
        let count = autocovariance.count();
        if rho.len() < LAGS || count < 4 * LAGS as u64 {
            return None;
        }
        let statistic = ljung_box(&rho[..LAGS], count);
        let p_value = chi_squared_above(LAGS as f64, statistic);
        Some(Self { lag_one: *rho.first()?, ljung_box: statistic, p_value, count })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Correlator;
    use crate::residual_model::tests::first_order;

    fn test(values: impl IntoIterator<Item = f64>) -> Whiteness {
        let mut correlator = Correlator::default();
        values.into_iter().for_each(|value| correlator.push(value));
        Whiteness::test(&correlator.autocovariance().unwrap()).unwrap()
    }

    #[test]
    fn statistic_agrees_with_a_hand_calculation() {
        // n (n + 2) (0.5^2 / 9 + 0.2^2 / 8) for n = 10: 120 * (0.0277778 + 0.005).
        assert!((ljung_box(&[0.5, -0.2], 10) - 3.933_333).abs() < 1e-5);
    }

    #[test]
    fn rejects_white_sequences_as_often_as_it_says() {
        let trials = 1_000_u64;
        let rejected =
            (0..trials).filter(|&seed| test(first_order(0.0, 500, seed)).p_value < 0.05).count() as f64;
        // Binomial: 4 sigma of 1,000 trials at 5 %. (The statistic is chi-squared to O(lags / n).)
        let sigma = (trials as f64 * 0.05 * 0.95).sqrt();
        assert!((rejected - 50.0).abs() < 4.0 * sigma, "{rejected}");
    }

    #[test]
    fn sees_weak_autocorrelation() {
        let whiteness = test(first_order(0.2, 2_000, 3));
        assert!(whiteness.p_value < 1e-6);
        assert!((whiteness.lag_one - 0.2).abs() < 4.0 / 2_000_f64.sqrt());
    }
}
