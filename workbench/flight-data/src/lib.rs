//! A flight in memory and as CSV text.
//!
//! Uses no files, terminal or threads: text is passed as bytes, and an [`executor::Executor`] reads long
//! texts in parts.
//!
//! # The file (`pylon-flight: 1`)
//! UTF-8 text: header lines `# key: value`, a row of column names, then one row a time, in time order.
//!
//! | header key | meaning |
//! |---|---|
//! | `pylon-flight` | version of the format; required, `1` |
//! | `vehicle` | the vehicle |
//! | `source` | origin of the flight; a simulation is marked here |
//! | `altitude_datum` | `msl` (default) or `ellipsoid`: what the altitudes are measured from; `baro_alt_m` from 1013.25 hPa |
//! | `altitude_datum COLUMN` | the same for one column: `msl`, `ellipsoid` or `pressure` |
//! | any other | kept as it is; a header line without a colon is kept as a remark |
//!
//! [`Channel`] lists the known columns and their units; `time_s` (seconds, f64, from 0 on) is the time axis.
//! `time_s`, `gps_alt_m` and one other altitude are required. Columns of other names are kept as signals; a
//! known column's name with another unit is an error. Axes: body forward-right-down, navigation
//! north-east-down; accelerations are specific force.
//!
//! An empty cell means "no new sample at this time". `nan` and `inf` are samples: the estimator counts
//! and rejects them. A time that repeats or runs backward is kept: the estimator counts and ignores it.
//!
//! Values are held as f32, the estimator's own precision, and positions (`latitude_deg`, `longitude_deg` and
//! names that end so) as f64. They are written with the fewest digits that give the same number back: the
//! output of [`to_writer`], read by [`parse`] and written again, is the same byte for byte.

mod channel;
mod column;
mod csv_reader;
mod csv_writer;
mod datum;
mod error;
mod names;
mod note;

pub use channel::Channel;
pub use column::Column;
pub use csv_reader::{parse, parse_with};
pub use csv_writer::to_writer;
pub use datum::{AltitudeDatum, is_altitude};
pub use error::{CsvProblem, FlightError};
pub use names::unit_slip;
pub use note::Note;

/// Largest time of a row, seconds (285 years): in microseconds it is still a whole number in f64.
pub const MAX_TIME_S: f64 = 9.0e9;

/// The `# key: value` lines at the head of a flight.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Header {
    /// The vehicle.
    pub vehicle: String,
    /// Where the flight comes from.
    pub source: String,
    /// What its altitudes are measured from.
    pub altitude_datum: AltitudeDatum,
    /// Every other key, in file order; a remark has an empty key.
    pub other: Vec<(String, String)>,
}

/// One flight. Every column has one cell a row.
#[derive(Clone, Debug, Default)]
pub struct Flight {
    /// The header.
    pub header: Header,
    /// Time of each row, seconds, as written in the file (it may repeat or run backward: the
    /// estimator counts such rows and ignores them).
    pub time_s: Vec<f64>,
    /// The known channels that the flight has.
    pub channels: Vec<(Channel, Column)>,
    /// Columns of other names, offered as signals.
    pub extra: Vec<(String, Column)>,
}

impl Flight {
    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.time_s.len()
    }

    /// The column of a channel, if the flight has it.
    #[must_use]
    pub fn channel(&self, channel: Channel) -> Option<&Column> {
        self.channels.iter().find_map(|(name, column)| (*name == channel).then_some(column))
    }

    /// Sets a channel's column, replacing an existing one.
    pub fn set_channel(&mut self, channel: Channel, column: Column) {
        match self.channels.iter_mut().find(|(name, _)| *name == channel) {
            Some((_, slot)) => *slot = column,
            None => self.channels.push((channel, column)),
        }
    }

    /// Checks that the flight has the reference and another altitude; without them there is nothing to
    /// calibrate.
    ///
    /// # Errors
    /// [`CsvProblem::Missing`] without `gps_alt_m`, [`CsvProblem::NoSecondAltitude`] without another
    /// altitude.
    pub fn require_altitudes(&self) -> Result<(), CsvProblem> {
        names::require_altitudes(|channel| self.channel(channel).is_some())
    }
}
