//! A flight through the estimator once more, for its diagrams.

use kf_core::atmosphere::pressure_altitude_m;
use kf_core::input::{BaroReading, TickInput};
use kf_core::output::{Phase, TickOutput};
use kf_core::sensor::{SENSORS, Sensor};

use super::table::Table;
use crate::compare::{Comparison, SensorComparison};
use crate::replay::{Replay, ReplayError};

/// Slots of curves that change slowly.
const SMOOTH_SLOTS: u64 = 1_200;

/// Series of one sensor over captive and free flight.
pub(super) const MEASURED: usize = 0;
/// See [`MEASURED`].
pub(super) const MODELLED: usize = 1;
/// See [`MEASURED`].
pub(super) const ERROR: usize = 2;
/// Series of an estimate.
pub(super) const VALUE: usize = 0;
/// See [`VALUE`].
pub(super) const SIGMA: usize = 1;
/// Series of a sensor in free flight, beside [`VALUE`], its error.
pub(super) const AVERAGE: usize = 1;

/// What the diagrams of a flight are drawn from. Metres, and times by the flight's own clock.
#[derive(Clone, Debug)]
pub(super) struct Recording {
    /// When the UAV was launched, microseconds.
    pub(super) launch_us: Option<u64>,
    /// Altitude of the reference in captive flight: its estimate and sigma.
    pub(super) altitude: Table,
    /// Biases in captive flight: estimate and sigma.
    pub(super) biases: [Table; SENSORS],
    /// Innovation of the reference in captive flight.
    pub(super) reference_residual: Table,
    /// Calibrated residuals in captive flight.
    pub(super) captive_error: [Table; SENSORS],
    /// Errors and their moving averages in free flight.
    pub(super) free_error: [Table; SENSORS],
    /// Reading, the model's prediction of it, and the difference, over both.
    pub(super) whole: [Table; SENSORS],
}

impl Recording {
    /// Flies the replay; the comparison says how many readings there are and when launch was.
    ///
    /// # Errors
    /// As [`Replay::run`].
    pub(super) fn take(replay: &Replay<'_>, comparison: &Comparison) -> Result<Self, ReplayError> {
        let mut recording = Self::empty(replay, comparison);
        replay.run(&mut |input, output| recording.tick(input, output))?;
        Ok(recording)
    }

    fn empty(replay: &Replay<'_>, comparison: &Comparison) -> Self {
        let micros = |seconds: f64| (seconds * 1e6).round() as u64;
        let times = || replay.times_s().iter().copied();
        let first_s = replay.source().window().map_or_else(
            || times().fold(f64::INFINITY, f64::min) + f64::from(replay.model().settling_s),
            |window| window.start_s,
        );
        let end_us = micros(times().fold(0.0, f64::max));
        let start_us = micros(first_s.max(0.0)).min(end_us);
        let launch_us = comparison.launch_s.map(micros);
        let launched_us = launch_us.unwrap_or(end_us).max(start_us);
        let rows = replay.times_s().len() as u64;
        let readings = |sensor: Sensor, count: fn(&SensorComparison) -> u64| {
            comparison.sensors.get(sensor.name()).map_or(0, count)
        };
        Self {
            launch_us,
            altitude: Table::new(start_us, launched_us, rows.min(SMOOTH_SLOTS), 2),
            biases: Sensor::ALL.map(|_| Table::new(start_us, launched_us, rows.min(SMOOTH_SLOTS), 2)),
            reference_residual: Table::new(start_us, launched_us, comparison.reference.captive.readings, 1),
            captive_error: Sensor::ALL.map(|sensor| {
                Table::new(start_us, launched_us, readings(sensor, |found| found.captive.readings), 1)
            }),
            free_error: Sensor::ALL.map(|sensor| {
                Table::new(launched_us, end_us, readings(sensor, |found| found.free_flight.readings), 2)
            }),
            whole: Sensor::ALL.map(|sensor| {
                let all = readings(sensor, |found| found.captive.readings + found.free_flight.readings);
                Table::new(start_us, end_us, all, 3)
            }),
        }
    }

    fn tick(&mut self, input: &TickInput, output: &TickOutput) {
        if output.out_of_order || output.phase == Phase::Settling {
            return;
        }
        let time_us = output.time_us;
        let is_captive = output.phase == Phase::Calibrating;
        if is_captive {
            self.altitude.push(VALUE, time_us, output.altitude_m);
            self.altitude.push(SIGMA, time_us, output.altitude_variance_m2.sqrt());
            if let Some(innovation_m) = output.gps_innovation_m {
                self.reference_residual.push(VALUE, time_us, innovation_m);
            }
        }
        for (sensor, said) in Sensor::ALL.into_iter().zip(&output.sensors) {
            let index = sensor.index();
            if let (false, Some(average_m)) = (is_captive, said.moving_average_m) {
                self.free_error[index].push(AVERAGE, time_us, average_m);
            }
            let Some(error_m) = said.error_m else { continue };
            if is_captive {
                self.captive_error[index].push(VALUE, time_us, error_m);
                self.biases[index].push(VALUE, time_us, said.bias_m);
                self.biases[index].push(SIGMA, time_us, said.bias_variance_m2.sqrt());
            } else {
                self.free_error[index].push(VALUE, time_us, error_m);
            }
            let whole = &mut self.whole[index];
            whole.push(ERROR, time_us, error_m);
            if let Some(reading_m) = reading_m(sensor, input) {
                whole.push(MEASURED, time_us, reading_m);
                whole.push(MODELLED, time_us, reading_m - error_m);
            }
        }
    }
}

/// What a sensor read, as an altitude.
fn reading_m(sensor: Sensor, input: &TickInput) -> Option<f32> {
    match sensor {
        Sensor::ImuMaster => input.imu_master_altitude_m,
        Sensor::ImuSlave => input.imu_slave_altitude_m,
        Sensor::Baro => match input.baro? {
            BaroReading::PressurePa(pressure_pa) => pressure_altitude_m(pressure_pa),
            BaroReading::AltitudeM(altitude_m) => Some(altitude_m),
        },
    }
}
