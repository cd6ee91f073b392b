//! `pylon import`.

use std::path::PathBuf;

use clap::Args;
use pylon::import::{guess, mapping};
use pylon::output_file::prepare;
use pylon::results::{ImportResult, VERSION};
use pylon::{flight, import};

use super::failure::Failure;
use super::load::write_notes;
use super::overwriting::{Role, refuse_overwriting};
use super::progress::while_busy;
use super::terminal;

const EXAMPLES: &str = "\
Examples:
  pylon import log_12_2024-05-01.ulg -o flight.csv
      a PX4 log (ULog); reports what was found, used and left out
  pylon import 00000042.BIN -o flight.csv
      an ArduPilot log (DataFlash), binary or as text (.log), of a copter, plane or rover
  pylon import 2023-04-28.igc -o flight.csv
      an IGC log (gliders, paragliders); reports what was inferred or left out
  pylon import flight.tlog -o flight.csv
      a recorded MAVLink stream, of Pylon's own telemetry or of another autopilot
  pylon import flight.tlog --turn gps_vd_mps -o flight.csv
      the same for an autopilot that logged its velocity with the wrong sign; import reports a log that looks like that
  pylon import flight.csv --to-msl imu_master_alt_m=47.2 -o corrected.csv
      one altitude above mean sea level like the others, where the geoid is 47.2 m above the ellipsoid; a flight CSV is accepted if it is to be corrected
  pylon import logger.csv --guess -o mapping.toml
      any table of numbers, CSV or Parquet: a draft of what its columns are, each guess with its reason, doubtful ones commented out
  pylon import logger.csv --mapping mapping.toml -o flight.csv
      import the table by that mapping, once you have checked it (format: docs/workbench.md)
  pylon import FLIGHT.record -o flight.csv
      a recording of a flight computer's results port (docs/bring-up.md), or the inputs of `pylon fly`; the header has the
      calibration and the flags as flown

Formats are detected from content. All commands that take a flight also read logs directly.";

/// Convert another program's log to a flight CSV
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The log: PX4 ULog, ArduPilot DataFlash (.bin, .log), IGC, a recorded MAVLink stream (tlog),
    /// AltusMetrum CSV, a flight record, Pylon's own MCAP or Parquet, or, with a mapping, any table of
    /// numbers (CSV, Parquet)
    #[arg(value_name = "LOG")]
    log: PathBuf,
    /// The flight to write (CSV), or the mapping with --guess [default with --guess: standard output]
    #[arg(short, long, value_name = "FILE", required_unless_present = "guess")]
    output: Option<PathBuf>,
    /// Read a table of numbers with this mapping file, which assigns the columns
    #[arg(long, value_name = "MAPPING", conflicts_with = "guess")]
    mapping: Option<PathBuf>,
    /// Draft a mapping file from names, values and physics; nothing is imported
    #[arg(long, conflicts_with = "turn")]
    guess: bool,
    /// Invert a velocity that the log records with the wrong sign (may be repeated)
    #[arg(long, value_name = "COLUMN", value_parser = clap::builder::PossibleValuesParser::new(import::signs::names()))]
    turn: Vec<String>,
    /// Convert an altitude above the ellipsoid to one above mean sea level, given the metres by which the
    /// geoid is above the ellipsoid there (may be repeated)
    #[arg(long, value_name = "COLUMN=METRES", conflicts_with = "guess")]
    to_msl: Vec<import::to_msl::ToMsl>,
    /// Print JSON: what was written
    #[arg(long, conflicts_with = "guess")]
    json: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if arguments.guess {
        return guess(arguments);
    }
    let Some(output) = &arguments.output else {
        return Err(Failure::input("no file to write the flight to, expected -o FLIGHT"));
    };
    let log = Role::new(&arguments.log, "the log");
    let inputs: Vec<Role<'_>> = [log]
        .into_iter()
        .chain(arguments.mapping.as_deref().map(|file| Role::new(file, "the mapping")))
        .collect();
    refuse_overwriting(&inputs, &[Role::new(output, "the flight")])?;
    let corrections =
        import::Corrections { turned: arguments.turn.clone(), to_msl: arguments.to_msl.clone() };
    let (flight, notes) = while_busy("importing", || -> Result<_, Failure> {
        Ok(match &arguments.mapping {
            Some(file) => mapping::import_file(&arguments.log, file, &corrections)?,
            None => import::import_file_corrected(&arguments.log, &corrections)?,
        })
    })?;
    while_busy("writing", || flight::write(output, &flight))?;
    write_notes(&notes);
    let clocks = while_busy("comparing clocks", || import::clock_offset::text(&flight));
    let clocks: Vec<_> = clocks.map(flight::Note::new).into_iter().collect();
    write_notes(&clocks);
    if arguments.json {
        return terminal::put_json(&ImportResult {
            version: VERSION,
            file: output.display().to_string(),
            rows: flight.rows() as u64,
            columns: flight.channels.iter().map(|(channel, _)| channel.name().into()).collect(),
            notes: notes.iter().chain(&clocks).map(ToString::to_string).collect(),
        });
    }
    let channels: Vec<&str> = flight.channels.iter().map(|(channel, _)| channel.name()).collect();
    terminal::put(&format!(
        "{}: {} rows of time_s, {}\n",
        output.display(),
        flight.rows(),
        channels.join(", ")
    ))
}

/// Drafts a mapping: into a new file with its explanation on standard output, or onto standard output itself.
fn guess(arguments: &Arguments) -> Result<(), Failure> {
    let draft = while_busy("guessing", || guess::guess_file(&arguments.log))?;
    let log = arguments.log.display().to_string();
    let Some(output) = &arguments.output else { return terminal::put(&draft.text(&log, "mapping.toml")) };
    let file = output.display().to_string();
    // A mapping that the user has corrected must not be overwritten by a second guess.
    if output.is_file() {
        return Err(Failure::input(format!(
            "{file}: already exists and would be overwritten; choose another name for -o"
        )));
    }
    prepare(output, |out| out.write_all(draft.text(&log, &file).as_bytes()))?.publish_new()?;
    terminal::put(&format!(
        "{file}: {}nothing is applied yet: read it, then 'pylon import {log} --mapping {file} -o flight.csv'\n",
        draft.explanation()
    ))
}
