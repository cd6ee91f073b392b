//! How the flight computer starts: cold, or from where a reset interrupted it.

use kf_core::guard::Guard;
use kf_core::launch::CaptiveForce;
use kf_core::navigation::KeptInertial;
use kf_core::snapshot::SnapshotError;
use survival::{
    Cause, Flight, Found, History, PAYLOAD_BYTES, Refusal, ResetSource, RestartReport, SlotOrder, Start,
    WordMemory, captive_force, clear_marks, clear_slots, history, keep_history, newest_mark, read_slot,
    take_crash,
};

use crate::estimation::Retainable;
use crate::onboard::Onboard;
use crate::retention::{mission_mark, split_snapshot};

/// A board's facts about its last reset, and the durations of its resets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ResetFacts {
    /// What reset the processor.
    pub source: ResetSource,
    /// Whether the break-wire is open now; `None` if that cannot be determined.
    pub umbilical_is_open: Option<bool>,
    /// Counts of the board's free-running timer per microsecond.
    pub counts_per_us: u32,
    /// Time from the last feed of the independent watchdog to its reset, microseconds.
    pub independent_watchdog_us: u64,
    /// Time from the reset to the first tick, microseconds.
    pub restart_us: u64,
}

impl ResetFacts {
    /// Facts of the host: the timer counts microseconds, and a start takes as long as on the real board.
    #[must_use]
    pub const fn host(source: ResetSource, umbilical_is_open: Option<bool>) -> Self {
        Self {
            source,
            umbilical_is_open,
            counts_per_us: 1,
            independent_watchdog_us: 600_000,
            restart_us: 15_000,
        }
    }
}

/// What a start has found. Any failure from here on has been counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Assessment {
    /// The restart's report; `None` after a start that found nothing.
    pub report: Option<RestartReport>,
    /// The snapshot's copies.
    pub order: SlotOrder,
}

/// Inspects what was kept and counts the restart. [`resume_mission`] finds out whether the mission continues.
#[inline(never)]
pub fn assess_restart(
    memory: &mut impl WordMemory,
    model: u64,
    facts: &ResetFacts,
    buffer: &mut [u8; PAYLOAD_BYTES],
) -> Assessment {
    let found = Found {
        source: facts.source,
        mark: newest_mark(memory),
        crash: take_crash(memory),
        umbilical_is_open: facts.umbilical_is_open,
    };
    let order = SlotOrder::find(memory, model, buffer);
    let mut report = RestartReport {
        start: Start::Cold,
        cause: found.cause(),
        crash: found.crash,
        mark: found.mark,
        snapshot_us: None,
        refused: order.refused,
        resumed_us: 0,
        restarts: 0,
        pause_us: 0,
    };
    if !found.is_interrupted() {
        keep_history(memory, History::default());
        clear_slots(memory);
        // After an interruption the mark stays until the first tick writes another: a reset before that tick
        // finds the same mark.
        clear_marks(memory);
        let has_copies = order.refused.iter().any(|refusal| *refusal != Some(Refusal::Empty));
        let is_worth_it = found.mark.is_some() || found.crash.is_some() || has_copies;
        return Assessment { report: is_worth_it.then_some(report), order: SlotOrder::EMPTY };
    }
    let before = history(memory);
    let ended_us = ended_us(&found, &before, facts);
    let is_crash = !Guard::OnlyCrashesCount.stands() || is_crash(report.cause);
    let counted = before.with_restart(is_crash, ended_us, 0);
    report.pause_us = if is_crash { counted.pause_us() } else { 0 };
    let stands_by_for_ever = !Guard::StandbyEnds.stands() && report.pause_us > 0;
    report.resumed_us = ended_us.saturating_add(facts.restart_us).saturating_add(report.pause_us);
    report.restarts = counted.restarts;
    report.start = found.start(stands_by_for_ever);
    keep_history(memory, History { resumed_us: report.resumed_us, ..counted });
    if needs_snapshot(report.start) {
        return Assessment { report: Some(report), order };
    }
    clear_slots(memory);
    Assessment { report: Some(report), order: SlotOrder::EMPTY }
}

