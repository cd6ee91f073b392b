//! Times of a flight that the user gives instead of those found in it.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

use super::has_launch;
use super::window::CalibrationWindow;
use flight_data::Flight;

/// Times of a flight that the user gives; those left out are found in the flight.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GivenTimes {
    /// Where to calibrate.
    pub calibration: Option<CalibrationWindow>,
    /// When it was in the air.
    pub airborne: Option<GivenAirborne>,
}

impl From<Option<CalibrationWindow>> for GivenTimes {
    fn from(calibration: Option<CalibrationWindow>) -> Self {
        Self { calibration, airborne: None }
    }
}

/// Take-off and landing, seconds of the flight's own clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GivenAirborne {
    /// When it took off; `None`: it was already in the air when the log began.
    pub take_off_s: Option<f64>,
    /// When it landed; `None`: it was still in the air when the log ended.
    pub landing_s: Option<f64>,
}

/// A take-off and a landing that cannot be used.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum AirborneError {
    /// Not of the form FROM..TO.
    #[error("time in the air '{0}', expected FROM..TO in seconds, such as 12..640, 12.. or ..640")]
    Form(String),
    /// It lands before it takes off.
    #[error("time in the air {0} lands before it takes off, expected FROM below TO")]
    Empty(GivenAirborne),
    /// The log has no row in it, or it extends beyond the log.
    #[error(
        "time in the air {airborne} does not lie within the log, which goes from {first_s} s to {last_s} s"
    )]
    Outside {
        /// The given times.
        airborne: GivenAirborne,
        /// Time of the log's first row, seconds.
        first_s: f64,
        /// Its largest time, seconds.
        last_s: f64,
    },
    /// The flight's own column records its launch.
    #[error(
        "time in the air {0}: this flight's launch column records its launch, and all of the flight is used; give take-off \
         and landing only for a log without that column"
    )]
    HasLaunch(GivenAirborne),
}

impl fmt::Display for GivenAirborne {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let end = |time_s: Option<f64>| time_s.map_or_else(String::new, |time_s| time_s.to_string());
        write!(formatter, "{}..{} s", end(self.take_off_s), end(self.landing_s))
    }
}

impl FromStr for GivenAirborne {
    type Err = AirborneError;

    fn from_str(text: &str) -> Result<Self, AirborneError> {
        let form = || AirborneError::Form(text.to_owned());
        let (from, to) = text.split_once("..").ok_or_else(form)?;
        let seconds = |text: &str| match text.trim() {
            "" => Ok(None),
            text => {
                let time_s = text.parse::<f64>().ok().filter(|time| time.is_finite() && *time >= 0.0);
                time_s.map(Some).ok_or_else(form)
            }
        };
        let airborne = Self { take_off_s: seconds(from)?, landing_s: seconds(to)? };
        match (airborne.take_off_s, airborne.landing_s) {
            (None, None) => Err(form()),
            (Some(take_off_s), Some(landing_s)) if take_off_s >= landing_s => {
                Err(AirborneError::Empty(airborne))
            }
            _ => Ok(airborne),
        }
    }
}

impl GivenAirborne {
    /// Checks that the log has rows between take-off and landing, and both within it.
    pub(super) fn check(self, flight: &Flight) -> Result<(), AirborneError> {
        if has_launch(flight) {
            return Err(AirborneError::HasLaunch(self));
        }
        let times = || flight.time_s.iter().copied();
        let (first_s, last_s) = (times().next().unwrap_or(0.0), times().fold(0.0, f64::max));
        let (from_s, to_s) = (self.take_off_s.unwrap_or(first_s), self.landing_s.unwrap_or(last_s));
        if from_s >= to_s {
            return Err(AirborneError::Empty(self));
        }
        if from_s < first_s || to_s > last_s || !times().any(|time_s| (from_s..to_s).contains(&time_s)) {
            return Err(AirborneError::Outside { airborne: self, first_s, last_s });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<GivenAirborne, String> {
        text.parse().map_err(|error: AirborneError| error.to_string())
    }

    #[test]
    fn reads_take_off_and_landing_and_one_of_both() {
        let airborne = |take_off_s, landing_s| Ok(GivenAirborne { take_off_s, landing_s });
        assert_eq!(parse("12..640.5"), airborne(Some(12.0), Some(640.5)));
        assert_eq!(parse("12.."), airborne(Some(12.0), None));
        assert_eq!(parse(" .. 640"), airborne(None, Some(640.0)));
        for bad in ["", "..", "12", "12-640", "a..b", "-1..5", "nan..5", "0..inf", "1..2..3"] {
            assert!(parse(bad).unwrap_err().contains("expected FROM..TO in seconds"), "{bad}");
        }
        assert!(
            parse("80..10").unwrap_err().starts_with("time in the air 80..10 s lands before it takes off")
        );
    }

    #[test]
    fn lies_within_the_log() {
        let flight = Flight { time_s: vec![5.0, 10.0, 20.0], ..Flight::default() };
        let check = |text: &str| text.parse::<GivenAirborne>().unwrap().check(&flight);
        for good in ["5..20", "8..12", "8..", "..20"] {
            assert_eq!(check(good), Ok(()), "{good}");
        }
        for outside in ["4..20", "5..21", "11..12"] {
            assert!(matches!(check(outside), Err(AirborneError::Outside { .. })), "{outside}");
        }
        assert!(matches!(check("30.."), Err(AirborneError::Empty(_))));
    }
}
