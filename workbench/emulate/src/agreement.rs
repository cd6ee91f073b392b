//! How far a calibration on chips is from the one with ideal sensors, and how far it may be.
//!
//! Except for its prior, a latched bias is a weighted mean of readings less the reference. Chips change that
//! mean in three ways, and the bound is their sum:
//!
//! - quantum: the MS5611's resolution ([`BARO_QUANTUM_PA`]) and `f32`'s in the standard atmosphere; the
//!   umbilical carries `f32`.
//! - delay: the altitude gained meanwhile. A conversion is read two ticks after it began, on a value that the
//!   flight gave up to one of its own intervals before; a frame on a serial line arrives at the next tick; a
//!   row waits for its tick. The climb rate is that of the whole range of altitude over the calibration. And
//!   a source that is late by some readings uses other readings at both ends of the calibration.
//! - resampling: a barometer chip samples when it is ready, the flight when it was recorded, so at worst the
//!   two means share no white noise. White noise is what differs from one reading to the next (von Neumann's
//!   estimate: half the mean square of successive differences). Its effect depends on how the model weighs
//!   readings (the first of a correlated sensor counts for many, a bias that wanders forgets the old), and
//!   reaches the other sensors through the common altitude, so it is measured: the calibration is repeated on
//!   the same rows, [`TRIALS`] times, with as much fresh noise added to the barometer.

use kf_core::atmosphere::static_pressure_pa;
use kf_core::input::{BaroReading, TickInput};
use kf_core::latch::{LatchRecord, SensorLatch};
use kf_core::output::Phase;
use kf_core::sensor::{SENSORS, Sensor};
use model::Model;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

use super::error::FlyError;
use super::grid::TICK_US;
use replay::{mission, reading_m};

/// Largest error of the MS5611's result due to its resolution, pascals: half a count of D1 (0.010), half a
/// count of D2 through OFF and SENS (0.014), and the rounding of the pressure to `f32` on the way in and out
/// (2/128), for the coefficients of the datasheet's example.
pub const BARO_QUANTUM_PA: f64 = 0.04;
/// Rounding of an altitude in `kf_core::atmosphere`, metres: `f32` keeps 44,331 m to 4 mm, there and back.
const ATMOSPHERE_ROUNDING_M: f64 = 0.01;
/// R / g times the warmest temperature of the standard atmosphere, m: the largest scale height.
const SCALE_HEIGHT_M: f64 = 8_435.0;
/// Number of calibrations with fresh noise.
const TRIALS: u64 = 16;
/// Number of standard deviations allowed for the resampling. The deviation is estimated from [`TRIALS`]:
/// Student's t of 16 degrees of freedom exceeds this in 1 of 10,000 flights.
const SIGMAS: f64 = 5.0;

/// One sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorAgreement {
    /// The sensor.
    pub sensor: Sensor,
    /// Bias latched with ideal sensors, metres.
    pub ideal_bias_m: f32,
    /// Bias latched on chips, metres.
    pub chips_bias_m: f32,
    /// Largest difference explained by the chips' resolution and delays, metres.
    pub bound_m: f64,
}

impl SensorAgreement {
    /// The bias on chips less the ideal one, metres.
    #[must_use]
    pub fn difference_m(&self) -> f64 {
        f64::from(self.chips_bias_m) - f64::from(self.ideal_bias_m)
    }

    /// Whether the chips explain the difference.
    #[must_use]
    pub fn is_within_bound(&self) -> bool {
        self.difference_m().abs() <= self.bound_m
    }
}

/// Every sensor that was calibrated with ideal sensors.
#[derive(Clone, Debug, PartialEq)]
pub struct Agreement {
    /// In the order of [`Sensor`].
    pub sensors: Vec<SensorAgreement>,
}

/// What the calibration with ideal sensors measured.
struct Ideal {
    latch: LatchRecord,
    lowest_m: f32,
    highest_m: f32,
    /// Variance of the white part of the barometer's noise, square metres.
    white_m2: f64,
}

/// Flies the same rows with ideal sensors, and compares; `None` if they do not latch.
pub(super) fn of(
    rows: impl Iterator<Item = TickInput> + Clone,
    model: &Model,
    chips: &LatchRecord,
) -> Result<Option<Agreement>, FlyError> {
    let Some(ideal) = fly(rows.clone(), model)? else { return Ok(None) };
    let resampled_m2 = resampled_m2(&rows, model, &ideal)?;
    let pairs = Sensor::ALL.into_iter().zip(ideal.latch.sensors.iter().zip(&chips.sensors));
    let sensors = pairs
        .filter(|(_, (of_ideal, _))| of_ideal.readings > 1)
        .map(|(sensor, (of_ideal, of_chips))| SensorAgreement {
            sensor,
            ideal_bias_m: of_ideal.bias_m,
            chips_bias_m: of_chips.bias_m,
            bound_m: bound_m(sensor, of_ideal, of_chips, &ideal, resampled_m2[sensor.index()]),
        })
        .collect();
    Ok(Some(Agreement { sensors }))
}

