//! The plain values that are sent in turn.

use kf_core::config::MAX_ESTIMATED_EFFECTS;
use kf_core::output::Phase;
use kf_core::sensor::{SENSORS, Sensor};

use super::{Telemetry, TickReport, send_value};
use crate::link::{MessageKind, Priority};
use crate::named::{self, Name};

/// A list of values, and the index of the next one.
#[derive(Clone, Copy, Debug)]
pub struct Turn {
    next: usize,
    values: usize,
}

/// Number of errors, moving averages and trusts of all sensors.
const ERRORS: usize = 3 * SENSORS;
const OF_SENSORS: usize = 4 * SENSORS;
const COEFFICIENTS: usize = OF_SENSORS + MAX_ESTIMATED_EFFECTS;
const COEFFICIENT_SIGMAS: usize = COEFFICIENTS + MAX_ESTIMATED_EFFECTS;
const SINGLE: usize = COEFFICIENT_SIGMAS + 5;
const SLOW: usize = SINGLE + MessageKind::COUNT;

impl Turn {
    pub const ERRORS: Self = Self { next: 0, values: ERRORS };
    pub const SLOW: Self = Self { next: 0, values: SLOW };
}

impl Telemetry<'_> {
    /// Sends the next available value of a list: 0 is the errors, 1 everything else.
    pub(super) fn send_in_turn(&mut self, list: usize, report: &TickReport<'_>, now_ms: u32) {
        let Some(Turn { next, values }) = self.turns.get(list).copied() else { return };
        for step in 0..values {
            let index = (next + step) % values;
            let found = if list == 0 {
                self.error_value(index, report, now_ms)
            } else {
                self.slow_value(index, report, now_ms)
            };
            if let Some((name, time_ms, value)) = found {
                send_value(&mut self.link, Priority::Turn, time_ms, name, value);
                if let Some(turn) = self.turns.get_mut(list) {
                    turn.next = (index + 1) % values;
                }
                return;
            }
        }
    }

    fn error_value(
        &mut self,
        index: usize,
        report: &TickReport<'_>,
        now_ms: u32,
    ) -> Option<(Name, u32, f32)> {
        let sensor = *Sensor::ALL.get(index / 3)?;
        let sample = match index % 3 {
            0 => (named::of(&named::ERROR, sensor), self.errors.get_mut(sensor.index())?.send()?),
            1 => (named::of(&named::MOVING_AVERAGE, sensor), self.averages.get_mut(sensor.index())?.send()?),
            _ => {
                let trust = report.output.sensors.get(sensor.index())?.trust;
                (named::of(&named::TRUST, sensor), (now_ms, named::trust_number(trust)))
            }
        };
        let (name, (time_ms, value)) = sample;
        Some((name, time_ms, value))
    }

    fn slow_value(&mut self, index: usize, report: &TickReport<'_>, now_ms: u32) -> Option<(Name, u32, f32)> {
        let output = report.output;
        let now = |name: &Name, value: f32| Some((*name, now_ms, value));
        match index {
            0..OF_SENSORS => {
                let sensor = *Sensor::ALL.get(index / 4)?;
                let out = output.sensors.get(sensor.index())?;
                let latch = || report.latch.and_then(|latch| latch.sensors.get(sensor.index()));
                match index % 4 {
                    0 => now(&named::of(&named::BIAS, sensor), out.bias_m),
                    1 => now(&named::of(&named::BIAS_SIGMA, sensor), libm::sqrtf(out.bias_variance_m2)),
                    2 => now(&named::of(&named::RESIDUAL_SIGMA, sensor), latch()?.residual_sigma_m()),
                    _ => now(&named::of(&named::BOUND, sensor), latch()?.bound_m()),
                }
            }
            OF_SENSORS..COEFFICIENTS => {
                let k = index - OF_SENSORS;
                now(named::COEFFICIENT.get(k)?, output.coefficients.get(k)?.coefficient)
            }
            COEFFICIENTS..COEFFICIENT_SIGMAS => {
                let k = index - COEFFICIENTS;
                let variance = output.coefficients.get(k)?.variance;
                now(named::COEFFICIENT_SIGMA.get(k)?, libm::sqrtf(variance))
            }
            COEFFICIENT_SIGMAS..SINGLE => match index - COEFFICIENT_SIGMAS {
                0 if output.phase != Phase::FreeFlight => {
                    now(&named::REFERENCE_SIGMA, libm::sqrtf(output.altitude_variance_m2))
                }
                0 => None,
                1 => self.innovation.send().map(|(time_ms, value)| (named::FIX_INNOVATION, time_ms, value)),
                2 => {
                    report.latch.and_then(|latch| now(&named::FAILED_CHECKS, f32::from(latch.failed_checks)))
                }
                3 => now(&named::TICKS, report.counters.ticks as f32),
                _ => now(&named::WIRE, named::wire_number(self.wire?)),
            },
            _ => {
                let k = index - SINGLE;
                now(named::DROPPED.get(k)?, *self.link.counts().dropped.get(k)? as f32)
            }
        }
    }
}
