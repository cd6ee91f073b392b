//! From likelihoods and lengths to probabilities.

use super::search::BIT;

/// Gain in twice the log likelihood, beyond its length, at which a law is as probable as none: the same that
/// an effect of the catalogue needs beyond the number of candidates. 16 is a chance of 1 in 10,000, which
/// leaves room for noise that is not quite what the likelihood assumes.
pub const EVIDENCE: f64 = 16.0;
/// Prior sigma of a law's size before a flight, rms, metres: the size of misfits of interest.
pub const SIZE_M: f64 = 10.0;
/// Laws are proposed where their probabilities add up to this.
pub const PROPOSED: f64 = 0.95;
/// A law whose evidence is less than a simpler one's by this is not on the front: twice the logarithm of odds
/// of 20.
pub const DOMINATED: f64 = 6.0;
/// Correlation (of whitened columns) above which two laws are equal on the flights: one leaves a tenth of
/// what the other explains.
pub const EQUAL: f64 = 0.95;
/// Maximum number of laws that are proposed.
pub const MOST_LAWS: usize = 5;

/// What is used to weigh a law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weight {
    /// Its gain in twice the log likelihood, reduced for its residual's autocorrelation.
    pub evidence: f64,
    /// Its length, bits.
    pub bits: f64,
    /// Information of its coefficient times the prior's variance.
    pub surprise: f64,
    /// Twice the log prior odds of the effects that it replaces.
    pub instead_of: f64,
}

impl Weight {
    /// Twice the logarithm of its odds against no law. The coefficient is integrated over its prior
    /// (Laplace's method).
    #[must_use]
    pub fn twice_log_odds(&self) -> f64 {
        self.evidence - BIT * self.bits - EVIDENCE - libm::log1p(self.surprise.max(0.0)) + self.instead_of
    }
}

/// Probabilities of laws with these (twice log) odds, and of no law.
#[must_use]
pub fn probabilities(twice_log_odds: &[f64]) -> (Vec<f64>, f64) {
    let most = twice_log_odds.iter().copied().fold(0.0, f64::max);
    let weights: Vec<f64> = twice_log_odds.iter().map(|odds| libm::exp(0.5 * (odds - most))).collect();
    let none = libm::exp(-0.5 * most);
    let sum = none + weights.iter().sum::<f64>();
    (weights.iter().map(|weight| weight / sum).collect(), none / sum)
}

/// Which laws are on the front of simplicity against evidence: no simpler one has more evidence beyond
/// chance.
#[must_use]
pub fn front(weights: &[Weight]) -> Vec<bool> {
    let is_dominated = |own: &Weight| {
        weights.iter().any(|other| other.bits < own.bits && other.evidence > own.evidence + DOMINATED)
    };
    weights.iter().map(|own| !is_dominated(own)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn weight(evidence: f64, bits: f64) -> Weight {
        Weight { evidence, bits, surprise: 100.0, instead_of: 0.0 }
    }

    #[test]
    fn a_law_must_pay_for_its_length() {
        let odds = [weight(60.0, 12.0), weight(62.0, 20.0)].map(|weight| weight.twice_log_odds());
        let (probability, none) = probabilities(&odds);
        // A bit is a factor of two; two of twice the log likelihood are a factor of e.
        let ratio = probability[0] / probability[1];
        assert!((ratio - libm::exp(-1.0) * 256.0).abs() < 1e-9 * ratio, "{ratio}");
        assert!((probability.iter().sum::<f64>() + none - 1.0).abs() < 1e-12);
        // Odds are against no law.
        let against = probability[0] / none;
        assert!((against - libm::exp(0.5 * odds[0])).abs() < 1e-9 * against, "{against}");
        let (nothing, none) = probabilities(&[weight(8.0, 12.0).twice_log_odds()]);
        assert!(nothing[0] < 1e-4 && none > 0.999, "{nothing:?}");
        assert_eq!(probabilities(&[]), (Vec::new(), 1.0));
    }

    #[test]
    fn the_front_has_no_law_that_a_simpler_one_beats_beyond_chance() {
        let weights = [weight(60.0, 12.0), weight(50.0, 20.0), weight(80.0, 20.0), weight(56.0, 14.0)];
        assert_eq!(front(&weights), [true, false, true, true]);
    }
}
