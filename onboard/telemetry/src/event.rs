//! Events: reported once, as a text, with time and cause.

use heapless::Deque;
use kf_core::effect::EffectId;
use kf_core::input::LaunchDoubt;
use kf_core::launch::WireCondition;
use kf_core::output::{Agreement, Trust};
use kf_core::quality::{Check, FailedChecks};
use kf_core::sensor::Sensor;
use mavlink::dialects::common::{MavSeverity, STATUSTEXT_DATA};
use survival::{Cause, Refusal};

use crate::message::status_text;
use crate::text::Text;

/// Largest number of waiting events: a restart that lost the calibration, a latch with every check failed,
/// every flag and eight effects.
const EVENTS: usize = 32;

/// An event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// The calibration was latched, with this many failed checks.
    Latched {
        /// Bits of [`FailedChecks`].
        failed: u16,
    },
    /// One of the failed checks.
    Failed(Check),
    /// A sensor's trust changed.
    Trust {
        /// The sensor.
        sensor: Sensor,
        /// Its new trust.
        trust: Trust,
        /// The error (doubtful) or its moving average (untrustworthy) that exceeded the alarm limit, metres.
        value_m: f32,
        /// The alarm limit, metres.
        bound_m: f32,
    },
    /// A sensor that was unmonitored has a reference again.
    Monitored(Sensor),
    /// The agreement of the two sensors that fly free changed, without a reference.
    CrossCheck {
        /// The new agreement.
        agreement: Agreement,
        /// Their difference (doubtful) or its moving average (disagree) that exceeded the limit, metres.
        value_m: f32,
        /// The limit, metres.
        bound_m: f32,
    },
    /// The certainty of the launch changed.
    Launch(LaunchDoubt),
    /// The umbilical's wire is no longer usable for the launch decision, or is usable again.
    Wire(WireCondition),
    /// The flight computer was restarted.
    Restarted {
        /// Number of restarts since power-on, this one included; 255 means 255 or more.
        number: u8,
        /// Cause of the restart.
        cause: Cause,
    },
    /// A copy of the kept state was refused.
    Refused {
        /// Index of the copy.
        copy: u8,
        /// Reason for the refusal.
        refusal: Refusal,
    },
    /// The restarted mission continued with the latched calibration.
    Resumed {
        /// Time from the copy to the time at which the clock continues, milliseconds: nothing is known of it.
        gap_ms: u32,
    },
    /// It was in free flight, and no copy of the calibration was valid.
    Lost,
    /// It was in captive flight: the calibration starts again.
    Captive,
    /// The flight computer started after this cause, and uses nothing of the kept state.
    Cold(Cause),
    /// It keeps crashing, the last time by this cause, and stands by before the mission continues.
    Standby {
        /// Cause of the last crash.
        cause: Cause,
        /// Length of the standby, microseconds.
        pause_us: u64,
    },
    /// It runs on its internal oscillator, because the crystal did not start.
    InternalClock,
    /// The effect that a coefficient belongs to.
    Effect {
        /// The number in the name of the coefficient.
        number: u8,
        /// The effect.
        id: EffectId,
    },
}

