//! Which part of a log is analysed, as text and for other programs.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::extent::Unused;
use super::{CalibrationSource, Replay, WildCells};

/// Which part of a log is analysed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Usage {
    /// Whether the flight records its own launch.
    pub has_launch: bool,
    /// Number of flights in the log; 0 where the log records its own launch, or shows none.
    pub flights: usize,
    /// Number of the analysed one, from 1.
    pub flight: Option<usize>,
    /// When it took off, seconds; null where that is not in the log.
    pub take_off_s: Option<f64>,
    /// When it landed, seconds; null where that is not in the log.
    pub landing_s: Option<f64>,
    /// Share of the log's time that is analysed.
    pub used_share: f64,
    /// What is not analysed, and why.
    pub unused: Vec<Unused>,
    /// What else a user should know, one line each.
    pub remarks: Vec<String>,
}

impl Usage {
    /// The usage of a replay's log.
    #[must_use]
    pub fn of(replay: &Replay<'_>) -> Self {
        let extent = replay.extent();
        let unused = replay.unused();
        let interval = extent.interval();
        let mut remarks: Vec<String> = extent.several().into_iter().collect();
        if extent.is_given {
            remarks.push("take-off and landing are those given, not those found in the log".to_owned());
        }
        if let (CalibrationSource::Calmest(_), Some(_)) = (replay.source(), interval) {
            remarks.push("no quiet stretch: the calibration's checks show its quality".to_owned());
        }
        remarks.extend(replay.wild().iter().map(WildCells::sentence));
        Self {
            has_launch: super::has_launch(replay.flight()),
            flights: extent.airborne.len(),
            flight: extent.chosen.map(|chosen| chosen + 1),
            take_off_s: interval.and_then(|interval| interval.take_off_s),
            landing_s: interval.and_then(|interval| interval.landing_s),
            used_share: 1.0 - unused.iter().map(|part| part.share).sum::<f64>(),
            unused,
            remarks,
        }
    }

    /// The lines above a result: the remarks, and one for each part that is not used.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        self.remarks.iter().cloned().chain(self.unused.iter().map(Unused::text)).collect()
    }

    /// When it took off and landed, by the flight's own clock; `None` where the log does not show a flight.
    #[must_use]
    pub fn in_the_air(&self) -> Option<String> {
        self.flight?;
        let take_off = self.take_off_s.map_or_else(
            || "in the air when the log begins".to_owned(),
            |at_s| format!("take-off at {}", clock(at_s)),
        );
        let landing = self.landing_s.map_or_else(
            || "in the air when it ends".to_owned(),
            |at_s| format!("landing at {}", clock(at_s)),
        );
        Some(format!("{take_off}, {landing}"))
    }
}

/// Seconds of the flight's own clock as hours, minutes and seconds, followed by the seconds for
/// `--calibrate`.
#[must_use]
pub fn clock(at_s: f64) -> String {
    let whole = at_s.round().max(0.0) as u64;
    format!("{:02}:{:02}:{:02} ({whole} s)", whole / 3600, whole / 60 % 60, whole % 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_is_said_as_a_clock_has_it_and_in_seconds() {
        assert_eq!(clock(0.4), "00:00:00 (0 s)");
        assert_eq!(clock(3_725.0), "01:02:05 (3725 s)");
        assert_eq!(clock(359_999.6), "100:00:00 (360000 s)");
    }

    /// The time in the air is reported as far as the log shows it.
    #[test]
    fn a_time_in_the_air_is_said_as_far_as_the_log_has_it() {
        let said = |flight, take_off_s, landing_s| {
            Usage { flight, take_off_s, landing_s, ..Usage::default() }.in_the_air()
        };
        assert_eq!(said(None, Some(60.0), Some(120.0)), None);
        assert_eq!(
            said(Some(1), Some(60.0), Some(125.0)).unwrap(),
            "take-off at 00:01:00 (60 s), landing at 00:02:05 (125 s)"
        );
        assert_eq!(
            said(Some(1), None, None).unwrap(),
            "in the air when the log begins, in the air when it ends"
        );
    }
}
