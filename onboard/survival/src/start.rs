//! Decides how the flight computer starts, from what a reset has left.

use serde::{Deserialize, Serialize};

use crate::crash::{Cause, CrashRecord};
use crate::tick_mark::{Flight, TickMark};

/// How the flight computer started.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Start {
    /// Power-on: nothing was kept, or nothing that may be used.
    Cold,
    /// It was reset in captive flight: the calibration starts again.
    Captive,
    /// It was reset in free flight, and the mission continues.
    Resumed,
    /// It was reset in free flight, and no snapshot is valid: the calibration is lost.
    Lost,
    /// It has crashed too often within too short a time, and the mission does not continue: only with
    /// `Guard::StandbyEnds` taken out.
    Standby,
    /// It was reset while a launch was suspected: the calibration is held, and the launch is still undecided.
    Suspected,
}

impl Start {
    /// The name used in logs and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Cold => "cold",
            Self::Captive => "captive",
            Self::Resumed => "resumed",
            Self::Lost => "lost",
            Self::Standby => "standby",
            Self::Suspected => "suspected",
        }
    }
}

/// What reset the processor, as far as the processor can tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResetSource {
    /// The supply was away or too low.
    Supply,
    /// The reset pin: a person, or a disturbance.
    Pin,
    /// The program itself, or a debugger.
    Software,
    /// The independent watchdog.
    IndependentWatchdog,
}

/// Evidence that a start finds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Found {
    /// What reset the processor.
    pub source: ResetSource,
    /// The last tick before the reset.
    pub mark: Option<TickMark>,
    /// The record of a crash.
    pub crash: Option<CrashRecord>,
    /// Whether the break-wire is open now; `None` if that cannot be determined.
    pub umbilical_is_open: Option<bool>,
}

impl Found {
    /// What ended the last run.
    #[must_use]
    pub fn cause(&self) -> Cause {
        match (self.crash, self.source) {
            (Some(crash), _) => crash.cause,
            (None, ResetSource::Supply) => Cause::Supply,
            (None, ResetSource::Pin) => Cause::ResetPin,
            (None, ResetSource::Software) => Cause::Unrecorded,
            (None, ResetSource::IndependentWatchdog) => Cause::IndependentWatchdog,
        }
    }

    /// Whether a mission was interrupted rather than ended. A reset by the flight computer itself always is
    /// an interruption. Any other may be the switch, the reset button or a debugger, with contents kept from
    /// another flight: it is an interruption unless the wire is closed, which it cannot be in free flight.
    #[must_use]
    pub fn is_interrupted(&self) -> bool {
        let by_itself = match self.source {
            ResetSource::IndependentWatchdog => true,
            ResetSource::Software => self.crash.is_some(),
            ResetSource::Supply | ResetSource::Pin => false,
        };
        (self.mark.is_some() || self.crash.is_some()) && (by_itself || self.umbilical_is_open != Some(false))
    }

    /// How to start: [`Start::Resumed`] and [`Start::Suspected`] require a valid snapshot.
    /// `stands_by_for_ever`: the guard that ends a standby is taken out.
    #[must_use]
    pub fn start(&self, stands_by_for_ever: bool) -> Start {
        match self.mark.map(|mark| mark.flight) {
            _ if !self.is_interrupted() => Start::Cold,
            _ if stands_by_for_ever => Start::Standby,
            Some(Flight::Free) => Start::Resumed,
            Some(Flight::Suspected) => Start::Suspected,
            Some(Flight::Captive | Flight::CaptiveUnwired) | None => Start::Captive,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOURCES: [ResetSource; 4] =
        [ResetSource::Supply, ResetSource::Pin, ResetSource::Software, ResetSource::IndependentWatchdog];

    fn found(source: ResetSource, flight: Flight, crashed: bool, open: Option<bool>) -> Found {
        Found {
            source,
            mark: Some(TickMark { time_us: 5, count: 0, flags: 0, failed_checks: 0, suspicions: 0, flight }),
            crash: crashed.then(|| CrashRecord::new(Cause::Panic)),
            umbilical_is_open: open,
        }
    }

    #[test]
    fn in_free_flight_every_reset_is_resumed() {
        for source in SOURCES {
            for crashed in [false, true] {
                for open in [Some(true), None] {
                    let found = found(source, Flight::Free, crashed, open);
                    assert_eq!(found.start(false), Start::Resumed, "{found:?}");
                    assert_eq!(found.start(true), Start::Standby, "{found:?}");
                    assert_eq!(Found { mark: None, ..found }.start(false) == Start::Captive, crashed);
                }
            }
        }
    }

    #[test]
    fn with_the_wire_closed_only_what_it_did_to_itself_is_an_interruption() {
        for (source, crashed, start) in [
            (ResetSource::Supply, false, Start::Cold),
            // A crash whose own reset did not come before the supply went away.
            (ResetSource::Supply, true, Start::Cold),
            (ResetSource::Pin, false, Start::Cold),
            (ResetSource::Pin, true, Start::Cold),
            // A debugger that has written another image.
            (ResetSource::Software, false, Start::Cold),
            // A launch with the wire stuck closed, and then a crash.
            (ResetSource::Software, true, Start::Resumed),
            (ResetSource::IndependentWatchdog, false, Start::Resumed),
        ] {
            let found = found(source, Flight::Free, crashed, Some(false));
            assert_eq!(found.start(false), start, "{found:?}");
        }
    }

    #[test]
    fn a_reset_while_a_launch_is_suspected_leaves_the_suspicion() {
        for source in SOURCES {
            let found = found(source, Flight::Suspected, false, Some(true));
            assert_eq!(
                (found.start(false), found.start(true)),
                (Start::Suspected, Start::Standby),
                "{found:?}"
            );
        }
        // Switched off and on under the pylon.
        let closed = found(ResetSource::Supply, Flight::Suspected, false, Some(false));
        assert_eq!(closed.start(false), Start::Cold);
    }

    #[test]
    fn a_reset_in_captive_flight_starts_the_calibration_again() {
        let crash = found(ResetSource::Software, Flight::Captive, true, Some(false));
        assert_eq!((crash.start(false), crash.start(true)), (Start::Captive, Start::Standby));
        assert_eq!(found(ResetSource::Supply, Flight::Captive, false, Some(false)).start(false), Start::Cold);
    }

    #[test]
    fn nothing_kept_is_a_cold_start_whatever_the_wire_says() {
        for source in SOURCES {
            for umbilical_is_open in [Some(true), Some(false), None] {
                let found = Found { source, mark: None, crash: None, umbilical_is_open };
                assert_eq!((found.start(false), found.start(true)), (Start::Cold, Start::Cold), "{found:?}");
            }
        }
    }

    #[test]
    fn the_cause_is_the_records_or_what_the_processor_says() {
        assert_eq!(found(ResetSource::Software, Flight::Free, true, None).cause(), Cause::Panic);
        let causes = SOURCES.map(|source| found(source, Flight::Free, false, None).cause());
        assert_eq!(causes, [Cause::Supply, Cause::ResetPin, Cause::Unrecorded, Cause::IndependentWatchdog]);
    }
}