impl Event {
    /// The event's message. `time_us` is the time of the event, not of the sending.
    ///
    /// | event | severity | text |
    /// |---|---|---|
    /// | latch, good | notice | `t=130.000 latched good` |
    /// | latch, degraded | warning | `t=130.000 latched degraded, 2 checks failed` |
    /// | each failed check | warning | `t=130.000 failed check settled` |
    /// | doubtful | warning | `t=137.600 baro doubtful -40.4>40.3m`: error and alarm limit |
    /// | untrustworthy | error | `t=139.100 baro untrustworthy -41.0>40.3m`: moving average and alarm limit |
    /// | unmonitored | warning | `t=150.000 baro unmonitored: no reference` |
    /// | monitored again | notice | `t=152.000 baro monitored again` |
    /// | both sensors, without a reference | notice, warning, error | `t=160.000 baro-imu_slave doubtful 30.2>29.9m`, `agree`, `disagree` (moving average) |
    /// | launch suspected | warning | `t=129.995 launch suspected, calibration held` |
    /// | suspicion withdrawn | notice | `t=130.105 launch not confirmed, calibrating` |
    /// | launched, without confirmation | warning | `t=130.105 launched, not confirmed` |
    /// | the wire was found broken; unreadable | warning | `t=130.400 umbilical's wire broken` |
    /// | the wire is whole again | notice | `t=131.000 umbilical's wire closed` |
    /// | restart, its number since power-on, and its cause | error | `t=140.000 restart 2: a panic` |
    /// | a copy that was refused, and why | critical | `t=140.000 copy 0 refused: corrupt` |
    /// | restart in free flight, and the unknown time | error | `t=140.000 resumed, 0.150s not known` |
    /// | the same without a valid copy | critical | `t=140.000 calibration lost in the restart` |
    /// | restart in captive flight | warning | `t=140.000 calibration starts again` |
    /// | start without the kept state, and its cause | notice | `t=0.000 cold start: a loss of power` |
    /// | too many crashes | emergency | `t=140.000 standby 2s: a hard fault` |
    /// | no crystal | error | `t=0.000 no crystal: clock 1% to 4% off` |
    /// | coefficient's effect | info | `c_0 is baro.dynamic_pressure` |
    #[inline(never)]
    pub fn message(&self, time_us: u64) -> STATUSTEXT_DATA {
        let at = || *Text::new().text("t=").seconds(time_us).text(" ");
        let (severity, text) = match *self {
            Self::Latched { failed } => {
                let failed = FailedChecks::from_bits(failed).iter().count() as u64;
                match failed {
                    0 => (MavSeverity::MAV_SEVERITY_NOTICE, *at().text("latched good")),
                    _ => (
                        MavSeverity::MAV_SEVERITY_WARNING,
                        *at().text("latched degraded, ").number(failed).text(" checks failed"),
                    ),
                }
            }
            Self::Failed(check) => {
                (MavSeverity::MAV_SEVERITY_WARNING, *at().text("failed check ").text(check.name()))
            }
            Self::Trust { sensor, trust: Trust::Unmonitored, .. } => (
                MavSeverity::MAV_SEVERITY_WARNING,
                *at().text(sensor.name()).text(" unmonitored: no reference"),
            ),
            Self::Trust { sensor, trust, value_m, bound_m } => (
                match trust {
                    Trust::Untrustworthy => MavSeverity::MAV_SEVERITY_ERROR,
                    _ => MavSeverity::MAV_SEVERITY_WARNING,
                },
                *at()
                    .text(sensor.name())
                    .text(" ")
                    .text(trust.name())
                    .text(" ")
                    .metres(value_m)
                    .text(">")
                    .metres(bound_m)
                    .text("m"),
            ),
            Self::Monitored(sensor) => {
                (MavSeverity::MAV_SEVERITY_NOTICE, *at().text(sensor.name()).text(" monitored again"))
            }
            Self::CrossCheck { agreement, value_m, bound_m } => (
                match agreement {
                    Agreement::Agree => MavSeverity::MAV_SEVERITY_NOTICE,
                    Agreement::Doubtful => MavSeverity::MAV_SEVERITY_WARNING,
                    Agreement::Disagree => MavSeverity::MAV_SEVERITY_ERROR,
                },
                *at()
                    .text("baro-imu_slave ")
                    .text(agreement.name())
                    .text(" ")
                    .metres(value_m)
                    .text(if agreement == Agreement::Agree { "<" } else { ">" })
                    .metres(bound_m)
                    .text("m"),
            ),
            Self::Wire(wire) => {
                let severity = match wire {
                    WireCondition::Closed | WireCondition::Open => MavSeverity::MAV_SEVERITY_NOTICE,
                    WireCondition::Broken | WireCondition::Unreadable => MavSeverity::MAV_SEVERITY_WARNING,
                };
                (severity, *at().text("umbilical's wire ").text(wire.name()))
            }
            Self::Launch(LaunchDoubt::Suspected) => {
                (MavSeverity::MAV_SEVERITY_WARNING, *at().text("launch suspected, calibration held"))
            }
            Self::Launch(LaunchDoubt::None) => {
                (MavSeverity::MAV_SEVERITY_NOTICE, *at().text("launch not confirmed, calibrating"))
            }
            Self::Launch(LaunchDoubt::Unconfirmed) => {
                (MavSeverity::MAV_SEVERITY_WARNING, *at().text("launched, not confirmed"))
            }
            Self::Restarted { number, cause } => (
                MavSeverity::MAV_SEVERITY_ERROR,
                *at().text("restart ").number(number.into()).text(": ").text(cause.name()),
            ),
            Self::Refused { copy, refusal } => (
                MavSeverity::MAV_SEVERITY_CRITICAL,
                *at().text("copy ").number(copy.into()).text(" refused: ").text(refusal.name()),
            ),
            Self::Resumed { gap_ms } => (
                MavSeverity::MAV_SEVERITY_ERROR,
                *at().text("resumed, ").seconds(u64::from(gap_ms) * 1_000).text("s not known"),
            ),
            Self::Lost => (MavSeverity::MAV_SEVERITY_CRITICAL, *at().text("calibration lost in the restart")),
            Self::Captive => (MavSeverity::MAV_SEVERITY_WARNING, *at().text("calibration starts again")),
            Self::Cold(cause) => {
                (MavSeverity::MAV_SEVERITY_NOTICE, *at().text("cold start: ").text(cause.name()))
            }
            Self::Standby { cause, pause_us } => (
                MavSeverity::MAV_SEVERITY_EMERGENCY,
                *at().text("standby ").number(pause_us / 1_000_000).text("s: ").text(cause.name()),
            ),
            Self::InternalClock => {
                (MavSeverity::MAV_SEVERITY_ERROR, *at().text("no crystal: clock 1% to 4% off"))
            }
            Self::Effect { number, id } => (
                MavSeverity::MAV_SEVERITY_INFO,
                *Text::new().text("c_").number(number.into()).text(" is ").text(id.name()),
            ),
        };
        status_text(severity, text.bytes())
    }
}

