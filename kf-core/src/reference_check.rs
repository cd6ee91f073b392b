//! In free flight: whether the reference may be believed.
//!
//! Eq. 16 compares both sensors with one receiver, so a fault of the receiver looks like two faults of sensors. Two things
//! say whose it is:
//!
//! - The receiver's climb rate is Doppler, its altitude is code: a fix that leaves the last good one's altitude, carried on
//!   by the climb rate, has jumped. It is refused ([`crate::output::Rejection::Gated`]), and the altitude is carried on for as long as
//!   a reference without fixes counts. A jump that lasts is a lost reference.
//! - An error of both sensors is the reference's before it is two sensors' by coincidence. With two sensors to ask, the error
//!   of one counts against it only while the other vouches for the reference: it is itself within its bound, and nearer to
//!   the reference than to the first. Otherwise the reading is not judged, and the sensor is `unmonitored`.
//!
//! The limits: two sensors that fail alike are told from a reference that drifts by nobody, and are `unmonitored`, not flagged;
//! a single sensor is blamed for a slow drift of the reference, and, where the receiver gives no climb rate, for a jump.

use serde::{Deserialize, Serialize};

use crate::config::MissionConfig;
use crate::guard::Guard;
use crate::time::{microseconds, seconds_between};

/// The reference's standing.
#[derive(Clone, Debug)]
pub(crate) struct ReferenceCheck {
    is_on: bool,
    /// Variance of a fix's departure from the last good one: two independent errors of a fix, times the monitor's multiplier
    /// squared. A correlated error departs less.
    gate_m2: f32,
    /// What the climb rate's own error adds to that in a second.
    gate_m2_per_s: f32,
    lost_after_us: u64,
    standing: Standing,
}

/// What of it changes in flight.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Standing {
    /// Time of the last fix that was good.
    good_us: u64,
    /// The altitude that was carried on to the last fix, metres, where that was refused.
    carried_m: Option<f32>,
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
            lost_after_us: microseconds(reference.lost_after_s),
            standing: Standing { good_us: 0, carried_m: None },
        }
    }

    /// At launch, with the reference as it is.
    pub(crate) fn begin(&mut self, time_us: u64) {
        self.standing = Standing { good_us: time_us, carried_m: None };
    }

    pub(crate) const fn standing(&self) -> Standing {
        self.standing
    }

    pub(crate) fn restore(&mut self, standing: Standing) {
        self.standing = standing;
    }

    #[inline]
    pub(crate) fn is_on(&self) -> bool {
        self.is_on && Guard::ReferenceJump.stands()
    }

    /// The altitude that takes the last fix's place, metres; `None` where that was good.
    #[inline]
    pub(crate) const fn carried_m(&self) -> Option<f32> {
        self.standing.carried_m
    }

    /// Fixes have been refused for so long that what they were carried on from is worth nothing.
    #[inline]
    pub(crate) fn is_lost(&self, time_us: u64) -> bool {
        self.standing.carried_m.is_some()
            && time_us.saturating_sub(self.standing.good_us) > self.lost_after_us
    }

    /// Takes a fix that is so many metres off `carried_m`, the altitude carried on to it. `None` where nothing was carried.
    /// True if it is good; `is_vouched` says whether the sensors take the fix's side.
    pub(crate) fn take(
        &mut self,
        time_us: u64,
        carried_m: Option<f32>,
        departure_m: f32,
        is_vouched: impl FnOnce() -> bool,
    ) -> bool {
        let gate_m2 = self.gate_m2 + self.gate_m2_per_s * seconds_between(self.standing.good_us, time_us);
        // A departure that overflows is beyond any gate.
        let is_good = carried_m.is_none() || departure_m * departure_m <= gate_m2 || is_vouched();
        self.standing = match is_good {
            true => Standing { good_us: time_us, carried_m: None },
            false => Standing { carried_m, ..self.standing },
        };
        is_good
    }
}
