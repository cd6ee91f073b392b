//! Gathers a comparison tick by tick.

use std::collections::BTreeMap;

use executor::Executor;
use kf_core::config::{MAX_ESTIMATED_EFFECTS, MonitorConfig, SigmaSource};
use kf_core::input::TickInput;
use kf_core::latch::LatchRecord;
use kf_core::mission::{Counters, SourceCounters};
use kf_core::output::{CoefficientOutput, Phase, TickOutput, Trust};
use kf_core::quality::FailedChecks;
use kf_core::sensor::{SENSORS, Sensor};
use model::{Effect, Model};

use super::comparison::{
    CalibrationFacts, Comparison, EffectFacts, MonitorFacts, ReadingCounts, ReferenceComparison,
    SensorComparison,
};
use super::cross_check::CrossChecks;
use super::flags::Flags;
use super::phase_statistics::PhaseStatistics;
use super::rules::{RuleRequirements, SensorRules, judge};
use super::timeline::Timeline;
use super::traces::Traces;
use super::warnings::warnings;
use crate::name::Name;

/// Number of worst stretches listed for each sensor.
const WORST_STRETCHES: usize = 3;

/// Takes a mission's inputs and outputs, tick by tick and in bounded memory (except for one entry a second of
/// free flight).
#[derive(Clone, Debug, Default)]
pub struct Comparator {
    captive: [PhaseStatistics; SENSORS],
    free: [PhaseStatistics; SENSORS],
    reference: PhaseStatistics,
    flags: [Flags; SENSORS],
    cross_checks: CrossChecks,
    moving_average_m: [Option<f32>; SENSORS],
    last_bias: [Option<(f32, f32)>; SENSORS],
    coefficients: heapless::Vec<CoefficientOutput, MAX_ESTIMATED_EFFECTS>,
    /// Ticks at which each effect was used outside of its envelope, by the bits of
    /// [`TickOutput::extrapolated`].
    extrapolated: [u32; u16::BITS as usize],
    has_read: [bool; SENSORS],
    launch_us: Option<u64>,
    has_settled: bool,
    timeline: Timeline,
    traces: Option<Box<Traces>>,
}

/// The mission's own results at its end.
#[derive(Clone, Copy, Debug)]
pub struct MissionEnd<'a> {
    /// The latched calibration, if there was a launch.
    pub latch: Option<&'a LatchRecord>,
    /// The mission's counts.
    pub counters: &'a Counters,
    /// The flown model.
    pub model: &'a Model,
}

impl Comparator {
    /// A comparator. `trace_slots` keeps the data of charts, each series with at most this many slots.
    #[must_use]
    pub fn new(trace_slots: Option<usize>) -> Self {
        let traces = trace_slots.map(|slots| Box::new(Traces::new(slots)));
        Self { traces, ..Self::default() }
    }

    /// Takes one tick.
    #[inline]
    pub fn take(&mut self, input: &TickInput, output: &TickOutput) {
        if output.out_of_order {
            return;
        }
        if output.latched_now {
            self.launch_us = Some(output.time_us);
        }
        if let Some(traces) = &mut self.traces {
            traces.take(input, output);
        }
        for (has_read, sensor) in self.has_read.iter_mut().zip(&output.sensors) {
            *has_read |= sensor.error_m.is_some() || sensor.rejection.is_some();
        }
        if output.extrapolated != 0 {
            for (bit, ticks) in self.extrapolated.iter_mut().enumerate() {
                *ticks += u32::from(output.extrapolated >> bit & 1);
            }
        }
        self.has_settled |= output.phase != Phase::Settling;
        match output.phase {
            Phase::Settling => {}
            Phase::Calibrating => self.take_captive(output),
            Phase::FreeFlight => self.take_free(input, output),
        }
    }

