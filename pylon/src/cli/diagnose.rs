//! `pylon diagnose`.

use std::path::PathBuf;

use clap::Args;
use pylon::diagnose::{diagnose, text};
use pylon::replay::{CalibrationWindow, Replay};

use super::failure::Failure;
use super::places::Places;
use super::progress::Counter;
use super::{load, terminal};

const EXAMPLES: &str = "\
Examples:
  pylon diagnose flight.csv
      which physical effect the default model lacks on this flight
  pylon diagnose monday.csv tuesday.csv --hold-out friday.csv --model ours.toml
      learn from two flights, judge on a third
  pylon diagnose logs/
      every log of a folder; one that cannot be used is skipped and named
  pylon diagnose logger.igc --calibrate 60..180
      a flight that does not say when it was launched: calibrate on 60 s to 180 s
  pylon diagnose flight.csv --json | jq .sensors.baro.missing
      for other programs";

/// Find the physical effect that a model lacks, or say that a flight can't tell
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Flights to learn from: flights' CSV, logs that `pylon import` reads, or folders of them
    #[arg(value_name = "FLIGHT", required = true)]
    flights: Vec<PathBuf>,
    /// The model: a TOML file, `default` or `paper`
    #[arg(long, value_name = "MODEL", default_value = "default")]
    model: String,
    /// Judge the errors on this flight instead of on held-out manoeuvres (may be repeated)
    #[arg(long, value_name = "FLIGHT")]
    hold_out: Vec<PathBuf>,
    /// Calibrate on this part of the flights (seconds of the flight's own clock, as `pylon open` shows it: an imported log's begins with its first record) and say launch at its end
    #[arg(long, value_name = "START..END")]
    calibrate: Option<CalibrationWindow>,
    /// Refuse all flights if one of them cannot be used, instead of skipping and naming it
    #[arg(long)]
    strict: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let model = load::model(&arguments.model)?;
    let [given, held_files] = [Places::find(&arguments.flights)?, Places::find(&arguments.hold_out)?];
    load::refuse_repeats(&given.files, &held_files.files)?;
    let batch = load::Batch::read(&given.files, arguments.strict, |flight| {
        Replay::calibrated_or_not(flight, &model, arguments.calibrate).map(|_| ())
    })?;
    let held = load::flights(&held_files.files)?;
    let warnings = |files: &[PathBuf], flights: &[load::Read]| -> Vec<String> {
        let pairs = files.iter().zip(flights);
        pairs
            .flat_map(|(file, (_, notes))| notes.iter().map(|note| format!("{}: {note}", file.display())))
            .collect()
    };
    let warnings = [warnings(&batch.files, &batch.flights), warnings(&held_files.files, &held)].concat();
    let learned = load::replays_to_diagnose(&batch.files, &batch.flights, &model, arguments.calibrate)?;
    let held = load::replays_to_diagnose(&held_files.files, &held, &model, arguments.calibrate)?;
    let mut counter = Counter::new("diagnosing", "fits");
    let mut diagnosis = diagnose(&learned, &held, &mut || counter.step());
    drop(counter);
    diagnosis.model.clone_from(&arguments.model);
    diagnosis.warnings.splice(0..0, warnings);
    given.write_notes();
    held_files.write_notes();
    batch.write_skipped();
    if arguments.json {
        let mut json = serde_json::to_string_pretty(&diagnosis)?;
        json.push('\n');
        terminal::put(&json)
    } else {
        terminal::put(&text(&diagnosis, terminal::has_colour()))
    }
}
