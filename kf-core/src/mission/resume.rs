//! A mission that continues after a restart.

use super::latching::{Decision, Latching};
use super::{Counters, Mission};
use crate::effect::{EffectSubject, Formulas, SignalTracker};
use crate::free_flight::WATCHED;
use crate::latch::{LatchRecord, collected};
use crate::output::{Phase, Trust};
use crate::sensor::Sensor;
use crate::snapshot::{Fields, MissionMark, MissionSnapshot, RaisedFlags, SnapshotError, Stage};
use crate::time::microseconds;

impl<const HEAD: usize, const TAIL: usize, const E: usize> Mission<HEAD, TAIL, E> {
    /// The mission's state for storage; `None` until a launch is at least suspected. The state held during a
    /// suspicion is what the launch will latch, except for what its confirmation changes: that is in
    /// [`Self::mark`].
    #[must_use]
    pub fn snapshot(&self) -> Option<MissionSnapshot> {
        let (first_us, latch) = (self.first_us?, self.latching.record()?);
        Some(MissionSnapshot {
            first_us,
            last_us: self.last_us,
            // A mission that resumes from a held state does so after the launch.
            launch_was: self.launch_was || self.latching.is_held(),
            latch: latch.clone(),
            free_flight: self.free_flight.kept(),
            cross_check: self.cross_check.trust(),
            signals: self.signals,
            formulas: self.formulas.kept(&self.config),
            tracker: self.tracker,
            fix_regressors_m: collected(self.fix_regressors_m.into_iter()),
            stuck: self.stuck,
            last_accepted_us: self.last_accepted_us,
            counters: self.counters,
        })
    }

    /// The mark that must be stored at every tick.
    #[must_use]
    #[inline]
    pub fn mark(&self) -> MissionMark {
        if let Some(bounce) = self.latching.bounce(self.last_us) {
            return MissionMark {
                stage: Stage::Suspected,
                flags: RaisedFlags::default(),
                failed_checks: bounce.failed_checks,
                suspicions: self.counters.launch_suspicions.wrapping_sub(1) as u8 % MissionMark::SUSPICIONS,
            };
        }
        MissionMark {
            stage: self.latching.stage(),
            flags: self.raised_flags(),
            failed_checks: self.latching.record().map_or(0, |latch| latch.failed_checks),
            suspicions: self.counters.launch_suspicions as u8 % MissionMark::SUSPICIONS,
        }
    }

    /// The flags raised so far.
    #[must_use]
    pub fn raised_flags(&self) -> RaisedFlags {
        if !self.latching.is_launched() {
            return RaisedFlags::default();
        }
        let flags = Sensor::ALL.into_iter().map(|sensor| (sensor, self.free_flight.flag(sensor)));
        let flags =
            flags.fold(RaisedFlags::default(), |flags, (sensor, flag)| flags.with_sensor(sensor, flag));
        flags.with_cross_check(Some(self.cross_check.trust()))
    }

    /// Derives what is not in a snapshot from what is.
    fn resume(&mut self, cross_check: Trust, flags: RaisedFlags) {
        if let Some(latch) = self.latching.record() {
            self.cross_check.begin(latch);
        }
        self.cross_check.raise(cross_check);
        for sensor in Sensor::ALL {
            if let Some(flag) = flags.of(sensor) {
                self.free_flight.raise(sensor, flag);
            }
        }
        if let Some(flag) = flags.of_cross_check() {
            self.cross_check.raise(flag);
        }
        self.phase = Phase::FreeFlight;
        self.counters.restarts = self.counters.restarts.saturating_add(1);
        self.is_resumed = true;
    }

    fn is_latch_ours(&self, latch: &LatchRecord) -> bool {
        latch.state.len() == HEAD + TAIL && latch.covariance.len() == (HEAD + TAIL) * (HEAD + TAIL + 1) / 2
    }

