//! Whether the reference can be trusted in free flight.
//!
//! Eq. 16 compares both sensors with one receiver, so a fault of the receiver looks like two sensor faults.
//! These rules distinguish them:
//!
//! - The receiver's climb rate is Doppler, its altitude is code. A fix that leaves the last good one's
//!   altitude, carried forward by the climb rate, has jumped. It is refused
//!   ([`crate::output::Rejection::Gated`]), and the altitude is carried forward for as long as a reference
//!   without fixes counts. A jump that lasts is a lost reference.
//! - An error of both sensors is attributed to the reference before it counts as a coincidence of two sensor
//!   faults. With two sensors, the error of one counts against it only if its own fault is the likelier
//!   explanation of both errors (`is_likelier_own` in `free_flight`). Otherwise the reading is not judged,
//!   and the sensor is `unmonitored`.
//! - A fix that brings altitude and climb rate together again, after they disagreed, is good however far it
//!   departs.
//! - A receiver that contradicts itself gives two altitudes: one that has left its own climb rate may be
//!   wrong by that much, and a refused fix may be right and the altitude carried forward wrong. An error
//!   counts only if the sensor is beyond its alarm limit by both altitudes, or if the other sensor,
//!   calibrated before the two disagreed, is within its own limit by the reference and beyond it by the
//!   alternative altitude. Once both sensors have supported one of the two altitudes against the other,
//!   neither is such a witness: one that comes to support the other later has moved.
//! - A receiver that contradicted itself until it was lost, or by hundreds of metres, is the reference only
//!   because there is no better one: it is disputed. Until a sensor is within its alarm limit by it, an error
//!   is not judged if there is no other sensor to compare with.
//!
//! The limits: if the receiver gives no climb rate, or was silent until it was lost, two sensors that fail
//! alike cannot be distinguished from a drifting reference. They are `unmonitored`, not flagged, and a single
//! sensor is blamed for the reference's error. If it gives one, altitude and climb rate with the same error
//! are accepted, and both sensors are blamed.

use serde::{Deserialize, Serialize};

use crate::config::MissionConfig;
use crate::guard::Guard;
use crate::time::{microseconds, seconds_between};

/// Memory of the altitude's departure from the climb rate's integral, seconds. A receiver takes a minute or
/// two to converge; by then the climb rate's own random walk is 6 m, within a monitor's alarm limit.
const MEMORY_S: f32 = 300.0;
/// Departure of the altitude from the climb rate's integral without a fault, in a fix's sigmas: the alarm
/// limit allows for it, and it excuses no sensor. The part of a fault that this leaves unexcused is within
/// any alarm limit, which is three.
const WANDER_SIGMAS: f32 = 2.0;

/// Beyond this many times that wander, the departure from the climb rate's integral is unknown: the part of
/// it that is forgotten in five seconds, a sixtieth of the memory, exceeds what a fix's own errors explain
/// (four sigmas).
const KNOWN_WANDERS: f32 = 120.0;

/// Possible error of the reference: anything between zero and the difference to its alternative altitude,
/// plus a fix's own errors beyond that.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Play {
    /// Error that both sensors show if the climb rate is right and the altitude is wrong, metres.
    pub(crate) other_m: f32,
    /// Inverse square of a fix's own error, 1/m^2, at the monitor's multiple of sigma: two errors, one in the
    /// calibration and one now.
    pub(crate) stiffness_per_m2: f32,
}

/// Assessment of the reference.
#[derive(Clone, Debug)]
pub(crate) struct ReferenceCheck {
    is_on: bool,
    /// Variance of a fix's departure from the last good one: two independent errors of a fix, times the
    /// monitor's multiplier squared. A correlated error departs less.
    gate_m2: f32,
    /// Increase of that variance per second, from the climb rate's own error.
    gate_m2_per_s: f32,
    /// Departure of the altitude from the climb rate's integral without a fault, metres.
    wander_m: f32,
    lost_after_us: u64,
    standing: Standing,
}

/// The part of it that changes in flight.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "KeptStanding", into = "KeptStanding")]
pub(crate) struct Standing {
    /// Time of the last fix that was good.
    good_us: u64,
    /// Altitude carried forward to the last fix, metres, if that fix was refused.
    carried_m: Option<f32>,
    /// Departure of the good fixes from the altitude that their climb rate carries, metres; infinite if
    /// unknown; NaN while the receiver is disputed ([`ReferenceCheck::is_disputed`]).
    left_m: f32,
    /// Altitude and climb rate disagreed at the launch already, or this is unknown: the sensors may have been
    /// calibrated with the wrong one. Or both sensors have since supported one of the two against the other.
    was_doubted: bool,
    /// When fixes began to be refused, microseconds; 0 while they are good. Not kept over a restart.
    refused_us: u64,
    /// The receiver's alternative altitude less the reference, metres: the last fix if it was refused,
    /// otherwise the altitude by the climb rate and the fixes before it. Not kept over a restart: the next
    /// fix gives it again.
    other_m: f32,
}

