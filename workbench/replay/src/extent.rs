//! Chooses the part of a log that is analysed: one flight, from the ground before its take-off to its
//! landing.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::error::ReplayError;
use super::given::{GivenAirborne, GivenTimes};
use super::window::WindowError;
use crate::airborne::{self, AirborneInterval, AirborneIntervals};
use flight_data::Flight;

/// Shortest unused part that is reported, seconds: less is a block of a second or two at either end.
const NOT_WORTH_SAYING_S: f64 = 5.0;

/// The part of a log that is analysed, and the flights that the log has.
#[derive(Clone, Debug, PartialEq)]
pub struct Extent {
    /// The log's first and last time, seconds.
    pub log_s: (f64, f64),
    /// Start and end of the analysed part, seconds; a row at the end is included.
    pub used_s: (f64, f64),
    /// Every time in the air; empty where the flight records its own launch.
    pub airborne: Vec<AirborneInterval>,
    /// Index of the one that is analysed.
    pub chosen: Option<usize>,
    /// Whether the user gave its take-off and landing.
    pub is_given: bool,
}

/// A part of a log that is not analysed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Unused {
    /// Start, seconds.
    pub from_s: f64,
    /// End, seconds.
    pub to_s: f64,
    /// Share of the whole log.
    pub share: f64,
    /// Why it is not analysed.
    pub reason: String,
}

impl Unused {
    /// As a line of text.
    #[must_use]
    pub fn text(&self) -> String {
        let seconds = self.to_s - self.from_s;
        format!(
            "not used: {seconds:.0} s ({:.1} %), from {:.0} s to {:.0} s: {}",
            100.0 * self.share,
            self.from_s,
            self.to_s,
            self.reason
        )
    }
}

impl Extent {
    /// All of a flight, for one that records its own launch.
    pub(super) fn all(flight: &Flight) -> Self {
        let times = || flight.time_s.iter().copied();
        let first_s = times().next().unwrap_or(0.0);
        let log_s = (first_s, times().fold(first_s, f64::max));
        Self { log_s, used_s: log_s, airborne: Vec::new(), chosen: None, is_given: false }
    }

    /// The flight with the take-off and landing that the user gives; else the one that the user's window is
    /// in, or the longest of the log.
    ///
    /// # Errors
    /// An invalid take-off and landing, or [`WindowError::AfterLanding`].
    pub(super) fn of(flight: &Flight, given: GivenTimes) -> Result<Self, ReplayError> {
        let mut extent = Self::all(flight);
        let mut found = airborne::find(flight);
        let window = given.calibration;
        if let Some(airborne) = given.airborne {
            airborne.check(flight)?;
            let (place, interval) = put(&mut found, airborne, extent.log_s);
            if let (Some(window), Some(landing_s)) = (window, interval.landing_s)
                && window.end_s > landing_s
            {
                return Err(WindowError::AfterLanding { window, landing_s }.into());
            }
            // The user's window is included, wherever it is.
            let from_s = interval.ground_from_s.unwrap_or(interval.from_s);
            let from_s = window.map_or(from_s, |window| from_s.min(window.start_s));
            extent.used_s = (from_s, interval.to_s);
            extent.chosen = Some(place);
            extent.airborne = found.airborne;
            extent.is_given = true;
            return Ok(extent);
        }
        let chosen = match window {
            None => found.longest(),
            Some(window) => {
                let around = found.around(window.start_s);
                let landing_s = |interval: &AirborneInterval| {
                    interval.landing_s.filter(|landing_s| *landing_s < window.end_s)
                };
                let landed_s = match (around, found.airborne.last()) {
                    (Some((_, interval)), _) => landing_s(&interval),
                    (None, last) => last.and_then(|interval| interval.landing_s),
                };
                if let Some(landing_s) = landed_s {
                    return Err(WindowError::AfterLanding { window, landing_s }.into());
                }
                around
            }
        };
        extent.airborne = found.airborne;
        if let Some((place, interval)) = chosen {
            extent.chosen = Some(place);
            let is_first = place == 0;
            let from_s = match interval.ground_from_s {
                _ if is_first => extent.log_s.0,
                Some(ground_s) => ground_s,
                None => interval.from_s,
            };
            extent.used_s = (from_s, interval.landing_s.unwrap_or(extent.end_s(place, &interval)));
        }
        Ok(extent)
    }

