//! A captive flight of any length, tick by tick, in constant memory: for problems that only show after hours.

use kf_core::atmosphere::pressure_altitude_m;
use kf_core::input::{BaroReading, GpsFix, ImuSample, Signals, TickInput};

/// Length of a tick, microseconds.
pub const TICK_US: u64 = 5_000;
/// Ticks a second.
const TICKS_PER_S: u64 = 200;
/// Free flight at the end, seconds.
const FREE_S: u64 = 60;
/// Altitude of the flight, metres.
const ALTITUDE_M: f64 = 2_000.0;
/// Approximate pressure there in the standard atmosphere, pascals; the core computes its exact altitude.
const PRESSURE_PA: f32 = 79_495.2;
/// The scale height there, metres: `p / (rho g)` with the standard temperature at 2 km.
const SCALE_HEIGHT_M: f64 = 8_054.0;
/// White noise of the fixes, the pressure's altitude and the inertial altitudes, metres.
const SIGMA_M: [f64; 3] = [1.5, 0.4, 0.3];
/// Biases of the barometer, of the UAV's and of the mother ship's inertial altitude, metres. The barometer's
/// has in addition the difference of [`PRESSURE_PA`] from the altitude flown.
const BIAS_M: [f64; 3] = [35.0, -12.0, 4.0];

/// Captive flight of some hours in a slow swing of 5 m, then launch and a minute of free flight. Noise is a
/// function of the tick's number, so a clone continues identically.
#[derive(Clone, Debug)]
pub struct LongFlight {
    next: u64,
    ticks: u64,
    launch: u64,
}

impl LongFlight {
    /// Makes a flight with this many hours of captive flight.
    #[must_use]
    pub fn new(hours: f64) -> Self {
        let launch = (hours * 3_600.0) as u64 * TICKS_PER_S;
        Self { next: 0, ticks: launch + FREE_S * TICKS_PER_S, launch }
    }

    /// Number of ticks.
    #[must_use]
    pub const fn ticks(&self) -> u64 {
        self.ticks
    }

    /// The true biases of the UAV's inertial altitude and of the barometer, metres.
    #[must_use]
    pub fn biases_m(&self) -> [f64; 2] {
        let read_m = pressure_altitude_m(PRESSURE_PA).map_or(f64::NAN, f64::from);
        [BIAS_M[1], BIAS_M[0] + read_m - ALTITUDE_M]
    }
}

impl Iterator for LongFlight {
    type Item = TickInput;

    fn next(&mut self) -> Option<TickInput> {
        let tick = self.next;
        if tick >= self.ticks {
            return None;
        }
        self.next += 1;
        let time_s = tick as f64 / TICKS_PER_S as f64;
        let rate = std::f64::consts::TAU / 45.0;
        let (swing_m, climb_mps) = (5.0 * (rate * time_s).sin(), 5.0 * rate * (rate * time_s).cos());
        let altitude_m = ALTITUDE_M + swing_m;
        let every = |period: u64| tick.is_multiple_of(period);
        let noise = |stream: u64| gaussian(tick.wrapping_mul(8).wrapping_add(stream));
        let inertial_m = |bias_m: f64, stream: u64| (altitude_m + bias_m + SIGMA_M[2] * noise(stream)) as f32;
        Some(TickInput {
            time_us: 1_000_000 + tick * TICK_US,
            launch: tick >= self.launch,
            gps: every(40).then(|| GpsFix {
                altitude_m: (altitude_m + SIGMA_M[0] * noise(0)) as f32,
                velocity_north_mps: Some(30.0),
                velocity_east_mps: Some(0.0),
                velocity_down_mps: Some((0.05 * noise(1) - climb_mps) as f32),
                vertical_accuracy_m: Some(SIGMA_M[0] as f32),
                satellites: Some(12),
                fix_time_us: Some(tick * TICK_US),
            }),
            baro: every(4).then(|| {
                let metres = swing_m + BIAS_M[0] + SIGMA_M[1] * noise(2);
                BaroReading::PressurePa((f64::from(PRESSURE_PA) * (-metres / SCALE_HEIGHT_M).exp()) as f32)
            }),
            imu_master_altitude_m: every(20).then(|| inertial_m(BIAS_M[2], 3)),
            imu_slave_altitude_m: every(4).then(|| inertial_m(BIAS_M[1], 4)),
            imu: Some(ImuSample {
                accel_mps2: [0.0, 0.0, (rate * rate * swing_m - 9.806_65) as f32],
                gyro_radps: [0.0; 3],
            }),
            signals: Signals { true_airspeed_mps: every(20).then_some(30.0), ..Signals::default() },
            ..TickInput::default()
        })
    }
}

/// A standard normal number from a counter: two of SplitMix64's outputs (Steele, Lea and Flood, 2014) through
/// Box and Muller's transform.
fn gaussian(counter: u64) -> f64 {
    let uniform = |k: u64| {
        let mut z = k.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(0x632b_e59b_d9b4_e019);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    };
    let (a, b) = (uniform(2 * counter), uniform(2 * counter + 1));
    (-2.0 * (1.0 - a).ln()).sqrt() * (std::f64::consts::TAU * b).cos()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_noise_is_standard_and_normal() {
        let n = 100_000_u64;
        let values: Vec<f64> = (0..n).map(gaussian).collect();
        let mean = values.iter().sum::<f64>() / n as f64;
        let square = values.iter().map(|value| value * value).sum::<f64>() / n as f64;
        let fourth = values.iter().map(|value| value.powi(4)).sum::<f64>() / n as f64;
        // Tolerances are four standard errors.
        assert!(mean.abs() < 4.0 / (n as f64).sqrt(), "{mean}");
        assert!((square - 1.0).abs() < 4.0 * (2.0 / n as f64).sqrt(), "{square}");
        assert!((fourth - 3.0).abs() < 4.0 * (96.0 / n as f64).sqrt(), "{fourth}");
    }

    #[test]
    fn a_clone_goes_on_alike_and_time_goes_on() {
        let mut flight = LongFlight::new(0.01);
        let first: Vec<TickInput> = flight.by_ref().take(500).collect();
        assert!(first.windows(2).all(|pair| pair[1].time_us == pair[0].time_us + TICK_US));
        let clone = flight.clone();
        assert!(flight.eq(clone));
        assert_eq!(LongFlight::new(0.01).count() as u64, LongFlight::new(0.01).ticks());
    }
}
