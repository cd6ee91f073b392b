//! `pylon import`.

use std::path::PathBuf;

use clap::Args;
use pylon::{flight, import};

use super::failure::Failure;
use super::load::write_notes;
use super::overwriting::{Role, refuse_overwriting};
use super::progress::while_busy;
use super::terminal;

const EXAMPLES: &str = "\
Examples:
  pylon import log_12_2024-05-01.ulg -o flight.csv
      a PX4 log (ULog); what was found, used, and could not be used is said
  pylon import 00000042.BIN -o flight.csv
      an ArduPilot log (DataFlash), binary or as text (.log), of a copter, plane or rover
  pylon import 2023-04-28.igc -o flight.csv
      an IGC log (gliders, paragliders) as a flight's CSV; what was inferred or left out is said
  pylon import flight.tlog -o flight.csv
      a recorded MAVLink stream, of Pylon's own telemetry or of another autopilot
  pylon import flight.tlog --turn gps_vd_mps -o flight.csv
      the same of an autopilot that wrote its velocity down with the sign turned; import says when a log looks like that
  pylon import FLIGHT.record -o flight.csv
      a flight computer's results' line as it was recorded (docs/bring-up.md), or the inputs of `pylon fly`; the calibration
      and the flags as flown are in the header

A log is recognised by its content. `compare` and `fly` read logs directly as well.";

/// Turn a log of another program into a flight's CSV
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The log: PX4 ULog, ArduPilot DataFlash (.bin, .log), IGC, a MAVLink stream's recording (tlog), AltusMetrum CSV, or a flight
    /// record
    #[arg(value_name = "LOG")]
    log: PathBuf,
    /// The flight to write (CSV)
    #[arg(short, long, value_name = "FLIGHT")]
    output: PathBuf,
    /// Turn the sign of a velocity that the log has the wrong way round; may be given several times
    #[arg(long, value_name = "COLUMN", value_parser = clap::builder::PossibleValuesParser::new(import::signs::names()))]
    turn: Vec<String>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    refuse_overwriting(
        &[Role::new(&arguments.log, "the log")],
        &[Role::new(&arguments.output, "the flight")],
    )?;
    let (flight, notes) =
        while_busy("importing", || import::import_file_turned(&arguments.log, &arguments.turn))?;
    while_busy("writing", || flight::write(&arguments.output, &flight))?;
    write_notes(&notes);
    let channels: Vec<&str> = flight.channels.iter().map(|(channel, _)| channel.name()).collect();
    terminal::put(&format!(
        "{}: {} rows of time_s, {}\n",
        arguments.output.display(),
        flight.rows(),
        channels.join(", ")
    ))
}
