//! Ties altitude and climb rate to the reference, and mends free flight's gaps with it.

use super::bridge::{CLIMB_FIX_S, MENDED_BY_CLIMB_M2PS2, MENDED_LACKING_M2PS4, MENDED_M2, MENDED_M2PS2};
use super::memory::Memory;
use super::sum::Sum;
use super::tie::Tie;
use super::vector::{scaled, sum};
use super::{
    LONGEST_OUTLIER_S, MAXIMUM_ALTITUDE_M, MAXIMUM_SPEED_MPS, OUTLIERS, Phase, StrapdownError,
    VerticalChannel,
};
use crate::guard::Guard;
use crate::time::seconds_between;

/// A fix that moves the altitude by more than five of the sigmas after it must be confirmed by the next one:
/// after an outage the gate passes outliers of tens of metres, and their distribution is not normal.
const CONFIRMED_SIGMAS_SQUARED: f32 = 25.0;

impl VerticalChannel {
    /// Takes an altitude of the reference, metres, in captive flight or while a gap is mended.
    ///
    /// # Errors
    /// [`StrapdownError::Launched`], [`StrapdownError::NotFinite`], [`StrapdownError::Implausible`],
    /// [`StrapdownError::NoVertical`], [`StrapdownError::OutOfOrder`]; nothing has changed then.
    /// [`StrapdownError::Outlier`].
    pub fn reference(&mut self, time_us: u64, altitude_m: f32) -> Result<(), StrapdownError> {
        let is_captive = self.phase == Phase::Captive;
        if !is_captive && !self.is_mending() {
            return Err(StrapdownError::Launched);
        }
        if !altitude_m.is_finite() {
            return Err(StrapdownError::NotFinite);
        }
        if altitude_m.abs() > MAXIMUM_ALTITUDE_M {
            return Err(StrapdownError::Implausible);
        }
        if self.last.is_none() {
            return Err(StrapdownError::NoVertical);
        }
        if is_captive && self.anchor.is_empty() {
            self.begin_tie(time_us, altitude_m);
            return Ok(());
        }
        if time_us <= self.anchor_time_us {
            return Err(StrapdownError::OutOfOrder);
        }
        let step_s = seconds_between(self.anchor_time_us, time_us);
        let residual_m = altitude_m - self.altitude.value();
        let moved = if Guard::TieKnowsGaps.stands() {
            self.pass_tie(time_us);
            self.tie.fix(step_s, residual_m)
        } else {
            let mut memory = self.anchor;
            memory.count(step_s, self.config.anchor_window_s);
            Some(memory.parabola_gains(step_s).map(|gain| gain * residual_m))
        };
        let Some([moved_m, climb_rate, lacking]) = moved else {
            // In free flight a reference that contradicts the channel is never right. It is not worth waiting
            // for either: an error that no gap can have caused was there before, or is the reference's, and
            // must be seen.
            if !is_captive {
                self.drifted_m2 = self.tie.altitude_m2();
                return Err(StrapdownError::Outlier);
            }
            let (since_us, count) = self.outlying.unwrap_or((time_us, 0));
            let count = (count + 1).min(2 * OUTLIERS);
            self.outlying = Some((since_us, count));
            // Fixes that contradict a tie outweigh it once they have lasted longer than the tie's own fixes.
            let outweighs_s = LONGEST_OUTLIER_S.min(self.anchor.elapsed_s());
            let has_lasted = seconds_between(since_us, time_us) > outweighs_s;
            if count >= OUTLIERS && has_lasted {
                // The reference or the channel has moved: in either case the old tie is invalid.
                // The time since the first fix was spent aligning.
                self.anchor_before_s += self.anchor.elapsed_s() + step_s;
                self.anchor = Memory::default();
                self.begin_tie(time_us, altitude_m);
            }
            return Err(StrapdownError::Outlier);
        };
        // A fix that is taken outweighs two outliers; a tie to an outlier is outweighed by the other fixes.
        self.outlying =
            self.outlying.filter(|(_, count)| *count > 2).map(|(since_us, count)| (since_us, count - 2));
        self.anchor_time_us = time_us;
        self.anchor.count(step_s, self.config.anchor_window_s);
        self.altitude.add(moved_m);
        self.climb_rate.add(climb_rate);
        if is_captive {
            self.lacking_mps2.add(lacking);
            self.is_unconfirmed = moved_m * moved_m > CONFIRMED_SIGMAS_SQUARED * self.tie.altitude_m2();
            self.end_mending(MENDED_BY_CLIMB_M2PS2, MENDED_M2);
        } else {
            self.lack(lacking);
            // With a receiver that measures climb rates, the climb rate ends the mending.
            let has_climb =
                self.climb_fix_us.is_some_and(|fix_us| seconds_between(fix_us, time_us) < CLIMB_FIX_S);
            if !has_climb {
                self.end_mending(MENDED_M2PS2, f32::MAX);
            }
        }
        Ok(())
    }

