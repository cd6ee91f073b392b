//! Level alignment: the direction of down and the gyro's bias, from the accelerometer in trimmed flight.
//!
//! Over a time in which the aircraft neither changes speed nor turns, specific force is minus gravity, so its
//! mean is the vertical (Titterton and Weston, section 10.3). Meanwhile the gyro carries the attitude. Its
//! error is fitted with a straight line in time: the tilt at the start and the gyro's bias. So the mean is
//! taken in axes that do not move with gusts, and the result is the present attitude.

use super::memory::Memory;
use super::sum::Sum;
use super::vector::{Down, Vector, cross, dot};
use super::{Config, GRAVITY_MPS2};

/// Time constant of the two measures of trim, seconds: slower than vibration and most gusts, and fast enough
/// to detect a turn before it pulls at the level.
const TRIM_TIME_CONSTANT_S: f32 = 1.0;

/// A line over less than this (seconds) says less about the gyro's bias than is known of any unit (0.02
/// rad/s): within it gusts and vibration move the vertical of the specific force by 0.03 rad. With such a
/// bias the flight seems to turn, and a fit that therefore takes no more samples stays there. So until then
/// only the gyro decides whether the flight turns.
const LEAST_LINE_S: f32 = 3.0;

/// Two shaken samples give a bias of 20 rad/s, which turns the axes further than small angles. Over less than
/// this (seconds) the fit is a mean.
const LEAST_SLOPE_S: f32 = 0.2;

/// If a fit of less than [`super::COARSE_LEVEL_S`] finds the flight untrimmed for this long (seconds), the
/// fit itself is wrong: a gust's first samples gave it a gyro bias by which every flight turns.
const LONGEST_UNTRIMMED_S: f32 = 10.0;

/// A single sample of more than twice gravity is a jolt and does not show the vertical.
const SPIKE: f32 = 3.0;

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Levelling {
    memory: Memory,
    pub(super) gyro_bias: [Sum; 3],
    turn_radps: f32,
    /// Specific force squared over gravity squared, less 1.
    excess_load: f32,
    /// Time since the last sample taken, seconds.
    untrimmed_s: f32,
}

impl Levelling {
    pub(super) fn gyro_bias_radps(&self) -> Vector {
        self.gyro_bias.map(Sum::value)
    }

    pub(super) const fn elapsed_s(&self) -> f32 {
        self.memory.elapsed_s()
    }

    /// Whether the fit excludes all further samples.
    pub(super) fn is_stuck(&self) -> bool {
        self.untrimmed_s > LONGEST_UNTRIMMED_S && self.elapsed_s() < super::COARSE_LEVEL_S
    }

    /// Skips a sample while velocities level the channel: a later fit counts it as if it had been included.
    pub(super) fn pass(&mut self, step_s: f32, config: &Config) {
        self.memory.count(step_s, config.level_window_s);
    }

    /// Takes a sample into the fit if the flight is trimmed; returns whether it is.
    pub(super) fn take(
        &mut self,
        down: &mut Down,
        force: Vector,
        rate: Vector,
        step_s: f32,
        config: &Config,
    ) -> bool {
        let vertical = down.get();
        let bias = self.gyro_bias_radps();
        let turn = dot(rate, vertical) - dot(bias, vertical);
        // A gap has one sample, which shows no more than any other: weighted in full, its vibration would be
        // half of the mean.
        let smoothed_s = step_s.min(super::LONGEST_INTERVAL_S);
        let smoothing = smoothed_s / (TRIM_TIME_CONSTANT_S + smoothed_s);
        let shown = if self.elapsed_s() < LEAST_LINE_S { dot(rate, vertical) } else { turn };
        self.turn_radps += smoothing * (shown - self.turn_radps);
        let excess = dot(force, force) / (GRAVITY_MPS2 * GRAVITY_MPS2) - 1.0;
        self.excess_load += smoothing * (excess - self.excess_load);
        let turning = self.turn_radps > config.turn_limit_radps || self.turn_radps < -config.turn_limit_radps;
        let loaded = self.excess_load > config.load_limit || self.excess_load < -config.load_limit;
        if turning || loaded || excess > SPIKE {
            self.untrimmed_s += step_s;
            return false;
        }
        self.untrimmed_s = 0.0;
        self.memory.count(step_s, config.level_window_s);
        let [value, slope] = if self.elapsed_s() < LEAST_SLOPE_S {
            [self.memory.mean_gain(), 0.0]
        } else {
            self.memory.line_gains(step_s)
        };
        // The small rotation that would bring `down` to the accelerometer's vertical.
        let error = cross(vertical, force.map(|part| -part / GRAVITY_MPS2));
        down.rotate(error.map(|part| part * value));
        // A bias about the vertical causes no tilt error: straight flight does not turn, so it is the mean.
        let heading = self.memory.mean_gain() * turn;
        for axis in 0..3 {
            self.gyro_bias[axis].add(slope * error[axis] + heading * vertical[axis]);
        }
        true
    }
}
