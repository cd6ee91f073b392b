//! What the model's effects add to a tick's readings, and whether they were used within their envelopes.

use super::Mission;
use crate::config::MAX_ESTIMATED_EFFECTS;
use crate::effect::{ActingEffects, EffectId, EffectSubject, Regressor};
use crate::reference::AcceptedFix;

/// Regressors of the estimated effects at one tick, and how the effects were used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct EffectUse<const E: usize> {
    /// `None` if a signal is missing.
    regressors_m: [Option<f32>; E],
    /// Readings and fixes that were not corrected by an effect.
    missing: u32,
    /// Readings and fixes outside an effect's envelope.
    beyond: u32,
    extrapolated: u16,
}

impl<const E: usize> EffectUse<E> {
    pub(super) const fn new(regressors_m: [Option<f32>; E]) -> Self {
        Self { regressors_m, missing: 0, beyond: 0, extrapolated: 0 }
    }

    /// Metres per unit of coefficient; zero where a signal is missing.
    pub(super) fn regressors_m(&self) -> [f32; E] {
        self.regressors_m.map(|regressor_m| regressor_m.unwrap_or(0.0))
    }

    /// See [`crate::output::TickOutput::extrapolated`].
    pub(super) const fn extrapolated(&self) -> u16 {
        self.extrapolated
    }

    /// Records that an effect was used with this regressor.
    fn note(&mut self, bit: usize, regressor_m: Option<f32>, extrapolates: impl FnOnce(f32) -> bool) {
        match regressor_m {
            None => self.missing = self.missing.saturating_add(1),
            Some(regressor_m) if extrapolates(regressor_m) => {
                self.beyond = self.beyond.saturating_add(1);
                self.extrapolated |= 1 << (bit & 15);
            }
            Some(_) => {}
        }
    }
}

impl<const HEAD: usize, const TAIL: usize, const E: usize> Mission<HEAD, TAIL, E> {
    /// Regressors of the estimated effects, metres per unit of coefficient.
    pub(super) fn regressors(&self) -> [Option<f32>; E] {
        core::array::from_fn(|j| match self.config.estimated_effects[j].regressor {
            Regressor { id: EffectId::Defined(_), .. } => self.formulas.estimated_m(j),
            regressor => self.signals.regressor_m(regressor),
        })
    }

    /// Sum of the constant effects on a subject, metres, to subtract from its reading; records the use of
    /// every effect on it.
    #[inline(always)]
    pub(super) fn correction_m(&self, subject: EffectSubject, effects: &mut EffectUse<E>) -> f32 {
        if self.calibration.acting().any(subject) { self.sum_of_constants_m(subject, effects) } else { 0.0 }
    }

    fn sum_of_constants_m(&self, subject: EffectSubject, effects: &mut EffectUse<E>) -> f32 {
        let mut sum_m = 0.0;
        let acting = self.calibration.acting();
        for (k, effect) in self.config.constant_effects.iter().enumerate() {
            if acting.constant(subject, k) {
                let regressor_m = match effect.regressor {
                    Regressor { id: EffectId::Defined(_), .. } => self.formulas.constant_m(k),
                    regressor => self.signals.regressor_m(regressor),
                };
                effects.note(MAX_ESTIMATED_EFFECTS + k, regressor_m, |phi| effect.extrapolates(phi));
                sum_m += effect.coefficient * regressor_m.unwrap_or(0.0);
            }
        }
        let regressors_m = effects.regressors_m;
        for (j, (effect, regressor_m)) in self.config.estimated_effects.iter().zip(regressors_m).enumerate() {
            if acting.estimated(subject, j) {
                effects.note(j, regressor_m, |phi| effect.extrapolates(phi));
            }
        }
        sum_m
    }

    /// The accepted fix without the reference's constant effects; stores its regressors of the estimated
    /// ones.
    #[inline]
    pub(super) fn correct_fix(&mut self, accepted: AcceptedFix, effects: &mut EffectUse<E>) -> AcceptedFix {
        let correction_m = self.correction_m(EffectSubject::Gps, effects);
        if E == 0 && correction_m == 0.0 {
            return accepted;
        }
        self.fix_regressors_m =
            self.calibration.acting().own_regressors(EffectSubject::Gps, &effects.regressors_m());
        self.tracker.correct(accepted, correction_m)
    }

    /// What the effects on the reference add to a fix, as at the last one, metres, and its variance, square
    /// metres.
    pub(super) fn effects_on_fix(&self) -> (f32, f32) {
        let mut effects_m = self.tracker.correction_m();
        let mut variance_m2 = 0.0;
        if E > 0 {
            let estimator = self.calibration.estimator();
            let coefficients = estimator.coefficients();
            for (j, (coefficient, phi)) in coefficients.iter().zip(&self.fix_regressors_m).enumerate() {
                if *phi != 0.0 {
                    effects_m += coefficient * phi;
                    variance_m2 += phi * phi * estimator.coefficient_variance(j);
                }
            }
        }
        (effects_m, variance_m2)
    }

    /// Counts this tick's uses of the effects.
    pub(super) fn count_effects(&mut self, effects: &EffectUse<E>) {
        let counters = &mut self.counters;
        counters.effects_without_signal = counters.effects_without_signal.saturating_add(effects.missing);
        counters.effects_extrapolated = counters.effects_extrapolated.saturating_add(effects.beyond);
    }
}

/// Sum of the estimated effects on one subject, metres.
#[inline]
pub(super) fn effect_sum<const E: usize>(
    acting: &ActingEffects,
    subject: EffectSubject,
    coefficients: &[f32; E],
    regressors_m: &[f32; E],
) -> f32 {
    let terms = coefficients.iter().zip(regressors_m).enumerate();
    terms.filter(|(effect, _)| acting.estimated(subject, *effect)).map(|(_, (c, phi))| c * phi).sum()
}