/// Events that wait for sending.
#[derive(Debug)]
pub struct Events {
    waiting: Deque<(u64, Event), EVENTS>,
}

impl Events {
    /// No events.
    pub const fn new() -> Self {
        Self { waiting: Deque::new() }
    }

    /// Adds an event. Returns whether there was room.
    #[must_use]
    pub fn push(&mut self, time_us: u64, event: Event) -> bool {
        self.waiting.push_back((time_us, event)).is_ok()
    }

    /// Whether no event waits.
    pub fn is_empty(&self) -> bool {
        self.waiting.is_empty()
    }

    /// The event that has waited longest, and its time.
    pub fn first(&self) -> Option<&(u64, Event)> {
        self.waiting.front()
    }

    /// Removes that event.
    pub fn forget_first(&mut self) {
        self.waiting.pop_front();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(event: Event, time_us: u64) -> (MavSeverity, String) {
        let message = event.message(time_us);
        (message.severity, message.text.to_str().unwrap().to_owned())
    }

    #[test]
    fn says_what_the_table_says() {
        let trust = |trust| Event::Trust { sensor: Sensor::Baro, trust, value_m: -40.41, bound_m: 40.33 };
        for (event, severity, text) in [
            (Event::Latched { failed: 0 }, 5, "t=130.000 latched good"),
            (Event::Latched { failed: 5 }, 4, "t=130.000 latched degraded, 2 checks failed"),
            (Event::Failed(Check::Settled), 4, "t=130.000 failed check settled"),
            (trust(Trust::Doubtful), 4, "t=130.000 baro doubtful -40.4>40.3m"),
            (trust(Trust::Untrustworthy), 3, "t=130.000 baro untrustworthy -40.4>40.3m"),
            (trust(Trust::Unmonitored), 4, "t=130.000 baro unmonitored: no reference"),
            (
                Event::CrossCheck { agreement: Agreement::Disagree, value_m: 30.2, bound_m: 29.9 },
                3,
                "t=130.000 baro-imu_slave disagree 30.2>29.9m",
            ),
            (
                Event::CrossCheck { agreement: Agreement::Agree, value_m: -0.2, bound_m: 29.9 },
                5,
                "t=130.000 baro-imu_slave agree -0.2<29.9m",
            ),
            (Event::Launch(LaunchDoubt::Suspected), 4, "t=130.000 launch suspected, calibration held"),
            (Event::Launch(LaunchDoubt::None), 5, "t=130.000 launch not confirmed, calibrating"),
            (Event::Launch(LaunchDoubt::Unconfirmed), 4, "t=130.000 launched, not confirmed"),
            (Event::Wire(WireCondition::Broken), 4, "t=130.000 umbilical's wire broken"),
            (Event::Wire(WireCondition::Closed), 5, "t=130.000 umbilical's wire closed"),
            (Event::Restarted { number: 2, cause: Cause::Panic }, 3, "t=130.000 restart 2: a panic"),
            (Event::Refused { copy: 1, refusal: Refusal::Corrupt }, 2, "t=130.000 copy 1 refused: corrupt"),
            (Event::Resumed { gap_ms: 150 }, 3, "t=130.000 resumed, 0.150s not known"),
            (Event::Lost, 2, "t=130.000 calibration lost in the restart"),
            (Event::Captive, 4, "t=130.000 calibration starts again"),
            (Event::Cold(Cause::Supply), 5, "t=130.000 cold start: a loss of power"),
            (
                Event::Standby { cause: Cause::HardFault, pause_us: 16_000_000 },
                0,
                "t=130.000 standby 16s: a hard fault",
            ),
            (Event::InternalClock, 3, "t=130.000 no crystal: clock 1% to 4% off"),
            (Event::Monitored(Sensor::ImuSlave), 5, "t=130.000 imu_slave monitored again"),
            (
                Event::Effect { number: 0, id: EffectId::BaroDynamicPressure },
                6,
                "c_0 is baro.dynamic_pressure",
            ),
        ] {
            let (severity_sent, said) = said(event, 130_000_999);
            assert_eq!((severity_sent as u8, said.as_str()), (severity, text));
        }
    }

    const CAUSES: [Cause; 8] = [
        Cause::Unrecorded,
        Cause::Panic,
        Cause::HardFault,
        Cause::StackOverflow,
        Cause::Stuck,
        Cause::Supply,
        Cause::ResetPin,
        Cause::IndependentWatchdog,
    ];
    const REFUSALS: [Refusal; 5] =
        [Refusal::Empty, Refusal::Corrupt, Refusal::OtherModel, Refusal::NotUnderstood, Refusal::OtherLaunch];

    #[test]
    fn every_text_fits_with_a_day_of_flight() {
        let day_us = 99_999_999_000;
        let mut longest = 0;
        let mut take = |event: Event| longest = longest.max(said(event, day_us).1.len());
        take(Event::Latched { failed: 0x3ff });
        Check::ALL.into_iter().for_each(|check| take(Event::Failed(check)));
        EffectId::ALL.iter().for_each(|id| take(Event::Effect { number: 7, id: *id }));
        for sensor in Sensor::ALL.into_iter().filter(|sensor| sensor.flies_free()) {
            for trust in [Trust::Trusted, Trust::Doubtful, Trust::Untrustworthy, Trust::Unmonitored] {
                take(Event::Trust { sensor, trust, value_m: -99_999.0, bound_m: 99_999.0 });
            }
            take(Event::Monitored(sensor));
        }
        for agreement in [Agreement::Agree, Agreement::Doubtful, Agreement::Disagree] {
            take(Event::CrossCheck { agreement, value_m: -99_999.0, bound_m: 99_999.0 });
        }
        for doubt in [LaunchDoubt::None, LaunchDoubt::Suspected, LaunchDoubt::Unconfirmed] {
            take(Event::Launch(doubt));
        }
        for wire in
            [WireCondition::Closed, WireCondition::Open, WireCondition::Broken, WireCondition::Unreadable]
        {
            take(Event::Wire(wire));
        }
        for cause in CAUSES {
            take(Event::Restarted { number: u8::MAX, cause });
            take(Event::Cold(cause));
            take(Event::Standby { cause, pause_us: 16_000_000 });
        }
        for refusal in REFUSALS {
            take(Event::Refused { copy: 1, refusal });
        }
        take(Event::Resumed { gap_ms: u32::MAX });
        take(Event::Lost);
        take(Event::Captive);
        // A text of fifty bytes may have been cut.
        assert!(longest < crate::text::MAX_TEXT, "{longest}");
    }
}
