//! `pylon ladder`.

use std::path::PathBuf;

use clap::Args;
use pylon::learn::{ladder, ladder_text};
use pylon::replay::{CalibrationWindow, Replay};

use super::failure::Failure;
use super::places::Places;
use super::progress::Progress;
use super::{load, terminal};

const EXAMPLES: &str = "\
Examples:
  pylon ladder --model ours.toml monday.csv friday.csv
      how the errors fell, and when flags were raised, with every revision of the model
  pylon ladder --model ours.toml flight.csv --json | jq '.revisions[].flights[0].sensors.baro.free_flight_rms_m'
      for other programs";

/// The error of every revision of a model on every flight
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Flights: flight CSVs, logs that `pylon import` reads, or folders of them
    #[arg(value_name = "FLIGHT", required = true)]
    flights: Vec<PathBuf>,
    /// The model: a TOML file, `default` or `paper`
    #[arg(long, value_name = "MODEL")]
    model: String,
    /// Calibrate on this part of the flights, and take its end as launch; seconds of the flight's clock, as `pylon open` shows it
    #[arg(long, value_name = "START..END")]
    calibrate: Option<CalibrationWindow>,
    /// Fail if one flight cannot be used, instead of skipping and naming it
    #[arg(long)]
    strict: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let model = load::model(&arguments.model)?;
    let given = Places::find(&arguments.flights)?;
    load::refuse_repeats(&given.files, &[])?;
    let batch = load::Batch::read(&given.files, arguments.strict, |flight| {
        Replay::new(flight, &model, arguments.calibrate).map(|_| ())
    })?;
    let flights = load::named(&batch.files, &batch.flights);
    let mut progress = Progress::new("flying", (model.revisions.len() as u64 + 1) * batch.files.len() as u64);
    let mut ladder = ladder(&model, &flights, arguments.calibrate, &mut |done| progress.show(done))
        .map_err(|error| Failure::input(error.to_string()))?;
    drop(progress);
    ladder.model.clone_from(&arguments.model);
    given.write_notes();
    batch.write_skipped();
    load::write_unused(&load::replays(&batch.files, &batch.flights, &model, arguments.calibrate)?);
    if arguments.json { terminal::put_json(&ladder) } else { terminal::put(&ladder_text(&ladder)) }
}
