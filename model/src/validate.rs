//! Valid values of a model.

use kf_core::config::{MAX_CONSTANT_EFFECTS, MAX_ESTIMATED_EFFECTS, SecondCorrection};
use kf_core::effect::formula_words;
use kf_core::sensor::Sensor;

use crate::{Model, ModelError};

const POSITIVE: &str = "a finite number above 0";
const NOT_NEGATIVE: &str = "a finite number from 0 on";
const FINITE: &str = "a finite number";
/// No flight lasts a day: a longer window would never be full, and the cost of evaluating its rule grows with
/// it.
const LONGEST_WINDOW_S: f32 = 86_400.0;

fn require(key: impl Into<String>, value: f32, good: bool, expected: &'static str) -> Result<(), ModelError> {
    if value.is_finite() && good {
        return Ok(());
    }
    Err(ModelError::Value { key: key.into(), found: value.to_string(), expected })
}

fn positive(key: impl Into<String>, value: f32) -> Result<(), ModelError> {
    require(key, value, value > 0.0, POSITIVE)
}

fn not_negative(key: impl Into<String>, value: f32) -> Result<(), ModelError> {
    require(key, value, value >= 0.0, NOT_NEGATIVE)
}

fn finite(key: impl Into<String>, value: f32) -> Result<(), ModelError> {
    require(key, value, true, FINITE)
}

impl Model {
    /// Checks every value; [`Model::parse`] and [`Model::mission_config`] already do so.
    ///
    /// # Errors
    /// The first value, in file order, that is invalid for its key.
    pub fn validate(&self) -> Result<(), ModelError> {
        not_negative("settling_s", self.settling_s)?;
        if let SecondCorrection::Kalman { wander_m_per_sqrt_s } = self.second_correction {
            positive("second_correction_wander_m_per_sqrt_s", wander_m_per_sqrt_s)?;
        }
        let latitude_deg = self.latitude_deg;
        let is_latitude = (-90.0..=90.0).contains(&latitude_deg);
        require("site.latitude_deg", latitude_deg, is_latitude, "a latitude from -90 to 90 degrees")?;
        self.validate_sensors()?;
        positive("monitor.multiplier", self.monitor.multiplier)?;
        let window_s = self.monitor.window_s;
        let is_window = window_s > 0.0 && window_s <= LONGEST_WINDOW_S;
        require("monitor.window_s", window_s, is_window, "seconds above 0, at most a day")?;
        not_negative("monitor.persistence_s", self.monitor.persistence_s)?;
        let quality = &self.quality;
        not_negative("quality.minimum_duration_s", quality.minimum_duration_s)?;
        for (key, value) in [
            ("quality.trimmed_altitude_m", quality.trimmed_altitude_m),
            ("quality.trimmed_airspeed_mps", quality.trimmed_airspeed_mps),
            ("quality.reference_drift_m", quality.reference_drift_m),
            ("quality.vertical_accuracy_m", quality.vertical_accuracy_m),
            ("quality.bias_drift_sigmas", quality.bias_drift_sigmas),
        ] {
            positive(key, value)?;
        }
        let share = quality.implausible_share;
        require("quality.implausible_share", share, (0.0..=1.0).contains(&share), "a share from 0 to 1")?;
        self.validate_effects()
    }

    fn validate_sensors(&self) -> Result<(), ModelError> {
        let reference = &self.reference;
        positive("gps.sigma_m", reference.sigma_m)?;
        not_negative("gps.correlation_time_s", reference.correlation_time_s)?;
        finite("gps.prior_altitude_m", reference.prior_altitude_m.unwrap_or(0.0))?;
        positive("gps.prior_sigma_m", reference.prior_sigma_m)?;
        if let Some(climb_rate) = reference.climb_rate {
            positive("gps.climb_rate_sigma_mps", climb_rate.sigma_mps)?;
            positive("gps.climb_rate_correlation_time_s", climb_rate.correlation_time_s)?;
        }
        positive("gps.lost_after_s", reference.lost_after_s)?;
        for (sensor, config) in Sensor::ALL.into_iter().zip(&self.sensors) {
            let key = |name| format!("sensor.{}.{name}", sensor.name());
            positive(key("sigma_m"), config.sigma_m)?;
            not_negative(key("correlation_time_s"), config.correlation_time_s)?;
            finite(key("prior_bias_m"), config.prior_bias_m)?;
            positive(key("prior_sigma_m"), config.prior_sigma_m)?;
            not_negative(key("wander_m_per_sqrt_s"), config.wander_m_per_sqrt_s)?;
        }
        Ok(())
    }

    fn validate_effects(&self) -> Result<(), ModelError> {
        let (estimated, constant) = (self.estimated_effects().count(), self.constant_effects().count());
        if estimated > MAX_ESTIMATED_EFFECTS {
            return Err(ModelError::TooMany {
                kind: "estimated",
                found: estimated,
                most: MAX_ESTIMATED_EFFECTS,
            });
        }
        if constant > MAX_CONSTANT_EFFECTS {
            return Err(ModelError::TooMany {
                kind: "constant",
                found: constant,
                most: MAX_CONSTANT_EFFECTS,
            });
        }
        let formulas = self.effects.iter().filter_map(|effect| effect.term.id().formula());
        let found = formulas.map(|parts| parts.program.state_words()).sum();
        let most = formula_words(estimated);
        if found > most {
            return Err(ModelError::FormulaWords { found, most, estimated });
        }
        for (index, effect) in self.effects.iter().enumerate() {
            let id = effect.term.id().name();
            let key = |name| format!("{name} of effect {id}");
            finite(key("coefficient"), effect.term.coefficient)?;
            if effect.estimate {
                positive(key("sigma"), effect.term.sigma)?;
            } else {
                not_negative(key("sigma"), effect.term.sigma)?;
            }
            if effect.term.id().has_time_constant() {
                positive(key("time_constant_s"), effect.term.regressor.time_constant_s)?;
            }
            if let Some([least, largest]) = effect.term.envelope_m {
                finite(key("envelope_m's lower end"), least)?;
                finite(key("envelope_m's upper end"), largest)?;
                let expected = "a finite number from envelope_m's lower end on";
                require(key("envelope_m's upper end"), largest, least <= largest, expected)?;
            }
            if self.effects.iter().take(index).any(|earlier| earlier.term.id() == effect.term.id()) {
                return Err(ModelError::Twice { id });
            }
        }
        Ok(())
    }
}
