//! Events that are reported once, when they occur.

use kf_core::input::LaunchDoubt;
use kf_core::launch::WireCondition;
use kf_core::output::{Agreement, Trust};
use kf_core::quality::FailedChecks;
use kf_core::sensor::Sensor;
use survival::{Refusal, RestartReport, Start};

use super::{Telemetry, TickReport};
use crate::event::Event;
use crate::link::MessageKind;
use crate::rates::Rates;
use crate::sample::Sample;
use crate::schedule::Slot;

impl Telemetry<'_> {
    /// Reports how the flight computer has started, if there is something to report: the first texts, before
    /// those of the first tick.
    pub fn note_start(&mut self, report: &RestartReport) {
        let at_us = report.resumed_us;
        if report.start == Start::Cold {
            // A cold start does not inspect the copies: they may hold arbitrary contents of memory without a
            // battery.
            self.note(at_us, Event::Cold(report.cause));
            return;
        }
        if report.pause_us > 0 {
            self.note(at_us, Event::Standby { cause: report.cause, pause_us: report.pause_us });
        }
        let number = u8::try_from(report.restarts).unwrap_or(u8::MAX);
        self.note(at_us, Event::Restarted { number, cause: report.cause });
        for (copy, refusal) in (0..).zip(report.refused) {
            if let Some(refusal) = refusal.filter(|refusal| *refusal != Refusal::Empty) {
                self.note(at_us, Event::Refused { copy, refusal });
            }
        }
        let how = match report.start {
            Start::Resumed | Start::Suspected => {
                let gap_us = at_us.saturating_sub(report.snapshot_us.unwrap_or(at_us));
                Event::Resumed { gap_ms: u32::try_from(gap_us / 1_000).unwrap_or(u32::MAX) }
            }
            Start::Lost => Event::Lost,
            Start::Captive => Event::Captive,
            Start::Cold | Start::Standby => return,
        };
        self.note(at_us, how);
    }

    /// Records that the flight computer runs on its internal oscillator, because its crystal did not start.
    /// It is reported repeatedly, like the model's effects.
    pub const fn note_internal_clock(&mut self) {
        self.clock_is_internal = true;
    }

    /// Queues a tick's events.
    pub(super) fn note_events(&mut self, report: &TickReport<'_>, now_us: u64) {
        let output = report.output;
        if self.launch != Some(report.input.launch) {
            self.launch = Some(report.input.launch);
            self.schedule.at_once(Slot::Launch);
        }
        let doubt = report.input.launch_doubt;
        if core::mem::replace(&mut self.launch_doubt, doubt) != doubt
            && (doubt != LaunchDoubt::None || !report.input.launch)
        {
            self.note(now_us, Event::Launch(doubt));
        }
        if self.phase != Some(output.phase) {
            self.phase = Some(output.phase);
            self.schedule.at_once(Slot::Heartbeat);
        }
        if (!self.effects.is_empty() || self.clock_is_internal) && self.announcement_due.is_due(now_us) {
            self.announcement_due.sent(now_us, Rates::ANNOUNCE_US);
            if self.clock_is_internal {
                self.note(now_us, Event::InternalClock);
            }
            for k in 0..self.effects.len() {
                if let Some(id) = self.effects.get(k) {
                    let event = Event::Effect { number: k as u8, id: *id };
                    self.note(now_us, event);
                }
            }
        }
        if output.latched_now {
            self.note(now_us, Event::Latched { failed: output.failed_checks });
            for check in FailedChecks::from_bits(output.failed_checks).iter() {
                self.note(now_us, Event::Failed(check));
            }
        }
        self.note_trust(report, now_us);
        self.note_cross_check(report, now_us);
    }

    /// Reports a wire that is no longer usable for the launch decision, or is usable again.
    pub(super) fn note_wire(&mut self, wire: Option<WireCondition>, now_us: u64) {
        let was = core::mem::replace(&mut self.wire, wire);
        let is_none = |wire| matches!(wire, Some(WireCondition::Broken | WireCondition::Unreadable));
        if let Some(wire) = wire.filter(|wire| was != Some(*wire))
            && (is_none(was) || is_none(Some(wire)))
        {
            self.note(now_us, Event::Wire(wire));
        }
    }

    fn note_trust(&mut self, report: &TickReport<'_>, now_us: u64) {
        let output = report.output;
        for sensor in Sensor::ALL {
            let i = sensor.index();
            let (Some(out), Some(before)) = (output.sensors.get(i), self.trust.get_mut(i)) else { continue };
            let was = core::mem::replace(before, out.trust);
            if was == out.trust || !sensor.flies_free() {
                continue;
            }
            match out.trust {
                Trust::Doubtful | Trust::Untrustworthy | Trust::Unmonitored => {
                    let beyond =
                        if out.trust == Trust::Untrustworthy { &self.averages } else { &self.errors };
                    let value_m = beyond.get(i).and_then(Sample::latest).map_or(f32::NAN, |(_, value)| value);
                    let bound_m = report
                        .latch
                        .and_then(|latch| latch.sensors.get(i))
                        .map_or(f32::NAN, |latch| latch.bound_m());
                    self.note(now_us, Event::Trust { sensor, trust: out.trust, value_m, bound_m });
                }
                Trust::Trusted if was == Trust::Unmonitored => self.note(now_us, Event::Monitored(sensor)),
                Trust::Trusted | Trust::Calibrating => {}
            }
        }
    }

    /// Reports the flag of the cross-check, which exists only without a reference.
    fn note_cross_check(&mut self, report: &TickReport<'_>, now_us: u64) {
        let Some(check) = report.output.cross_check else { return };
        let agreement = check.agreement;
        if core::mem::replace(&mut self.agreement, agreement) == agreement {
            return;
        }
        let value_m = match agreement {
            Agreement::Disagree => check.moving_average_m,
            Agreement::Agree | Agreement::Doubtful => check.difference_m,
        };
        let free = |sensor: Sensor| report.latch.and_then(|latch| latch.sensors.get(sensor.index()));
        let bound_m = match (free(Sensor::ImuSlave), free(Sensor::Baro)) {
            (Some(slave), Some(baro)) => libm::sqrtf(slave.bound_m2 + baro.bound_m2),
            _ => f32::NAN,
        };
        self.note(now_us, Event::CrossCheck { agreement, value_m, bound_m });
    }

    fn note(&mut self, now_us: u64, event: Event) {
        if !self.events.push(now_us, event) {
            self.link.count_lost(MessageKind::StatusText);
        }
    }
}