/// A standing in a snapshot, which has no room for more than these fields.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct KeptStanding {
    good_us: u64,
    carried: KeptCarried,
    left_m: f32,
}

/// [`Standing::carried_m`] and [`Standing::was_doubted`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum KeptCarried {
    Nothing,
    Altitude(f32),
    NothingDoubted,
    AltitudeDoubted(f32),
}

impl From<Standing> for KeptStanding {
    fn from(standing: Standing) -> Self {
        let Standing { good_us, carried_m, left_m, was_doubted, .. } = standing;
        let carried = match (carried_m, was_doubted) {
            (None, false) => KeptCarried::Nothing,
            (Some(carried_m), false) => KeptCarried::Altitude(carried_m),
            (None, true) => KeptCarried::NothingDoubted,
            (Some(carried_m), true) => KeptCarried::AltitudeDoubted(carried_m),
        };
        Self { good_us, carried, left_m }
    }
}

impl From<KeptStanding> for Standing {
    fn from(kept: KeptStanding) -> Self {
        let KeptStanding { good_us, carried, left_m } = kept;
        let (carried_m, was_doubted) = match carried {
            KeptCarried::Nothing => (None, false),
            KeptCarried::Altitude(carried_m) => (Some(carried_m), false),
            KeptCarried::NothingDoubted => (None, true),
            KeptCarried::AltitudeDoubted(carried_m) => (Some(carried_m), true),
        };
        Self { good_us, carried_m, left_m, was_doubted, refused_us: 0, other_m: 0.0 }
    }
}

impl ReferenceCheck {
    pub(crate) fn new<const E: usize>(config: &MissionConfig<E>) -> Self {
        let reference = &config.reference;
        let multiplier2 = config.monitor.multiplier * config.monitor.multiplier;
        let climb_m2_per_s = reference
            .climb_rate
            .map_or(0.0, |climb| 2.0 * climb.sigma_mps * climb.sigma_mps * climb.correlation_time_s);
        Self {
            is_on: config.monitor.reference_check,
            gate_m2: multiplier2 * 2.0 * reference.sigma_m * reference.sigma_m,
            gate_m2_per_s: multiplier2 * climb_m2_per_s,
            wander_m: WANDER_SIGMAS * reference.sigma_m,
            lost_after_us: microseconds(reference.lost_after_s),
            standing: Standing {
                good_us: 0,
                carried_m: None,
                left_m: 0.0,
                was_doubted: true,
                refused_us: 0,
                other_m: 0.0,
            },
        }
    }

    /// At launch; see [`Self::begin`].
    pub(crate) fn launch(&mut self, time_us: u64, left_m: f32) {
        self.begin(time_us, left_m);
        self.standing.was_doubted = self.standing.other_m != 0.0;
    }

    /// Starts at launch, or at a good fix, with the reference as it is: `left_m` from its mean over the
    /// calibration, by its climb rate, metres.
    #[inline(never)]
    fn begin(&mut self, time_us: u64, left_m: f32) {
        let is_beyond = left_m.is_finite() && left_m.abs() > KNOWN_WANDERS * self.wander_m;
        let left_m = if is_beyond { f32::NAN } else { left_m };
        // What is left of the departure without the part that the wander may explain (the positive part of
        // Stein's estimator: C. Stein, "Estimation of the mean of a multivariate normal distribution", Ann.
        // Statist. 9, 1981).
        let wander_m2 = self.wander_m * self.wander_m;
        let is_excess = left_m.is_finite() && left_m * left_m > wander_m2;
        let other_m = if is_excess { wander_m2 / left_m - left_m } else { 0.0 };
        self.standing =
            Standing { good_us: time_us, carried_m: None, left_m, refused_us: 0, other_m, ..self.standing };
    }

    pub(crate) const fn standing(&self) -> Standing {
        self.standing
    }

    pub(crate) fn restore(&mut self, standing: Standing) {
        self.standing = standing;
        if standing.carried_m.is_none() {
            self.begin(standing.good_us, standing.left_m);
        }
    }

    #[inline]
    pub(crate) fn is_on(&self) -> bool {
        self.is_on && Guard::ReferenceJump.stands()
    }

    /// Altitude that replaces the last fix, metres; `None` if that fix was good.
    #[inline]
    pub(crate) const fn carried_m(&self) -> Option<f32> {
        self.standing.carried_m
    }

    /// See [`Standing::other_m`].
    #[inline]
    pub(crate) const fn other_m(&self) -> f32 {
        self.standing.other_m
    }