    /// Takes the climb rate of the fix that [`Self::reference`] was just given, m/s, while a gap of free
    /// flight is mended: it shows at once what altitudes show after seconds. It is not used in captive
    /// flight, because the altitudes are enough there, and it would be one more source to trust.
    ///
    /// # Errors
    /// [`StrapdownError::Launched`], [`StrapdownError::NotFinite`], [`StrapdownError::OutOfOrder`]; nothing
    /// has changed then. [`StrapdownError::Outlier`].
    pub fn climb_rate_fix(&mut self, time_us: u64, climb_rate_mps: f32) -> Result<(), StrapdownError> {
        if !self.is_mending() {
            return Err(StrapdownError::Launched);
        }
        if !climb_rate_mps.is_finite() {
            return Err(StrapdownError::NotFinite);
        }
        // Not the fix to which the tie was propagated.
        if time_us != self.tie_time_us {
            return Err(StrapdownError::OutOfOrder);
        }
        let moved = self.tie.fix_climb(climb_rate_mps - self.climb_rate.value());
        let Some([moved_m, climb_rate, lacking]) = moved else { return Err(StrapdownError::Outlier) };
        self.altitude.add(moved_m);
        self.climb_rate.add(climb_rate);
        self.lack(lacking);
        self.climb_fix_us = Some(time_us);
        self.end_mending(MENDED_BY_CLIMB_M2PS2, MENDED_M2);
        Ok(())
    }

    /// Ends mending if climb rate and altitude are known to these variances and the level no longer pulls at
    /// the climb rate.
    fn end_mending(&mut self, climb_m2ps2: f32, altitude_m2: f32) {
        if self.tie.climb_m2ps2() <= climb_m2ps2
            && self.tie.altitude_m2() <= altitude_m2
            && self.tie.lacking_m2ps4() <= MENDED_LACKING_M2PS4
        {
            self.is_mending = false;
            self.climb_fix_us = None;
            self.bridged_m2ps2 = 0.0;
        }
    }

    /// Adds lacking upward acceleration, m/s^2, to the accelerometer's bias of free flight.
    fn lack(&mut self, lacking_mps2: f32) {
        if let (Phase::Free { accel_bias, .. }, Some(down)) = (&mut self.phase, &self.down) {
            *accel_bias = sum(*accel_bias, scaled(down.get(), lacking_mps2));
        }
    }

    /// Whether a gap of free flight is being mended, so that fixes are needed.
    #[must_use]
    pub fn is_mending(&self) -> bool {
        self.is_mending && matches!(self.phase, Phase::Free { .. })
    }

    /// Ties the altitude to its first fix. The search for the accelerometer's bias begins at the bias found
    /// so far.
    fn begin_tie(&mut self, time_us: u64, altitude_m: f32) {
        self.anchor.count(0.0, self.config.anchor_window_s);
        self.anchor_time_us = time_us;
        self.tie = Tie::START;
        self.tie_time_us = time_us;
        self.outlying = None;
        self.altitude = Sum::new(altitude_m);
        self.climb_rate = Sum::default();
    }

    pub(super) fn pass_tie(&mut self, time_us: u64) {
        self.tie.pass(seconds_between(self.tie_time_us, time_us));
        self.tie_time_us = time_us;
    }

    /// Climb rate and its variance, m/s and (m/s)^2, as soon as the reference has given any information about
    /// it, aligned or not.
    #[must_use]
    pub fn tied_climb_rate(&self) -> Option<(f32, f32)> {
        (self.phase != Phase::Lost && !self.anchor.is_empty())
            .then(|| (self.climb_rate.value(), self.tie.climb_m2ps2()))
    }

    /// In captive flight, ties altitude and climb rate again to a fix that contradicts them, metres and m/s,
    /// because their variances are wrong. The accelerometer's bias is kept if it was found before that;
    /// otherwise the search for it starts again.
    ///
    /// # Errors
    /// [`StrapdownError::Implausible`]; nothing has changed then.
    pub fn retie(
        &mut self,
        time_us: u64,
        altitude_m: f32,
        climb_rate_mps: f32,
    ) -> Result<(), StrapdownError> {
        // NaN is not plausible either.
        let is_plausible =
            altitude_m.abs() <= MAXIMUM_ALTITUDE_M && climb_rate_mps.abs() <= MAXIMUM_SPEED_MPS;
        if !is_plausible {
            return Err(StrapdownError::Implausible);
        }
        let is_known = self.anchor.elapsed_s() >= self.config.minimum_s;
        let tied = self.tie.retied();
        if !is_known {
            self.anchor_before_s += self.anchor.elapsed_s();
            self.anchor = Memory::default();
            self.lacking_mps2 = Sum::default();
        }
        self.begin_tie(time_us, altitude_m);
        self.climb_rate = Sum::new(climb_rate_mps);
        if is_known {
            self.tie = tied;
        }
        Ok(())
    }
}
