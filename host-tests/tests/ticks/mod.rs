//! A made-up flight, tick by tick: 20 s captive at 2000 m, launch, 10 s of a dive. For tests that do not
//! depend on realistic numbers.
// Each test file uses only part of this.
#![allow(dead_code, clippy::panic)]

use kf_core::input::{BaroReading, GpsFix, ImuSample, LaunchDoubt, Signals, TickInput};
use model::Model;
use pylon::fly::FlyError;

/// Length of a tick, microseconds.
pub const TICK_US: u64 = 5_000;
/// The first tick of free flight.
pub const LAUNCH: usize = 4_000;
/// Number of ticks.
pub const TICKS: usize = 6_000;

/// The default model, calibrating from the first tick on, so that a flight can be short.
pub fn prompt(model: Model) -> Model {
    Model { settling_s: 2.0, ..model }
}

/// White noise of unit variance: uniform, from Numerical Recipes' 32-bit generator.
struct Noise(u32);

impl Noise {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        ((self.0 >> 8) as f32 / 16_777_216.0 - 0.5) * 3.464_101_6
    }
}

/// The flight.
pub fn flight() -> Vec<TickInput> {
    let mut noise = Noise(7);
    (0..TICKS)
        .map(|k| {
            let free_s = k.saturating_sub(LAUNCH) as f32 * 0.005;
            let altitude_m = 2_000.0 - 30.0 * free_s;
            let airspeed_mps = 60.0 + 4.0 * free_s;
            let swing = ((k % 2_000) as f32 * 1e-3 - 1.0).abs();
            TickInput {
                time_us: 1_000_000 + k as u64 * TICK_US,
                launch: k >= LAUNCH,
                // A wire that bounces under the pylon.
                launch_doubt: if (2_500..2_503).contains(&k) {
                    LaunchDoubt::Suspected
                } else {
                    LaunchDoubt::None
                },
                gps: (k % 40 == 0).then(|| GpsFix {
                    altitude_m: altitude_m + 2.0 * noise.next(),
                    velocity_north_mps: Some(airspeed_mps),
                    velocity_east_mps: Some(0.1 * noise.next()),
                    velocity_down_mps: Some(if free_s > 0.0 { 30.0 } else { 0.0 } + 0.1 * noise.next()),
                    vertical_accuracy_m: Some(2.5),
                    satellites: Some(11),
                    fix_time_us: None,
                }),
                baro: (k % 4 == 0).then(|| {
                    // 11.1 m/hPa near 2000 m, and a static port that is affected by the dynamic pressure.
                    let error_m = 0.04 * airspeed_mps * airspeed_mps / 19.6;
                    BaroReading::PressurePa(
                        79_495.0 - (altitude_m - 2_000.0 + error_m) * 9.87 + 3.0 * noise.next(),
                    )
                }),
                imu_master_altitude_m: (k % 4 == 1 && k < LAUNCH).then(|| altitude_m + 12.0 + noise.next()),
                imu_slave_altitude_m: (k % 4 == 2)
                    .then(|| altitude_m - 72.9 + free_s * free_s + noise.next()),
                imu: Some(ImuSample {
                    accel_mps2: [0.0, 0.0, -9.8 + 0.1 * noise.next()],
                    gyro_radps: [0.0; 3],
                }),
                signals: Signals {
                    true_airspeed_mps: (k % 4 == 0).then_some(airspeed_mps),
                    angle_of_attack_rad: (k % 4 == 0).then_some(0.05),
                    sideslip_rad: (k % 4 == 0).then_some(0.02),
                    throttle: (k % 4 == 0).then_some(0.6),
                    baro_temperature_c: (k % 100 == 0).then_some(25.0),
                    // Not constant: effects of the attitude must change. Slowly, and back and forth.
                    attitude_rad: Some([0.3 - swing, 0.5 * swing - 0.1, 1.0]),
                    ..Signals::default()
                },
                ..TickInput::default()
            }
        })
        .collect()
}

/// The result, or a test failure with the error's own words, which say what to install.
pub fn must<T>(result: Result<T, FlyError>) -> T {
    result.unwrap_or_else(|error| panic!("{error}"))
}
