//! Which readings of a source are outliers, and when it is the filter that is wrong.
//!
//! An innovation is an outlier beyond [`GATE_SIGMAS`]. Two things keep that from locking out a source that is
//! well:
//!
//! - How large its innovations really are is followed by a mean of the NIS that no outlier can move much (a
//!   winsorised mean; P. J. Huber, "Robust Statistics", Wiley 1981). Where they are clearly larger than the
//!   model says, the gate and the noise that the filter weighs the source with grow with them: the gate lets
//!   a noisy sensor in, and the weight keeps it from moving the others.
//! - Outliers that stay on one side are a level, not outliers: once they have outlasted what the filter's
//!   opinion rests on, or [`STEP_AFTER_US`], the opinion is given up.
//!
//! Outliers that come close together put a source on probation: its readings are judged, but not taken, until
//! some fifty in a row have been within the gate. What a broken source has within the gate by chance moves no
//! other's state.

use crate::guard::Guard;
use crate::time::seconds_between;

/// Beyond this many sigmas an innovation is an outlier. A Gaussian one is so once in 5e8, or once in a
/// hundred days at 50 Hz, and what is cut off takes 1e-7 off a variance: the residual's sigma needs no
/// correction.
pub(super) const GATE_SIGMAS: f32 = 6.0;
/// An NIS counts in their mean up to three sigmas: of Gaussian innovations that takes off 0.5 %.
const CLIPPED_SIGMAS: f32 = 3.0;
/// Memory of that mean, seconds. A second of nothing but outliers raises it by exp(8 / 20), and so the gate's
/// width by a fifth.
const MEMORY_S: f32 = 20.0;
/// Longest step of it, seconds.
const LONGEST_STEP_S: f32 = 5.0;
/// Up to this the mean may be chance or a harmless inaccuracy of the model (innovations 1.4 times as large as
/// it says): the model's word stands.
const TOLERATED_SPREAD: f32 = 2.0;
/// The model can be wrong by no more: a source with ten times its noise is not the one that the model is of.
pub(super) const LARGEST_SPREAD: f32 = 100.0;
/// Fewer outliers in a row overturn nothing: two may be a glitch and its echo in a driver's average.
const FEWEST_TO_OVERTURN: u32 = 3;
/// Outliers on one side for this long are a step, microseconds. A transient lasts a second; the gate's width
/// reaches the smaller steps sooner.
const STEP_AFTER_US: u64 = 5_000_000;
/// So many readings within the gate make up for one outlier: those that come more rarely, up to twice the
/// share that a good calibration may have, are refused one by one and cost no others.
const FITS_PER_OUTLIER: u32 = 20;
/// A probation that lasts ends after 50 readings in a row within the gate. Noise of which the widest gate
/// lets in three quarters (any bits, around the level that it set last) gets there once in 2e6; a source of
/// 50 Hz that is well again waits for a second.
const MOST_TO_MAKE_UP: u32 = FITS_PER_OUTLIER + 50;

/// What has come of an outlier.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    /// It is one.
    Outlier,
    /// The readings have a level of their own: what was believed of the source is void, and the next one is
    /// to be believed.
    Overturned,
}

/// One source's gate.
#[derive(Clone, Copy, Debug)]
pub(super) struct SourceGate {
    /// Winsorised mean of the NIS: 1 where the model is right.
    spread: f32,
    seen_us: Option<u64>,
    /// Readings taken since the source was last believed anew.
    taken: u32,
    /// Outliers in a row on the same side, the first one's time, and which side that is.
    run: u32,
    run_since_us: u64,
    is_above: bool,
    /// Readings within the gate that are missing to make up for the outliers.
    to_make_up: u32,
    readings: u32,
    /// Of those: outliers, and what a level that was given up rested on.
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

    /// By what factor the source's innovations have a larger variance than the model says: gate and noise
    /// grow by it.
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
        self.believe_anew();
        Outcome::Overturned
    }

    /// Counts a reading that was none.
    pub(super) fn note_misfit(&mut self) {
        self.readings = self.readings.saturating_add(1);
        self.misfits = self.misfits.saturating_add(1);
    }

    /// Whether the next reading is only to be judged. The first one of a new level is taken: nothing is known
    /// of the bias, so it says nothing of the altitude.
    #[inline(always)]
    pub(super) const fn is_on_probation(&self) -> bool {
        self.to_make_up > FITS_PER_OUTLIER && self.taken > 0
    }

    /// What is known of the source is void; how much its innovations seemed to spread as well, for they were
    /// against what is void.
    pub(super) fn believe_anew(&mut self) {
        (self.taken, self.run, self.spread) = (0, 0, 1.0);
    }

    /// The source was lost: what was known of it is void. The outliers since then still count, or one that
    /// has come back elsewhere would be refused for ever.
    pub(super) fn begin_anew(&mut self) {
        if self.taken > 0 {
            self.believe_anew();
        }
    }

    /// Whether the source has ever been believed for longer than a glitch lasts.
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

    /// Whether the source has been consistent: no step, and not more misfits than may be implausible.
    pub(super) fn is_consistent(&self, implausible_share: f32) -> bool {
        !self.has_stepped && self.misfits as f32 <= implausible_share * self.readings as f32
    }
}

/// `f32::min` of numbers, in place: on the target that is a call.
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
