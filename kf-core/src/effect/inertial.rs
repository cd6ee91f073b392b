//! Specific force and attitude, from which the inertial effects are integrated.

use serde::{Deserialize, Serialize};

use super::integral::DoubleIntegral;
use crate::atmosphere::STANDARD_GRAVITY_MPS2;
use crate::time::seconds_between;
use crate::trigonometry::sine_and_cosine;

/// Columns of an inertial sample, which is complete or absent.
pub(super) const COLUMNS: &[&str] =
    &["accel_x_mps2", "accel_y_mps2", "accel_z_mps2", "gyro_x_radps", "gyro_y_radps", "gyro_z_radps"];
/// Columns of an attitude, which is complete or absent.
pub(super) const ATTITUDE_COLUMNS: &[&str] = &["roll_rad", "pitch_rad", "yaw_rad"];
/// Both.
pub(super) const COLUMNS_AND_ATTITUDE: &[&str] = &[
    "accel_x_mps2",
    "accel_y_mps2",
    "accel_z_mps2",
    "gyro_x_radps",
    "gyro_y_radps",
    "gyro_z_radps",
    "roll_rad",
    "pitch_rad",
    "yaw_rad",
];

/// Time constant of the load factor's low-pass, seconds: an engine's vibration must not look like manoeuvres,
/// and no manoeuvre is this fast.
const LOAD_FACTOR_TIME_S: f32 = 0.05;

/// Sines and cosines of the level frame's angles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Level {
    sin_roll: f32,
    cos_roll: f32,
    sin_pitch: f32,
    cos_pitch: f32,
}

/// Cosine of the pitch beyond which roll is not carried on: roll is not defined at the vertical.
const STEEP_COSINE: f32 = 0.1;
/// Largest turn of an aircraft between two samples, rad.
const LARGEST_TURN_RAD: f32 = 0.3;

/// Sine and cosine of an angle that has grown by a small angle, to the third power of that.
fn turned((sine, cosine): (f32, f32), by_rad: f32) -> (f32, f32) {
    let loss = 0.5 * by_rad * by_rad;
    (sine + by_rad * cosine - loss * sine, cosine - by_rad * sine - loss * cosine)
}

/// Latest specific force and attitude.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Inertial {
    accel: Option<(u64, [f32; 3])>,
    load_factor: Option<f32>,
    level: Option<Level>,
    /// The last sample since launch, for the vibration's differences.
    shaken: Option<(u64, [f32; 3])>,
    vibration: DoubleIntegral,
}

impl Inertial {
    /// Takes a finite specific force, body axes, m/s^2.
    pub(super) fn take_accel(&mut self, time_us: u64, accel_mps2: [f32; 3]) {
        let [_, _, z] = accel_mps2;
        let load_factor = -z / STANDARD_GRAVITY_MPS2;
        self.load_factor = Some(match (self.load_factor, self.accel) {
            (Some(filtered), Some((last_us, _))) => {
                let seconds = seconds_between(last_us, time_us);
                filtered + (load_factor - filtered) * (seconds / (LOAD_FACTOR_TIME_S + seconds))
            }
            _ => load_factor,
        });
        self.accel = Some((time_us, accel_mps2));
    }

    /// Takes roll and pitch, rad; false for an invalid angle.
    pub(super) fn take_attitude(&mut self, roll_rad: f32, pitch_rad: f32) -> bool {
        let (Some((sin_roll, cos_roll)), Some((sin_pitch, cos_pitch))) =
            (sine_and_cosine(roll_rad), sine_and_cosine(pitch_rad))
        else {
            return false;
        };
        self.level = Some(Level { sin_roll, cos_roll, sin_pitch, cos_pitch });
        true
    }

    /// Carries roll and pitch on from the last sample of specific force by the body rates, rad/s, until there
    /// is a new attitude: one that is 15 ms late would let gravity in (Titterton and Weston, on propagating
    /// Euler angles). Rates that no aircraft has are ignored.
    pub(super) fn turn(&mut self, time_us: u64, [p, q, r]: [f32; 3]) {
        let (Some((last_us, _)), Some(level)) = (self.accel, &mut self.level) else { return };
        let seconds = seconds_between(last_us, time_us);
        if level.cos_pitch < STEEP_COSINE {
            return;
        }
        let pitched_rad = seconds * (q * level.cos_roll - r * level.sin_roll);
        let around = q * level.sin_roll + r * level.cos_roll;
        let rolled_rad = seconds * (p + level.sin_pitch / level.cos_pitch * around);
        let is_small = |turn_rad: f32| turn_rad.abs() <= LARGEST_TURN_RAD;
        if is_small(pitched_rad) && is_small(rolled_rad) {
            (level.sin_roll, level.cos_roll) = turned((level.sin_roll, level.cos_roll), rolled_rad);
            (level.sin_pitch, level.cos_pitch) = turned((level.sin_pitch, level.cos_pitch), pitched_rad);
        }
    }

    /// Restarts the vibration's integral.
    pub(super) fn restart(&mut self) {
        self.shaken = None;
        self.vibration = DoubleIntegral::default();
    }

    /// Integrates the vibration's variance, (m/s^2)^2 summed over the axes, over the time since the last
    /// sample: half the squared difference of two neighbours (von Neumann, "Distribution of the ratio of the
    /// mean square successive difference to the variance", Ann. Math. Stat. 12(4), 1941), which a manoeuvre
    /// hardly affects. It needs no window: the integrals average. False where it overflows.
    pub(super) fn shake(&mut self, time_us: u64, accel_mps2: [f32; 3]) -> bool {
        let Some((last_us, last)) = self.shaken.replace((time_us, accel_mps2)) else { return true };
        let square: f32 =
            accel_mps2.iter().zip(last).map(|(now, before)| (now - before) * (now - before)).sum();
        let seconds = seconds_between(last_us, time_us);
        // Constant over the interval: its straight line has equal ends.
        let mut next = self.vibration;
        let is_taken = next.advance(0.0, 0.5 * square) && next.advance(seconds, 0.5 * square);
        if is_taken {
            self.vibration = next;
        }
        is_taken
    }

