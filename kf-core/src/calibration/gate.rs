//! Decides which readings of a source are outliers, and when the filter itself is wrong.
//!
//! An innovation beyond [`GATE_SIGMAS`] is an outlier. Two mechanisms keep that from locking out a healthy
//! source:
//!
//! - The real size of its innovations is tracked by a mean of the NIS that no outlier can move much (a
//!   winsorised mean; P. J. Huber, "Robust Statistics", Wiley 1981). Where they are clearly larger than the
//!   model predicts, the gate grows with them, and so does the noise that the filter weighs the source with:
//!   the gate lets a noisy sensor in, and the weight keeps it from moving the others.
//! - Outliers that stay on one side are a level, not outliers: once they have outlasted what the filter's
//!   estimate rests on, or [`STEP_AFTER_US`], the estimate is given up.
//!
//! Outliers in quick succession put a source on probation: its readings are judged, but not taken, until some
//! fifty in a row have been within the gate. Readings of a broken source that are within the gate by chance
//! then move no other state.

use crate::guard::Guard;
use crate::time::seconds_between;

/// An innovation beyond this many sigmas is an outlier. A Gaussian one is so once in 5e8, or once in a
/// hundred days at 50 Hz, and the cut-off reduces a variance by 1e-7: the residual's sigma needs no
/// correction.
pub(super) const GATE_SIGMAS: f32 = 6.0;
/// An NIS is clipped at this many sigmas in the mean: for Gaussian innovations, with three, that reduces the
/// mean by 0.5 %.
const CLIPPED_SIGMAS: f32 = 3.0;
/// Memory of that mean, seconds. A second of nothing but outliers raises it by exp(8 / 20), and so the gate's
/// width by a fifth.
const MEMORY_S: f32 = 20.0;
/// Longest step of that mean, seconds.
const LONGEST_STEP_S: f32 = 5.0;
/// Up to this value the mean may be chance or a harmless inaccuracy of the model (innovations 1.4 times as
/// large as it predicts): the model is used as it is.
const TOLERATED_SPREAD: f32 = 2.0;
/// Largest error of the model that is accepted: a source with ten times its noise is not the source that was
/// modelled.
pub(super) const LARGEST_SPREAD: f32 = 100.0;
/// Fewest outliers in a row that overturn the estimate: two may be a glitch and its echo in a driver's
/// average.
const FEWEST_TO_OVERTURN: u32 = 3;
/// Outliers on one side for this long are a step, microseconds. A transient lasts a second; the gate's width
/// reaches the smaller steps sooner.
const STEP_AFTER_US: u64 = 5_000_000;
/// This many readings within the gate make up for one outlier. Rarer outliers, up to twice the share that a
/// good calibration may have, are refused one by one and cost no other readings.
const FITS_PER_OUTLIER: u32 = 20;
/// A lasting probation ends after 50 readings in a row within the gate. Noise of which the widest gate lets
/// in three quarters (any bits, around the level that it set last) gets there once in 2e6; a source of 50 Hz
/// that has recovered waits for a second.
const MOST_TO_MAKE_UP: u32 = FITS_PER_OUTLIER + 50;

/// How an outlier was treated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    /// As an outlier.
    Outlier,
    /// The readings are on a level of their own: the estimate for the source is void, and the next reading is
    /// to be accepted.
    Overturned,
}

/// One source's gate.
#[derive(Clone, Copy, Debug)]
pub(super) struct SourceGate {
    /// Winsorised mean of the NIS: 1 where the model is right.
    spread: f32,
    seen_us: Option<u64>,
    /// Readings taken since the source was last accepted again.
    taken: u32,
    /// Outliers in a row on the same side, the time of the first, and which side that is.
    run: u32,
    run_since_us: u64,
    is_above: bool,
    /// Readings within the gate that are still needed to make up for the outliers.
    to_make_up: u32,
    readings: u32,
    /// Of those: outliers, and readings that a level which was given up rested on.
    misfits: u32,
    /// A level that was well founded was given up.
    has_stepped: bool,
}

impl SourceGate {
    pub(super) const NEW: Self = Self {
        spread: 1.0,
        seen_us: None,
        taken: 0,
        run: 0,
        run_since_us: 0,
        is_above: false,
        to_make_up: 0,
        readings: 0,
        misfits: 0,
        has_stepped: false,
    };

    /// Factor by which the variance of the source's innovations exceeds the model's; gate and noise grow by
    /// it.
    #[inline(always)]
    pub(super) fn excess(&self) -> f32 {
        if self.spread <= TOLERATED_SPREAD { 1.0 } else { smaller(self.spread, LARGEST_SPREAD) }
    }

    /// Largest NIS that is taken.
    #[inline(always)]
    pub(super) fn limit(&self) -> f32 {
        GATE_SIGMAS * GATE_SIGMAS * self.excess()
    }

    /// Takes the NIS of a reading within the gate.
    #[inline]
    pub(super) fn take(&mut self, time_us: u64, nis: f32) {
        self.follow(time_us, nis);
        self.taken = self.taken.saturating_add(1);
        self.to_make_up = self.to_make_up.saturating_sub(1);
        self.run = 0;
    }

