//! The level that a sensor was on in the settling time: checks whether the calibration's bias is on the same
//! one.
//!
//! A sensor that steps between settling and calibration leaves a bias that is consistent with every later
//! reading, and nothing shows which of the two levels is right. The step is therefore reported as
//! inconsistent readings.

use crate::config::{MissionConfig, SensorConfig};

use super::gate::GATE_SIGMAS;
use super::square;

/// The first residual of a sensor in the settling time that the next one confirmed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SettlingLevel {
    /// Metres; NaN before the first.
    first_m: f32,
    is_confirmed: bool,
}

impl SettlingLevel {
    pub(super) const NEW: Self = Self { first_m: f32::NAN, is_confirmed: false };

    /// Notes a residual, metres, against a reference that is reported to be good.
    pub(super) fn note<const E: usize>(
        &mut self,
        config: &MissionConfig<E>,
        sensor: &SensorConfig,
        residual_m: f32,
    ) {
        if self.is_confirmed {
            return;
        }
        let limit_m2 = square(GATE_SIGMAS) * variance_m2(config, sensor);
        self.is_confirmed = square(residual_m - self.first_m) <= limit_m2;
        if !self.is_confirmed {
            self.first_m = residual_m;
        }
    }

    /// Whether a bias, metres, estimated over that duration, is still on that level. An unconfirmed level
    /// contradicts nothing.
    pub(super) fn is_level_of<const E: usize>(
        &self,
        config: &MissionConfig<E>,
        sensor: &SensorConfig,
        bias_m: f32,
        duration_s: f32,
    ) -> bool {
        let variance_m2 = variance_m2(config, sensor) + square(sensor.wander_m_per_sqrt_s) * duration_s;
        !self.is_confirmed || square(bias_m - self.first_m) <= square(GATE_SIGMAS) * variance_m2
    }
}

/// Variance of the difference of two residuals, each with an error of the sensor and one of the reference,
/// square metres.
fn variance_m2<const E: usize>(config: &MissionConfig<E>, sensor: &SensorConfig) -> f32 {
    2.0 * (square(sensor.sigma_m) + square(config.reference.sigma_m))
}
