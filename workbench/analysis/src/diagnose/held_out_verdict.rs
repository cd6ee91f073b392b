//! Whether an effect predicts data that it was not learned from worse than no effect does, beyond chance.
//!
//! The raw rms error cannot decide this. It is mostly the reference's slow wander, which correlates with any
//! regressor by chance, so a small true effect often makes it larger. The likelihood accounts for the wander
//! ([`Evidence`]). The coefficient c raises twice its logarithm by `G = c (2 s - c i)`, which is negative
//! where the held-out data, fitted by itself, gives less than half of c. With V the score's variance (Newey
//! and West's, and at least the information), `z = G / (2 |c| sqrt(V))` is normal with unit variance about
//!
//! - 0 where the effect is half as large as learned, so that it does as much good as harm,
//! - `|c| i / (2 sqrt(V))` where it acts as learned,
//! - minus that where it does not act.
//!
//! The test is one-sided at 5 %: an effect is called harmful below z = -1.645. A true effect, whatever its
//! size, is called harmful in at most 5 % of cases, and in `P(z < -1.645 - |c| i / (2 sqrt(V)))`; one that
//! does not act in `P(z < -1.645 + |c| i / (2 sqrt(V)))`. Where the latter is less than 95 %, the test cannot
//! tell and reports that.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::evidence::{Evidence, Folds};

/// Normal deviate below which 5 % lie, with its sign reversed.
const LEVEL: f64 = 1.645;

/// Held-out data, predicted with an effect and without.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct HeldOutVerdict {
    /// What twice the log likelihood gains by the effect; negative if the effect makes it worse.
    pub gain: f64,
    /// One sigma of the gain by chance.
    pub gain_sigma: f64,
    /// The gain if the effect acted exactly as learned; minus that if it did not act.
    pub gain_as_learned: f64,
    /// Whether the effect is harmful beyond chance.
    pub is_worse: bool,
    /// Whether an effect that does not act would be detected, with a probability of 95 %.
    pub can_tell: bool,
}

impl HeldOutVerdict {
    fn new(gain: f64, gain_sigma: f64, gain_as_learned: f64) -> Self {
        Self {
            gain,
            gain_sigma,
            gain_as_learned,
            is_worse: gain < -LEVEL * gain_sigma,
            can_tell: gain_as_learned > 2.0 * LEVEL * gain_sigma,
        }
    }

    /// The verdict on flights that the coefficient was not learned from.
    #[must_use]
    pub fn on_flights(evidence: &Evidence, coefficient: f64) -> Self {
        let Evidence { score, information, variance } = *evidence;
        Self::new(
            coefficient * (2.0 * score - coefficient * information),
            2.0 * coefficient.abs() * variance.sqrt(),
            coefficient * coefficient * information,
        )
    }

    /// The verdict on stretches of the learning flights, each with the coefficient of all the others. Because
    /// that coefficient varies by chance too, the gain's sigma uses the derivative with respect to every
    /// stretch's score.
    #[must_use]
    pub fn on_stretches(folds: &Folds) -> Self {
        let all = folds.stretches.iter().fold(folds.captive, |sum, stretch| sum.and(*stretch));
        let mut gain = 0.0;
        let mut as_learned = 0.0;
        // Derivatives through the stretch's own score, and through the others' coefficient.
        let mut own = Vec::with_capacity(folds.stretches.len());
        let mut by_others = Vec::with_capacity(folds.stretches.len());
        for stretch in &folds.stretches {
            let information = all.information - stretch.information;
            // A coefficient that only this stretch shows cannot be predicted from the others.
            let known = information > 0.0 && stretch.information > 0.0;
            let coefficient = if known { (all.score - stretch.score) / information } else { 0.0 };
            gain += coefficient * (2.0 * stretch.score - coefficient * stretch.information);
            as_learned += coefficient * coefficient * stretch.information;
            own.push(2.0 * coefficient);
            let bend = 2.0 * (stretch.score - coefficient * stretch.information);
            by_others.push(if known { bend / information } else { 0.0 });
        }
        let every: f64 = by_others.iter().sum();
        let mut variance = every * every * folds.captive.variance;
        for ((stretch, own), by_others) in folds.stretches.iter().zip(own).zip(by_others) {
            let derivative = own + every - by_others;
            variance += derivative * derivative * stretch.variance;
        }
        Self::new(gain, variance.sqrt(), as_learned)
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng as _;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution as _, StandardNormal};