    fn take_captive(&mut self, output: &TickOutput) {
        if let Some(innovation_m) = output.gps_innovation_m {
            self.reference.take_error(output.time_us, f64::from(innovation_m));
        }
        if let Some(signed_nis) = output.gps_signed_nis {
            self.reference.take_nis(signed_nis);
        }
        if !output.coefficients.is_empty() {
            self.coefficients.clone_from(&output.coefficients);
        }
        for (index, sensor) in output.sensors.iter().enumerate() {
            self.captive[index].take_captive(output.time_us, sensor);
            if sensor.error_m.is_some() {
                self.last_bias[index] = Some((sensor.bias_m, sensor.bias_variance_m2));
            }
        }
    }

    fn take_free(&mut self, input: &TickInput, output: &TickOutput) {
        self.timeline.take(input, output);
        if let Some(check) = &output.cross_check {
            self.cross_checks.take(output.time_us, check);
        }
        for (index, sensor) in output.sensors.iter().enumerate() {
            if let Some(error_m) = sensor.error_m {
                self.free[index].take_error(output.time_us, f64::from(error_m));
            }
            self.moving_average_m[index] = sensor.moving_average_m.or(self.moving_average_m[index]);
            self.flags[index].take(output.time_us, sensor.trust);
        }
    }

    /// The comparison, without what only the caller has (the names of flight and model, the remedies), and
    /// the traces if they were kept.
    #[must_use]
    pub fn finish(
        self,
        end: &MissionEnd<'_>,
        requirements: &RuleRequirements,
        executor: &dyn Executor,
    ) -> (Comparison, Option<Box<Traces>>) {
        let sensors = Sensor::ALL
            .into_iter()
            .filter(|sensor| self.has_read[sensor.index()])
            .map(|sensor| (sensor.name().into(), self.sensor(sensor, end)))
            .collect();
        let failures = self.timeline.failures(WORST_STRETCHES);
        let mut comparison = Comparison {
            version: Comparison::VERSION,
            launch_s: self.launch_us.map(|launch_us| launch_us as f64 * 1e-6),
            sensors,
            cross_check: self.cross_checks.facts(|time_us| self.after_s(time_us)),
            reference: ReferenceComparison {
                captive: self.reference.summary(0.0),
                fixes: counts(&end.counters.gps),
            },
            calibration: calibration(end.latch),
            effects: self.effects(end.model),
            monitor: monitor(&end.model.monitor),
            rules: self.rules(end, requirements, executor),
            failures,
            ..Comparison::default()
        };
        comparison.warnings = warnings(end.counters, self.has_settled, &comparison);
        (comparison, self.traces)
    }

    /// Converts a time to seconds after launch.
    fn after_s(&self, time_us: Option<u64>) -> Option<f64> {
        let (time_us, launch_us) = time_us.zip(self.launch_us)?;
        Some(time_us.saturating_sub(launch_us) as f64 * 1e-6)
    }

    fn sensor(&self, sensor: Sensor, end: &MissionEnd<'_>) -> SensorComparison {
        let index = sensor.index();
        let captive = &self.captive[index];
        let latched = end.latch.map(|latch| &latch.sensors[index]).filter(|_| captive.readings() > 0);
        let bias = latched.map(|latch| (latch.bias_m, latch.bias_variance_m2)).or(self.last_bias[index]);
        let bias_m = bias.map(|(bias_m, _)| f64::from(bias_m));
        let captive_summary = captive.summary(bias_m.or_else(|| captive.mean_m()).unwrap_or(0.0));
        let free_summary = self.free[index].summary(0.0);
        let flags = &self.flags[index];
        SensorComparison {
            flies_free: sensor.flies_free(),
            bias_m,
            bias_sigma_m: bias.map(|(_, variance)| f64::from(variance).sqrt()),
            residual_sigma_m: latched
                .map(|latch| f64::from(latch.residual_sigma_m()))
                .filter(|sigma| *sigma > 0.0)
                .or_else(|| captive.spread_m()),
            captive_rms_m: captive_summary.rms_m,
            free_flight_rms_m: free_summary.rms_m,
            moving_average_end_m: self.moving_average_m[index].map(f64::from),
            doubtful_after_s: self.after_s(flags.doubtful_us),
            untrustworthy_after_s: self.after_s(flags.untrustworthy_us),
            trust: flags.last.unwrap_or(Trust::Calibrating).name().into(),
            unmonitored_s: flags.unmonitored_us as f64 * 1e-6,
            bound_m: latched.map(|latch| f64::from(latch.bound_m())).filter(|bound| *bound > 0.0),
            captive: captive_summary,
            free_flight: free_summary,
            readings: counts(&end.counters.sensors[index]),
        }
    }

