//! What the commands print that write a file: where it is and what is in it.

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
    /// The file of the truth about it.
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
    /// What was remarkable about the log.
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
    /// Columns, in formats that have columns of the flight's own number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub columns: Option<usize>,
    /// Messages, in formats that have messages.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub messages: Option<u64>,
    /// Topics that the messages are on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub topics: Option<usize>,
    /// What was remarkable about the input.
    pub notes: Vec<String>,
}

/// `pylon report --json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ReportResult {
    /// Version of these keys.
    pub version: u32,
    /// The page.
    pub file: String,
    /// Flights that it draws.
    pub flights: usize,
    /// Its size, bytes.
    pub size_bytes: usize,
}
