//! `pylon diagnose`.

use std::sync::Mutex;

use clap::Args;
use pylon::batch;
use pylon::contained::{Panicked, contained};
use pylon::diagnose::{diagnose, text};
use pylon::results::{DiagnoseResult, FailedDiagnosis};

use super::failure::Failure;
use super::progress::Counter;
use super::study::StudyArguments;
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
    #[command(flatten)]
    study: StudyArguments,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let study = &arguments.study;
    let model = load::model(&study.model)?;
    let flights = study.find()?.read(&model, study)?;
    let [learned, held] = flights.replays(&model)?;
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
    // A panic in the joint diagnosis must not lose the diagnoses of single flights.
    let together = match together {
        Err(why) if one_by_one.is_none() => return Err(Failure::input(defect(&why))),
        Err(why) => Err(defect(&why)),
        // Nothing tested is no good fit.
        Ok(diagnosis) if let Some(why) = diagnosis.untestable() => {
            let why = format!("the model could not be tested: {why}");
            if let ([flight], None) = (learned.as_slice(), &one_by_one) {
                return Err(Failure::input(format!("{}: {why}", flight.file)));
            }
            Err(why)
        }
        Ok(mut diagnosis) => {
            diagnosis.model.clone_from(&study.model);
            diagnosis.warnings.splice(0..0, flights.warnings());
            Ok(diagnosis)
        }
    };
    flights.write_left_out();
    if arguments.json {
        let (together, failed) =
            together.map_or_else(|why| (None, Some(FailedDiagnosis::new(why))), |found| (Some(found), None));
        terminal::put_json(&DiagnoseResult { together, failed, one_by_one })
    } else {
        let together = together
            .map_or_else(|why| format!("{why}\n"), |diagnosis| text(&diagnosis, terminal::has_colour()));
        terminal::put_coloured(&(together + &one_by_one.as_ref().map_or_else(String::new, batch::text)))
    }
}

fn defect(why: &Panicked) -> String {
    format!("the flights could not be diagnosed together because of a bug in pylon; please report it: {why}")
}
