//! What the paper's figures are drawn from.

use kf_core::output::{Phase, TickOutput};
use kf_core::sensor::SENSORS;

use super::envelope::Envelope;

/// An estimate and the standard deviation the filter gives it.
#[derive(Clone, Debug, Default)]
pub struct EstimateTrace {
    /// The estimate, metres.
    pub value_m: Envelope,
    /// Its standard deviation, metres.
    pub sigma_m: Envelope,
}

/// Series of one flight, thinned out for drawing. Times are the inputs', microseconds.
#[derive(Clone, Debug, Default)]
pub struct Traces {
    /// Altitude of the reference, captive flight.
    pub altitude: EstimateTrace,
    /// Biases, captive flight, in the order of `kf_core::sensor::Sensor`.
    pub biases: [EstimateTrace; SENSORS],
    /// Innovation of the reference, captive flight, metres.
    pub reference_residual_m: Envelope,
    /// Calibrated residuals of the sensors, captive flight, metres.
    pub captive_error_m: [Envelope; SENSORS],
    /// Errors of the sensors (eq. 16), free flight, metres.
    pub free_error_m: [Envelope; SENSORS],
    /// Their moving averages, metres.
    pub moving_average_m: [Envelope; SENSORS],
}

impl Traces {
    /// Takes one tick.
    #[inline]
    pub(super) fn take(&mut self, output: &TickOutput) {
        let time_us = output.time_us;
        match output.phase {
            Phase::Settling => {}
            Phase::Calibrating => {
                self.altitude.value_m.push(time_us, output.altitude_m);
                self.altitude.sigma_m.push(time_us, output.altitude_variance_m2.sqrt());
                if let Some(innovation_m) = output.gps_innovation_m {
                    self.reference_residual_m.push(time_us, innovation_m);
                }
                for (index, sensor) in output.sensors.iter().enumerate() {
                    let Some(error_m) = sensor.error_m else { continue };
                    self.captive_error_m[index].push(time_us, error_m);
                    self.biases[index].value_m.push(time_us, sensor.bias_m);
                    self.biases[index].sigma_m.push(time_us, sensor.bias_variance_m2.sqrt());
                }
            }
            Phase::FreeFlight => {
                for (index, sensor) in output.sensors.iter().enumerate() {
                    if let Some(error_m) = sensor.error_m {
                        self.free_error_m[index].push(time_us, error_m);
                    }
                    if let Some(average_m) = sensor.moving_average_m {
                        self.moving_average_m[index].push(time_us, average_m);
                    }
                }
            }
        }
    }
}
