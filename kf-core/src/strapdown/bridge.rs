//! What a gap between two inertial samples costs, and how free flight makes good for it.
//!
//! A gap is bridged on a straight line. In captive flight the reference takes the error out again. In free
//! flight nothing may move the channel but its own samples, or it could not be watched; but a climb rate that
//! is off by a metre a second after a transient of half a second makes the channel useless for the rest of
//! the flight. So gaps that have cost more than [`MENDED_BY_CLIMB_M2PS2`] are mended: fixes are taken,
//! weighed by what the gaps have cost, until the climb rate is known to [`MENDED_M2PS2`], and to
//! [`MENDED_BY_CLIMB_M2PS2`] by a receiver that measures its own: after its first fix the altitude is known
//! again. Nor is that enough: the level that a gap has cost goes on pulling at the climb rate, so the
//! acceleration that is lacking has to be known as well ([`MENDED_LACKING_M2PS4`]). After a gap of a second
//! altitudes alone take 10 to 30 s for it. A gap under the pylon that the launch leaves no time to mend is
//! mended after it.

/// Variance of the climb rate to which gaps are mended, (m/s)^2: half a metre a second, 30 m in a
/// minute of free flight, is what a MEMS unit drifts anyway.
pub(super) const MENDED_M2PS2: f32 = 0.25;
/// The same where fixes have climb rates, which take no longer for it: 0.14 m/s. Of half a metre a second an
/// altitude would be at its bound after a quarter of a minute. What a gap may cost and not be mended: a fifth
/// of a second.
pub(super) const MENDED_BY_CLIMB_M2PS2: f32 = 0.02;
/// Variance of the lacking acceleration to which gaps are mended, (m/s^2)^2: 0.017 m/s^2, the same 30 m in a
/// minute. A channel that has been tied for a minute or more knows it to 0.01 m/s^2, and a gap that is too
/// short to be mended leaves it below this.
pub(super) const MENDED_LACKING_M2PS4: f32 = 2.8e-4;
/// Without one for so long, seconds, a receiver measures none.
pub(super) const CLIMB_FIX_S: f32 = 1.5;
/// Variance of the altitude to which gaps are mended, m^2: what some seconds of fixes leave.
pub(super) const MENDED_M2: f32 = 2.0;
/// Variances beyond which a channel that is being mended says nothing: 2 m/s, and 5 m more than it had
/// drifted by in free flight.
pub(super) const UNKNOWN_CLIMB_M2PS2: f32 = 4.0;
pub(super) const UNKNOWN_ALTITUDE_M2: f32 = 25.0;
/// The samples at a gap's ends have the vibration of 0.8 m/s^2 in them, half of it squared.
const SHAKE: f32 = 0.32;
/// Between them the acceleration wanders off the line by 2 m/s^2 within 0.5 s (variance of a Brownian
/// bridge's integral, `2 sigma^2 / tau t^3 / 12`).
const MANOEUVRE: f32 = 1.33;
/// Likewise for turn rates that wander by 0.3 rad/s within 0.5 s.
const TURN: f32 = 0.03;

/// What a straight line over a gap costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BridgeCost {
    /// The climb rate, (m/s)^2.
    pub(super) climb_m2ps2: f32,
    /// The level, rad^2. A horizontal acceleration of 1 m/s^2 makes of it what the accelerometer lacks.
    pub(super) tilt_rad2: f32,
}

impl BridgeCost {
    /// Of a gap of so many seconds.
    pub(super) fn of(gap_s: f32) -> Self {
        let square = gap_s * gap_s;
        Self { climb_m2ps2: square * (SHAKE + MANOEUVRE * gap_s), tilt_rad2: TURN * square * gap_s }
    }
}
