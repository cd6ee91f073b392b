//! From likelihoods and lengths to probabilities.

use super::search::BIT;

/// What a law must gain in twice the log likelihood beyond its length before it is as probable as none: as an effect of the catalogue must
/// beyond its number. 16 is a chance of 1 in 10,000, which leaves room for noise that is not quite what the likelihood takes it for.
pub const EVIDENCE: f64 = 16.0;
/// Sigma of what is believed of a law's size before a flight, rms, metres: the misfits that anyone is after.
pub const SIZE_M: f64 = 10.0;
/// Laws are proposed where together they are so probable.
pub const PROPOSED: f64 = 0.95;
/// A law with so much less evidence than a simpler one is not on the front: twice the logarithm of odds of 20.
pub const DOMINATED: f64 = 6.0;
/// Correlation (of whitened columns) from which on two laws are equal on the flights: one leaves a tenth of what the other explains.
pub const EQUAL: f64 = 0.95;
/// Most laws that are proposed.
pub const MOST_LAWS: usize = 5;

/// What is known of a law when it is weighed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weight {
    /// What it gains in twice the log likelihood, its residual's autocorrelation taken off.
    pub evidence: f64,
    /// Its length.
    pub bits: f64,
    /// Information of its coefficient times the prior's variance.
    pub surprise: f64,
    /// Twice the log prior odds of the effects that it takes the place of.
    pub instead_of: f64,
}

impl Weight {
    /// Twice the logarithm of its odds against none. The coefficient is integrated over its prior (Laplace's method).
    #[must_use]
    pub fn twice_log_odds(&self) -> f64 {
        self.evidence - BIT * self.bits - EVIDENCE - libm::log1p(self.surprise.max(0.0)) + self.instead_of
    }
}

/// Probabilities of laws with these (twice log) odds, and of none.
#[must_use]
pub fn probabilities(twice_log_odds: &[f64]) -> (Vec<f64>, f64) {
    let most = twice_log_odds.iter().copied().fold(0.0, f64::max);
    let weights: Vec<f64> = twice_log_odds.iter().map(|odds| libm::exp(0.5 * (odds - most))).collect();
    let none = libm::exp(-0.5 * most);
    let sum = none + weights.iter().sum::<f64>();
    (weights.iter().map(|weight| weight / sum).collect(), none / sum)
}

/// Which laws are on the front of simplicity against evidence: no simpler one has more evidence beyond chance.
#[must_use]
pub fn front(weights: &[Weight]) -> Vec<bool> {
    let is_dominated = |own: &Weight| {
        weights.iter().any(|other| other.bits < own.bits && other.evidence > own.evidence + DOMINATED)
    };
    weights.iter().map(|own| !is_dominated(own)).collect()
}
