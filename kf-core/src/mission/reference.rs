//! The reference with which the sensors are compared.

use super::Mission;
use crate::output::Rejection;
use crate::reference::AcceptedFix;
use crate::time::seconds_between;

/// Prediction with which the next fix is compared.
#[derive(Clone, Copy, Debug)]
pub(super) struct Carried {
    /// The altitude carried forward to now, metres.
    altitude_m: f32,
    /// The climb rate used for it, m/s, if there was one.
    rate_mps: Option<f32>,
    /// Time over which it was carried, seconds.
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

    /// An altitude of the last fix without the estimated effects.
    fn freed_m(&self, altitude_m: f32) -> f32 {
        // The current ones; after launch, the latched ones.
        let coefficients = self.coefficients();
        let products = coefficients.iter().zip(&self.fix_regressors_m);
        altitude_m - products.map(|(coefficient, phi)| coefficient * phi).sum::<f32>()
    }

    /// Prediction for a fix that comes now; `None` in captive flight and if the reference is lost.
    pub(super) fn carried(&self, time_us: u64) -> Option<Carried> {
        self.latching.record()?;
        Some(Carried {
            altitude_m: self.reference_m(time_us)?,
            rate_mps: self.tracker.carrying_rate_mps(),
            age_s: seconds_between(self.tracker.last_fix_us(), time_us),
        })
    }

    /// Compares a fix that was just accepted with the altitude carried forward to it.
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
                // With the mean of the climb rates at both ends, and over the receiver's own interval: the
                // clock may have leapt.
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

    /// Withdraws a suspicion: captive flight continues from the altitude that was carried forward to a fix
    /// that was refused meanwhile, not from that fix.
    pub(super) fn resume_reference(&mut self) {
        let last_m = self.tracker.altitude_m(self.tracker.last_fix_us());
        if let (Some(carried_m), Some(last_m)) = (self.free_flight.carried_m(), last_m) {
            self.tracker.shift(carried_m - self.freed_m(last_m));
        }
    }
}
