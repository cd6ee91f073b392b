//! How the flight computer starts: cold, or where a reset has interrupted it.

use kf_core::snapshot::{MissionMark, RaisedFlags, SnapshotError, Stage};
use survival::{Flight, Found, History, Refusal, ResetSource, RestartReport, Start, TickMark, TickMarks};

use crate::board;
use crate::flown_model::{FINGERPRINT, FlownMission};
use crate::retained::Retained;

/// Looks at what was kept and counts the restart; `None` where there is nothing to say. Whether the mission
/// goes on, [`go_on`] finds out: whatever fails there has then been counted.
#[inline(never)]
pub fn notice(retained: &mut Retained) -> Option<RestartReport> {
    let found = Found {
        source: board::reset_source(),
        mark: retained.marks.newest(),
        crash: retained.crash.take(),
        umbilical_is_open: board::umbilical_is_open(),
    };
    let refused = retained.slots.recover(FINGERPRINT).refused;
    let mut report = RestartReport {
        start: Start::Cold,
        cause: found.cause(),
        crash: found.crash,
        mark: found.mark,
        snapshot_us: None,
        refused,
        resumed_us: 0,
        restarts: 0,
    };
    if !found.is_interrupted() {
        retained.history.keep(History::default());
        forget(retained);
        let has_copies = refused.iter().any(|refusal| *refusal != Some(Refusal::Empty));
        return (found.mark.is_some() || found.crash.is_some() || has_copies).then_some(report);
    }
    // Before the first tick there is no time to go on from.
    report.resumed_us = found.mark.map_or(0, |mark| mark.time_us.saturating_add(outage_us(&mark, &found)));
    let history = retained.history.get().with_restart(report.resumed_us);
    retained.history.keep(history);
    report.restarts = history.restarts;
    report.start = found.start(history.is_loop());
    if !needs_snapshot(report.start) {
        forget(retained);
    }
    Some(report)
}

/// Lets the mission go on from the newest copy that is a snapshot of it, if that is what the report says, and
/// corrects the report where there is none.
#[inline(never)]
pub fn go_on(mission: &mut FlownMission, retained: &mut Retained, report: &mut RestartReport) {
    let Some(mark) = report.mark.filter(|_| needs_snapshot(report.start)) else { return };
    let mark = MissionMark {
        stage: match mark.flight {
            Flight::Captive => Stage::Captive,
            Flight::Suspected => Stage::Suspected,
            Flight::Free => Stage::Launched,
        },
        flags: RaisedFlags::from_bits(mark.flags),
        failed_checks: mark.failed_checks,
        suspicions: mark.suspicions,
    };
    let recovered = retained.slots.recover(FINGERPRINT);
    for (place, payload) in recovered.places.into_iter().zip(recovered.payloads) {
        let Some(payload) = payload else { continue };
        match take_up(mission, payload, &mark) {
            Ok(snapshot_us) => {
                report.snapshot_us = Some(snapshot_us);
                return;
            }
            Err(why) => {
                if let Some(refusal) = report.refused.get_mut(place) {
                    *refusal = Some(why);
                }
            }
        }
    }
    report.start = match report.start {
        // What was held for it is gone; whether the UAV has left is found out as at any start.
        Start::Suspected => Start::Captive,
        _ => Start::Lost,
    };
    forget(retained);
}

/// Whether a start goes on from a snapshot.
const fn needs_snapshot(start: Start) -> bool {
    matches!(start, Start::Resumed | Start::Suspected)
}

/// The snapshot's time, if it is one of this mission and of this launch.
#[inline(never)]
fn take_up(mission: &mut FlownMission, payload: &[u8], mark: &MissionMark) -> Result<u64, Refusal> {
    match mission.go_on_from(payload, mark) {
        Ok(snapshot_us) => Ok(snapshot_us),
        Err(SnapshotError::OtherLaunch) => Err(Refusal::OtherLaunch),
        Err(_) => Err(Refusal::NotUnderstood),
    }
}

/// Nothing of another mission may be taken for this one's.
fn forget(retained: &mut Retained) {
    retained.slots.clear();
    *retained.marks = TickMarks::EMPTY;
}

/// From the last tick to the first one after the restart, microseconds. How long the supply was away, nobody knows.
fn outage_us(mark: &TickMark, found: &Found) -> u64 {
    let until_reset_us = match (&found.crash, found.source) {
        (Some(crash), _) => board::microseconds(crash.count.wrapping_sub(mark.count)).into(),
        (None, ResetSource::IndependentWatchdog) => board::INDEPENDENT_WATCHDOG_US,
        (None, ResetSource::Supply | ResetSource::Pin | ResetSource::Software) => 0,
    };
    until_reset_us + board::RESTART_US
}

/// Says what the start has come to, in the log.
pub fn log(report: &RestartReport) {
    defmt::error!(
        "restart {=u32} ({=str}) after {=str}; the clock goes on at {=u64} us",
        report.restarts,
        report.start.name(),
        report.cause.name(),
        report.resumed_us
    );
    if let Some(crash) = &report.crash {
        defmt::error!(
            "it was at {=u32:#010x}, called from {=u32:#010x}, in exception {=u16}; cfsr {=u32:#010x}, hfsr {=u32:#010x}, mmfar {=u32:#010x}, bfar {=u32:#010x}, late {=u8:#b}, {=str}:{=u32}",
            crash.pc,
            crash.lr,
            crash.exception,
            crash.cfsr,
            crash.hfsr,
            crash.mmfar,
            crash.bfar,
            crash.late,
            crash.file(),
            crash.line
        );
    }
    for (copy, refusal) in report.refused.iter().enumerate() {
        if let Some(refusal) = refusal.filter(|refusal| *refusal != Refusal::Empty) {
            defmt::error!("copy {=usize} of the snapshot is {=str}", copy, refusal.name());
        }
    }
    match report.start {
        Start::Lost => defmt::error!("the latched calibration is lost"),
        Start::Captive => defmt::warn!("the calibration starts again"),
        Start::Standby => defmt::error!("too many restarts: there is no mission any more"),
        Start::Cold => defmt::warn!("nothing of what was kept is used: a new flight"),
        Start::Suspected => defmt::warn!("a launch was suspected: the calibration is held"),
        Start::Resumed => {}
    }
}
