//! In free flight: whether the reference may be believed.
//!
//! Eq. 16 compares both sensors with one receiver, so a fault of the receiver looks like two faults of
//! sensors. Two things say whose it is:
//!
//! - The receiver's climb rate is Doppler, its altitude is code: a fix that leaves the last good one's
//!   altitude, carried on by the climb rate, has jumped. It is refused ([`crate::output::Rejection::Gated`]),
//!   and the altitude is carried on for as long as a reference without fixes counts. A jump that lasts is a
//!   lost reference.
//! - An error of both sensors is the reference's before it is two sensors' by coincidence. With two sensors
//!   to ask, the error of one counts against it only where its own fault is the likelier reading of both
//!   errors (`is_likelier_own` in `free_flight`). Otherwise the reading is not judged, and the sensor is
//!   `unmonitored`.
//! - A fix that brings altitude and climb rate together again, after they lay apart, is good however far it
//!   departs.
//! - A receiver that contradicts itself has two words: an altitude that has left its own climb rate may be as
//!   wrong as that, and a fix that was refused may be right and what was carried on wrong. An error counts
//!   only if the sensor is beyond its bound by both, or the other sensor, calibrated before the two lay
//!   apart, is within its own by the reference and beyond it by the other word.
//! - A receiver that contradicted itself until it was lost, or by hundreds of metres, is the reference for
//!   want of a better: it is disputed. Until a sensor is within its bound by it, an error that no other
//!   sensor can be asked about is not judged.
//!
//! The limits: where the receiver gives no climb rate, or was silent until it was lost, nobody tells two
//! sensors that fail alike from a reference that drifts; they are `unmonitored`, not flagged, and a single
//! sensor is blamed for the reference. Where it gives one, altitude and climb rate that lie alike are
//! believed, and both sensors are blamed.

use serde::{Deserialize, Serialize};

use crate::config::MissionConfig;
use crate::guard::Guard;
use crate::time::{microseconds, seconds_between};

/// For how long it is known that the altitude has left the climb rate's integral, seconds. A receiver that
/// converges takes a minute or two; the climb rate's own random walk is 6 m by then, within a monitor's
/// bound.
const MEMORY_S: f32 = 300.0;
/// The altitude leaves the climb rate's integral by so many of a fix's sigmas without a fault: the bound
/// allows for that, and it excuses nobody. What is left of a fault with that taken off is within any bound,
/// which is three.
const WANDER_SIGMAS: f32 = 2.0;

/// Beyond so many times that wander nobody knows by how much the altitude has left the climb rate's integral:
/// what is forgotten of it in five seconds, a sixtieth of the memory, is more than a fix's own errors explain
/// (four sigmas).
const KNOWN_WANDERS: f32 = 120.0;

/// How far the reference may be off: by anything between nothing and what its other word makes of it, and by
/// a fix's own errors beyond that.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Play {
    /// The error that both sensors show if the climb rate is right and the altitude is not, metres.
    pub(crate) other_m: f32,
    /// One over the square of how far a fix is off by itself, 1/m^2, at the monitor's multiple of sigma: two
    /// errors, one in the calibration and one now.
    pub(crate) stiffness_per_m2: f32,
}

/// The reference's standing.
#[derive(Clone, Debug)]
pub(crate) struct ReferenceCheck {
    is_on: bool,
    /// Variance of a fix's departure from the last good one: two independent errors of a fix, times the
    /// monitor's multiplier squared. A correlated error departs less.
    gate_m2: f32,
    /// What the climb rate's own error adds to that in a second.
    gate_m2_per_s: f32,
    /// How far the altitude may leave the climb rate's integral by itself, metres.
    wander_m: f32,
    lost_after_us: u64,
    standing: Standing,
}

