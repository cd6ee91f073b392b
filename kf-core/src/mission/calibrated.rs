//! A calibration in the form of the outputs.

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
        let (altitude_variance_m2, [of_master, of_slave, of_baro], of_coefficients) = estimator.variances();
        let [master, slave, baro] = Sensor::ALL.map(|sensor| estimator.bias_m(sensor));
        let coefficients = estimator.coefficients().into_iter().zip(of_coefficients);
        Self {
            altitude_m: estimator.altitude_m(),
            altitude_variance_m2,
            biases: [[master, of_master], [slave, of_slave], [baro, of_baro]],
            coefficients: collected(
                coefficients.map(|(coefficient, variance)| CoefficientOutput { coefficient, variance }),
            ),
        }
    }

    /// The same numbers, to the bit, as the estimator had when it was latched.
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
