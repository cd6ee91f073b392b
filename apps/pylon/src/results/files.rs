//! JSON results of the commands that write a file: its path and contents.

use analysis::name::Name;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `pylon simulate --json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SimulateResult {
    /// Version of these keys.
    pub version: u32,
    /// The flight's file.
    pub file: String,
    /// The file of its truth.
    pub truth: String,
    /// The scenario's name.
    pub scenario: String,
    /// The seed.
    pub seed: u64,
    /// Rows of the flight.
    pub rows: usize,
    /// Length of the flight, seconds.
    pub duration_s: f64,
    /// When it was launched, seconds; null without a launch.
    pub launch_s: Option<f64>,
}

/// `pylon import --json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ImportResult {
    /// Version of these keys.
    pub version: u32,
    /// The flight's file.
    pub file: String,
    /// Rows of the flight.
    pub rows: u64,
    /// Its columns, besides `time_s`.
    pub columns: Vec<Name>,
    /// Notes on the log.
    pub notes: Vec<String>,
}

/// `pylon export --json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ExportResult {
    /// Version of these keys.
    pub version: u32,
    /// The exported file.
    pub file: String,
    /// Its format.
    pub format: Name,
    /// Rows of the flight.
    pub rows: u64,
    /// Columns, in formats whose number of columns depends on the flight.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub columns: Option<usize>,
    /// Messages, in formats that have messages.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub messages: Option<u64>,
    /// Topics of the messages.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub topics: Option<usize>,
    /// Notes on the input.
    pub notes: Vec<String>,
}

/// `pylon report --json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ReportResult {
    /// Version of these keys.
    pub version: u32,
    /// The page.
    pub file: String,
    /// Flights on it.
    pub flights: usize,
    /// Its size, bytes.
    pub size_bytes: usize,
}