/// If the report requires it, continues the mission from the newest copy that is a snapshot of it, and
/// corrects the report if there is none. Returns the kept state of the inertial altitude, for
/// [`Onboard::resume`].
#[inline(never)]
pub fn resume_mission(
    mission: &mut impl Retainable,
    memory: &mut impl WordMemory,
    model: u64,
    assessment: &mut Assessment,
    buffer: &mut [u8; PAYLOAD_BYTES],
) -> Option<KeptInertial> {
    let Assessment { report: Some(report), order } = assessment else { return None };
    let mark = report.mark.filter(|_| needs_snapshot(report.start))?;
    let mark = mission_mark(&mark);
    for place in order.newest_first {
        let restored = read_slot(memory, place, model, buffer).and_then(|slot| {
            let of_mission = split_snapshot(slot.payload)
                .and_then(|(inertial, payload)| Ok((inertial, mission.restore_snapshot(payload, &mark)?)));
            of_mission.map_err(|error| match error {
                SnapshotError::OtherLaunch => Refusal::OtherLaunch,
                _ => Refusal::NotUnderstood,
            })
        });
        match restored {
            Ok((inertial, snapshot_us)) => {
                report.snapshot_us = Some(snapshot_us);
                order.use_copy(place);
                return inertial;
            }
            Err(why) => {
                if let Some(refusal) = report.refused.get_mut(place) {
                    *refusal = Some(why);
                }
            }
        }
    }
    report.start = match report.start {
        // The held calibration is gone; whether the UAV has left is determined as at any start.
        Start::Suspected => Start::Captive,
        _ => Start::Lost,
    };
    clear_slots(memory);
    *order = SlotOrder::EMPTY;
    None
}

/// Assumed length of a loss of the supply, seconds: a transient lasts a second at most. Its actual length is
/// not known on board.
const LONGEST_DIP_S: f32 = 1.0;

impl Onboard {
    /// Continues after a start, with the inertial altitude that [`resume_mission`] has found, and with what
    /// [`survival::keep_captive_force`] has kept in `memory`.
    #[inline(never)]
    pub fn resume(
        &mut self,
        report: Option<&RestartReport>,
        inertial: Option<&KeptInertial>,
        memory: &impl WordMemory,
    ) {
        let Some(report) = report else { return };
        let unknown_s = if report.cause == Cause::Supply { LONGEST_DIP_S } else { 0.0 };
        match report.start {
            Start::Resumed | Start::Lost => self.resume_in_free_flight(inertial, unknown_s),
            Start::Suspected => {
                let force = captive_force(memory).and_then(CaptiveForce::from_words);
                self.resume_suspected(inertial, unknown_s, force);
            }
            Start::Captive => {
                self.resume_captive(report.mark.is_some_and(|mark| mark.flight == Flight::CaptiveUnwired));
            }
            Start::Cold => self.note_traces(),
            Start::Standby => (),
        }
    }
}

/// Whether the program itself has failed. A reset without a record counts too, although it may be a
/// debugger's: a board that cannot start resets itself.
const fn is_crash(cause: Cause) -> bool {
    !matches!(cause, Cause::Supply | Cause::ResetPin)
}

/// Whether a start continues from a snapshot.
const fn needs_snapshot(start: Start) -> bool {
    matches!(start, Start::Resumed | Start::Suspected)
}

/// End of the last run by the mission's clock, as far as it is known. How long the supply was away is not
/// known.
fn ended_us(found: &Found, before: &History, facts: &ResetFacts) -> u64 {
    // Without a tick since the last restart, the timer's counts belong to different runs.
    let Some(mark) = found.mark.filter(|mark| mark.time_us >= before.resumed_us) else {
        return before.resumed_us;
    };
    let until_reset_us = match (&found.crash, found.source) {
        (Some(crash), _) => (crash.count.wrapping_sub(mark.count) / facts.counts_per_us.max(1)).into(),
        (None, ResetSource::IndependentWatchdog) => facts.independent_watchdog_us,
        (None, ResetSource::Supply | ResetSource::Pin | ResetSource::Software) => 0,
    };
    mark.time_us.saturating_add(until_reset_us)
}