/// What of it changes in flight.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "KeptStanding", into = "KeptStanding")]
pub(crate) struct Standing {
    /// Time of the last fix that was good.
    good_us: u64,
    /// The altitude that was carried on to the last fix, metres, where that was refused.
    carried_m: Option<f32>,
    /// How far the good fixes have left the altitude that their climb rate carries, metres; infinite where
    /// nobody knows; NaN while the receiver is disputed ([`ReferenceCheck::is_disputed`]).
    left_m: f32,
    /// Altitude and climb rate lay apart at the launch already, or nobody knows: the sensors may have been
    /// calibrated by the wrong one.
    was_doubted: bool,
    /// Since when fixes have been refused, microseconds; 0 while they are good. Not kept over a restart,
    /// either.
    refused_us: u64,
    /// The receiver's other word on the altitude, less the reference, metres: the last fix, if it was
    /// refused, or else what the climb rate makes of the fixes before it. Not kept over a restart: the next
    /// fix says it anew.
    other_m: f32,
}

/// A standing in a snapshot, which has no byte left for more than these.
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

    /// At launch, or at a good fix, with the reference as it is: so many metres from its mean over the
    /// calibration, by its climb rate.
    fn begin(&mut self, time_us: u64, left_m: f32) {
        let is_beyond = left_m.is_finite() && left_m.abs() > KNOWN_WANDERS * self.wander_m;
        let left_m = if is_beyond { f32::NAN } else { left_m };
        let is_excess = left_m.is_finite() && left_m.abs() > self.wander_m;
        let excess_m = if is_excess { left_m.abs() - self.wander_m } else { 0.0 };
        let other_m = if left_m > 0.0 { -excess_m } else { excess_m };
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

    /// The altitude that takes the last fix's place, metres; `None` where that was good.
    #[inline]
    pub(crate) const fn carried_m(&self) -> Option<f32> {
        self.standing.carried_m
    }

    /// See [`Standing::other_m`].
    #[inline]
    pub(crate) const fn other_m(&self) -> f32 {
        self.standing.other_m
    }

    /// Whether a sensor that has spoken last at that time is a witness of the reference's two words: it was
    /// calibrated before they lay apart, and has spoken since. What it said before a clock leapt, or a
    /// receiver was silent, is of neither.
    #[inline]
    pub(crate) const fn is_witness(&self, spoke_us: u64) -> bool {
        !self.standing.was_doubted && spoke_us >= self.standing.refused_us
    }

    /// How far the reference may be off; `None` where nobody knows.
    #[inline]
    pub(crate) fn play(&self) -> Option<Play> {
        let Standing { carried_m, left_m, .. } = self.standing;
        let is_known = carried_m.is_none() && left_m.is_finite();
        is_known.then(|| Play { other_m: -left_m, stiffness_per_m2: 1.0 / self.gate_m2 })
    }

    /// Whether a fix that departs by so much, metres, brings altitude and climb rate together again, after
    /// they lay apart: a receiver that jumped and comes back, once what it had jumped to was taken for the
    /// reference.
    fn is_reconciled(&self, departure_m: f32) -> bool {
        let left_m = self.standing.left_m;
        left_m.is_finite() && left_m.abs() > self.wander_m && (left_m + departure_m).abs() <= self.wander_m
    }

    /// The receiver has contradicted itself, by so much that nobody knows by how much, or until it was lost;
    /// what it says now is the reference for want of a better: neither its climb rate nor a sensor stands by
    /// it.
    #[inline]
    pub(crate) const fn is_disputed(&self) -> bool {
        self.standing.left_m.is_nan()
    }

    /// A sensor stands by what is the reference now.
    #[inline]
    pub(crate) const fn settle(&mut self) {
        if self.is_disputed() {
            self.standing.left_m = f32::INFINITY;
        }
    }

    /// Fixes have been refused for so long that what they were carried on from is worth nothing.
    #[inline]
    pub(crate) fn is_lost(&self, time_us: u64) -> bool {
        self.standing.carried_m.is_some()
            && time_us.saturating_sub(self.standing.good_us) > self.lost_after_us
    }

    /// Takes a fix that is so many metres off `carried_m`, the altitude carried on to it. `None` where
    /// nothing was carried. True if it is good; `is_vouched` says whether the sensors take the fix's side.
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
            // After a loss nobody knows what it has left, and where no climb rate carries it nobody ever
            // does.
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
