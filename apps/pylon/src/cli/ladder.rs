//! `pylon ladder`.

use std::path::PathBuf;

use clap::Args;
use pylon::learn::{ladder, ladder_text};
use pylon::replay::Replay;

use super::failure::Failure;
use super::places::Places;
use super::progress::Progress;
use super::times::TimesArguments;
use super::{load, terminal};

const EXAMPLES: &str = "\
Examples:
  pylon ladder --model ours.toml monday.csv friday.csv
      how the errors fell, and when flags were raised, with every revision of the model
  pylon ladder --model ours.toml flight.csv --json | jq '.revisions[].flights[0].sensors.baro.free_flight_rms_m'
      for other programs";

/// Show the error of every revision of a model on every flight
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Flights: flight CSVs, logs that `pylon import` reads, or folders of them
    #[arg(value_name = "FLIGHT", required = true)]
    flights: Vec<PathBuf>,
    /// The model: a TOML file, `default` or `paper`
    #[arg(long, value_name = "MODEL")]
    model: String,
    #[command(flatten)]
    times: TimesArguments,
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
    let places = Places::find(&arguments.flights)?;
    let given = arguments.times.given();
    load::refuse_repeats(&places.files, &[])?;
    let batch = load::Batch::read(&places.files, arguments.strict, |flight| {
        Replay::new(flight, &model, given).map(|_| ())
    })?;
    let flights = load::named(&batch.files, &batch.flights, given);
    let mut progress = Progress::new("flying", (model.revisions.len() as u64 + 1) * batch.files.len() as u64);
    let mut ladder = ladder(&model, &flights, &mut |done| progress.show(done))
        .map_err(|error| Failure::input(error.to_string()))?;
    drop(progress);
    ladder.model.clone_from(&arguments.model);
    places.write_notes();
    batch.write_skipped();
    load::write_unused(&load::replays(&batch.files, &batch.flights, &model, given)?);
    if arguments.json { terminal::put_json(&ladder) } else { terminal::put(&ladder_text(&ladder)) }
}
