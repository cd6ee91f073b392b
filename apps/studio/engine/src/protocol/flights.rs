//! Opening a flight, and its contents.

use std::collections::BTreeMap;

use analysis::overview::Overview;
use serde::{Deserialize, Serialize};

/// Where to calibrate, seconds of the flight's own clock; its end is taken as launch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Window {
    /// Start.
    pub start_s: f64,
    /// End.
    pub end_s: f64,
}

/// Take-off and landing, seconds of the flight's own clock; null: already in the air when the log begins, or
/// still when it ends.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Airborne {
    /// When it took off.
    pub take_off_s: Option<f64>,
    /// When it landed.
    pub landing_s: Option<f64>,
}

/// The user's times for a flight; null: those that Pylon finds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Times {
    /// Where to calibrate.
    pub window: Option<Window>,
    /// When it was in the air.
    pub airborne: Option<Airborne>,
}

/// The user's times for each flight, by its name; none for a flight that is not listed.
pub type TimesByFlight = BTreeMap<String, Times>;

/// Opens the log whose bytes come with the request: any format that Pylon imports, detected from its content.
/// An error is the importer's own line.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct OpenRequest {
    /// Name of the flight in later requests; an open flight of that name is replaced.
    pub flight: String,
    /// The file's name, for results and messages.
    pub file: String,
}

/// Asks for the contents of an opened flight, with the user's times.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct FlightRequest {
    /// The flight.
    pub flight: String,
    /// The user's times for it.
    pub times: Times,
}

/// Forgets a flight.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct CloseRequest {
    /// The flight.
    pub flight: String,
}

/// Whether a flight was closed.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Closed {
    /// False if it was not open.
    pub was_open: bool,
}

/// An opened flight.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Opened {
    /// The result of `pylon open --json`: the format, take-off, landing, launch, which parts are used and why
    /// others are not, the sensors, the importer's notes; if the flight cannot be analysed, `refused` gives
    /// the reason.
    pub overview: Overview,
    /// The vehicle, identified among others of its type; flights are grouped by it.
    pub vehicle: String,
    /// First and last time of the flight's own clock, seconds.
    pub first_s: f64,
    /// See [`Self::first_s`].
    pub last_s: f64,
    /// Every column, those that Pylon knows first.
    pub columns: Vec<ColumnFacts>,
    /// The altitude sensors that a mission over this flight has, by name: `baro`, `imu_slave`, `imu_master`.
    pub sensors: Vec<String>,
}

/// A column of a flight.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct ColumnFacts {
    /// Its name, which for a known column includes the unit.
    pub name: String,
    /// Whether Pylon knows the column.
    pub is_known: bool,
    /// Number of values.
    pub values: u32,
}

/// Asks for the flights that come with Pylon.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct SamplesRequest {}

/// A flight that comes with Pylon: a scenario, simulated when it is opened.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Sample {
    /// Its name, for [`OpenSampleRequest`].
    pub name: String,
    /// Description in one sentence, including that it is simulated.
    pub about: String,
}

/// Simulates a flight that comes with Pylon, and opens it.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct OpenSampleRequest {
    /// Name of the flight in later requests.
    pub flight: String,
    /// The sample's name.
    pub sample: String,
}
