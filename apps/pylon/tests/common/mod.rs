//! A generated flight whose every error is known; its header states that it is not a measured one.
#![allow(dead_code, clippy::unwrap_used)]

pub mod json;
pub mod openocd;
pub mod program;
pub mod python;

use std::path::{Path, PathBuf};

use pylon::flight::{self, Channel, Column, Flight};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};

/// Rows a second.
pub const ROWS_PER_S: f64 = 50.0;
/// Rows from one fix to the next.
pub const ROWS_PER_FIX: usize = 10;

/// The errors and motion of a generated flight.
pub struct Recipe {
    pub captive_s: f64,
    pub free_s: f64,
    pub launch_column: bool,
    pub seed: u64,
    /// Biases of imu_master, imu_slave, baro, metres.
    pub biases_m: [f64; 3],
    /// White noise of each, 1 sigma, metres.
    pub white_m: [f64; 3],
    /// First-order correlated error of the baro: 1 sigma in metres, correlation time in seconds.
    pub baro_correlated: (f64, f64),
    /// White noise of a fix, 1 sigma, metres.
    pub gps_m: f64,
    /// Error of the baro in addition to noise and bias, metres, by time after launch and climb rate.
    pub baro_error: fn(f64, f64) -> f64,
    /// The same for imu_slave.
    pub slave_error: fn(f64) -> f64,
    /// Climb rate, m/s, by time after launch.
    pub climb_mps: fn(f64) -> f64,
}

impl Default for Recipe {
    /// Level flight with healthy sensors.
    fn default() -> Self {
        Self {
            captive_s: 80.0,
            free_s: 60.0,
            launch_column: true,
            seed: 1,
            biases_m: [4.0, -30.0, 20.0],
            white_m: [0.5, 1.0, 0.6],
            baro_correlated: (0.0, 1.0),
            gps_m: 0.3,
            baro_error: |_, _| 0.0,
            slave_error: |_| 0.0,
            climb_mps: |_| 0.0,
        }
    }
}

/// A dive of 30 m/s from 10 s to 25 s after launch.
pub fn dive_mps(after_s: f64) -> f64 {
    if (10.0..25.0).contains(&after_s) { -30.0 } else { 0.0 }
}

impl Recipe {
    pub fn make(&self) -> Flight {
        let mut generator = ChaCha8Rng::seed_from_u64(self.seed);
        let mut noise = move || -> f64 { StandardNormal.sample(&mut generator) };
        let rows = ((self.captive_s + self.free_s) * ROWS_PER_S) as usize;
        let mut columns: Vec<(Channel, Column)> = [
            Channel::Launch,
            Channel::GpsAltM,
            Channel::GpsVnMps,
            Channel::GpsVeMps,
            Channel::GpsVdMps,
            Channel::BaroAltM,
            Channel::ImuMasterAltM,
            Channel::ImuSlaveAltM,
            Channel::TasMps,
        ]
        .map(|channel| (channel, Column::default()))
        .into();
        let mut time_s = Vec::new();
        let mut altitude_m = 2_000.0;
        let phi = (-1.0 / ROWS_PER_S / self.baro_correlated.1).exp();
        let mut correlated_m = self.baro_correlated.0 * noise();
        for row in 0..rows {
            let now_s = row as f64 / ROWS_PER_S;
            let after_s = now_s - self.captive_s;
            let is_free = after_s >= 0.0;
            let climb_mps = if is_free { (self.climb_mps)(after_s) } else { 0.0 };
            altitude_m += climb_mps / ROWS_PER_S;
            correlated_m = phi * correlated_m + self.baro_correlated.0 * (1.0 - phi * phi).sqrt() * noise();
            let [master, slave, baro] =
                [0, 1, 2].map(|i| altitude_m + self.biases_m[i] + self.white_m[i] * noise());
            let has_fix = row % ROWS_PER_FIX == 0;
            let fix_m = altitude_m + self.gps_m * noise();
            let baro_error_m = if is_free { (self.baro_error)(after_s, climb_mps) } else { 0.0 };
            let slave_error_m = if is_free { (self.slave_error)(after_s) } else { 0.0 };
            let cells = [
                Some(f64::from(u8::from(is_free))),
                has_fix.then_some(fix_m),
                has_fix.then_some(60.0),
                has_fix.then_some(0.0),
                has_fix.then_some(-climb_mps),
                Some(baro + correlated_m + baro_error_m),
                (!is_free).then_some(master),
                Some(slave + slave_error_m),
                has_fix.then_some(60.0),
            ];
            for ((_, column), cell) in columns.iter_mut().zip(cells) {
                column.push(cell.map(|value| value as f32));
            }
            time_s.push(now_s);
        }
        if !self.launch_column {
            columns.remove(0);
        }
        let mut made = Flight { time_s, channels: columns, ..Flight::default() };
        made.header.vehicle = "made".to_owned();
        made.header.source = "made for a test, not measured".to_owned();
        made
    }

    /// Writes the flight into a directory.
    pub fn write(&self, directory: &Path) -> PathBuf {
        let file = directory.join("made.csv");
        flight::write(&file, &self.make()).unwrap();
        file
    }
}

/// A model file for generated flights that describes their sensors.
pub const MODEL: &str = "\
[gps]
sigma_m = 0.3
correlation_time_s = 0
[sensor.imu_master]
sigma_m = 0.5
correlation_time_s = 0
wander_m_per_sqrt_s = 0
[sensor.imu_slave]
sigma_m = 1
correlation_time_s = 0
wander_m_per_sqrt_s = 0
[sensor.baro]
sigma_m = 0.6
correlation_time_s = 0
wander_m_per_sqrt_s = 0
[monitor]
multiplier = 4
window_s = 2
";
