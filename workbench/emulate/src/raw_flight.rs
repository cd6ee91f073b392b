//! Flights that are not compared: of arbitrary bytes, and of a flight computer that is struck.

use std::fs;

use flight_record::{ExitStatus, INPUT_FILE, STRIKES_FILE, SensorSource, Strike, Summary, TickRecord};
use kf_core::input::TickInput;
use kf_core::latch::LatchRecord;
use model::Model;
use survival::RestartReport;

use super::builder::{Board, PlantedError, Program, build};
use super::error::FlyError;
use super::fault_script::{self, PlannedFault, Scripted, schedule};
use super::grid::{GridReport, OnGrid};
use super::record::{self, FlightResult};
use super::run::{TELEMETRY_FILE, emulated, name, results};

/// Flies arbitrary bytes as a flight record, valid or not, without a comparison.
///
/// # Errors
/// Only what keeps the emulation from ending by itself.
pub fn fly_bytes(record: &[u8], model: &Model, planted: Option<PlantedError>) -> Result<RawFlight, FlyError> {
    fly_raw(record, model, planted, &[])
}

/// Flies a flight record whose flight computer is struck at these times: it must continue.
///
/// # Errors
/// As [`fly_bytes`].
pub fn fly_struck(record: &[u8], model: &Model, strikes: &[Strike]) -> Result<RawFlight, FlyError> {
    fly_raw(record, model, Some(PlantedError::Strike), strikes)
}

/// As [`fly_struck`], for ticks on chips with faults.
///
/// # Errors
/// As [`fly_struck`], and a fault that is not possible.
pub fn fly_struck_on_chips(
    inputs: impl Iterator<Item = TickInput> + Clone,
    model: &Model,
    faults: &[PlannedFault],
    strikes: &[Strike],
) -> Result<RawFlight, FlyError> {
    let events = schedule(faults)?;
    GridReport::of(inputs.clone())?;
    fault_script::check(&events, OnGrid::new(inputs.clone()))?;
    let file = tempfile::NamedTempFile::new().map_err(FlyError::io("the flight record"))?;
    let items = Scripted::new(OnGrid::new(inputs), &events);
    record::write_inputs(file.path(), model.fingerprint()?, SensorSource::Chips, items)?;
    let record = fs::read(file.path()).map_err(FlyError::io("the flight record"))?;
    fly_struck(&record, model, strikes)
}

fn fly_raw(
    record: &[u8],
    model: &Model,
    planted: Option<PlantedError>,
    strikes: &[Strike],
) -> Result<RawFlight, FlyError> {
    let image = build(Program::Flight(Board::Qemu), model, planted)?;
    let directory = tempfile::tempdir().map_err(FlyError::io("temporary directory"))?;
    fs::write(directory.path().join(name(INPUT_FILE)?), record).map_err(FlyError::io("the flight record"))?;
    let blows: Vec<u8> = strikes.iter().flat_map(|strike| strike.to_bytes()).collect();
    fs::write(directory.path().join(name(STRIKES_FILE)?), blows).map_err(FlyError::io("the strikes"))?;
    let ticks = u32::try_from(record.len() / 16).unwrap_or(u32::MAX);
    let mut run = emulated(&image, directory.path(), ticks, Some(TELEMETRY_FILE))?;
    let telemetry = fs::read(directory.path().join(TELEMETRY_FILE)).map_err(FlyError::io("the telemetry"))?;
    let record = results(directory.path())?;
    let mut flight =
        RawFlight { status: run.status, log: run.log, telemetry, record, ..RawFlight::default() };
    while let Some(result) = run.results.next_result()? {
        match result {
            FlightResult::Tick(tick) => flight.ticks.push(tick),
            FlightResult::Latch(latch) => flight.latches.push(latch),
            FlightResult::Restart(report) => flight.restarts.push((flight.ticks.len(), report)),
            FlightResult::Summary(summary) => flight.summary = Some(summary),
        }
    }
    Ok(flight)
}

/// What an emulated flight on arbitrary bytes produced.
#[derive(Clone, Debug, Default)]
pub struct RawFlight {
    /// How the firmware ended it; `None` if it did not.
    pub status: Option<ExitStatus>,
    /// What it logged.
    pub log: Vec<String>,
    /// Every tick.
    pub ticks: Vec<TickRecord>,
    /// Every latched calibration; there should be at most one.
    pub latches: Vec<LatchRecord>,
    /// Every restart, and how many ticks there were before it.
    pub restarts: Vec<(usize, RestartReport)>,
    /// The counters, if the flight reached its end.
    pub summary: Option<Summary>,
    /// Output of the telemetry line; a restart may have cut a frame.
    pub telemetry: Vec<u8>,
    /// All of that except log and telemetry, as the flight computer sent it.
    pub record: Vec<u8>,
}
