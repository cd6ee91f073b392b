//! Removes some of what the search chose: chance, harmful effects, and effects that cancel each other.

use kf_core::effect::EffectId;
use kf_core::sensor::Sensor;
use statistics::normal_above;

use super::Judge;
use crate::diagnose::evidence::{self, Fitted};
use crate::diagnose::held_out;
use crate::diagnose::held_out_verdict::HeldOutVerdict;
use crate::diagnose::repeatability::{Repeatability, inflation, repeatability};
use crate::diagnose::rivals::Rivals;
use crate::diagnose::roughness::unsteadiness;
use crate::diagnose::search::Explanation;

/// Corrected for the number of effects tried, a chosen effect must be less likely than this to be chance.
const SIGNIFICANT: f64 = 0.01;

/// An effect without which held-out errors shrink below this share of their size does not repeat.
const HARMFUL: f64 = 0.95;

/// Effects cancel each other when each is this many times larger than their sum.
const CANCELLING: f64 = 2.5;

impl Judge<'_> {
    /// The chosen column that is most likely to be chance, if it may be.
    pub(super) fn weakest(&self, explanation: &Explanation) -> Option<usize> {
        let information = self.suspects.information(self.problem, &explanation.fit.noise);
        let repeat = repeatability(self.problem, &explanation.fit.noise, &explanation.columns);
        let solution = information.solve(&self.suspects.positions(&explanation.columns))?;
        let n = explanation.columns.len();
        let inflation = self.inflation(explanation, &repeat);
        let chances = explanation.columns.iter().enumerate().map(|(k, column)| {
            let unsteadiness = unsteadiness(self.candidates[*column].effect(), self.has_climb_rate);
            let variance = solution.covariance[k * n + k] * inflation[k] + unsteadiness * unsteadiness;
            (*column, self.chance(solution.coefficients[k], variance))
        });
        let worst = chances.max_by(|a, b| a.1.total_cmp(&b.1))?;
        (worst.1 > SIGNIFICANT).then_some(worst.0)
    }

    /// The one of several effects without which the others predict held-out manoeuvres clearly better.
    pub(super) fn harmful(&self, explanation: &Explanation) -> Option<usize> {
        if explanation.columns.len() < 2 {
            return None;
        }
        let noise = &explanation.fit.noise;
        let rms_m = |columns: &[usize]| {
            held_out::manoeuvres(self.problem, noise, columns, &self.suspects.prior(columns)).any_rms_m()
        };
        let with_all = rms_m(&explanation.columns)?;
        let without = explanation.columns.iter().filter_map(|left_out| {
            let columns: Vec<usize> =
                explanation.columns.iter().copied().filter(|column| column != left_out).collect();
            Some((*left_out, rms_m(&columns)?))
        });
        let best = without.min_by(|a, b| a.1.total_cmp(&b.1))?;
        (best.1 < HARMFUL * with_all).then_some(best.0)
    }

    /// The chosen column whose coefficient is outside the physical range, with the final noise.
    pub(super) fn impossible(&self, explanation: &Explanation) -> Option<usize> {
        let information = self.suspects.information(self.problem, &explanation.fit.noise);
        let solution = information.solve(&self.suspects.positions(&explanation.columns))?;
        let n = explanation.columns.len();
        let outside = explanation.columns.iter().enumerate().map(|(k, column)| {
            let [least, most] = self.suspects.range(*column);
            let coefficient = solution.coefficients[k];
            let beyond = (coefficient - most).max(least - coefficient);
            (*column, beyond / solution.covariance[k * n + k].sqrt())
        });
        let worst = outside.max_by(|a, b| a.1.total_cmp(&b.1))?;
        (!self.suspects.is_possible(&explanation.columns, &solution)).then_some(worst.0)
    }

    /// The chosen column that makes the held-out data less likely, beyond chance, if there is one. The
    /// held-out data are the flights held out, or else stretches of the flights, each predicted from the
    /// others. Where the climb rate is measured, `harmful` decides by the errors, as in the blind trials, and
    /// `pylon add` uses the likelihood.
    pub(super) fn vetoed(&self, explanation: &Explanation) -> Option<usize> {
        let repeat = repeatability(self.problem, &explanation.fit.noise, &explanation.columns);
        let inflation = self.inflation(explanation, &repeat);
        let verdicts = explanation.columns.iter().enumerate().filter_map(|(k, column)| {
            let others: Vec<usize> =
                explanation.columns.iter().copied().filter(|other| other != column).collect();
            let noise = &explanation.fit.noise;
            let fitted = Fitted { noise, others: &others, column: *column, inflation: inflation[k] };
            let folds = evidence::of_folds(self.problem, &fitted);
            let verdict = match self.held {
                Some(held) => {
                    let all = folds.stretches.iter().fold(folds.captive, |sum, part| sum.and(*part));
                    let coefficient = if all.information > 0.0 { all.score / all.information } else { 0.0 };
                    HeldOutVerdict::on_flights(&evidence::of_flights(held, &fitted), coefficient)
                }
                None => HeldOutVerdict::on_stretches(&folds),
            };
            verdict.is_worse.then_some((*column, verdict.gain))
        });
        verdicts.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(column, _)| column)
    }

    /// The larger of the inflations by the spread over the parts and by the residual's autocorrelation.
    pub(in crate::diagnose) fn inflation(
        &self,
        explanation: &Explanation,
        repeat: &[Repeatability],
    ) -> Vec<f64> {
        inflation(self.problem, &explanation.fit.noise, &explanation.columns, repeat)
    }

    /// Two-sided chance of a coefficient as large, times the number of effects tried.
    pub(super) fn chance(&self, coefficient: f64, variance: f64) -> f64 {
        let mut effects: Vec<EffectId> =
            self.suspects.usable().iter().map(|column| self.candidates[*column].effect()).collect();
        effects.dedup();
        let alone = 2.0 * normal_above(coefficient.abs() / variance.sqrt());
        (alone * effects.len() as f64).min(1.0)
    }

    /// Two effects that are each far larger than their sum are distinguished by next to nothing: each becomes
    /// a rival of the other.
    pub(super) fn merge_cancelling(&self, explanation: &Explanation, rivals: &mut [Rivals]) {
        let information = self.suspects.information(self.problem, &explanation.fit.noise);
        let Some(solution) = information.solve(&self.suspects.positions(&explanation.columns)) else {
            return;
        };
        let terms: Vec<(usize, f64)> =
            explanation.columns.iter().copied().zip(solution.coefficients).collect();
        let largest = |sensor: usize| {
            let on: Vec<&(usize, f64)> = terms
                .iter()
                .filter(|(column, _)| {
                    self.candidates[*column].sensor().is_none_or(|own| own.index() == sensor)
                })
                .collect();
            let together_m = self.made_m(&on, sensor);
            on.into_iter()
                .filter(|term| self.made_m(&[*term], sensor) > CANCELLING * together_m)
                .map(|(column, _)| *column)
                .collect::<Vec<usize>>()
        };
        for sensor in Sensor::ALL {
            let cancelling = largest(sensor.index());
            for rival in rivals.iter_mut().filter(|rival| cancelling.contains(&rival.column)) {
                let own = rival.column;
                for other in cancelling.iter().filter(|column| **column != own) {
                    rival.add(*other, 1.0);
                }
            }
        }
    }

    /// What some columns with their coefficients contribute to a sensor's residual in free flight, rms about
    /// the captive mean, metres.
    fn made_m(&self, terms: &[&(usize, f64)], sensor: usize) -> f64 {
        let mut sum = 0.0;
        let mut count = 0_u32;
        for epochs in self.epochs {
            let series = &epochs.series;
            let made = |block: usize| -> f64 {
                terms.iter().map(|(column, value)| value * series.columns[*column][block][sensor]).sum()
            };
            let of = |free: bool| {
                (0..series.len()).filter(move |b| series.free[*b] == free && series.readings[*b][sensor] > 0)
            };
            let captive = of(false).count();
            let base = if captive > 0 { of(false).map(made).sum::<f64>() / captive as f64 } else { 0.0 };
            for block in of(true) {
                sum += (made(block) - base).powi(2);
                count += 1;
            }
        }
        (sum / f64::from(count.max(1))).sqrt()
    }
}