    fn are_signals_ours(&self, signals: &SignalTracker) -> bool {
        let effects = self.config.estimated_effects.iter().chain(&self.config.constant_effects);
        signals.is_for(effects.map(|effect| effect.id()), self.config.latitude_deg)
    }

    /// Restores the mission from the bytes of [`MissionSnapshot::to_bytes`], before the first tick, with the
    /// mark of the last tick before the interruption. Returns the snapshot's time, microseconds; the
    /// mission's clock must continue from there too.
    ///
    /// If the launch was confirmed after the snapshot, the snapshot becomes one of the launch. If it was not
    /// yet confirmed, the mission resumes as suspected; if that suspicion is withdrawn, the calibration
    /// starts again.
    ///
    /// The time between the snapshot and the first tick is a gap: the moving averages have no samples in it,
    /// and the regressors' integrals cross it on a straight line. If it is longer than the configuration's
    /// `lost_after_s`, the integrals are abandoned, and the sensors with such an effect are no longer
    /// monitored; their flags stay. [`crate::output::TickOutput::bridged_us`] reports the length of the gap.
    ///
    /// The bytes are read one field at a time, first to check that they are a snapshot of this mission, then
    /// into it: at a restart a whole snapshot does not fit on the stack.
    ///
    /// # Errors
    /// [`SnapshotError`]; the mission must then start normally, and nothing restored so far disturbs that.
    #[inline(never)]
    pub fn restore_snapshot(&mut self, bytes: &[u8], mark: &MissionMark) -> Result<u64, SnapshotError> {
        self.check_fields(Fields::of(bytes)?, mark)?;
        let mut fields = Fields::of(bytes)?;
        let (first_us, last_us, launch_was) = fields.times()?;
        self.read_latch(&mut fields)?;
        if !self.read_watches(&mut fields)? {
            self.latching = Latching::START;
            return Err(SnapshotError::OtherMission);
        }
        let cross_check = fields.cross_check()?;
        self.read_signals(&mut fields, last_us)?;
        self.read_formulas(&mut fields, last_us)?;
        self.tracker = fields.tracker()?;
        self.tracker.interrupt();
        let fix_regressors_m = fields.fix_regressors_m()?;
        for (kept_m, regressor_m) in self.fix_regressors_m.iter_mut().zip(&fix_regressors_m) {
            *kept_m = *regressor_m;
        }
        self.stuck = fields.stuck()?;
        self.last_accepted_us = fields.last_accepted_us()?;
        self.counters = fields.counters()?;
        (self.first_us, self.last_us, self.launch_was) = (Some(first_us), last_us, launch_was);
        self.resume(cross_check, mark.flags);
        self.apply_mark(mark);
        Ok(last_us)
    }

    /// Whether every field is valid and belongs to this mission and launch.
    #[inline(never)]
    fn check_fields(&self, mut fields: Fields<'_>, mark: &MissionMark) -> Result<(), SnapshotError> {
        fields.times()?;
        let mut is_ours = self.is_next_latch_ours(&mut fields)?;
        pass_watches(&mut fields)?;
        fields.cross_check()?;
        is_ours &= self.are_next_signals_ours(&mut fields)?;
        is_ours &= self.are_next_formulas_ours(&mut fields)?;
        fields.tracker()?;
        is_ours &= fields.fix_regressors_m()?.len() == E;
        fields.stuck()?;
        fields.last_accepted_us()?;
        let counters = fields.counters()?;
        fields.end()?;
        if is_ours { check_mark(&counters, mark) } else { Err(SnapshotError::OtherMission) }
    }

    // These are separate functions so that no two of the large fields are on the stack at once.

    #[inline(never)]
    fn read_latch(&mut self, fields: &mut Fields<'_>) -> Result<(), SnapshotError> {
        self.latching = Latching::Latched { record: fields.latch()?, decision: Decision::Launched };
        Ok(())
    }