    /// End of a flight without a landing: the log's end, or the gap before the next flight.
    fn end_s(&self, place: usize, interval: &AirborneInterval) -> f64 {
        if place + 1 == self.airborne.len() { self.log_s.1 } else { interval.to_s }
    }

    /// The flight that is analysed, if the log shows one.
    #[must_use]
    pub fn interval(&self) -> Option<AirborneInterval> {
        self.chosen.and_then(|chosen| self.airborne.get(chosen)).copied()
    }

    /// The unused parts, if rows are skipped up to `start_s` (the calibration's beginning).
    #[must_use]
    pub fn unused(&self, start_s: f64) -> Vec<Unused> {
        let whole_s = self.log_s.1 - self.log_s.0;
        let part = |from_s: f64, to_s: f64, reason: String| {
            (to_s - from_s >= NOT_WORTH_SAYING_S).then(|| Unused {
                from_s,
                to_s,
                share: (to_s - from_s) / whole_s,
                reason,
            })
        };
        let flights = |places: std::ops::Range<usize>| match places.len() {
            0 => String::new(),
            _ if self.airborne.len() == 2 => "the other flight of this log".to_owned(),
            1 => "another flight of this log".to_owned(),
            count => format!("{count} other flights of this log"),
        };
        let chosen = self.chosen.unwrap_or(0);
        let earlier = flights(0..chosen);
        let earlier = part(
            self.log_s.0,
            self.used_s.0,
            if earlier.is_empty() { "before this flight".to_owned() } else { earlier },
        );
        let skipped = part(self.used_s.0, start_s, "before the calibration".to_owned());
        let later = flights(chosen + 1..self.airborne.len().max(chosen + 1));
        let has_landed = self.interval().is_none_or(|interval| interval.landing_s.is_some());
        let after = match later.as_str() {
            "" => "on the ground after the landing".to_owned(),
            later if has_landed => format!("after the landing: on the ground, and {later}"),
            later => format!("after a gap in which nothing was recorded: {later}"),
        };
        let after = part(self.used_s.1, self.log_s.1, after);
        [earlier, skipped, after].into_iter().flatten().collect()
    }

    /// A remark for the user about a log with several flights.
    #[must_use]
    pub fn several(&self) -> Option<String> {
        let chosen = self.chosen.filter(|_| self.airborne.len() > 1)?;
        Some(format!(
            "{} flights in this log: number {} is used, {}",
            self.airborne.len(),
            chosen + 1,
            if self.is_longest(chosen) { "the longest" } else { "the one that contains the given times" }
        ))
    }

    fn is_longest(&self, chosen: usize) -> bool {
        let own_s = self.airborne.get(chosen).map_or(0.0, AirborneInterval::duration_s);
        self.airborne.iter().all(|interval| interval.duration_s() <= own_s)
    }
}

