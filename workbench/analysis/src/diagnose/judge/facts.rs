//! The figures that go with the verdicts.

use kf_core::effect::EffectId;
use kf_core::sensor::{SENSORS, Sensor};

use super::{Findings, Judge};
use crate::diagnose::delay::DelayShape;
use crate::diagnose::diagnosis::{CandidateFacts, NoiseFacts, SensorWander};
use crate::diagnose::held_out::{self, HeldOut};
use crate::diagnose::roughness::unsteadiness;

impl Judge<'_> {
    /// How much of the residual an effect makes in free flight beside the chosen ones, rms, metres.
    pub(super) fn size_m(&self, findings: &Findings, column: usize) -> f64 {
        let solution = findings.information.solve(&self.beside(findings, column));
        let coefficient = solution.and_then(|solution| solution.coefficients.last().copied()).unwrap_or(0.0);
        coefficient.abs() * self.spread_m(column).0
    }

    /// Spread (about its captive value if there is one) and range of a column in free flight.
    fn spread_m(&self, column: usize) -> (f64, [f64; 2]) {
        let mut sum = 0.0;
        let mut count = 0_u32;
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        let sensor = self.candidates[column].sensor();
        let sign = if sensor.is_none() { -1.0 } else { 1.0 };
        for epochs in self.epochs {
            let series = &epochs.series;
            let value = |block: usize| {
                let by_sensor = (0..SENSORS).find(|i| {
                    series.readings[block][*i] > 0 && sensor.is_none_or(|sensor| sensor.index() == *i)
                });
                by_sensor.map(|i| sign * series.columns[column][block][i])
            };
            let captive: Vec<f64> =
                (0..series.len()).filter(|block| !series.free[*block]).filter_map(value).collect();
            let free: Vec<f64> =
                (0..series.len()).filter(|block| series.free[*block]).filter_map(value).collect();
            let base = if captive.is_empty() { &free } else { &captive };
            let origin = base.iter().sum::<f64>() / base.len().max(1) as f64;
            for value in free {
                sum += (value - origin) * (value - origin);
                count += 1;
                range = [range[0].min(value), range[1].max(value)];
            }
        }
        ((sum / f64::from(count.max(1))).sqrt(), range)
    }

    pub(super) fn candidate_facts(
        &self,
        findings: &Findings,
        subject: Option<Sensor>,
    ) -> Vec<CandidateFacts> {
        let explanation = &findings.explanation;
        // Chosen effects are listed by importance, each held out with all others kept.
        let sizes = explanation.columns.iter().map(|column| (self.size_m(findings, *column), *column));
        let mut chosen: Vec<(f64, usize)> = sizes.collect();
        chosen.sort_by(|a, b| b.0.total_cmp(&a.0));
        let chosen: Vec<usize> = chosen.into_iter().map(|(_, column)| column).collect();
        let mut facts = Vec::new();
        for column in &chosen {
            if self.candidates[*column].sensor() == subject {
                let others: Vec<usize> = chosen.iter().copied().filter(|other| other != column).collect();
                facts.extend(self.candidate(findings, *column, &others, &chosen));
            }
        }
        let mut others = Vec::new();
        for column in self.one_an_effect(findings, subject) {
            if !chosen.iter().any(|other| self.suspects.same_effect(*other, column)) {
                let with: Vec<usize> = chosen.iter().copied().chain([column]).collect();
                if self.is_suspect(findings, column) {
                    others.extend(self.candidate(findings, column, &chosen, &with));
                }
            }
        }
        others.sort_by(|a, b| a.p_value.total_cmp(&b.p_value));
        facts.append(&mut others);
        facts
    }

    /// Whether the coefficient that a candidate would have together with the chosen ones is physically
    /// possible.
    fn is_suspect(&self, findings: &Findings, column: usize) -> bool {
        let set = self.columns_beside(findings, column);
        let solution = findings.information.solve(&self.suspects.positions(&set));
        solution.is_none_or(|solution| self.suspects.is_possible(&set, &solution))
    }

    pub(in crate::diagnose) fn candidate(
        &self,
        findings: &Findings,
        column: usize,
        without: &[usize],
        with: &[usize],
    ) -> Option<CandidateFacts> {
        let candidate = &self.candidates[column];
        let picks = self.beside(findings, column);
        let solution = findings.information.solve(&picks)?;
        let n = picks.len();
        let coefficient = *solution.coefficients.last()?;
        let at = findings.explanation.columns.iter().position(|chosen| *chosen == column);
        let inflation = at.and_then(|at| findings.inflation.get(at)).copied().unwrap_or(1.0);
        let of_noise = solution.covariance[n * n - 1] * inflation;
        let sigma = (of_noise + self.beyond_noise(findings, column).sum()).sqrt();
        let unsteadiness = unsteadiness(candidate.effect(), self.has_climb_rate);
        let variance = of_noise + unsteadiness * unsteadiness;
        let rms = |errors: HeldOut| match candidate.sensor() {
            Some(sensor) => errors.rms_m(sensor.index()),
            None => errors.rms_all_m(),
        };
        let noise = &findings.explanation.fit.noise;
        let prior = |picks: &[usize]| self.suspects.prior(picks);
        let held_out = |picks: &[usize]| match self.held {
            Some(held) => held_out::flights(self.problem, held, noise, picks, &prior(picks)),
            None => held_out::manoeuvres(self.problem, noise, picks, &prior(picks)),
        };
        let (spread_m, envelope_m) = self.spread_m(column);
        let effect = candidate.effect();
        let has_time = effect.has_time_constant();
        Some(CandidateFacts {
            effect: effect.name().into(),
            coefficient,
            sigma,
            unit: effect.unit().into(),
            probability: self.probability(findings, effect),
            p_value: self.chance(coefficient, variance),
            rms_before_m: rms(held_out(without)),
            rms_after_m: rms(held_out(with)),
            chosen: at.is_some(),
            time_constant_s: has_time.then(|| f64::from(candidate.regressor.time_constant_s)),
            noise_share: self.noise_share(findings, column, &solution),
            smoothing_s: match candidate.delay {
                DelayShape::LowPass(time_s) => Some(f64::from(time_s)),
                DelayShape::Slope | DelayShape::Pure(_) => None,
            },
            pure_delay_s: match candidate.delay {
                DelayShape::Pure(delay_s) => Some(f64::from(delay_s)),
                DelayShape::Slope | DelayShape::LowPass(_) => None,
            },
            since: has_time.then(|| candidate.regressor.since.name().into()),
            size_m: coefficient.abs() * spread_m,
            envelope_m,
        })
    }

    /// The probability that an effect acts: from the sets of effects, or else as one of those that may
    /// replace a chosen one.
    fn probability(&self, findings: &Findings, effect: EffectId) -> Option<f64> {
        if let Some(posterior) = &findings.posterior {
            return Some(posterior.inclusion(effect));
        }
        let sets = findings.rivals.iter().chain(&findings.weak).map(|rivals| self.set(rivals).effects);
        let own = sets.flatten().filter(|(other, _)| *other == effect).map(|(_, probability)| probability);
        own.max_by(f64::total_cmp)
    }

    /// Variance of the noise that the regressors of the effects found add to a sensor's blocks, m^2.
    pub(super) fn regressors_noise_m2(&self, findings: &Findings, sensor: Sensor) -> f64 {
        let columns = &findings.explanation.columns;
        let solution = findings.information.solve(&self.suspects.positions(columns));
        let coefficients = solution.map(|solution| solution.coefficients).unwrap_or_default();
        let own = columns
            .iter()
            .zip(coefficients)
            .filter(|(column, _)| self.candidates[**column].sensor().is_none_or(|other| other == sensor));
        own.map(|(column, coefficient)| coefficient * coefficient * self.suspects.column_noise_m2(*column))
            .sum()
    }

    pub(super) fn noise_facts(&self, findings: &Findings) -> NoiseFacts {
        let noise = &findings.explanation.fit.noise;
        let sensors = Sensor::ALL.into_iter().filter(|s| self.epochs.iter().any(|e| e.series.has(s.index())));
        NoiseFacts {
            reference_wander_m: noise.reference.sigma_m,
            reference_time_s: noise.reference.time_s,
            slow_wander_m: noise.slow.sigma_m,
            slow_time_s: noise.slow.time_s,
            fix_sigma_m: noise.fix_sigma_m,
            sensor_wander: sensors
                .map(|sensor| {
                    let wander = noise.sensors[sensor.index()].wander;
                    (sensor.name().into(), SensorWander { sigma_m: wander.sigma_m, time_s: wander.time_s })
                })
                .collect(),
        }
    }
}
