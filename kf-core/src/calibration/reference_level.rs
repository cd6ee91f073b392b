//! Whether the reference stayed on one level in captive flight.
//!
//! A receiver's altitude is code, its climb rate Doppler: the altitude less the integrated climb rate is a
//! level that moves only as the receiver's error does, and that is slow. Where it moves at once by more, the
//! receiver was wrong before or is wrong since, and nobody knows which. A level of a few metres less is
//! within the gate of single fixes, and has to be seen by a mean of some.

use crate::config::ReferenceConfig;
use crate::gauss_markov::recent_variance_factor;
use crate::reference::AcceptedFix;

/// Memory of the level as it is now, seconds: some fixes, so that one alone makes no level.
const NOW_S: f32 = 0.5;
/// Memory of the level as it was, seconds. Of a jump the two come to be 0.65 apart; with eight times the
/// shorter one, and so short that the receiver's wander and the climb rate's error hardly add to that.
pub(super) const BEFORE_S: f32 = 4.0;
/// A fix counts up to so many of its sigmas away: one or two that are off by kilometres make no level either.
const CLIPPED_SIGMAS: f32 = 2.0;
/// Beyond this many sigmas the levels are two: a Gaussian is once in 150,000 values, of which an hour has a
/// thousand independent ones.
const JUMP_SIGMAS: f32 = 4.5;

/// The reference's level in captive flight.
#[derive(Clone, Debug)]
pub(super) struct ReferenceLevel {
    now_m: f32,
    /// NaN before the first fix.
    before_m: f32,
    has_jumped: bool,
}

impl ReferenceLevel {
    pub(super) const NEW: Self = Self { now_m: 0.0, before_m: f32::NAN, has_jumped: false };

    /// Of nothing yet; whether it has jumped before that is known.
    pub(super) const fn new(has_jumped: bool) -> Self {
        Self { has_jumped, ..Self::NEW }
    }

    pub(super) const fn has_jumped(&self) -> bool {
        self.has_jumped
    }

    /// Makes the next fix the level. What was seen of others stays.
    pub(super) const fn begin_anew(&mut self) {
        self.before_m = f32::NAN;
    }

    /// Takes a fix; whether the level is not what it was. `counts`: it has no excuse to move. One that has
    /// makes no level.
    #[inline(never)]
    pub(super) fn follow(&mut self, config: &ReferenceConfig, fix: &AcceptedFix, counts: bool) -> bool {
        let (Some(climb), Some(level_m)) = (&config.climb_rate, fix.altitude_minus_climb_m) else {
            return false;
        };
        let (Some(seconds), false, true) = (fix.interval_s, self.before_m.is_nan(), counts) else {
            // Where the altitude was meanwhile, nobody knows.
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
        // Of the wander what is younger than the longer memory, and of the climb rate's random walk half of
        // that memory.
        let variance_m2 =
            config.sigma_m * config.sigma_m * recent_variance_factor(BEFORE_S, config.correlation_time_s)
                + climb.sigma_mps * climb.sigma_mps * climb.correlation_time_s * BEFORE_S;
        let apart_m = self.now_m - self.before_m;
        let is_apart = apart_m * apart_m > JUMP_SIGMAS * JUMP_SIGMAS * variance_m2;
        self.has_jumped |= is_apart;
        is_apart
    }
}