/// Inserts the user's time in the air in place of those that overlap it; returns its index.
fn put(found: &mut AirborneIntervals, given: GivenAirborne, log_s: (f64, f64)) -> (usize, AirborneInterval) {
    let (from_s, to_s) = (given.take_off_s.unwrap_or(log_s.0), given.landing_s.unwrap_or(log_s.1));
    found.airborne.retain(|other| other.to_s <= from_s || other.from_s >= to_s);
    let place = found.airborne.partition_point(|other| other.to_s <= from_s);
    let landed_s = found.airborne[..place].last().map(|earlier| earlier.to_s);
    let interval = AirborneInterval {
        take_off_s: given.take_off_s,
        landing_s: given.landing_s,
        from_s,
        to_s,
        ground_from_s: given.take_off_s.map(|_| landed_s.unwrap_or(log_s.0)),
    };
    found.airborne.insert(place, interval);
    (place, interval)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A log of 1,000 s with up to three flights; the chosen one is used from 50 s before its take-off on.
    fn log(flights: usize, chosen: usize) -> Extent {
        let airborne: Vec<_> = [(100.0, 200.0), (300.0, 600.0), (700.0, 800.0)]
            .into_iter()
            .take(flights)
            .map(|(from_s, to_s)| AirborneInterval {
                take_off_s: Some(from_s),
                landing_s: Some(to_s),
                from_s,
                to_s,
                ground_from_s: Some(from_s - 100.0),
            })
            .collect();
        let used_s = (airborne[chosen].from_s - 50.0, airborne[chosen].to_s);
        Extent { log_s: (0.0, 1_000.0), used_s, airborne, chosen: Some(chosen), is_given: false }
    }

    fn unused(extent: &Extent, start_s: f64) -> Vec<String> {
        extent.unused(start_s).iter().map(Unused::text).collect()
    }

    #[test]
    fn what_is_not_used_is_said_with_its_reason() {
        assert_eq!(
            unused(&log(1, 0), 60.0),
            [
                "not used: 50 s (5.0 %), from 0 s to 50 s: before this flight",
                "not used: 10 s (1.0 %), from 50 s to 60 s: before the calibration",
                "not used: 800 s (80.0 %), from 200 s to 1000 s: on the ground after the landing",
            ]
        );
        assert_eq!(
            unused(&log(2, 1), 250.0),
            [
                "not used: 250 s (25.0 %), from 0 s to 250 s: the other flight of this log",
                "not used: 400 s (40.0 %), from 600 s to 1000 s: on the ground after the landing",
            ]
        );
        assert_eq!(
            unused(&log(3, 1), 250.0),
            [
                "not used: 250 s (25.0 %), from 0 s to 250 s: another flight of this log",
                "not used: 400 s (40.0 %), from 600 s to 1000 s: after the landing: on the ground, and another flight \
                 of this log",
            ]
        );
        assert_eq!(
            unused(&log(3, 0), 50.0)[1],
            "not used: 800 s (80.0 %), from 200 s to 1000 s: after the landing: on the ground, and 2 other flights of \
             this log"
        );
        let mut torn = log(2, 0);
        torn.airborne[0].landing_s = None;
        assert_eq!(
            unused(&torn, 50.0)[1],
            "not used: 800 s (80.0 %), from 200 s to 1000 s: after a gap in which nothing was recorded: the other flight \
             of this log"
        );
    }

    #[test]
    fn of_several_flights_the_one_that_is_used_is_named() {
        assert_eq!(log(1, 0).several(), None);
        assert_eq!(log(2, 1).several().unwrap(), "2 flights in this log: number 2 is used, the longest");
        assert_eq!(
            log(3, 2).several().unwrap(),
            "3 flights in this log: number 3 is used, the one that contains the given times"
        );
    }

    #[test]
    fn a_flight_without_a_landing_ends_with_the_log_or_before_the_next() {
        let log = log(2, 0);
        assert_eq!([0, 1].map(|place| log.end_s(place, &log.airborne[place])), [200.0, 1_000.0]);
    }

    /// A given flight replaces those that it overlaps, and none that it only touches.
    #[test]
    fn a_given_flight_is_put_among_those_that_were_found() {
        let mut found = AirborneIntervals { airborne: log(3, 0).airborne, ..AirborneIntervals::default() };
        let given = GivenAirborne { take_off_s: Some(200.0), landing_s: Some(700.0) };
        let (place, interval) = put(&mut found, given, (0.0, 1_000.0));
        assert_eq!((place, interval.ground_from_s), (1, Some(200.0)));
        let times: Vec<_> = found.airborne.iter().map(|other| (other.from_s, other.to_s)).collect();
        assert_eq!(times, [(100.0, 200.0), (200.0, 700.0), (700.0, 800.0)]);
    }

    /// A moment on the ground belongs to the flight after it, one in the air to that flight. A log may end in
    /// the air.
    #[test]
    fn a_moment_belongs_to_the_next_landing() {
        let mut found = AirborneIntervals { airborne: log(2, 0).airborne, ..AirborneIntervals::default() };
        let place = |found: &AirborneIntervals, time_s| found.around(time_s).map(|(place, _)| place);
        let times = [0.0, 150.0, 200.0, 250.0, 600.0];
        assert_eq!(times.map(|time_s| place(&found, time_s)), [Some(0), Some(0), Some(1), Some(1), None]);
        found.airborne[1].landing_s = None;
        assert_eq!([600.0, 601.0].map(|time_s| place(&found, time_s)), [Some(1), None]);
    }

    /// A log with ten minutes on the ground and two flights of 300 s each, from 200 s and from 800 s on; it
    /// ends on the ground at 1,300 s.
    fn two_flights() -> Flight {
        let height = |second: u16| match second {
            200..500 | 800..1_100 => 600.0,
            _ => 300.0,
        };
        let (mut baro, mut receiver) = (flight_data::Column::default(), flight_data::Column::default());
        for second in 0..=1_300 {
            baro.push(Some(height(second)));
            receiver.push(Some(height(second)));
        }
        let mut flight = Flight { time_s: (0..=1_300).map(f64::from).collect(), ..Flight::default() };
        flight.set_channel(flight_data::Channel::GpsAltM, receiver);
        flight.set_channel(flight_data::Channel::BaroAltM, baro);
        flight
    }

    fn within(flight: &Flight, window: Option<(f64, f64)>, airborne: Option<&str>) -> Result<Extent, String> {
        let calibration = window.map(|(start_s, end_s)| crate::CalibrationWindow { start_s, end_s });
        let airborne = airborne.map(|text| text.parse().unwrap());
        Extent::of(flight, GivenTimes { calibration, airborne }).map_err(|error| error.to_string())
    }

    /// The user's window chooses the flight that it is in, or that comes next. A window that reaches beyond
    /// that flight's landing is refused; one that ends exactly there is not. The first flight is used from
    /// the log's beginning, a later one from the landing before it.
    #[test]
    fn a_window_chooses_the_flight_and_ends_before_its_landing() {
        let flight = two_flights();
        let longest = within(&flight, None, None).unwrap();
        assert_eq!((longest.airborne.len(), longest.chosen), (2, Some(0)), "of two that are alike the first");
        let landings = [0, 1].map(|place| longest.airborne[place].landing_s.unwrap());
        // To within a block of 2.5 s and one beside it.
        assert!((landings[0] - 500.0).abs() <= 5.0 && (landings[1] - 1_100.0).abs() <= 5.0, "{landings:?}");
        assert_eq!(longest.used_s, (0.0, landings[0]));
        let first = within(&flight, Some((50.0, landings[0])), None).unwrap();
        assert_eq!((first.chosen, first.used_s), (Some(0), (0.0, landings[0])));
        let second = within(&flight, Some((600.0, 700.0)), None).unwrap();
        assert_eq!((second.chosen, second.used_s), (Some(1), (landings[0], landings[1])));
        for beyond in [(50.0, landings[0] + 1.0), (50.0, 700.0), (1_150.0, 1_250.0)] {
            assert!(
                within(&flight, Some(beyond), None).unwrap_err().contains("beyond the landing"),
                "{beyond:?}"
            );
        }
        // The same where the user gives the landing.
        assert!(within(&flight, Some((50.0, 450.0)), Some("200..450")).is_ok());
        assert!(within(&flight, Some((50.0, 451.0)), Some("200..450")).is_err());
    }

    /// Shares are those of the log's length, whatever its clock shows at the beginning.
    #[test]
    fn a_share_is_of_the_logs_length() {
        let mut late = log(1, 0);
        late.log_s = (40.0, 1_040.0);
        late.used_s = (140.0, 790.0);
        let shares: Vec<f64> = late.unused(190.0).iter().map(|part| part.share).collect();
        assert_eq!(shares, [0.1, 0.05, 0.25]);
    }
}