    fn effects(&self, model: &Model) -> Vec<EffectFacts> {
        let mut estimates = self.coefficients.iter();
        let (mut estimated_bits, mut constant_bits) = (0.., MAX_ESTIMATED_EFFECTS..);
        let fact = |effect: &Effect| {
            let estimate = if effect.estimate { estimates.next() } else { None };
            let bit = if effect.estimate { estimated_bits.next() } else { constant_bits.next() };
            let (coefficient, sigma) = match estimate {
                Some(estimate) => (f64::from(estimate.coefficient), f64::from(estimate.variance).sqrt()),
                None => (f64::from(effect.term.coefficient), f64::from(effect.term.sigma)),
            };
            EffectFacts {
                effect: effect.term.id().name().into(),
                coefficient,
                sigma,
                unit: effect.term.id().unit().into(),
                estimated: effect.estimate,
                envelope_m: effect.term.envelope_m.map(|ends_m| ends_m.map(f64::from)),
                extrapolated_ticks: bit.and_then(|bit| self.extrapolated.get(bit)).copied().unwrap_or(0),
            }
        };
        model.effects.iter().map(fact).collect()
    }

    /// The rules of the sensors that fly free, one job a sensor: they are the only part whose time does not
    /// shrink with the flight.
    fn rules(
        &self,
        end: &MissionEnd<'_>,
        requirements: &RuleRequirements,
        executor: &dyn Executor,
    ) -> BTreeMap<Name, SensorRules> {
        let (multiplier, window_s) =
            (f64::from(end.model.monitor.multiplier), f64::from(end.model.monitor.window_s));
        let persistence_s = f64::from(end.model.monitor.persistence_s);
        let jobs = Sensor::ALL.into_iter().filter(|sensor| sensor.flies_free()).map(|sensor| {
            move || {
                let residual = self.captive[sensor.index()].residual_model()?;
                let bound_m = end
                    .latch
                    .map(|latch| f64::from(latch.sensors[sensor.index()].bound_m()))
                    .filter(|bound| *bound > 0.0);
                Some((
                    sensor.name().into(),
                    judge(residual, bound_m, multiplier, window_s, persistence_s, requirements),
                ))
            }
        });
        executor::map(executor, jobs).into_iter().flatten().collect()
    }
}

fn counts(counters: &SourceCounters) -> ReadingCounts {
    ReadingCounts {
        accepted: counters.accepted,
        not_finite: counters.not_finite,
        held: counters.held,
        stuck: counters.stuck,
        variance: counters.variance,
        gated: counters.gated,
        implausible: counters.implausible,
    }
}

fn calibration(latch: Option<&LatchRecord>) -> CalibrationFacts {
    let Some(latch) = latch else { return CalibrationFacts::default() };
    let failed = FailedChecks::from_bits(latch.failed_checks);
    CalibrationFacts {
        quality: Some(if failed.is_empty() { "good" } else { "degraded" }.into()),
        failed_checks: failed.iter().map(|check| check.name().into()).collect(),
        duration_s: Some(f64::from(latch.duration_s)),
        ..CalibrationFacts::default()
    }
}

fn monitor(config: &MonitorConfig) -> MonitorFacts {
    MonitorFacts {
        sigma: match config.sigma {
            SigmaSource::Residual => "residual".into(),
            SigmaSource::Covariance => "covariance".into(),
            SigmaSource::Datasheet => "datasheet".into(),
        },
        multiplier: f64::from(config.multiplier),
        window_s: f64::from(config.window_s),
        persistence_s: f64::from(config.persistence_s),
    }
}