    use super::*;

    const SEEDS: u32 = 4000;

    /// The share of seeds in which the verdict is "worse".
    fn refused(mut verdict: impl FnMut(&mut dyn FnMut() -> f64) -> HeldOutVerdict) -> f64 {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let mut white = move || -> f64 { StandardNormal.sample(&mut random) };
        let worse = (0..SEEDS).filter(|_| verdict(&mut white).is_worse).count();
        worse as f64 / f64::from(SEEDS)
    }

    /// Evidence of a true coefficient, with this many times the likelihood's chance variation.
    fn evidence(truth: f64, information: f64, inflation: f64, white: &mut dyn FnMut() -> f64) -> Evidence {
        let variance = information * inflation;
        Evidence { score: truth * information + variance.sqrt() * white(), information, variance }
    }

    /// Four binomial sigmas about a rate.
    fn close(rate: f64, expected: f64) -> bool {
        (rate - expected).abs() < 4.0 * (expected * (1.0 - expected) / f64::from(SEEDS)).sqrt()
    }

    #[test]
    fn a_flight_is_refused_at_the_rate_that_is_stated() {
        // In sigmas of the held-out estimate: |c| i / (2 sqrt(V)) = 1.5, so P(z < -3.145), 5 %, P(z <
        // -0.145).
        for (truth, expected) in [(3.0, 0.000_83), (1.5, 0.05), (0.0, 0.442_4)] {
            for inflation in [1.0, 2.5] {
                let scale = f64::sqrt(inflation);
                let rate = refused(|white| {
                    HeldOutVerdict::on_flights(&evidence(truth * scale, 1.0, inflation, white), 3.0 * scale)
                });
                assert!(close(rate, expected), "{truth} {inflation}: {rate}, not {expected}");
            }
        }
        // The sign does not matter.
        let rate = refused(|white| HeldOutVerdict::on_flights(&evidence(0.0, 1.0, 1.0, white), -6.6));
        assert!(rate > 0.94, "{rate}");
        let verdict =
            HeldOutVerdict::on_flights(&Evidence { score: 0.0, information: 1.0, variance: 1.0 }, 6.6);
        assert!(
            verdict.can_tell
                && !HeldOutVerdict {
                    ..HeldOutVerdict::on_flights(
                        &Evidence { score: 0.0, information: 1.0, variance: 1.0 },
                        6.5
                    )
                }
                .can_tell
        );
    }

    /// Stretches of very different weight, one of which has nearly all of it: true effects pass, and one that
    /// acts in a single stretch only does not.
    #[test]
    fn stretches_refuse_what_does_not_repeat_and_little_of_what_does() {
        let weights: [&[f64]; 3] = [&[1.0; 5], &[0.01, 0.01, 0.01, 0.01, 5.0], &[0.0, 3.0, 0.1, 1.0, 0.0]];
        for weights in weights {
            for truth in [3.0, 5.0, 20.0] {
                let rate = refused(|white| {
                    let stretches =
                        weights.iter().map(|weight| evidence(truth, *weight, 1.0, white)).collect();
                    HeldOutVerdict::on_stretches(&Folds { captive: Evidence::default(), stretches })
                });
                assert!(rate < 0.05, "{weights:?} {truth}: {rate}");
            }
        }
        let rate = refused(|white| {
            let truth = [12.0, 0.0, 0.0, -6.0, 0.0];
            let stretches = truth.iter().map(|truth| evidence(*truth, 1.0, 1.0, white)).collect();
            HeldOutVerdict::on_stretches(&Folds { captive: Evidence::default(), stretches })
        });
        assert!(rate > 0.5, "{rate}");
    }
}
