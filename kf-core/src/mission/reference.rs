//! The reference as the sensors are compared with it.

use super::Mission;
use crate::output::Rejection;
use crate::reference::AcceptedFix;
use crate::time::seconds_between;

/// What a fix is to be held against, from before it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Carried {
    /// The altitude carried on to now, metres.
    altitude_m: f32,
    /// The climb rate that did it, m/s, if there was one.
    rate_mps: Option<f32>,
    /// Over so many seconds.
    age_s: f32,
}

impl<const HEAD: usize, const TAIL: usize, const E: usize> Mission<HEAD, TAIL, E> {
    /// The reference now, free of its effects, metres; `None` when it is lost.
    pub(super) fn reference_m(&self, time_us: u64) -> Option<f32> {
        let altitude_m = self.tracker.altitude_m(time_us)?;
        if self.latching.record().is_some()
            && let Some(carried_m) = self.free_flight.carried_m()
        {
            return Some(carried_m + self.tracker.climbed_m(time_us));
        }
        Some(self.freed_m(altitude_m))
    }

    /// An altitude by the last fix, free of the estimated effects.
    fn freed_m(&self, altitude_m: f32) -> f32 {
        // As they stand; after launch, as latched.
        let coefficients = self.coefficients();
        let products = coefficients.iter().zip(&self.fix_regressors_m);
        altitude_m - products.map(|(coefficient, phi)| coefficient * phi).sum::<f32>()
    }

    /// What the next fix is to be held against, if it comes now; `None` in captive flight, and where the
    /// reference is lost.
    pub(super) fn carried(&self, time_us: u64) -> Option<Carried> {
        self.latching.record()?;
        Some(Carried {
            altitude_m: self.reference_m(time_us)?,
            rate_mps: self.tracker.carrying_rate_mps(),
            age_s: seconds_between(self.tracker.last_fix_us(), time_us),
        })
    }

    /// Holds a fix that was just accepted against what was carried on to it.
    pub(super) fn check_fix(
        &mut self,
        time_us: u64,
        fix: AcceptedFix,
        carried: Option<Carried>,
    ) -> Option<Rejection> {
        self.latching.record()?;
        let altitude_m = self.freed_m(fix.altitude_m);
        let carried_m = carried.map_or(altitude_m, |carried| carried.altitude_m);
        let rates_mps = (carried.and_then(|carried| carried.rate_mps), self.tracker.carrying_rate_mps());
        let is_good = match (rates_mps, fix.interval_s) {
            ((Some(before_mps), Some(now_mps)), Some(interval_s)) => {
                let age_s = carried.map_or(interval_s, |carried| carried.age_s);
                // By the mean of the climb rates at both ends, and over the time that it was: the clock may
                // have leapt.
                let carried_m =
                    carried_m + 0.5 * (now_mps - before_mps) * interval_s + before_mps * (interval_s - age_s);
                self.free_flight.take_fix(time_us, Some(carried_m), altitude_m)
            }
            _ => {
                self.free_flight.move_reference(altitude_m - carried_m);
                self.free_flight.take_fix(time_us, None, altitude_m)
            }
        };
        (!is_good).then_some(Rejection::Gated)
    }

    /// A suspicion was none: captive flight goes on from what was carried on to a fix that was refused in it,
    /// and not from that fix.
    pub(super) fn resume_reference(&mut self) {
        let last_m = self.tracker.altitude_m(self.tracker.last_fix_us());
        if let (Some(carried_m), Some(last_m)) = (self.free_flight.carried_m(), last_m) {
            self.tracker.shift(carried_m - self.freed_m(last_m));
        }
    }
}