    /// Both sensors support the receiver's alternative altitude against the reference, or the altitude
    /// carried forward against a fix. One that comes to support the other later has moved, and is no witness.
    #[inline]
    pub(crate) const fn discredit(&mut self) {
        self.standing.was_doubted = true;
    }

    /// Whether a sensor whose last reading has that time is a witness of the receiver's two altitudes: it was
    /// calibrated before they disagreed, and has delivered since. A reading from before a leap of the clock,
    /// or from before the receiver was silent, is evidence for neither.
    #[inline]
    pub(crate) const fn is_witness(&self, spoke_us: u64) -> bool {
        !self.standing.was_doubted && spoke_us >= self.standing.refused_us
    }

    /// Possible error of the reference; `None` if unknown.
    #[inline]
    pub(crate) fn play(&self) -> Option<Play> {
        let Standing { carried_m, left_m, .. } = self.standing;
        let is_known = carried_m.is_none() && left_m.is_finite();
        is_known.then(|| Play { other_m: -left_m, stiffness_per_m2: 1.0 / self.gate_m2 })
    }

    /// Whether a fix that departs by this much, metres, brings altitude and climb rate together again after
    /// they disagreed: a receiver that jumped and comes back after the altitude of the jump was adopted as
    /// the reference.
    fn is_reconciled(&self, departure_m: f32) -> bool {
        let left_m = self.standing.left_m;
        left_m.is_finite() && left_m.abs() > self.wander_m && (left_m + departure_m).abs() <= self.wander_m
    }

    /// The receiver contradicted itself until it was lost, or by so much that the amount is unknown. Its
    /// altitude is the reference only because there is no better one: neither its climb rate nor a sensor
    /// supports it.
    #[inline]
    pub(crate) const fn is_disputed(&self) -> bool {
        self.standing.left_m.is_nan()
    }

    /// A sensor supports the present reference.
    #[inline]
    pub(crate) const fn settle(&mut self) {
        if self.is_disputed() {
            self.standing.left_m = f32::INFINITY;
        }
    }

    /// Fixes have been refused for so long that the altitude carried forward is useless.
    #[inline]
    pub(crate) fn is_lost(&self, time_us: u64) -> bool {
        self.standing.carried_m.is_some()
            && time_us.saturating_sub(self.standing.good_us) > self.lost_after_us
    }

    /// Takes a fix that departs by `departure_m` metres from `carried_m`, the altitude carried forward to it;
    /// `None` if nothing was carried. True if the fix is good; `is_vouched` returns whether the sensors
    /// support it.
    pub(crate) fn take(
        &mut self,
        time_us: u64,
        carried_m: Option<f32>,
        departure_m: f32,
        is_vouched: impl FnOnce() -> bool,
    ) -> bool {
        let seconds = seconds_between(self.standing.good_us, time_us);
        let gate_m2 = self.gate_m2 + self.gate_m2_per_s * seconds;
        // A departure that overflows is beyond any gate.
        let is_good = carried_m.is_none()
            || departure_m * departure_m <= gate_m2
            || self.is_reconciled(departure_m)
            || is_vouched();
        if is_good {
            // After a loss the departure is unknown, and without a climb rate it always is.
            let is_known = carried_m.is_some() && seconds < MEMORY_S;
            let kept_m = if is_known {
                self.standing.left_m * (1.0 - seconds / MEMORY_S)
            } else if self.standing.carried_m.is_some() {
                f32::NAN
            } else {
                f32::INFINITY
            };
            self.begin(time_us, kept_m + departure_m);
        } else {
            let since_us = self.standing.refused_us;
            let refused_us = if since_us == 0 { time_us } else { since_us };
            self.standing = Standing { carried_m, refused_us, other_m: departure_m, ..self.standing };
        }
        is_good
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A departure within the wander has no alternative altitude. Of a larger one the wander explains its own
    /// square over the departure: 2 m of 8 m, 0.4 m of 40 m.
    #[test]
    fn a_large_departure_is_hardly_the_wanders() {
        let mut check = ReferenceCheck {
            is_on: true,
            gate_m2: 72.0,
            gate_m2_per_s: 2.0,
            wander_m: 4.0,
            lost_after_us: 5_000_000,
            standing: Standing {
                good_us: 0,
                carried_m: None,
                left_m: 0.0,
                was_doubted: false,
                refused_us: 0,
                other_m: 0.0,
            },
        };
        let mut other_m = |left_m: f32| {
            check.begin(1_000_000, left_m);
            check.other_m()
        };
        for (left_m, wanted_m) in [
            (0.0, 0.0),
            (4.0, 0.0),
            (-4.0, 0.0),
            (8.0, -6.0),
            (-8.0, 6.0),
            (40.0, -39.6),
            (f32::INFINITY, 0.0),
        ] {
            let found_m = other_m(left_m);
            assert!((found_m - wanted_m).abs() < 1e-4, "{left_m}: {found_m}");
        }
    }
}
