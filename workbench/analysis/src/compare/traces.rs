//! Data of a flight's charts: the paper's figures, and measured against modelled values.

use kf_core::input::TickInput;
use kf_core::output::{Phase, TickOutput};
use kf_core::sensor::{SENSORS, Sensor};
use replay::reading_m;

use super::envelope::{Envelope, FIGURE_SLOTS};

/// An estimate and its standard deviation by the filter.
#[derive(Clone, Debug)]
pub struct EstimateTrace {
    /// The estimate, metres.
    pub value_m: Envelope,
    /// Its standard deviation, metres.
    pub sigma_m: Envelope,
}

/// A sensor's readings against the model's prediction of them, over captive and free flight.
#[derive(Clone, Debug)]
pub struct ModelTrace {
    /// The reading as an altitude, metres; only at ticks with an error.
    pub measured_m: Envelope,
    /// The model's prediction of it, metres.
    pub modelled_m: Envelope,
    /// Measured less modelled, metres.
    pub error_m: Envelope,
}

/// Series of one flight, thinned out for drawing. Times are the inputs', microseconds.
#[derive(Clone, Debug)]
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
    /// Readings and the model's predictions of them.
    pub against_model: [ModelTrace; SENSORS],
}

impl Traces {
    /// Empty traces. Each series has at most that many slots; the estimates, which are smooth, at most
    /// [`FIGURE_SLOTS`].
    #[must_use]
    pub fn new(slots: usize) -> Self {
        let series = || Envelope::new(slots);
        let estimate = || EstimateTrace {
            value_m: Envelope::new(slots.min(FIGURE_SLOTS)),
            sigma_m: Envelope::new(slots.min(FIGURE_SLOTS)),
        };
        let by_sensor = || Sensor::ALL.map(|_| series());
        Self {
            altitude: estimate(),
            biases: Sensor::ALL.map(|_| estimate()),
            reference_residual_m: series(),
            captive_error_m: by_sensor(),
            free_error_m: by_sensor(),
            moving_average_m: by_sensor(),
            against_model: Sensor::ALL.map(|_| ModelTrace {
                measured_m: series(),
                modelled_m: series(),
                error_m: series(),
            }),
        }
    }

    /// Takes one tick.
    #[inline]
    pub(super) fn take(&mut self, input: &TickInput, output: &TickOutput) {
        if output.phase != Phase::Settling {
            self.take_against_model(input, output);
        }
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

    fn take_against_model(&mut self, input: &TickInput, output: &TickOutput) {
        for (sensor, tick) in Sensor::ALL.into_iter().zip(&output.sensors) {
            let Some(error_m) = tick.error_m else { continue };
            let trace = &mut self.against_model[sensor.index()];
            trace.error_m.push(output.time_us, error_m);
            if let Some(measured_m) = reading_m(sensor, input) {
                trace.measured_m.push(output.time_us, measured_m);
                trace.modelled_m.push(output.time_us, measured_m - error_m);
            }
        }
    }
}
