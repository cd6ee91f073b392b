//! Whether the reference stayed on one level in captive flight.
//!
//! A receiver's altitude comes from the code, its climb rate from Doppler. The altitude less the integrated
//! climb rate is a level that moves only with the receiver's error, and that is slow. If it moves suddenly by
//! more, the receiver was wrong before or is wrong since, and nothing on board can tell which. A step of a
//! few metres is within the gate of single fixes, and must be detected by a mean of several.

use crate::config::ReferenceConfig;
use crate::gauss_markov::recent_variance_factor;
use crate::reference::AcceptedFix;

/// Memory of the present level, seconds: several fixes, so that a single one makes no level.
const NOW_S: f32 = 0.5;
/// Memory of the previous level, seconds. After a jump the two differ by up to 0.65 of it, with eight times
/// the shorter memory; and it is so short that the receiver's wander and the climb rate's error hardly add to
/// that.
pub(super) const BEFORE_S: f32 = 4.0;
/// A fix is clipped at this many of its sigmas: one or two that are off by kilometres make no level either.
const CLIPPED_SIGMAS: f32 = 2.0;
/// Beyond this many sigmas the levels differ: a Gaussian does so once in 150,000 values, and an hour has a
/// thousand independent ones.
const JUMP_SIGMAS: f32 = 4.5;

/// The reference's level in captive flight.
#[derive(Clone, Debug)]
pub(super) struct ReferenceLevel {
    now_m: f32,
    /// NaN before the first fix.
    before_m: f32,
    /// The previous level as the calibration began; NaN if there was none.
    settling_m: f32,
    has_jumped: bool,
}

impl ReferenceLevel {
    pub(super) const NEW: Self =
        Self { now_m: 0.0, before_m: f32::NAN, settling_m: f32::NAN, has_jumped: false };

    /// Forgets the levels; [`Self::restart`] replaces the settling time's. The argument: whether one of them
    /// has jumped.
    pub(super) const fn forget(&mut self, has_jumped: bool) {
        self.before_m = f32::NAN;
        self.has_jumped = has_jumped;
    }

    pub(super) const fn has_jumped(&self) -> bool {
        self.has_jumped
    }

    /// Makes the next fix the level: the calibration begins. Jumps seen so far are kept.
    pub(super) const fn restart(&mut self) {
        self.settling_m = self.before_m;
        self.before_m = f32::NAN;
    }

    /// Whether the level leads back to the one of the settling time, if there was one. If so, the level
    /// between was a false one.
    pub(super) fn leads_back(&self) -> bool {
        let Self { now_m, before_m, settling_m, .. } = *self;
        // Its distance from that level is larger than the false one's, or equal; NaN is neither.
        let leads_away = (now_m - before_m) * ((now_m - settling_m) + (before_m - settling_m)) >= 0.0;
        !leads_away
    }

    /// Takes a fix and returns whether the level has changed. `counts`: the fix has no excuse to move. A fix
    /// with an excuse makes no level.
    #[inline(never)]
    pub(super) fn follow(&mut self, config: &ReferenceConfig, fix: &AcceptedFix, counts: bool) -> bool {
        let (Some(climb), Some(level_m)) = (&config.climb_rate, fix.altitude_minus_climb_m) else {
            return false;
        };
        let (Some(seconds), false, true) = (fix.interval_s, self.before_m.is_nan(), counts) else {
            // The altitude in the meantime is unknown.
            (self.now_m, self.before_m) = (level_m, if counts { level_m } else { f32::NAN });
            return false;
        };
        let share = |memory_s: f32| if seconds < memory_s { seconds / memory_s } else { 1.0 };
        let longest_m = CLIPPED_SIGMAS * config.sigma_m;
        let clipped = |by_m: f32| match by_m.abs() > longest_m {
            true if by_m > 0.0 => longest_m,
            true => -longest_m,
            false => by_m,
        };
        self.now_m += clipped(level_m - self.now_m) * share(NOW_S);
        self.before_m += clipped(level_m - self.before_m) * share(BEFORE_S);
        // The part of the wander that is younger than the longer memory, and half of that memory of the climb
        // rate's random walk.
        let variance_m2 =
            config.sigma_m * config.sigma_m * recent_variance_factor(BEFORE_S, config.correlation_time_s)
                + climb.sigma_mps * climb.sigma_mps * climb.correlation_time_s * BEFORE_S;
        let apart_m = self.now_m - self.before_m;
        let is_apart = apart_m * apart_m > JUMP_SIGMAS * JUMP_SIGMAS * variance_m2;
        self.has_jumped |= is_apart;
        is_apart
    }
}
