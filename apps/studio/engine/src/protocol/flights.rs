//! Opening a flight, and what is in it.

use std::collections::BTreeMap;

use analysis::overview::Overview;
use serde::{Deserialize, Serialize};

/// Where to calibrate, seconds of the flight's own clock; launch is said at its end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Window {
    /// Start.
    pub start_s: f64,
    /// End.
    pub end_s: f64,
}

/// Take-off and landing, seconds of the flight's own clock; null: in the air already when the log begins, or
/// still when it ends.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Airborne {
    /// When it took off.
    pub take_off_s: Option<f64>,
    /// When it landed.
    pub landing_s: Option<f64>,
}

/// What the user says of a flight's times; null: what Pylon finds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Times {
    /// Where to calibrate.
    pub window: Option<Window>,
    /// When it was in the air.
    pub airborne: Option<Airborne>,
}

/// What the user says of flights' times, by the flight; of one that is not there nothing is said.
pub type TimesByFlight = BTreeMap<String, Times>;

/// Opens the log whose bytes come with the request: any format that Pylon imports, told by its content. An
/// error is the importer's own line.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct OpenRequest {
    /// What later requests call the flight; one of that name is replaced.
    pub flight: String,
    /// The file's name, for results and messages.
    pub file: String,
}

/// Asks for what is in an opened flight, with the user's times.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct FlightRequest {
    /// The flight.
    pub flight: String,
    /// What the user says of its times.
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
    /// False for one that was not open.
    pub was_open: bool,
}

/// An opened flight.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct Opened {
    /// What `pylon open --json` says: the format, take-off, landing, launch, what is used and what not and
    /// why, the sensors, the notes of the importer; `refused` says why it cannot be analysed, where it
    /// cannot.
    pub overview: Overview,
    /// The vehicle, with what tells it from another of its type: flights are grouped by it.
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
    /// Its name; a known one's says the unit.
    pub name: String,
    /// Whether Pylon knows what it is.
    pub is_known: bool,
    /// How many values it has.
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
    /// What it is, in one sentence, that it is simulated included.
    pub about: String,
}

/// Simulates a flight that comes with Pylon, and opens it.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct OpenSampleRequest {
    /// What later requests call the flight.
    pub flight: String,
    /// The sample's name.
    pub sample: String,
}
