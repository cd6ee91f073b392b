//! `pylon import`.

use std::path::PathBuf;

use clap::Args;
use pylon::{flight, import};

use super::failure::Failure;
use super::load::write_notes;
use super::progress::while_busy;
use super::terminal;

const EXAMPLES: &str = "\
Examples:
  pylon import 2023-04-28.igc -o flight.csv
      an IGC log (gliders, paragliders) as a flight's CSV; what was inferred or left out is said
  pylon import flight.tlog -o flight.csv
      a recorded MAVLink stream, of Pylon's own telemetry or of another autopilot

A log is recognised by its content. `compare` and `fly` read logs directly as well.";

/// Turn a log of another program into a flight's CSV
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The log: IGC, or a MAVLink stream's recording (tlog)
    #[arg(value_name = "LOG")]
    log: PathBuf,
    /// The flight to write (CSV)
    #[arg(short, long, value_name = "FLIGHT")]
    output: PathBuf,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (flight, notes) = while_busy("importing", || import::import_file(&arguments.log))?;
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
