//! `pylon diagnose`.

use std::path::PathBuf;
use std::sync::Mutex;

use clap::Args;
use pylon::batch;
use pylon::contained::contained;
use pylon::diagnose::{diagnose, text};
use pylon::flight::Flight;
use pylon::replay::{CalibrationWindow, Replay};
use pylon::results::DiagnoseResult;

use super::failure::Failure;
use super::places::Places;
use super::progress::Counter;
use super::{load, terminal};

const EXAMPLES: &str = "\
Examples:
  pylon diagnose flight.csv
      which physical effect the default model lacks on this flight
  pylon diagnose monday.csv tuesday.csv --hold-out friday.csv --model ours.toml
      learn from two flights, evaluate on a third
  pylon diagnose logs/
      every log of a folder, together and one by one, by vehicle, naming outliers; logs that cannot be used are skipped
      and named
  pylon diagnose logger.igc --calibrate 60..180
      a flight without a launch column: calibrate on 60 s to 180 s
  pylon diagnose flight.csv --json | jq .sensors.baro.missing
      for other programs";

/// Find the physical effect that a model lacks, or report that the flights can't show it
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Flights to learn from: flight CSVs, logs that `pylon import` reads, or folders of them
    #[arg(value_name = "FLIGHT", required = true)]
    flights: Vec<PathBuf>,
    /// The model: a TOML file, `default` or `paper`
    #[arg(long, value_name = "MODEL", default_value = "default")]
    model: String,
    /// Evaluate on this flight instead of on held-out manoeuvres (may be repeated)
    #[arg(long, value_name = "FLIGHT")]
    hold_out: Vec<PathBuf>,
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
    let [given, held_files] = [Places::find(&arguments.flights)?, Places::find(&arguments.hold_out)?];
    load::refuse_repeats(&given.files, &held_files.files)?;
    let is_usable = |flight: &Flight| {
        let replay = Replay::calibrated_or_not(flight, &model, arguments.calibrate);
        replay.map(|_| ()).map_err(|error| error.to_string())
    };
    let [batch, held_out] =
        [&given.files, &held_files.files].map(|files| load::Batch::read(files, arguments.strict, is_usable));
    let (batch, held_out) = (batch?, held_out?);
    let warnings = |files: &[PathBuf], flights: &[load::Read]| -> Vec<String> {
        let pairs = files.iter().zip(flights);
        pairs
            .flat_map(|(file, (_, notes))| notes.iter().map(|note| format!("{}: {note}", file.display())))
            .collect()
    };
    let warnings =
        [warnings(&batch.files, &batch.flights), warnings(&held_out.files, &held_out.flights)].concat();
    let learned = load::replays_to_diagnose(&batch.files, &batch.flights, &model, arguments.calibrate)?;
    let held = load::replays_to_diagnose(&held_out.files, &held_out.flights, &model, arguments.calibrate)?;
    let mut counter = Counter::new("diagnosing", "fits");
    let together = contained(|| diagnose(&learned, &held, &mut || counter.step()));
    drop(counter);
    let one_by_one = (learned.len() > 1).then(|| {
        let counter = Mutex::new(Counter::new("diagnosing one by one", "flights"));
        batch::batch(&learned, together.as_ref().ok(), &|| {
            if let Ok(mut counter) = counter.lock() {
                counter.step();
            }
        })
    });
    // What one flight breaks is not to cost the others what each says alone.
    let together = match together {
        Err(why) if one_by_one.is_none() => return Err(Failure::input(defect(&why))),
        Err(why) => Err(defect(&why)),
        Ok(mut diagnosis) => {
            diagnosis.model.clone_from(&arguments.model);
            diagnosis.warnings.splice(0..0, warnings);
            Ok(diagnosis)
        }
    };
    given.write_notes();
    held_files.write_notes();
    batch.write_skipped();
    held_out.write_skipped();
    if arguments.json {
        let (together, failed) = together.map_or_else(|why| (None, Some(why)), |found| (Some(found), None));
        terminal::put_json(&DiagnoseResult { together, failed, one_by_one })
    } else {
        let together = together
            .map_or_else(|why| format!("{why}\n"), |diagnosis| text(&diagnosis, terminal::has_colour()));
        terminal::put_coloured(&(together + &one_by_one.as_ref().map_or_else(String::new, batch::text)))
    }
}

fn defect(why: &str) -> String {
    format!("the flights could not be diagnosed together because of a bug in pylon; please report it: {why}")
}
