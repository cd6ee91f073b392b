//! The truth about a simulated flight, used only to judge results: no other command reads it.

use std::collections::BTreeMap;

use serde::Serialize;

use super::motion::TruthSample;
use super::record::Effects;
use super::scenario::{Effect, Scenario};

/// The truth about one sensor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SensorTruth {
    /// The sensor's own bias, m.
    pub bias_m: f64,
    /// Result of a perfect calibration against the reference, m: the bias plus the captive mean, after
    /// settling, of all other systematic differences between the sensor and the reference (effects, the
    /// receiver's bias and cold start, a non-standard day's pressure altitude).
    pub captive_offset_m: f64,
}

/// The truth about a simulated flight.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Truth {
    /// The scenario's name.
    pub scenario: String,
    /// The seed.
    pub seed: u64,
    /// Rows of the flight.
    pub rows: usize,
    /// Time of launch, s; missing if the UAV was never launched.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub launch_s: Option<f64>,
    /// The sensors by name.
    pub sensors: BTreeMap<&'static str, SensorTruth>,
    /// The injected effects.
    #[serde(rename = "effect")]
    pub effects: Vec<Effect>,
    /// The true motion, one sample a row; in memory only.
    #[serde(skip)]
    pub trajectory: Vec<TruthSample>,
}

impl Truth {
    /// The truth file's text.
    ///
    /// # Errors
    /// When a value cannot be written in TOML (a seed beyond its 64-bit signed integers).
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        Ok(format!(
            "# Truth about a simulated flight. No command of pylon reads this file.\n{}",
            toml::to_string(self)?
        ))
    }
}

pub(super) fn truth(
    scenario: &Scenario,
    trajectory: Vec<TruthSample>,
    effects: &Effects,
    seed: u64,
) -> Truth {
    let sensors = &scenario.sensors;
    let cold = |time_s: f64| {
        sensors.gps.cold_start.map_or(0.0, |cold_start| {
            cold_start.altitude_error_m * libm::exp(-time_s / cold_start.time_constant_s)
        })
    };
    let calibrating = |sample: &&TruthSample| sample.captive && sample.time_s >= scenario.captive.settling_s;
    let count = trajectory.iter().filter(calibrating).count();
    let mean = |error: &dyn Fn(usize, &TruthSample) -> f64| {
        let errors = trajectory.iter().enumerate().filter(|(_, sample)| calibrating(sample));
        let sum: f64 = errors.map(|(row, sample)| error(row, sample)).sum();
        if count > 0 { sum / count as f64 } else { 0.0 }
    };
    let at = |effects: &[f64], row: usize| effects.get(row).copied().unwrap_or(0.0);
    let reference = sensors.gps.bias_m + mean(&|row, sample| at(&effects.gps, row) + cold(sample.time_s));
    let baro = mean(&|row, sample| at(&effects.baro, row) + sample.pressure_altitude_m - sample.altitude_m);
    let imu_slave = mean(&|row, _| at(&effects.imu_slave, row));
    let entry = |bias_m: f64, systematic_m: f64| SensorTruth {
        bias_m,
        captive_offset_m: bias_m + systematic_m - reference,
    };
    Truth {
        scenario: scenario.name.clone(),
        seed,
        rows: trajectory.len(),
        launch_s: scenario.launch_s(),
        sensors: BTreeMap::from([
            ("baro", entry(sensors.baro.bias_m, baro)),
            ("imu_master", entry(sensors.imu_master.bias_m, 0.0)),
            ("imu_slave", entry(sensors.imu_slave.bias_m, imu_slave)),
        ]),
        effects: scenario.effect.clone(),
        trajectory,
    }
}
