//! The part of a flight used for calibration, where the flight does not record its launch.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

use flight_data::Flight;

/// From `start_s` to `end_s` on the flight's own clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CalibrationWindow {
    /// First time that is used, seconds.
    pub start_s: f64,
    /// Time at which launch is set, seconds.
    pub end_s: f64,
}

/// A window that cannot be used.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum WindowError {
    /// Not of the form START..END.
    #[error("calibration window '{0}', expected START..END in seconds, such as 10..80")]
    Form(String),
    /// It ends before it starts.
    #[error("calibration window {0} ends before it starts, expected START below END")]
    Empty(CalibrationWindow),
    /// It extends beyond the landing.
    #[error(
        "calibration window {window} of the flight's own clock reaches beyond the landing at {landing_s:.0} s: nothing is \
         calibrated after a landing ('pylon open' shows when the flight took off and landed)"
    )]
    AfterLanding {
        /// The window.
        window: CalibrationWindow,
        /// When it landed, seconds.
        landing_s: f64,
    },
    /// The flight has no row in it, or none after it.
    #[error(
        "calibration window {window} does not lie within the flight, which goes from {first_s} s to {last_s} s"
    )]
    Outside {
        /// The window.
        window: CalibrationWindow,
        /// Time of the flight's first row, seconds.
        first_s: f64,
        /// Largest time in the flight, seconds.
        last_s: f64,
    },
}

impl fmt::Display for CalibrationWindow {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}..{} s", self.start_s, self.end_s)
    }
}

impl FromStr for CalibrationWindow {
    type Err = WindowError;

    fn from_str(text: &str) -> Result<Self, WindowError> {
        let form = || WindowError::Form(text.to_owned());
        let (start, end) = text.split_once("..").ok_or_else(form)?;
        let seconds = |text: &str| {
            text.trim().parse::<f64>().ok().filter(|time| time.is_finite() && *time >= 0.0).ok_or_else(form)
        };
        let window = Self { start_s: seconds(start)?, end_s: seconds(end)? };
        if window.start_s < window.end_s { Ok(window) } else { Err(WindowError::Empty(window)) }
    }
}

impl CalibrationWindow {
    /// Checks that the flight has rows in the window and after it.
    pub(super) fn check(self, flight: &Flight) -> Result<(), WindowError> {
        if self.start_s >= self.end_s || !self.start_s.is_finite() || !self.end_s.is_finite() {
            return Err(WindowError::Empty(self));
        }
        let times = || flight.time_s.iter().copied();
        let has_inside = times().any(|time| (self.start_s..self.end_s).contains(&time));
        let last_s = times().fold(0.0, f64::max);
        if has_inside && last_s >= self.end_s {
            return Ok(());
        }
        let first_s = times().next().unwrap_or(0.0);
        Err(WindowError::Outside { window: self, first_s, last_s })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<CalibrationWindow, String> {
        text.parse().map_err(|error: WindowError| error.to_string())
    }

    #[test]
    fn reads_start_and_end() {
        assert_eq!(parse("10..80"), Ok(CalibrationWindow { start_s: 10.0, end_s: 80.0 }));
        assert_eq!(parse("0 .. 12.5"), Ok(CalibrationWindow { start_s: 0.0, end_s: 12.5 }));
        for bad in ["", "10", "10-80", "a..b", "..5", "5..", "-1..5", "nan..5", "0..inf", "1..2..3"] {
            assert!(parse(bad).unwrap_err().contains("expected START..END in seconds"), "{bad}");
        }
        assert!(
            parse("80..10").unwrap_err().starts_with("calibration window 80..10 s ends before it starts")
        );
        assert!(parse("5..5").is_err());
    }

    #[test]
    fn lies_within_the_flight() {
        let flight = Flight { time_s: vec![5.0, 10.0, 20.0], ..Flight::default() };
        let check = |start_s, end_s| CalibrationWindow { start_s, end_s }.check(&flight);
        check(0.0, 20.0).unwrap();
        check(10.0, 15.0).unwrap();
        assert_eq!(
            check(0.0, 20.5).unwrap_err().to_string(),
            "calibration window 0..20.5 s does not lie within the flight, which goes from 5 s to 20 s"
        );
        assert!(check(11.0, 19.0).is_err());
    }

    /// An invalid window is refused as such, before the flight is examined.
    #[test]
    fn a_window_without_a_length_is_empty() {
        let flight = Flight { time_s: vec![5.0, 10.0, 20.0], ..Flight::default() };
        for (start_s, end_s) in
            [(10.0, 10.0), (15.0, 5.0), (f64::NAN, 20.0), (0.0, f64::INFINITY), (f64::NEG_INFINITY, 20.0)]
        {
            let refused = CalibrationWindow { start_s, end_s }.check(&flight);
            assert!(matches!(refused, Err(WindowError::Empty(_))), "{start_s} {end_s}");
        }
    }
}