    /// Takes an outlier.
    #[inline(never)]
    pub(super) fn refuse(&mut self, time_us: u64, is_above: bool) -> Outcome {
        self.follow(time_us, f32::MAX);
        self.misfits = self.misfits.saturating_add(1);
        self.to_make_up = (self.to_make_up + FITS_PER_OUTLIER).min(MOST_TO_MAKE_UP);
        if self.run == 0 || is_above != self.is_above {
            (self.run, self.run_since_us, self.is_above) = (0, time_us, is_above);
        }
        self.run = self.run.saturating_add(1);
        let is_step = time_us.saturating_sub(self.run_since_us) >= STEP_AFTER_US;
        if self.run < FEWEST_TO_OVERTURN || (self.run <= self.taken && !is_step) {
            return Outcome::Outlier;
        }
        if self.run <= self.taken {
            self.has_stepped = true;
        } else {
            self.misfits = self.misfits.saturating_add(self.taken);
        }
        self.reset_estimate();
        Outcome::Overturned
    }

    /// Counts an invalid reading.
    pub(super) fn note_misfit(&mut self) {
        self.readings = self.readings.saturating_add(1);
        self.misfits = self.misfits.saturating_add(1);
    }

    /// Whether the next reading is only to be judged. The first one of a new level is taken: the bias is
    /// unknown, so the reading carries no information on the altitude.
    #[inline(always)]
    pub(super) const fn is_on_probation(&self) -> bool {
        self.to_make_up > FITS_PER_OUTLIER && self.taken > 0
    }

    /// Discards what is known of the source, including the spread of its innovations: they referred to what
    /// is now void.
    pub(super) fn reset_estimate(&mut self) {
        (self.taken, self.run, self.spread) = (0, 0, 1.0);
    }

    /// The source was lost: what was known of it is void. The outliers since then still count; otherwise a
    /// source that has come back on another level would be refused for ever.
    pub(super) fn restart(&mut self) {
        if self.taken > 0 {
            self.reset_estimate();
        }
    }

    /// Whether the source has ever been accepted for longer than a glitch lasts.
    pub(super) const fn is_established(&self) -> bool {
        self.readings.saturating_sub(self.misfits) > 10
    }

    #[inline]
    fn follow(&mut self, time_us: u64, nis: f32) {
        self.readings = self.readings.saturating_add(1);
        let seconds = self.seen_us.map_or(0.0, |seen_us| seconds_between(seen_us, time_us));
        self.seen_us = Some(time_us);
        let spread = if self.spread > 1.0 { self.spread } else { 1.0 };
        let clipped = smaller(nis, CLIPPED_SIGMAS * CLIPPED_SIGMAS * spread);
        self.spread += (clipped - self.spread) * (smaller(seconds, LONGEST_STEP_S) * (1.0 / MEMORY_S));
    }

    /// Whether the source has been consistent: no step, and no larger share of misfits than may be
    /// implausible.
    pub(super) fn is_consistent(&self, implausible_share: f32) -> bool {
        !self.has_stepped && self.misfits as f32 <= implausible_share * self.readings as f32
    }
}

/// `f32::min` of numbers, inlined: on the target the original is a call.
#[inline(always)]
const fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// Whether innovations are gated at all.
#[inline(always)]
pub(super) fn stands() -> bool {
    Guard::InnovationGate.stands()
}

#[cfg(test)]
mod tests {
    use super::{FITS_PER_OUTLIER, MOST_TO_MAKE_UP, Outcome, SourceGate};

    #[test]
    fn outliers_close_together_put_on_probation_until_enough_readings_fit() {
        let mut gate = SourceGate::NEW;
        for k in 0..100 {
            gate.take(20_000 * k, 1.0);
        }
        for k in 100..110 {
            assert_eq!(gate.is_on_probation(), k > 101, "{k}");
            assert_eq!(gate.refuse(20_000 * k, k % 2 == 0), Outcome::Outlier);
        }
        for k in 0..MOST_TO_MAKE_UP - FITS_PER_OUTLIER {
            assert!(gate.is_on_probation(), "{k}");
            gate.take(20_000 * u64::from(110 + k), 1.0);
        }
        assert!(!gate.is_on_probation());
    }

    #[test]
    fn rare_outliers_cost_no_readings_but_themselves() {
        let mut gate = SourceGate::NEW;
        for k in 0..1_000 {
            match k % 25 {
                24 => assert_eq!(gate.refuse(20_000 * k, k % 50 == 24), Outcome::Outlier),
                _ => gate.take(20_000 * k, 1.0),
            }
            assert!(!gate.is_on_probation(), "{k}");
        }
    }

    #[test]
    fn the_first_reading_of_a_new_level_is_taken() {
        let mut gate = SourceGate::NEW;
        for k in 1..3 {
            assert_eq!(gate.refuse(20_000 * k, true), Outcome::Outlier);
        }
        assert_eq!(gate.refuse(60_000, true), Outcome::Overturned);
        assert!(!gate.is_on_probation());
        gate.take(80_000, 1.0);
        assert!(gate.is_on_probation());
    }
}
