//! The constant error of the forward acceleration, measured in captive flight against the receiver's
//! velocity.
//!
//! A quarter of a degree of pitch lets 0.04 m/s^2 of gravity into the forward acceleration. Integrated twice,
//! that is more than the aircraft's own motion after some minutes. In captive flight the receiver shows it:
//! the integral of the forward acceleration should be the sum of the velocity's changes along the heading. In
//! a turn at constant speed the velocity changes across the heading, and a steady wind cancels.
//!
//! This measurement is wrong by the noise of the velocity at both ends, and by the part of the turns that a
//! wrong heading lets in. The less certain it is, compared with the error that is expected, the less of it is
//! used.

use crate::root::reciprocal_root;
use crate::trigonometry::{LARGEST_ANGLE_RAD, sine_and_cosine};

/// One sigma of the error, m/s^2: a quarter of a degree of gravity. Data sheets state 0.2 degrees (Xsens
/// MTi-300, static) to 0.5 degrees (VectorNav VN-100, static).
const PRIOR_MPS2: f32 = 0.043;
/// One sigma of the heading, rad: the same data sheets state 1 to 2 degrees.
const HEADING_RAD: f32 = 0.025;
/// One sigma of a change of the velocity, m/s: noise at both ends (u-blox M8: 0.05 m/s each), and some tenths
/// of a second of delay times the acceleration there.
const VELOCITY_MPS: f32 = 0.2;
/// Cosine of the largest turn between two fixes: beyond it the heading's mean says little.
const LARGEST_TURN: f32 = 0.5;

/// Velocity and heading at a fix, north and east.
#[derive(Clone, Copy, Debug, PartialEq)]
struct At {
    velocity_mps: [f32; 2],
    heading: [f32; 2],
}

/// Sums of what the accelerometers and the receiver say in captive flight, from a first fix with a heading on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ForwardError {
    heading_rad: Option<f32>,
    last: Option<At>,
    /// The integral of the forward acceleration less the velocity's changes along the heading, m/s.
    excess_mps: f32,
    /// The velocity's changes across the heading, m/s.
    across_mps: f32,
    seconds: f32,
}

impl ForwardError {
    /// Takes a heading, rad; an invalid angle is none.
    pub(super) fn turn_to(&mut self, heading_rad: f32) {
        if (-LARGEST_ANGLE_RAD..=LARGEST_ANGLE_RAD).contains(&heading_rad) {
            self.heading_rad = Some(heading_rad);
        }
    }

    /// Integrates a forward acceleration over the time since the last tick.
    pub(super) fn advance(&mut self, seconds: f32, forward_mps2: f32) {
        if self.last.is_some() {
            self.excess_mps += seconds * forward_mps2;
            self.seconds += seconds;
        }
    }

    /// Takes a fix's velocity, north and east, m/s, at the end of what was integrated.
    #[inline(never)]
    pub(super) fn take(&mut self, velocity_mps: [f32; 2]) {
        let Some((sine, cosine)) = self.heading_rad.and_then(sine_and_cosine) else { return };
        let now = At { velocity_mps, heading: [cosine, sine] };
        let Some(last) = self.last.replace(now) else { return };
        let turned = cosine * last.heading[0] + sine * last.heading[1];
        if turned < LARGEST_TURN {
            *self = Self { heading_rad: self.heading_rad, last: Some(now), ..Self::default() };
            return;
        }
        let length = reciprocal_root(2.0 + 2.0 * turned);
        let [north, east] = [cosine + last.heading[0], sine + last.heading[1]].map(|part| length * part);
        let changed = [velocity_mps[0] - last.velocity_mps[0], velocity_mps[1] - last.velocity_mps[1]];
        self.excess_mps -= changed[0] * north + changed[1] * east;
        self.across_mps += changed[1] * north - changed[0] * east;
    }

    /// Measures from the next fix on; the aircraft has flown free in between.
    pub(super) fn restart(&mut self) {
        *self = Self { heading_rad: self.heading_rad, ..Self::default() };
    }

    /// The variances of the error itself and of its measurement, times the square of its time, (m/s)^2.
    fn variances(&self) -> [f32; 2] {
        let own_mps = PRIOR_MPS2 * self.seconds;
        let across_mps = HEADING_RAD * self.across_mps;
        [own_mps * own_mps, across_mps * across_mps + VELOCITY_MPS * VELOCITY_MPS]
    }

    /// The error as far as it is known, m/s^2; none where nothing was measured or a number has overflowed.
    pub(super) fn estimate_mps2(&self) -> f32 {
        let [own, measured] = self.variances();
        let estimate_mps2 = own / (own + measured) * (self.excess_mps / self.seconds);
        if estimate_mps2.is_finite() { estimate_mps2 } else { 0.0 }
    }

    /// Its remaining sigma, m/s^2.
    pub(super) fn sigma_mps2(&self) -> f32 {
        let [own, measured] = self.variances();
        let share = measured / (own + measured);
        if share >= f32::MIN_POSITIVE { PRIOR_MPS2 * share * reciprocal_root(share) } else { PRIOR_MPS2 }
    }
}
