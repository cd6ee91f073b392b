//! The constant error of the forward acceleration, measured in captive flight against the receiver's velocity.
//!
//! A quarter of a degree of pitch lets 0.04 m/s^2 of gravity into the forward acceleration. Integrated twice,
//! that is more than the aircraft's own motion after some minutes. In captive flight the receiver shows it: the
//! integral of the forward acceleration should be the changes of the velocity along the heading. In a turn at
//! constant speed the velocity changes across the heading, and a wind, which does not change, cancels.
//!
//! What the turns let in through a wrong heading, and the noise of the velocity at both ends, are the
//! measurement's error; it is weighted against the error's own sigma.

use crate::root::reciprocal_root;
use crate::trigonometry::sine_and_cosine;

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

/// Sums of what the accelerometers and the receiver say in captive flight.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ForwardError {
    heading_rad: Option<f32>,
    last: Option<At>,
    /// Integral of the forward acceleration since the last fix, m/s, and its time, s.
    pending: (f32, f32),
    /// The integral's excess over the velocity's changes along the heading, m/s.
    excess_mps: f32,
    /// The velocity's changes across the heading, m/s.
    across_mps: f32,
    seconds: f32,
}

impl ForwardError {
    /// Takes a heading, rad.
    pub(super) fn turn_to(&mut self, heading_rad: f32) {
        self.heading_rad = Some(heading_rad);
    }

    /// Integrates a forward acceleration over the time since the last tick. Without one, the interval between
    /// the fixes is not used.
    pub(super) fn advance(&mut self, seconds: f32, forward_mps2: Option<f32>) {
        match forward_mps2 {
            Some(forward_mps2) => {
                self.pending.0 += seconds * forward_mps2;
                self.pending.1 += seconds;
            }
            None => self.last = None,
        }
    }

    /// Takes a fix's velocity, north and east, m/s, at the end of what was integrated.
    pub(super) fn take(&mut self, velocity_mps: [f32; 2]) {
        let (gained_mps, seconds) = core::mem::take(&mut self.pending);
        let Some((sine, cosine)) = self.heading_rad.and_then(sine_and_cosine) else { return };
        let now = At { velocity_mps, heading: [cosine, sine] };
        let Some(last) = self.last.replace(now) else { return };
        let turned = cosine * last.heading[0] + sine * last.heading[1];
        if turned < LARGEST_TURN {
            return;
        }
        let length = reciprocal_root(2.0 + 2.0 * turned);
        let [north, east] = [cosine + last.heading[0], sine + last.heading[1]].map(|part| length * part);
        let changed = [velocity_mps[0] - last.velocity_mps[0], velocity_mps[1] - last.velocity_mps[1]];
        let next = Self {
            excess_mps: self.excess_mps + gained_mps - (changed[0] * north + changed[1] * east),
            across_mps: self.across_mps + (changed[1] * north - changed[0] * east),
            seconds: self.seconds + seconds,
            ..*self
        };
        if next.excess_mps.is_finite() && next.across_mps.is_finite() {
            *self = next;
        }
    }

    /// Begins an interval afresh: what lies between the last fix and the next is not used.
    pub(super) fn interrupt(&mut self) {
        self.last = None;
    }

    /// The error as far as it is known, and its remaining sigma, m/s^2.
    pub(super) fn estimate_mps2(&self) -> (f32, f32) {
        let across_mps = HEADING_RAD * self.across_mps;
        let doubt = across_mps * across_mps + VELOCITY_MPS * VELOCITY_MPS;
        let prior = PRIOR_MPS2 * PRIOR_MPS2 * self.seconds * self.seconds;
        let sum = prior + doubt;
        if !(sum.is_finite() && self.seconds > 0.0) {
            return (0.0, PRIOR_MPS2);
        }
        let estimate_mps2 = PRIOR_MPS2 * PRIOR_MPS2 * self.seconds * self.excess_mps / sum;
        (estimate_mps2, PRIOR_MPS2 * doubt / sum * reciprocal_root(doubt / sum))
    }
}
