//! Consistency test: are the innovations as large as the filter predicts?

use super::BatchMeans;
use super::distributions::chi_squared_quantile;

/// Probability that a consistent filter's mean NIS lies within the bounds.
const CONFIDENCE: f64 = 0.95;
/// NIS (one degree of freedom) of an innovation of three sigmas.
const THREE_SIGMA_NIS: f64 = 9.0;

/// Compares the mean normalised innovation squared with its chi-squared bounds.
///
/// Source: Bar-Shalom, Li, Kirubarajan, "Estimation with Applications to Tracking and Navigation", section
/// 5.4.2. That test assumes independent innovations; here their effective number comes from batch means, so
/// that autocorrelation widens the bounds as it should.
#[derive(Clone, Debug, Default)]
pub struct NisSummary {
    nis: BatchMeans,
    beyond_three_sigmas: u64,
}

/// Result of [`NisSummary`].
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Consistency {
    /// Mean NIS; 1 for a consistent filter.
    pub mean: f64,
    /// Lower 95 % bound of the mean for a consistent filter.
    pub lower: f64,
    /// Upper 95 % bound.
    pub upper: f64,
    /// Share of innovations beyond three sigmas; 0.0027 for a consistent filter.
    pub beyond_three_sigmas: f64,
    /// Number of innovations.
    pub count: u64,
    /// Number of independent innovations that they are worth.
    pub effective_count: f64,
}

impl Consistency {
    /// Whether the mean lies within its bounds.
    #[must_use]
    pub fn is_consistent(&self) -> bool {
        (self.lower..=self.upper).contains(&self.mean)
    }
}

impl NisSummary {
    /// Adds the normalised squared innovation of one scalar measurement.
    #[inline]
    pub fn push(&mut self, nis: f64) {
        self.nis.push(nis);
        self.beyond_three_sigmas += u64::from(nis > THREE_SIGMA_NIS);
    }

    /// Mean and bounds; `None` below 32 innovations.
    #[must_use]
    pub fn consistency(&self) -> Option<Consistency> {
        let count = self.nis.moments().count();
        let mean = self.nis.moments().mean()?;
        let effective_count = self.nis.effective_count()?.max(1.0);
        let bound = |p: f64| chi_squared_quantile(effective_count, p) / effective_count;
        let tail = 0.5 * (1.0 - CONFIDENCE);
        Some(Consistency {
            mean,
            lower: bound(tail),
            upper: bound(1.0 - tail),
            beyond_three_sigmas: self.beyond_three_sigmas as f64 / count as f64,
            count,
            effective_count,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::residual_model::tests::first_order;

    fn consistent_share(phi: f64, scale: f64, trials: u64) -> f64 {
        let consistent = (0..trials).filter(|&seed| {
            let mut summary = NisSummary::default();
            for value in first_order(phi, 3_000, 77 + seed) {
                summary.push((scale * value).powi(2));
            }
            summary.consistency().unwrap().is_consistent()
        });
        consistent.count() as f64 / trials as f64
    }

    #[test]
    fn a_consistent_filter_passes_about_95_times_in_100() {
        for phi in [0.0, 0.8] {
            let share = consistent_share(phi, 1.0, 300);
            // 4 sigma of 300 trials is 5 %; batch means with 32-63 batches cost another 2 %.
            assert!((share - 0.95).abs() < 0.07, "phi {phi}: {share}");
        }
    }

    #[test]
    fn a_filter_wrong_by_a_third_fails() {
        assert!(consistent_share(0.0, 4.0 / 3.0, 50) < 0.02);
        assert!(consistent_share(0.0, 0.75, 50) < 0.02);
    }

    #[test]
    fn counts_innovations_beyond_three_sigmas() {
        let mut summary = NisSummary::default();
        for index in 0..100 {
            summary.push(if index % 10 == 0 { 9.1 } else { 8.9 });
        }
        assert!((summary.consistency().unwrap().beyond_three_sigmas - 0.1).abs() < 1e-12);
    }
}