fn fly(rows: impl Iterator<Item = TickInput>, model: &Model) -> Result<Option<Ideal>, FlyError> {
    let mut mission = mission(model)?;
    let (mut lowest_m, mut highest_m) = (f32::INFINITY, f32::NEG_INFINITY);
    let mut differences = Differences::default();
    for row in rows {
        let output = mission.tick(&row);
        match (output.phase, mission.latch()) {
            (Phase::Calibrating, _) => {
                differences.take(reading_m(Sensor::Baro, &row));
                if row.gps.is_some() && output.gps_rejection.is_none() {
                    lowest_m = lowest_m.min(output.altitude_m);
                    highest_m = highest_m.max(output.altitude_m);
                }
            }
            (_, Some(latch)) => {
                let white_m2 = differences.white_m2();
                return Ok(Some(Ideal { latch: latch.clone(), lowest_m, highest_m, white_m2 }));
            }
            _ => {}
        }
    }
    Ok(None)
}

/// Mean square of the change in each bias due to fresh white noise on the barometer, for two calibrations
/// that share none of it.
fn resampled_m2(
    rows: &(impl Iterator<Item = TickInput> + Clone),
    model: &Model,
    ideal: &Ideal,
) -> Result<[f64; SENSORS], FlyError> {
    let noise = Normal::new(0.0, ideal.white_m2.sqrt()).map_err(FlyError::BarometerNoise)?;
    let mut sums_m2 = [0.0; SENSORS];
    for trial in 0..TRIALS {
        let mut generator = ChaCha8Rng::seed_from_u64(trial);
        let noisy = rows.clone().map(|row| with_noise(row, noise.sample(&mut generator)));
        let Some(other) = fly(noisy, model)? else { continue };
        for (sum_m2, (other, ideal)) in
            sums_m2.iter_mut().zip(other.latch.sensors.iter().zip(&ideal.latch.sensors))
        {
            *sum_m2 += (f64::from(other.bias_m) - f64::from(ideal.bias_m)).powi(2);
        }
    }
    // Each of the two has noise of its own.
    Ok(sums_m2.map(|sum_m2| 2.0 * sum_m2 / TRIALS as f64))
}

/// The row with a barometer that reads this much higher, metres.
fn with_noise(mut row: TickInput, noise_m: f64) -> TickInput {
    row.baro = row.baro.map(|reading| match reading {
        BaroReading::PressurePa(pressure_pa) => {
            BaroReading::PressurePa((f64::from(pressure_pa) * (-noise_m / SCALE_HEIGHT_M).exp()) as f32)
        }
        BaroReading::AltitudeM(altitude_m) => {
            BaroReading::AltitudeM((f64::from(altitude_m) + noise_m) as f32)
        }
    });
    row
}

/// Squares of the differences of successive readings.
#[derive(Clone, Copy, Debug, Default)]
struct Differences {
    last_m: Option<f32>,
    sum_m2: f64,
    count: u32,
}

impl Differences {
    fn take(&mut self, reading_m: Option<f32>) {
        let Some(reading_m) = reading_m.filter(|reading_m| reading_m.is_finite()) else { return };
        if let Some(last_m) = self.last_m.replace(reading_m) {
            self.sum_m2 += (f64::from(reading_m) - f64::from(last_m)).powi(2);
            self.count += 1;
        }
    }

    fn white_m2(&self) -> f64 {
        self.sum_m2 / (2.0 * f64::from(self.count.max(1)))
    }
}

fn bound_m(
    sensor: Sensor,
    of_ideal: &SensorLatch,
    of_chips: &SensorLatch,
    ideal: &Ideal,
    resampled_m2: f64,
) -> f64 {
    if of_chips.readings < 2 {
        return f64::INFINITY;
    }
    let tick_s = TICK_US as f64 * 1e-6;
    let duration_s = f64::from(ideal.latch.duration_s).max(tick_s);
    let climb_rate_mps = f64::from(ideal.highest_m - ideal.lowest_m).max(0.0) / duration_s;
    // The flight's rows wait for their tick. So do the reference's, whose frame takes one more.
    let reference_lag_s = 2.0 * tick_s;
    let (quantum_m, lag_s) = match sensor {
        Sensor::Baro => {
            let pressure_pa = static_pressure_pa(ideal.highest_m).map_or(f64::NAN, f64::from);
            let quantum_m = BARO_QUANTUM_PA * SCALE_HEIGHT_M / pressure_pa + ATMOSPHERE_ROUNDING_M;
            (quantum_m, 3.0 * tick_s + duration_s / f64::from(of_ideal.readings))
        }
        Sensor::ImuMaster => (0.0, 2.0 * tick_s),
        Sensor::ImuSlave => (0.0, tick_s),
    };
    let late_s = lag_s + reference_lag_s;
    let readings = f64::from(of_ideal.readings);
    let exchanged = 2.0 * (late_s * readings / duration_s).ceil();
    let ends_m2 = f64::from(of_ideal.residual_variance_m2) * exchanged / (readings * readings);
    quantum_m + climb_rate_mps * late_s + SIGMAS * (resampled_m2 + ends_m2).sqrt()
}
