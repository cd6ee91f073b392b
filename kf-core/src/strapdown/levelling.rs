//! Level alignment: where down is, and what the gyro reads at rest, from the accelerometer in trimmed flight.
//!
//! Over a time in which the aircraft neither speeds up nor turns, specific force is minus gravity, so its
//! mean is the vertical (Titterton and Weston, section 10.3). Attitude is kept by the gyro meanwhile; what is
//! fitted is its error, a straight line in time: the tilt at its start and the gyro's bias. So the mean is
//! taken in axes that do not move with gusts, and what comes out is the attitude now.

use super::memory::Memory;
use super::sum::Sum;
use super::vector::{Down, Vector, cross, dot};
use super::{Config, GRAVITY_MPS2};

/// Time constant of the two measures of trim, seconds: vibration and most gusts are faster, a turn is noticed
/// before it has pulled at the level.
const TRIM_TIME_CONSTANT_S: f32 = 1.0;

/// A line over less than this (seconds) says less of the gyro's bias than what is known of any unit (0.02
/// rad/s): gusts and vibration move what specific force shows by 0.03 rad within it. By what it makes of it
/// the flight seems to turn, and a fit that therefore takes no more samples stays there. So until then it is
/// the gyro alone that says whether the flight turns.
const LEAST_LINE_S: f32 = 3.0;

/// Two shaken samples make a bias of 20 rad/s, by which the axes turn further than small angles do. Over less
/// than this (seconds) the fit is a mean.
const LEAST_SLOPE_S: f32 = 0.2;

/// A fit of less than [`super::COARSE_LEVEL_S`] that finds the flight untrimmed for so long (seconds) is
/// wrong itself: of a gust's first samples it makes a gyro's bias that every flight turns by.
const LONGEST_UNTRIMMED_S: f32 = 10.0;

/// A single sample of more than twice gravity is a jolt, and shows no vertical.
const SPIKE: f32 = 3.0;

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Levelling {
    memory: Memory,
    pub(super) gyro_bias: [Sum; 3],
    turn_radps: f32,
    /// Specific force squared over gravity squared, less 1.
    excess_load: f32,
    /// Since the last sample that was taken.
    untrimmed_s: f32,
}

impl Levelling {
    pub(super) fn gyro_bias_radps(&self) -> Vector {
        self.gyro_bias.map(Sum::value)
    }

    pub(super) const fn elapsed_s(&self) -> f32 {
        self.memory.elapsed_s()
    }

    /// Whether the fit has shut itself out.
    pub(super) fn is_stuck(&self) -> bool {
        self.untrimmed_s > LONGEST_UNTRIMMED_S && self.elapsed_s() < super::COARSE_LEVEL_S
    }

    /// Passes over a sample while something better levels: a later fit counts from here as if it had been in
    /// it.
    pub(super) fn pass(&mut self, step_s: f32, config: &Config) {
        self.memory.count(step_s, config.level_window_s);
    }

    /// Takes a sample into the fit; whether the flight was trimmed, without which it is not.
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
        // Of a gap there is one sample, which shows no more than any other: what it shakes by would be half
        // of the mean.
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
        // The rotation that would bring `down` to where the accelerometer sees it; small.
        let error = cross(vertical, force.map(|part| -part / GRAVITY_MPS2));
        down.rotate(error.map(|part| part * value));
        // A bias about the vertical makes no error of tilt: straight flight has no turn, so it is the mean.
        let heading = self.memory.mean_gain() * turn;
        for axis in 0..3 {
            self.gyro_bias[axis].add(slope * error[axis] + heading * vertical[axis]);
        }
        true
    }
}
