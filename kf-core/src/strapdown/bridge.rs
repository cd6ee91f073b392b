//! The cost of a gap between two inertial samples, and its repair in free flight.
//!
//! A gap is bridged by a straight line. In captive flight the reference removes the error again. In free
//! flight only the channel's own samples may move it, or it could not be monitored. But a climb rate that is
//! off by a metre a second after a transient of half a second makes the channel useless for the rest of the
//! flight. So gaps that have cost more than [`MENDED_BY_CLIMB_M2PS2`] are mended: fixes are taken, weighted
//! by what the gaps have cost, until the climb rate is known to [`MENDED_M2PS2`], or to
//! [`MENDED_BY_CLIMB_M2PS2`] with a receiver that measures its own climb rate; after its first fix the
//! altitude is known again. That is not enough: a level error from a gap continues to pull at the climb rate,
//! so the lacking acceleration must be known as well ([`MENDED_LACKING_M2PS4`]). After a gap of a second
//! altitudes alone take 10 to 30 s for it. A gap in captive flight that the launch leaves no time to mend is
//! mended after the launch.

/// Variance of the climb rate to which gaps are mended, (m/s)^2: half a metre a second, 30 m in a minute of
/// free flight, which is the drift of a MEMS unit anyway.
pub(super) const MENDED_M2PS2: f32 = 0.25;
/// The same if fixes have climb rates, which take no longer to reach it: 0.14 m/s. With half a metre a second
/// an altitude would be at its alarm limit after a quarter of a minute. Also the cost up to which a gap is
/// not mended: that of a fifth of a second.
pub(super) const MENDED_BY_CLIMB_M2PS2: f32 = 0.02;
/// Variance of the lacking acceleration to which gaps are mended, (m/s^2)^2: 0.017 m/s^2, the same 30 m in a
/// minute. A channel tied for a minute or more knows it to 0.01 m/s^2, and a gap too short to be mended
/// leaves it below this.
pub(super) const MENDED_LACKING_M2PS4: f32 = 2.8e-4;
/// Time without a climb rate after which a receiver is assumed to measure none, seconds.
pub(super) const CLIMB_FIX_S: f32 = 1.5;
/// Variance of the altitude to which gaps are mended, m^2: reached after some seconds of fixes.
pub(super) const MENDED_M2: f32 = 2.0;
/// Variances beyond which a channel that is being mended gives no altitude: 2 m/s, and 5 m more than its
/// drift in free flight.
pub(super) const UNKNOWN_CLIMB_M2PS2: f32 = 4.0;
pub(super) const UNKNOWN_ALTITUDE_M2: f32 = 25.0;
/// The samples at a gap's ends contain vibration of 0.8 m/s^2, half of it squared.
const SHAKE: f32 = 0.32;
/// Between them the acceleration wanders off the line by 2 m/s^2 within 0.5 s (variance of a Brownian
/// bridge's integral, `2 sigma^2 / tau t^3 / 12`).
const MANOEUVRE: f32 = 1.33;
/// Likewise for turn rates that wander by 0.3 rad/s within 0.5 s.
const TURN: f32 = 0.03;

/// Cost of a straight line over a gap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BridgeCost {
    /// Variance of the climb rate, (m/s)^2.
    pub(super) climb_m2ps2: f32,
    /// Variance of the level, rad^2. Under a horizontal acceleration of 1 m/s^2 it becomes lacking
    /// acceleration.
    pub(super) tilt_rad2: f32,
}

impl BridgeCost {
    /// Cost of a gap of this many seconds.
    pub(super) fn of(gap_s: f32) -> Self {
        let square = gap_s * gap_s;
        Self { climb_m2ps2: square * (SHAKE + MANOEUVRE * gap_s), tilt_rad2: TURN * square * gap_s }
    }
}