    /// False if they do not belong to this configuration and latch.
    #[inline(never)]
    fn read_watches(&mut self, fields: &mut Fields<'_>) -> Result<bool, SnapshotError> {
        if let Some(latch) = self.latching.record() {
            self.free_flight.begin(&self.config, latch, 0.0);
        }
        self.free_flight.restore_standing(fields.standing()?);
        let mut are_ours = true;
        for place in 0..WATCHED.len() {
            are_ours &= self.free_flight.restore_watch(place, fields.watch()?.as_ref());
        }
        Ok(are_ours)
    }

    #[inline(never)]
    fn read_signals(&mut self, fields: &mut Fields<'_>, last_us: u64) -> Result<(), SnapshotError> {
        self.signals = fields.signals()?;
        self.signals.continue_after(last_us);
        Ok(())
    }

    #[inline(never)]
    fn read_formulas(&mut self, fields: &mut Fields<'_>, last_us: u64) -> Result<(), SnapshotError> {
        self.formulas.resume(&fields.formulas()?, last_us);
        Ok(())
    }

    #[inline(never)]
    fn are_next_formulas_ours(&self, fields: &mut Fields<'_>) -> Result<bool, SnapshotError> {
        Ok(Formulas::is_ours(&self.config, &fields.formulas()?))
    }

    #[inline(never)]
    fn is_next_latch_ours(&self, fields: &mut Fields<'_>) -> Result<bool, SnapshotError> {
        Ok(self.is_latch_ours(&fields.latch()?))
    }

    #[inline(never)]
    fn are_next_signals_ours(&self, fields: &mut Fields<'_>) -> Result<bool, SnapshotError> {
        Ok(self.are_signals_ours(&fields.signals()?))
    }

    /// Applies what is newer in the mark than in an earlier snapshot.
    fn apply_mark(&mut self, mark: &MissionMark) {
        let Latching::Latched { record, decision } = &mut self.latching else { return };
        record.failed_checks = mark.failed_checks;
        if mark.stage == Stage::Suspected {
            *decision = Decision::Suspected { unchecked: None, has_reacquired: false };
            // The filter is new: if it must calibrate after all, it settles first.
            self.phase = Phase::Settling;
            self.first_us = None;
        }
    }

    /// At the first tick after a restart: the time without data, microseconds. `last_us` is still the
    /// snapshot's.
    #[inline]
    pub(super) fn bridge(&mut self, time_us: u64) -> Option<u64> {
        if !self.is_resumed {
            return None;
        }
        self.is_resumed = false;
        let gap_us = time_us.saturating_sub(self.last_us);
        if gap_us > microseconds(self.config.reference.lost_after_s) {
            self.give_up_integrals();
        }
        Some(gap_us)
    }

    #[cold]
    fn give_up_integrals(&mut self) {
        self.signals.lose_integrals();
        self.formulas.lose_integrals();
        let free_flight = &mut self.free_flight;
        for effect in self.config.estimated_effects.iter().chain(&self.config.constant_effects) {
            if !effect.is_integrated() {
                continue;
            }
            match effect.id().subject() {
                EffectSubject::Sensor(sensor) => free_flight.stop(sensor),
                EffectSubject::Gps => Sensor::ALL.into_iter().for_each(|sensor| free_flight.stop(sensor)),
            }
        }
    }
}

/// Whether a snapshot with these counters belongs to the mark's launch.
fn check_mark(counters: &Counters, mark: &MissionMark) -> Result<(), SnapshotError> {
    let suspicions = counters.launch_suspicions as u8 % MissionMark::SUSPICIONS;
    if mark.stage == Stage::Captive || suspicions != mark.suspicions {
        return Err(SnapshotError::OtherLaunch);
    }
    Ok(())
}

#[inline(never)]
fn pass_watches(fields: &mut Fields<'_>) -> Result<(), SnapshotError> {
    fields.standing()?;
    for _ in WATCHED {
        fields.watch()?;
    }
    Ok(())
}