    /// See [`Self::shake`]; `None` before the first sample.
    pub(super) fn vibration_integral_m(&self) -> Option<f32> {
        self.accel.map(|_| self.vibration.value())
    }

    /// Load factor, g; `None` before the first sample.
    pub(super) const fn load_factor(&self) -> Option<f32> {
        self.load_factor
    }

    /// Sine of the pitch angle.
    pub(super) fn sin_pitch(&self) -> Option<f32> {
        self.level.map(|level| level.sin_pitch)
    }

    /// Whether specific force and attitude are both known.
    pub(super) const fn is_complete(&self) -> bool {
        self.accel.is_some() && self.level.is_some()
    }

    /// Upward acceleration (specific force less gravity) and forward acceleration in the level frame that
    /// turns with the heading, m/s^2.
    pub(super) fn upward_and_forward_mps2(&self) -> Option<[f32; 2]> {
        let ((_, [x, y, z]), level) = (self.accel?, self.level?);
        let Level { sin_roll, cos_roll, sin_pitch, cos_pitch } = level;
        // Body axes rolled back to level.
        let down = sin_roll * y + cos_roll * z;
        let forward = cos_pitch * x + sin_pitch * down;
        let upward = sin_pitch * x - cos_pitch * down - STANDARD_GRAVITY_MPS2;
        Some([upward, forward])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn level_and_banked_flight_have_no_vertical_acceleration() {
        let mut inertial = Inertial::default();
        assert_eq!(inertial.upward_and_forward_mps2(), None);
        let g = STANDARD_GRAVITY_MPS2;
        // A level turn at 60 degrees of bank: 2 g along the body's own vertical.
        inertial.take_accel(0, [0.0, 0.0, -2.0 * g]);
        assert!(inertial.take_attitude(core::f32::consts::FRAC_PI_3, 0.0));
        let [upward, forward] = inertial.upward_and_forward_mps2().unwrap();
        assert!(upward.abs() < 1e-5 && forward == 0.0, "{upward}");
        assert_eq!(inertial.load_factor(), Some(2.0));
        // At rest, nose up by 30 degrees: half of g along x, and no acceleration.
        inertial.take_accel(5_000, [0.5 * g, 0.0, -0.866_025_4 * g]);
        assert!(inertial.take_attitude(0.0, core::f32::consts::FRAC_PI_6));
        let [upward, forward] = inertial.upward_and_forward_mps2().unwrap();
        assert!(upward.abs() < 1e-5 && forward.abs() < 1e-5, "{upward} {forward}");
        assert!(!inertial.take_attitude(f32::NAN, 0.0) && !inertial.take_attitude(0.0, 1e9));
        assert_eq!(inertial.sin_pitch(), Some(0.5));
    }

    #[test]
    fn between_attitudes_the_body_rates_carry_roll_and_pitch() {
        let mut inertial = Inertial::default();
        assert!(inertial.take_attitude(0.3, -0.2));
        inertial.take_accel(0, [0.0, 0.0, -9.8]);
        // Euler angles that change at 0.5 and -0.4 rad/s, yaw still: their body rates, and 20 steps of 5 ms.
        let (mut roll, mut pitch) = (0.3_f64, -0.2_f64);
        for k in 1..=20_u16 {
            let middle = roll + 0.5 * 0.005 * 0.5;
            let rates = [0.5, (-0.4 * middle.cos()) as f32, (0.4 * middle.sin()) as f32];
            let time_us = u64::from(k) * 5_000;
            inertial.turn(time_us, rates);
            inertial.take_accel(time_us, [0.0, 0.0, -9.8]);
            roll += 0.0025;
            pitch -= 0.002;
        }
        let level = inertial.level.unwrap();
        for (ours, exact) in [
            (level.sin_roll, roll.sin()),
            (level.cos_roll, roll.cos()),
            (level.sin_pitch, pitch.sin()),
            (level.cos_pitch, pitch.cos()),
        ] {
            // Rates of the interval's middle, angles of its start: a thousandth of the 0.05 rad turned.
            assert!((f64::from(ours) - exact).abs() < 1e-4, "{ours} {exact}");
        }
        let before = inertial;
        inertial.turn(105_000, [1e9, 0.0, 0.0]);
        inertial.turn(105_000, [f32::NAN, 0.0, 0.0]);
        assert_eq!(inertial, before);
    }

    #[test]
    fn the_vibrations_variance_is_found_under_a_manoeuvre() {
        // Uniform noise of 2 m/s^2 on each axis over a ramp of 10 m/s^3, 50 s at 200 Hz.
        let mut inertial = Inertial::default();
        let mut seed = 3_u32;
        let mut noise = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            2.0 * ((seed >> 8) as f32 / 16_777_216.0 - 0.5) * 3.464_101_6
        };
        for k in 0..=10_000_u16 {
            let ramp = f32::from(k) * 0.05;
            let accel = [ramp + noise(), noise(), ramp + noise()];
            inertial.take_accel(u64::from(k) * 5_000, accel);
            assert!(inertial.shake(u64::from(k) * 5_000, accel));
        }
        let expected = 12.0 * 50.0 * 50.0 / 2.0;
        // 30,000 squares of differences: 1 % is two of their standard errors, and the ramp adds 0.02 %.
        assert!((inertial.vibration_integral_m().unwrap() / expected - 1.0).abs() < 0.02);
    }
}
