//! A calibration as the outputs say it.

use crate::config::MAX_ESTIMATED_EFFECTS;
use crate::estimator::Estimator;
use crate::latch::{LatchRecord, collected};
use crate::output::CoefficientOutput;
use crate::sensor::{SENSORS, Sensor};

/// The states and their variances.
pub(super) struct Calibrated {
    pub altitude_m: f32,
    pub altitude_variance_m2: f32,
    /// Bias (m) and its variance (m^2), in the order of [`Sensor`].
    pub biases: [[f32; 2]; SENSORS],
    pub coefficients: heapless::Vec<CoefficientOutput, MAX_ESTIMATED_EFFECTS>,
}

impl Calibrated {
    #[inline]
    pub(super) fn of_estimator<const HEAD: usize, const TAIL: usize, const E: usize>(
        estimator: &Estimator<HEAD, TAIL, E>,
    ) -> Self {
        let bias = |sensor| [estimator.bias_m(sensor), estimator.bias_variance_m2(sensor)];
        let [master, slave, baro] = Sensor::ALL;
        let coefficients = estimator.coefficients().into_iter().enumerate();
        Self {
            altitude_m: estimator.altitude_m(),
            altitude_variance_m2: estimator.altitude_variance_m2(),
            biases: [bias(master), bias(slave), bias(baro)],
            coefficients: collected(coefficients.map(|(effect, coefficient)| CoefficientOutput {
                coefficient,
                variance: estimator.coefficient_variance(effect),
            })),
        }
    }

    /// The same numbers, to the bit, as the estimator's when it was latched.
    #[inline]
    pub(super) fn of_latch(latch: &LatchRecord) -> Self {
        let [master, slave, baro] = &latch.sensors;
        let effects = latch.state.len().saturating_sub(1 + SENSORS);
        Self {
            altitude_m: latch.state.first().copied().unwrap_or(0.0),
            altitude_variance_m2: latch.variance(0),
            biases: [master, slave, baro].map(|sensor| [sensor.bias_m, sensor.bias_variance_m2]),
            coefficients: collected((0..effects).map(|effect| CoefficientOutput {
                coefficient: latch.coefficient(effect),
                variance: latch.variance(1 + SENSORS + effect),
            })),
        }
    }
}
